#!/bin/bash
# millpost as its users run it: figures against an independent computation with h5py and numpy, laws
# that hold and laws that are broken on purpose, exports, bad input.
# shellcheck disable=SC2317 # functions are called by name
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh

post() { "$post" "$@"; }
run() { "$mill" run "$@" --quiet --force; }
agrees() { # FILE CODE COMMAND ...: python with `result` (parsed JSON of the command's output), h (h5py file)
  local file=$1 code=$2
  shift 2
  post "$@" --json >"$work/json" || return 1
  is_true "$file" "$code"
}

is_true() { # FILE CODE: of what was printed last
  local file=$1 code=$2
  /usr/bin/python3 - "$work/json" "$file" <<PY
import json, sys
import h5py, numpy as np
result = json.load(open(sys.argv[1]))
h = h5py.File(sys.argv[2], "r")
t = h["eventmill/collisions/time"][...] if "collisions" in h["eventmill"] else None
$code
PY
}

settings=(balls.count=2500 duration=0.25 contact.rule=reichardt2005)
one=$work/one.h5 plain=$work/plain.h5 fast=$work/fast.h5 gas=$work/gas.h5
run geometries/simoloyer-2l.cfg "${settings[@]}" record.collisions=true \
  record.frames=200 record.observables=400 record.histograms=100 -o "$one" &&
  run geometries/simoloyer-2l.cfg "${settings[@]}" record.histograms=100 \
    record.collisions=false -o "$plain" &&
  run geometries/simoloyer-2l.cfg "${settings[@]}" rotor.rpm=1700 \
    record.collisions=false -o "$fast" &&
  run geometries/ideal-gas.cfg balls.count=1000 duration=4 record.collisions=true \
    record.frames=20 -o "$gas"
is "runs to look at" 0 $?

for command in info hist map verify power steady compare scale fit frame film export; do
  check "help of $command" post "$command" --help
done
check "help" post --help
check "version" post --version

