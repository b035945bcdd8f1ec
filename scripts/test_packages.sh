#!/usr/bin/env bash
# Installs each package in clean roots without compilers, bakes and renders there, and compares with a build tree's program.
#
#   scripts/test_packages.sh PACKAGES HALFLIGHT [--blender] [--cached]
#
# PACKAGES is scripts/package.sh's output, HALFLIGHT the program to compare with. Bakes have the same bytes everywhere, pictures
# with the same driver. The roots: Debian 12; two systems with an older glibc, Debian 11 (2.31) and Ubuntu 22.04 (2.35, the
# oldest whose Mesa has Vulkan 1.3); Debian 13 and Ubuntu 24.04 for their Debian packages. The roots are made by debootstrap
# in $HALFLIGHT_ROOTS (default /var/cache/halflight) and kept
# there for the next run; each test gets a copy. Exit code 77, with a sentence, where that cannot be done: it needs root,
# debootstrap, ubuntu-keyring and, the first time, mirrors. --cached never makes a root. --blender also tests the extension,
# with the program of its wheel, in Debian 13's Blender 4.3 (1.7 GB the first time).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=$(realpath "$1") halflight=$(realpath "$2"); shift 2
blender=0 cached=0
for argument in "$@"; do
  case "$argument" in
    --blender) blender=1 ;;
    --cached) cached=1 ;;
    *) echo "usage: scripts/test_packages.sh PACKAGES HALFLIGHT [--blender] [--cached]" >&2; exit 2 ;;
  esac
done
. scripts/packaging/roots.sh
# The wheel's name promises it (scripts/package.sh).
oldest_glibc=2.31
need_roots

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/in" "$work/out"
cp "$packages"/halflight* assets/courtyard.glb "$work/in"
unpack="tar xzf /in/halflight-*.tar.gz -C /opt --strip-components=1"
bake_options="--quality preview --texels-per-meter 4 --probe-spacing 4 --quiet"
render_options="--size 320x180 --device cpu --quiet"
"$halflight" bake "$work/in/courtyard.glb" -o "$work/expected.glb" $bake_options --write-images "$work/expected"
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

check_debs() { # SUITE SYSTEM RELEASE MESA: MESA is what render and window need
  ls "$work/in"/halflight-view_*-"$3"_*.deb >/dev/null 2>&1 || { echo "skipped: $packages has no packages for $2 (scripts/package_debs.sh)"; return; }
  (make_root "$1") || return 0 # it said why
  fresh_root "$1"
  inside "$work/root" "apt-get update -qq && $install /in/halflight_*-$3_*.deb >/dev/null 2>&1
    rm -rf /out/deb && halflight bake /in/courtyard.glb -o /out/deb.glb $bake_options --write-images /out/deb
    test -s /usr/share/bash-completion/completions/halflight && test -s /usr/share/doc/halflight/schemas/bake_report.schema.json
    ! halflight view /out/deb.glb 2>/out/said && grep -q 'package halflight-view' /out/said
    ! dpkg-query -W libsdl2-2.0-0 >/dev/null 2>&1 || test $1 = trixie
    $4 && $install xvfb xauth >/dev/null 2>&1
    halflight render /out/deb.glb -o /out/deb.png $render_options
    $install /in/halflight-view_*-$3_*.deb >/dev/null 2>&1
    xvfb-run -a halflight view /out/deb.glb --size 320x180 --device cpu --frames 5 | tee /out/window
    apt-get remove -y -qq halflight-view >/dev/null 2>&1 && ! halflight view /out/deb.glb 2>/out/said"
  grep -q '^5 frames' "$work/out/window" || { cat "$work/out/window" >&2; exit 1; }
  echo "halflight-view, $2: $(grep '^5 frames' "$work/out/window")"
  if [ "$1" = bookworm ]; then # the build tree's system
    same deb.glb expected.glb "deb, $2, bake"
    same deb.png expected.png "deb, $2, render"
  else
    echo "deb, $2, bake: $(python3 tests/package/lightmap_difference.py "$work/out/deb" "$work/expected")"
    echo "deb, $2, bake and render: $(python3 tests/package/picture_difference.py "$work/out/deb.png" "$work/expected.png")"
  fi
}

make_root bookworm
check_tarball bookworm "Debian 12"
# Its own Mesa cannot render, and the message names the cure.
inside "$work/root" "$install libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  ! /opt/bin/halflight render /out/tarball.glb -o /out/none.png $render_options 2>/out/said
  grep -q 'apt install -t bookworm-backports mesa-vulkan-drivers' /out/said || { cat /out/said >&2; exit 1; }"
