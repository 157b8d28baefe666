# SUNDIALS 6.4 or newer with what the component ida uses; sets mbsr_sundials_targets.
# SPDX-License-Identifier: BSD-3-Clause

# The version file of SUNDIALS accepts one major version only, so the version is compared here.
find_package(SUNDIALS QUIET CONFIG
             COMPONENTS ida nvecserial sunmatrixdense sunlinsoldense sunlinsolspgmr)
if(NOT SUNDIALS_FOUND OR NOT TARGET SUNDIALS::ida)
    if(SUNDIALS_NOT_FOUND_MESSAGE)
        set(mbsr_reason "Its package says: ${SUNDIALS_NOT_FOUND_MESSAGE}. ")
    endif()
    message(FATAL_ERROR "SUNDIALS (6.4 or newer, with ida, nvecserial, sunmatrixdense, "
                        "sunlinsoldense and sunlinsolspgmr) was not found. ${mbsr_reason}"
                        "Set SUNDIALS_ROOT to where it is installed, "
                        "or MBSR_IDA=OFF to build without the component ida.")
endif()
if(SUNDIALS_VERSION VERSION_LESS 6.4)
    message(FATAL_ERROR "SUNDIALS ${SUNDIALS_VERSION} in ${SUNDIALS_DIR} is too old: 6.4 or newer "
                        "is needed. MBSR_IDA=OFF builds without the component ida.")
endif()

set(mbsr_sundials_targets
    SUNDIALS::ida SUNDIALS::nvecserial SUNDIALS::sunmatrixdense SUNDIALS::sunlinsoldense
    SUNDIALS::sunlinsolspgmr)
# Since version 7 the context and the types have a library of their own.
if(TARGET SUNDIALS::core)
    list(APPEND mbsr_sundials_targets SUNDIALS::core)
endif()
message(STATUS "SUNDIALS ${SUNDIALS_VERSION} in ${SUNDIALS_DIR}")
