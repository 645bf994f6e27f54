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
mkdir T=3
cp gas.cfg T=3/gas.cfg
expect 0 "" "a folder with a value in its name" "$sweep" T=3/gas.cfg balls.count=10,20 duration=0.01 -q -o T=3/s
expect 0 "" "goes on" "$sweep" T=3/gas.cfg balls.count=10,20 duration=0.01 -q -o T=3/s
expect 0 "" "its tables" "$scripts/collect" T=3/s
is "have its runs" 3 "$(lines T=3/s/table.csv)"
expect 0 "" "its runs" "$scripts/run-point" T=3/s "$(column ./T=3/s/points.csv run | head -n 1)"
expect 0 "" "its diagrams" "$scripts/plot-lines" T=3/s median_speed -o T=3/speed.gp
is "have its points" 2 "$(grep -cE '^1,[12]0,' T=3/speed.gp)"
mkdir "a clone"
cp -R "$scripts" "a clone/scripts"
expect 0 "" "scripts in such a folder" "a clone/scripts/sweep" "${gas[@]}" balls.count=10,20 -o clone

# A job array, as far as it can be told without Slurm: sbatch runs the first task at once.
mkdir fake
printf '#!/bin/sh\nSLURM_ARRAY_TASK_ID=0; export SLURM_ARRAY_TASK_ID\n%s\n' \
  'echo "$*" >>"$SENT"; case " $* " in *--wrap*) for last; do :; done; sh -c "$last" ;; *) for last; do :; done; sh "$last" ;; esac
echo 1' >fake/sbatch
printf '#!/bin/sh\n' >fake/scontrol
cat >fake/squeue <<'E'
#!/bin/sh
echo "$*" >>"$SENT.asked"
[ ! -e "$SENT.down" ] || { rm "$SENT.down"; echo "slurm_load_jobs error: Unable to contact slurm controller" >&2; exit 1; }
[ -z "$QUEUE" ] || echo "$QUEUE"
E
chmod +x fake/*
export QUEUE='' SENT=$PWD/sent
PATH=$PWD/fake:$PATH expect 0 "" "its task finds its way there" \
  "a clone/scripts/sweep" "${gas[@]}" balls.count=10,20 --chunk 2 --on slurm --wait -o "$odd/array"
is "as does the job for the tables" 3 "$(lines "$odd/array/table.csv")"

rm sent.asked
touch sent.down
PATH=$PWD/fake:$PATH expect 0 "" "a queue that does not answer" \
  "$sweep" "${gas[@]}" balls.count=10,20 --on slurm --chunk 2 --wait -o down
is "is asked again" 3 "$(lines sent.asked)"
touch sent.down
PATH=$PWD/fake:$PATH expect 1 "contact slurm controller: if job 1 of this sweep is over, delete" \
  "before there is another job" "$sweep" "${gas[@]}" balls.count=10,20,30 --on slurm -o down

replaced="{} 100%d"
PATH=$PWD/fake:$PATH expect 0 "" "a folder named like what Slurm and GNU parallel replace" \
  "$sweep" "${gas[@]}" balls.count=10 --chunk 1 --on slurm --wait -o "$replaced"
check "its log" grep -qF -- "--output=$PWD/{} 100%%d/slurm-%A.log" sent
expect 0 "" "the same, locally" "$sweep" "${gas[@]}" balls.count=10,20 -o "$replaced"
is "has its runs" 3 "$(lines "$replaced/table.csv")"

mkdir another
printf '#!/bin/sh\necho "parallel: invalid option" >&2; exit 1\n' >another/parallel
chmod +x another/parallel
PATH=$PWD/another:$PATH expect 1 "is it GNU parallel?" "another program of that name" \
  "$sweep" "${gas[@]}" balls.count=10,20 -o another/s

# ---------------------------------------------------------------- one at a time
# What is refused changes nothing: rows that wait in a queue or go on keep their meaning.
cp "$replaced/points.csv" points
PATH=$PWD/fake:$PATH QUEUE=1 expect 1 "job 1 of this sweep is still in the queue" "an array in the queue" \
  "$sweep" "${gas[@]}" balls.count=5,10,20 --on slurm -o "$replaced"
PATH=$PWD/fake:$PATH QUEUE=1 expect 1 "still in the queue" "nor is it run locally" \
  "$sweep" "${gas[@]}" balls.count=5,10,20 -o "$replaced"
expect 1 "another sweep is at work" "a folder in which another sweep works" \
  flock "$replaced/lock" "$sweep" "${gas[@]}" balls.count=5,10,20 -o "$replaced"
check "stays as it is" cmp points "$replaced/points.csv"
expect 1 "has no run 1" "runs are known by their names" "$scripts/run-point" "$replaced" 1
run=$(cd "$replaced" && ls runs/count-10_*.h5)
touch "$replaced/${run%.h5}.lock"
expect 0 "" "a run that another process has finished" "$scripts/run-point" "$replaced" "$run"
check "leaves no lock" test ! -e "$replaced/${run%.h5}.lock"

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

# ---------------------------------------------------------------- tables
for option in --json "--of runs" "-o x.csv" --above; do
  # shellcheck disable=SC2086 # a word and its value
  expect 2 "unexpected\|missing" "collect $option" "$scripts/collect" told $option
done
check "they spoil no table" cmp sound.csv told/table.csv
"$scripts/collect" told 2>other &
check "two collections at a time" "$scripts/collect" told --from 0
wait $!
is "both end well" 0 $?
is "leave the tables" "mean.csv points.csv provenance.csv table.csv table.h5" \
  "$(cd told && echo *.csv* table*h5* | xargs -n 1 | sort | xargs)"

# A sweep that is being extended: one run is as long as asked for, the other is not yet.
expect 0 "" "a sweep" "$sweep" "${gas[@]}" balls.count=10,20 -o longer
echo duration=0.02 >>longer/fixed
expect 0 "" "goes on" "$scripts/run-point" longer "$(column longer/points.csv run | head -n 1)"
expect 0 "" "meanwhile tables" "$scripts/collect" longer
is "hold the finished run" 0.02 "$(column longer/table.csv 'simulated_time [s]')"
check "and tell of the other" grep -q '^# 1 runs are missing or not finished' longer/mean.csv
expect 2 "runs of 0.02 s, which can only grow" "a shorter duration" \
  "$sweep" "${gas[@]}" balls.count=10,20 -o longer
check "is refused" grep -qx duration=0.02 longer/fixed

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

echo '0.05 0.07 0.02 -1 0 0' >>"$place"/rows.txt
expect 2 'scene"/rows.txt is not what it was' "a table that has changed since" \
  "$sweep" "$place/scene.cfg" balls.diameter=0.004,0.005,0.006 record.frames=100 -q -j1 -o closed
(cat gas.cfg; echo 'duration = 0.01;') >grows.cfg
expect 0 "" "a scene with its duration" "$sweep" grows.cfg balls.count=10,20 -q -j1 -o grown
sed -i 's/duration = 0.01/duration = 0.02/' grows.cfg
expect 0 "" "which grows" "$sweep" grows.cfg balls.count=10,20 -q -j1 -o grown
is "makes longer runs" "0.02 0.02" "$(column grown/table.csv 'simulated_time [s]' | xargs)"

# The balls of a run that lies beside the scene.
cp "$(ls closed/runs/*.h5 | head -n 1)" "$place/before.h5"
sed -i 's/start = .*/start = "run"; from = "before.h5"; count = 2; diameter = 0.004; };/; s/diameter = 0.005; //' \
  "$place/gas.cfg"
