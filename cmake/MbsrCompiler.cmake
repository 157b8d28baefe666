# Compiler flags for this project's own targets; none of them reaches an installed target.
# SPDX-License-Identifier: BSD-3-Clause

if(MBSR_FENCES)
    add_compile_definitions(MBSR_FENCES)
endif()
if(MBSR_SANITIZE)
    # -O1 finds what -O0 finds, in a third of the time, but clang takes ten times as long to compile with it: what runs
    # long has it (mbsr_add_objects, tests/support). Line numbers are all that reports need. What null and object-size
    # check the address sanitizer finds at the access.
    add_compile_options(-fsanitize=${MBSR_SANITIZE} -fno-sanitize-recover=all
                        -fno-sanitize=null,object-size -fno-omit-frame-pointer $<$<CONFIG:Debug>:-g1>)
    add_link_options(-fsanitize=${MBSR_SANITIZE})
endif()

# A 32-bit x86 keeps intermediate results in 80 bits unless told otherwise; sums in twofold precision and decisions
# of rank count on those of double.
include(CheckCSourceCompiles)
check_c_source_compiles("
    #if !defined(__i386__) || !defined(__GNUC__)
    #error not a 32-bit x86
    #endif
    int main(void) { return 0; }"
    MBSR_I386)
if(MBSR_I386)
    add_compile_options(-msse2 -mfpmath=sse)
endif()

# Refusals count on NaN and infinities, sums in twofold precision on their order: also in a project that compiles with
# -Ofast, the library of it included.
if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
    string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
    get_directory_property(given_options COMPILE_OPTIONS)
    if("${CMAKE_C_FLAGS} ${CMAKE_C_FLAGS_${build_type}} ${given_options}" MATCHES
       "-(Ofast|ffast-math|ffinite-math-only|funsafe-math-optimizations|fassociative-math)")
        add_compile_options(-fno-fast-math -fno-finite-math-only -fno-unsafe-math-optimizations -fno-associative-math)
    endif()
    if(NOT MBSR_FMA)
        add_compile_options(-ffp-contract=off)
    endif()
endif()

function(mbsr_set_warnings target)
    if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
        target_compile_options(${target} PRIVATE
            -Wall -Wextra -Wpedantic -Wshadow -Wvla -Wconversion
            $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes> $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes>)
        if(MINGW) # isfinite of its header has a branch for float, by size
            target_compile_options(${target} PRIVATE -Wno-float-conversion)
        endif()
        if(MBSR_UNITY) # names of the files before
            target_compile_options(${target} PRIVATE -Wno-shadow)
        endif()
        if(MBSR_WERROR)
            target_compile_options(${target} PRIVATE -Werror)
        endif()
    elseif(MSVC)
        target_compile_options(${target} PRIVATE /W4 $<$<BOOL:${MBSR_WERROR}>:/WX>)
    endif()
endfunction()

# Inside another project without a build type CMake would compile without -O. The build type is that
# project's to set; so are -O flags of its own, in CMAKE_C_FLAGS or by add_compile_options, whose
# options come after these.
function(mbsr_set_optimisation target)
    if(MBSR_DEFAULT_O2 AND CMAKE_C_COMPILER_ID MATCHES "GNU|Clang"
       AND NOT CMAKE_C_FLAGS MATCHES "(^| )-O")
        target_compile_options(${target} BEFORE PRIVATE $<$<CONFIG:>:-O2>)
    endif()
endfunction()

# mbsr_groups_of_sources(variable shared source... [OVER]): lines "GROUP SOURCE" of what one compilation may include together, OVER
# folders. A compiler's start and the headers take half of the time of one that does not optimise.
function(mbsr_groups_of_sources variable shared)
    set(script "${PROJECT_SOURCE_DIR}/cmake/groups.awk")
    cmake_parse_arguments(PARSE_ARGV 2 groups "OVER" "" "")
    set(limits -v most=12)
    if(groups_OVER)
        set(limits -v most=24 -v over=1)
    endif()
    execute_process(COMMAND awk ${limits} -v "shared=${shared}" -f "${script}" ${groups_UNPARSED_ARGUMENTS} WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
                    OUTPUT_VARIABLE lines COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "[^ \n]+ [^ \n]+" lines "${lines}")
    set(${variable} "${lines}" PARENT_SCOPE)
endfunction()

