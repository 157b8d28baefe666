# A set of C11 sources of the core and of what FMUs call, which needs no option, no folder of headers and no other library
# than the C library's: each source stands at the top, path/name.c as path_name.c, headers below it with the paths they
# have; includes are relative, and mbsrank_set.h, included first, chooses what options choose elsewhere.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: cmake -DROOT=... -DSOURCES=a.c,b.c,... -DOUT=... -P SourceSet.cmake
# OUT has of each file a line "NAME LENGTH", then its bytes and a line's end.

cmake_minimum_required(VERSION 3.20)
string(REPLACE "," ";" sources "${SOURCES}")
file(WRITE "${OUT}.new" "")

# set_put(NAME TEXT)
function(set_put name text)
    string(LENGTH "${text}" length)
    file(APPEND "${OUT}.new" "${name} ${length}\n${text}\n")
endfunction()

# set_read(PATH UP TEXT): the file with relative includes, UP steps below the top; what it includes is added to `headers`, or
# to `standard`; with its condition, if that is all that depends on it, to `conditional`.
macro(set_read path up text)
    if("${path}" MATCHES "^mbsrank/")
        file(READ "${ROOT}/include/${path}" ${text})
    else()
        file(READ "${ROOT}/src/${path}" ${text})
    endif()
    string(REGEX MATCHALL "#if[^\n]*\n#include <[^>]+>\n#endif\n" included "${${text}}")
    list(APPEND conditional ${included})
    string(REGEX REPLACE "#if[^\n]*\n#include <[^>]+>\n#endif\n" "" unconditional "${${text}}")
    string(REGEX MATCHALL "#include [\"<][^\">]+" included "${unconditional}")
    foreach(line IN LISTS included)
        if(line MATCHES "^#include \"(.+)$")
            list(APPEND headers "${CMAKE_MATCH_1}")
        elseif(line MATCHES "^#include <(mbsrank/.+)$")
            list(APPEND headers "${CMAKE_MATCH_1}")
        elseif(line MATCHES "^#include <(.+)$")
            list(APPEND standard "${CMAKE_MATCH_1}")
        endif()
    endforeach()
    string(REGEX REPLACE "#include \"([^\"]+)\"" "#include \"${up}\\1\"" ${text} "${${text}}")
    string(REGEX REPLACE "#include <(mbsrank/[^>]+)>" "#include \"${up}\\1\"" ${text} "${${text}}")
endmacro()

set(headers)
set(standard)
set(conditional)
foreach(source IN LISTS sources)
    set_read("${source}" "" text)
    string(REPLACE "/" "_" name "${source}")
    if(source MATCHES "kernels_base[.]c$")
        set(text "#ifndef MBSR_WITHOUT_VECTORS\n${text}#else\nextern int mbsri_nothing;\n#endif\n")
    endif()
    set_put("${name}" "#include \"mbsrank_set.h\"\n${text}")
endforeach()

set(done)
while(headers)
    list(POP_FRONT headers header)
    if(header IN_LIST done)
        continue()
    endif()
    list(APPEND done "${header}")
    string(REGEX REPLACE "[^/]+" ".." up "${header}")
    string(REGEX REPLACE "[.][.]$" "" up "${up}")
    set_read("${header}" "${up}" text)
    set_put("${header}" "${text}")
endwhile()

list(REMOVE_DUPLICATES standard)
list(REMOVE_ITEM standard pthread.h stdatomic.h) # of threads, which the set has not
list(SORT standard)
set(text "/* What is chosen for a set of sources; every source includes this first.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Functions of the standard begin with FMI2_FUNCTION_PREFIX or FMI3_FUNCTION_PREFIX, the identifier of the model, unless
 * FMI2_OVERRIDE_FUNCTION_PREFIX or FMI3_OVERRIDE_FUNCTION_PREFIX is defined. All else is hidden. With
 * MBSR_WITHOUT_VECTORS, which compilers without the vector types of GCC have by themselves, all is plain C11. Where the
 * importer has headers of the standard (fmi2Functions.h, fmi3Functions.h), these declare and name the functions. */
#ifndef MBSRANK_SET_H
#define MBSRANK_SET_H

#include \"model_identifier.h\"

#define MBSR_STATIC
#define MBSR_API
#define MBSR_BUILDING
#define MBSR_OWN_LAPACK
#if !defined(__GNUC__) && !defined(MBSR_WITHOUT_VECTORS)
#define MBSR_WITHOUT_VECTORS
#endif

")
foreach(header IN LISTS standard)
    string(APPEND text "#include <${header}>\n")
endforeach()
list(REMOVE_DUPLICATES conditional)
list(SORT conditional)
foreach(header IN LISTS conditional)
    string(APPEND text "${header}")
endforeach()
foreach(version IN ITEMS 2 3)
    string(APPEND text "
#if defined(FMI${version}_FUNCTION_PREFIX) && defined(__has_include)
#if __has_include(\"fmi${version}Functions.h\")
#include \"fmi${version}Functions.h\"
#define MBSRI_FMI${version}_FUNCTIONS_H
#endif
#endif
")
endforeach()
string(APPEND text "
#if defined(__GNUC__) && !defined(_WIN32)
#pragma GCC visibility push(hidden)
#pragma GCC diagnostic ignored \"-Wpsabi\"
#endif

#define MBSRI_PREFIXED_AS(prefix, name) prefix##name
#define MBSRI_PREFIXED(prefix, name) MBSRI_PREFIXED_AS(prefix, name)
")
foreach(version IN ITEMS 2 3)
    file(READ "${ROOT}/src/fmu/fmi${version}_functions.h" declared)
    string(REGEX MATCHALL "[^a-zA-Z0-9_]fmi${version}[A-Z][A-Za-z0-9]*[(]" names "${declared}")
    list(REMOVE_DUPLICATES names)
    string(APPEND text "\n#if defined(FMI${version}_FUNCTION_PREFIX) && !defined(FMI${version}_OVERRIDE_FUNCTION_PREFIX) && \\
    !defined(MBSRI_FMI${version}_FUNCTIONS_H)\n")
    foreach(name IN LISTS names)
        string(REGEX REPLACE "[^a-zA-Z0-9_]" "" name "${name}")
        string(APPEND text "#define ${name} MBSRI_PREFIXED(FMI${version}_FUNCTION_PREFIX, ${name})\n")
    endforeach()
    string(APPEND text "#endif\n")
endforeach()
string(APPEND text "\n#endif\n")
set_put(mbsrank_set.h "${text}")
file(READ "${ROOT}/LICENSE" text)
set_put(LICENSE "${text}")
file(RENAME "${OUT}.new" "${OUT}")
