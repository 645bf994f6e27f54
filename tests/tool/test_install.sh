#!/bin/bash
# An installed Eventmill is complete: programs run, a foreign program compiles against the
# pkg-config file (static and shared), uninstall leaves nothing behind.
set -eu
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT

# BUILD is where this kind of build (SAN, DEBUG) is, not the folder above it.
settings=("BUILD=$BUILD" SAN= DEBUG=)
make -s "${settings[@]}" DESTDIR="$root" PREFIX=/opt/mill install-files
top=$root/opt/mill

"$top/bin/mill" --version | grep -q '[0-9]\.[0-9]'
"$top/bin/millpost" --help | grep -q hist
"$top/bin/mill" check "$top/share/eventmill/geometries/simoloyer-2l.cfg" >/dev/null

# The program that docs/library.md begins with.
sed -n '/^```c$/,/^```$/{/^```/!p}' docs/library.md >"$root/use.c"

# A library with sanitizers takes a program with sanitizers.
sanitize=()
nm "$top/lib/libeventmill.a" 2>/dev/null | grep -q __asan_init &&
  sanitize=(-fsanitize=address -fsanitize=undefined)
compiler=gcc
[[ $(make -s "${settings[@]}" print-CC) == *clang* ]] && compiler=clang

export PKG_CONFIG_PATH=$top/lib/pkgconfig PKG_CONFIG_SYSROOT_DIR=
flags=$(pkg-config --define-variable=prefix="$top" --cflags --libs eventmill)
static=$(pkg-config --define-variable=prefix="$top" --static --cflags --libs eventmill)

# shellcheck disable=SC2086
"$compiler" "${sanitize[@]}" "$root/use.c" $flags -o "$root/shared"
# shellcheck disable=SC2086
"$compiler" "${sanitize[@]}" "$root/use.c" -Wl,-Bstatic ${static%% *} "-L$top/lib" -leventmill \
  -Wl,-Bdynamic ${static//-leventmill/} -o "$root/static"

# What it runs and what it records is the same.
use() { "$1" "$top/share/eventmill/geometries/simoloyer-2l.cfg" "$root/$2.h5" >"$root/$2.txt"; }
LD_LIBRARY_PATH=$top/lib use "$root/shared" shared
use "$root/static" static
for said in "$root/shared.txt" "$root/static.txt"; do
  [ "$(wc -l <"$said")" -eq 2 ] && [ "$(sort -u "$said" | wc -l)" -eq 1 ] || { cat "$said"; exit 1; }
  grep -qE '^[1-9][0-9]+ hard contacts, [0-9.]+ J' "$said" || { cat "$said"; exit 1; }
done
"$root/static" no.cfg none.h5 2>&1 | grep -q '^no.cfg: error: '
readelf -d "$root/shared" | grep -q 'NEEDED.*libeventmill\.so\.0'
if readelf -d "$root/static" | grep -q libeventmill; then
  echo "the static program wants the shared library"
  exit 1
fi

# All headers serve C++ as well.
cxx=g++
[ $compiler = gcc ] || cxx=clang++
if command -v $cxx >/dev/null; then
  {
    echo '#include <cstdio>'
    for header in "$top"/include/eventmill/*.h; do echo "#include <eventmill/${header##*/}>"; done
    echo 'int main() { std::puts(em_error_text(EM_INPUT)); }'
  } >"$root/use.cc"
  # shellcheck disable=SC2086
  $cxx -Wall -Wextra -Werror "${sanitize[@]}" "$root/use.cc" $flags -o "$root/use++"
  LD_LIBRARY_PATH=$top/lib "$root/use++" | grep -qx 'bad input'
fi

make -s "${settings[@]}" DESTDIR="$root" PREFIX=/opt/mill uninstall
left=$(find "$top" -type f -o -type l)
[ -z "$left" ] || { echo "left behind: $left"; exit 1; }

# The shared library shows what the headers declare, and nothing else.
nm -D --defined-only "$BUILD/libeventmill.so" | awk '$3 ~ /^em_/ { print $3 }' | sort >"$root/shown"
nm -g --defined-only "$BUILD/libeventmill.a" 2>/dev/null | awk 'NF == 3 { print $3 }' | sort -u >"$root/all"
grep -oh 'em_[a-z0-9_]*' include/eventmill/*.h | sort -u | comm -12 "$root/all" - | cmp - "$root/shown"

# Other flags of the linker, and a source that is gone, make the programs anew.
make -pq "${settings[@]}" >"$root/rules" || true
for made in mill millpost libeventmill.so; do
  grep "^$BUILD/$made:" "$root/rules" | grep -F "$BUILD/link" | grep -qF "$BUILD/members"
done
alone=("BUILD=$root/alone" SAN= DEBUG=)
make -s "${alone[@]}" "$root/alone/link" "$root/alone/members"
cp "$root/alone/link" "$root/flags"
make -s "${alone[@]}" LDFLAGS="-Wl,-rpath,'\$\$ORIGIN'" "$root/alone/link"
cmp -s "$root/alone/link" "$root/flags" && { echo "LDFLAGS are not noticed"; exit 1; }
grep -q "$root/alone/src/tool/mill.o" "$root/alone/members"

# What make cannot do, it says.
make -s "BUILD=$root/two words" help 2>&1 | grep -q 'without blanks'
make -s "${settings[@]}" PKG_CONFIG=nowhere packages 2>&1 | grep -q '^missing: pkg-config\.'

# A prefix with blanks and quotes: nothing beside it is touched.
settings+=(DESTDIR= "PREFIX=$root/it's a mill")
make -s "${settings[@]}" install-files
flags=$(PKG_CONFIG_PATH="$root/it's a mill/lib/pkgconfig" pkg-config --cflags eventmill)
eval "set -- $flags" # quoted for the shell
test -f "${1#-I}/eventmill/scene.h"
make -s "${settings[@]}" uninstall
left=$(find "$root/it's a mill" -type f -o -type l; ls -d "$root/it" 2>/dev/null) || true
[ -z "$left" ] || { echo "left behind: $left"; exit 1; }

# Letters that mean something to sed; a umask that leaves nothing to others; a prefix from nowhere.
settings=("BUILD=$BUILD" SAN= DEBUG= DESTDIR= "PREFIX=$root/a|b&c")
(umask 077 && make -s "${settings[@]}" install-files)
grep -qF "$root/a|b&c" "$root/a|b&c/lib/pkgconfig/eventmill.pc"
closed=$(find "$root/a|b&c" -type f ! -perm -044 -o -type d ! -perm -055)
[ -z "$closed" ] || { echo "closed to others: $closed"; exit 1; }
if make -s "BUILD=$BUILD" SAN= DEBUG= DESTDIR= PREFIX=here install-files 2>"$root/said"; then
  echo "a relative prefix is taken"
  exit 1
fi
grep -q "PREFIX must be absolute, found 'here'" "$root/said"
[ ! -e here ] || { echo "it left something"; exit 1; }

# A test that is built on its own takes the library as it is, with flags of its own.
make -s "${alone[@]}" "$root/alone/src/num/error.o"
cp "$root/alone/flags" "$root/flags"
make -s "${alone[@]}" "$root/alone/tests/unit/test_error.o"
cmp "$root/alone/flags" "$root/flags"
