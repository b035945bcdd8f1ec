# What `cmake --install` puts in place, in three components. runtime: the program, its manual pages and completions, the guide,
# the format and its schemas. view: the window. development: the libraries, the headers (shading/*.h are GLSL includes too), the CMake package
# `halflight` and a pkg-config file.
include(CMakePackageConfigHelpers)

set(HALFLIGHT_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/halflight)
string(REGEX MATCH "^[0-9]+" HALFLIGHT_EMBREE_MAJOR "${EMBREE_VERSION}")
foreach(decoder draco meshoptimizer WEBP)
    if(${decoder}_FOUND)
        set(HALFLIGHT_USES_${decoder} TRUE)
    else()
        set(HALFLIGHT_USES_${decoder} FALSE)
    endif()
endforeach()

# The project's licence, and those of the functions of mathematics, which every program and library contains.
set(HALFLIGHT_COPYRIGHT ${PROJECT_BINARY_DIR}/copyright)
file(READ LICENSE licence)
file(READ src/base/mathematics/COPYRIGHT licences_of_others)
file(WRITE ${HALFLIGHT_COPYRIGHT} "${licence}\n----------------------------------------------------------------------\n\n${licences_of_others}")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS LICENSE src/base/mathematics/COPYRIGHT)

install(TARGETS halflight RUNTIME COMPONENT runtime)
if(TARGET halflight_window)
    install(TARGETS halflight_window RUNTIME COMPONENT view)
    install(FILES ${PROJECT_BINARY_DIR}/cli_docs/man1/halflight-view.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
        COMPONENT view OPTIONAL)
    install(FILES ${HALFLIGHT_COPYRIGHT} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/halflight-view COMPONENT view)
endif()
# Each before those that it uses, as a linker reads them.
set(HALFLIGHT_ARCHIVES halflight_bake_cpu halflight_transport halflight_bake halflight_unwrap halflight_render
                       halflight_frame halflight_gpu halflight_scene halflight_base)
install(TARGETS ${HALFLIGHT_ARCHIVES} halflight_shading
    EXPORT halflightTargets ARCHIVE COMPONENT development LIBRARY COMPONENT development)
# The window is a part of the program, not of the libraries.
install(DIRECTORY include/halflight DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development PATTERN view EXCLUDE)
install(EXPORT halflightTargets NAMESPACE halflight:: DESTINATION ${HALFLIGHT_PACKAGE_DIR} COMPONENT development)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/halflightConfig.cmake.in
    ${PROJECT_BINARY_DIR}/halflightConfig.cmake INSTALL_DESTINATION ${HALFLIGHT_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/halflightConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/halflightConfig.cmake ${PROJECT_BINARY_DIR}/halflightConfigVersion.cmake
    DESTINATION ${HALFLIGHT_PACKAGE_DIR} COMPONENT development)

file(RELATIVE_PATH HALFLIGHT_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" HALFLIGHT_PC_PREFIX "${HALFLIGHT_PC_PREFIX}")
list(TRANSFORM HALFLIGHT_ARCHIVES PREPEND -l OUTPUT_VARIABLE HALFLIGHT_PC_LIBS)
list(JOIN HALFLIGHT_PC_LIBS " " HALFLIGHT_PC_LIBS)
string(APPEND HALFLIGHT_PC_LIBS " -lembree${HALFLIGHT_EMBREE_MAJOR}")
set(HALFLIGHT_PC_REQUIRES "libpng libzstd libxxhash spdlog tbb tomlplusplus")
if(HALFLIGHT_OPENEXR)
    string(PREPEND HALFLIGHT_PC_REQUIRES "OpenEXR ")
endif()
if(draco_FOUND)
    string(APPEND HALFLIGHT_PC_LIBS " -ldraco")
endif()
if(meshoptimizer_FOUND)
    string(APPEND HALFLIGHT_PC_LIBS " -lmeshoptimizer")
endif()
if(WEBP_FOUND)
    string(APPEND HALFLIGHT_PC_REQUIRES " libwebp")
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/halflight.pc.in ${PROJECT_BINARY_DIR}/halflight.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/halflight.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

install(FILES README.md CHANGELOG.md docs/guide.md docs/format.md docs/engines.md docs/conventions.md
    DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(FILES ${HALFLIGHT_COPYRIGHT} DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(FILES ${HALFLIGHT_COPYRIGHT} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/halflight-dev COMPONENT development)
install(DIRECTORY docs/guide docs/schemas DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
# Made when the program is linked (apps/halflight/CMakeLists.txt).
set(HALFLIGHT_CLI_DOCS ${PROJECT_BINARY_DIR}/cli_docs)
install(DIRECTORY ${HALFLIGHT_CLI_DOCS}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT runtime OPTIONAL
    PATTERN halflight-view.1 EXCLUDE)
install(FILES ${HALFLIGHT_CLI_DOCS}/halflight.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    RENAME halflight COMPONENT runtime OPTIONAL)
install(FILES ${HALFLIGHT_CLI_DOCS}/_halflight DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT runtime OPTIONAL)
install(FILES ${HALFLIGHT_CLI_DOCS}/halflight.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
    COMPONENT runtime OPTIONAL)

if(PROJECT_IS_TOP_LEVEL)
    include(HalflightPackages)
endif()