info() { agrees "$one" '
assert result["seed"] == h["parameters/seed"][0]
assert result["collisions"] == len(t) == result["rows"]
assert sum(c["count"] for c in result["collisions_by_class"]) == len(t)
' info "$one"; }
check "info counts what the file holds" info
check "-j is short for --json" bash -c "'$post' info '$one' -qj | cmp - <('$post' info '$one' --json)"

between() { # flushed between two samples, without observables
  run geometries/simoloyer-2l.cfg balls.count=100 duration=0.1234 record.observables=0 record.histograms=0 \
    -o "$work/between.h5" && agrees "$one" '
assert sum(c["count"] for c in result["collisions_by_class"]) == result["collisions"] > 0, result
' info "$work/between.h5"
}
check "without observables, too" between

hist() { agrees "$one" '
w = (t >= result["from"]) & (t < result["to"])
vn, cls = h["eventmill/collisions/vn"][...][w], h["eventmill/collisions/class"][...][w]
names = ["ball-ball", "ball-drum", "ball-end", "ball-blade"]
span = result["to"] - result["from"]
for often, hard in zip(result["how_often"], result["how_hard"]):
    x = vn if often["class"] == "all" else vn[cls == names.index(often["class"])]
    assert often["count"] == len(x), (often, len(x))
    assert abs(often["rate"] - len(x) / span) < 1e-6 * often["rate"]
    assert abs(often["share_above"] - np.mean(x > 1.5)) < 2e-3
    for key, q in (("q25", 25), ("median", 50), ("q75", 75)):
        assert abs(hard[key] / np.percentile(x, q) - 1) < 0.01, (key, hard, np.percentile(x, q))
    assert abs(hard["mean"] / np.mean(x, dtype=float) - 1) < 1e-9 and hard["highest"] == x.max()
    assert hard["median_ci95"] > 0
' hist "$one" --from 0.1 --above 1.5; }
check "hist agrees with numpy" hist

last() { # the run ended amid contacts at one time: they are no less than the others
  run geometries/bouncing-ball.cfg contact.normal=0.3 -o "$work/collapsed.h5" 2>/dev/null
  agrees "$work/collapsed.h5" '
assert result["how_often"][-1]["count"] == len(t) > np.sum(t < t[-1]) + 1, (result["how_often"], len(t))
' hist "$work/collapsed.h5" --from 0
}
check "contacts at the end of a run are counted" last

area() { # of √N bins, N of the smallest class or else enough, up to the highest value
  agrees "$one" '
w = (t >= result["from"]) & (t < result["to"])
vn, cls = h["eventmill/collisions/vn"][...][w], h["eventmill/collisions/class"][...][w]
curve = result["curve"]
few, all = np.ceil(np.sqrt([np.bincount(cls).min(), cls.size]))
assert len(curve) == max(few, min(100, all)), len(curve)
assert vn.max() <= curve[-1]["high"] < 1.001 * vn.max()
for name in ("all", "ball-ball", "ball-drum", "ball-end", "ball-blade"):
    assert abs(sum(b[name] * (b["high"] - b["low"]) for b in curve) - 1) < 1e-9, name
' hist "$one" --from 0.1 --curve
}
check "a histogram holds all values, and its area is 1" area
rare() { # one collision: no figure beyond it, and no interval
  agrees "$one" '
often, hard = (result[k][0] for k in ("how_often", "how_hard"))
assert often["count"] == 1 and often["share_above_ci95"] is None, often
for key in ("mode", "q25", "median", "q75", "mean", "q90", "highest"):
    assert abs(hard[key] - hard["highest"]) < 1e-6 * hard[key], hard
    assert hard.get(key + "_ci95") is None, hard
assert len(result["curve"]) == 1
' hist "$one" --class ball-blade --curve --from "$1" --to "$2"
}
blow=$(/usr/bin/python3 - "$one" <<'PY'
import sys
import h5py
t, c = (h5py.File(sys.argv[1], "r")["eventmill/collisions/" + k][...] for k in ("time", "class"))
k = t[(c == 3) & (t > 0.1)][0]
print(repr(float(k) - 1e-7), repr(float(k) + 1e-9))
PY
)
# shellcheck disable=SC2086 # two times
check "one collision tells no interval" rare $blow
nothing() { agrees "$one" '
assert any("nothing was counted between 0.2499999 s and 0.25 s" in n for n in result["notes"]), result["notes"]
' hist "$one" --class ball-blade --from 0.2499999; }
check "an empty window is told" nothing

level() { # the half width's key tells its level, and it is narrower
  local a
  a=$(post hist "$one" --from 0.1 --json) && post hist "$one" --from 0.1 --level 0.9 --json |
    /usr/bin/python3 -c 'import json, sys
wide, narrow = json.loads(sys.argv[1])["how_hard"][0], json.load(sys.stdin)["how_hard"][0]
assert narrow["median_ci90"] < wide["median_ci95"] and "median_ci95" not in narrow' "$a" &&
    post compare "$one" "$fast" --level 0.9 --csv | grep -q "_ci90" &&
    ! post compare "$one" "$fast" --level 0.9 --csv | grep -q "_ci95"
}
check "half widths are named by their level" level

for of in vt relative speed vx energy lost impact; do
  check "hist --of $of" post hist "$one" --of $of --from 0.05 --csv
done

heavy=$work/heavy.h5 swift=$work/swift.h5
cat >"$work/heavy.cfg" <<'CFG'
duration = 0.2;
gravity = "none";
chamber = { shape = "box"; size = [5.0, 5.0, 5.0]; };
balls = { count = 40; diameter = 0.5; density = 7850.0; speed = 2000.0; };
contact = { rule = "smooth"; normal = 0.9; };
record = { observables = 1000.0; histograms = 1000.0; };
CFG
run "$work/heavy.cfg" record.collisions=true -o "$heavy" >"$work/out" &&
  run "$work/heavy.cfg" -o "$swift" >"$work/out" &&
  run "$work/heavy.cfg" balls.speed=20000 duration=0.002 --json -o "$work/lossy.h5" >"$work/json"
is "heavy balls that are swift" 0 $?
check "of which mill run tells no median" is_true "$swift" 'assert result["median_vn"] is None, result'
strong() { # every value, of megajoules as well
  agrees "$heavy" "
c = h['eventmill/collisions']
m, vn, cls = h['particles/balls/mass'][...][0], c['vn'][...].astype(float), c['class'][...]
x = {'energy': 0.5 * np.where(cls == 0, m / 2, m) * vn ** 2, 'lost': c['dissipated'][...], 'vn': vn}['$1']
for k in range(3):
    often, hard, own = result['how_often'][k], result['how_hard'][k], x[cls == k]
    assert often['count'] == len(own) and abs(often['share'] - len(own) / len(x)) < 1e-9, often
    for key, q in (('q25', 25), ('median', 50), ('q75', 75)):
        assert abs(hard[key] / np.percentile(own, q, method='inverted_cdf') - 1) < 0.05, (key, hard)
    assert abs(hard['mean'] / np.mean(own, dtype=float) - 1) < 1e-9 and hard['highest'] == own.max()
    assert abs(often['share_above'] - np.mean(own > $2)) < 0.02, often
" hist "$heavy" --from 0 --of "$1" --above "$2"
}
check "hist of energies" strong energy 3e8
check "of losses" strong lost 1e8
check "of speeds" strong vn 1100
beyond() { # the online bins end at 1016 m/s
  agrees "$heavy" '
vn, cls = h["eventmill/collisions/vn"][...], h["eventmill/collisions/class"][...]
assert any("beyond 1016 m/s" in n for n in result["notes"]), result["notes"]
for k, (often, hard) in enumerate(zip(result["how_often"], result["how_hard"])):
    own = vn[cls == k] if k < 3 else vn
    assert often["count"] == len(own) and abs(often["share_above"] - np.mean(own > 900)) < 0.01, often
    assert hard["mean"] is None and hard["highest"] is None and hard["q90"] is None, hard
    assert (hard["median"] is None) == (np.mean(own > 1016) > 0.5) and hard["q25"] < 1016, hard
' hist "$swift" --from 0 --above 900 && agrees "$swift" '
assert result["classes"][0]["share_above"] is None, result' power "$swift" --from 0
}
check "what lies beyond the online bins is counted and not told" beyond

online() { # the same run with and without its table; the window is made of whole blocks
  local a b
  a=$(post hist "$one" --from 0.1 --to 0.2 --json) && b=$(post hist "$plain" --from 0.1 --to 0.2 --json) &&
    /usr/bin/python3 - "$a" "$b" <<'PY'
import json, sys
a, b = (json.loads(x) for x in sys.argv[1:])
for p, q in zip(a["how_often"], b["how_often"]):
    assert p["count"] == q["count"], (p, q)
for p, q in zip(a["how_hard"], b["how_hard"]):
    assert abs(p["median"] / q["median"] - 1) < 0.01
PY
}
check "online histograms tell the same as the table" online

brief() { # in a window shorter than a block, the blocks that it overlaps, and no others
  agrees "$plain" '
start, end = (h["eventmill/histogram/" + k][...] for k in ("start", "end"))
k = np.flatnonzero((start < 0.204) & (end > 0.202))
assert len(k) == 1 and result["from"] == start[k[0]] and result["to"] == end[k[0]], result
assert "whole blocks" in result["from_how"]
count = h["eventmill/histogram/counts"][k[0]].sum()
assert [c["count"] for c in result["how_often"] if c["class"] == "all"] == [count]
' hist "$plain" --from 0.202 --to 0.204
}
check "a window shorter than a block of histograms" brief
told() { post compare "$plain" "$fast" --from 0.202 --to 0.204 --json >"$work/json" &&
  grep -q '"plain": "0.202 … 0.204 s (as given); collisions 0.2 … 0.21 s' "$work/json"; }
check "compare tells from when to when collisions are counted" told
printf 'point,run\n1,plain.h5\n' >"$work/points.csv"
table() { agrees "$plain" '
row = result["runs"][0]
assert (row["from"], row["to"]) == (0.202, 0.204), row
assert (row["counted_from"], row["counted_to"]) == (0.2, 0.21), row
' table "$work/points.csv" --from 0.202 --to 0.204; }
check "so does table" table
names() { # one of Latin-1, one of characters that are cut at the 95th byte, one of four bytes each
  local latin=$work/m$'\xfc'hle.h5 long name
  long=$work/$(printf 'ä%.0s' {1..60}).h5 name=$work/𝄞.h5
  ln -f "$plain" "$latin" && ln -f "$plain" "$long" && ln -f "$plain" "$name" &&
    post compare "$plain" "$latin" "$long" "$name" --json >"$work/json" && is_true "$plain" '
assert "m\ufffdhle" in result and "ä" * 47 + "\ufffd" in result and "𝄞" in result, result'
}
check "JSON is UTF-8, whatever files are called" names
printf 'point,run\n1,plain.h5\n2,brief.h5\n3,none.h5\n' >"$work/mixed.csv"
brief_run() { run geometries/simoloyer-2l.cfg balls.count=100 duration=0.01 -o "$work/brief.h5" >"$work/out" &&
  agrees "$plain" '
assert [r["run"] for r in result["runs"]] == ["plain.h5"], result["runs"]
assert [n.split()[0] for n in result["notes"]] == ["1", "1"] and "over before 0.2 s" in result["notes"][1], result["notes"]
' table "$work/mixed.csv" --from 0.2; }
check "table leaves out runs that are over before its window" brief_run
expect 2 "ends in .h5" "table writes HDF5 alone" post table "$work/points.csv" -o "$work/points.png"
check "and leaves nothing else" test ! -e "$work/points.png"
printf '\357\273\277point,run\n1,plain.h5\n1,plain.h5\n' >"$work/marked.csv"
marked() { agrees "$plain" 'assert [p["runs"] for p in result["points"]] == [2], result' \
  table "$work/marked.csv" --of points; }
check "a mark of UTF-8 hides no column" marked
for keys in rpm,run nan,run run,run power,run rpm/s,run; do
  { [ $keys = nan,run ] && printf 'point,run\nnan,plain.h5\n' || printf '%s\n1,plain.h5\n' $keys; } >"$work/keys.csv"
  expect 2 "keys.csv: error" "points of $keys" post table "$work/keys.csv" --of points -o "$work/keys.h5"
  check "leave no file" test ! -e "$work/keys.h5"
done
check "all tables in one file" post table "$work/points.csv" -o "$work/points.h5"

speed() { agrees "$one" '
f = h["particles/balls"]
time = f["velocity/time"][...]
v = np.linalg.norm(f["velocity/value"][...][time >= 0.1], axis=2)
assert result["how_often"][0]["count"] == v.size
assert abs(result["how_hard"][0]["median"] / np.median(v) - 1) < 0.005
' hist "$one" --of speed --from 0.1; }
check "speeds of balls agree with numpy" speed

map_count() { agrees "$one" '
frames = np.sum(h["particles/balls/position/time"][...] >= 0.1)
assert sum(c["values"] for c in result["cells"]) == 2500 * frames
' map "$one" --cells sectors --of count --from 0.1; }
check "a map counts every ball of every frame" map_count

map_vn() { agrees "$one" '
w = (t >= result["from"]) & (t < result["to"])
vn = h["eventmill/collisions/vn"][...][w]
n = np.array([c["values"] for c in result["cells"]])
x = np.array([c["value"] or 0 for c in result["cells"]])
assert n.sum() == len(vn)
assert abs((n * x).sum() / vn.sum() - 1) < 1e-6
' map "$one" --cells rings --of vn --from 0.1; }
check "a map of v_n adds up" map_vn
map_speed() { agrees "$one" '
f = h["particles/balls"]
time = f["velocity/time"][...]
v = np.linalg.norm(f["velocity/value"][...][time >= 0.1], axis=2)
tubes, cells = result["tubes"], result["cells"]
assert sum(t["values"] for t in tubes) == v.size
assert abs(sum(t["values"] * t["value"] for t in tubes) / v.sum() - 1) < 1e-6
assert sum(c["relative_sigma"] is not None for c in cells) > 100
' map "$one" --cells sectors --sectors 100 --tubes 5 --slices 3 --of speed --from 0.1; }
check "tubes sum up their slices" map_speed
map_alike() { agrees "$one" '
half = [c["half"] / c["value"] for c in result["cells"] if c["half"] is not None and c["value"]]
assert len(half) > 100 and not any(0 < x < 1e-9 for x in half)
' map "$one" --cells rings --of count --from 0.24; }
check "the interval of counts that are alike is no rounding" map_alike
sigma() { agrees "$one" '
assert all(c["relative_sigma"] is None for c in result["cells"])
' map "$one" --cells sectors --from 0.1 "$@"; }
for of in count hits energy; do
  check "there is no spread of $of" sigma --of $of
done
check "there is no spread of a difference" sigma --of speed --minus "$fast"
script() { # PATTERN COMMAND...: is it in the script of the diagram?
  local pattern=$1
  shift
  post "$@" -o "$work/diagram.gp" && grep -q -- "$pattern" "$work/diagram.gp"
}
check "a map names its classes" script "· ball-ball, ball-blade" \
  map "$one" --cells sectors --of vn --class ball-ball,ball-blade
check "a histogram names its class" script "· ball-blade" hist "$one" --class ball-blade
check "a comparison names its class" script "balls of 5 mm · ball-blade" \
  hist "$one" "$plain" --class ball-blade
windows() { agrees "$one" '
assert [result[k] for k in ("from", "to", "minus_from", "minus_to")] == [0.1, 0.25, 0.1, 0.25], result
' map "$one" --minus "$fast" --cells rings --of count --from 0.1; }
check "a difference tells both windows" windows
run geometries/simoloyer-2l.cfg balls.count=100 chamber.length=0.14 duration=0.05 -o "$work/longer.h5" >"$work/out"
expect 2 "longer.h5: error: a drum of 0.146 × 0.14 m" "drums of two sizes" \
  post map "$one" --minus "$work/longer.h5" --cells rings --of count --from 0.01
check "a difference of two maps" post map "$one" --minus "$fast" --cells sectors --of speed --from 0.1

power() { agrees "$one" '
assert result["imbalance"] < 1e-9, result["imbalance"]
w = h["observables/blade_work/value"][...].sum(axis=1)
tt = h["observables/blade_work/time"][...]
k = tt >= result["from"] - 1e-12
assert abs(result["power"] / ((w[k][-1] - w[k][0]) / (tt[k][-1] - tt[k][0])) - 1) < 1e-9
assert abs(sum(b["power"] for b in result["blades"]) / result["power"] - 1) < 1e-9
assert [b["blade"] for b in result["blades"]] == list(range(h["observables/blade_work/value"].shape[1]))
' power "$one" --from 0.1; }
check "power agrees in all three ways" power
turning=$work/turning.h5
run geometries/ideal-gas.cfg balls.count=300 duration=0.05 chamber.rpm=300 contact.rule=reichardt2005 \
  contact.tangential=0.5 -o "$turning"
check "power of a turning drum is drawn" script "title 'drum'" power "$turning" --from 0
check "under its name" grep -q "Power of the drum and dissipation" "$work/diagram.gp"
against_time() { agrees "$one" '
curve = result["curve"]
mean = lambda key: sum(c[key] * (c["high"] - c["low"]) for c in curve) / (curve[-1]["high"] - curve[0]["low"])
for key in ("power_by_torque", "power_by_energy", "dissipated"):
    assert abs(mean(key) / result[key] - 1) < 1e-9, key
assert len(curve) == 60 and max(abs(c["difference"]) for c in curve) < 1e-9 * result["power"]
' power "$one" --from 0.1 --curve; }
check "power against time" against_time
uneven() { # more samples than are drawn, farther and farther apart
  run geometries/simoloyer-2l.cfg balls.count=50 duration=0.0903 record.observables=5000 -o "$work/uneven.h5"
  /usr/bin/python3 - "$work/uneven.h5" <<'PY' &&
import sys
import h5py
time = h5py.File(sys.argv[1], "r+")["observables/blade_work/time"]  # all observables share it
time[...] = time[...] * (time[...] + 0.0903)
PY
    post power "$work/uneven.h5" --from 0 --to 0.02 -o "$work/diagram.gp" && agrees "$work/uneven.h5" '
text = open("'"$work"'/diagram.gp").read()
tt = h["observables/blade_work/time"][...]
for name, key in (("$d0", "dissipated"), ("$d1", "power_by_torque")):
    rows = text.split(name + " << EOD\n")[1].split("EOD")[0].split("\n")
    low, energy = tt[0], 0.0
    for middle, power in (map(float, row.split()[:2]) for row in rows if row):
        energy += power * 2 * (middle - low)
        low = 2 * middle - low
    assert abs(low / tt[-1] - 1) < 1e-6, (low, tt[-1])
    assert abs(energy / (result[key] * (tt[-1] - tt[0])) - 1) < 1e-6, (key, energy)
' power "$work/uneven.h5" --from 0 --to 0.02
}
check "what is drawn of many samples is all of the work" uneven
between_samples() { # every 0.0025 s
  post power "$one" --above 2 --from 0.1012 --to 0.1987 >"$work/out" &&
    grep -q "told from 0.1025 s to 0.1975 s, between samples" "$work/out" &&
    diff <(grep '^ball-' "$work/out") <("$post" power "$one" --above 2 --from 0.1025 --to 0.1975 | grep '^ball-')
}
check "power is told of the time between samples, in all its parts" between_samples
check "power without a table" post power "$plain" --from 0.1
halves() { post power "$plain" --from 0.1 --csv >"$work/table" && grep -q '^# power_ci95 = [0-9.]* W$' "$work/table" &&
  ! grep -q '±' "$work/table"; }
check "CSV tells half widths by their keys, in its head as well" halves
check "steady" post steady "$one"

same() { agrees "$one" '
for f in result["figures"]:
    assert f["plain_change"] is None or abs(f["plain_change"]) < 0.02, f
    assert f["plain_significant"] != "yes", f
' compare "$one" "$plain" --from 0.1 --to 0.2; }
check "compare finds no difference between equals" same
faster() { agrees "$fast" '
f = {x["figure"].strip(): x for x in result["figures"]}
assert f["power of the blades"]["fast_significant"] == "yes"
assert f["power of the blades"]["fast_change"] > 0.3
' compare "$plain" "$fast" --from 0.1; }
check "compare finds that 1700 rpm takes more power than 1300" faster
check "compare draws" post compare "$plain" "$fast" "$one" --from 0.1 -o "$work/compare.png"
mkdir "$work/a" "$work/b"
cp "$plain" "$work/a/run.h5"
cp "$fast" "$work/b/run.h5"
keys() { # runs of one file name, and one that is called like a key
  cp "$plain" "$work/level.h5"
  (cd "$work" && post compare a/run.h5 b/run.h5 b/run.h5 level.h5 --json) | /usr/bin/python3 -c '
import json, sys
def unique(pairs):
    assert len({k for k, _ in pairs}) == len(pairs), pairs
    return dict(pairs)
result = json.load(sys.stdin, object_pairs_hook=unique)
assert "a/run" in result["figures"][0], result
keys = [f["key"] for f in result["figures"]]
assert len(set(keys)) == len(keys) and "median_vn_ball_ball" in keys
'
}
check "compare gives each run and each figure a key of its own" keys
check "scale" post scale "$plain" "$fast" --from 0.1

# Runs at two speeds, one of them with three seeds; one without gravity; one that was interrupted.
few=(geometries/simoloyer-2l.cfg balls.count=100 duration=0.06)
for point in 1000/1 1000/2 1000/3 1400/1 1900/1; do
  run "${few[@]}" rotor.rpm=${point%/*} seed=${point#*/} -o "$work/at-${point/\//-}.h5"
done >"$work/out"
run "${few[@]}" rotor.rpm=1200 gravity='"none"' -o "$work/afloat.h5" >"$work/out"
cp "$work/at-1400-1.h5" "$work/left.h5" && /usr/bin/python3 - "$work/left.h5" <<'PY'
import sys
import h5py, numpy as np
h5py.File(sys.argv[1], "r+")["eventmill"].attrs["end"] = np.bytes_("interrupted")
PY
is "runs to scale" 0 $?
scale() { (cd "$work" && post scale "$@" --match mean-speed --from 0.02 --json); }
order() {
  scale at-1000-1.h5 at-1000-2.h5 at-1000-3.h5 at-1400-1.h5 afloat.h5 >"$work/json" &&
    scale at-1000-3.h5 at-1400-1.h5 at-1000-3.h5 at-1000-1.h5 afloat.h5 at-1000-2.h5 >"$work/other" &&
    /usr/bin/python3 - "$work/json" "$work/other" <<'PY'
import json, sys
a, b = (json.load(open(x)) for x in sys.argv[1:])
assert a["groups"] == b["groups"] and a["target"] == b["target"], (a, b)
assert [g["runs"] for g in a["groups"]] == [4, 1], a["groups"]
values = [r["value"] for r in a["runs"] if r["rpm"] == 1000]
assert len(values) == 3 and abs(a["target"] / (sum(values) / 3) - 1) < 1e-12
assert not any("not done" in n for n in a["notes"])
PY
}
check "scale averages runs at one speed, and keeps unlike runs apart" order
# remedy.jam_within is less at 1900 rpm than at 1000.
alike() {
  scale at-1000-1.h5 at-1900-1.h5 >"$work/json" &&
    is_true "$one" 'assert [g["runs"] for g in result["groups"]] == [2], result["groups"]'
}
check "what follows from the speed parts no runs" alike
warned() { scale at-1000-1.h5 left.h5 | grep -q 'left is not done: interrupted'; }
check "scale warns of runs that are not done" warned
cp "$work/at-1900-1.h5" "$work/lazy.h5" && /usr/bin/python3 - "$work/lazy.h5" <<'PY'
import sys
import h5py
v = h5py.File(sys.argv[1], "r+")["observables/mean_speed/value"]
v[...] = 0.1 * v[...]
PY
twice() { # between the first two runs, and once more between the last two
  local runs=(at-1000-1.h5 at-1400-1.h5 lazy.h5) target
  scale "${runs[@]}" >"$work/json" &&
    target=$(/usr/bin/python3 -c 'import json, sys
a, b, c = (r["value"] for r in json.load(open(sys.argv[1]))["runs"])
assert c < a < b
print((a * b) ** 0.5)' "$work/json") &&
    scale "${runs[@]}" --target "$target" >"$work/json" && is_true "$one" '
assert 1000 < result["groups"][0]["speed"] < 1400, result["groups"]
assert any("more than one speed" in n for n in result["notes"]), result["notes"]'
}
check "scale says when it is reached twice" twice
sed '/^balls = {/,/^};/d' geometries/simoloyer-2l.cfg >"$work/kinds.cfg"
kinds() { # of the second, a ball weighs on average (50 · 6³ · 3000 + 50 · 5³ · 7850) / (100 · 5³ · 7850)
  echo 'balls = ({ count = 50; diameter = 0.006; density = 3000.0; }, { count = 50; diameter = 0.005; });' >>"$work/kinds.cfg" &&
    run "$work/kinds.cfg" duration=0.06 -o "$work/kinds.h5" >"$work/out" &&
    scale at-1000-1.h5 kinds.h5 >"$work/json" && is_true "$one" '
name, rule = (result["groups"][1][key] for key in ("group", "rule"))
assert name == "50 balls of 6 mm, 3000 kg/m³ and 50 balls of 5 mm, 7850 kg/m³, drum 146 mm", name
assert abs(rule - 1000 * (0.5 * (1.2 ** 3 * 3000 / 7850 + 1)) ** -0.5) < 1e-6, rule'
}
check "scale tells all species of a group" kinds

# ---------------------------------------------------------------- tables
printf 'point,repeat,seed,run\n1,1,1979500123,at-1000-1.h5\n2,1,7,at-1400-1.h5\n' >"$work/points.csv"
expect 0 "" "a table" post table "$work/points.csv"
check "has seeds to the last digit" grep -q ' 1979500123 ' "$work/out"
expect 2 "$work: error: cannot be read: Is a directory" "a table of a directory" post table "$work"

expect 0 "" "verify accepts an ideal gas" post verify "$gas"
expect 0 "" "verify says that a mill is no ideal gas" post verify "$one"
grep -q "a rotor drives the balls" "$work/out"
is "and says why" 0 $?
expect 3 "" "verify refutes a mill when told to look anyway" post verify "$one" --anyway --from 0.05
tamper() { # CODE that changes a copy of the gas
  cp "$gas" "$work/wrong.h5" && /usr/bin/python3 - "$work/wrong.h5" <<PY
import sys
import h5py, numpy as np
h = h5py.File(sys.argv[1], "r+")
v, e = h["particles/balls/velocity/value"], h["eventmill/collisions/normal"]
$1
PY
}
verdict() { # VERDICT CODE RUN ...: exit code 0 says that the laws hold
  local verdict=$1 code=$2 expected=3
  shift 2
  [ "$verdict" = holds ] && expected=0
  post verify "$@" --json >"$work/json"
  [ $? -eq $expected ] && is_true "$gas" "assert result['verdict'].split(':')[0] == '$verdict', result
$code"
}
ball=$work/ball.h5 drop=$work/drop.h5 loop=$work/loop.h5 cradle=$work/cradle.h5
free=$work/free.h5 drift=$work/drift.h5 no_balls=$work/no-balls.h5 spin=$work/spin.h5
handful=$work/handful.h5 slit=$work/slit.h5
cat >"$work/loop.cfg" <<'CFG'
duration = 2.0;
gravity = [0.0, 0.0, -9.81];
chamber = { shape = "box"; size = [0.05, 0.05, 0.05]; periodic = [true, true, true]; };
balls = { count = 150; diameter = 0.003; density = 7850.0; start = "uniform"; speed = 1.0; };
contact = { rule = "smooth"; normal = 1.0; };
record = { frames = 50.0; observables = 100.0; };
CFG
run geometries/bouncing-ball.cfg contact.normal=1 duration=2 -o "$ball" >"$work/out" &&
  run geometries/ideal-gas-gravity.cfg balls.count=300 balls.speed=0 duration=1 -o "$drop" >"$work/out" &&
  run "$work/loop.cfg" -o "$loop" >"$work/out" &&
  run geometries/newtons-cradle.cfg -o "$cradle" >"$work/out" &&
  run "$work/loop.cfg" gravity='"none"' balls.count=50 balls.diameter=0.006 duration=8 -o "$free" >"$work/out" &&
  run "$work/loop.cfg" balls.count=0 duration=0.1 -o "$no_balls" >"$work/out" &&
  run "$work/loop.cfg" gravity='"none"' chamber.periodic=false balls.count=30 balls.diameter=0.01 \
    duration=100 -o "$handful" >"$work/out" &&
  run "$work/loop.cfg" gravity='"none"' chamber.periodic='[true,true,false]' balls.count=60 \
    balls.diameter=0.008 duration=60 -o "$slit" >"$work/out" &&
  /usr/bin/python3 - "$free" "$work/drift.txt" <<'PY' &&
import sys
import h5py, numpy as np
balls = h5py.File(sys.argv[1], "r")["particles/balls"]
r, v = (balls[k + "/value"][-1] for k in ("position", "velocity"))
np.savetxt(sys.argv[2], np.hstack([np.mod(r, 0.05), v + [1.0, 0.0, 0.5]]), fmt="%.17g")
np.savetxt(sys.argv[2] + ".spin", np.hstack([np.mod(r, 0.05), v, 400.0 * v]), fmt="%.17g")
PY
  run "$work/loop.cfg" gravity='"none"' balls.count=50 balls.diameter=0.006 balls.start=table \
    balls.table="$work/drift.txt" duration=8 -o "$drift" >"$work/out" &&
  run "$work/loop.cfg" gravity='"none"' balls.count=50 balls.diameter=0.006 balls.start=table \
    balls.table="$work/drift.txt.spin" duration=8 record.collisions=true -o "$spin" >"$work/out"
is "runs that keep their energy" 0 $?
kept='assert result["energy_drift"] < 1e-12, result'
check "a ball that bounces from rest keeps its energy" verdict undecided "$kept" "$ball" --from 0
check "a gas that falls from rest does" verdict holds "$kept" "$drop" --from 0.5
check "where it falls for ever, energy is not tested" verdict holds '
assert result["energy_drift"] is None and any("periodic boundary" in n for n in result["notes"])' "$loop"
heat='
speed = result["laws"][0]
assert abs(result["kt"] / result["kt_frames"] - 1) < 1e-9, result
assert abs(speed["fitted"] / speed["predicted"] - 1) < 1e-6, speed'
check "without walls, the centre of mass has no heat" verdict holds "$heat" "$free"
check "nor has a gas that drifts" verdict holds "$heat" "$drift"
spinning="$heat"'
laws = [law["quantity"] for law in result["laws"]]
assert not any("relative" in q or "impact parameter" in q for q in laws), laws
assert any("relative speeds and impact parameters need not hold" in n for n in result["notes"])'
check "nor have spins that smooth balls keep" verdict holds "$spinning" "$spin"
run geometries/ideal-gas.cfg chamber.length=0.034 balls.count=250 balls.diameter=0.01 duration=2 \
  -o "$work/flat.h5" >"$work/out"
check "a flat drum has no places beyond the layers at its ends" verdict holds '
assert any("along the axis; 0 values" in n for n in result["notes"]), result["notes"]' "$work/flat.h5"
run geometries/simoloyer-2l.cfg rotor.rpm=0 gravity='"none"' contact.rule=smooth contact.normal=1 balls.count=300 \
  duration=3 record.frames=50 record.observables=100 record.collisions=true -o "$work/still.h5" >"$work/out"
check "blades at rest have layers of balls around them" verdict holds '
assert not any("impact points on the balls" in law["quantity"] for law in result["laws"]), result["laws"]
assert any("layers around blades" in n for n in result["notes"]), result["notes"]' "$work/still.h5"
check "30 balls tell no law, however long" verdict undecided '
assert result["verdict"].endswith("too few balls") and result["tests"] == 0, result' "$handful"
check "60 tell as many values as their law is that of many" verdict holds '
assert [law["values"] for law in result["laws"][:2]] == [360, 360], result["laws"]' "$slit"
expect 2 "no balls to verify" "a run without balls" post verify "$no_balls"
lossless() { agrees "$gas" 'assert result["imbalance"] < 1e-12, result' power "$gas"; }
check "power of a gas without losses is balanced" lossless
nothing() { agrees "$gas" '
assert result["dissipated"] == 0 and all(c["dissipated"] == 0 for c in result["classes"]), result
' power "$gas" && agrees "$gas" '
energy = [i for i in result["indicators"] if i["indicator"].strip() == "kinetic energy"][0]
assert energy["found"] == "yes", energy
' steady "$gas" && agrees "$gas" '
assert all(not t["value"] for t in result["tubes"]), result["tubes"]
' map "$gas" --cells sectors --of lost && agrees "$gas" '
assert all(row["highest"] == row["q25"] == 0 for row in result["how_hard"]), result["how_hard"]
assert not result["notes"], result["notes"]' hist "$gas" --of lost; }
check "which loses nothing, and not what rounding leaves" nothing
check "five balls tell no law" verdict undecided 'assert result["tests"] == 0' "$cradle" --from 0
check "verify names the laws that it cannot test" verdict holds '
untested = [n for n in result["notes"] if n.startswith("Not tested: ")]
assert len(untested) == result["untested"] > 0 and any("v_n at ball-end" in n for n in untested), untested
' "$gas" --to 0.9
expect 2 "until 0.01 s there are" "a window that is too short" post verify "$gas" --to 0.01
tamper 'x = v[...]; x[:, :, 0] *= 1.04; v[...] = x'
expect 3 "" "verify catches one component that is too fast" post verify "$work/wrong.h5"
tamper 'x = e[...]; x[:, 0] += 0.2; e[...] = x / np.linalg.norm(x, axis=1)[:, None]'
expect 3 "" "verify catches impact points pulled to one side" post verify "$work/wrong.h5"
tamper 'd = h["eventmill/collisions/dissipated"]; x = d[...]; x[:100] = -1.0; d[...] = x'
gains() { agrees "$gas" '
assert any(": 100 of " in n and "lie below 0 J" in n for n in result["notes"]), result["notes"]
' hist "$work/wrong.h5" --of lost --from 0; }
check "hist tells on which side of the bins contacts lie that gain energy" gains

/usr/bin/python3 -c '
import random
random.seed(3)
print("speed, restitution")
for _ in range(240):
    v = random.uniform(0.1, 50)
    print(v, 0.985 / (v + 0.9494) ** 0.291 + random.gauss(0, 0.01), sep=", ")' >"$work/shots.csv"
fit() { agrees "$one" '
p = {x["name"]: x for x in result["parameters"] if x["law"] == "spahn"}
for name, truth in (("A", 0.985), ("B", 0.9494), ("C", 0.291)):
    assert abs(p[name]["value"] - truth) < 4 * p[name]["error"], p[name]
assert result["ranking"][0]["law"] in ("spahn", "power4")
' fit "$work/shots.csv"; }
check "fit recovers a law" fit
snippet() { # what it prints is a valid entry of a scene
  post fit "$work/shots.csv" --json | /usr/bin/python3 -c 'import json, sys
print(json.load(sys.stdin)["scene"])' >"$work/law.cfg" &&
    { grep -v '^contact' geometries/ideal-gas.cfg | cat - "$work/law.cfg" >"$work/scene.cfg"; } &&
    "$mill" check "$work/scene.cfg"
}
check "and its scene entry is accepted" snippet

/usr/bin/python3 -c '
for k in range(60):
    v = 0.1 * 1.11 ** k
    print("%.15g %.15g" % (v, 0.35 + 0.65 * (1 + v ** 1.2) ** -0.6))' >"$work/exact.txt"
power4() { agrees "$one" '
p = {x["name"]: x["value"] for x in result["parameters"] if x["law"] == "power4"}
assert result["best"] == "power4"
for name, truth in (("A", 1.0), ("B", 1.2), ("C", 0.6), ("D", 0.35)):
    assert abs(p[name] - truth) < 1e-6, p
' fit "$work/exact.txt"; }
check "fit finds all four parameters of power4" power4
{ printf '\357\273\277' && sed "1s/\$/ # $(printf '%1100s' '1.5 1.4')/" "$work/exact.txt"; } >"$work/marked.txt"
marked() { agrees "$one" 'assert result["pairs"] == 60 and result["ranking"][0]["sigma"] < 1e-9, result' \
  fit "$work/marked.txt"; }
check "a mark of UTF-8 hides no pair, and a long comment adds none" marked
for k in 1 2 3 4 5 6 7 8; do echo "2.0, 0.7$k"; done >"$work/same.csv"
same() { agrees "$one" '
e = {(x["law"], x["name"]): x["error"] for x in result["parameters"]}
assert e["constant", "epsilon"] > 0
assert ("salo", "c") in e and not {"spahn", "power2", "power4", "exponential"} & {law for law, _ in e}, e
' fit "$work/same.csv"; }
check "one speed does not determine three parameters" same
accepted() { # LAW VALUE: the best law, which a scene takes
  agrees "$one" "
assert result['best'] == '$1' and '$2' in result['scene'], result" fit "$work/odd.csv" &&
    /usr/bin/python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["scene"])' "$work/json" >"$work/odd.cfg" &&
    grep -v "^contact" "$work/loop.cfg" >>"$work/odd.cfg" && "$mill" check "$work/odd.cfg"
}
for e in 1.02 1.01 1.0 0.99 1.01 1.02 1.0 1.01; do echo "$((++k)), $e"; done >"$work/odd.csv"
check "no constant above 1" accepted constant "epsilon = 1.0"
for e in 1.4 1.4 1.4 1.4 1.4 1.4 1.4 1.4; do echo "$((++k)), $e"; done >"$work/odd.csv"
check "nor of what gains energy alone" accepted constant "epsilon = 1.0"
is "and no other law" 1 "$(/usr/bin/python3 -c 'import json, sys
print(len(json.load(open(sys.argv[1]))["ranking"]))' "$work/json")"
for e in 1 1 1 1 1 1 1 1; do echo "$((++k)), $e"; done >"$work/odd.csv"
whole() { agrees "$one" '
best = result["ranking"][0]
assert best["law"] == "constant" and best["delta_aic"] == 0 and best["aic"] < -500, best' fit "$work/odd.csv"; }
check "pairs without any scatter have a criterion" whole
for e in .50 .52 .55 .60 .68 .74 .83 .90 .97 1; do echo "$((++k)), $e"; done >"$work/odd.csv"
rising() { agrees "$one" '
assert result["best"] == "constant", result
assert not {"power2", "exponential"} & {x["law"] for x in result["ranking"]}, result' fit "$work/odd.csv"; }
check "of what rises, no law that ends as the constant" rising

for to in xdmf xdmf3 vtk lammps csv pov stl; do
  check "export --to $to" post export "$one" --to $to --every 25 -o "$work/export.$to"
done
members() { # of a collection, whose name XML would read otherwise
  post export "$one" --to vtk --every 25 -o "$work/a&b <\"c\">.pvd" && /usr/bin/python3 - "$work" <<'PY'
import os, sys, xml.etree.ElementTree as tree
names = [x.get("file") for x in tree.parse(sys.argv[1] + '/a&b <"c">.pvd').iter("DataSet")]
assert names and all(os.path.exists(os.path.join(sys.argv[1], n)) for n in names), names
PY
}
check "a VTK collection finds its files, whatever its name" members
if command -v povray >"$work/where"; then
  check "POV-Ray at one moment" post export "$one" --to pov --at 0.2 -o "$work/one.pov"
  check "which renders" bash -c "cd '$work' && povray -D +W96 +H54 +Ione.pov +Oone.png && test -s one.png"
else
  skip "POV-Ray renders" "no povray"
fi
check "export of collisions" post export "$one" --to csv --of collisions -o "$work/rows.csv"
piped() { # a pipe is written to, and stays
  mkfifo "$work/pipe" && { timeout 30 cat "$work/pipe" >"$work/piped.csv" & } &&
    post export "$one" --to csv --of collisions -o "$work/pipe" && wait &&
    cmp "$work/piped.csv" "$work/rows.csv" && [ -p "$work/pipe" ]
}
check "the same through a pipe" piped
rows() { [ "$(wc -l <"$work/rows.csv")" -eq $(($(post info "$one" --csv | sed -n 's/^# rows = //p') + 1)) ]; }
check "with a line for each" rows
third=$work/third.h5
run geometries/bouncing-ball.cfg duration=0.1 record.frames=30 -o "$third" >"$work/out"
at() { # WANTED OPTION ...: times of the frames, as printed
  post export "$third" --to csv "${@:2}" -o "$work/third.csv" >"$work/out" &&
    [ "$(cut -d, -f1 "$work/third.csv" | sed 1d | uniq | xargs)" = "$1" ]
}
check "the frame nearest to a time" at 0.0333333333 --at 0.0333
check "times as they are printed" at "0.0333333333 0.0666666667" --from 0.0333333333 --until 0.0666666667
check "from a time that was rounded up" at "0.0666666667 0.1" --from 0.0666666667
check "until one that was rounded down" at "0 0.0333333333" --until 0.0333333333
expect 2 "frames from 0 to 0.25 s" "export beyond the end" post export "$one" --to csv --at 99 -o "$work/x.csv"
expect 2 "frames from 0 to 0.25 s" "export before the begin" post export "$one" --to csv --at -99 -o "$work/x.csv"
expect 2 "no frame is chosen" "export of no frame" post export "$one" --to stl --from 99 -o "$work/x.csv"
expect 2 "choose frames" "export of collisions at a moment" \
  post export "$one" --to csv --of collisions --at 0.1 -o "$work/x.csv"
expect 2 "choose frames" "export of every tenth collision" \
  post export "$one" --to csv --of collisions --every 10 -o "$work/x.csv"
expect 2 "no collision is chosen" "export of no collision" \
  post export "$one" --to csv --of collisions --from 10 -o "$work/x.csv"
check "which leave nothing" test ! -e "$work/x.csv"
dump() { [ "$(grep -c 'ITEM: TIMESTEP' "$work/export.lammps")" -eq 3 ] &&
  [ "$(wc -l <"$work/export.lammps")" -eq $((3 * 2513)) ]; }
check "a LAMMPS dump has all balls" dump

facets=$work/facets.h5
run geometries/ideal-gas.cfg balls.count=1000 balls.diameter=0.008 duration=2 record.frames=50 \
  chamber.facets=3 -o "$facets"
box() { agrees "$facets" '
r = h["particles/balls/position/value"][...]
low = h["particles/balls/box/offset"][...]
high = low + h["particles/balls/box/edges"][...]
assert np.all(r > low) and np.all(r < high) and np.hypot(r[..., 0], r[..., 2]).max() > 0.1
' info "$facets"; }
check "the box of a run holds the corners of facets" box
solid() { # all balls are within the surface
  post export "$facets" --to stl -o "$work/facets.stl" && /usr/bin/python3 - "$facets" "$work/facets.stl" <<'PY'
import sys
import h5py, numpy as np
r = h5py.File(sys.argv[1])["particles/balls/position/value"][...].reshape(-1, 3)
one = np.dtype([("n", "<f4", 3), ("p", "<f4", (3, 3)), ("rest", "<u2")])
stl = np.frombuffer(open(sys.argv[2], "rb").read()[84:], one)
assert abs(stl["p"][..., 2].min() + 0.146) < 1e-6
for n, p in zip(stl["n"], stl["p"]):
    assert ((r - p[0]) @ n).min() > 0.004 - 1e-6
PY
}
check "the STL surface has the facets" solid
check "POV-Ray has them" post export "$facets" --to pov --at 0.2 -o "$work/facets.pov"
check "as prisms" grep -q "prism {.*, 4,$" "$work/facets.pov"
expect 2 "3 facets" "no map of a drum with facets" post map "$facets" --cells rings
expect 0 "" "verify of a drum with facets" post verify "$facets"
check "tests no places" grep -q "laws of places need not hold here: the drum has facets" "$work/out"

expect 2 "" "no command" post
expect 2 "" "unknown command" post frobnicate
expect 2 "" "unknown option" post hist "$one" --frobnicate
expect 2 "" "no run" post hist
expect 2 "" "unknown quantity" post hist "$one" --of frobs
expect 2 "" "unknown class" post hist "$one" --class ball-frob
expect 2 "" "not a number" post hist "$one" --from never
expect 2 "" "an empty window" post hist "$one" --from 3
expect 2 "" "a quantity that needs the table" post hist "$plain" --of vt
expect 2 "" "cells of no kind" post map "$one" --cells cubes
expect 2 "balls have none" "classes of a count" post map "$one" --cells rings --of count --class ball-ball
expect 2 "balls have none" "classes of speeds" post hist "$one" --of speed --class ball-ball
for of in count hits energy; do
  expect 2 "expected a mean" "the spread of $of" post map "$one" --cells rings --of $of --spread
done
expect 2 "goes with neither" "the spread of a difference" \
  post map "$one" --cells rings --of vn --spread --minus "$fast"
expect 2 "of --cells sectors" "slices of rings" post map "$one" --cells rings --slices 5
expect 2 "of --cells rings" "rings of sectors" post map "$one" --cells sectors --rings 50
expect 2 "" "a map of a box" post map "$gas" --cells rings --slices 0
expect 2 "nowhere.h5: error" "a run that is not there" post info "$work/nowhere.h5"
echo "this is no run" >"$work/text.h5"
for command in info hist verify power steady frame film view "map --cells rings" "export --to csv" "compare $one" "scale $one"; do
  # shellcheck disable=SC2086
  expect 2 "text.h5: error" "${command%% *} of a file that is no run" post $command "$work/text.h5"
done
expect 2 "nowhere.txt: error" "pairs that are not there" post fit "$work/nowhere.txt"
expect 2 "nowhere.csv: error" "points that are not there" post table "$work/nowhere.csv"
head -c 20000 "$one" >"$work/short.h5"
expect 2 "" "a truncated run" post hist "$work/short.h5"
limited() { (ulimit -f 8; "$post" "$@"); }
expect 1 "cannot be written" "a table over the limit of files" limited export "$one" --to csv --of collisions \
  -o "$work/limit.csv"
check "which leaves nothing" bash -c "! compgen -G '$work/limit*'"
cp "$one" "$work/own.h5"
expect 2 "would replace the run itself" "an export over its run" post export "$work/own.h5" --to csv -o "$work/own.h5"
check "which stays" cmp -s "$one" "$work/own.h5"
expect 1 "" "a picture that cannot be written" post hist "$one" -o "$work/no/where.png"
full() { post hist "$one" >/dev/full; }
expect 1 "" "a full disk" full
full() { post info "$one" --scene >/dev/full; }
expect 1 "cannot write the output" "a full disk for a scene" full
printf '1 0.9\n2 zero\n' >"$work/bad.txt"
expect 2 "" "a table with a bad line" post fit "$work/bad.txt"
grep -q "bad.txt:2: error" "$work/err"
is "which names the line" 0 $?
printf '1 0.9x\n%s' "$(cat "$work/exact.txt")" >"$work/bad.txt"
expect 2 "bad.txt:1: error" "a first line that is no heading" post fit "$work/bad.txt"

finish
