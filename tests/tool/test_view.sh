#!/bin/bash
# millpost view and track as a user runs them; the page is opened in headless Chromium where there is
# one (scripts/setup browser).
set -u
cd "$(dirname "$0")/../.." || exit 2
# shellcheck source=tests/support/tap.sh
. tests/support/tap.sh

run=$work/run.h5 still=$work/still.h5 page=$work/run.html
small=(geometries/simoloyer-2l.cfg duration=0.05 balls.count=800 --quiet)
"$bin/mill" run "${small[@]}" record.frames=200 record.collisions=true -o "$run" >"$work/out" || exit 2
"$bin/mill" run "${small[@]}" record.frames=0 -o "$still" >"$work/out" || exit 2

# ---------------------------------------------------------------- view: the command line
expect 0 "" "view --help" "$post" view --help
expect 2 "expected RUN" "view without a run" "$post" view
expect 2 "unknown option '--fly'" "view --fly" "$post" view "$run" --fly
expect 2 "is not a number" "view --from" "$post" view "$run" --from soon
expect 2 "is not above 0" "view --step" "$post" view "$run" --step 0
expect 2 "no frames" "view of a run without frames" "$post" view "$still" -o "$page"
expect 2 "nothing to show from 3 to 0.05 s" "view of no time" "$post" view "$run" --from 3 -o "$page"
mkfifo "$work/pipe"
timeout 30 cat "$work/pipe" >"$work/piped.html" &
expect 0 "0.05 s$" "a page into a pipe" "$post" view "$run" -o "$work/pipe"
wait
expect 2 "" "view of a foreign file" "$post" view README.md
expect 1 "cannot be written" "view into nowhere" "$post" view "$run" -o /nowhere/x.html
is "and nothing is left" 1 "$([ -e "$page" ]; echo $?)"
expect 0 "51 frames of 800 balls" "a page" "$post" view "$run" -o "$page"
is "the same as through a pipe" 0 "$(cmp -s "$page" "$work/piped.html"; echo $?)"
is "without any address" 0 "$(grep -c 'https\?://' "$page")"
expect 0 "of 51 frames are kept" "a page of limited size" \
  "$post" view "$run" --max-size 0.2 -o "$work/thin.html"
is "is small" 1 $(($(stat -c %s "$work/thin.html") < 300000))
expect 0 "frames of 100 balls" "a page of few balls" \
  "$post" view "$run" --balls 100 --from 0.01 --to 0.02 --step 0.002 -o "$work/few.html"
expect 0 "" "with its colours from 1 to 4 m/s" "$post" view "$run" --scale 1:4 -o "$work/scale.html"
is "which are in the page" 1 "$(grep -c '"scaleLow":1,"scaleHigh":4,' "$work/scale.html")"
expect 0 "" "or up to 4 m/s" "$post" view "$run" --scale 4 --max-balls 100 -o "$work/scale.html"
is "from 0 on" 1 "$(grep -c '"scaleLow":0,"scaleHigh":4,' "$work/scale.html")"
expect 2 "is not LOW:HIGH" "but not down" "$post" view "$run" --scale 4:1 -o "$work/scale.html"

# More kinds of balls than a byte can tell.
{ echo 'duration=0.01; chamber={shape="box"; size=[0.1,0.1,0.1];}; record={frames=100.0;}; balls=('
  for k in {0..299}; do echo "$([ "$k" = 0 ] || echo ,){name=\"$k\"; count=1; density=1.0; diameter=0.001$((100 + k));}"; done
  echo ');'; } >"$work/kinds.cfg"
"$bin/mill" run "$work/kinds.cfg" --quiet -o "$work/kinds.h5" >"$work/out" || exit 2
expect 0 "" "a page of 300 kinds of balls" "$post" view "$work/kinds.h5" -o "$work/kinds.html"
check "has the size of each ball" /usr/bin/python3 - "$work/kinds.html" <<'PY'
import array, base64, json, re, sys
page = open(sys.argv[1]).read()
part = lambda name: re.search(f'id="{name}">(.*?)</script>', page, re.S)[1]
head, kind = json.loads(part("head")), array.array("H", base64.b64decode(part("species")))
assert list(kind) == list(range(300)) and len(head["speciesNames"]) == 300
assert all(abs(r - (0.001100 + 1e-6 * k) / 2) < 1e-12 for k, r in enumerate(head["radii"]))
PY

