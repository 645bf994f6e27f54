# Makes the table of points of a sweep. Axes come as lines "KEY=VALUES" (mode grid or lhs), or as a
# table with a header (mode list). Prints CSV: point,repeat,seed,run,KEY... Variables: mode, count
# (Latin hypercube), draw (its seed), repeat, base (added to all seeds), fixed (keys that have a value
# for all points, with a blank after each). Text is bytes: LC_ALL=C.
#
# A point's seed and name depend on its values, the repeat and base alone: neither on the order of
# the axes nor on the other points, so that a sweep can be extended.

function die(text) {
  print "sweep: error: " text > "/dev/stderr"
  dead = 1
  exit 2
}
function is_number(text) { return text ~ /^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$/ }
function number(x) { return sprintf("%.10g", x) }

# A number in its shortest form that is not another one.
function exact(text,   digits, short) {
  for (digits = 10; digits < 17; digits++) {
    short = sprintf("%." digits "g", text)
    if (short + 0 == text + 0) return short
  }
  return sprintf("%.17g", text)
}

# A value that stands in a CSV file, a file name and a command line.
function checked(key, text) {
  if (text == "" || text ~ /[,"' \t;$`\\]/)
    die(key ": '" text "' cannot be a value of an axis, expected a number or a word")
  if (key ~ /\.(table|from)$/ && text !~ /^\//)
    die(key ": '" text "': names of files must be absolute")
  return is_number(text) ? exact(text) : text
}

# A slip in a step must not fill the memory.
function bound(what, n) {
  if (n > 1e6) die(sprintf("%s: %.10g, expected at most 1000000", what, n))
}

# Minimal standard generator (Park and Miller): the same numbers with every awk.
function uniform() {
  state = (state * 48271) % 2147483647
  return state / 2147483647
}

function hash(text, start,   k, h) {
  h = start
  for (k = 1; k <= length(text); k++) h = (h * 131 + ord[substr(text, k, 1)] + 1) % 2147483647
  for (k = 0; k < 3; k++) h = (h * 48271 + 11) % 2147483647
  return h
}

# Values of axis a: a list "x,y", a range "low:step:high"; for a hypercube "low:high" as well.
function read_axis(a, text,   part, n, k, steps) {
  n = split(text, part, ":")
  if (n == 3 || (n == 2 && mode == "lhs")) {
    for (k = 1; k <= n; k++)
      if (!is_number(part[k])) die(key[a] ": '" part[k] "' is not a number")
    low[a] = part[1] + 0
    high[a] = part[n] + 0
    step[a] = n == 3 ? part[2] + 0 : 0
    if (high[a] < low[a] || (n == 3 && step[a] <= 0))
      die(key[a] ": '" text "', expected low:step:high with step > 0 and low <= high")
    is_range[a] = 1
    if (n == 2) return
    steps = int((high[a] - low[a]) / step[a] + 1e-9)
    bound("values of " key[a], steps + 1)
    for (k = 0; k <= steps; k++) {
      value[a, k] = number(low[a] + k * step[a])
      if (k && value[a, k] == value[a, k - 1])
        die(key[a] ": '" text "', expected steps that are seen in ten digits")
    }
    values[a] = steps + 1
    return
  }
  if (n == 2) die(key[a] ": '" text "', expected low:step:high (low:high goes with --lhs)")
  values[a] = split(text, part, ",")
  for (k = 1; k <= values[a]; k++) value[a, k - 1] = checked(key[a], part[k])
}

function grid(   k, a, rest) {
  for (k = 0; k < points; k++) {
    rest = k
    for (a = axes; a >= 1; a--) {
      at[k, a] = value[a, rest % values[a]]
      rest = int(rest / values[a])
    }
  }
}

# Each axis is cut into `count` parts of equal probability; each part is drawn once.
function hypercube(   a, k, j, order, swap, u) {
  for (a = 1; a <= axes; a++) {
    for (k = 0; k < count; k++) order[k] = k
    for (k = count - 1; k > 0; k--) {
      j = int(uniform() * (k + 1))
      swap = order[k]
      order[k] = order[j]
      order[j] = swap
    }
    for (k = 0; k < count; k++) {
      u = (order[k] + uniform()) / count
      if (is_range[a] && step[a] == 0) at[k, a] = number(low[a] + u * (high[a] - low[a]))
      else at[k, a] = value[a, int(u * values[a])]
    }
  }
}

function sort_keys(   a, b, swap) {
  for (a = 1; a <= axes; a++) sorted[a] = a
  for (a = 2; a <= axes; a++)
    for (b = a; b > 1 && key[sorted[b]] < key[sorted[b - 1]]; b--) {
      swap = sorted[b]
      sorted[b] = sorted[b - 1]
      sorted[b - 1] = swap
    }
}

function write_point(k,   a, r, text, name, row, seed, id) {
  text = name = row = ""
  for (a = 1; a <= axes; a++) {
    text = text key[sorted[a]] "=" at[k, sorted[a]] " "
    id = key[sorted[a]]
    sub(/.*\./, "", id)
    name = name id "-" at[k, sorted[a]] "_"
    row = row "," at[k, a]
  }
  if (text in seen) return
  seen[text] = 1
  points_written++
  gsub(/[^A-Za-z0-9.+_-]/, "_", name)
  if (length(name) > 120) name = substr(name, 1, 120) "_"
  for (r = 1; r <= repeat; r++) {
    seed = 1 + hash(text r, 17 + base) % 2147483646
    id = sprintf("%s%07x-%d", name, hash(text, 5381 + base), r)
    if (id in seen) die("two points have the same name '" id "'")
    seen[id] = 1
    printf "%d,%d,%d,runs/%s.h5%s\n", points_written, r, seed, id, row
  }
}

BEGIN {
  no_seed = "seeds come from the points: --seed, --repeat"
  for (k = 1; k < 256; k++) ord[sprintf("%c", k)] = k
  state = 1 + draw % 2147483646
  base %= 2147483646
  for (k = 0; k < 10; k++) uniform()
}
NR == 1 { sub(/^\357\273\277/, "") } # UTF-8's byte order mark, as spreadsheets put it
{ sub(/\r$/, "") }
/^[ \t]*(#|$)/ { next }
mode == "list" {
  sub(/[ \t]#.*/, "")
  gsub(/[ \t]*,[ \t]*|[ \t]+/, ",")
  gsub(/^,|,$/, "")
  n = split($0, field, ",")
  for (a = 1; a <= n; a++)
    if (field[a] ~ /^".+"$/) field[a] = substr(field[a], 2, length(field[a]) - 2)
  if (!axes) {
    axes = n
    for (a = 1; a <= n; a++) key[a] = field[a]
    next
  }
  if (n != axes) die("the list's line " NR " has " n " values, expected " axes)
  for (a = 1; a <= n; a++) at[points + 0, a] = checked(key[a], field[a])
  points++
  next
}
{
  eq = index($0, "=")
  axes++
  key[axes] = substr($0, 1, eq - 1)
  read_axis(axes, substr($0, eq + 1))
}
END {
  if (dead) exit 2
  if (mode == "list" && !points) die("the list holds no point")
  if (index(" " fixed, " seed ")) die(no_seed)
  for (a = 1; a <= axes; a++)
    if (key[a] !~ /^[A-Za-z][A-Za-z0-9_.-]*$/) die("'" key[a] "' is not a key of a scene")
  for (a = 1; a <= axes; a++) {
    if (key[a] == "seed") die(no_seed)
    if (given[key[a]]++) die(key[a] " is given twice")
    if (index(" " fixed, " " key[a] " ")) die(key[a] " has a fixed value and is an axis")
  }
  if (mode != "list") points = mode == "lhs" ? count : 1
  if (mode == "grid")
    for (a = 1; a <= axes; a++) points *= values[a]
  bound("runs", points * repeat)
  if (mode == "grid") grid()
  if (mode == "lhs") hypercube()
  sort_keys()
  printf "point,repeat,seed,run"
  for (a = 1; a <= axes; a++) printf ",%s", key[a]
  print ""
  for (k = 0; k < points; k++) write_point(k)
}
