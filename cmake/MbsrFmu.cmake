# The static libraries that go into the shared object of FMUs: sets mbsr_fmu_archives, or MBSR_FMU to OFF where one is missing.
# SPDX-License-Identifier: BSD-3-Clause

set(mbsr_fmu_archives "")
set(mbsr_fmu_missing "")
get_target_property(mbsr_sundials_location SUNDIALS::ida LOCATION)
if(NOT mbsr_sundials_location)
    set(mbsr_sundials_location "/usr/lib")
endif()
get_filename_component(mbsr_sundials_folder "${mbsr_sundials_location}" DIRECTORY)

# The first of these archives that is there; what may be missing with newer or older ones has OPTIONAL as its last name.
function(mbsr_add_archive variable)
    set(names ${ARGN})
    list(REMOVE_ITEM names OPTIONAL)
    find_library(${variable} NAMES ${names} HINTS "${mbsr_sundials_folder}" PATH_SUFFIXES blas lapack)
    mark_as_advanced(${variable})
    if(${variable})
        set(mbsr_fmu_archives "${mbsr_fmu_archives};${${variable}}" PARENT_SCOPE)
    elseif(NOT "OPTIONAL" IN_LIST ARGN)
        list(GET names 0 name)
        set(mbsr_fmu_missing "${mbsr_fmu_missing} ${name}" PARENT_SCOPE)
    endif()
endfunction()

foreach(part IN ITEMS ida sunlinsolspgmr sunlinsoldense sunmatrixdense nvecserial)
    mbsr_add_archive(MBSR_FMU_${part} libsundials_${part}.a)
endforeach()
# Their common part is called generic up to version 6, core since.
mbsr_add_archive(MBSR_FMU_sundials libsundials_core.a libsundials_generic.a)
# Compiled for shared libraries, where a distribution has both.
mbsr_add_archive(MBSR_FMU_lapack liblapack_pic.a liblapack.a)
mbsr_add_archive(MBSR_FMU_blas libblas.a)

if(mbsr_fmu_missing)
    message(STATUS "Static libraries were not found (${mbsr_fmu_missing} ): the component fmu is left out")
    set(MBSR_FMU OFF)
endif()
