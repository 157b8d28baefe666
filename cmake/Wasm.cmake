# Toolchain for WebAssembly: the distribution's clang, lld and wasi-libc (scripts/wasm.sh).
# SPDX-License-Identifier: BSD-3-Clause
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_C_COMPILER clang)
set(CMAKE_C_COMPILER_TARGET wasm32-wasi)
find_program(MBSR_LLVM_AR NAMES llvm-ar llvm-ar-14 REQUIRED)
find_program(MBSR_LLVM_RANLIB NAMES llvm-ranlib llvm-ranlib-14 REQUIRED)
set(CMAKE_AR "${MBSR_LLVM_AR}" CACHE FILEPATH "")
set(CMAKE_RANLIB "${MBSR_LLVM_RANLIB}" CACHE FILEPATH "")
set(CMAKE_C_FLAGS_INIT -msimd128)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
