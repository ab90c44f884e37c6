# SPDX-License-Identifier: Apache-2.0
include(GoogleTest)

# enfilade_library(core_grid SOURCES a.cc b.cc DEPS enfilade::core_geometry PRIVATE_DEPS PNG::PNG)
# Defines the static library of one folder, with the alias enfilade::<name>. Without SOURCES it is header-only.
function(enfilade_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPS;PRIVATE_DEPS")
  set(target enfilade_${name})
  if(arg_SOURCES)
    add_library(${target} STATIC ${arg_SOURCES})
    target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
    target_link_libraries(${target} PUBLIC ${arg_DEPS} PRIVATE ${arg_PRIVATE_DEPS} $<BUILD_INTERFACE:enfilade_warnings>)
    enfilade_compile_together(${target})
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
    target_link_libraries(${target} INTERFACE ${arg_DEPS})
  endif()
  add_library(enfilade::${name} ALIAS ${target})
endfunction()

# Most of the compile time of a source goes into headers that its neighbours include, too (gRPC, Eigen, GoogleTest), so the
# sources of a target are compiled up to 16 at a time. Their anonymous namespaces become one: helper functions need names
# that are unique in their target. The preset dev compiles each source by itself, which finds missing includes.
function(enfilade_compile_together target)
  set_target_properties(${target} PROPERTIES
    UNITY_BUILD ${ENFILADE_COMPILE_TOGETHER} UNITY_BUILD_MODE BATCH UNITY_BUILD_BATCH_SIZE 16)
  if(ENFILADE_COMPILE_TOGETHER AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # GCC treats an included source as a header.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# enfilade_program(enfilade-server SOURCES main.cc DEPS ...)
function(enfilade_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPS")
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_DEPS} enfilade_warnings)
  enfilade_compile_together(${name})
endfunction()

# enfilade_test(core_grid_test SOURCES a_test.cc DEPS enfilade::core_grid [WHOLE] [LABELS db])
# Defines a GoogleTest program. Each of its cases becomes a ctest case. With WHOLE, the program is one ctest case (for tests
# that share an expensive set-up, such as a database cluster).
function(enfilade_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "WHOLE" "TIMEOUT" "SOURCES;DEPS;LABELS")
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_DEPS} GTest::gmock GTest::gtest_main enfilade_warnings)
  target_compile_options(${name} PRIVATE ${ENFILADE_COMPILE_FAST})
  enfilade_compile_together(${name})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  if(ENFILADE_SANITIZE)  # tests take five to fifteen times as long
    math(EXPR arg_TIMEOUT "${arg_TIMEOUT} * 10")
  endif()
  if(arg_WHOLE)
    add_test(NAME ${name} COMMAND ${name})
    # The longest begin first, so that the last one does not run alone.
    set_tests_properties(${name} PROPERTIES TIMEOUT ${arg_TIMEOUT} COST ${arg_TIMEOUT} LABELS "${arg_LABELS}")
  else()
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST NO_PRETTY_VALUES TEST_PREFIX "${name}:"
      PROPERTIES TIMEOUT ${arg_TIMEOUT})
  endif()
endfunction()

# enfilade_benchmark(bench_grid SOURCES grid_bench.cc DEPS ...): run by `make bench`, never by the tests.
function(enfilade_benchmark name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPS")
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_DEPS} benchmark::benchmark enfilade_warnings)
  enfilade_compile_together(${name})
endfunction()
