#!/bin/bash
# mill cost and mill run --until-precision as a user runs them.
# shellcheck disable=SC2016,SC2317
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh

# cell ROW COLUMN: of the CSV's table of accuracy.
cell() {
  awk -F, -v row="$1" -v column="$2" '
    $1 ~ /variant/ && !at { for (k = 1; k <= NF; k++) if ($k == column || index($k, column " [") == 1) at = k; next }
    at && $1 == row { gsub(/"/, ""); print $at; exit }' "$work/cost.csv"
}

gas=geometries/ideal-gas.cfg mill_scene=geometries/simoloyer-2l.cfg

# ---------------------------------------------------------------- usage
expect 0 "" "help" "$mill" cost --help
expect 2 "no scene given" "no scene" "$mill" cost
expect 2 "unknown option" "unknown option" "$mill" cost "$gas" --fast
expect 2 "from 1 to 64" "rounds out of range" "$mill" cost "$gas" --rounds 0
expect 2 "whole number" "half a turn" "$mill" cost "$gas" --rounds 2.7
expect 2 "expected part of one of: level fast, " "no such variant" "$mill" cost "$gas" --only quarz
expect 2 "nowhere/c.csv: error: cannot be written" "the table has no place" \
  "$mill" cost "$gas" --csv "$work/nowhere/c.csv"
expect 2 "nowhere/c-accuracy.png: error: cannot be written" "nor have the pictures" \
  "$mill" cost "$gas" -o "$work/nowhere/c"
expect 2 "expected KEY=VALUE" "two scenes" "$mill" cost "$gas" "$gas"
expect 2 "engine.quartic" "unknown solver" "$mill" check "$gas" engine.quartic=cardano
expect 2 "at least 3" "two facets" "$mill" check "$gas" chamber.facets=2
expect 2 "neither turns" "facets that turn" "$mill" check "$gas" chamber.facets=32 chamber.rpm=10

# ---------------------------------------------------------------- tables
expect 0 "" "a mill with few balls" "$mill" cost "$mill_scene" balls.count=250 --steady 0.02 \
  --time 0.02 --rounds 2 --flights 4000 --csv "$work/cost.csv" -o "$work/cost" -q
for table in "accuracy against time" "effects against time" "recording against time" \
  "statistics against time" "one per cent takes"; do
  check "table: $table" grep -q "$table" "$work/out"
done
for picture in accuracy effects statistics; do
  check "picture: $picture" test -s "$work/cost-$picture.png"
done
above() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a != "" && a + 0 > b + 0) }'; }
equal() { [ "$1" = "$2" ]; }
check "the scene as it is has no shift" equal "$(cell 'level standard' power)" 0
check "nor an interval" equal "$(cell 'level standard' power_ci95)" 0
check "113 bits cost time" above "$(cell 'level reference' time)" 2
check "standard misses nothing" equal "$(cell 'level standard' missed)" 0
check "standard invents nothing" equal "$(cell 'level standard' invented)" 0
check "reference has no error" equal "$(cell 'level reference' error_most)" 0
check "the reference's search misses contacts with the ends of blades" \
  above "$(cell 'blade: steps of 0.1 d' missed)" 0
check "a coarse tolerance shows in the contact times" \
  above "$(cell 'tolerance 1e-3 d' error_rms)" "$(cell 'level standard' error_rms)"
check "Ferrari's form loses digits" \
  above "$(cell 'quartic: Ferrari' error_rms)" 0
"$mill" cost "$gas" balls.count=200 --steady 0.01 --time 0.01 --rounds 2 --flights 1000 --json -q \
  >"$work/json" 2>"$work/err"
check "JSON" python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); d["accuracy"][0]["time"]' \
  "$work/json"

expect 0 "" "a few of the variants" "$mill" cost "$gas" balls.count=200 --steady 0.01 --time 0.01 \
  --only polish --rounds 1 --json -q
cp "$work/out" "$work/only"
check "only these" python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
assert not d["effects"] and [r["variant"] for r in d["accuracy"]] == ["polish: 64 bits"]' "$work/only"

cat >"$work/fall.cfg" <<'CFG'
duration = 1.0;
chamber = { shape = "box"; size = [0.05, 0.05, 0.05]; periodic = [true, true, true]; };
balls = { count = 50; diameter = 0.003; density = 7850.0; start = "uniform"; speed = 1.0; };
contact = { rule = "smooth"; normal = 1.0; };
CFG
"$mill" cost "$work/fall.cfg" --steady 0.05 --time 0.05 --rounds 1 --only polish --json -q >"$work/json" 2>"$work/err"
check "no energy error where balls fall for ever" python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
assert d["energy"] is None and d["accuracy"][0]["energy"] is None, d' "$work/json"

