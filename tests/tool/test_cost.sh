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
expect 2 "expected 1 to 64" "rounds out of range" "$mill" cost "$gas" --rounds 0
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
check "what a digit costs, in a sentence" \
  grep -q '1 % on the rate above 3 m/s takes [0-9.e+]* s simulated, [0-9.e+]* s of computing' "$work/out"
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
  --only quartic --rounds 1 --json -q
cp "$work/out" "$work/only"
check "only these" python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
assert not d["effects"] and all("quartic" in r["variant"] for r in d["accuracy"])' "$work/only"

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
