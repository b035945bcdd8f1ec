#!/usr/bin/env bash
# bare_root_test.sh SOURCE BUILD: makes tarball and wheel of a build tree and runs the tarball's program in a root that holds glibc
# and nothing else, without debootstrap. tests/package/clean_roots_test.sh installs all packages in whole systems.
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

mkdir -p "$root"/{opt,proc,dev,tmp,lib64}
libc=$(ldd /bin/true | sed -n 's/.*libc.so.6 => \([^ ]*\).*/\1/p')
mkdir -p "$root$(dirname "$libc")"
for name in libc.so.6 libm.so.6 libdl.so.2 libpthread.so.0 librt.so.1; do cp -L "$(dirname "$libc")/$name" "$root$(dirname "$libc")"; done
cp -L /lib64/ld-linux-x86-64.so.2 "$root/lib64"
tar xzf "$packages"/halflight-*.tar.gz -C "$root/opt" --strip-components=1
cp "$source/assets/courtyard.glb" "$root"
unshare -rm bash -ec 'mount --rbind /proc "$0/proc"; mount --rbind /dev "$0/dev"
  chroot "$0" /opt/bin/halflight bake /courtyard.glb -o /tarball.glb $1' "$root" "$options"
cmp "$root/tarball.glb" "$work/expected.glb"
echo "tarball, glibc alone, bake: same bytes as the build tree's"

# The wheel holds the same program, and says which glibc the files ask for.
wheel=$(echo "$packages"/halflight-*.whl)
python3 -m zipfile -e "$wheel" "$work/wheel"
diff -r "$work/wheel/halflight/program/bin" "$root/opt/bin"
diff -r "$work/wheel/halflight/program/lib" "$root/opt/lib"
newest=$(find "$root/opt/bin" "$root/opt/lib" -type f -exec objdump -T {} + | grep -o 'GLIBC_2\.[0-9]*' | sort -t. -k2n | tail -n 1)
[[ "$wheel" == *"-manylinux_2_${newest#GLIBC_2.}_"* ]] || { echo "$wheel does not say $newest" >&2; exit 1; }
chmod +x "$work/wheel/halflight/program/bin/halflight"
(cd "$work" && PYTHONPATH="$work/wheel" python3 "$source/tests/package/wheel_check.py" "$source/assets/courtyard.glb" "$work/wheel.glb" $options)
cmp "$work/wheel.glb" "$work/expected.glb"
echo "wheel, $newest: same bytes as the build tree's"
