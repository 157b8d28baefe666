# What all tests and examples have in common.
# SPDX-License-Identifier: BSD-3-Clause

# No test takes more than 30 s on a free processor, under sanitizers too (tests/support/duration.h);
# on a busy one it may take ten times as long. ctest runs them side by side, so that none may take
# several processors for linear algebra.
set(mbsr_test_timeout 300)
set(mbsr_test_environment "OPENBLAS_NUM_THREADS=1")
if(MBSR_TEST_LONG)
    set(mbsr_test_timeout 6000)
    list(APPEND mbsr_test_environment "MBSR_TEST_LONG=1")
endif()

# Those that take longest, which begin first.
set(mbsr_longest_tests
    "^(package\\.|program\\.viewer|example\\.1[28]|unit\\.(finite_solvers|loops_tree_start|stepper)|ida\\.(bead|beam|car_axis|space|small_models|linear)|fmu\\.sources|property\\.)")

# mbsr_set_test(name label property value...)
function(mbsr_set_test name label)
    set(cost 1)
    if(name MATCHES "${mbsr_longest_tests}")
        set(cost 10)
    endif()
    set_tests_properties(${name} PROPERTIES LABELS ${label} TIMEOUT ${mbsr_test_timeout}
                         COST ${cost} ENVIRONMENT "${mbsr_test_environment}" ${ARGN})
endfunction()
