#!/bin/bash
# millpost frame and film as a user runs them: good input, bad input, an interrupted film.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh

picture() { # width,height of a file
  ffprobe -v error -show_entries stream=width,height -of csv=p=0 "$1"
}

run=$work/run.h5 plain=$work/plain.h5 still=$work/still.h5
small=(geometries/simoloyer-2l.cfg duration=0.01 balls.count=300 record.frames=1000 --quiet)
"$bin/mill" run "${small[@]}" record.collisions=true -o "$run" >"$work/out" || exit 2
"$bin/mill" run "${small[@]}" record.collisions=false -o "$plain" >"$work/out" || exit 2
"$bin/mill" run "${small[@]}" record.frames=0 -o "$still" >"$work/out" || exit 2

# ---------------------------------------------------------------- pictures
for command in frame film; do
  [ $command = frame ] && ending=.png || ending=.mp4
  expect 0 "" "$command --help" "$post" $command --help
  expect 2 "expected RUN" "$command without a run" "$post" $command
  expect 2 "unknown option '--fly'" "$command --fly" "$post" $command "$run" --fly
  expect 2 "unexpected argument" "$command with two runs" "$post" $command "$run" "$run"
  expect 2 "is not WIDTHxHEIGHT" "$command --size" "$post" $command "$run" --size 5
  expect 2 "expected one of: axial side three-quarter" "$command --camera" "$post" $command "$run" --camera upside
  expect 2 "is not LOW:HIGH" "$command --scale" "$post" $command "$run" --scale 3:1
  expect 2 "1 to 4" "$command --smooth" "$post" $command "$run" --smooth 9 -o "$work/d$ending"
  expect 2 "is not a number" "$command --turn" "$post" $command "$run" --turn nan
  expect 2 "unknown thing" "$command --hide" "$post" $command "$run" --hide drum,moon
  expect 2 "no ball 300" "$command --trail" "$post" $command "$run" --trail 300
  expect 2 "no collision table" "$command --marks" "$post" $command "$plain" --marks 0.001
  expect 2 "no frames" "$command of a run without frames" "$post" $command "$still"
  expect 2 "" "$command of no file" "$post" $command "$work/none.h5"
  expect 2 "" "$command of a foreign file" "$post" $command README.md
  expect 2 "no collision table" "$command --colour class" "$post" $command "$plain" --colour class
  expect 1 "cannot be written" "$command into nowhere" "$post" $command "$run" -o /nowhere/x$ending
  expect 2 "must end in $ending" "$command to another format" "$post" $command "$run" -o "$work/x.avi"
done
mkfifo "$work/pipe.mp4"
expect 2 "expected a regular file" "a film into a pipe" "$post" film "$run" -o "$work/pipe.mp4"
is "which stays" 0 "$([ -p "$work/pipe.mp4" ]; echo $?)"
expect 2 "the run has frames from 0 to 0.01" "--at beyond the end" "$post" frame "$run" --at 0.5
expect 2 "0.0085 to 0.0105 s: the run has frames" "--triple beyond the end" \
  "$post" frame "$run" --at 0.0085 --triple 0.001
for what in class species; do
  expect 2 "cannot be seen" "three moments by $what" \
    "$post" frame "$run" --triple 0.001 --colour $what -o "$work/x.png"
done
triple=(--triple 0.001 --size 320x200 --quiet)
expect 0 "" "the last three moments" "$post" frame "$run" "${triple[@]}" -o "$work/three.png"
"$post" frame "$run" "${triple[@]}" --at 0.008 -o "$work/late.png"
is "are those" 0 "$(cmp -s "$work/three.png" "$work/late.png"; echo $?)"
expect 0 "drawn by" "a picture" "$post" frame "$run" --at 0.0053 --size 400x300 -o "$work/a.png"
is "its size" 400,300 "$(picture "$work/a.png")"
"$post" frame "$run" --at 0.0053 --size 400x300 --quiet -o "$work/b.png"
is "the same again" 0 "$(cmp -s "$work/a.png" "$work/b.png"; echo $?)"
for look in "--camera axial" "--colour class" "--color spin --map ember" "--colour species --dark" \
  "--speeds 1:2 --balls 50" "--trail 1,2 --trail-time 0.005" "--marks 0.002" "--triple 0.001" \
  "--parallel --turn 45 --tilt 30 --zoom 1.5" "--hide rotor,drum,legend" "--scale 0:3" "--smooth 3"; do
  # shellcheck disable=SC2086
  expect 0 "" "a picture: $look" "$post" frame "$run" --at 0.005 --size 320x200 --quiet $look \
    -o "$work/c.png"
  is "differs: $look" 1 "$(cmp -s "$work/a.png" "$work/c.png"; echo $?)"
done

"$bin/mill" run "${small[@]}" balls.count=0 -o "$work/nobody.h5" >"$work/out" || exit 2
for command in frame film view; do
  expect 2 "the run has no balls" "$command of a run without balls" "$post" $command "$work/nobody.h5"
