# Libraries from Debian's source packages, for scripts that source this file and set:
#
#   here       the script's folder, with patches/LIBRARY-*.patch (first line of each: why)
#   top        a folder of the cache; sources, build and done are made in it
#   prefix     where libraries are installed; licences lie in prefix/licenses
#   flags      the compiler's, for C and C++
#   small      the same, for libraries that take no time in a bake
#   cc cxx ar  programs
#   configure  the words that begin a call of CMake
#   apt        the words that begin a call of apt-get and know deb and deb-src of the suites
jobs=2

fetch() { # PACKAGE SUITE [--tar-only]: its source, with Debian's patches where there are packaging files
  cd "$top/sources"
  rm -rf "${1:?}" "${1}_tmp"
  $apt source -qq --download-only ${3:-} "$1/$2" 2>&1 | grep -v 'unsandboxed as root' || true
  if [ -n "${3:-}" ]; then
    mkdir "$1"
    tar -xf "$1"_*.orig.tar.* -C "$1" --strip-components=1
  else
    dpkg-source --no-check -x "$1"_*.dsc "$1" >/dev/null
  fi
  for patch in "$here/patches/$1"-*.patch; do
    [ ! -e "$patch" ] || patch -d "$1" -p1 -s <"$patch"
  done
}

by_cmake() { # NAME OPTION…
  rm -rf "${top:?}/build/$1"
  $configure -S "$top/sources/$1" -B "$top/build/$1" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF \
    -DBUILD_TESTING=OFF "-DCMAKE_C_FLAGS=$flags" "-DCMAKE_CXX_FLAGS=$flags" "-DCMAKE_INSTALL_PREFIX=$prefix" \
    --log-level=WARNING "${@:2}"
  ninja -C "$top/build/$1" -j$jobs --quiet install
}