# mbsr_set_groups(line...): tells CMake, which includes such groups together where UNITY_BUILD_MODE is GROUP.
function(mbsr_set_groups)
    foreach(line IN LISTS ARGN)
        string(REPLACE " " ";" line "${line}")
        list(GET line 0 group)
        list(GET line 1 source)
        set_source_files_properties("${source}" PROPERTIES UNITY_GROUP ${group})
    endforeach()
endfunction()

# mbsr_unite(variable name source...): the sources of a library, those of any folders and of the same options in files that
# include many of them. Where each is read alone, too, the groups are those of one folder (mbsr_group_sources): calls from one to
# another stay calls there, which tests/faults replaces.
function(mbsr_unite variable name)
    set(united "")
    set(kinds "")
    foreach(source IN LISTS ARGN)
        get_source_file_property(alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
        get_source_file_property(options "${source}" COMPILE_OPTIONS)
        get_source_file_property(definitions "${source}" COMPILE_DEFINITIONS)
        if(alone OR source MATCHES "/kernels_") # they define what their headers read
            list(APPEND united ${source})
            continue()
        endif()
        string(MD5 kind "${options} ${definitions}")
        list(APPEND kinds ${kind})
        list(APPEND of_${kind} ${source})
        set(options_${kind} "${options}")
        set(definitions_${kind} "${definitions}")
    endforeach()
    list(REMOVE_DUPLICATES kinds)
    foreach(kind IN LISTS kinds)
        mbsr_groups_of_sources(lines "" ${of_${kind}} OVER)
        set(groups "")
        foreach(line IN LISTS lines)
            string(REGEX MATCH "^([0-9]+) (.*)" line "${line}")
            set(group "${kind}_${CMAKE_MATCH_1}")
            list(APPEND groups ${group})
            list(APPEND of_${group} ${CMAKE_MATCH_2})
            string(APPEND text_${group} "#include \"${CMAKE_CURRENT_SOURCE_DIR}/${CMAKE_MATCH_2}\"\n")
        endforeach()
        list(REMOVE_DUPLICATES groups)
        foreach(group IN LISTS groups)
            list(LENGTH of_${group} number)
            if(number EQUAL 1)
                continue()
            endif()
            list(REMOVE_ITEM of_${kind} ${of_${group}})
            set(file "${CMAKE_CURRENT_BINARY_DIR}/united/${name}_${group}.c")
            file(CONFIGURE OUTPUT "${file}" CONTENT "@text_${group}@" @ONLY)
            list(APPEND united "${file}")
            foreach(property IN ITEMS options definitions)
                if(${property}_${kind})
                    string(TOUPPER "COMPILE_${property}" to)
                    set_property(SOURCE "${file}" PROPERTY ${to} "${${property}_${kind}}")
                endif()
            endforeach()
        endforeach()
        list(APPEND united ${of_${kind}})
    endforeach()
    set(${variable} "${united}" PARENT_SCOPE)
endfunction()

# mbsr_group_sources(source...): the groups of the sources of targets of this folder, where libraries are compiled so.
function(mbsr_group_sources)
    if(NOT MBSR_UNITY)
        return()
    endif()
    mbsr_groups_of_sources(lines "" ${ARGN})
    mbsr_set_groups(${lines})
    set(CMAKE_UNITY_BUILD ON PARENT_SCOPE)
    set(CMAKE_UNITY_BUILD_MODE GROUP PARENT_SCOPE)
endfunction()

# mbsr_read_alone(target source...): where sources of the target are compiled together, what one of them does not include and
# which of its names hide others is seen when it is read alone, with all warnings. Those with options of their own are compiled so.
function(mbsr_read_alone target)
    if(NOT MBSR_UNITY STREQUAL "CHECKED")
        return()
    endif()
    set(together "")
    foreach(source IN LISTS ARGN)
        get_source_file_property(options "${source}" COMPILE_OPTIONS)
        if(options)
            set_property(SOURCE "${source}" APPEND PROPERTY COMPILE_OPTIONS -Wshadow)
        else()
            list(APPEND together "${source}")
        endif()
    endforeach()
    add_library(${target}_alone OBJECT ${together})
    set_target_properties(${target}_alone PROPERTIES UNITY_BUILD OFF)
    target_include_directories(${target}_alone PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
    target_compile_definitions(${target}_alone PRIVATE $<TARGET_PROPERTY:${target},COMPILE_DEFINITIONS>)
    target_compile_options(${target}_alone PRIVATE
                           $<FILTER:$<TARGET_PROPERTY:${target},COMPILE_OPTIONS>,EXCLUDE,-Wno-shadow> -fsyntax-only)
endfunction()