# A page holds the places of balls, to 16 bits of the chamber's box, in the corners of facets as well.
facets=$work/facets.h5
"$bin/mill" run "${small[@]}" chamber.facets=3 record.frames=200 -o "$facets" >"$work/out" || exit 2
expect 0 "" "a page of a drum with facets" "$post" view "$facets" -o "$work/facets.html"
check "has the balls where they are" /usr/bin/python3 - "$facets" "$work/facets.html" <<'PY'
import base64, json, re, sys
import h5py, numpy as np
want = h5py.File(sys.argv[1])["particles/balls/position/value"][...]
page = open(sys.argv[2]).read()
part = lambda name: re.search(f'id="{name}">(.*?)</script>', page, re.S)[1]
head, n = json.loads(part("head")), want.shape[1]
raw = np.frombuffer(base64.b64decode(part("frames")), "<u2").reshape(len(want), 6 * n)
low, high = np.array(head["low"]), np.array(head["high"])
got = low + raw[:, :3 * n].reshape(want.shape) * (high - low) / 65535
assert head["facets"] == 3 and np.hypot(want[..., 0], want[..., 2]).max() > 0.1
assert abs(got - want).max() < 3e-6, abs(got - want).max()
PY

# ---------------------------------------------------------------- view: in a browser
if command -v chromium >"$work/out" && command -v chromedriver >"$work/out"; then
  /usr/bin/python3 tests/tool/view.py "$page" "$work/page.png" >"$work/err" 2>&1
  status=$?
  sed 's/^/# /' "$work/err"
  is "the page in Chromium" 0 $status
  is "and a picture of it" 1 $(($(stat -c %s "$work/page.png") > 50000))
  [ -z "${KEEP:-}" ] || cp "$work/page.png" "$KEEP"
else
  skip "the page in Chromium" "no chromium and chromedriver: scripts/setup browser"
fi

# ---------------------------------------------------------------- track
# A film of a disc, drawn by ffmpeg, that comes at 15 m/s and leaves at 60 % of it.
film=$work/film
mkdir "$film" "$work/empty"
x='if(lt(N,20),40+9*N,220-5.4*(N-20))'
ffmpeg -v error -f lavfi -i "color=gray:s=260x80:r=25,format=gray,geq=lum='if(lt(hypot(X-($x),Y-40),18),60,170)'" \
  -frames:v 40 "$film/%d.png" || exit 2
expect 0 "" "track --help" "$post" track --help
expect 2 "expected FOLDER" "track without a folder" "$post" track --fps 5
expect 2 "expected --fps" "track without a rate" "$post" track "$film"
expect 2 "expected --diameter" "track without a scale" "$post" track "$film" --fps 5000
expect 2 "unknown side" "track --plate" "$post" track "$film" --plate middle
expect 2 "at least 7" "track of nothing" "$post" track "$work/empty" --fps 5000 --diameter 0.005
expect 2 "cannot be read" "track of no folder" "$post" track "$work/no" --fps 5000 --diameter 0.005
expect 2 "film: error: .*towards the plate" "track to the wrong side" \
  "$post" track "$film" --fps 5000 --diameter 0.005 --plate left
expect 0 "" "track" "$post" track "$film" --fps 5000 --scale 0.0003333333 --json -o "$work/pairs.txt"
is "measures speed and restitution" "yes" "$(/usr/bin/python3 - "$work/out" <<'PY'
import json, sys
shot = json.load(open(sys.argv[1]))["shots"][0]
good = abs(shot["speed"] / 15 - 1) < 0.005 and abs(shot["restitution"] / 0.6 - 1) < 0.01
print("yes" if good and shot["plate"] == "right" else shot)
PY
)"
is "a pair for fit" 1 "$(grep -c '^1[45][.][0-9]* 0[.][56][0-9]* ' "$work/pairs.txt")"
cp "$work/pairs.txt" "$work/before.txt"
limited() { (ulimit -f 0 && "$post" track "$film" --fps 5000 --diameter 0.005 -o "$work/pairs.txt") 2>&1 | cat >&2
  return "${PIPESTATUS[0]}"; }
