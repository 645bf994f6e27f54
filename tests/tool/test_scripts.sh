#!/bin/bash
# Scripts around sweeps and programs, which take long: the arithmetic and the paths of theirs, with
# stand-ins for what they run.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh
mkdir "$work/clone" && cp -R scripts "$work/clone/scripts"
scripts=$work/clone/scripts
cd "$work" || exit 2

# ---------------------------------------------------------------- calibrate
# R1 and R2 are met at 5.5 mm; the sweep has done the radii in the order of its list.
cat >"$scripts/sweep" <<'E2'
#!/bin/sh
echo "$*" >sent
E2
cat >"$scripts/collect" <<'E2'
#!/bin/sh
awk -F, -v OFS=, 'NR == 1 { print "rotor.rpm,rotor.tip,rotor.radius [m],median_speed [m/s],median_speed_ci95"; next }
  { d = 1000 * $5 - 5.5; print $1, $4, $5, ($1 == 1300 ? 1.8186 : 1.2) + 0.1 * d, 0.01 }' "$1/list.csv" >"$1/mean.csv"
E2
best() { sed -n '/^best/,$s/^none *//p' out; }
expect 0 "" "calibrate" "$scripts/calibrate" --tips none --radii 0.004,0.005,0.006 -o sorted
is "finds the radius between the runs" "5.50 1.8186 1.2000 0.00" "$(best | xargs)"
expect 0 "" "with the radii in another order" \
  "$scripts/calibrate" --tips none --radii 0.006,0.004,0.005 --on slurm -o unsorted
is "as well" "5.50 1.8186 1.2000 0.00" "$(best | xargs)"
check "on Slurm it waits for the runs" grep -q -- "--on slurm --wait" sent

# ---------------------------------------------------------------- reproduce-report
mkdir -p build elsewhere report/{gas,gas-gravity}/runs
echo '{"energy_error": 3e-16}' >report/gas/runs/a.json
echo '{"energy_error": 2e-9}' >report/gas-gravity/runs/a.json
printf '#!/bin/sh\n' | tee build/mill >build/millpost
chmod +x build/mill build/millpost
expect 0 "" "a report" env BUILD="$work/build" "$scripts/reproduce-report" report
is "judges errors of the energy" "3.0e-16 | agrees, no jumps; 2.0e-09 | above rounding" \
  "$(sed -n 's/^| R12 .* gravity | \(.*\) | –.*/\1/p' out | paste -sd';' | sed 's/;/; /')"

# ---------------------------------------------------------------- demo
# shellcheck disable=SC2016 # the stand-in's own
printf '#!/bin/sh\nwhile [ $# -gt 1 ]; do [ "$1" != -o ] || echo film >"$2"; shift; done\n' | tee build/mill >build/millpost
chmod +x build/mill build/millpost
expect 0 "" "demo" env -C elsewhere BUILD="$work/build" "$scripts/demo" "my films"
check "writes where the user stands" test -s "elsewhere/my films/demo.mp4"
finish
