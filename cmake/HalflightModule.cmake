# All sources of a module are compiled as one: what they include is read once, templates that they share are compiled
# once. The largest take 1.7 GB of memory. Whoever edits all day joins fewer (CONTRIBUTING.md). The asan preset
# compiles each by itself, which shows what a file forgot to include.
if(NOT DEFINED CMAKE_UNITY_BUILD)
    set(CMAKE_UNITY_BUILD ON)
endif()
if(NOT DEFINED CMAKE_UNITY_BUILD_BATCH_SIZE)
    set(CMAKE_UNITY_BUILD_BATCH_SIZE 0)
endif()

set(CMAKE_POSITION_INDEPENDENT_CODE ON)

add_library(halflight_options INTERFACE)
target_compile_features(halflight_options INTERFACE cxx_std_20)
if(MSVC)
    # /fp:precise fuses nothing.
    target_compile_options(halflight_options INTERFACE /fp:precise /utf-8 /bigobj /W3)
    target_compile_definitions(halflight_options INTERFACE NOMINMAX)
else()
    # No fused multiply-add behind our back: the same seed gives the same bytes on processors of one identity.
    # Nobody reads errno or floating-point traps after a square root.
    target_compile_options(halflight_options INTERFACE -ffp-contract=off -fno-math-errno -fno-trapping-math
        $<BUILD_INTERFACE:-Wall -Wextra -Wno-missing-field-initializers>
        $<$<BOOL:${HALFLIGHT_WERROR}>:-Werror>)
    # Sources this large take GCC up to 7 % less time where it collects garbage later, and 0.7 GB more memory.
    cmake_host_system_information(RESULT memory QUERY TOTAL_PHYSICAL_MEMORY) # MiB
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND memory GREATER 15000)
        target_compile_options(halflight_options INTERFACE $<BUILD_INTERFACE:--param=ggc-min-heapsize=1048576>) # KiB
    endif()
endif()
if(HALFLIGHT_SANITIZE)
    target_compile_options(halflight_options INTERFACE -fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
    target_link_options(halflight_options INTERFACE -fsanitize=address,undefined)
endif()
if(HALFLIGHT_SANITIZE_THREADS)
    target_compile_options(halflight_options INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
    target_link_options(halflight_options INTERFACE -fsanitize=thread)
endif()
if(HALFLIGHT_FUZZERS)
    target_compile_options(halflight_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# halflight_cold(TARGET [LEVEL]): optimizes a target by -O1, or LEVEL. For what runs as fast so, and compiles in a fifth
# less time.
function(halflight_cold target)
    set(level -O1)
    if(ARGC GREATER 1)
        set(level ${ARGV1})
    endif()
    target_compile_options(${target} PRIVATE $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:${level}>)
endfunction()

# halflight_module(NAME SOURCES … [PUBLIC libs…] [PRIVATE libs…] [COLD]): one static library per folder of src/, target
# halflight_NAME, alias halflight::NAME. Its public headers are include/halflight/NAME/. COLD: halflight_cold().
function(halflight_module name)
    cmake_parse_arguments(ARG "COLD" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    set(target halflight_${name})
    add_library(${target} STATIC ${ARG_SOURCES})
    add_library(halflight::${name} ALIAS ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    target_include_directories(${target}
        PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
        PRIVATE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE $<BUILD_INTERFACE:halflight_options> ${ARG_PRIVATE})
    target_compile_features(${target} PUBLIC cxx_std_20)
    if(ARG_COLD)
        halflight_cold(${target})
    endif()
endfunction()

# halflight_test(NAME SOURCES … [LIBS …] [LABELS …] [TIMEOUT seconds] [SUITES] [INTEGRATES]): one GoogleTest program; tests
# may include a module's private headers. ctest runs each test in a process of its own, or each suite with SUITES.
# INTEGRATES: the tests themselves sum formulas over many samples.
function(halflight_test name)
    cmake_parse_arguments(ARG "SUITES;INTEGRATES" "TIMEOUT" "SOURCES;LIBS;LABELS" ${ARGN})
    add_executable(test_${name} ${ARG_SOURCES})
    target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/tests)
    target_link_libraries(test_${name} PRIVATE halflight_options GTest::gtest_main GTest::gmock ${ARG_LIBS})
    # Names at file scope need to be unique in so many sources only.
    set_target_properties(test_${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 32)
    # GoogleTest macros after a bare "if" are fine.
    target_compile_options(test_${name} PRIVATE -Wno-dangling-else)
    # Tests take a third less to compile with -Og than with -O1, and no longer to run, but for sums of their own: those
    # would take up to ten times as long.
    if(ARG_INTEGRATES)
        halflight_cold(test_${name})
    else()
        halflight_cold(test_${name} -Og)
    endif()
    target_compile_definitions(test_${name} PRIVATE
        HALFLIGHT_SOURCE_DIR="${PROJECT_SOURCE_DIR}" HALFLIGHT_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared")
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT 600)
    endif()
    set(environment "")
    if(HALFLIGHT_SANITIZE AND "vulkan" IN_LIST ARG_LABELS)
        # Mesa's CPU driver leaks what it compiled, from code without a name that could be suppressed.
        set(environment ASAN_OPTIONS=detect_leaks=0)
    endif()
    if(ARG_SUITES)
        set(file ${CMAKE_CURRENT_BINARY_DIR}/test_${name}_suites.cmake)
        add_custom_command(TARGET test_${name} POST_BUILD VERBATIM
            COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:test_${name}> -D FILE=${file} -D LABELS=${ARG_LABELS}
                    -D TIMEOUT=${ARG_TIMEOUT} -D ENVIRONMENT=${environment}
                    -D TIMES=${PROJECT_SOURCE_DIR}/tests/nightly.cmake
                    -P ${PROJECT_SOURCE_DIR}/cmake/DiscoverSuites.cmake)
        # Until the program is built there is no file.
        file(WRITE ${file}.include "if(EXISTS [=[${file}]=])\n    include([=[${file}]=])\nendif()\n")
        set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file}.include)
        return()
    endif()
    if(environment)
        list(PREPEND environment ENVIRONMENT)
    endif()
    gtest_discover_tests(test_${name} DISCOVERY_TIMEOUT 120 TEST_LIST tests_of_${name}
        PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}" ${environment})
    # Their names are known when ctest starts.
    set(file ${CMAKE_CURRENT_BINARY_DIR}/test_${name}_times.cmake)
    file(WRITE ${file} "include([=[${PROJECT_SOURCE_DIR}/tests/nightly.cmake]=])\n"
        "foreach(test IN LISTS tests_of_${name})\n"
        "    halflight_time_label(\"\${test}\" \"${ARG_LABELS}\" time)\n"
        "    set_tests_properties(\"\${test}\" PROPERTIES LABELS \"${ARG_LABELS};\${time}\")\n"
        "endforeach()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()

# Labels the tests of this directory that are no GoogleTest programs by where they run.
function(halflight_label_tests)
    get_property(tests DIRECTORY PROPERTY TESTS)
    foreach(test IN LISTS tests)
        get_test_property(${test} LABELS labels)
        halflight_time_label(${test} "${labels}" time)
        set_property(TEST ${test} APPEND PROPERTY LABELS ${time})
    endforeach()
endfunction()
