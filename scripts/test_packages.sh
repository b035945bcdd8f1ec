#!/usr/bin/env bash
# Installs each package in clean roots without compilers, bakes and renders there, and compares with a build tree's program.
#
#   scripts/test_packages.sh PACKAGES HALFLIGHT [--blender] [--cached]
#
# PACKAGES is scripts/package.sh's output, HALFLIGHT the program to compare with. Bakes have the same bytes everywhere, pictures
# with the same driver. The roots: Debian 12; two systems with an older glibc, Debian 11 (2.31) and Ubuntu 22.04 (2.35, the
# oldest whose Mesa has Vulkan 1.3). They are made by debootstrap in $HALFLIGHT_ROOTS (default /var/cache/halflight) and kept
# there for the next run; each test gets a copy. Exit code 77, with a sentence, where that cannot be done: it needs root,
# debootstrap, ubuntu-keyring and, the first time, mirrors. --cached never makes a root. --blender also tests the extension,
# with the program of its wheel, in Debian 13's Blender 4.3 (1.7 GB the first time).
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
ubuntu_mirror="${HALFLIGHT_UBUNTU_MIRROR:-http://archive.ubuntu.com/ubuntu}"
# The wheel's name promises it (scripts/package.sh).
oldest_glibc=2.31
[ "$(id -u)" -eq 0 ] || skip "clean roots need root's rights"
unshare -m true 2>/dev/null || skip "this machine allows no mount namespaces"
command -v debootstrap >/dev/null || [ -x "$roots/bookworm/bin/sh" ] || skip "debootstrap is not installed (apt-get install debootstrap)"

make_root() { # SUITE [MIRROR OPTIONS…]
  [ -e "$roots/$1/.complete" ] && return
  [ "$cached" -eq 0 ] || skip "there is no root $roots/$1; scripts/test_packages.sh without --cached makes it"
  local suite="$1" from="${2:-$mirror}"
  rm -rf "${roots:?}/$suite"
  mkdir -p "$roots/archives"
  debootstrap --variant=minbase "${@:3}" "$suite" "$roots/$suite" "$from" >"$roots/$suite.log" 2>&1 ||
    skip "debootstrap $suite failed: $(tail -1 "$roots/$suite.log")"
  touch "$roots/$suite/.complete"
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
install="apt-get install -y -qq --no-install-recommends"
unpack="tar xzf /in/halflight-*.tar.gz -C /opt --strip-components=1"
bake_options="--quality preview --texels-per-meter 4 --probe-spacing 4 --quiet"
render_options="--size 320x180 --device cpu --quiet"
"$halflight" bake "$work/in/courtyard.glb" -o "$work/expected.glb" $bake_options
"$halflight" render "$work/expected.glb" -o "$work/expected.png" $render_options

fresh_root() { # SUITE
  rm -rf "$work/root"
  cp -a "$roots/$1" "$work/root"
  ! chroot "$work/root" sh -c 'command -v gcc || command -v cmake' >/dev/null || { echo "the root has a compiler" >&2; exit 1; }
}
same() { # FILE EXPECTED TEST
  cmp "$work/out/$1" "$work/$2" || { echo "$3: not the bytes of the build tree's" >&2; exit 1; }
  echo "$3: same bytes as the build tree's"
}
check_tarball() { # SUITE SYSTEM
  fresh_root "$1"
  inside "$work/root" "$unpack && /opt/bin/halflight bake /in/courtyard.glb -o /out/tarball.glb $bake_options"
  same tarball.glb expected.glb "tarball, $2, bake"
}
readme_line=$(grep -o '^python3 -m venv .*\.whl' README.md)
check_wheel() { # SUITE SYSTEM: by README's line
  fresh_root "$1"
  inside "$work/root" "$install python3-venv >/dev/null 2>&1
    cd /opt && cp /in/halflight-*.whl . && $readme_line >/dev/null
    cd /source && /opt/env/bin/python tests/package/wheel_check.py /in/courtyard.glb /out/wheel.glb $bake_options"
  same wheel.glb expected.glb "wheel, $2, bake"
}

make_root bookworm
check_tarball bookworm "Debian 12"
fresh_root bookworm
inside "$work/root" "$install /in/halflight_*.deb >/dev/null 2>&1
  halflight bake /in/courtyard.glb -o /out/deb.glb $bake_options
  test -s /usr/share/bash-completion/completions/halflight && test -s /usr/share/doc/halflight/schemas/bake_report.schema.json
  echo 'deb $mirror bookworm-backports main' >/etc/apt/sources.list.d/backports.list && apt-get update -qq
  $install -t bookworm-backports libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  halflight render /out/deb.glb -o /out/deb.png $render_options"
same deb.glb expected.glb "deb, Debian 12, bake"
same deb.png expected.png "deb, Debian 12, render"
check_wheel bookworm "Debian 12"

# Debian 11's Vulkan loader and driver load into the glibc that came along; the driver is too old, which is said.
make_root bullseye
check_tarball bullseye "Debian 11"
inside "$work/root" "ldd --version | grep -q ' $oldest_glibc\$' || { echo 'Debian 11 has another glibc than $oldest_glibc' >&2; exit 1; }
  $install libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  ! /opt/bin/halflight render /out/tarball.glb -o /out/none.png $render_options 2>/out/said
  grep -q 'llvmpipe .* is older than Vulkan 1.3' /out/said || { cat /out/said >&2; exit 1; }"
echo "tarball, Debian 11, render: $(sed 's/.*: //' "$work/out/said")"
check_wheel bullseye "Debian 11"

make_root jammy "$ubuntu_mirror" --components=main,universe
fresh_root jammy
inside "$work/root" "echo 'deb $ubuntu_mirror jammy-updates main universe' >>/etc/apt/sources.list && apt-get update -qq
  $install libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  $unpack && /opt/bin/halflight render /out/tarball.glb -o /out/jammy.png $render_options"
echo "tarball, Ubuntu 22.04, render: $(python3 tests/package/picture_difference.py "$work/out/jammy.png" "$work/expected.png")"

if [ "$blender" -eq 1 ]; then
  make_root trixie
  inside "$roots/trixie" "command -v blender >/dev/null || {
      apt-get update -qq
      apt-get install -y -qq --no-install-recommends blender python3-numpy libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1; }
    rm -rf /opt/halflight && mkdir /opt/halflight && tar xzf /in/halflight-*.tar.gz -C /opt/halflight --strip-components=1
    export HALFLIGHT_WHEEL=\$(echo /in/*.whl)
    for script in in_blender.py install_in_blender.py; do
      python3 /source/tests/blender/extension_test.py /opt/halflight/bin/halflight /source/blender \$script
    done" \
    >"$work/blender.log" 2>&1 || { cat "$work/blender.log" >&2; exit 1; }
  check_wheel trixie "Debian 13"
  grep -E 'Blender 4|against|switched off|program|whole' "$work/blender.log" | sort -u
fi
