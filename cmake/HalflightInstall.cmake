# What `cmake --install` puts in place: the program, the libraries, the headers (shading/*.h are GLSL includes too), and
# the CMake package `halflight`.
include(CMakePackageConfigHelpers)

set(HALFLIGHT_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/halflight)
string(REGEX MATCH "^[0-9]+" HALFLIGHT_EMBREE_MAJOR "${EMBREE_VERSION}")
if(OpenImageDenoise_FOUND)
    set(HALFLIGHT_USES_OIDN TRUE)
else()
    set(HALFLIGHT_USES_OIDN FALSE)
endif()

foreach(decoder draco meshoptimizer WEBP)
    if(${decoder}_FOUND)
        set(HALFLIGHT_USES_${decoder} TRUE)
    else()
        set(HALFLIGHT_USES_${decoder} FALSE)
    endif()
endforeach()

install(TARGETS halflight RUNTIME)
install(TARGETS halflight_base halflight_shading halflight_scene halflight_unwrap halflight_bake halflight_bake_cpu
                halflight_gpu halflight_frame halflight_render
    EXPORT halflightTargets ARCHIVE LIBRARY)
install(DIRECTORY include/halflight DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT halflightTargets NAMESPACE halflight:: DESTINATION ${HALFLIGHT_PACKAGE_DIR})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/halflightConfig.cmake.in
    ${PROJECT_BINARY_DIR}/halflightConfig.cmake INSTALL_DESTINATION ${HALFLIGHT_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/halflightConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/halflightConfig.cmake ${PROJECT_BINARY_DIR}/halflightConfigVersion.cmake
    DESTINATION ${HALFLIGHT_PACKAGE_DIR})
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
