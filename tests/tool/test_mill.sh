#!/bin/bash
# mill as a user runs it: good input, bad input, signals, full disks.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh
mounted=
trap '[ -n "$mounted" ] && umount "$work/small"; rm -rf "$work"' EXIT
gas=geometries/ideal-gas.cfg
small=("$gas" duration=0.002 balls.count=200)
declare -A tell=([mill]=check [millpost]=hist) # a command of each program

# ---------------------------------------------------------------- usage
expect 2 "Usage" "no command" "$mill"
expect 2 "unknown command 'fly', expected one of: run check cost" "unknown command" "$mill" fly
expect 2 "unknown command 'fly', expected one of: info hist " "millpost: unknown command" "$post" fly
expect 2 "no scene given" "no scene" "$mill" run
expect 2 "unknown option '--fast'" "unknown option" "$mill" run $gas --fast
expect 2 "unknown option '-x'" "unknown letter among others" "$mill" run --json -xq $gas
expect 2 "unknown option '-o'" "an option of another command" "$mill" check $gas -o x
expect 2 "unknown option '--output'" "the same in full" "$mill" check $gas --output x
for letter in r f u J; do
  expect 2 "unknown option '-$letter'" "no letter -$letter" "$mill" run $gas -$letter
done
expect 2 "unknown option '--joined'" "an option of mill check" "$mill" run $gas --joined
expect 2 "no value belongs to '--force=3'" "a value too many" "$mill" run $gas --force=3
expect 2 "unknown option '-x'" "mill cost: unknown letter among others" "$mill" cost $gas -xq
expect 2 "unknown option '-x'" "millpost: unknown letter among others" "$post" info -xq run.h5
expect 2 "unknown option '-o'" "millpost: an option of another command" "$post" info run.h5 -o x
expect 2 "unknown option '--fast'" "millpost: unknown option" "$post" info run.h5 --fast
expect 2 "unknown option '-j'" "millpost: a picture is no JSON" "$post" frame run.h5 -j
expect 2 "--until-precision: error: 'foo'" "no precision" "$mill" run $gas -o none --until-precision foo
expect 2 "missing after '-o'" "option without its value" "$mill" run $gas -o
expect 2 "expected KEY=VALUE, found 'x'" "a second scene" "$mill" run $gas x
expect 2 "nothere.cfg" "a scene that is not there" "$mill" run nothere.cfg
expect 2 "error" "unknown entry" "$mill" run $gas balls.colour=3 -o "$work/a.h5"
expect 2 "error" "entry of the wrong type" "$mill" run $gas duration=long -o "$work/a.h5"
[ ! -e "$work/a.h5" ] || report "not ok" "bad input leaves a file"
for command in run check; do
  check "$command --help has examples" bash -c "'$mill' $command --help | grep -q '^  mill $command geometries/'"
