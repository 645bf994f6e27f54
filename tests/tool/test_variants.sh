#!/bin/bash
# What an effect needs is not in the code of the variants of the loop that do without it: every
# instruction of these is traced to the functions that it was inlined from or calls.
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh

if ! objdump --inlines --version >/dev/null 2>&1; then
  skip "code of the variants" "objdump is missing or older than 2.35"
  finish
fi
functions=$(grep -ho 'FN([a-z_]*)' src/event/loop_{template,pairs,surfaces,contacts}.h | sort -u | tr -d '()' | sed 's/^FN//')

# look OBJECT: per variant the effects whose functions its code calls or has inlined; variants are
# named by their effects.
look() {
  objdump -dr -l --inlines "$1" | awk -v functions="$functions" '
    BEGIN {
      split(functions, list, "\n")
      for (k in list) template[list[k]] = 1
      of["rotor"] = "predict_blade turning_gap note_blade em_surface_blade em_surface_blade_normal " \
        "em_surface_blade_velocity"
      of["spin"] = "spin_up em_contact_spin_factor"
      of["periodic"] = "em_body_shift em_body_wrap"
      of["remedies"] = "since em_body_exact_pair em_body_special_drum em_body_facet em_surface_roots_plane " \
        "em_surface_roots_blade"
      for (effect in of) {
        n = split(of[effect], name, " ")
        for (k = 1; k <= n; k++) belongs[name[k]] = effect
      }
    }
    # Splits pair_gravity_spin.isra.0 into what it is and its variant.
    function base(symbol,   s, best, f) {
      s = symbol; sub(/\..*/, "", s); best = ""; variant = ""
      for (f in template)
        if (length(f) > length(best) && index(s, f "_") == 1) best = f
      if (best == "") return s
      variant = substr(s, length(best) + 2)
      return best
    }
    function seen(symbol,   b, mine) {
      mine = owner; b = base(symbol)
      if (mine != "" && b in belongs) print mine, belongs[b]
    }
    /^[0-9a-f]+ <.*>:$/ { s = $2; gsub(/[<>:]/, "", s); base(s); owner = variant; next }
    /^inlined by / { s = $NF; gsub(/[()]/, "", s); seen(s); next }
    /^[A-Za-z_][A-Za-z_0-9.]*\(\):$/ { s = $1; sub(/\(.*/, "", s); seen(s); next }
    / R_X86_64_(PLT32|PC32|GOTPCREL|REX_GOTPCRELX|GOTPCRELX)|R_AARCH64_(CALL26|JUMP26)/ {
      s = $NF; sub(/[-+]0x.*/, "", s); seen(s)
    }' | sort -u
}

for object in loop loop_avx2 loop_avx512; do
  [ -f "$bin/src/event/$object.o" ] || continue
  look "$bin/src/event/$object.o" >"$work/pairs"
  # plain has nothing; every other variant has an effect only if its name says so.
  awk '{ if (index("_" $1 "_", "_" $2 "_") == 0) { print; bad = 1 } } END { exit bad }' \
    "$work/pairs" >"$work/extra"
  check "$object: no variant has code of an effect that it does without" test ! -s "$work/extra"
  sed 's/^/# /' "$work/extra"
  for effect in rotor spin periodic remedies; do
    check "$object: the code of $effect is found where it is wanted" grep -q " $effect\$" "$work/pairs"
  done
done
finish
