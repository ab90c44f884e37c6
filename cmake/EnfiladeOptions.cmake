# SPDX-License-Identifier: Apache-2.0
# Switches of the build; the presets in CMakePresets.json set them.
option(ENFILADE_BUILD_TESTS "Build the tests" ON)
option(ENFILADE_BUILD_BENCHMARKS "Build the benchmarks with the tests" ON)
option(ENFILADE_WERROR "Treat warnings as errors" OFF)
option(ENFILADE_COVERAGE "Instrument for line coverage (gcov)" OFF)
option(ENFILADE_COMPILE_TOGETHER "Compile small sources of one target many at a time" ON)
option(ENFILADE_FUZZ "Build fuzzers with clang's libFuzzer, under its sanitizers" OFF)
set(ENFILADE_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize= (address,undefined or thread)")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # The cache's keys hold paths relative to the checkout, so that other checkouts share the cache.
  set(CMAKE_C_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_C_COMPILER_LAUNCHER})
endif()

if(ENFILADE_FUZZ)
  # Without vptr, which needs the type information of libraries that hide it. A finding ends the program.
  set(fuzz_flags -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize=vptr -fno-sanitize-recover=all)
  add_compile_options(${fuzz_flags} -fno-omit-frame-pointer)
  add_compile_definitions(ENFILADE_LIBFUZZER)
  add_link_options(${fuzz_flags})
endif()
if(ENFILADE_SANITIZE)
  add_compile_options(-fsanitize=${ENFILADE_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${ENFILADE_SANITIZE})
endif()
if(ENFILADE_COVERAGE)
  add_compile_options(--coverage -fprofile-update=atomic)
  add_link_options(--coverage)
endif()

# By default GCC collects garbage from 128 MiB on. With 2 GiB it compiles 20 % faster, in 1.6 GiB instead of 1.3 GiB.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=2097152>)

# For code that computes (core, perception). -O2 under sanitizers, where the tests of SLAM would otherwise take most of the
# time.
set(ENFILADE_COMPILE_HOT $<$<CONFIG:Release>:-O3> $<$<CONFIG:RelWithDebInfo>:-O2>)
# For code that runs once per command or test, which is half of all code. It compiles in two thirds of the time.
set(ENFILADE_COMPILE_FAST $<$<CONFIG:Release>:-O1>)

# Every target except generated code links this.
add_library(enfilade_warnings INTERFACE)
target_compile_options(enfilade_warnings INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # GCC 12 wrongly reports uninitialised members in moved std::variants (GCC bug 105562 and similar ones).
  target_compile_options(enfilade_warnings INTERFACE -Wno-maybe-uninitialized)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  target_compile_options(enfilade_warnings INTERFACE -Wthread-safety)
endif()
if(ENFILADE_WERROR)
  target_compile_options(enfilade_warnings INTERFACE -Werror)
endif()
