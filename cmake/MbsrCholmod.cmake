# CHOLMOD of SuiteSparse, for large models in the component fe: MBSR_CHOLMOD_LIBRARY and
# MBSR_CHOLMOD_INCLUDE, empty or NOTFOUND without.
# SPDX-License-Identifier: BSD-3-Clause

find_path(MBSR_CHOLMOD_INCLUDE cholmod.h PATH_SUFFIXES suitesparse)
find_library(MBSR_CHOLMOD_LIBRARY cholmod)
mark_as_advanced(MBSR_CHOLMOD_INCLUDE MBSR_CHOLMOD_LIBRARY)
if(NOT MBSR_CHOLMOD_INCLUDE OR NOT MBSR_CHOLMOD_LIBRARY)
    message(STATUS "CHOLMOD was not found: the component fe goes without, up to 5000 dofs")
    set(MBSR_CHOLMOD OFF)
endif()
