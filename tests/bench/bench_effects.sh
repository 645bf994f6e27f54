#!/bin/sh
# Instructions per collision and bytes per ball, effect by effect, counted by callgrind: the same on
# every run. The rotor's and gravity's own functions show whether an absent effect is really absent.
set -eu
mill=${BUILD:-build}/mill
command -v valgrind >/dev/null || { echo 'valgrind is missing' >&2; exit 1; }
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

# count NAME SCENE [KEY=VALUE ...]
count() {
  name=$1 scene=$folder/$2
  shift 2
  valgrind --tool=callgrind --callgrind-out-file="$folder/out" \
    --toggle-collect=em_world_run_collisions "$mill" run "$scene" "$@" duration=0.02 \
    record.frames=0.0 record.observables=0.0 record.histograms=0.0 -o none --json -q \
    >"$folder/json" 2>/dev/null
  collisions=$(sed 's/.*"collisions":\([0-9]*\).*/\1/' "$folder/json")
  instructions=$(sed -n 's/^totals: //p' "$folder/out")
  bytes=$("$mill" check "$scene" "$@" | sed -n 's/^# balls: .*, \([0-9]*\) bytes each.*/\1/p')
  loop=$("$mill" check "$scene" "$@" | sed -n 's/^# loop: //p')
  calls=''
  for f in em_surface_blade em_surface_drum em_surface_plane em_contact_restitution; do
    grep -q "^c\{0,1\}fn=([0-9]*) $f" "$folder/out" && calls="$calls ${f#em_}"
  done
  echo "$name|$collisions|$instructions|$bytes|$loop|$calls" |
    awk -F'|' '{ printf "%-34s %8d %9.1f %6d  %-28s%s\n", $1, $2, $3 / $2, $4, $5, $6 }'
}

printf '%-34s %8s %9s %6s  %-28s%s\n' scene collided 'instr./c' B/ball loop ' calls of'
count 'mill, full physics' mill.cfg
count '  without gravity' mill.cfg gravity=none
count '  smooth: without spin' mill.cfg contact.rule=smooth
count '  constant restitution' mill.cfg contact.normal=0.95
count '  blades without tips' mill.cfg rotor.tip=none
count '  accuracy fast' mill.cfg engine.accuracy=fast
count '  collision table (no file)' mill.cfg record.collisions=true
count 'gas in a drum' gas.cfg
count '  again' gas.cfg
count '  with gravity' gas.cfg 'gravity=[0,0,-9.81]'
count '  with spin' gas.cfg contact.rule=rough
count '  with falling restitution' gas.cfg contact.normal=spahn
count '  with TC' gas.cfg remedy.tc=1e-6
count '  drum of 64 facets' gas.cfg chamber.facets=64
count 'gas in a periodic box' box.cfg
