#!/bin/bash
# Sweeps as a user runs them: points and seeds, kills, failures, tables, diagrams.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh
export BUILD=$bin
top=$PWD sweep=$PWD/scripts/sweep collect=$PWD/scripts/collect
scene=$top/geometries/simoloyer-2l.cfg
if ! command -v parallel >/dev/null; then
  skip "sweeps" "GNU parallel is not installed"
  finish
fi
cd "$work" || exit 2

rows() { grep -vc '^#' "$1"; }
column() { # FILE KEY
  awk -F, -v key="$2" '/^#/ { next } !at { for (k = 1; k <= NF; k++) if ($k == key) at = k; next }
    { print $at }' "$1"
}

few=("$scene" "balls.count=40,60" rotor.rpm=900:300:1500 duration=0.06)

# ---------------------------------------------------------------- usage
expect 2 "no scene" "no scene" "$sweep" -o a
expect 2 "no folder" "no folder" "$sweep" "$scene" rotor.rpm=900,1000
expect 2 "there is no such scene" "a scene that is not there" "$sweep" no.cfg rotor.rpm=900,1000 -o a
expect 2 "low:step:high" "a range that runs backwards" "$sweep" "$scene" rotor.rpm=900:10:800 -o a
expect 2 "error" "a key that the scene does not know" "$sweep" "$scene" rotor.rmp=900,1000 -o a
expect 2 "seeds come from the points" "a seed as an axis" "$sweep" "$scene" seed=1,2 -o a
expect 2 "unknown option" "an unknown option" "$sweep" "$scene" --fast -o a
check "bad usage leaves nothing" test ! -e a
for script in sweep collect run-point plot-map plot-lines calibrate reproduce reproduce-report; do
  check "$script --help" bash -c "'$top/scripts/$script' --help | grep -q '^Usage\|Usage:'"
done

# ---------------------------------------------------------------- dry run
expect 0 "" "a dry run" "$sweep" "${few[@]}" -o a -n
cp out plan
check "it lists the points" test "$(grep -c "to do.*runs/" plan)" -eq 6
check "and the time" grep -q "6 of 6 runs to do.*of computing" plan
check "it leaves nothing" test ! -e a
expect 0 "point 2 fails within 0.12 s: .*balls" "a dry run of points of which one fails" \
  "$sweep" "$scene" balls.count=40,400000,50 duration=0.02 -o a -n
check "goes by the others" grep -q "at 2 points" out

# ---------------------------------------------------------------- a grid
expect 0 "12 of 12" "a sweep, which tells its progress" "$sweep" "${few[@]}" --repeat 2 -j2 -o whole
report "$([ "$(rows whole/table.csv)" -eq 13 ] && [ "$(rows whole/mean.csv)" -eq 7 ] &&
  [ "$(rows whole/provenance.csv)" -eq 13 ] && echo ok || echo not ok)" "tables with all runs and points"
report "$([ "$(column whole/table.csv seed | sort -u | wc -l)" -eq 12 ] && echo ok || echo not ok)" \
  "each run has a seed of its own"
