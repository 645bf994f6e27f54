#!/bin/sh
# Instructions per collision, stage by stage, of the mill and of gases, counted by callgrind: the same
# on every run.
set -eu
cd "$(dirname "$0")/../.."
for case in mill 'gas 1e3 0.1' 'gas 1e3 0.3' 'gas 1e3 0.5' 'gas 4e3 0.3 gravity' 'gas 4e3 0.3 spin'; do
  printf '\n'
  tests/bench/profile "$case" 20000
done