done
nowhere() { "$@" >/dev/full; }
for program in "$mill" "$post"; do
  name=${program##*/}
  check "$name --version names libraries" bash -c "'$program' --version | grep -q 'HDF5.*GSL.*libconfig'"
  for asked in "--help" "--version" "${tell[$name]} --help"; do
    # shellcheck disable=SC2086 # several words
    expect 1 "cannot be written" "$name $asked to a full disk" nowhere "$program" $asked
  done
done

# ---------------------------------------------------------------- check
for scene in geometries/*.cfg; do
  check "check $scene prints itself" bash -c "
    '$mill' check $scene >'$work/one.cfg' && '$mill' check '$work/one.cfg' >'$work/two.cfg' &&
    diff '$work/one.cfg' '$work/two.cfg'"
done

# ---------------------------------------------------------------- run
expect 0 "" "run" "$mill" run "${small[@]}" -o "$work/run.h5" -q
cp "$work/run.h5" "$work/copy.h5"
expect 2 "exists already" "an existing file is not replaced" "$mill" run "${small[@]}" -o "$work/run.h5" -q
check "and is untouched" cmp "$work/run.h5" "$work/copy.h5"
expect 0 "" "resuming a finished run does nothing" "$mill" run "${small[@]}" -o "$work/run.h5" -q --resume
check "and leaves it as it is" cmp "$work/run.h5" "$work/copy.h5"
expect 2 '"seed = 1;" there, "seed = 9;" now' "resuming with another scene" "$mill" run "${small[@]}" seed=9 -o "$work/run.h5" --resume
expect 2 '"jam_after = 0; *" there, "jam_after = 3; *" now' "or with what follows from it no longer" \
  "$mill" run "${small[@]}" remedy.jam_after=3 -o "$work/run.h5" --resume
expect 0 "" "a scene that is printed and saved" bash -c "
  '$mill' check geometries/simoloyer-2l.cfg contact.rule=smooth >'$work/saved.cfg' &&
  '$mill' check '$work/saved.cfg' contact.rule=rough >'$work/one.cfg' &&
  '$mill' check geometries/simoloyer-2l.cfg contact.rule=rough >'$work/two.cfg'"
check "can be changed as the first one" cmp "$work/one.cfg" "$work/two.cfg"
expect 0 "" "the scene in a run file" bash -c "'$post' info --scene '$work/run.h5' >'$work/saved.cfg' &&
  '$mill' check '$work/saved.cfg' >'$work/one.cfg' && '$mill' check ${small[*]} >'$work/two.cfg'"
check "is that of the run" cmp "$work/one.cfg" "$work/two.cfg"
expect 0 "" "force replaces" "$mill" run "${small[@]}" seed=9 -o "$work/run.h5" -q --force
"$mill" run "${small[@]}" -o none >"$work/out" 2>/dev/null
check "its time is told as wall time" grep -q "wall time .* s$" "$work/out"
check "the default name comes from the scene" bash -c "
  cd '$work' && '$mill' run '$PWD/$gas' duration=0.001 2>said && grep -q 'writing ideal-gas.h5' said &&
  test -s ideal-gas.h5"
check "-o none writes nothing" bash -c "
  mkdir '$work/empty' && cd '$work/empty' && '$mill' run '$PWD/$gas' duration=0.001 -o none -q &&
  test -z \"\$(ls)\""

cat >"$work/strict.py" <<'END'
import json, sys
def no(word):
    raise ValueError(word)
o = json.load(sys.stdin, parse_constant=no)
keys = """collisions collisions_per_second simulated_time wall_time realtime_factor median_speed median_vn
rate_above_3 share_above_3 power energy_error collisions_by_class effects seed
tc_contacts elastic_contacts jam_contacts""".split()
assert sorted(o) == sorted(keys), sorted(o)
assert sorted(o["collisions_by_class"]) == ["ball-ball", "ball-blade", "ball-drum", "ball-end"]
assert sum(o["collisions_by_class"].values()) == o["collisions"]
assert isinstance(o["effects"], list) and o["seed"] == 1
assert o["energy_error"] < 1e-9
for word in sys.argv[1:]:
    assert o[word] is None, word
END
check "--json is strict JSON" bash -c "
  '$mill' run ${small[*]} -o none --json | /usr/bin/python3 '$work/strict.py'"
check "--json of nothing has nulls" bash -c "
  '$mill' run $gas duration=1e-9 balls.count=2 -o none --json | /usr/bin/python3 '$work/strict.py' median_vn"
expect 1 "collapse" "a collapse ends the run" "$mill" run geometries/bouncing-ball.cfg duration=7.0 \
  -o "$work/ball.h5" -q
cp "$work/err" "$work/advice"
check "of a table, only a new begin is advised" bash -c "
  ! grep -q 'resume\|balls.start' '$work/advice' && grep -q 'begin anew with a remedy' '$work/advice'"
check "and is told in the file" bash -c "h5dump -a /eventmill/end '$work/ball.h5' | grep -q collapse"
expect 1 "each within 1 s of the one before" "remedy.jam_within is taken as given" \
  "$mill" run "${small[@]}" duration=0.01 remedy.jam_within=1 remedy.collapse_after=2 -o none -q

gliding=(geometries/simoloyer-2l.cfg balls.count=100 -q)
expect 1 "begin anew with a remedy" "few balls glide" "$mill" run "${gliding[@]}" duration=3 -o "$work/glide.h5"
cp "$work/err" "$work/advice"
check "resuming is not advised" bash -c "! grep -q resume '$work/advice'"
read -ra advised <<<"$(sed -n 's/.*with one: \(.*\) -o NEW.h5/\1/p' "$work/advice")"
expect 0 "" "what is advised works" "$mill" run "${gliding[@]}" duration=0.5 remedy.elastic_below=0.001 \
  "${advised[@]:-none}" -o "$work/beyond.h5"

# ---------------------------------------------------------------- rates
expect 1 "warning: record.histograms: 20 a second are 2e+07 in all" "far too many blocks are told" \
  timeout -s INT --preserve-status 1 "$mill" run "$gas" balls.count=0 duration=1e6 record.frames=0 \
  record.observables=0 -o none -q

# ---------------------------------------------------------------- signals
long=(geometries/simoloyer-2l.cfg duration=0.06 balls.count=1000)
"$mill" run "${long[@]}" -o "$work/whole.h5" -q
for signal in INT TERM HUP; do
  rm -f "$work/cut.h5"
  "$mill" run "${long[@]}" duration=50.0 -o "$work/cut.h5" >"$work/out" 2>"$work/err" &
  pid=$!
  for _ in $(seq 100); do [ -e "$work/cut.h5" ] && break; sleep 0.05; done
  sleep 0.2
  kill -$signal $pid
  # GNU parallel and batch systems tell a program more than once.
  if [ $signal = TERM ]; then while kill -TERM $pid 2>/dev/null; do sleep 0.001; done; fi
  wait $pid
  status=$?
  verdict=ok
  [ $status -eq 1 ] && grep -q "can be resumed" "$work/err" || verdict="not ok"
  report "$verdict" "SIG$signal ends the run with exit code 1"
  check "with a valid file" bash -c "h5dump -a /eventmill/end '$work/cut.h5' | grep -q interrupted"
done

(trap '' HUP; exec "$mill" run "${long[@]}" duration=50.0 -o none -q >"$work/out" 2>"$work/said") &
pid=$!
sleep 0.5
kill -HUP $pid
sleep 0.3
kill -0 $pid
is "under nohup a closed terminal does not end it" 0 $?
kill -INT $pid
wait $pid

"$mill" run geometries/simoloyer-2l.cfg duration=1 balls.count=260000 balls.diameter=0.002 -o none -q \
  >"$work/out" 2>"$work/said" &
pid=$!
sleep 1
kill -TERM $pid
wait $pid
is "SIGTERM ends the placing of balls" 1 $?
check "and is told" grep -q "stopped while the balls were being placed" "$work/said"

# ---------------------------------------------------------------- two at a time
# Only one works on a file; the other says so.
valid() { "$post" info --json "$1" >/dev/null; }
two=("$gas" balls.count=200 duration=1e9 record.collisions=true record.frames=1.0)
"$mill" run "${two[@]}" record.checkpoint=0.05 -o "$work/two.h5" -q >/dev/null 2>"$work/first" &
pid=$!
for _ in $(seq 200); do [ -e "$work/two.h5" ] && break; sleep 0.05; done
others=()
for way in --resume --force; do
  "$mill" run "${two[@]}" record.checkpoint=0.05 -o "$work/two.h5" -q $way >/dev/null 2>"$work/other$way" &
  others+=($!)
done
wait "${others[0]}"
is "--resume of a file that is being written" 2 $?
wait "${others[1]}"
is "--force of a file that is being written" 2 $?
for way in --resume --force; do
  check "$way says why" grep -q "another process is writing this run" "$work/other$way"
done
check "the file is valid meanwhile" valid "$work/two.h5"
kill -INT $pid
wait $pid
is "the first one has its own end" 1 $?
check "and its file" bash -c "h5dump -a /eventmill/end '$work/two.h5' | grep -q interrupted"
for round in 1 2 3; do
  rm -f "$work/two.h5"
  for seed in 1 2; do
    "$mill" run "${small[@]}" seed=$seed -o "$work/two.h5" -q >/dev/null 2>"$work/seed$seed" &
    others[seed]=$!
  done
  codes=0 winner=0
  for seed in 1 2; do
    if wait "${others[seed]}"; then winner=$seed; else codes=$((codes + 1)); fi
  done
  is "of two that begin together one is refused, round $round" 1 $codes
  check "the file is the other's" bash -c "'$post' info --scene '$work/two.h5' | grep -q 'seed = $winner;'"
  "$mill" run "${small[@]}" duration=0.05 -o "$work/two.h5" -q --force >/dev/null 2>"$work/err" &
  pid=$!
  "$mill" run "${small[@]}" duration=0.05 -o "$work/two.h5" -q --resume >/dev/null 2>"$work/other"
  second=$?
  wait $pid
  first=$?
  # Whichever was first: both know the same scene, and the end is one of a whole run or a refusal.
  case $first$second in 00 | 02 | 20) verdict=0 ;; *) verdict="$first and $second" ;; esac
  is "--force and --resume together, round $round" 0 "$verdict"
  check "leave a valid file" valid "$work/two.h5"
done

# ---------------------------------------------------------------- links
mkdir "$work/far"
ln -s far/target.h5 "$work/link.h5"
expect 0 "" "a link that leads nowhere yet" "$mill" run "${small[@]}" -o "$work/link.h5" -q
check "its target is made" test -f "$work/far/target.h5" -a -L "$work/link.h5"
ln "$work/far/target.h5" "$work/kept.h5"
cp "$work/kept.h5" "$work/copy.h5"
expect 0 "" "resuming through a link" \
  "$mill" run "${small[@]}" duration=0.004 record.checkpoint=30.0 -o "$work/link.h5" -q --resume
check "the link stays" test -L "$work/link.h5"
check "its target goes on" bash -c "h5dump -a /eventmill/time '$work/far/target.h5' | grep -q 0.004"
check "another name of the old file keeps it" cmp "$work/kept.h5" "$work/copy.h5"
check "nothing is left over" test -z "$(find "$work" -name '*.h5.*')"

# ---------------------------------------------------------------- disks
expect 1 "standard output cannot be written" "a summary that nobody gets" \
  bash -c "'$mill' run ${small[*]} -o none --json -q >/dev/full"
if [ -d /proc/self/fd ]; then
  "$mill" run "${long[@]}" duration=50.0 -o "$work/mute.h5" <&- >&- 2>&- &
  pid=$!
  until [ -e "$work/mute.h5" ] || ! kill -0 $pid; do sleep 0.05; done
  taken=$(readlink /proc/$pid/fd/0 /proc/$pid/fd/1 /proc/$pid/fd/2 | sort -u)
  kill -INT $pid
  wait $pid
  is "no file takes the place of a closed stream, and its words" /dev/null "$taken"
else
  skip "no file takes the place of a closed stream" "no /proc"
fi
long_name=$(printf 'a%.0s' $(seq 200))
deep=$work/$long_name/$long_name/$long_name/$long_name/$long_name
mkdir -p "$deep"
expect 2 "the path is too long" "a path that is too long" "$mill" run "${small[@]}" -o "$deep/run.h5" -q
expect 2 "the path is too long" "frames with names that are too long" \
  "$post" export "$work/run.h5" --to vtk -o "$deep/a.pvd"
check "writes nothing" bash -c "[ -z \"\$(find '$work/$long_name' -type f)\" ]"
expect 2 "No such file or directory" "a folder that is not there" "$mill" run "${small[@]}" -o "$work/no/a.h5" -q
expect 2 "not a plain file" "a device" "$mill" run "${small[@]}" -o /dev/full -q --force
expect 2 "cannot be written" "a place where nothing can be made" "$mill" run "${small[@]}" -o /proc/a.h5 -q
many=(geometries/ideal-gas.cfg duration=0.2 record.frames=1000.0 record.checkpoint=0.05)
# shellcheck disable=SC2317 # called through expect
limit() { (ulimit -f 4000 && exec "$mill" "$@"); } # kB
expect 1 "File too large" "a file beyond its limit" limit run "${many[@]}" -o "$work/large.h5" -q
check "what was flushed can be read" h5dump -a /eventmill/time "$work/large.h5"
if mkdir "$work/small" && mount -t tmpfs -o size=5m tmpfs "$work/small" 2>/dev/null; then
  mounted=yes
  expect 1 "No space left" "a full disk" "$mill" run "${many[@]}" -o "$work/small/full.h5" -q
  check "what was flushed can be read" h5dump -a /eventmill/time "$work/small/full.h5"
  check "the second copy is gone" test ! -e "$work/small/full.h5.next"
  mount -o remount,ro "$work/small"
  expect 2 "Read-only file system" "a read-only disk" "$mill" run "${small[@]}" -o "$work/small/b.h5" -q
fi

# ---------------------------------------------------------------- from run to run
mill_scene=(geometries/simoloyer-2l.cfg record.frames=100.0)
expect 0 "" "a mill" "$mill" run "${mill_scene[@]}" duration=0.03 -o "$work/first.h5" -q
second=("${mill_scene[@]}" balls.start=run balls.from="$work/first.h5")
expect 0 "" "it goes on from its last frame, blades too" \
  "$mill" run "${second[@]}" duration=0.005 -o "$work/second.h5" -q
check "its scene is printed" bash -c "'$mill' check ${second[*]} >'$work/second.cfg'"
check "and reads back the same" \
  bash -c "'$mill' check '$work/second.cfg' | cmp - '$work/second.cfg'"
mkdir "$work/scenes"
cp geometries/simoloyer-2l.cfg "$work/scenes/mill.cfg"
mv "$work/first.h5" "$work/scenes"
near=(scenes/mill.cfg record.frames=100.0 balls.start=run balls.from=first.h5)
check "a run beside the scene, as seen from elsewhere" bash -c "
  cd '$work' && '$mill' check ${near[*]} >scenes/whole.cfg &&
  '$mill' check scenes/whole.cfg | cmp - scenes/whole.cfg"
check "goes on without that run" bash -c "
  cd '$work' && '$mill' run ${near[*]} duration=0.002 -o third.h5 -q &&
  '$mill' run ${near[*]} duration=0.005 -o whole3.h5 -q && rm scenes/first.h5 &&
  '$mill' run ${near[*]} duration=0.005 -o third.h5 -q --resume &&
  h5diff --exclude-path /eventmill/sessions --exclude-path /eventmill/checkpoint/engine third.h5 whole3.h5"

check "a ball at rest among blades" timeout 60 "$mill" run geometries/simoloyer-2l.cfg 'gravity="none"' \
  balls.count=1 balls.speed=0 duration=0.1 -o none -q

# ---------------------------------------------------------------- damaged files
head -c 30000 "$work/whole.h5" >"$work/short.h5"
expect 2 "truncated, damaged" "resuming a truncated file" "$mill" run "${long[@]}" -o "$work/short.h5" --resume -q
echo "no HDF5" >"$work/text.h5"
expect 2 "is not an HDF5 file" "resuming a foreign file" "$mill" run "${long[@]}" -o "$work/text.h5" --resume -q

finish
