#!/usr/bin/env bash
# Builds the libraries of halflight.exe into $HALFLIGHT_ROOTS/windows/prefix (default /var/cache/halflight), all of them
# static. A library whose recipe and patches are as before is kept, so an interrupted run goes on.
#
# Sources are those of Debian 12's packages, whose versions the Linux program is made with. Embree's and oneTBB's lack
# their packaging files in the archive.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../packaging/roots.sh"
. "$here/../packaging/libraries.sh"
top=$roots/windows
prefix=$top/prefix
flags="-O3 -DNDEBUG"
target=x86_64-w64-mingw32
cc=$target-gcc-posix cxx=$target-g++-posix ar=$target-gcc-ar-posix
export HALFLIGHT_WINDOWS_PREFIX=$prefix
command -v ccache >/dev/null && launcher="-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache" || launcher=
configure="cmake $launcher --toolchain $here/../../cmake/toolchains/mingw-x86_64.cmake"

# Package lists of its own: nothing of this system is changed.
apt="apt-get -o Dir::Etc::SourceList=$top/apt/sources.list -o Dir::Etc::SourceParts=/dev/null
  -o Dir::State::Lists=$top/apt/lists -o Dir::Cache=$top/apt/cache"
prepare_apt() {
  [ ! -e "$top/apt/.complete" ] || return 0
  mkdir -p "$top"/apt/{lists,cache}/partial
  printf '%s\n' "deb $mirror bookworm main" "deb-src $mirror bookworm main" >"$top/apt/sources.list"
  $apt update -qq
  touch "$top/apt/.complete"
}

# Libraries of templates and inline functions: Debian's packages as they are.
build_headers() {
  local package
  for package in libglm-dev libcli11-dev nlohmann-json3-dev libeigen3-dev; do packaged $package bookworm include share; done
  for package in libstb-dev libtinygltf-dev libvulkan-dev libtomlplusplus-dev; do packaged $package bookworm include; done
  mkdir -p "$prefix/lib/cmake/tomlplusplus"
  echo 'add_library(tomlplusplus::tomlplusplus INTERFACE IMPORTED)' >"$prefix/lib/cmake/tomlplusplus/tomlplusplusConfig.cmake"
}

build_zlib() {
  fetch zlib bookworm
  local from=$top/sources/zlib
  by_hand z $cc "" "$from"/{adler32,crc32,deflate,inflate,inftrees,inffast,trees,zutil,compress,uncompr,infback}.c
  cp "$from"/{zlib,zconf}.h "$prefix/include"
}

build_onetbb() {
  fetch onetbb bookworm --tar-only
  by_cmake onetbb -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBB_ENABLE_IPO=OFF -DTBBMALLOC_BUILD=OFF
  # A static oneTBB names CMake's threads without looking for them.
  sed -i '1i include(CMakeFindDependencyMacro)\nfind_dependency(Threads)' "$prefix/lib/cmake/TBB/TBBConfig.cmake"
}

# What the bake traces: triangles and instances of them, by single rays and packets, with masks as in Debian's library.
# Its AVX2 kernels call AVX's.
build_embree() {
  fetch embree bookworm --tar-only
  local options=() kind
  for kind in QUAD CURVE SUBDIVISION USER GRID POINT; do options+=(-DEMBREE_GEOMETRY_$kind=OFF); done
  for kind in SSE2 AVX AVX2; do options+=(-DEMBREE_ISA_$kind=ON); done
  for kind in SSE42 AVX512; do options+=(-DEMBREE_ISA_$kind=OFF); done
  by_cmake embree -DEMBREE_STATIC_LIB=ON -DEMBREE_ISPC_SUPPORT=OFF -DEMBREE_TUTORIALS=OFF -DEMBREE_RAY_MASK=ON \
    -DEMBREE_TASKING_SYSTEM=TBB -DEMBREE_MAX_ISA=NONE "${options[@]}"
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
  by_hand png $cc "-DPNG_INTEL_SSE_OPT=0 -I$prefix/include" "${sources[@]}"
  cp "$from"/{png,pngconf,pnglibconf}.h "$prefix/include"
}

build_imath() {
  fetch imath bookworm
  by_cmake imath
}

build_openexr() {
  fetch openexr bookworm
  by_cmake openexr -DOPENEXR_BUILD_TOOLS=OFF -DOPENEXR_INSTALL_EXAMPLES=OFF -DOPENEXR_INSTALL_DOCS=OFF
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
  by_hand draco $cxx "-std=c++17 -I$top/sources/draco/src" "${sources[@]}"
  mkdir -p "$prefix/lib/cmake/draco"
  printf 'add_library(draco::draco STATIC IMPORTED)\nset_target_properties(draco::draco PROPERTIES IMPORTED_LOCATION %s)\n' \
    "$prefix/lib/libdraco.a" >"$prefix/lib/cmake/draco/draco-config.cmake"
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
  sed -i "s/ -Werror//" "$top/sources/meshoptimizer/CMakeLists.txt" # of warnings of this compiler
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
  by_cmake fmtlib -DFMT_TEST=OFF -DFMT_DOC=OFF
}

build_spdlog() {
  fetch spdlog bookworm
  by_cmake spdlog -DSPDLOG_FMT_EXTERNAL=ON -DSPDLOG_BUILD_EXAMPLE=OFF
}

# Of all that is linked: the libraries, and the C and C++ libraries that come with MinGW.
build_licenses() {
  local name
  for name in zlib imath openexr draco onetbb embree libzstd libpng1.6 libwebp meshoptimizer xxhash fmtlib spdlog; do
    source_license $name
  done
  cp /usr/share/doc/mingw-w64-common/copyright "$prefix/licenses/mingw-w64.txt"
  cp /usr/share/doc/gcc-mingw-w64-base/copyright "$prefix/licenses/gcc.txt"
}

prepare_apt
build_all headers zlib onetbb embree libzstd libpng imath openexr draco libwebp meshoptimizer xxhash fmt spdlog licenses