"$mill" cost "$gas" balls.count=10 --steady 0.01 --time 0.01 --only frames --rounds 1 --flights 0 -q \
  >"$work/out" 2>"$work/err"
check "runs too short to compare are said to be" grep -q "^recording: - where .* --time above 0.01" "$work/out"
expect 0 "c-accuracy.png: not drawn" "a run that records" "$mill" cost "$gas" --steady 0.05 --time 1 \
  --only frames --rounds 1 --flights 0 -o "$work/c" -q
check "its cost" grep -q "^frames, 50/s  *[0-9.]" "$work/out"
check "in a picture of its own" test -s "$work/c-recording.png"
check "what a digit costs, in a sentence" \
  grep -q '1 % on the rate above 3 m/s takes [0-9.e+]* s simulated, [0-9.e+]* s of computing' "$work/out"

"$mill" cost <(cat "$gas") balls.count=200 --steady 0.01 --time 0.01 --rounds 1 --flights 100 \
  --only "level fast" -q >"$work/out" 2>"$work/err"
check "a scene from a pipe" grep -q "^level fast  *[0-9.]" "$work/out"

# What a scene comes to, not the way there: a gas that cools for 0.4 s, seen for 0.04 s.
"$mill" cost "$gas" balls.count=300 --steady 0.4 --time 0.01 --rounds 1 --flights 0 --csv "$work/cost.csv" \
  --only restitution -q >"$work/out" 2>"$work/err"
check "variants settle before their figures count" \
  above -0.2 "$(sed -n 's/^restitution falls with speed,//p' "$work/cost.csv" | cut -d, -f5)"

# ---------------------------------------------------------------- levels of a scene in full
"$mill" check "$gas" balls.count=200 >"$work/full.cfg"
expect 0 "" "a scene in full" "$mill" cost "$work/full.cfg" --steady 0.01 --time 0.01 --rounds 1 \
  --flights 1000 --only level --csv "$work/cost.csv" -q
check "its levels differ" above "$(cell 'level reference' time)" 2
check "in their errors, too" equal "$(cell 'level reference' error_most)" 0

cp "$work/cost.csv" "$work/before.csv"
(ulimit -f 0; "$mill" cost "$work/full.cfg" --steady 0.01 --time 0.01 --rounds 1 --flights 0 \
  --only "level fast" --csv "$work/cost.csv" -q >/dev/null 2>&1)
check "a full disk leaves the table of before" cmp -s "$work/cost.csv" "$work/before.csv"

# ---------------------------------------------------------------- scenes with little to measure
cat >"$work/rest.cfg" <<'END'
duration = 1.0; gravity = "none";
chamber = { shape = "drum"; diameter = 0.1; length = 0.1; };
balls = { count = 3; diameter = 0.01; speed = 0.0; };
END
for count in 0 3; do
  expect 0 "" "$count balls at rest" timeout 60 "$mill" cost "$work/rest.cfg" balls.count=$count \
    --only "level fast" --time 0.05 --rounds 1 -q
  check "are told to have no contacts" grep -q "none judged" "$work/out"
done
expect 0 "" "balls at rest begin to fall" "$mill" cost "$work/rest.cfg" --only "with gravity" \
  --steady 0.3 --time 0.1 --rounds 1 --json -q
check "their time per contact is to be compared with none" \
  grep -q '"time_per_collision": null' "$work/out"
expect 0 "" "a mill without its rotor" timeout 60 "$mill" cost "$mill_scene" balls.count=1000 --steady 1.5 \
  --time 0.02 --rounds 1 --flights 0 -q --only "without rotor"
check "comes to rest" grep -q "^without rotor: .*comes to rest" "$work/out"
expect 0 "bounce-accuracy.png: not drawn" "a ball that comes to rest" "$mill" cost \
  geometries/bouncing-ball.cfg --rounds 1 -q -o "$work/bounce" --only level
check "is measured for its duration" grep -q "goes on for 4 s only: .*collapse" "$work/out"
check "in the same blocks of time" grep -q "^level standard .* 0 ± 0 %" "$work/out"
expect 0 "" "balls that come to glide before a sixteenth of the time" "$mill" cost \
  geometries/simoloyer-2l.cfg balls.count=100 duration=0.02 --rounds 1 --flights 0 -q --only "level standard"
