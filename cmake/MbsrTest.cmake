# What all tests and examples have in common.
# SPDX-License-Identifier: BSD-3-Clause

# No test takes more than 30 s on a free processor, under sanitizers too (tests/support/duration.h);
# on a busy one it may take ten times as long. ctest runs them side by side, so that none may take
# several processors for linear algebra.
set(mbsr_test_timeout 300)
if(CMAKE_CROSSCOMPILING_EMULATOR)
    set(mbsr_test_timeout 3000)
endif()
set(mbsr_test_environment "OPENBLAS_NUM_THREADS=1")
# Models come and go by thousands: memory that glibc gives back each time, the kernel has to clear again.
list(APPEND mbsr_test_environment "MALLOC_TRIM_THRESHOLD_=1000000000" "MALLOC_MMAP_THRESHOLD_=33554432")
# Under gcov each test writes to a folder of its own, and takes its time (scripts/coverage.sh).
set(MBSR_TEST_COUNTERS "" CACHE PATH "Folder with a folder of gcov's counters for each test; empty: where objects are")
mark_as_advanced(MBSR_TEST_COUNTERS)
if(MBSR_TEST_COUNTERS)
    set(mbsr_test_timeout 1500)
endif()
if(MBSR_TEST_LONG)
    set(mbsr_test_timeout 6000)
    list(APPEND mbsr_test_environment "MBSR_TEST_LONG=1")
endif()

# Those that take longest begin first, and first of all those of the first list: what begins last is to be short.
string(JOIN "|" mbsr_first_tests "instructions\\.per_body" "web\\.package" "program\\.(commands|options|study|viewer)" "hygiene\\.(format|snippets)"
    "fmu\\.sources" "package\\." "unit\\.batch")
string(JOIN "|" mbsr_longest_tests "program\\." "hygiene\\.(finite|headers|tables)" "memcheck\\." "instructions\\." "faults\\." "fmu\\." "python\\.build"
    "example\\.(12|14|18|22|26|3[1257]|39)" "files\\.(damaged|xacro)" "linear\\.modes_near" "property\\." "reference\\.validation"
    "ida\\.(bead|beam|car_axis|flexible|linear|paper|space|small_|stiff)"
    "unit\\.(blocks|callers_|changed_fields|finite|fronts|loops_tree_start|model|newton|split|stepper|sweeps)")

# mbsr_set_test(name label property value...)
function(mbsr_set_test name label)
    set(environment ${mbsr_test_environment})
    if(MBSR_TEST_COUNTERS)
        list(APPEND environment "GCOV_PREFIX=${MBSR_TEST_COUNTERS}/${name}")
    endif()
    set(cost 1)
    if(name MATCHES "^(${mbsr_first_tests})")
        set(cost 100)
    elseif(name MATCHES "^(${mbsr_longest_tests})")
        set(cost 10)
    endif()
    set_tests_properties(${name} PROPERTIES LABELS ${label} TIMEOUT ${mbsr_test_timeout}
                         COST ${cost} ENVIRONMENT "${environment}" ${ARGN})
endfunction()

# mbsr_wants_test(variable name): whether MBSR_TEST_ONLY and MBSR_TEST_WITHOUT leave that test.
function(mbsr_wants_test variable name)
    set(${variable} ON PARENT_SCOPE)
    if((MBSR_TEST_WITHOUT AND name MATCHES "^(${MBSR_TEST_WITHOUT})$")
       OR (MBSR_TEST_ONLY AND NOT name MATCHES "^(${MBSR_TEST_ONLY})$"))
        set(${variable} OFF PARENT_SCOPE)
    endif()
endfunction()
