#!/usr/bin/env bash
# Builds halflight.exe for Windows on x86-64, by Debian 12's MinGW, and makes its packages:
#
#   halflight-*-windows-x64.zip         the program, guide, schemas, licences: unpack anywhere, run bin\halflight.exe
#   halflight-*-win_amd64.whl           Python wheel with the program and a thin module
#   halflight-blender-*-windows-x64.zip the Blender extension with the wheel
#
#   scripts/build-windows.sh [--cached] [--program] [OUT]     packages into OUT (default out/packages)
#
# The libraries are in $HALFLIGHT_ROOTS/windows (default /var/cache/halflight/windows); scripts/windows/dependencies.sh
# builds them once, and a run that was interrupted goes on. The program is built in build/windows. --program: that alone.
# --cached: exit code 77, with a sentence, where compiler or libraries are not there yet.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/packaging/roots.sh

read_cross_options "$@"
needs="g++-mingw-w64-x86-64-posix"
if ! command -v x86_64-w64-mingw32-g++-posix >/dev/null; then
  [ "$cached" -eq 0 ] || skip "MinGW is not installed (apt-get install $needs)"
  echo "build-windows.sh: MinGW is missing: apt-get install $needs" >&2
  exit 1
fi
export HALFLIGHT_WINDOWS_PREFIX="$roots/windows/prefix"
if [ "$cached" -eq 1 ]; then
  [ -e "$roots/windows/done/licenses" ] || skip "there are no libraries in $roots/windows; scripts/build-windows.sh makes them"
else
  scripts/windows/dependencies.sh
fi

cmake --preset windows --log-level=WARNING
cmake --build --preset windows -- --quiet
[ "$packages" -eq 1 ] || exit 0

stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
version=$(sed -n 's/^project(halflight VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
name="halflight-$version-windows-x64"
cmake --install build/windows --prefix "$stage/$name" --component runtime --strip >/dev/null
mkdir -p "$out" "$stage/$name/share/doc/halflight/licences"
cp "$HALFLIGHT_WINDOWS_PREFIX"/licenses/* "$stage/$name/share/doc/halflight/licences"
rm -f "$out/$name.zip" "$out"/halflight-*-win_amd64.whl "$out/halflight-blender-$version-windows-x64.zip"
python3 scripts/packaging/make_zip.py "$stage/$name" "$out/$name.zip"
wheel=$(python3 scripts/packaging/make_wheel.py "$stage/$name" "$version" win_amd64 "$out")
python3 blender/make_zip.py "$out/halflight-blender-$version-windows-x64.zip" --wheel "$wheel"
ls -l "$out/$name.zip" "$wheel" "$out/halflight-blender-$version-windows-x64.zip" | awk '{ printf "%9.1f MB  %s\n", $5 / 1e6, $9 }'
