# shellcheck shell=sh
# shellcheck disable=SC2034,SC2154 # variables of whoever sources this
# What the scripts for parameter studies share. Sourced; $here is the folder of the scripts.

# Numbers have points, and words one order, whatever the user's language.
LANG=${LC_ALL:-${LANG:-}}
unset LC_ALL
export LANG LC_NUMERIC=C LC_COLLATE=C

say() { echo "${0##*/}: $*" >&2; }
fail() { say "error: $*"; exit "${code:-1}"; }
usage_error() { say "error: $*"; echo "Try '${0##*/} --help'." >&2; exit 2; }

# The comment at the top of a script is its help.
print_help() { sed -n '2,/^[^#]/{s/^# \{0,1\}//p;}' "$0"; }

# The programs: those in $BUILD; where BUILD is not set, those of the tree, else installed ones.
find_programs() {
  top=$(cd "$here/.." && pwd)
  case ${BUILD:-build} in /*) build=$BUILD ;; *) build=$top/${BUILD:-build} ;; esac
  if [ -z "${BUILD:-}" ] && [ ! -x "$build/mill" ] && command -v mill >/dev/null; then
    build=$(cd "$(dirname "$(command -v mill)")" && pwd)
  fi
  mill=$build/mill millpost=$build/millpost
  export BUILD="$build"
  if [ ! -x "$mill" ] || [ ! -x "$millpost" ]; then
    code=2 fail "no mill and millpost in $build: run make, or set BUILD"
  fi
}

# operand NAME: a file's name that awk does not take for an assignment.
operand() {
  case $1 in [A-Za-z_]*=*) printf './' ;; esac
  printf '%s\n' "$1"
}

# need PROGRAM PACKAGE
need() { command -v "$1" >/dev/null || fail "$2 is not installed: there is no $1"; }

# json_number KEY <JSON: the first number of that key.
json_number() { sed -n "s/.*\"$1\": *\\([-+0-9.eE]*\\).*/\\1/p" | head -n 1; }

# is_finished RUN.h5 [DURATION]: does its summary exist, and is it as long as that? The summary is
# written after the run file is complete.
is_finished() {
  [ -s "$1" ] && [ -s "${1%.h5}.json" ] || return 1
  [ -z "${2:-}" ] && return 0
  awk -v want="$2" 'match($0, /"simulated_time": *[-+0-9.eE]+/) {
      split(substr($0, RSTART, RLENGTH), part, ": *"); done = part[2] >= want * (1 - 1e-9); exit }
    END { exit !done }' <"${1%.h5}.json"
}

# states SWEEP POINTS.csv DURATION: for each run of the table its row, from 1, its name, and 1 when it
# is finished, else 0. DURATION is theirs where the table has none.
states() {
  awk -F, -v fixed="$3" 'NR == 1 { for (a = 5; a <= NF; a++) if ($a == "duration") d = a }
    NR > 1 { print NR - 1, $4, d ? $d : fixed }' "$2" |
    while read -r row run time; do
      is_finished "$1/$run" "$time" && echo "$row $run 1" || echo "$row $run 0"
    done
}

# The median speed of a run's balls over time: lines of time,speed.
median_over_time() {
  both=$(for what in time value; do
    h5dump -d "/observables/median_speed/$what" -y -w 1 "$1" || exit 1
  done) || return 1
  echo "$both" | sed -n 's/^ *\(-\{0,1\}[0-9][0-9.e+-]*\),\{0,1\}$/\1/p' |
    awk '{ x[NR] = $1 } END { for (k = 1; k <= NR / 2; k++) print x[k] "," x[k + NR / 2] }'
}

# A time in seconds, for people.
clock() { awk -v t="$1" 'BEGIN { t = int(t + 0.5);
  if (t >= 3600) printf "%d:%02d:%02d", t / 3600, t % 3600 / 60, t % 60
  else printf "%d:%02d", t / 60, t % 60 }'; }

# --- diagrams, in the style of millpost's --------------------------------------------------------

colours="#1f5fa8 #d95f0e #1b8a5a #b83270 #6a4ca5 #8c6d1f #2a9db5 #5b606b"

# A text as a gnuplot string.
quoted() { printf "'%s'" "$(printf '%s' "$1" | sed "s/'/''/g")"; }

# plot_begin OUT.{png,svg,pdf,gp} WIDTH HEIGHT TITLE SUBTITLE: the begin of a script.
plot_begin() {
  case $1 in
    *.png | *.gp) echo "set terminal pngcairo size $2,$3 enhanced font 'DejaVu Sans,13'" ;;
    *.svg) echo "set terminal svg size $2,$3 enhanced font 'DejaVu Sans,13' background 'white'" ;;
    *.pdf) awk -v w="$2" -v h="$3" 'BEGIN { printf "set terminal pdfcairo size %gin,%gin " \
      "enhanced font \"DejaVu Sans,10\"\n", w / 120, h / 120 }' ;;
    *) usage_error "$1: the name of a diagram must end in .png, .svg, .pdf or .gp" ;;
  esac
  case $1 in *.gp) echo "set output $(quoted "$(basename "$1" .gp).png")" ;; esac
  cat <<END
set encoding utf8
set datafile separator ','
set border 3 lw 1 lc rgb '#5b606b'
set tics nomirror out scale 0.6 textcolor rgb '#2b2f36'
set grid back lt 1 lw 0.8 lc rgb '#e4e7eb'
set key top right samplen 2 spacing 1.25 font ',12' textcolor rgb '#2b2f36' noenhanced
set tmargin at screen 0.865
set label 1000 $(quoted "$4") at screen 0.035,0.955 left font ',17' textcolor rgb '#1c1f24' noenhanced front
set label 1001 $(quoted "$5") at screen 0.035,0.908 left font ',12' textcolor rgb '#6a707b' noenhanced front
END
}

