#!/usr/bin/env bash
# bare_root_test.sh SOURCE BUILD: makes tarball and wheel of a build tree and runs the tarball's program in roots that hold a shell
# and nothing else: with this system's glibc, and with none. tests/package/clean_roots_test.sh installs all packages in whole systems.
set -euo pipefail
source="$1" build="$2"
skip() { echo "skipped: $1"; exit 77; }
for tool in patchelf objdump; do
  command -v "$tool" >/dev/null || skip "$tool is missing (apt-get install patchelf binutils)"
done
unshare -rm true 2>/dev/null || skip "this machine allows no mount namespaces"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
packages="$work/packages" root="$work/root"
"$source/scripts/package.sh" --build "$build" --out "$packages" --no-deb
options="--quality preview --texels-per-meter 4 --probe-spacing 4 --quiet"
"$build/apps/halflight/halflight" bake "$source/assets/courtyard.glb" -o "$work/expected.glb" $options

# A root with a shell that has its C library to itself, in /shell, so that nothing else finds it.
mkdir -p "$root"/{opt,proc,dev,tmp,bin,shell,lib64}
loader=$(patchelf --print-interpreter /bin/sh)
folder=$(dirname "$(ldd /bin/sh | sed -n 's/.*libc.so.6 => \([^ ]*\).*/\1/p')")
cp -L /bin/sh "$root/bin/sh"
cp -L "$loader" "$root/shell/loader"
cp -L "$folder/libc.so.6" "$root/shell"
patchelf --set-interpreter /shell/loader --force-rpath --set-rpath /shell "$root/bin/sh"
tar xzf "$packages"/halflight-*.tar.gz -C "$root/opt" --strip-components=1
cp "$source/assets/courtyard.glb" "$root"
baked() { # NAME SYSTEM: bakes in the root
  unshare -rm bash -ec 'mount --rbind /proc "$0/proc"; mount --rbind /dev "$0/dev"
    chroot "$0" /opt/bin/halflight bake /courtyard.glb -o "/$1" $2' "$root" "$1" "$options"
  cmp "$root/$1" "$work/expected.glb"
  echo "tarball, $2, bake: same bytes as the build tree's"
}
baked bundled.glb "no glibc in the system"

# With the system's glibc the bundled one is not read.
mkdir -p "$root$folder"
cp -L "$loader" "$root$loader"
for name in libc.so.6 libm.so.6 libdl.so.2 libpthread.so.0 librt.so.1; do cp -L "$folder/$name" "$root$folder"; done
mv "$root/opt/lib/halflight/glibc" "$work/glibc"
baked system.glb "the system's glibc alone"
mv "$work/glibc" "$root/opt/lib/halflight/glibc"

# The wheel holds the same program. Its name promises the oldest glibc that scripts/test_packages.sh has a root with.
wheel=$(echo "$packages"/halflight-*.whl)
python3 -m zipfile -e "$wheel" "$work/wheel"
diff -r "$work/wheel/halflight/program/bin" "$root/opt/bin"
diff -r "$work/wheel/halflight/program/lib" "$root/opt/lib"
oldest=$(sed -n 's/^oldest_glibc=//p' "$source/scripts/test_packages.sh")
[[ "$wheel" == *"-manylinux_${oldest/./_}_"* ]] || { echo "$wheel does not say $oldest" >&2; exit 1; }
# zipfile gives no file the right to run, as Blender does not; the module gives it back.
! find "$work/wheel" -type f -perm /111 | grep . || exit 1
for glibc in system bundled; do
  (cd "$work" && HALFLIGHT_GLIBC=$glibc PYTHONPATH="$work/wheel" \
    python3 "$source/tests/package/wheel_check.py" "$source/assets/courtyard.glb" "$work/wheel.glb" $options)
  cmp "$work/wheel.glb" "$work/expected.glb"
  echo "wheel, $glibc glibc, bake: same bytes as the build tree's"
done

# Blender's zip has this wheel; the licences of the mathematics (src/base/mathematics) are in all of them.
python3 -m zipfile -e "$packages"/halflight-blender-*-linux-*.zip "$work/blender"
cmp "$(find "$work/blender" -name '*.whl')" "$wheel"
for text in "$root/opt/share/doc/halflight/copyright" "$work/wheel"/halflight-*.dist-info/LICENSE; do
  cmp "$text" "$build/copyright"
  for owner in "Arm Limited" "Sun Microsystems"; do grep -q "$owner" "$text" || { echo "$text does not name $owner" >&2; exit 1; }; done
done
