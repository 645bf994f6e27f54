#!/bin/bash
# The reference's experiments in short: every part runs, goes on, and has its lines in the report.
set -u
cd "$(dirname "$0")/../.." || exit 2
case ${BUILD:-build} in /*) ;; *) BUILD=$PWD/${BUILD:-build} ;; esac
export BUILD
reproduce=$PWD/scripts/reproduce
command -v parallel >/dev/null || { echo "ok 1 - skipped: GNU parallel is not installed"; exit 0; }
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
mkdir "$work/a place" && cd "$work/a place" || exit 2
number=0 failed=0
check() { # TEXT COMMAND...
  local text=$1 verdict="not ok"
  shift
  number=$((number + 1))
  if "$@" >"$work/out" 2>"$work/err"; then verdict=ok; else failed=1; fi
  echo "$verdict $number - $text"
  [ "$verdict" = ok ] || tail -n 20 "$work/err" | sed 's/^/# /'
}
lines() { # COUNT PATTERN: so many lines of the report
  test "$(grep -c -- "$2" all/report.md)" -eq "$1"
}
check "a part that is not there" bash -c "! '$reproduce' --only R3 -o all 2>err && grep -q 'expected some of' err"
check "the parts that are quick" "$reproduce" --only main,half,counts,detail,gas --duration 0.3 --repeat 2 -q -o "$PWD/all"
check "R1, both starts and its course in time" lines 2 '^| R1 |'
check "R2" lines 1 '^| R2 |'
check "R3 and R7, class by class" lines 8 '^| R[37] | ball–'
check "R4 and R5" lines 4 '^| R[45] |'
check "R6 and R7, hard impacts" lines 6 '^| R[67] | \(v_n\|above\|Σ\)'
check "R8, with the speed that follows" lines 4 '^| R8 |'
check "R12" lines 2 '^| R12 .*agrees'
check "no figure is missing" bash -c "! grep '^| R[1-8] ' all/report.md | grep -e '| –' -e nan -e inf"
check "every figure has a verdict" bash -c "! grep '^| R[1-8] ' all/report.md | grep -v '\(agrees\|%\) | .* \(agrees\|%\) |$'"
check "the budgets add up" awk -F'|' '/^\| (of the work|…[^p]*\|)/ { a += $3; b += $4; n++ }
  END { exit !(n == 4 && a > 0.9 && a < 1.1 && b > 0.8 && b < 1.1) }' all/report.md
check "pictures" test -s all/sectors-rough.png -a -s all/ramps-vn-reichardt2005.png
stat -c '%n %Y' all/*/runs/*.h5 >before
check "the same again" "$reproduce" --only main,half,counts,detail,gas --duration 0.3 --repeat 2 -q -o "$PWD/all"
check "changes no run" bash -c "stat -c '%n %Y' all/*/runs/*.h5 | cmp before -"
for run in all/main/runs/*rpm-1300*.h5; do head -c 3000 "$run" >short && mv short "$run"; done
check "a run that cannot be read fails the report" bash -c "! '$reproduce-report' all >report"
exit $failed