# plot_label AXIS TEXT
plot_label() { echo "set $1label $(quoted "$2") noenhanced textcolor rgb '#2b2f36'"; }

# The colours of maps: lagoon, at some of its 256 steps.
plot_palette() {
  echo 'set palette defined (0 "#4c0f78", 42 "#4844a8", 81 "#1772b8", 117 "#0095aa", 147 "#00b29f",' \
    '183 "#41d084", 219 "#a5e258", 255 "#f8ea21")'
}

# plot_end SCRIPT OUT: draws it; the picture appears complete or not at all.
plot_end() {
  case $2 in *.gp) cp "$1" "$2"; return ;; esac
  command -v gnuplot >/dev/null || fail "gnuplot is not installed: scripts/setup installs it"
  gnuplot "$1" >"$2.part" && [ -s "$2.part" ] && mv -f "$2.part" "$2" || {
    rm -f "$2.part"
    fail "gnuplot could not draw $2"
  }
}

# The words of a column's heading, unit included, from a key and the header of a table.
heading() { # TABLE KEY
  awk -F, -v key="$2" '/^#/ { next } { for (k = 1; k <= NF; k++) { name = $k; sub(/ \[.*/, "", name)
      if (name == key) { found = $k } } exit }
    END { if (found == "") exit 1
      unit = ""; if (match(found, /\[.*/)) unit = "  " substr(found, RSTART)
      words = key
      if (key == "rotor.rpm") { words = "speed of the rotor"; unit = "  [rpm]" }
      if (key == "balls.count") words = "number of balls"
      if (key == "contact.tangential") words = "tangential restitution"
      if (key == "contact.normal") words = "normal restitution"
      if (key == "share_above") words = "share of collisions above the threshold"
      if (key == "rate_above") words = "collisions above the threshold"
      if (key == "impact") words = "impact power, sum of m v_n^2 / 2"
      sub(/vn$/, "normal collision speed", words); sub(/_vn_/, " normal collision speed ", words)
      gsub(/_/, " ", words); print words unit }' "$1"
}

# columns TABLE KEY...: these columns, without header, in that order.
columns() {
  table=$1
  shift
  awk -F, -v keys="$*" 'BEGIN { n = split(keys, want, " ") } /^#/ { next }
    !header { for (k = 1; k <= NF; k++) { name = $k; sub(/ \[.*/, "", name); at[name] = k }
      for (k = 1; k <= n; k++) if (!(want[k] in at)) {
        print "no column " want[k] > "/dev/stderr"; exit 2 }
      header = 1; next }
    { row = $at[want[1]]; for (k = 2; k <= n; k++) row = row "," $at[want[k]]; print row }' "$table"
}

# --- key figures of a sweep over its axes ---------------------------------------------------------

# first_axis SWEEP 'KEY KEY=VALUE ...': the first axis that is none of these.
first_axis() {
  head -n 1 "$1/points.csv" | tr ',' '\n' | tail -n +5 | awk -v taken="$2" '
    BEGIN { n = split(taken, t, " "); for (k = 1; k <= n; k++) { sub(/=.*/, "", t[k]); out[t[k]] } }
    !($0 in out) { print; exit }'
}

# chosen TABLE CONDITIONS KEY...: these columns of the rows that meet all CONDITIONS, "KEY=VALUE ...".
chosen() {
  from=$1 conditions=$2 count=$(($# - 2))
  shift 2
  for condition in $conditions; do
    case $condition in
      ?*=?*) set -- "$@" "${condition%%=*}" ;;
      *) usage_error "--where $condition: expected KEY=VALUE" ;;
    esac
  done
  rows=$(columns "$from" "$@") || exit 2
  printf '%s\n' "$rows" | awk -F, -v OFS=, -v conditions="$conditions" -v count="$count" '
    function is_number(x) { return x ~ /^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$/ }
    BEGIN { n = split(conditions, v, " "); for (k = 1; k <= n; k++) sub(/^[^=]*=/, "", v[k]) }
    { for (k = 1; k <= n; k++) {
        x = $(count + k)
        if (is_number(x) && is_number(v[k]) ? x + 0 != v[k] + 0 : x != v[k]) next
      }
      row = $1; for (k = 2; k <= count; k++) row = row OFS $k
      print row }'
}

# one_each SWEEP CONDITIONS KEY [KEY]: refuses values of the KEYs, a line for each point, that come
# twice: another axis parts these points.
one_each() {
  [ -n "$(sort | uniq -d)" ] || return 0
  other=$(first_axis "$1" "$2 $3 ${4:-}")
  code=2 fail "$1: several points have the same $3${4:+ and $4}: choose some with --where ${other:-KEY}=VALUE"
}

# The line under a diagram's title: the scene's title, the conditions, and TEXT.
subtitle() { # SWEEP CONDITIONS TEXT
  title=$({ sed -n 's/^title *[=:] *"\([^"]*\)".*/\1/p' "$1/scene.cfg" | head -n 1
    sed -n 's/^title=//p' "$1/fixed" 2>/dev/null | sed 's/^"\(.*\)"$/\1/'; } | tail -n 1)
  text=${title:+$title · }
  for condition in $2; do text="$text${condition%%=*} = ${condition#*=} · "; done
  printf '%s\n' "$text$3"
}
