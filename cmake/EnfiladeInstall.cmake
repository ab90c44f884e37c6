# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where: the programs, and the robot library with all that it is made of, for
#   find_package(enfilade REQUIRED)
#   target_link_libraries(robot PRIVATE enfilade::client_uplink)
# examples/robot_client is such a program.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(installed_libraries client_uplink client_connection client_spool proto_convert proto core_sensor core_geometry core_base)
set(header_dir ${CMAKE_INSTALL_INCLUDEDIR}/enfilade)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/enfilade)

install(TARGETS enfilade enfilade-server RUNTIME)
foreach(library IN LISTS installed_libraries)
  set_target_properties(enfilade_${library} PROPERTIES EXPORT_NAME ${library})
  target_include_directories(enfilade_${library} INTERFACE $<INSTALL_INTERFACE:${header_dir}>)
  install(TARGETS enfilade_${library} EXPORT enfilade)
endforeach()
install(EXPORT enfilade NAMESPACE enfilade:: DESTINATION ${package_dir})

foreach(folder client/sdk core/base core/geometry core/sensor proto/convert)
  install(DIRECTORY ${folder}/ DESTINATION ${header_dir}/${folder} FILES_MATCHING PATTERN "*.h")
endforeach()
install(FILES core/graph/link_point_kind.h DESTINATION ${header_dir}/core/graph)  # that records name
install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/enfilade DESTINATION ${header_dir} FILES_MATCHING PATTERN "*.pb.h")
install(DIRECTORY proto/enfilade DESTINATION ${CMAKE_INSTALL_DATADIR}/enfilade/proto FILES_MATCHING PATTERN "*.proto")

configure_package_config_file(cmake/enfilade-config.cmake.in enfilade-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(enfilade-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/enfilade-config.cmake ${PROJECT_BINARY_DIR}/enfilade-config-version.cmake
  DESTINATION ${package_dir})
