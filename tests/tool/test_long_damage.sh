#!/bin/bash
# 200 files with one bit turned, for each command.
FLIPS=200 SEED=2 exec bash "$(dirname "$0")/test_damage.sh"
