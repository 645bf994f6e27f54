#!/bin/bash
# millpost verify over many gases: each law's p-values are uniform themselves, and gases that are wrong
# on purpose are caught. SEEDS=100 by default, from FIRST=1 on; about 6 s of computing each.
#
# Uniform: Kolmogorov-Smirnov of a series of p-values gives a p of its own. Of 31 right series, one is
# below 0.01 by chance in 27 of 100 tests. So all series together are judged at 1 %: none below
# 0.01/31, and at most two below 0.01 (more has a chance of 0.4 %).
set -u
cd "$(dirname "$0")/../.." || exit 2
case ${BUILD:-build} in /*) build=$BUILD ;; *) build=$PWD/${BUILD:-build} ;; esac
seeds=${SEEDS:-100} first=${FIRST:-1}
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT

gas() { # FILE SEED KEY=VALUE ...
  local file=$1 seed=$2
  shift 2
  "$build/mill" run geometries/ideal-gas.cfg balls.count=4000 duration=1.6 seed="$seed" \
    record.collisions=true record.frames=100 record.compression=0 "$@" -o "$file" --quiet --force \
    >/dev/null
}
tamper() { # FROM TO CODE
  cp "$1" "$2" && /usr/bin/python3 - "$2" <<PY
import sys
import h5py, numpy as np
h = h5py.File(sys.argv[1], "r+")
v, e = h["particles/balls/velocity/value"], h["eventmill/collisions/normal"]
$3
PY
}
caught() { # FILE NAME: counts a refusal
  "$build/millpost" verify "$1" >/dev/null
  [ $? -eq 3 ] && echo "$2" >>"$work/caught"
}

touch "$work/caught" "$work/accepted"
for seed in $(seq "$first" $((first + seeds - 1))); do
  gas "$work/gas.h5" "$seed" || exit 1
  "$build/millpost" verify "$work/gas.h5" --json >"$work/json.$seed" && echo yes >>"$work/accepted"
  tamper "$work/gas.h5" "$work/wrong.h5" 'x = v[...]; x[:, :, 0] *= 1.02; v[...] = x'
  caught "$work/wrong.h5" component
  tamper "$work/gas.h5" "$work/wrong.h5" \
    'x = e[...]; x[:, 0] += 0.1; e[...] = x / np.linalg.norm(x, axis=1)[:, None]'
  caught "$work/wrong.h5" points
  gas "$work/wrong.h5" "$seed" contact.normal=0.999 || exit 1
  "$build/millpost" verify "$work/wrong.h5" --anyway >/dev/null
  [ $? -eq 3 ] && echo restitution >>"$work/caught"
done

/usr/bin/python3 - "$work" "$seeds" "$first" <<'PY'
import json, math, sys

folder, seeds, first = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
series = {}


def collect(node, name=""):
    if isinstance(node, dict):
        name = node.get("quantity", name)
        for key, value in node.items():
            if key.startswith("p_") and isinstance(value, (int, float)):
                series.setdefault(f"{name}, {key}", []).append(value)
            else:
                collect(value, name)
    elif isinstance(node, list):
        for item in node:
            collect(item, name)


for k in range(first, first + seeds):
    collect(json.load(open(f"{folder}/json.{k}")))


def kolmogorov(p):  # p-value of the largest distance from uniform
    p, n = sorted(p), len(p)
    d = max(max((i + 1) / n - x, x - i / n) for i, x in enumerate(p))
    t = d * (math.sqrt(n) + 0.12 + 0.11 / math.sqrt(n))
    return max(0.0, min(1.0, 2 * sum((-1) ** (k - 1) * math.exp(-2 * (k * t) ** 2)
                                     for k in range(1, 101))))


number, failed = 0, 0


def verdict(good, text):
    global number, failed
    number += 1
    failed += not good
    print("ok" if good else "not ok", number, "-", text)


verdict(len(series) >= 20, f"{len(series)} series of p-values")
small = []
for name, p in sorted(series.items()):
    value = kolmogorov(p)
    if value < 0.01:
        small.append(name)
    verdict(value > 0.01 / len(series) and len(p) == seeds,
            f"{name}: {len(p)} p-values, KS p {value:.4f}")
verdict(len(small) <= 2, f"{len(small)} of them below 0.01 {small or ''}")
lines = open(folder + "/caught").read().split()
for name in ("component", "points", "restitution"):
    n = lines.count(name)
    verdict(n >= 0.95 * seeds, f"wrong {name}: {n} of {seeds} caught")
n = len(open(folder + "/accepted").read().split())
verdict(n >= 0.95 * seeds, f"right gases: {n} of {seeds} accepted")
sys.exit(failed > 0)
PY