by_hand() { # LIBRARY COMPILER OPTIONS SOURCE…: for sources whose own build asks more than it builds
  local objects=$top/build/$1
  rm -rf "$objects" && mkdir -p "$objects"
  printf '%s\n' "${@:4}" | xargs -P $jobs -n 16 sh -c 'cd "$1"; shift; exec "$@"' - "$objects" "$2" $flags $3 -c
  rm -f "$prefix/lib/lib$1.a"
  $ar rcs "$prefix/lib/lib$1.a" "$objects"/*.o
}

pkgconfig() { # NAME VERSION LIBRARY
  printf 'Name: %s\nDescription: %s\nVersion: %s\nCflags: -I%s/include\nLibs: -L%s/lib -l%s\n' "$1" "$1" "$2" \
    "$prefix" "$prefix" "$3" >"$prefix/lib/pkgconfig/$1.pc"
}

packaged() { # PACKAGE SUITE FOLDER…: folders of /usr in its package, for libraries of headers alone
  local package=$1 folder
  cd "$top/sources"
  rm -rf "$package"_*.deb unpacked
  $apt download -qq "$package/$2" 2>&1 | grep -v 'unsandboxed as root' || true
  dpkg-deb -x "$package"_*.deb unpacked
  for folder in "${@:3}"; do cp -a "unpacked/usr/$folder" "$prefix"; done
  cp "unpacked/usr/share/doc/$package/copyright" "$prefix/licenses/$package.txt"
  rm -rf unpacked
}

source_license() { # PACKAGE: what Debian says about its source, or its own file
  local text=$top/sources/$1/debian/copyright
  [ -e "$text" ] || text=$(find "$top/sources/$1" -maxdepth 1 -name 'LICENSE*' -print -quit)
  cp "$text" "$prefix/licenses/$1.txt"
}

# Calls build_NAME for each name. What was built by the same recipe, flags and patches is kept, so that a run that was
# interrupted goes on.
build_all() { # NAME…
  local name recipe status
  mkdir -p "$top"/{sources,build,done} "$prefix"/{include,lib/pkgconfig,licenses}
  for name in "$@"; do
    recipe=$(echo "$flags"; declare -f "build_$name"; cat "$here/patches/$name"*-*.patch 2>/dev/null || true)
    recipe=$(sha256sum <<<"$recipe")
    [ "$(cat "$top/done/$name" 2>/dev/null)" != "$recipe" ] || continue
    echo "building $name $(date +%T)"
    set +e # as bash heeds -e in no command that || follows
    (set -e; "build_$name") >"$top/build/$name.log" 2>&1
    status=$?
    set -e
    if [ $status -ne 0 ]; then
      tail -30 "$top/build/$name.log" >&2
      echo "dependencies.sh: $name failed: its log is $top/build/$name.log" >&2
      exit 1
    fi
    echo "$recipe" >"$top/done/$name"
  done
}

# Recipes for build_all that do not depend on the system. What takes no time in a bake is built with $small.

build_zlib() {
  fetch zlib bookworm
  local from=$top/sources/zlib
  flags=$small by_hand z $cc "" "$from"/{adler32,crc32,deflate,inflate,inftrees,inffast,trees,zutil,compress,uncompr,infback}.c
  cp "$from"/{zlib,zconf}.h "$prefix/include"
}

build_openexr() {
  fetch openexr bookworm
  flags=$small by_cmake openexr -DOPENEXR_BUILD_TOOLS=OFF -DOPENEXR_INSTALL_EXAMPLES=OFF -DOPENEXR_INSTALL_DOCS=OFF
}

# The decoder of meshes, with the features of Debian's package.
build_draco() {
  fetch draco bookworm
  local from=$top/sources/draco/src/draco sources=()
  packaged libdraco-dev bookworm include
  sed -i /TRANSCODER/d "$prefix/include/draco/draco_features.h" # what that needs is not here
  cp "$prefix/include/draco/draco_features.h" "$from"
  mapfile -t sources < <(find "$from"/{attributes,core,mesh,metadata,point_cloud,compression/{attributes,bit_coders,entropy,mesh,point_cloud}} \
    -name '*.cc' | grep -v -e encode -e _test -e test_utils)
  flags=$small by_hand draco $cxx "-std=c++17 -I$top/sources/draco/src" "${sources[@]}"
  mkdir -p "$prefix/lib/cmake/draco"
  printf 'add_library(draco::draco STATIC IMPORTED)\nset_target_properties(draco::draco PROPERTIES IMPORTED_LOCATION %s)\n' \
    "$prefix/lib/libdraco.a" >"$prefix/lib/cmake/draco/draco-config.cmake"
}

build_libzstd() {
  fetch libzstd bookworm
  local from=$top/sources/libzstd/lib
  # With its worker threads, which change the bytes of what it writes.
  by_hand zstd $cc "-DZSTD_DISABLE_ASM -DZSTD_MULTITHREAD" "$from"/{common,compress,decompress}/*.c
  cp "$from"/{zstd,zstd_errors,zdict}.h "$prefix/include"
  pkgconfig libzstd 1.5.4 zstd
}

build_libpng() {
  fetch libpng1.6 bookworm
  local from=$top/sources/libpng1.6 sources=() part
  cp "$from/scripts/pnglibconf.h.prebuilt" "$from/pnglibconf.h"
  for part in "" error get mem pread read rio rtran rutil set trans wio write wtran wutil; do
    sources+=("$from/png$part.c")
  done
  flags=$small by_hand png $cc "-DPNG_INTEL_SSE_OPT=0 -I$prefix/include" "${sources[@]}"
  cp "$from"/{png,pngconf,pnglibconf}.h "$prefix/include"
}

build_libwebp() {
  fetch libwebp bookworm
  local from=$top/sources/libwebp
  by_hand webp $cc "-msse2 -I$from" "$from"/src/{dec,dsp,enc,utils}/*.c "$from"/sharpyuv/*.c
  mkdir -p "$prefix/include/webp"
  cp "$from"/src/webp/{decode,encode,types}.h "$prefix/include/webp"
  pkgconfig libwebp 1.2.4 webp
}

build_meshoptimizer() {
  fetch meshoptimizer bookworm
  sed -i "s/ -Werror//" "$top/sources/meshoptimizer/CMakeLists.txt" # of some compilers' warnings
  by_cmake meshoptimizer
}

build_xxhash() {
  fetch xxhash bookworm
  by_hand xxhash $cc "" "$top/sources/xxhash/xxhash.c"
  cp "$top/sources/xxhash/xxhash.h" "$prefix/include"
  pkgconfig libxxhash 0.8.1 xxhash
}

build_fmt() {
  fetch fmtlib bookworm
  flags=$small by_cmake fmtlib -DFMT_TEST=OFF -DFMT_DOC=OFF
}

build_spdlog() {
  fetch spdlog bookworm
  flags=$small by_cmake spdlog -DSPDLOG_FMT_EXTERNAL=ON -DSPDLOG_BUILD_EXAMPLE=OFF
}
