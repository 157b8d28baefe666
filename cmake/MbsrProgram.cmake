# Programs made of one file that uses the public headers: examples and benchmarks.
# SPDX-License-Identifier: BSD-3-Clause

# mbsr_add_program(target source): links what the file includes. Sets mbsr_program_added to OFF in
# the caller's scope when the file needs the component ida or SUNDIALS and this build has neither.
function(mbsr_add_program target source)
    file(STRINGS "${source}" uses_ida REGEX "^#include [<\"]mbsrank/(ida|simulation|sundials)\\.h")
    file(STRINGS "${source}" uses_sundials
         REGEX "^#include [<\"](ida|cvode|sundials|nvector|sunmatrix|sunlinsol)/")
    file(STRINGS "${source}" uses_cvode REGEX "^#include [<\"]cvode/")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
    if(((uses_ida OR uses_sundials) AND NOT MBSR_IDA) OR (uses_cvode AND NOT TARGET SUNDIALS::cvode))
        set(mbsr_program_added OFF PARENT_SCOPE)
        return()
    endif()
    add_executable(${target} "${source}")
    mbsr_set_warnings(${target})
    target_link_libraries(${target} PRIVATE mbsrank::core)
    if(uses_ida)
        target_link_libraries(${target} PRIVATE mbsrank::ida)
    endif()
    if(uses_sundials)
        target_link_libraries(${target} PRIVATE ${mbsr_sundials_targets})
    endif()
    if(uses_cvode)
        target_link_libraries(${target} PRIVATE SUNDIALS::cvode)
    endif()
    if(UNIX)
        target_link_libraries(${target} PRIVATE m)
    endif()
    set(mbsr_program_added ON PARENT_SCOPE)
endfunction()
