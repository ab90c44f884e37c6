# SPDX-License-Identifier: Apache-2.0
# Switches of the build; the presets in CMakePresets.json set them.
option(ENFILADE_BUILD_TESTS "Build the tests" ON)
option(ENFILADE_BUILD_BENCHMARKS "Build the benchmarks with the tests" ON)
option(ENFILADE_WERROR "Treat warnings as errors" OFF)
option(ENFILADE_COVERAGE "Instrument for line coverage (gcov)" OFF)
option(ENFILADE_COMPILE_TOGETHER "Compile small sources of one target many at a time" ON)
set(ENFILADE_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize= (address,undefined or thread)")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # Paths relative to the checkout in the cache's keys: another checkout builds from this one's cache.
  set(CMAKE_C_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_C_COMPILER_LAUNCHER})
endif()

if(ENFILADE_SANITIZE)
  add_compile_options(-fsanitize=${ENFILADE_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${ENFILADE_SANITIZE})
endif()
if(ENFILADE_COVERAGE)
  add_compile_options(--coverage -fprofile-update=atomic)
  add_link_options(--coverage)
endif()

# GCC looks for garbage from 128 MiB on, again and again. With 2 GiB it compiles a fifth faster, in 1.6 GiB instead of 1.3.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=2097152>)

# For what computes (core, perception); the rest waits for it, the database or the network. Under sanitizers -O2, or the
# tests of SLAM would take most of the time.
set(ENFILADE_COMPILE_HOT $<$<CONFIG:Release>:-O3> $<$<CONFIG:RelWithDebInfo>:-O2>)
# For code that runs once per command or test: a third less time to compile it, and it is half of all code.
set(ENFILADE_COMPILE_FAST $<$<CONFIG:Release>:-O1>)

# Every target of ours links this; generated code does not.
add_library(enfilade_warnings INTERFACE)
target_compile_options(enfilade_warnings INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # GCC 12 sees uninitialised members in every moved std::variant (GCC bug 105562 and its kin).
  target_compile_options(enfilade_warnings INTERFACE -Wno-maybe-uninitialized)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  target_compile_options(enfilade_warnings INTERFACE -Wthread-safety)
endif()
if(ENFILADE_WERROR)
  target_compile_options(enfilade_warnings INTERFACE -Werror)
endif()
