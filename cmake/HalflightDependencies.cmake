# Everything comes from the distribution (scripts/install-packages.sh) or vcpkg.json; nothing is downloaded here.
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(glm REQUIRED)
find_package(spdlog REQUIRED)
# Debian's Imath package prints a STATUS paragraph about a Python library that comes in a package nobody needs here.
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(OpenEXR CONFIG QUIET)
unset(CMAKE_MESSAGE_LOG_LEVEL)
if(NOT TARGET OpenEXR::OpenEXR)
    message(FATAL_ERROR "OpenEXR 3 not found (libopenexr-dev, or vcpkg's openexr)")
endif()
message(STATUS "OpenEXR ${OpenEXR_VERSION}")
find_package(PNG REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(CLI11 REQUIRED)
find_package(Vulkan REQUIRED COMPONENTS glslangValidator)
find_package(PkgConfig REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
find_package(tomlplusplus REQUIRED)

# Header-only in Debian's package and in vcpkg's, each under its own folder.
find_path(STB_INCLUDE_DIR stb_image.h PATH_SUFFIXES stb REQUIRED)
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)

# Embree 4, or 3 on Debian 12. Sources include "bake_cpu/embree.h", which hides the difference.
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
    find_package(embree 3 REQUIRED)
endif()
message(STATUS "Embree ${EMBREE_VERSION}")

# Optional: another denoiser, where the distribution carries it.
find_package(OpenImageDenoise QUIET)
if(OpenImageDenoise_FOUND)
    message(STATUS "Open Image Denoise ${OpenImageDenoise_VERSION}")
endif()

# Optional: decoders of compressed glTF. A file that needs one that is missing is refused with the command that helps.
find_package(draco CONFIG QUIET)
find_package(meshoptimizer CONFIG QUIET)
pkg_check_modules(WEBP QUIET IMPORTED_TARGET libwebp)
foreach(decoder draco meshoptimizer WEBP)
    if(NOT ${decoder}_FOUND)
        message(STATUS "${decoder} not found: glTF files that need it are not read")
    endif()
endforeach()

# Optional: the window.
if(HALFLIGHT_VIEW)
    pkg_check_modules(SDL2 QUIET IMPORTED_TARGET sdl2)
    pkg_check_modules(IMGUI QUIET IMPORTED_TARGET imgui)
    if(NOT SDL2_FOUND OR NOT IMGUI_FOUND)
        message(STATUS "SDL2 or Dear ImGui not found: halflight view is not built")
    endif()
endif()

if(HALFLIGHT_TESTS)
    find_package(GTest REQUIRED)
    include(GoogleTest)
endif()
if(HALFLIGHT_BENCHMARKS)
    find_package(benchmark REQUIRED)
endif()
