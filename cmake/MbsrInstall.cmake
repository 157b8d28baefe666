# Installation: headers, libraries, CMake package, pkg-config files, licence.
# SPDX-License-Identifier: BSD-3-Clause
include(CMakePackageConfigHelpers)

set(mbsr_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/mbsrank")

# mbsr_install_library(target component): library, its part of the CMake package, its .pc file.
function(mbsr_install_library target component)
    install(TARGETS ${target} EXPORT mbsrank-${component}
            RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT ${component}
            LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${component}
            ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${component})
    install(EXPORT mbsrank-${component} NAMESPACE mbsrank::
            FILE mbsrank-${component}-targets.cmake
            DESTINATION "${mbsr_package_dir}" COMPONENT ${component})
    configure_file("${PROJECT_SOURCE_DIR}/cmake/${target}.pc.in" "${target}.pc" @ONLY)
    install(FILES "${CMAKE_CURRENT_BINARY_DIR}/${target}.pc"
            DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT ${component})
endfunction()

# mbsr_link_flags(out item...): what a linker needs for libraries given by file, by flag, by plain
# name or by imported target; files in the linker's own folders become -l flags.
function(mbsr_link_flags out)
    set(flags "")
    foreach(item IN LISTS ARGN)
        if(TARGET "${item}")
            get_target_property(type "${item}" TYPE)
            if(type STREQUAL "INTERFACE_LIBRARY")
                get_target_property(behind "${item}" INTERFACE_LINK_LIBRARIES)
                list(FILTER behind INCLUDE REGEX "^SUNDIALS::")
                list(GET behind 0 item)
            endif()
            get_target_property(item "${item}" LOCATION)
        endif()
        if(item MATCHES "^(.*)/lib([^/]+)\\.(so[.0-9]*|a|dylib|tbd)$")
            set(folder "${CMAKE_MATCH_1}")
            set(stem "${CMAKE_MATCH_2}")
            if(folder IN_LIST CMAKE_C_IMPLICIT_LINK_DIRECTORIES)
                list(APPEND flags "-l${stem}")
            else()
                list(APPEND flags "-L${folder}" "-l${stem}")
            endif()
        elseif(item MATCHES "^[-/]")
            list(APPEND flags "${item}")
        else()
            list(APPEND flags "-l${item}")
        endif()
    endforeach()
    list(REMOVE_DUPLICATES flags)
    list(JOIN flags " " flags)
    set(${out} "${flags}" PARENT_SCOPE)
endfunction()

# The .pc files find the prefix from where they stand, so that an installed tree can be moved.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}" OR IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
    set(mbsr_pc_prefix "${CMAKE_INSTALL_PREFIX}")
    set(mbsr_pc_libdir "${CMAKE_INSTALL_FULL_LIBDIR}")
    set(mbsr_pc_includedir "${CMAKE_INSTALL_FULL_INCLUDEDIR}")
else()
    file(RELATIVE_PATH mbsr_pc_up "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
    string(REGEX REPLACE "/$" "" mbsr_pc_up "${mbsr_pc_up}")
    set(mbsr_pc_prefix "\${pcfiledir}/${mbsr_pc_up}")
    set(mbsr_pc_libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
    set(mbsr_pc_includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()

set(mbsr_thread_flag "")
if(MBSR_THREADS)
    set(mbsr_thread_flag ${CMAKE_THREAD_LIBS_INIT})
endif()
mbsr_link_flags(mbsr_core_private ${LAPACK_LIBRARIES} ${BLAS_LIBRARIES} m ${mbsr_thread_flag})
mbsr_install_library(mbsrank core)
file(GLOB mbsr_headers CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/include/mbsrank/*.h")
list(FILTER mbsr_headers EXCLUDE REGEX "/(fe|files|fit|fmu|ida|linear|sid|simulation|study|sundials)\\.h$")
install(FILES ${mbsr_headers} DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT core)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT core)

set(mbsr_cholmod "")
if(MBSR_CHOLMOD)
    set(mbsr_cholmod "${MBSR_CHOLMOD_LIBRARY}")
endif()
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/mbsrank-config.cmake.in"
    mbsrank-config.cmake INSTALL_DESTINATION "${mbsr_package_dir}"
    NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(mbsrank-config-version.cmake COMPATIBILITY ${mbsr_compatibility})
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/mbsrank-config.cmake"
              "${CMAKE_CURRENT_BINARY_DIR}/mbsrank-config-version.cmake"
        DESTINATION "${mbsr_package_dir}" COMPONENT core)

if(MBSR_IDA)
    mbsr_link_flags(mbsr_ida_private ${mbsr_sundials_targets} m)
    mbsr_install_library(mbsrank_ida ida)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/ida.h"
                  "${PROJECT_SOURCE_DIR}/include/mbsrank/sensitivity.h"
                  "${PROJECT_SOURCE_DIR}/include/mbsrank/simulation.h"
                  "${PROJECT_SOURCE_DIR}/include/mbsrank/sundials.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT ida)
endif()

if(MBSR_FILES)
    mbsr_link_flags(mbsr_files_private ${EXPAT_LIBRARIES} ${mbsr_png} m)
    mbsr_install_library(mbsrank_files files)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/files.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT files)
endif()

if(MBSR_CONTACT)
    mbsr_install_library(mbsrank_contact contact)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/contact.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT contact)
endif()

if(MBSR_FE)
    mbsr_link_flags(mbsr_fe_private ${mbsr_cholmod} ${LAPACK_LIBRARIES} ${BLAS_LIBRARIES} m)
    mbsr_install_library(mbsrank_fe fe)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/fe.h"
                  "${PROJECT_SOURCE_DIR}/include/mbsrank/sid.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT fe)
endif()

if(MBSR_LINEAR)
    mbsr_link_flags(mbsr_linear_private ${LAPACK_LIBRARIES} ${BLAS_LIBRARIES} m)
    mbsr_install_library(mbsrank_linear linear)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/linear.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT linear)
endif()

if(MBSR_STUDY)
    mbsr_link_flags(mbsr_study_private m)
    mbsr_install_library(mbsrank_study study)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/fit.h"
                  "${PROJECT_SOURCE_DIR}/include/mbsrank/study.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT study)
endif()

if(MBSR_FMU)
    mbsr_install_library(mbsrank_fmu fmu)
    install(FILES "${PROJECT_SOURCE_DIR}/include/mbsrank/fmu.h"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mbsrank" COMPONENT fmu)
endif()

if(PROJECT_IS_TOP_LEVEL) # other projects have targets of this name
    configure_file("${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake.in" "${PROJECT_BINARY_DIR}/mbsrank-uninstall.cmake" @ONLY)
    add_custom_target(uninstall COMMAND "${CMAKE_COMMAND}" -P "${PROJECT_BINARY_DIR}/mbsrank-uninstall.cmake")
endif()
