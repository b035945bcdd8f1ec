#!/usr/bin/env bash
# clean_roots_test.sh SOURCE BUILD: makes the packages of a build tree and tests them in the roots that are there.
set -euo pipefail
[ -n "${HALFLIGHT_PACKAGE_TESTS:-}" ] || { echo "skipped: takes minutes; HALFLIGHT_PACKAGE_TESTS=1 turns it on"; exit 77; }
roots="${HALFLIGHT_ROOTS:-/var/cache/halflight}"
[ -e "$roots/bookworm/.complete" ] || { echo "skipped: there is no root $roots/bookworm; scripts/test_packages.sh makes it"; exit 77; }
for tool in patchelf objdump dpkg-shlibdeps fakeroot; do
  command -v "$tool" >/dev/null || { echo "skipped: $tool is missing (apt-get install patchelf binutils dpkg-dev fakeroot)"; exit 77; }
done
"$1/scripts/package.sh" --build "$2" --out "$2/packages"
"$1/scripts/test_packages.sh" "$2/packages" "$2/apps/halflight/halflight" --cached
