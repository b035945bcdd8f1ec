#!/usr/bin/env bash
# Unpacks the libraries of a program for Linux on arm64 into $HALFLIGHT_ROOTS/arm64/sysroot (default
# /var/cache/halflight): Debian 12's arm64 packages of what scripts/install-packages.sh installs for a build. Nothing of
# this system is changed. A list of packages that is as before keeps the folder.
#
# Packages are unpacked, not installed, so this writes dpkg's database itself. It has what dpkg-query and dpkg-shlibdeps
# ask for: which package has a file, and which version of a package has a symbol.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../packaging/roots.sh"
top=$roots/arm64
new=$top/sysroot.new
# base-files has the licences that packages name, and the system's name.
wanted=(base-files libvulkan1 $(sed -n '/^build_packages=(/,/^)/p' "$here/../install-packages.sh" | grep -oE '[a-z0-9-]+-dev\b' | grep -v dpkg-dev))
recipe=$(cat "${BASH_SOURCE[0]}"; echo "${wanted[@]}")
recipe=$(sha256sum <<<"$recipe")
[ "$(cat "$top/done" 2>/dev/null)" != "$recipe" ] || exit 0

rm -rf "$new" "$top/apt"
mkdir -p "$new/var/lib/dpkg/info" "$top"/apt/{lists,cache}/partial "$top/apt/packages"
echo "deb [arch=arm64] $mirror bookworm main" >"$top/apt/sources.list"
touch "$top/apt/status"
apt="apt-get -qq -o Dir::Etc::SourceList=$top/apt/sources.list -o Dir::Etc::SourceParts=/dev/null -o APT::Architecture=arm64
  -o APT::Architectures=arm64 -o Dir::State::Lists=$top/apt/lists -o Dir::State::Status=$top/apt/status
  -o Dir::Cache=$top/apt/cache"
$apt update
mapfile -t packages < <($apt -s install --no-install-recommends "${wanted[@]}" | sed -n 's/^Inst \([^ ]*\) .*/\1/p')
echo "sysroot.sh: ${#packages[@]} packages"
(cd "$top/apt/packages" && $apt download "${packages[@]}" 2>&1 | grep -v 'unsandboxed as root' || true)

database=$new/var/lib/dpkg
echo 1 >"$database/info/format" # names of packages with their architecture
for file in "$top"/apt/packages/*.deb; do
  dpkg-deb -x "$file" "$new"
  name=$(dpkg-deb -f "$file" Package)
  [ "$(dpkg-deb -f "$file" Multi-Arch)" != same ] || name+=:$(dpkg-deb -f "$file" Architecture)
  { dpkg-deb -f "$file"; echo "Status: install ok installed"; echo; } >>"$database/status"
  # Files by their place on the target, and by that in this folder, which dpkg-shlibdeps asks for.
  dpkg-deb --fsys-tarfile "$file" | tar -t | sed 's#^\.##; s#/$##; /^$/d' >"$database/info/$name.list"
  sed -i "p; s#^#$top/sysroot#" "$database/info/$name.list"
  for part in shlibs symbols; do
    dpkg-deb -I "$file" "$part" >"$database/info/$name.$part" 2>/dev/null || rm "$database/info/$name.$part"
  done
done

# Links that lead to the root of the target, from where they are; Draco's CMake files, which alone name that root.
find "$new" -type l -lname '/*' | while read -r link; do
  ln -sfnr "$new$(readlink "$link")" "$link"
done
sed -i -E 's#"/usr/(lib|include)#"${CMAKE_SYSROOT}/usr/\1#g' "$new"/usr/lib/aarch64-linux-gnu/cmake/draco/draco-targets*.cmake
rm -rf "$top/sysroot"
mv "$new" "$top/sysroot"
rm -rf "$top/apt"
echo "$recipe" >"$top/done"
