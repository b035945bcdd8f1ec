#!/usr/bin/env bash
# Installs each package in a clean Debian root without compilers, bakes and renders there, and compares bytes with those of a
# build tree's program.
#
#   scripts/test_packages.sh PACKAGES HALFLIGHT [--blender] [--cached]
#
# PACKAGES is scripts/package.sh's output, HALFLIGHT the program to compare with. Roots are made by debootstrap in
# $HALFLIGHT_ROOTS (default /var/cache/halflight) and kept there for the next run; each test gets a copy. Exit code 77, with a
# sentence, where that cannot be done: it needs root, debootstrap and, the first time, a Debian mirror. --cached never makes a
# root. --blender also tests the extension, with the program of its wheel, in Debian 13's Blender 4.3 (1.7 GB the first time).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

skip() { echo "skipped: $1"; exit 77; }
packages=$(realpath "$1") halflight=$(realpath "$2"); shift 2
blender=0 cached=0
for argument in "$@"; do
  case "$argument" in
    --blender) blender=1 ;;
    --cached) cached=1 ;;
    *) echo "usage: scripts/test_packages.sh PACKAGES HALFLIGHT [--blender] [--cached]" >&2; exit 2 ;;
  esac
done
roots="${HALFLIGHT_ROOTS:-/var/cache/halflight}"
mirror="${HALFLIGHT_MIRROR:-http://deb.debian.org/debian}"
[ "$(id -u)" -eq 0 ] || skip "clean roots need root's rights"
unshare -m true 2>/dev/null || skip "this machine allows no mount namespaces"
command -v debootstrap >/dev/null || [ -x "$roots/bookworm/bin/sh" ] || skip "debootstrap is not installed (apt-get install debootstrap)"

make_root() { # SUITE
  [ -e "$roots/$1/.complete" ] && return
  [ "$cached" -eq 0 ] || skip "there is no root $roots/$1; scripts/test_packages.sh without --cached makes it"
  rm -rf "${roots:?}/$1"
  mkdir -p "$roots/archives"
  debootstrap --variant=minbase "$1" "$roots/$1" "$mirror" >"$roots/$1.log" 2>&1 || skip "debootstrap $1 failed: $(tail -1 "$roots/$1.log")"
  touch "$roots/$1/.complete"
}

# Runs a command in a root. /in: the packages and the scene. /out: what comes back. Downloaded packages are kept.
inside() { # ROOT COMMAND
  mkdir -p "$1/in" "$1/out" "$1/source" "$roots/archives"
  unshare -m bash -ec '
    mount --bind "$3" "$1/in"; mount --bind "$4" "$1/out"; mount --bind "$5" "$1/source"
    mount --bind "$6" "$1/var/cache/apt/archives"
    mount -t proc proc "$1/proc"; mount --rbind /dev "$1/dev"
    exec chroot "$1" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive bash -ec "$2"
  ' inside "$1" "$2" "$work/in" "$work/out" "$PWD" "$roots/archives"
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/in" "$work/out"
cp "$packages"/halflight* assets/courtyard.glb "$work/in"
bake_options="--quality preview --texels-per-meter 4 --probe-spacing 4 --quiet"
render_options="--size 320x180 --device cpu --quiet"
"$halflight" bake "$work/in/courtyard.glb" -o "$work/expected.glb" $bake_options
"$halflight" render "$work/expected.glb" -o "$work/expected.png" $render_options

fresh_root() { # NAME
  rm -rf "$work/root"
  cp -a "$roots/bookworm" "$work/root"
  ! chroot "$work/root" sh -c 'command -v gcc || command -v cmake' >/dev/null || { echo "the root has a compiler" >&2; exit 1; }
}
same() { # FILE EXPECTED TEST
  cmp "$work/out/$1" "$work/$2" || { echo "$3: not the bytes of the build tree's" >&2; exit 1; }
  echo "$3: same bytes as the build tree's"
}

make_root bookworm
fresh_root
inside "$work/root" "tar xzf /in/halflight-*.tar.gz -C /opt && /opt/halflight-*/bin/halflight bake /in/courtyard.glb -o /out/tarball.glb $bake_options"
same tarball.glb expected.glb "tarball, Debian 12, bake"

fresh_root
inside "$work/root" "apt-get install -y -qq --no-install-recommends /in/halflight_*.deb >/dev/null 2>&1
  halflight bake /in/courtyard.glb -o /out/deb.glb $bake_options
  test -s /usr/share/bash-completion/completions/halflight && test -s /usr/share/doc/halflight/schemas/bake_report.schema.json
  echo 'deb $mirror bookworm-backports main' >/etc/apt/sources.list.d/backports.list && apt-get update -qq
  apt-get install -y -qq --no-install-recommends -t bookworm-backports libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  halflight render /out/deb.glb -o /out/deb.png $render_options"
same deb.glb expected.glb "deb, Debian 12, bake"
same deb.png expected.png "deb, Debian 12, render"

fresh_root
inside "$work/root" "apt-get install -y -qq --no-install-recommends python3-venv >/dev/null 2>&1
  python3 -m venv /opt/venv && /opt/venv/bin/pip install --no-index --quiet /in/halflight-*.whl
  cd /source && /opt/venv/bin/python tests/package/wheel_check.py /in/courtyard.glb /out/wheel.glb $bake_options"
same wheel.glb expected.glb "wheel, Debian 12, bake"

if [ "$blender" -eq 1 ]; then
  make_root trixie
  inside "$roots/trixie" "command -v blender >/dev/null || {
      apt-get update -qq
      apt-get install -y -qq --no-install-recommends blender python3-numpy libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1; }
    rm -rf /opt/halflight && mkdir /opt/halflight && tar xzf /in/halflight-*.tar.gz -C /opt/halflight --strip-components=1
    HALFLIGHT_WHEEL=\$(echo /in/*.whl) python3 /source/tests/blender/extension_test.py /opt/halflight/bin/halflight /source/blender" \
    >"$work/blender.log" 2>&1 || { cat "$work/blender.log" >&2; exit 1; }
  grep -E 'Blender 4|against|switched off|program|whole' "$work/blender.log" | sort -u
fi
