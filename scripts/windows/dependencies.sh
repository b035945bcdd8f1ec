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
small=$flags
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
  for package in libstb-dev libvulkan-dev libtomlplusplus-dev; do packaged $package bookworm include; done
  mkdir -p "$prefix/lib/cmake/tomlplusplus"
  echo 'add_library(tomlplusplus::tomlplusplus INTERFACE IMPORTED)' >"$prefix/lib/cmake/tomlplusplus/tomlplusplusConfig.cmake"
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

build_imath() {
  fetch imath bookworm
  by_cmake imath
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
