#!/bin/bash
# Every command on files that are damaged, and on disks that take nothing: an error that says so and
# leaves nothing behind, or exactly what comes of the good file; no crash, no hang. FLIPS (6) files
# with one bit turned.
set -u
cd "$(dirname "$0")/../.." || exit 2
. tests/support/tap.sh
FLIPS=${FLIPS:-6}
RANDOM=${SEED:-1}
trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
scene=$PWD/geometries/simoloyer-2l.cfg
small=("$scene" balls.count=60 record.frames=200.0 record.observables=400.0
  record.histograms=200.0 record.collisions=true)

mkdir -p "$work/good" "$work/bad" "$work/disk"
"$mill" run "${small[@]}" duration=0.02 -o "$work/good/run.h5" -q || exit 1
"$mill" run "${small[@]}" duration=0.01 -o "$work/half.h5" -q || exit 1
for v in 1 2 3 4 6 8 12 16 24 32 48; do echo "$v 0.$((99 - v / 2))"; done >"$work/good/pairs.txt"

# What reads a run. Those that draw take their time, and get fewer damaged files.
tables=("info run.h5" "hist run.h5" "map run.h5 --cells rings" "power run.h5"
  "steady run.h5" "compare run.h5 run.h5" "scale run.h5 run.h5"
  "hist run.h5 --of vt -o x.png")
files=("export run.h5 --to xdmf -o x.xdmf" "export run.h5 --to vtk -o x.pvd"
  "export run.h5 --to lammps -o x.lammps" "export run.h5 --to csv --of collisions -o x.csv"
  "export run.h5 --to pov -o x.pov" "export run.h5 --to stl -o x.stl")
drawn=("view run.h5 -o x.html" "frame run.h5 --at 0.01 --size 64x64 -o x.png"
  "film run.h5 --size 64x64 -o x.mp4")

# look FOLDER COMMAND: runs it there; exit code in $status, what it wrote in FOLDER.out and x.*
look() {
  rm -rf "$1"/x*
  # shellcheck disable=SC2086
  (cd "$1" && timeout 60 "$post" $2 >"$1.out" 2>"$work/err" </dev/null)
  status=$?
}

# The same command on the good file and on the bad one; $verdict.
compare() {
  verdict=ok
  look "$work/bad" "$1"
  case $status in
    0 | 3)
      diff -r -x run.h5 "$work/good.$2" "$work/bad" >>"$work/err" &&
        cmp "$work/good.$2.out" "$work/bad.out" >>"$work/err" || verdict="other numbers without a word"
      ;;
    1 | 2)
      grep -q "error" "$work/err" || verdict="exit code $status without an error"
      [ -z "$(find "$work/bad" -name 'x*')" ] || verdict="something was left behind"
      ;;
    *) verdict="exit code $status" ;;
  esac
}

# Keeps what comes of the good file, to compare with.
remember() {
  look "$work/good" "$1"
  [ $status -eq 0 ] || [ $status -eq 3 ] || report "not ok" "$1 of the good file"
  cp -r "$work/good" "$work/good.$2" && mv "$work/good.out" "$work/good.$2.out"
  rm -f "$work/good.$2/run.h5" "$work/good.$2/pairs.txt"
}

flip() { # FILE SIZE: turns one bit
  local at=$(((RANDOM * 32768 + RANDOM) % $2)) byte
  byte=$(od -An -tu1 -j $at -N 1 "$1")
  # shellcheck disable=SC2059
  printf "\\$(printf %03o $((byte ^ (1 << (RANDOM % 8)))))" |
    dd of="$1" bs=1 seek=$at conv=notrunc status=none
}