done
is "which is not blamed on its frames" 1 "$(grep -q record.frames "$work/err"; echo $?)"

# ---------------------------------------------------------------- films
for quality in 0 52 1.5; do
  expect 2 "whole number from 1 to 51" "--quality $quality" "$post" film "$run" --quality $quality
done
"$post" film "$run" --size 320x180 --slow 10 --workers 100 --quiet -o "$work/few.mp4" &
pid=$! most=0
while kill -0 $pid 2>/dev/null; do
  children=$(pgrep -c -P $pid)
  [ "$children" -gt $most ] && most=$children
  sleep 0.02
done
wait $pid
is "a film of three frames" 0 $?
is "takes three processes and that of ffmpeg, not a hundred" yes "$([ "$most" -le 4 ] && echo yes)"
expect 0 "frames/s" "a film" "$post" film "$run" --size 320x180 --fps 20 --slow 50 -o "$work/a.mp4"
is "its size, rate and frames" "h264,320,180,20/1,11" "$(ffprobe -v error -count_frames \
  -show_entries stream=codec_name,width,height,r_frame_rate,nb_read_frames -of csv=p=0 "$work/a.mp4")"
expect 0 "" "every stored frame once" "$post" film "$plain" --size 64x64 --quiet -o "$work/b.mp4"
is "as many frames" 11 "$(ffprobe -v error -count_frames -show_entries stream=nb_read_frames \
  -of csv=p=0 "$work/b.mp4")"
expect 0 "" "an orbit with trails" "$post" film "$run" --size 160x90 --orbit 90 --trail 3 --quiet \
  --marks 0.001 --colour class -o "$work/c.mp4"
expect 2 "the run has frames" "--from after --to" "$post" film "$run" --from 0.009 --to 0.001
(cd "$work" && "$post" film run.h5 --size 64x64 --quiet)
is "named after the run" 0 "$([ -s "$work/run.mp4" ]; echo $?)"

for signal in INT TERM HUP; do
  "$post" film "$run" --size 1280x720 --slow 50000 -o "$work/long.mp4" 2>"$work/err" &
  pid=$!
  for _ in $(seq 100); do compgen -G "$work/long.mp4.*.part" >/dev/null && break; sleep 0.1; done
  kill -$signal $pid
  wait $pid
  is "a film interrupted by SIG$signal" 1 $?
  is "leaves nothing" "" "$(find "$work" -name 'long*')"
done

# ---------------------------------------------------------------- damaged files
# A run file cut short, one with a stretch of noise in it, one that is no run: an error that names the
# file, no crash, and nothing written.
size=$(stat -c %s "$run")
cp "$run" "$work/noise.h5"
for part in 10 30 50 70 90; do
  dd if=/dev/urandom of="$work/noise.h5" bs=1 seek=$((size * part / 100)) count=2000 conv=notrunc status=none
done
head -c $((size / 2)) "$run" >"$work/short.h5"
: >"$work/empty.h5"
for command in "frame --size 64x64 -o $work/x.png" "film --size 64x64 -o $work/x.mp4" \
  "view -o $work/x.html" "export --to vtk -o $work/x.pvd" "export --to csv -o $work/x.csv"; do
  for file in short empty; do
    # shellcheck disable=SC2086
    expect 2 "$file.h5" "${command%% *} of a damaged file ($file)" \
      "$post" ${command%% *} "$work/$file.h5" ${command#* }
  done
  is "which leaves nothing" "" "$(find "$work" -name 'x[.-]*')"
  # shellcheck disable=SC2086
  "$post" ${command%% *} "$work/noise.h5" ${command#* } >"$work/out" 2>"$work/err"
  is "${command%% *} of a file with noise ends in order" yes "$([ $? -le 2 ] && echo yes)"
  rm -f "$work"/x[.-]*
done

# ---------------------------------------------------------------- diagrams
# A parent that ignores how its children end leaves that to us.
ignoring=(/usr/bin/python3 -c 'import os, signal, sys
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
os.execvp(sys.argv[1], sys.argv[1:])')
expect 0 "" "a diagram under a parent that ignores children" "${ignoring[@]}" "$post" hist "$run" -o "$work/child.png"
expect 0 "" "and a film" "${ignoring[@]}" "$post" film "$run" --size 64x64 --quiet -o "$work/child.mp4"
# Nothing is left of a diagram that is ended while it is drawn.
mkdir "$work/slow"
printf '#!/bin/sh\nexec sleep 5\n' >"$work/slow/gnuplot"
chmod +x "$work/slow/gnuplot"
PATH=$work/slow:$PATH timeout 1 "$post" hist "$run" -o "$work/ended.png" >"$work/out" 2>"$work/err"
is "a diagram that is ended" 124 $?
is "leaves nothing" 0 "$(find "$work" -name 'ended*' | wc -l)"
finish