echo "tarball, Debian 12, render: $(head -1 "$work/out/said")"
check_wheel bookworm "Debian 12"
mesa="$install libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1"
backports="echo 'deb $mirror bookworm-backports main' >/etc/apt/sources.list.d/backports.list && apt-get update -qq"
check_debs bookworm "Debian 12" debian12 "$backports && ${mesa/install/install -t bookworm-backports}"
check_debs trixie "Debian 13" debian13 "$mesa"
check_debs noble "Ubuntu 24.04" ubuntu24.04 "$mesa"
if (make_root noble); then check_wheel noble "Ubuntu 24.04"; fi # else it said why

# Debian 11's Vulkan loader and driver load into the glibc that came along; the driver is too old, which is said.
make_root bullseye
check_tarball bullseye "Debian 11"
inside "$work/root" "ldd --version | grep -q ' $oldest_glibc\$' || { echo 'Debian 11 has another glibc than $oldest_glibc' >&2; exit 1; }
  $install libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  ! /opt/bin/halflight render /out/tarball.glb -o /out/none.png $render_options 2>/out/said
  grep -q 'llvmpipe .* is older than Vulkan 1.3' /out/said || { cat /out/said >&2; exit 1; }"
echo "tarball, Debian 11, render: $(head -1 "$work/out/said")"
check_wheel bullseye "Debian 11"

make_root jammy
fresh_root jammy
inside "$work/root" "echo 'deb $ubuntu_mirror jammy-updates main universe' >>/etc/apt/sources.list && apt-get update -qq
  $install libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
  $unpack && /opt/bin/halflight render /out/tarball.glb -o /out/jammy.png $render_options"
echo "tarball, Ubuntu 22.04, render: $(python3 tests/package/picture_difference.py "$work/out/jammy.png" "$work/expected.png")"

# The guide's steps in the system's own Blender, with the zip that holds the wheel: install, bake, view.
check_blender() { # SUITE SYSTEM
  local root="$roots/blender-$1" step steps
  steps=$(sed -n '/^## Install in Blender/,/^## Bake/p' docs/guide/blender.md | grep -c '^[0-9]*\. ')
  [ "$steps" -ge 1 ] && [ "$steps" -le 6 ] || { echo "docs/guide/blender.md: $steps steps to install, not 1 to 6" >&2; exit 1; }
  step=$(sed -n 's/^1\. `\(apt install blender[^`]*\)` in a terminal.*/\1/p' docs/guide/blender.md)
  if [ ! -e "$root" ]; then
    rm -rf "$root.new"
    cp -a "$roots/$1" "$root.new"
    inside "$root.new" "apt-get update -qq; ${step/install/install -y -qq --no-install-recommends} >/dev/null 2>&1"
    mv "$root.new" "$root"
  fi
  inside "$root" "export HALFLIGHT_WHEEL=\$(echo /in/*.whl)
    for script in install_in_blender.py smoke_in_blender.py; do
      python3 /source/tests/blender/extension_test.py /none /source/blender \$script
    done" >"$work/blender.log" 2>&1 || { cat "$work/blender.log" >&2; exit 1; }
  echo "zip, $2: $(grep -m 1 -o '^Blender [0-9.]*' "$work/blender.log"): $step, the first of $steps steps; installed, baked, viewed, left"
}
if [ "$blender" -eq 1 ]; then
  check_blender bookworm "Debian 12"
  make_root trixie
  check_blender trixie "Debian 13"
  check_wheel trixie "Debian 13"
  inside "$roots/blender-trixie" "apt-get install -y -qq --no-install-recommends libvulkan1 mesa-vulkan-drivers >/dev/null 2>&1
    rm -rf /opt/halflight && mkdir /opt/halflight && tar xzf /in/halflight-*.tar.gz -C /opt/halflight --strip-components=1
    export HALFLIGHT_WHEEL=\$(echo /in/*.whl)
    python3 /source/tests/blender/extension_test.py /opt/halflight/bin/halflight /source/blender in_blender.py" \
    >"$work/blender.log" 2>&1 || { cat "$work/blender.log" >&2; exit 1; }
  grep -E 'Blender 4|against|switched off|program|whole' "$work/blender.log" | sort -u
fi
