#!/usr/bin/env bash
# Makes the Debian packages of each system in a root of that system, into OUT: halflight, halflight-view, halflight-dev.
#
#   scripts/package_debs.sh OUT [SUITE…]       default: bookworm (Debian 12), trixie (Debian 13), noble (Ubuntu 24.04)
#
# Roots and build folders are kept in $HALFLIGHT_ROOTS (default /var/cache/halflight), so that the next run builds what
# changed. A suite whose archive cannot be reached is skipped with a sentence; exit code 77 where none can be made.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/packaging/roots.sh

[ $# -gt 0 ] || { echo "usage: scripts/package_debs.sh OUT [SUITE…]" >&2; exit 2; }
mkdir -p "$1"
out=$(realpath "$1"); shift
suites=("$@")
[ $# -gt 0 ] || suites=(bookworm trixie noble)
need_roots
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

make_debs() { # SUITE
  local root="$roots/build-$1" log="$roots/build-$1.log"
  make_root "$1"
  if [ ! -e "$root" ]; then
    rm -rf "$root.new"
    cp -a "$roots/$1" "$root.new"
    mv "$root.new" "$root"
  fi
  rm -rf "$work/out"
  inside "$root" 'dpkg --configure -a && apt-get -f install -y -qq && apt-get update -qq
    /source/scripts/install-packages.sh --build
    cmake --preset release -S /source -B /build --log-level=WARNING
    cmake --build /build
    rm -rf /build/packages && cpack -G DEB --config /build/CPackConfig.cmake -B /build/packages
    mv /build/packages/*.deb /out' >"$log" 2>&1 || { tail -20 "$log" >&2; echo "package_debs.sh: $1 failed: $log" >&2; exit 1; }
  mv "$work"/out/*.deb "$out"
}

made=0
for suite in "${suites[@]}"; do
  status=0
  (make_debs "$suite") || status=$?
  case "$status" in
    0) made=$((made + 1)) ;;
    77) ;; # said why
    *) exit "$status" ;;
  esac
done
[ "$made" -gt 0 ] || exit 77
