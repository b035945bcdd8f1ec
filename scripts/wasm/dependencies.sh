#!/usr/bin/env bash
# Builds the libraries of the WebAssembly program, inside the Debian 13 root of scripts/build-wasm.sh, into
# /dependencies/prefix. A library whose recipe and patches are as before is kept, so an interrupted run goes on.
#
# Sources are Debian 12's, whose versions the native packages are made with; only oneTBB is Debian 13's, as older ones
# do not know WebAssembly. Embree and oneTBB lack their packaging files in the archive.
set -euo pipefail

here=$(dirname "${BASH_SOURCE[0]}")
top=/dependencies
prefix=$top/prefix
. "$here/../packaging/libraries.sh"
export EM_CACHE=$top/emscripten # Debian's is read-only
# -fwasm-exceptions cannot be mixed with -fexceptions; threads and SIMD hold for all objects or for none.
flags="-O3 -DNDEBUG -msimd128 -pthread -fwasm-exceptions"
small=${flags/-O3/-Os} # for what takes no time in a bake, and room in what is downloaded
cc=emcc cxx=em++ ar=emar apt=apt-get configure="emcmake cmake -DCMAKE_FIND_ROOT_PATH=$prefix"
mkdir -p $top
[ -e "$EM_CACHE" ] || cp -a /usr/share/emscripten/cache "$EM_CACHE"

# Libraries of templates and inline functions: Debian 12's packages as they are.
build_headers() {
  local package
  for package in libglm-dev libcli11-dev nlohmann-json3-dev libeigen3-dev; do packaged $package bookworm include share; done
  packaged libstb-dev bookworm include
}

build_imath() {
  fetch imath bookworm
  # The table of all half floats would be a quarter of a megabyte.
  flags=$small by_cmake imath -DIMATH_HALF_USE_LOOKUP_TABLE=OFF
}

build_onetbb() {
  fetch onetbb trixie --tar-only
  by_cmake onetbb -DTBB_STRICT=OFF -DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON -DTBB_TEST=OFF -DTBB_EXAMPLES=OFF \
    -DTBBMALLOC_BUILD=OFF
}

# What the bake traces: triangles, instances of them, one ray at a time.
build_embree() {
  fetch embree bookworm --tar-only
  local without=() kind
  for kind in QUAD CURVE SUBDIVISION USER GRID POINT; do without+=(-DEMBREE_GEOMETRY_$kind=OFF); done
  by_cmake embree -DEMBREE_STATIC_LIB=ON -DEMBREE_ISPC_SUPPORT=OFF -DEMBREE_TUTORIALS=OFF -DEMBREE_TASKING_SYSTEM=TBB \
    -DTBB_DIR=$prefix/lib/cmake/TBB -DEMBREE_MAX_ISA=SSE2 "-DFLAGS_SSE2=-msse -msse2" -DEMBREE_RAY_PACKETS=OFF \
    "${without[@]}"
}

build_tomlplusplus() {
  packaged libtomlplusplus-dev bookworm include
  mkdir -p $prefix/lib/cmake/tomlplusplus
  echo 'add_library(tomlplusplus::tomlplusplus INTERFACE IMPORTED)' >$prefix/lib/cmake/tomlplusplus/tomlplusplusConfig.cmake
}

# Of all that is linked: the libraries, and the C and C++ libraries that come with Emscripten.
build_licenses() {
  local name
  cp /usr/share/doc/emscripten/copyright $prefix/licenses/emscripten.txt
  for name in zlib imath openexr draco onetbb embree libzstd libpng1.6 libwebp meshoptimizer xxhash fmtlib spdlog; do
    source_license $name
  done
}

build_all headers zlib imath openexr draco onetbb embree libzstd libpng libwebp meshoptimizer xxhash fmt spdlog tomlplusplus \
  licenses