run=$(ls -d "$PWD"/whole/runs/*.h5 | head -n 1)
"$post" info "$run" --json >info
check "no frames, no collision table" bash -c "
  grep -q '\"frames\": 0,' info && grep -q '\"rows\": \"none\"' info"
check "the HDF5 table holds what the CSV does" bash -c "
  h5dump -d /runs/total_collisions -y -w 1 whole/table.h5 | awk '/^ *[0-9]/ { s += \$1 } END { print s }' >x
  awk -F, '/^#/ { next } !c { for (k = 1; k <= NF; k++) if (\$k == \"total_collisions\") c = k; next }
    { s += \$c } END { print s }' whole/table.csv >y && [ -s x ] && cmp x y"
check "units are in the HDF5 table" bash -c "
  h5dump -a /points/median_speed/unit whole/table.h5 | grep -q 'm/s'"
check "means of repeated runs" bash -c "
  awk -F, '/^#/ { next } FNR == 1 || !h[FILENAME]++ { for (k = 1; k <= NF; k++) { n = \$k; sub(/ .*/, \"\", n)
      at[FILENAME, n] = k }; next }
    FILENAME ~ /table/ { sum[\$at[FILENAME, \"point\"]] += \$at[FILENAME, \"collision_rate\"] / 2; next }
    { d = sum[\$at[FILENAME, \"point\"]] / \$at[FILENAME, \"collision_rate\"] - 1
      if (d * d > 1e-14) bad = 1; n++ } END { exit bad || n != 6 }' whole/table.csv whole/mean.csv"

# A point's seed and name depend on its values alone.
check "one point of it, with the axes the other way round" "$sweep" "$scene" duration=0.06 \
  rotor.rpm=1200,1200.0 balls.count=60,60 -o one
report "$(grep -qF "$(tail -n 1 one/table.csv | cut -d, -f 3,4)" whole/table.csv && echo ok ||
  echo not ok)" "has the same seed and name"

# ---------------------------------------------------------------- extending
stamp() { stat -c '%n %Y %s' "$1"/runs/*.h5 | sort; }
stamp whole >before
check "the same again" "$sweep" "${few[@]}" --repeat 2 -o whole
check "changes no run" bash -c "$(declare -f stamp); stamp whole | cmp before -"
cp whole/table.csv first.csv
check "a longer duration goes on" "$sweep" "${few[@]}" --repeat 2 duration=0.08 -o whole
report "$(column whole/table.csv 'simulated_time [s]' | grep -qxv 0.08 && echo not ok || echo ok)" \
  "to that duration"
expect 2 "another folder" "other fixed values are refused" "$sweep" "${few[@]}" "gravity=[0,0,0]" -o whole

# ---------------------------------------------------------------- lists and hypercubes
printf 'rotor.rpm balls.count\n900 40\n\n# a comment\n1300 50\n' >list
check "points from a list" "$sweep" "$scene" --list list duration=0.02 -o listed
report "$([ "$(column listed/table.csv balls.count | tr '\n' ' ')" = "40 50 " ] && echo ok ||
  echo not ok)" "has those points"
check "a hypercube" "$sweep" "$scene" rotor.rpm=800:1600 balls.count=20:5:55 --lhs 8 duration=0.01 -o cube
report "$(column cube/table.csv rotor.rpm | awk '{ part[int(($1 - 800) / 100)]++ }
  END { for (k = 0; k < 8; k++) if (part[k] != 1) bad = 1; print bad ? "not ok" : "ok" }')" \
  "has one point in each eighth"
report "$(column cube/table.csv balls.count | sort -n | tr '\n' ' ' |
  grep -qx '20 25 30 35 40 45 50 55 ' && echo ok || echo not ok)" "along each axis"

# ---------------------------------------------------------------- failures
# 400000 balls find no place in the drum.
expect 1 "1 of 3 runs failed" "a point that fails" "$sweep" "$scene" balls.count=40,400000,50 duration=0.02 -o bad
cp err why
check "the others are in the table" test "$(rows bad/table.csv)" -eq 3
check "it is listed" grep -q 400000 bad/failed.csv
check "with its reason" grep -q "count-400000.*error" why

# A run file that is damaged is begun anew, and gives the same again.
run=$(ls "$work"/listed/runs/*.h5 | head -n 1)
cp listed/table.csv sound.csv
head -c 3000 "$run" >short && mv short "$run" && rm "${run%.h5}.json"
expect 0 "" "a damaged run file" "$sweep" "$scene" --list list duration=0.02 -o listed
check "is begun anew" cmp sound.csv listed/table.csv

# ---------------------------------------------------------------- kills
long=("$scene" rotor.rpm=900:100:1700 balls.count=300 duration=0.4 -q)
check "a sweep, undisturbed" "$sweep" "${long[@]}" -o quiet
processes() { ps -o pid= -s "$1" 2>/dev/null; }
for signal in KILL TERM; do
  setsid "$sweep" "${long[@]}" -o "$signal" >/dev/null 2>&1 &
  for _ in $(seq 100); do
    ls "$signal"/runs/*.h5 >/dev/null 2>&1 && break
    sleep 0.05
  done
  sleep 0.1
  group=$(ps -o sid= -p $! | tr -d ' ')
  if [ "$signal" = KILL ]; then # everything at once, as when the machine goes down
    [ -n "$group" ] && processes "$group" | xargs -r kill -KILL 2>/dev/null
  else
    kill -TERM $!
  fi
  wait $! 2>/dev/null
  report "$([ "$(ls "$signal"/runs/*.json 2>/dev/null | wc -l)" -lt 9 ] && echo ok || echo not ok)" \
    "SIG$signal in the middle of a sweep"
  for _ in $(seq 40); do [ -n "$(processes "${group:-0}")" ] || break; sleep 0.1; done
  report "$([ -z "$group" ] || [ -z "$(processes "$group")" ] && echo ok || echo not ok)" \
    "leaves no process behind"
  check "the same command goes on" "$sweep" "${long[@]}" -o "$signal"
  check "and gives the same table" cmp quiet/table.csv "$signal/table.csv"
done

# Ctrl-C at a terminal tells sweep and GNU parallel, each of which tells the runs.
ends() { for run in "$1"/runs/*.h5; do h5dump -a /eventmill/end "$run" | sed -n 's/.*(0): "\(.*\)"/\1/p'; done; }
setsid env --default-signal=INT "$sweep" "$scene" rotor.rpm=900:100:1200 balls.count=3000 duration=100 \
  record.frames=500 -q -j 4 -o keys >out 2>said &
for _ in $(seq 200); do
  [ "$(ls keys/runs/*.h5 2>/dev/null | wc -l)" -eq 4 ] && break
  sleep 0.05
done
sleep 1
kill -INT -- -$!
wait $!
is "Ctrl-C ends a sweep" 1 $?
check "which says so" grep -q "interrupted; the same command goes on" said
is "all its runs leave checkpoints" "interrupted interrupted interrupted interrupted" "$(ends keys | xargs)"

# ---------------------------------------------------------------- diagrams
"$collect" whole >/dev/null 2>&1
if command -v gnuplot >/dev/null; then
  check "a map" "$top/scripts/plot-map" whole median_vn -o map.png
  check "with a surface" "$top/scripts/plot-map" whole median_vn --surface -o surface.png
  expect 2 "on a grid" "no surface of scattered points" "$top/scripts/plot-map" cube power --surface -o x.png
  check "curves" "$top/scripts/plot-lines" whole power --by balls.count -o lines.svg
  check "a map of scattered points" "$top/scripts/plot-map" cube collision_rate -o cube.gp
  check "are there" test -s map.png -a -s surface.png -a -s lines.svg -a -s cube.gp

  # What scripts draw looks like what millpost draws.
  read -ra eight <<<"$(echo whole/runs/*.h5 | cut -d' ' -f1-8)"
  "$mill" run "$scene" balls.count=60 duration=0.02 record.frames=100 -o still.h5 -q >x 2>&1
  "$post" hist "${eight[@]}" -o hist.gp >x && "$post" map still.h5 --cells rings -o field.gp >x &&
    "$top/scripts/plot-lines" whole power --by balls.count -o lines.gp
  style() { # all but the words and the size
    sed -nE "s/'.*' (at|noenhanced)/\1/; s/ size [0-9]+,[0-9]+//
      /^set (terminal|encoding|border 3 lw|tics|grid|key top right samplen|tmargin|[xy]label|label 100)/p" "$1" | sort
  }
  is "the same style" "$(style hist.gp)" "$(style lines.gp)"
  is "the same colours" "$(grep -o "lines lw 1.5 lc rgb '#[0-9a-f]*" hist.gp | grep -o '#.*' | tr '\n' ' ')" \
    "$(sed -n 's/^colours="\(.*\)"/\1 /p' "$top/scripts/lib.sh")"
  pairs() { grep '^set palette defined' "$1" | tr -d "\"'(),\n" | grep -oE '[0-9]+ #[0-9a-f]{6}'; }
  is "the same palette" "$(pairs cube.gp)" "$(pairs field.gp | grep -xF "$(pairs cube.gp)")"
fi
expect 2 "no column" "a figure that is not there" "$top/scripts/plot-lines" whole beauty -o x.png

# ---------------------------------------------------------------- the programs
expect 2 "no mill and millpost in $work/nowhere" "BUILD names a folder without the programs" \
  env PATH="$bin:$PATH" BUILD="$work/nowhere" "$collect" whole
mkdir -p installed/{bin,share} && cp -r "$top/scripts" installed/share && cp "$mill" "$post" installed/bin
expect 0 "" "installed programs serve without BUILD" \
  env -u BUILD PATH="$work/installed/bin:$PATH" installed/share/scripts/collect whole
finish
