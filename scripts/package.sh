#!/usr/bin/env bash
# Makes all packages from one CMake install, into out/packages:
#
#   halflight*.deb                          Debian 12 and 13, Ubuntu 24.04, each made in its root (scripts/package_debs.sh);
#                                           where no roots can be made, this system's
#   halflight-*-linux-*.tar.gz              relocatable, glibc included: unpack anywhere, run bin/halflight
#   halflight-*.whl                         Python wheel with the program and a thin module
#   halflight-blender-*.zip                 the Blender extension, with the wheel and without
#   halflight-three-*.tgz and others        the packages of web/, as npm would publish them, where npm is there
#
#   scripts/package.sh [--build DIR] [--out DIR] [--no-deb] [--target arm64]
#
# --build packages a build tree that is there instead of building the release preset; its .deb are for this
# system. Tarball and wheel use the system's glibc where it is new enough, and bring one along for older systems.
# --target: of a build tree for another machine, .deb, tarball and wheel alone (scripts/build-arm64.sh).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. scripts/packaging/roots.sh

build="" out=out/packages deb=1 target="" machine=$(uname -m)
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build="$2"; shift 2 ;;
    --out) out="$2"; shift 2 ;;
    --no-deb) deb=0; shift ;;
    --target) target="$2"; shift 2 ;;
    *) echo "usage: scripts/package.sh [--build DIR] [--out DIR] [--no-deb] [--target arm64]" >&2; exit 2 ;;
  esac
done
other=() # of another machine: what bundle_libraries.py asks for
case "$target" in
  "") ;;
  arm64)
    machine=aarch64 sysroot=${HALFLIGHT_ARM64_SYSROOT:-$roots/arm64/sysroot}
    other=("$machine" "$sysroot" qemu-aarch64-static)
    build="${build:-build/arm64}" ;;
  *) echo "package.sh: --target must be arm64, not '$target'" >&2; exit 2 ;;
esac
tools="patchelf objdump"
[ "$deb" -eq 0 ] || tools+=" dpkg-shlibdeps fakeroot"
for tool in $tools; do
  command -v "$tool" >/dev/null || { echo "package.sh: $tool is missing: apt-get install patchelf binutils dpkg-dev fakeroot" >&2; exit 1; }
done
built=0
if [ -z "$build" ]; then
  build=build/release built=1
  cmake --preset release --log-level=WARNING
  cmake --build --preset release
fi

mkdir -p "$out"
out=$(cd "$out" && pwd)
[ -n "$target" ] || rm -f "$out"/halflight*
rm -f "$out"/halflight*_"$target".deb "$out"/halflight-*"$machine".{tar.gz,whl}
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:STATIC=//p' "$build/CMakeCache.txt")

if [ "$deb" -eq 1 ]; then
  status=77
  [ "$built" -eq 0 ] || { status=0; scripts/package_debs.sh "$out" || status=$?; }
  if [ "$status" -eq 77 ]; then # of this system alone
    [ -z "$target" ] || export DEB_HOST_ARCH="$target" DPKG_ADMINDIR="$sysroot/var/lib/dpkg"
    cpack -G DEB --config "$build/CPackConfig.cmake" -B "$stage/deb" >"$stage/cpack.log" || { cat "$stage/cpack.log" >&2; exit 1; }
    mv "$stage"/deb/*.deb "$out"
  elif [ "$status" -ne 0 ]; then
    exit "$status"
  fi
fi

name="halflight-$version-linux-$machine"
cmake --install "$build" --prefix "$stage/$name" --component runtime --strip >/dev/null
needed=$(python3 scripts/packaging/bundle_libraries.py "$stage/$name" "${other[@]}")
tar -C "$stage" --sort=name --owner=0 --group=0 --numeric-owner --mtime=@1767225600 -cf - "$name" | gzip -9n >"$out/$name.tar.gz"

# The oldest glibc of a system that scripts/test_packages.sh installs the wheel on; pip refuses older ones by this name.
oldest=2.31
[ "$machine" = x86_64 ] || oldest=2.36 # the wheel's own: no older one was tried
wheel=$(python3 scripts/packaging/make_wheel.py "$stage/$name" "$version" "manylinux_${oldest/./_}_$machine" "$out")
if [ -z "$target" ]; then python3 blender/make_zip.py "$out/halflight-blender-$version.zip"; fi
# blender.org has no Blender for other machines with Linux; those of distributions take the zip without the program.
if [ "$machine" = x86_64 ]; then python3 blender/make_zip.py "$out/halflight-blender-$version-linux-$machine.zip" --wheel "$wheel"; fi

if [ -n "$target" ]; then
  : # the packages of web/ are those of all machines
elif command -v npm >/dev/null; then
  for package in three react aframe gltf-transform; do (cd "web/$package" && npm pack --silent --pack-destination "$out" >/dev/null); done
else
  echo "package.sh: npm is missing: the packages of web/ are left out" >&2
fi

ls -l "$out" | awk -v name="${target:+$target|$machine}" 'NR > 1 && $9 ~ name { printf "%9.1f MB  %s\n", $5 / 1e6, $9 }'
echo "package.sh: tarball and wheel use a system's glibc from $needed on, and elsewhere their own; pip takes the wheel from $oldest on"