check "are measured up to there" grep -q "goes on for 0.5.* s only: .*collapse" "$work/out"
cat >"$work/one.cfg" <<'END'
chamber = { shape = "box"; size = [0.1, 0.1, 0.1]; };
gravity = "none"; contact = { rule = "smooth"; normal = 1.0; };
balls = { count = 1; diameter = 0.02; speed = 1.0; };
END
expect 0 "" "one elastic ball" "$mill" cost "$work/one.cfg" --time 0.5 --rounds 1 -q --only level
check "has an exact speed" grep -q "0 s where the figure is exact" "$work/out"
expect 0 "" "elastic balls most of which have met none" "$mill" cost "$work/one.cfg" balls.count=60 \
  balls.diameter=0.003 chamber.size=[0.05,0.05,0.05] --steady 0.02 --time 0.02 --flights 0 --rounds 1 -q \
  --only "level standard" --csv "$work/cost.csv"
check "their median speed does not vary by its rounding" \
  equal "$(sed -n '/^# statistics/,/^$/p' "$work/cost.csv" | tail -n 2 | cut -d, -f3 | tr -d '\n')" 0
expect 0 "" "a short run" "$mill" cost "$mill_scene" balls.count=100 --steady 0.02 --time 0.001 \
  --rounds 1 --flights 100 -q --only "level fast"
check "cannot tell what one per cent takes" grep -q "run longer: --time above 0.001" "$work/out"

facets=(geometries/ideal-gas-gravity.cfg balls.count=200 chamber.facets=64 --steady 0.01 --time 0.01
  --rounds 1 --flights 2000 -q)
expect 2 "in no variant" "no quartic where the drum has facets" "$mill" cost "${facets[@]}" --only quartic
expect 0 "" "a drum of facets" "$mill" cost "${facets[@]}" --only level --csv "$work/cost.csv"
check "has errors of contact times" above "$(cell 'level standard' error_rms)" 0
check "but for the reference" equal "$(cell 'level reference' error_most)" 0

# ---------------------------------------------------------------- files that cannot be, and stops
short=("$gas" balls.count=200 --steady 0.01 --time 0.01 --rounds 1 --flights 100 -q)
TMPDIR=$work/nowhere expect 0 "" "no folder for runs that record" "$mill" cost "${short[@]}" \
  --only frames
check "is told" grep -q "^frames, 50/s: .*nowhere/mill-cost-.*cannot be created" "$work/out"
limited() { (ulimit -f 20 && "$@"); }
TMPDIR=$work expect 0 "" "a limit to files" limited "$mill" cost "${short[@]}" --only "collision table"
check "is told as well" grep -q "^collision table: .*cannot be written" "$work/out"
check "nothing is left" equal "$(find "$work" -name 'mill-cost-*')" ""
mkdir "$work/tmp"
TMPDIR=$work/tmp "$mill" cost "$gas" balls.count=200 --steady 0.01 --time 0.5 --rounds 64 --flights 100 \
  --only ta --csv "$work/stopped.csv" >"$work/out" 2>"$work/err" &
pid=$!
for ((k = 0; k < 300; k++)); do
  [ -n "$(ls "$work/tmp")" ] && break
  sleep 0.1
done
kill -INT $pid
wait $pid
is "stopped while it records" 1 $?
check "it says so" grep -q "^interrupted: [0-9]* of [0-9]* variants are measured" "$work/out"
check "with what is measured" grep -q "^level standard,[0-9.]*,[0-9.]" "$work/stopped.csv"
check "and leaves no file" equal "$(ls "$work/tmp")" ""

"$mill" cost "$mill_scene" balls.count=260000 balls.diameter=0.002 -q >"$work/out" 2>"$work/said" &
pid=$!
sleep 1
kill -INT $pid
check "stopped while it places balls" timeout 5 tail --pid=$pid -f /dev/null # all take 15 s
kill -KILL $pid 2>/dev/null
wait $pid
is "with its exit code" 1 $?
check "it says so" grep -q "^interrupted" "$work/said"

# What the scene includes is changed while it is measured: all variants are those of its beginning.
printf '@include "part.cfg"\n' >"$work/whole.cfg"
cp "$gas" "$work/part.cfg"
mkdir "$work/changed"
TMPDIR=$work/changed "$mill" cost "$work/whole.cfg" balls.count=200 --steady 0.01 --time 0.5 --rounds 4 \
  --flights 100 --only "collision table" -q >"$work/out" 2>"$work/err" &
pid=$!
for ((k = 0; k < 300; k++)); do
  [ -n "$(ls "$work/changed")" ] && break
  sleep 0.1
