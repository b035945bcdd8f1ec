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
ar=emar apt=apt-get configure="emcmake cmake -DCMAKE_FIND_ROOT_PATH=$prefix"
mkdir -p $top
[ -e "$EM_CACHE" ] || cp -a /usr/share/emscripten/cache "$EM_CACHE"

# Libraries of templates and inline functions: Debian 12's packages as they are.
build_headers() {
  local package
  for package in libglm-dev libcli11-dev nlohmann-json3-dev libeigen3-dev; do packaged $package bookworm include share; done
  for package in libstb-dev libtinygltf-dev; do packaged $package bookworm include; done
}

build_zlib() {
  fetch zlib bookworm
  local from=$top/sources/zlib
  flags=$small by_hand z emcc "" "$from"/{adler32,crc32,deflate,inflate,inftrees,inffast,trees,zutil,compress,uncompr,infback}.c
  cp "$from"/{zlib,zconf}.h $prefix/include
}

build_imath() {
  fetch imath bookworm
  # The table of all half floats would be a quarter of a megabyte.
  flags=$small by_cmake imath -DIMATH_HALF_USE_LOOKUP_TABLE=OFF
}

build_openexr() {
  fetch openexr bookworm
  flags=$small by_cmake openexr -DOPENEXR_BUILD_TOOLS=OFF -DOPENEXR_INSTALL_EXAMPLES=OFF -DOPENEXR_INSTALL_DOCS=OFF
}

# The decoder of meshes, with the features of Debian 12's package.
build_draco() {
  fetch draco bookworm
  local from=$top/sources/draco/src/draco sources=()
  packaged libdraco-dev bookworm include
  sed -i /TRANSCODER/d $prefix/include/draco/draco_features.h # what that needs is not here
  cp $prefix/include/draco/draco_features.h "$from"
  mapfile -t sources < <(find "$from"/{attributes,core,mesh,metadata,point_cloud,compression/{attributes,bit_coders,entropy,mesh,point_cloud}} \
    -name '*.cc' | grep -v -e encode -e _test -e test_utils)
  flags=$small by_hand draco em++ "-std=c++17 -I$top/sources/draco/src" "${sources[@]}"
  mkdir -p $prefix/lib/cmake/draco
  printf 'add_library(draco::draco STATIC IMPORTED)\nset_target_properties(draco::draco PROPERTIES IMPORTED_LOCATION %s)\n' \
    $prefix/lib/libdraco.a >$prefix/lib/cmake/draco/draco-config.cmake
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

build_libzstd() {
  fetch libzstd bookworm
  local from=$top/sources/libzstd/lib
  # With its worker threads, which change the bytes of what it writes.
  by_hand zstd emcc "-DZSTD_DISABLE_ASM -DZSTD_MULTITHREAD" "$from"/{common,compress,decompress}/*.c
  cp "$from"/{zstd,zstd_errors,zdict}.h $prefix/include
  pkgconfig libzstd 1.5.4 zstd
}

build_libpng() {
  fetch libpng1.6 bookworm
  local from=$top/sources/libpng1.6 sources=() part
  cp "$from/scripts/pnglibconf.h.prebuilt" "$from/pnglibconf.h"
  for part in "" error get mem pread read rio rtran rutil set trans wio write wtran wutil; do
    sources+=("$from/png$part.c")
  done
  flags=$small by_hand png emcc "-DPNG_INTEL_SSE_OPT=0 -I$prefix/include" "${sources[@]}"
  cp "$from"/{png,pngconf,pnglibconf}.h $prefix/include
}

build_libwebp() {
  fetch libwebp bookworm
  local from=$top/sources/libwebp
  by_hand webp emcc "-msse2 -I$from" "$from"/src/{dec,dsp,enc,utils}/*.c "$from"/sharpyuv/*.c
  mkdir -p $prefix/include/webp
  cp "$from"/src/webp/{decode,encode,types}.h $prefix/include/webp
  pkgconfig libwebp 1.2.4 webp
}

build_meshoptimizer() {
  fetch meshoptimizer bookworm
  sed -i "s/ -Werror//" $top/sources/meshoptimizer/CMakeLists.txt # of variables that are unused with SIMD
  by_cmake meshoptimizer
}

build_xxhash() {
  fetch xxhash bookworm
  by_hand xxhash emcc "" $top/sources/xxhash/xxhash.c
  cp $top/sources/xxhash/xxhash.h $prefix/include
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
