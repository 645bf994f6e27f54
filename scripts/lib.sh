# shellcheck shell=sh
# shellcheck disable=SC2034,SC2154 # variables of whoever sources this
# What the scripts for parameter studies share. Sourced; $here is the folder of the scripts.

say() { echo "${0##*/}: $*" >&2; }
fail() { say "error: $*"; exit "${code:-1}"; }
usage_error() { say "error: $*"; echo "Try '${0##*/} --help'." >&2; exit 2; }

# The comment at the top of a script is its help.
print_help() { sed -n '2,/^[^#]/{s/^# \{0,1\}//p;}' "$0"; }

# The programs: those in $BUILD, else those of the tree, else installed ones.
find_programs() {
  top=$(cd "$here/.." && pwd)
  case ${BUILD:-build} in /*) build=${BUILD:-build} ;; *) build=$top/${BUILD:-build} ;; esac
  if [ -x "$build/mill" ] && [ -x "$build/millpost" ]; then
    mill=$build/mill millpost=$build/millpost
    export BUILD="$build"
  elif command -v mill >/dev/null && command -v millpost >/dev/null; then
    mill=$(command -v mill) millpost=$(command -v millpost)
  else
    code=2 fail "no mill and millpost in $build: run make, or set BUILD"
  fi
}

# json_number KEY <JSON: the first number of that key.
json_number() { sed -n "s/.*\"$1\": *\\([-+0-9.eE]*\\).*/\\1/p" | head -n 1; }

# is_finished RUN.h5: does its summary exist, and is it as long as $duration (if set) asks for? The
# summary is written after the run file is complete; a run that has no entry `duration` in the scene
# is as long as `mill run` made it.
is_finished() {
  [ -s "$1" ] && [ -s "${1%.h5}.json" ] || return 1
  [ -z "${2:-}" ] && return 0
  json_number simulated_time <"${1%.h5}.json" |
    awk -v want="$2" '{ done = $1 >= want * (1 - 1e-9) } END { exit !done }'
}

# A time in seconds, for people.
clock() { awk -v t="$1" 'BEGIN { t = int(t + 0.5);
  if (t >= 3600) printf "%d:%02d:%02d", t / 3600, t % 3600 / 60, t % 60
  else printf "%d:%02d", t / 60, t % 60 }'; }
