# shellcheck shell=bash
# shellcheck disable=SC2034 # what scripts use
# What tests of programs share: `. tests/support/tap.sh` from the top folder. Gives $bin, where the
# programs are, and $work, a folder that goes when the script ends.
case ${BUILD:-build} in /*) bin=$BUILD ;; *) bin=$PWD/${BUILD:-build} ;; esac
mill=$bin/mill post=$bin/millpost
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
number=0 failed=0

report() { # VERDICT TEXT: "ok" or "not ok"
  number=$((number + 1))
  echo "$1 $number - $2"
  [ "$1" = ok ] || { failed=1; tail -n 20 "$work/err" | sed 's/^/# /'; }
}

# expect CODE PATTERN TEXT COMMAND...: exit code and a pattern in what goes to stderr. What goes to
# stdout is in $work/out.
expect() {
  local code=$1 pattern=$2 text=$3 status verdict=ok
  shift 3
  "$@" >"$work/out" 2>"$work/err"
  status=$?
  [ $status -eq "$code" ] || { verdict="not ok"; echo "exit code $status" >>"$work/err"; }
  [ -z "$pattern" ] || grep -q -- "$pattern" "$work/err" || verdict="not ok"
  report "$verdict" "$text"
}

check() { # TEXT COMMAND...: does it succeed? Leaves $work/out as it is.
  local text=$1
  shift
  if "$@" >"$work/err" 2>&1; then report ok "$text"; else report "not ok" "$text"; fi
}

is() { # TEXT WANT GOT
  echo "$3, expected $2" >"$work/err"
  if [ "$2" = "$3" ]; then report ok "$1"; else report "not ok" "$1"; fi
}

skip() { # TEXT WHY
  number=$((number + 1))
  echo "ok $number - $1 # SKIP $2"
}

finish() {
  echo "1..$number"
  exit $failed
}
