#!/bin/sh
# Instructions per collision and bytes per ball, effect by effect, counted by callgrind between two
# times, so that the start does not count: the same on every run. A scene that calls a function of an
# effect that it does without makes the bench fail.
#
#   FROM=0.01 TO=0.04   simulated times (s)
set -eu
mill=${BUILD:-build}/mill
command -v valgrind >/dev/null || { echo 'valgrind is missing (scripts/setup bench)' >&2; exit 1; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

gas='chamber = { shape = "drum"; diameter = 0.146; length = 0.135; };
balls = { count = 1500; diameter = 0.005; };
contact = { rule = "smooth"; normal = 1.0; };
gravity = "none";'
box='chamber = { shape = "box"; size = [0.13, 0.13, 0.13]; periodic = true; };
balls = { count = 1500; diameter = 0.005; };
contact = { rule = "smooth"; normal = 1.0; };
gravity = "none";'
printf '%s\n' "$gas" >"$folder/gas.cfg"
printf '%s\n' "$box" >"$folder/box.cfg"
sed 's/ 3500;/ 1500;/' geometries/simoloyer-2l.cfg >"$folder/mill.cfg"

bad=0
blades='em_surface_blade em_surface_blade_normal em_surface_roots_blade'
quartic='em_poly_quartic em_poly_first_rise'
table='em_writer_contact'

# measure DURATION SCENE [KEY=VALUE ...]: sets collisions and instructions.
measure() {
  duration=$1
  shift
  valgrind --tool=callgrind --callgrind-out-file="$folder/out" \
    --toggle-collect=em_world_run_collisions "$mill" run "$@" duration="$duration" \
    record.frames=0.0 record.observables=0.0 record.histograms=0.0 -o none --json -q \
    >"$folder/json" 2>/dev/null
  collisions=$(sed 's/.*"collisions":\([0-9]*\).*/\1/' "$folder/json")
  instructions=$(sed -n 's/^totals: //p' "$folder/out")
}

# count NAME SCENE ABSENT [KEY=VALUE ...]: ABSENT: functions that must not be called.
count() {
  name=$1 scene=$folder/$2 absent=$3
  shift 3
  measure "${FROM:-0.01}" "$scene" "$@"
  before="$collisions|$instructions"
  measure "${TO:-0.04}" "$scene" "$@"
  bytes=$("$mill" check "$scene" "$@" | sed -n 's/^# balls: .*, \([0-9]*\) bytes each.*/\1/p')
  loop=$("$mill" check "$scene" "$@" | sed -n 's/^# loop: //p')
  calls=''
  for f in $absent; do
    grep -q "^c\{0,1\}fn=([0-9]*) $f" "$folder/out" && calls="$calls $f" && bad=1
  done
  echo "$name|$before|$collisions|$instructions|$bytes|$loop|$calls" |
    awk -F'|' '{ printf "%-34s %8d %9.1f %6d  %-28s%s\n", $1, $4 - $2, ($5 - $3) / ($4 - $2), $6, $7, $8 }'
}

printf '%-34s %8s %9s %6s  %-28s%s\n' scene collided 'instr./c' B/ball loop ' calls in vain'
count 'mill, full physics' mill.cfg "$table"
count '  accuracy fast' mill.cfg "$table" engine.accuracy=fast
count '  without gravity' mill.cfg "$quartic $table" gravity=none
count '  smooth: without spin' mill.cfg em_contact_spin_factor contact.rule=smooth
count '  constant restitution' mill.cfg "pow" contact.normal=0.95
count '  blades without tips' mill.cfg "$table" rotor.tip=none
count 'gas in a drum' gas.cfg "$blades $quartic $table"
count '  again' gas.cfg "$blades $quartic $table"
count '  with gravity' gas.cfg "$blades $table" 'gravity=[0,0,-9.81]'
count '  with spin' gas.cfg "$blades $quartic" contact.rule=rough
count '  with falling restitution' gas.cfg "$blades $quartic" contact.normal=spahn
count '  with TC' gas.cfg "$blades $quartic" remedy.tc=1e-6
count '  drum of 64 facets' gas.cfg "$blades $quartic em_surface_drum" chamber.facets=64
count 'gas in a periodic box' box.cfg "$blades $quartic em_surface_drum em_surface_plane"
[ $bad -eq 0 ] || echo 'bench_effects: an absent effect is paid for' >&2
exit $bad
