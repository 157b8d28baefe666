# Compiler flags for this project's own targets; none of them reaches an installed target.
# SPDX-License-Identifier: BSD-3-Clause

if(MBSR_SANITIZE)
    # -O1 finds what -O0 finds, in a third of the time; line numbers are all that reports need.
    add_compile_options(-fsanitize=${MBSR_SANITIZE} -fno-sanitize-recover=all
                        -fno-omit-frame-pointer $<$<CONFIG:Debug>:-O1> $<$<CONFIG:Debug>:-g1>)
    add_link_options(-fsanitize=${MBSR_SANITIZE})
endif()

function(mbsr_set_warnings target)
    if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
        target_compile_options(${target} PRIVATE
            -Wall -Wextra -Wpedantic -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wvla
            -Wconversion)
        if(MBSR_WERROR)
            target_compile_options(${target} PRIVATE -Werror)
        endif()
    elseif(MSVC)
        target_compile_options(${target} PRIVATE /W4 $<$<BOOL:${MBSR_WERROR}>:/WX>)
    endif()
endfunction()
