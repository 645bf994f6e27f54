#!/bin/bash
# mill killed by SIGKILL at random moments: its run file opens in h5dump and h5py at once, and is
# resumed to the same end as if nothing had happened. KILLS (20) of them.
set -u
cd "$(dirname "$0")/../.." || exit 2
mill=$PWD/${BUILD:-build}/mill
case ${BUILD:-} in /*) mill=$BUILD/mill ;; esac
KILLS=${KILLS:-20}
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
RANDOM=${SEED:-1}

scene=(geometries/simoloyer-2l.cfg duration=0.04 balls.count=1500 record.collisions=true
  record.checkpoint=0.01)

fail() {
  echo "not ok - $*"
  exit 1
}

same() {
  h5diff --exclude-path /eventmill/sessions --exclude-path /eventmill/checkpoint/engine "$1" "$2"
}

opens() {
  h5dump -A "$1" >/dev/null 2>&1 || fail "h5dump after kill $kills"
  /usr/bin/python3 - "$1" <<'END' || fail "h5py after kill $kills"
import sys, h5py
with h5py.File(sys.argv[1], "r") as f:
    f["particles/balls/position/value"][()]
    f["eventmill/collisions/vn"][()]
    assert f["eventmill"].attrs["end"] in (b"running", b"done")
END
}

# How long a whole run takes here: kills shall strike in all its parts.
start=$(date +%s%N)
"$mill" run "${scene[@]}" -o "$work/whole.h5" -q || fail "the reference run"
whole=$((($(date +%s%N) - start) / 1000000)) # ms

kills=0 rounds=0 resumed=0
while [ $kills -lt "$KILLS" ]; do
  rm -f "$work"/cut.h5*
  status=137
  while [ $status -eq 137 ]; do
    [ -e "$work/cut.h5" ] && resumed=$((resumed + 1))
    # After enough kills the run may come to its end.
    if [ $kills -lt "$KILLS" ]; then
      wait_ms=$((RANDOM % (whole * 6 / 5) + 5))
      timeout -s KILL "$((wait_ms / 1000)).$(printf '%03d' $((wait_ms % 1000)))" \
        "$mill" run "${scene[@]}" -o "$work/cut.h5" -q --resume 2>"$work/messages"
    else
      "$mill" run "${scene[@]}" -o "$work/cut.h5" -q --resume 2>"$work/messages"
    fi
    status=$?
    [ $status -eq 137 ] && kills=$((kills + 1))
    [ -e "$work/cut.h5" ] && opens "$work/cut.h5"
  done 2>/dev/null # the shell's own word on each kill
  [ $status -eq 0 ] || fail "exit code $status: $(cat "$work/messages")"
  same "$work/whole.h5" "$work/cut.h5" || fail "round $rounds: not the uninterrupted run"
  [ -e "$work/cut.h5.next" ] && fail "the second copy was left behind"
  [ -e "$work/cut.h5.lock" ] && fail "the lock was left behind"
  rounds=$((rounds + 1))
done
[ $resumed -gt 0 ] || fail "no kill left a file to resume"
echo "ok 1 - $kills kills, $resumed resumed, $rounds runs ended as the uninterrupted one"
