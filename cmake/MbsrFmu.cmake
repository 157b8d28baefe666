# The static libraries that go into the shared object of FMUs: sets mbsr_fmu_archives, or MBSR_FMU to OFF where one is missing.
# SPDX-License-Identifier: BSD-3-Clause

set(mbsr_fmu_archives "")
set(mbsr_fmu_missing "")
get_target_property(mbsr_sundials_location SUNDIALS::ida LOCATION)
if(NOT mbsr_sundials_location)
    set(mbsr_sundials_location "/usr/lib")
endif()
get_filename_component(mbsr_sundials_folder "${mbsr_sundials_location}" DIRECTORY)

# mbsr_add_archive(variable name...): the first of these that is there.
function(mbsr_add_archive variable)
    find_library(${variable} NAMES ${ARGN} HINTS "${mbsr_sundials_folder}")
    mark_as_advanced(${variable})
    if(${variable})
        set(mbsr_fmu_archives "${mbsr_fmu_archives};${${variable}}" PARENT_SCOPE)
    else()
        set(mbsr_fmu_missing "${mbsr_fmu_missing} ${ARGV1}" PARENT_SCOPE)
    endif()
endfunction()

foreach(part IN ITEMS ida sunlinsolspgmr sunlinsoldense sunmatrixdense nvecserial)
    mbsr_add_archive(MBSR_FMU_${part} libsundials_${part}.a)
endforeach()
# Their common part is called generic up to version 6, core since.
mbsr_add_archive(MBSR_FMU_sundials libsundials_core.a libsundials_generic.a)

if(mbsr_fmu_missing)
    message(STATUS "Static libraries were not found (${mbsr_fmu_missing} ): the component fmu is left out")
    set(MBSR_FMU OFF)
endif()
