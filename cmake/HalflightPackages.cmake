# The Debian packages (cpack -G DEB): halflight, halflight-view with the window, and halflight-dev for those who link.
# Their versions name the system that they are made on and for. scripts/package.sh makes all packages.
set(CPACK_PACKAGE_NAME halflight)
set(CPACK_PACKAGE_VENDOR "The Halflight authors")
set(CPACK_PACKAGE_CONTACT "The Halflight authors <halflight@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime development)
if(TARGET halflight_window)
    list(APPEND CPACK_COMPONENTS_ALL view)
endif()

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
if(CMAKE_CROSSCOMPILING AND CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64)
    # cpack is started with dpkg's database of the other system (scripts/package.sh).
    set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
    set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_SYSROOT}/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}
        ${CMAKE_SYSROOT}/lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()
cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${system_ID}${system_VERSION_ID})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME halflight)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
# Baking needs no Vulkan; rendering loads it.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "libvulkan1, mesa-vulkan-drivers | vulkan-icd")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Bakes lightmaps, shadowmasks and probes into glTF files, and renders them.")

set(CPACK_DEBIAN_VIEW_PACKAGE_NAME halflight-view)
set(CPACK_DEBIAN_VIEW_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_VIEW_PACKAGE_DEPENDS "halflight (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_DEBIAN_VIEW_PACKAGE_RECOMMENDS "libvulkan1, mesa-vulkan-drivers | vulkan-icd")
set(CPACK_COMPONENT_VIEW_DESCRIPTION "The window of Halflight: halflight view.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME halflight-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Static libraries, headers, CMake package and pkg-config file of Halflight.")
set(needs libdraco-dev libeigen3-dev libembree-dev libfmt-dev libglm-dev libmeshoptimizer-dev libopenexr-dev libpng-dev
    libspdlog-dev libtbb-dev libtomlplusplus-dev libvulkan-dev libwebp-dev libxxhash-dev libzstd-dev nlohmann-json3-dev pkg-config)
list(JOIN needs ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)
include(CPack)
