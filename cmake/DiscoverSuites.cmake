# Writes a ctest file with one test per suite of a GoogleTest program: cmake -D PROGRAM=… -D FILE=… -D LABELS=… -D TIMEOUT=…
# -D TIMES=tests/nightly.cmake [-D ENVIRONMENT=…] -P DiscoverSuites.cmake. Tests of a suite may then share what is expensive (SetUpTestSuite()).
include(${TIMES})
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[^ \n]+\\." suites "${listed}")
set(text "")
foreach(suite IN LISTS suites)
    string(STRIP "${suite}" suite)
    string(REGEX REPLACE "\\.$" "" suite "${suite}")
    halflight_time_label(${suite} "${LABELS}" time)
    string(APPEND text "add_test([=[${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
        "set_tests_properties([=[${suite}]=] PROPERTIES LABELS [=[${LABELS};${time}]=] TIMEOUT ${TIMEOUT}")
    if(ENVIRONMENT)
        string(APPEND text " ENVIRONMENT [=[${ENVIRONMENT}]=]")
    endif()
    string(APPEND text ")\n")
endforeach()
file(WRITE ${FILE} "${text}")
