# halflight_cross_tests(NAME SCRIPT SECONDS CLASS…): nightly tests of the program for another system. scripts/build-NAME.sh
# builds it first; SCRIPT of this folder runs a class of tests for up to so many seconds. Exit code 77: skipped.
function(halflight_cross_tests name script seconds)
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    add_test(NAME ${name}.build COMMAND bash ${PROJECT_SOURCE_DIR}/scripts/build-${name}.sh --cached --program)
    set_tests_properties(${name}.build PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 3600 LABELS "${name};nightly" FIXTURES_SETUP ${name})
    foreach(class ${ARGN})
        add_test(NAME ${name}.${class}
            COMMAND Python3::Interpreter ${CMAKE_CURRENT_SOURCE_DIR}/${script} $<TARGET_FILE:halflight> ${PROJECT_SOURCE_DIR}/../shared ${class})
        set_tests_properties(${name}.${class} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT ${seconds} LABELS "${name};nightly"
            FIXTURES_REQUIRED ${name})
    endforeach()
endfunction()
