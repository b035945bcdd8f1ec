#!/usr/bin/env bash
# Builds halflight for Linux on arm64, by Debian 12's cross compiler and its arm64 libraries, and makes its packages:
#
#   halflight_*_arm64.deb, halflight-dev_*_arm64.deb   for Debian 12
#   halflight-*-linux-aarch64.tar.gz                   unpack anywhere; run bin/halflight
#   halflight-*-manylinux_2_36_aarch64.whl             Python wheel with the program and a thin module
#
#   scripts/build-arm64.sh [--cached] [--program] [OUT]     packages into OUT (default out/packages)
#
# The libraries are in $HALFLIGHT_ROOTS/arm64 (default /var/cache/halflight/arm64); scripts/arm64/sysroot.sh unpacks them
# once. The program is built in build/arm64, without the window, and scripts/package.sh makes the packages. --program: the
# program alone. --cached: exit code 77, with a sentence, where compiler or libraries are not there yet.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/packaging/roots.sh

read_cross_options "$@"
needs="g++-aarch64-linux-gnu qemu-user-static"
for program in aarch64-linux-gnu-g++ qemu-aarch64-static; do
  if ! command -v $program >/dev/null; then
    [ "$cached" -eq 0 ] || skip "$program is not installed (apt-get install $needs)"
    echo "build-arm64.sh: $program is missing: apt-get install $needs" >&2
    exit 1
  fi
done
export HALFLIGHT_ARM64_SYSROOT="$roots/arm64/sysroot"
if [ "$cached" -eq 1 ]; then
  [ -e "$roots/arm64/done" ] || skip "there are no libraries in $roots/arm64; scripts/build-arm64.sh unpacks them"
else
  scripts/arm64/sysroot.sh
fi

cmake --preset arm64 --log-level=WARNING
cmake --build --preset arm64 -- --quiet
[ "$packages" -eq 1 ] || exit 0
scripts/package.sh --target arm64 --build build/arm64 --out "$out"
