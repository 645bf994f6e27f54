#!/bin/bash
# Diagrams of sweeps: which axes they take, words, a third axis, intervals, titles. The tables are
# written here, so that nothing has to be simulated.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh
lines=$PWD/scripts/plot-lines map=$PWD/scripts/plot-map
cd "$work" || exit 2

# make_sweep NAME KEYS <ROWS: a sweep of which only the tables are there. A row has the values of the
# keys, the power and its half width.
make_sweep() {
  mkdir -p "$1"
  echo 'title = "as in the scene";' >"$1/scene.cfg"
  : >"$1/fixed"
  echo "point,repeat,seed,run,$2" >"$1/points.csv"
  { echo "# level = 0.95"; echo "point,$2,power [W],power_ci95 [W]"; awk '{ print NR "," $0 }'; } >"$1/mean.csv"
}
make_sweep two rotor.rpm,balls.count <<'END'
1000,40,10,90
1000,60,20,1
1300,40,50,
1300,60,60,2
END
make_sweep words contact.rule,rotor.rpm <<'END'
rough,1000,1,0.1
smooth,1000,2,0.1
rough,1300,3,0.1
smooth,1300,4,0.1
END
make_sweep laws contact.normal <<'END'
spahn,1,0.1
0.9,2,0.1
salo,3,0.1
END
make_sweep three rotor.rpm,balls.count,balls.diameter <<'END'
1000,40,0.004,1,0.1
1000,60,0.004,2,0.1
1300,40,0.004,3,0.1
1300,60,0.004,4,0.1
1000,40,0.005,5,0.1
1000,60,0.005,6,0.1
1300,40,0.005,7,0.1
1300,60,0.005,8,0.1
END
make_sweep nought remedy.tc,rotor.rpm <<'END'
0,1000,1,0.1
0,1300,2,0.1
1e-05,1000,3,0.1
1e-05,1300,4,0.1
END
# Scattered; the figure depends on the second axis alone, which spans less than the first by 1e4.
make_sweep scattered rotor.rpm,contact.tangential < <(awk 'BEGIN { srand(2)
  for (k = 0; k < 30; k++) { e = 0.8 + 0.1 * rand(); print 1000 + 1000 * rand() "," e "," sin(60 * e) ",0" } }')
curves() { grep -c '^\$d[0-9]* <<' "$1"; }
rows() { awk -v d="\$d$2" '$1 == d { on = 1; next } /^EOD/ { on = 0 } on' "$1"; }

# ---------------------------------------------------------------- which axes
check "x, when the curves are by the first axis" "$lines" two power --by rotor.rpm -o a.gp
is "is the second" "2 curves over number of balls" "$(curves a.gp) curves over $(sed -n \
  "s/^set xlabel '\(.*\)' noenh.*/\1/p" a.gp)"
check "curves by an axis that begins at 0" "$lines" nought power --by remedy.tc -o a.gp
is "are all there" 2 "$(curves a.gp)"
expect 2 "both rotor.rpm" "one axis twice" "$lines" two power -x rotor.rpm --by rotor.rpm -o x.gp
expect 2 "both rotor.rpm" "and on a map" "$map" two power -x rotor.rpm -y rotor.rpm -o x.gp
expect 2 "found 'impact'" "two figures" "$lines" two power impact -o x.gp
expect 2 "found 'impact'" "and on a map" "$map" two power impact -o x.gp
expect 2 "whole number above 0" "a number of contours that is none" "$map" two power --contours abc -o x.gp
expect 2 "no axis that is left" "a condition on the only axis" "$lines" laws power --where contact.normal=0.9 -o x.gp
expect 2 "expected KEY=VALUE" "a condition without a value" "$lines" two power --where rotor.rpm -o x.gp

# ---------------------------------------------------------------- words
check "curves by words" "$lines" words power -x rotor.rpm --by contact.rule -o a.gp
is "are one for each word" "2 1000 1300" "$(curves a.gp) $(rows a.gp 0 | cut -d, -f2 | tr '\n' ' ' | sed 's/ $//')"
check "words on the x axis" "$lines" laws power -o a.gp
is "are its tics" "set xtics ('salo' 1, 'spahn' 2, '0.9' 3) noenhanced" "$(grep 'set xtics' a.gp)"
is "with all points" "3,1,2" "$(rows a.gp 0 | cut -d, -f3 | paste -sd,)"
check "a condition on words" "$lines" words power --where contact.rule=smooth -o a.gp
is "chooses them" "2,4" "$(rows a.gp 0 | cut -d, -f3 | paste -sd,)"
expect 2 "'rough' is no number" "words on a map" "$map" words power -o x.gp

# ---------------------------------------------------------------- a third axis
expect 2 "--where balls.diameter=VALUE" "three axes" "$lines" three power -o x.gp
expect 2 "--where balls.diameter=VALUE" "and on a map" "$map" three power -o x.gp
check "one value of the third" "$map" three power --where balls.diameter=0.005 -o a.gp
check "is told in the picture" grep -q "as in the scene · balls.diameter = 0.005 · 4 points" a.gp
check "and in that of curves" bash -c "
  '$lines' three power --where balls.diameter=0.004 -o a.gp && grep -q '· balls.diameter = 0.004 ·' a.gp"
echo 'title="of its own"' >>two/fixed
check "a title given to the sweep" bash -c "'$lines' two power -o a.gp && grep -q 'of its own ·' a.gp"

# ---------------------------------------------------------------- intervals
check "an axis from zero" "$lines" two power --zero -o a.gp
is "holds all intervals" yes "$(sed -n 's/^set yrange \[0:\(.*\)\]/\1/p' a.gp | awk '{ print ($1 > 100 ? "yes" : "no") }')"
is "an interval that is not known is left out" "1300,50," "$(rows a.gp 0 | grep 1300 | cut -d, -f2-)"

if command -v gnuplot >/dev/null; then
  for of in two words laws; do check "curves of $of" "$lines" $of power -o $of.png; done
  check "a map of scattered points" "$map" scattered power -o scattered.gp
  { grep -v '^set terminal\|^set output' scattered.gp | sed '/^set datafile separator whitespace/q'
    echo 'print $net'; } >net.gp
  is "follows the narrow axis" yes "$(grep -v '[#p]' scattered/mean.csv | cut -d, -f3 | sort -g | sed -n '1p;$p' |
    cat - <(gnuplot net.gp 2>&1) | awk 'NR == 1 { low = $1 } NR == 2 { high = $1 }
      NF == 4 && $4 == "i" { e = low + $2 * (high - low); d = $3 - sin(60 * e); near += d * d < 0.09; n++ }
      END { print (near > 0.8 * n ? "yes" : "no") }')"
  check "and is drawn" "$map" scattered power -o scattered.png
fi

# ---------------------------------------------------------------- links
ln -s "$lines" linked
expect 0 "" "a script called through a symbolic link" ./linked two power -o a.gp
finish