expect 0 "" "a scene that goes on from a run" "$sweep" "$place/scene.cfg" contact.normal=0.9,1 -q -j1 -o from
check "the file is noted" grep -q 'before.h5$' from/files
for from in before.h5 before.h5,after.h5; do
  expect 2 "must be absolute" "not $from" "$sweep" "$place/scene.cfg" "balls.from=$from" -q -o no
done

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
printf 'seed,balls.count\n5,10\n' >list
expect 2 "seeds come from the points" "seeds in a list" "$sweep" "${gas[@]}" --list list -o no
expect 2 "values of rotor.rpm: 9.99e+11, expected at most" "a slip in a step" \
  "$sweep" "${gas[@]}" rotor.rpm=1:1e-9:1000 -o no
expect 0 "" "values that differ late" \
  "$sweep" "${gas[@]}" contact.normal=0.9,0.90000000001,0.900,9e-1 -n -o no
is "are two points" "0.9 0.90000000001" "$(sed -n 's/.*normal-\(.*\)_.*/\1/p' out | xargs)"
expect 2 "seen in ten digits" "steps that are too fine" "$sweep" "${gas[@]}" contact.normal=0.9:1e-11:0.90000000003 -o no
expect 2 "runs: 1000002, expected at most" "too many repeats" \
  "$sweep" "${gas[@]}" balls.count=10,20 --repeat 500001 -o no
printf '\xef\xbb\xbf"balls.count","contact.normal"\r\n10,1   # a comment\r\n"20","1"\r\n' >list
expect 0 "count-10_normal-1_.*h5" "a list from a spreadsheet" bash -c '"$@" -n >&2' - "$sweep" "${gas[@]}" --list list -o no
expect 2 "KEY=LOW:1:HIGH" "whole numbers in a hypercube" "$sweep" "${gas[@]}" balls.count=10:20 --lhs 3 -o no
expect 2 "lhs must be at least 1" "a hypercube without points" \
  "$sweep" "${gas[@]}" balls.count=10:20 --lhs 0 -o no
expect 2 "j must be at least 1" "no run at a time" "$sweep" "${gas[@]}" balls.count=10,20 -j 0 -n -o no
check "leave nothing" test ! -e no

# ---------------------------------------------------------------- languages
if localedef -i de_DE -f UTF-8 "$work/de_DE.UTF-8" 2>/dev/null; then
  comma=(env LOCPATH="$work" LC_ALL=de_DE.UTF-8)
  expect 0 "" "where a half is 0,5" "${comma[@]}" "$sweep" "${gas[@]}" contact.normal=0.9,1 -o comma
  expect 0 "" "a longer duration goes on" \
    "${comma[@]}" "$sweep" "${gas[@]}" contact.normal=0.9,1 duration=0.02 -o comma
  is "to that duration" "0.02 0.02" "$(column comma/table.csv 'simulated_time [s]' | xargs)"
  "${comma[@]}" "$scripts/plot-lines" comma median_speed -o comma.gp
  is "diagrams have points" "" "$(sed -n 's/^set yrange.*,.*/&/p' comma.gp)"
else
  skip "where a half is 0,5" "there is no such locale"
fi

# ---------------------------------------------------------------- help
for script in "$scripts"/*; do
  case $script in *.sh | *.awk) continue ;; esac
  check "$(basename "$script") --help" bash -c 'timeout 20 "$1" --help | grep -q Usage' - "$script"
done
finish