damage() { # NUMBER: makes bad/run.h5; $how
  local bad=$work/bad/run.h5 size cuts
  size=$(stat -c %s "$work/good/run.h5")
  cuts=("$((size - 1))" "$((size / 2))" 5000 100 0)
  cp "$work/good/run.h5" "$bad"
  if [ "$1" -lt ${#cuts[@]} ]; then
    how="cut to ${cuts[$1]} bytes"
    truncate -s "${cuts[$1]}" "$bad"
  else
    how="one bit turned"
    flip "$bad" "$size"
  fi
}

# attack STEP COMMAND...: every STEP-th damage.
attack() {
  local step=$1 command k n=0
  shift
  for command in "$@"; do
    remember "$command" $n
    local worst=ok
    for ((k = 0; k < 5 + FLIPS; k += step)); do
      damage $k
      compare "$command" $n
      [ "$verdict" = ok ] || { worst="$how: $verdict" && break; }
    done
    is "$command" ok "$worst"
    n=$((n + 1))
  done
  rm -rf "$work"/good.*
}
attack 1 "${tables[@]}"
attack 2 "${files[@]}"
attack 4 "${drawn[@]}"

# A run long enough to be held against the laws of a gas, whatever the verdict.
mv "$work/good/run.h5" "$work/whole.h5"
"$mill" run geometries/ideal-gas.cfg balls.count=500 duration=2.0 -o "$work/good/run.h5" -q
attack 1 "verify run.h5"
mv "$work/whole.h5" "$work/good/run.h5"

# ---------------------------------------------------------------- going on from a damaged run
same() {
  h5diff --exclude-path /eventmill/sessions --exclude-path /eventmill/checkpoint/engine "$@"
}
worst=ok
size=$(stat -c %s "$work/half.h5")
for ((k = 0; k < FLIPS; k++)); do
  cp "$work/half.h5" "$work/bad/run.h5"
  flip "$work/bad/run.h5" "$size"
  (cd "$work/bad" && timeout 60 "$mill" run "${small[@]}" duration=0.02 -o run.h5 --resume -q 2>"$work/err")
  status=$?
  case $status in
    0) same "$work/good/run.h5" "$work/bad/run.h5" >>"$work/err" 2>&1 || worst="another run" ;;
    1 | 2) grep -q error "$work/err" || worst="no error" ;;
    *) worst="exit code $status" ;;
  esac
done
is "resuming a file with one bit turned" ok "$worst"

# What resuming has no need of shall be whole as well: mass, and the first frame.
for set in particles/balls/mass particles/balls/position/value; do
  cp "$work/half.h5" "$work/bad/run.h5"
  at=$(/usr/bin/python3 -c "import sys, h5py
print(h5py.File(sys.argv[1])[sys.argv[2]].id.get_chunk_info(0).byte_offset)" "$work/half.h5" $set)
  printf '\252' | dd of="$work/bad/run.h5" bs=1 seek=$((at + 3)) conv=notrunc status=none
  expect 2 "$set: damaged" "resuming a file with damaged $set" \
    "$mill" run "${small[@]}" duration=0.02 -o "$work/bad/run.h5" --resume -q
done

# spoil PATH INDEX NUMBER: half.h5 with one number of its checkpoint replaced, as bad/run.h5.
spoil() {
  cp "$work/half.h5" "$work/bad/run.h5"
  /usr/bin/python3 - "$work/bad/run.h5" "$@" <<'END'
import sys, h5py
file, path, at, number = sys.argv[1:]
with h5py.File(file, "r+") as f:
    here = f["eventmill/checkpoint"]
    if path in here.attrs:
        here.attrs.modify(path, float(number))
    else:
        here[path][tuple(map(int, at.split(",")))] = float(number)
END
}
for one in "velocity 7,1 nan" "velocity 7,1 1e300" "position 7,0 inf" "time 7 nan" "time 7 1e300" \
  "blade_angle 0 inf" "last 7 4000000000" "clock 0 1e300" "epoch 0 1e15"; do
  # shellcheck disable=SC2086
  spoil $one
  expect 2 "error" "resuming a checkpoint with $one" timeout 60 \
    "$mill" run "${small[@]}" duration=0.02 -o "$work/bad/run.h5" --resume -q
done

# ---------------------------------------------------------------- scenes
mkdir "$work/scenes"
worst=ok
length=$(stat -c %s "$scene")
for ((k = 0; k < 5 * FLIPS; k++)); do
  cp "$scene" "$work/scenes/bad.cfg"
  if [ $((k % 2)) -eq 0 ]; then
    truncate -s $((RANDOM % length)) "$work/scenes/bad.cfg"
  else
    flip "$work/scenes/bad.cfg" "$length"
  fi
  timeout 20 "$mill" check "$work/scenes/bad.cfg" >"$work/out" 2>"$work/err"
  status=$?
  case $status in
    0) ;;
    2) grep -q "error" "$work/err" || worst="no error" ;;
    *) worst="check: exit code $status" ;;
  esac
  [ $status -eq 0 ] && continue
  for command in run cost; do
    (cd "$work/scenes" && timeout 20 "$mill" $command bad.cfg >"$work/out" 2>"$work/err")
    [ $? -eq 2 ] || worst="$command of a scene that check refuses"
  done
  [ "$(ls "$work/scenes")" = bad.cfg ] || worst="a file of a refused scene"
