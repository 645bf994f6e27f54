#!/bin/bash
# millpost as its users run it: figures against an independent computation with h5py and numpy, laws
# that hold and laws that are broken on purpose, exports, bad input.
# shellcheck disable=SC2317 # functions are called by name
set -u
cd "$(dirname "$0")/../.." || exit 2
case ${BUILD:-build} in /*) build=$BUILD ;; *) build=$PWD/${BUILD:-build} ;; esac
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
number=0 failed=0

verdict() { # STATUS TEXT
  number=$((number + 1))
  if [ "$1" -eq 0 ]; then echo "ok $number - $2"; else echo "not ok $number - $2" && failed=1; fi
}
try() { # TEXT COMMAND...
  local text=$1
  shift
  "$@" >"$work/out" 2>"$work/err"
  local status=$?
  [ $status -eq 0 ] || head -5 "$work/err" | sed 's/^/# /'
  verdict $status "$text"
}
exits() { # CODE TEXT COMMAND...
  local code=$1 text=$2
  shift 2
  "$@" >"$work/out" 2>"$work/err"
  local status=$?
  [ $status -eq "$code" ] || echo "# exit code $status, expected $code: $(head -3 "$work/err")"
  [ $status -eq "$code" ]
  verdict $? "$text"
}
post() { "$build/millpost" "$@"; }
run() { "$build/mill" run "$@" --quiet --force; }
check() { # python code with `result` (parsed JSON of the command's output), h (h5py file)
  local file=$1 code=$2
  shift 2
  post "$@" --json >"$work/json" || return 1
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
mill=$work/mill.h5 plain=$work/plain.h5 fast=$work/fast.h5 gas=$work/gas.h5
run geometries/simoloyer-2l.cfg "${settings[@]}" record.collisions=true \
  record.frames=200 record.observables=400 record.histograms=100 -o "$mill" &&
  run geometries/simoloyer-2l.cfg "${settings[@]}" record.histograms=100 \
    record.collisions=false -o "$plain" &&
  run geometries/simoloyer-2l.cfg "${settings[@]}" rotor.rpm=1700 \
    record.collisions=false -o "$fast" &&
  run geometries/ideal-gas.cfg balls.count=1000 duration=4 record.collisions=true \
    record.frames=20 -o "$gas"
verdict $? "runs to look at"

for command in info hist map verify power steady compare scale fit frame film export; do
  try "help of $command" post "$command" --help
done
try "help" post --help
try "version" post --version

info() { check "$mill" '
assert result["seed"] == h["eventmill"].attrs.get("seed", result["seed"])
assert result["collisions"] == len(t) == result["rows"]
assert sum(c["count"] for c in result["collisions_by_class"]) <= len(t)
' info "$mill"; }
try "info counts what the file holds" info

hist() { check "$mill" '
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
    assert hard["median_ci95"] > 0
' hist "$mill" --from 0.1 --above 1.5; }
try "hist agrees with numpy" hist

for of in vt relative speed vx energy lost impact; do
  try "hist --of $of" post hist "$mill" --of $of --from 0.05 --csv
done

online() { # the same run with and without its table; the window is made of whole blocks
  local a b
  a=$(post hist "$mill" --from 0.1 --to 0.2 --json) && b=$(post hist "$plain" --from 0.1 --to 0.2 --json) &&
    /usr/bin/python3 - "$a" "$b" <<'PY'
import json, sys
a, b = (json.loads(x) for x in sys.argv[1:])
for p, q in zip(a["how_often"], b["how_often"]):
    assert p["count"] == q["count"], (p, q)
for p, q in zip(a["how_hard"], b["how_hard"]):
    assert abs(p["median"] / q["median"] - 1) < 0.01
PY
}
try "online histograms tell the same as the table" online

speed() { check "$mill" '
f = h["particles/balls"]
time = f["velocity/time"][...]
v = np.linalg.norm(f["velocity/value"][...][time >= 0.1], axis=2)
assert result["how_often"][0]["count"] == v.size
assert abs(result["how_hard"][0]["median"] / np.median(v) - 1) < 0.005
' hist "$mill" --of speed --from 0.1; }
try "speeds of balls agree with numpy" speed

map_count() { check "$mill" '
frames = np.sum(h["particles/balls/position/time"][...] >= 0.1)
assert sum(c["values"] for c in result["cells"]) == 2500 * frames
' map "$mill" --cells sectors --of count --from 0.1; }
try "a map counts every ball of every frame" map_count

map_vn() { check "$mill" '
w = (t >= result["from"]) & (t < result["to"])
vn = h["eventmill/collisions/vn"][...][w]
n = np.array([c["values"] for c in result["cells"]])
x = np.array([c["value"] or 0 for c in result["cells"]])
assert n.sum() == len(vn)
assert abs((n * x).sum() / vn.sum() - 1) < 1e-6
' map "$mill" --cells rings --of vn --from 0.1; }
try "a map of v_n adds up" map_vn
try "a difference of two maps" post map "$mill" --minus "$fast" --cells sectors --of speed --from 0.1

power() { check "$mill" '
assert result["imbalance"] < 1e-9, result["imbalance"]
w = h["observables/blade_work/value"][...].sum(axis=1)
tt = h["observables/blade_work/time"][...]
k = tt >= result["from"] - 1e-12
assert abs(result["power"] / ((w[k][-1] - w[k][0]) / (tt[k][-1] - tt[k][0])) - 1) < 1e-9
assert abs(sum(b["power"] for b in result["blades"]) / result["power"] - 1) < 1e-9
' power "$mill" --from 0.1; }
try "power agrees in all three ways" power
try "power without a table" post power "$plain" --from 0.1
try "steady" post steady "$mill"

same() { check "$mill" '
for f in result["figures"]:
    assert f["plain_change"] is None or abs(f["plain_change"]) < 0.02, f
    assert f["plain_significant"] != "yes", f
' compare "$mill" "$plain" --from 0.1 --to 0.2; }
try "compare finds no difference between equals" same
faster() { check "$fast" '
f = {x["figure"].strip(): x for x in result["figures"]}
assert f["power of the blades"]["fast_significant"] == "yes"
assert f["power of the blades"]["fast_change"] > 0.3
' compare "$plain" "$fast" --from 0.1; }
try "compare finds that 1700 rpm takes more power than 1300" faster
try "scale" post scale "$plain" "$fast" --from 0.1

exits 0 "verify accepts an ideal gas" post verify "$gas"
exits 0 "verify says that a mill is no ideal gas" post verify "$mill"
grep -q "a rotor drives the balls" "$work/out"
verdict $? "and says why"
exits 3 "verify refutes a mill when told to look anyway" post verify "$mill" --anyway --from 0.05
tamper() { # CODE that changes a copy of the gas
  cp "$gas" "$work/wrong.h5" && /usr/bin/python3 - "$work/wrong.h5" <<PY
import sys
import h5py, numpy as np
h = h5py.File(sys.argv[1], "r+")
v, e = h["particles/balls/velocity/value"], h["eventmill/collisions/normal"]
$1
PY
}
tamper 'x = v[...]; x[:, :, 0] *= 1.04; v[...] = x'
exits 3 "verify catches one component that is too fast" post verify "$work/wrong.h5"
tamper 'x = e[...]; x[:, 0] += 0.2; e[...] = x / np.linalg.norm(x, axis=1)[:, None]'
exits 3 "verify catches impact points pulled to one side" post verify "$work/wrong.h5"

/usr/bin/python3 -c '
import random
random.seed(3)
print("speed, restitution")
for _ in range(240):
    v = random.uniform(0.1, 50)
    print(v, 0.985 / (v + 0.9494) ** 0.291 + random.gauss(0, 0.01), sep=", ")' >"$work/shots.csv"
fit() { check "$mill" '
p = {x["name"]: x for x in result["parameters"] if x["law"] == "spahn"}
for name, truth in (("A", 0.985), ("B", 0.9494), ("C", 0.291)):
    assert abs(p[name]["value"] - truth) < 4 * p[name]["error"], p[name]
assert result["ranking"][0]["law"] in ("spahn", "power4")
' fit "$work/shots.csv"; }
try "fit recovers a law" fit
snippet() { # what it prints is a valid entry of a scene
  post fit "$work/shots.csv" --json | /usr/bin/python3 -c 'import json, sys
print(json.load(sys.stdin)["scene"])' >"$work/law.cfg" &&
    { grep -v '^contact' geometries/ideal-gas.cfg | cat - "$work/law.cfg" >"$work/scene.cfg"; } &&
    "$build/mill" check "$work/scene.cfg"
}
try "and its scene entry is accepted" snippet

for to in xdmf xdmf3 vtk lammps csv pov stl; do
  try "export --to $to" post export "$mill" --to $to --every 25 -o "$work/export.$to"
done
try "export of collisions" post export "$mill" --to csv --of collisions -o "$work/rows.csv"
rows() { [ "$(wc -l <"$work/rows.csv")" -eq $(($(post info "$mill" --csv | sed -n 's/^# rows = //p') + 1)) ]; }
try "with a line for each" rows
dump() { [ "$(grep -c 'ITEM: TIMESTEP' "$work/export.lammps")" -eq 3 ] &&
  [ "$(wc -l <"$work/export.lammps")" -eq $((3 * 2513)) ]; }
try "a LAMMPS dump has all balls" dump

exits 2 "no command" post
exits 2 "unknown command" post frobnicate
exits 2 "unknown option" post hist "$mill" --frobnicate
exits 2 "no run" post hist
exits 2 "unknown quantity" post hist "$mill" --of frobs
exits 2 "unknown class" post hist "$mill" --class ball-frob
exits 2 "not a number" post hist "$mill" --from never
exits 2 "an empty window" post hist "$mill" --from 3
exits 2 "a quantity that needs the table" post hist "$plain" --of vt
exits 2 "cells of no kind" post map "$mill" --cells cubes
exits 2 "a map of a box" post map "$gas" --cells rings --slices 0
exits 1 "a run that is not there" post info "$work/nowhere.h5"
echo "this is no run" >"$work/text.h5"
exits 1 "a file that is no run" post hist "$work/text.h5"
head -c 20000 "$mill" >"$work/short.h5"
exits 1 "a truncated run" post hist "$work/short.h5"
exits 1 "a picture that cannot be written" post hist "$mill" -o "$work/no/where.png"
full() { post hist "$mill" >/dev/full; }
exits 1 "a full disk" full
printf '1 0.9\n2 zero\n' >"$work/bad.txt"
exits 2 "a table with a bad line" post fit "$work/bad.txt"
grep -q "bad.txt:2: error" "$work/err"
verdict $? "which names the line"

echo "1..$number"
exit $failed
