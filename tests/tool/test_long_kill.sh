#!/bin/bash
# 200 kills at random moments.
KILLS=200 SEED=2 exec bash "$(dirname "$0")/test_kill.sh"
