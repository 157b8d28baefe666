# Programs made of one file that uses the public headers: examples and benchmarks.
# SPDX-License-Identifier: BSD-3-Clause

include(CheckCSourceCompiles)

# PETSc with numbers of type double, for the one who includes it; its own flags are left aside, which
# ask for an optimised build. Not under sanitizers: MPI leaks.
function(mbsr_find_petsc)
    find_package(PkgConfig QUIET)
    if(PkgConfig_FOUND AND NOT MBSR_SANITIZE AND NOT TARGET mbsr_petsc)
        pkg_check_modules(MBSR_PETSC QUIET PETSc>=3.17)
        if(MBSR_PETSC_FOUND)
            find_package(MPI QUIET COMPONENTS C)
        endif()
        if(MBSR_PETSC_FOUND AND MPI_C_FOUND)
            set(CMAKE_REQUIRED_INCLUDES ${MBSR_PETSC_INCLUDE_DIRS})
            set(CMAKE_REQUIRED_LIBRARIES ${MBSR_PETSC_LINK_LIBRARIES} MPI::MPI_C)
            check_c_source_compiles("#include <petscsys.h>
                #if defined PETSC_USE_COMPLEX || !defined PETSC_USE_REAL_DOUBLE
                #error
                #endif
                int main(void) { return 0; }" MBSR_PETSC_REAL)
        endif()
        if(MBSR_PETSC_REAL)
            add_library(mbsr_petsc INTERFACE)
            target_include_directories(mbsr_petsc SYSTEM INTERFACE ${MBSR_PETSC_INCLUDE_DIRS})
            target_link_libraries(mbsr_petsc INTERFACE ${MBSR_PETSC_LINK_LIBRARIES} MPI::MPI_C)
        endif()
    endif()
endfunction()

# mbsr_add_program(target source): links what the file includes. Sets mbsr_program_added to OFF in
# the caller's scope when the file needs a component, SUNDIALS or PETSc and this build has none.
function(mbsr_add_program target source)
    file(STRINGS "${source}" uses_ida REGEX "^#include [<\"]mbsrank/(ida|simulation|sundials)\\.h")
    file(STRINGS "${source}" uses_files REGEX "^#include [<\"]mbsrank/files\\.h")
    file(STRINGS "${source}" uses_sundials
         REGEX "^#include [<\"](ida|cvode|sundials|nvector|sunmatrix|sunlinsol)/")
    file(STRINGS "${source}" uses_cvode REGEX "^#include [<\"]cvode/")
    file(STRINGS "${source}" uses_fe REGEX "^#include [<\"]mbsrank/(fe|sid)\\.h")
    file(STRINGS "${source}" uses_petsc REGEX "^#include <petsc")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
    if(uses_petsc)
        mbsr_find_petsc()
        if(NOT TARGET mbsr_petsc)
            message(STATUS "Skipped: ${source}: no real PETSc 3.17 or newer "
                           "(libpetsc-real-dev), or under sanitizers")
            set(mbsr_program_added OFF PARENT_SCOPE)
            return()
        endif()
    endif()
    if(((uses_ida OR uses_sundials) AND NOT MBSR_IDA) OR (uses_files AND NOT MBSR_FILES) OR
       (uses_fe AND NOT MBSR_FE) OR (uses_cvode AND NOT TARGET SUNDIALS::cvode))
        set(mbsr_program_added OFF PARENT_SCOPE)
        return()
    endif()
    add_executable(${target} "${source}")
    mbsr_set_warnings(${target})
    target_link_libraries(${target} PRIVATE mbsrank::core)
    if(uses_ida)
        target_link_libraries(${target} PRIVATE mbsrank::ida)
    endif()
    if(uses_files)
        target_link_libraries(${target} PRIVATE mbsrank::files)
    endif()
    if(uses_fe)
        target_link_libraries(${target} PRIVATE mbsrank::fe)
    endif()
    if(uses_sundials)
        target_link_libraries(${target} PRIVATE ${mbsr_sundials_targets})
    endif()
    if(uses_cvode)
        target_link_libraries(${target} PRIVATE SUNDIALS::cvode)
    endif()
    if(uses_petsc)
        target_link_libraries(${target} PRIVATE mbsr_petsc)
    endif()
    if(UNIX)
        target_link_libraries(${target} PRIVATE m)
    endif()
    set(mbsr_program_added ON PARENT_SCOPE)
endfunction()
