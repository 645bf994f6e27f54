#!/bin/bash
# The demo's folder is seen from where its user stands. In place of the programs stand two that make
# what -o names.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh
demo=$PWD/scripts/demo
cd "$work" || exit 2
mkdir programs
for name in mill millpost; do
  printf '#!/bin/sh\nwhile [ $# -gt 1 ]; do [ "$1" != -o ] || echo made >"$2"; shift; done\n' >programs/$name
  chmod +x programs/$name
done
export BUILD=$work/programs
for folder in "out here" "$work/elsewhere"; do
  expect 0 "" "a demo in '$folder'" "$demo" "$folder"
  check "is there" test -s "$folder/demo.mp4" -a -s "$folder/demo.h5"
done
finish
