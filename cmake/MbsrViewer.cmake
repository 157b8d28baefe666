# Bundles the page of `mbsrank view` from src/program/viewer and the packages that npm gets for it.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: cmake -DSOURCE=... -DWORK=... -DOUT=... -DNPM=... -DNODE=... -DREQUIRED=ON|OFF [-DLIVE=PACKAGE;EXAMPLE...] -P MbsrViewer.cmake
# LIVE: the page that runs models, with the package of web/ and examples to begin with.
# Where npm gets nothing, as without a network, the viewer is left out with a message, or with REQUIRED the
# build ends.

# step(WHAT COMMAND...): ends the script where the command fails.
macro(step what)
    execute_process(COMMAND ${ARGN} WORKING_DIRECTORY "${WORK}" RESULT_VARIABLE status
                    OUTPUT_VARIABLE said ERROR_VARIABLE said)
    if(status)
        if(REQUIRED)
            message(FATAL_ERROR "${what} failed:\n${said}")
        endif()
        message(STATUS "The viewer of mbsrank is left out: ${what} failed")
        file(REMOVE "${OUT}")
        return()
    endif()
endmacro()

file(GLOB files "${SOURCE}/*")
file(COPY ${files} DESTINATION "${WORK}")
file(SHA256 "${SOURCE}/package-lock.json" wanted)
set(got "")
if(EXISTS "${WORK}/node_modules/.wanted")
    file(READ "${WORK}/node_modules/.wanted" got)
endif()
if(NOT got STREQUAL wanted)
    step("npm ci" "${NPM}" ci --prefer-offline --no-audit --no-fund --ignore-scripts --fetch-retries=0
         --fetch-timeout=20000)
    file(WRITE "${WORK}/node_modules/.wanted" "${wanted}")
endif()
step("the bundle" "${NODE}" bundle.mjs "${OUT}" ${LIVE})
