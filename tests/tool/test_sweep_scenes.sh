#!/bin/bash
# What a sweep takes: scenes with includes and files, folders of any name, values in any order, other
# seeds; and what it refuses.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh
export BUILD=$bin
scripts=$PWD/scripts sweep=$PWD/scripts/sweep
command -v parallel >/dev/null || { skip "sweeps" "GNU parallel is not installed"; finish; }
cd "$work" || exit 2

cat >gas.cfg <<'E'
gravity = "none";
chamber = { shape = "box"; size = [0.1, 0.1, 0.1]; periodic = true; };
balls = { count = 20; diameter = 0.005; start = "uniform"; speed = 1.0; };
contact = { rule = "smooth"; normal = 1.0; };
E
gas=("$work/gas.cfg" duration=0.01 -q -j1)
column() { # FILE KEY
  awk -F, -v key="$2" '/^#/ { next } !at { for (k = 1; k <= NF; k++) if ($k == key) at = k; next }
    { print $at }' "$1"
}
lines() { grep -vc '^#' "$1"; }

# ---------------------------------------------------------------- names of folders
odd="it's a \$HOME \"place\""
mkdir "$odd"
cp gas.cfg "$odd/my scene.cfg"
cd "$odd" || exit 2
expect 0 "" "a folder with blanks and quotes in its name" \
  "$sweep" "my scene.cfg" balls.count=10,20 duration=0.01 -q -j1 -o "my sweep"
is "has its runs" 3 "$(lines "my sweep/table.csv")"
cd "$work" || exit 2
mkdir "a clone"
cp -R "$scripts" "a clone/scripts"
expect 0 "" "scripts in such a folder" "a clone/scripts/sweep" "${gas[@]}" balls.count=10,20 -o clone

# A job array, as far as it can be told without Slurm: sbatch runs the first task at once.
mkdir fake
printf '#!/bin/sh\nSLURM_ARRAY_TASK_ID=0; export SLURM_ARRAY_TASK_ID\n%s\n' \
  'case " $* " in *--wrap*) for last; do :; done; sh -c "$last" ;; *) for last; do :; done; sh "$last" ;; esac
echo 1' >fake/sbatch
printf '#!/bin/sh\n' >fake/squeue
cp fake/squeue fake/scontrol
chmod +x fake/*
PATH=$PWD/fake:$PATH expect 0 "" "its task finds its way there" \
  "a clone/scripts/sweep" "${gas[@]}" balls.count=10,20 --chunk 2 --on slurm --wait -o "$odd/array"
is "as does the job for the tables" 3 "$(lines "$odd/array/table.csv")"

# ---------------------------------------------------------------- what a run tells
expect 0 "" "a sweep" "$sweep" "${gas[@]}" balls.count=10,20 -o told
run=$(ls told/runs/count-10_*.h5)
rm "${run%.h5}.json"
mkdir "${run%.h5}.lock"
expect 1 "$(basename "$run" .h5).lock" "a run that cannot begin says why" \
  "$sweep" "${gas[@]}" balls.count=10,20 --retries 0 -o told
rmdir "${run%.h5}.lock"

# ---------------------------------------------------------------- damage
expect 0 "" "it is tried again" "$sweep" "${gas[@]}" balls.count=10,20 -o told
cp told/table.csv sound.csv
head -c 3000 "$run" >short && mv short "$run"
expect 1 "$(basename "$run") is damaged" "a finished file that is damaged is told" \
  "$sweep" "${gas[@]}" balls.count=10,20 -o told
expect 0 "" "and begun anew" "$sweep" "${gas[@]}" balls.count=10,20 -o told
check "with the same table" cmp sound.csv told/table.csv

# ---------------------------------------------------------------- other seeds
expect 0 "" "another base seed" "$sweep" "${gas[@]}" balls.count=10,20 --seed 9 -o told
is "has runs of its own" 4 "$(ls told/runs/*.h5 | wc -l)"
"$post" info "told/$(column told/table.csv run | head -n 1)" --scene >made.cfg
is "the table tells their seeds, in full" "$(sed -n 's/^seed = \([0-9]*\).*/\1/p' made.cfg)" \
  "$(column told/table.csv seed | head -n 1)"

# ---------------------------------------------------------------- scenes
place='the "scene"'
mkdir "$place"
cat >"$place"/scene.cfg <<'E'
/* what is not there:
@include "nothing.cfg"
*/
  @include "gas.cfg" duration = 0.02;
E
sed 's/start = .*/start = "table"; table = "rows.txt"; };/; s/count = 20; //' gas.cfg >"$place"/gas.cfg
printf '0.02 0.02 0.02 1 0 0\n0.07 0.02 0.02 -1 0 0\n' >"$place"/rows.txt
expect 0 "" "a scene with an include and a table" "$sweep" "$place/scene.cfg" balls.diameter=0.004,0.005 \
  record.frames=100 -q -j1 -o closed
is "all of it counts" "0.02 0.02" "$(column closed/table.csv 'simulated_time [s]' | xargs)"
expect 2 "goes without KEY=VALUE" "mill check --joined prints what is written" \
  "$mill" check --joined "$place/scene.cfg" duration=1
echo '@include "loop.cfg"' >loop.cfg
expect 2 "nested too deeply" "a scene that includes itself" "$sweep" loop.cfg balls.count=1,2 -o loop

# The balls of a run that lies beside the scene.
cp "$(ls closed/runs/*.h5 | head -n 1)" "$place/before.h5"
sed -i 's/start = .*/start = "run"; from = "before.h5"; count = 2; diameter = 0.004; };/; s/diameter = 0.005; //' \
  "$place/gas.cfg"
expect 0 "" "a scene that goes on from a run" "$sweep" "$place/scene.cfg" contact.normal=0.9,1 -q -j1 -o from

# ---------------------------------------------------------------- values
law=(contact.normal=spahn contact.normal.A=0.9)
expect 0 "" "fixed values are set in their order" \
  "$sweep" "${gas[@]}" "${law[@]}" gravity=none balls.count=10,20 -o order
expect 0 "" "that order may change where it means the same" \
  "$sweep" "${gas[@]}" gravity=none "${law[@]}" balls.count=10,20 -o order
expect 2 "another folder" "but not where it does not" \
  "$sweep" "${gas[@]}" gravity=none contact.normal=0.9 balls.count=10,20 -o order
expect 2 "balls.count is given twice" "the same axis twice" \
  "$sweep" "${gas[@]}" balls.count=10,20 balls.count=30,40 -o no
expect 2 "balls.count has a fixed value and is an axis" "an axis and a fixed value" \
  "$sweep" "${gas[@]}" balls.count=10,20 balls.count=30 -o no
printf 'balls.count\n10\n20\n' >list
expect 2 "balls.count has a fixed value and is an axis" "a list and a fixed value" \
  "$sweep" "${gas[@]}" --list list balls.count=30 -o no
expect 2 "lhs must be at least 1" "a hypercube without points" \
  "$sweep" "${gas[@]}" balls.count=10:20 --lhs 0 -o no
expect 2 "j must be at least 1" "no run at a time" "$sweep" "${gas[@]}" balls.count=10,20 -j 0 -n -o no
check "leave nothing" test ! -e no

# ---------------------------------------------------------------- help
for script in "$scripts"/*; do
  case $script in *.sh | *.awk) continue ;; esac
  check "$(basename "$script") --help" bash -c 'timeout 20 "$1" --help | grep -q Usage' - "$script"
done
finish