done
echo "nonsense" >"$work/part.cfg"
wait $pid
is "a scene that is changed while it is measured" 0 $?
check "is the one of the beginning" grep -q "^collision table  *[-0-9.]" "$work/out"
check "without an error" bash -c "! grep -q error: $work/out"

# Two kinds of balls: left out, all are of one.
cat >"$work/two.cfg" <<'END'
chamber = { shape = "drum"; diameter = 0.146; length = 0.135; };
balls = ( { name = "a"; count = 100; diameter = 0.005; speed = 1.0; },
          { name = "b"; count = 50; diameter = 0.01; speed = 1.0; } );
END
expect 0 "" "balls of two kinds" "$mill" cost "$work/two.cfg" --steady 0.01 --time 0.02 --rounds 1 -q \
  --only kind
check "left out" grep -q "balls of one kind  *[0-9.]" "$work/out"

expect 0 "" "a box with balls from a table" "$mill" cost geometries/newtons-cradle.cfg --time 0.2 \
  --rounds 2 -q

# ---------------------------------------------------------------- until precision
small=("$gas" balls.count=300 record.collisions=false duration=20 -o none -q)
expect 0 "precision reached" "stops when it is reached" \
  "$mill" run "${small[@]}" --until-precision 'rate(vn>1)=5%,median(vn)=0.05'
cp "$work/err" "$work/said"
check "long before the duration is over" \
  awk '/reached at/ { early = $4 < 20 } END { exit !early }' "$work/said"
expect 0 "precision not reached by 1 s" "the duration is the upper bound" \
  "$mill" run "${small[@]}" duration=1 --until-precision 'rate(vn>1)=0.01%'
expect 2 "expected median(speed)" "unknown figure" "$mill" run "${small[@]}" --until-precision 'mean=1%'
expect 0 "median(vn)  *nothing seen" "a median without contacts, over enough blocks" "$mill" run \
  "${small[@]}" balls.count=0 duration=2 --until-precision 'median(vn)=1%'
expect 0 "rate(vn>50)  *none seen" "what was never seen is not known" \
  "$mill" run "${small[@]}" duration=2 --until-precision 'rate(vn>50)=1%,power=1%'
cp "$work/err" "$work/said"
expect 0 "from fewer than 32 independent values" "nor what a few blocks tell" \
  "$mill" run "${small[@]}" duration=1 --until-precision 'rate(vn>1)=50%'
check "and not reached" grep -q "not reached by 2 s" "$work/said"
expect 2 "record.histograms: 0;" "no blocks" \
  "$mill" run "${small[@]}" record.histograms=0 --until-precision 'rate(vn>1)=1%'
for figure in 'median(speed)' power; do
  expect 2 "record.observables: 200; .* expected at least 250" "blocks without samples: $figure" \
    "$mill" run "${small[@]}" record.histograms=250 --until-precision "$figure=1%"
done
expect 0 "precision reached" "rates that do not fit each other, and JSON" "$mill" run "${small[@]}" \
  record.histograms=150 --json --until-precision 'median(speed)=5%, rate(vn>1)=20%'
check "says what was reached" python3 -c 'import json, sys
p = json.load(open(sys.argv[1]))["precision"]
assert [f["figure"] for f in p] == ["median(speed)", "rate(vn>1)"]
assert all(f["reached"] and 0 < f["ci95"] <= f["wanted"] * f["value"] for f in p)
assert [f["wanted"] for f in p] == [0.05, 0.2]' "$work/out"
expect 2 "precision such as" "no precision" "$mill" run "${small[@]}" --until-precision 'power=-1'
"$mill" run "${small[@]}" --until-precision 'rate(vn>1)=5%' -o "$work/a.h5" >/dev/null 2>&1
expect 0 "precision reached" "a run goes on to a better precision" \
  "$mill" run "${small[@]}" --until-precision 'rate(vn>1)=3%' -o "$work/a.h5" --resume
stopped=$(sed -n 's/precision reached at //p' "$work/err")
"$mill" run "${small[@]}" --until-precision 'rate(vn>1)=3%' -o "$work/b.h5" >/dev/null 2>"$work/said"
check "and ends where one run would have" grep -q "precision reached at $stopped" "$work/said"

# ---------------------------------------------------------------- absent effects
check "bytes of events" grep -q "of these bytes" <("$mill" check "$gas")
spinless=$("$mill" check "$gas" | sed -n 's/^# balls: .*, \([0-9]*\) bytes each.*/\1/p')
spinning=$("$mill" check "$gas" contact.rule=rough | sed -n 's/^# balls: .*, \([0-9]*\) bytes each.*/\1/p')
check "spin has its bytes only where it is called for" equal "$((spinning - spinless))" 24

finish
