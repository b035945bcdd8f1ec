#!/usr/bin/env bash
# Builds the baker as WebAssembly and makes the npm packages @halflight/cli and @halflight/bake.
#
#   scripts/build-wasm.sh [--cached] [OUT]     packages into OUT (default out/packages)
#
# Compiler and libraries are in $HALFLIGHT_ROOTS/wasm (default /var/cache/halflight/wasm), a Debian 13 root with its
# Emscripten; scripts/wasm/dependencies.sh builds the libraries. Both are made once; a run that was interrupted goes on.
# --cached: exit code 77, with a sentence, where they are not there yet. The program is built in build/wasm, and put into
# web/cli/wasm and web/bake/wasm.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/packaging/roots.sh

[ "${1:-}" != "--cached" ] || { cached=1; shift; }
[ $# -le 1 ] || { echo "usage: scripts/build-wasm.sh [--cached] [OUT]" >&2; exit 2; }
out=$(realpath -m "${1:-out/packages}")
root="$roots/wasm"
need_roots
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

make_wasm_root() {
  [ ! -e "$root/.emscripten" ] || return 0
  [ "$cached" -eq 0 ] || skip "there is no root $root; scripts/build-wasm.sh makes it"
  make_root trixie
  if [ ! -e "$root" ]; then
    rm -rf "$root.new"
    cp -a "$roots/trixie" "$root.new"
    mv "$root.new" "$root"
  fi
  # Sources and headers of the libraries are Debian 12's, for which the native packages are built too.
  printf '%s\n' "deb $mirror trixie main" "deb-src $mirror trixie main" "deb $mirror bookworm main" \
    "deb-src $mirror bookworm main" >"$root/etc/apt/sources.list"
  printf 'Package: *\nPin: release n=bookworm\nPin-Priority: 100\n' >"$root/etc/apt/preferences"
  inside "$root" "apt-get update -qq
    $install emscripten cmake ninja-build pkg-config dpkg-dev python3" >"$root.log" 2>&1 ||
    { tail -20 "$root.log" >&2; echo "build-wasm.sh: the root failed: $root.log" >&2; exit 1; }
  touch "$root/.emscripten"
}

make_wasm_root
inside "$root" /source/scripts/wasm/dependencies.sh
inside "$root" 'cd /source && cmake --preset wasm --log-level=WARNING && cmake --build --preset wasm -- --quiet'

cp build/wasm/apps/halflight/halflight.mjs "$work"
scripts/wasm/for_bundlers.sh "$work/halflight.mjs"
for package in cli bake; do
  rm -rf "web/$package/wasm" "web/$package/licenses"
  mkdir -p "web/$package/wasm"
  cp "$work/halflight.mjs" build/wasm/apps/halflight/halflight.wasm "web/$package/wasm"
  cp -r "$root/dependencies/prefix/licenses" "web/$package/licenses"
  cp src/base/mathematics/COPYRIGHT "web/$package/licenses/mathematics.txt"
done
if command -v npm >/dev/null; then
  mkdir -p "$out"
  for package in cli bake; do (cd "web/$package" && npm pack --silent --pack-destination "$out"); done
else
  echo "build-wasm.sh: npm is missing: no packages are made" >&2
fi
