#!/bin/bash
# Run files follow the rules of H5MD 1.1, in every scene, and open in h5dump.
set -u
cd "$(dirname "$0")/../.." || exit 2
case ${BUILD:-build} in /*) mill=$BUILD/mill ;; *) mill=$PWD/${BUILD:-build}/mill ;; esac
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
number=0 failed=0

try() { # TEXT, then a scene with overrides
  local text=$1 verdict=ok
  shift
  number=$((number + 1))
  "$mill" run "$@" -o "$work/run.h5" --force -q &&
    /usr/bin/python3 tests/tool/h5md.py "$work/run.h5" &&
    h5dump "$work/run.h5" >/dev/null || verdict="not ok"
  [ "$verdict" = ok ] || failed=1
  echo "$verdict $number - $text"
}

try "mill with table" geometries/simoloyer-2l.cfg duration=0.02 balls.count=300 record.collisions=true
try "two rotors" geometries/two-rotors.cfg duration=0.02
try "gas" geometries/ideal-gas.cfg duration=0.02 balls.count=300
try "gas under gravity" geometries/ideal-gas-gravity.cfg duration=0.02 balls.count=300
try "one ball" geometries/bouncing-ball.cfg duration=0.5
try "cradle" geometries/newtons-cradle.cfg duration=0.1
try "no frames" geometries/ideal-gas.cfg duration=0.01 balls.count=10 record.frames=0.0
try "no observables, no compression" geometries/ideal-gas.cfg duration=0.01 balls.count=10 \
  record.observables=0.0 record.compression=0
echo "1..$number"
exit $failed