done
is "scenes cut short or with one bit turned" ok "$worst"
: >"$work/scenes/bad.cfg"
for command in check run cost; do
  expect 2 "error" "$command of an empty scene" "$mill" $command "$work/scenes/bad.cfg"
  expect 2 "error" "$command of a folder" "$mill" $command "$work/scenes"
done

# ---------------------------------------------------------------- other inputs
for command in fit track; do
  : >"$work/empty"
  head -c 3000 /dev/urandom >"$work/noise"
  for input in empty noise; do
    (cd "$work" && timeout 60 "$post" $command $input >"$work/out" 2>"$work/err")
    status=$?
    verdict=ok
    case $status in 1 | 2) grep -q error "$work/err" || verdict="no error" ;; *) verdict="exit code $status" ;; esac
    is "$command of a file with $input" ok "$verdict"
  done
done

# ---------------------------------------------------------------- disks
cd "$work/good" || exit 2
for command in "${tables[@]:0:7}" "fit pairs.txt"; do
  # shellcheck disable=SC2086
  (timeout 60 "$post" $command >/dev/full 2>"$work/err")
  is "a full disk: $command" 1 $?
done
if mount -t tmpfs -o size=4k tmpfs "$work/disk" 2>/dev/null; then
  head -c 4096 /dev/zero >"$work/disk/other"
  for kind in full read-only; do
    [ $kind = read-only ] && mount -o remount,ro "$work/disk"
    for command in "${files[@]}" "${drawn[@]}" "hist run.h5 -o x.png" "fit pairs.txt -o x.png"; do
      # shellcheck disable=SC2086
      (timeout 60 "$post" ${command/-o x/-o $work/disk/x} >"$work/out" 2>"$work/err")
      status=$?
      verdict=ok
      [ $status -eq 1 ] || [ $status -eq 2 ] || verdict="exit code $status"
      grep -q "error" "$work/err" || verdict="$verdict, no error"
      [ "$(ls "$work/disk")" = other ] || verdict="$verdict, something left"
      [ $kind = full ] && rm -rf "$work"/disk/x*
      is "a $kind disk: $command" ok "$verdict"
    done
  done
  umount "$work/disk"
  # A disk that fills up after some frames.
  mount -t tmpfs -o size=16k tmpfs "$work/disk"
  for command in "${files[1]}" "${files[4]}"; do
    # shellcheck disable=SC2086
    expect 1 "No space" "a disk that fills up: $command" "$post" ${command/-o x/-o $work/disk/x}
    is "leaves nothing behind" "" "$(ls "$work/disk")"
  done
else
  skip "full and read-only disks" "no right to mount"
fi
cd / || exit 2
finish