expect 1 "pairs.txt: error: cannot be written" "track on a full disk" limited
check "leaves the pairs of before" cmp -s "$work/before.txt" "$work/pairs.txt"
# The picture without the ball stands for frames that lack it.
mkdir "$work/gaps"
cp "$film"/*.png "$work/gaps"
ffmpeg -v error -f lavfi -i "color=gray:s=260x80:r=25,format=gray,geq=lum=170" -frames:v 1 "$work/blank.png" || exit 2
for k in 5 6 21; do cp "$work/blank.png" "$work/gaps/$k.png"; done
expect 0 "" "track of a film with gaps" "$post" track "$work/gaps" --fps 5000 --diameter 0.005
is "says how many frames are lost" 1 "$(grep -c 'gaps: frames without the ball .*: 3$' "$work/out")"
for k in {8..34}; do cp "$work/blank.png" "$work/gaps/$k.png"; done
expect 2 "gaps: error: the ball is lost in the 27 frames about the impact, from 7 to 33" "track across a gap" \
  "$post" track "$work/gaps" --fps 5000 --diameter 0.005
expect 2 "0.5 to 3 are possible" "track of what is smoothed away" \
  "$post" track "$film" --fps 5000 --diameter 0.005 --smoothing 4

# Frames of a run, of a ball as light as the ground and of one that differs from it in its blue alone.
cat >"$work/shot.cfg" <<'CFG'
title="shot"; duration=0.02; gravity=[0.0,0.0,-9.81];
chamber={shape="box";size=[0.06,0.06,0.06];};
balls={start="table";count=1;diameter=0.005;table=((0.03,0.03,0.03,0.0,0.0,-3.0));};
contact={rule="smooth";normal=0.8;};
record={frames=2000.0;collisions=true;};
CFG
"$bin/mill" run "$work/shot.cfg" --quiet -o "$work/shot.h5" >"$work/out" || exit 2
for look in "plain" "speed --map ember --scale 0:3"; do
  rm -rf "$work/shot" && mkdir "$work/shot"
  for k in {00..19}; do
    # shellcheck disable=SC2086
    "$post" frame "$work/shot.h5" --at "0.0$k" --camera side --parallel --size 320x240 \
      --hide drum,legend,histogram --colour $look -q -o "$work/shot/$k.png" || exit 2
  done
  expect 0 "" "track of a run's ball, colour $look" \
    "$post" track "$work/shot" --fps 1000 --diameter 0.005 --json
  is "finds it in all frames, and what the scene says" "yes" "$(/usr/bin/python3 - "$work/out" <<'PY'
import json, math, sys
shot = json.load(open(sys.argv[1]))["shots"][0]
v = math.sqrt(9 + 2 * 9.81 * (0.03 - 0.0025))
good = shot["before"] + shot["after"] == 20
good = good and abs(shot["speed"] / v - 1) < 0.01 and abs(shot["speed"] - v) < 3 * shot["speed_error"]
good = good and abs(shot["restitution"] - 0.8) < 4 * shot["restitution_error"] + 1e-4
print("yes" if good else shot)
PY
)"
done

# A disc that turns back faster than it came, as no plate makes it.
mkdir "$work/kick"
x='if(lt(N,16),40+9*N,184-16*(N-16))'
ffmpeg -v error -f lavfi -i "color=gray:s=260x80:r=25,format=gray,geq=lum='if(lt(hypot(X-($x),Y-40),18),60,170)'" \
  -frames:v 25 "$work/kick/%d.png" || exit 2
expect 2 "kick: error: no impact on a plate" "track of three films, two of which fail" \
  "$post" track "$work/kick" "$film" "$work/empty" --fps 5000 --diameter 0.005 --csv -o "$work/good.txt"
is "names the other, too" 1 "$(grep -c 'empty: error' "$work/err")"
is "and measures the third" 1 "$(grep -c '^[0-9]' "$work/good.txt")"
is "in its table, too" 1 "$(grep -c "^$film," "$work/out")"
for _ in 1 2 3 4 5 6 7; do grep -v '^# speed' "$work/pairs.txt"; done >"$work/many.txt"
expect 0 "" "that fit reads" "$post" fit <(cat "$work/many.txt" "$work/many.txt")

finish
