# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` installs: the programs, and the client libraries with their headers, for
#   find_package(enfilade REQUIRED)
#   target_link_libraries(robot PRIVATE enfilade::client_uplink)  # record durably, stream to the server
#   target_link_libraries(tool PRIVATE enfilade::client_api)      # maps, blobs, lists, evidence
#   target_link_libraries(tool PRIVATE enfilade::client_import)   # other programs' maps
# examples/robot_client and examples/map_client are such programs.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(installed_libraries client_import client_uplink client_api client_connection client_spool io_tls core_building
  client_map_manager proto_convert proto core_options core_sensor core_geometry core_base io)
set(header_dir ${CMAKE_INSTALL_INCLUDEDIR}/enfilade)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/enfilade)

install(TARGETS enfilade enfilade-server RUNTIME)
foreach(library IN LISTS installed_libraries)
  set_target_properties(enfilade_${library} PROPERTIES EXPORT_NAME ${library})
  target_include_directories(enfilade_${library} INTERFACE $<INSTALL_INTERFACE:${header_dir}>)
  install(TARGETS enfilade_${library} EXPORT enfilade)
endforeach()
install(EXPORT enfilade NAMESPACE enfilade:: DESTINATION ${package_dir})

foreach(folder client/sdk client/import core/base core/geometry core/sensor io proto/convert)
  install(DIRECTORY ${folder}/ DESTINATION ${header_dir}/${folder} FILES_MATCHING PATTERN "*.h")
endforeach()
install(FILES core/graph/link_point_kind.h DESTINATION ${header_dir}/core/graph)  # that records name
install(FILES client/sources/imports/map_manager_database.h
  DESTINATION ${header_dir}/client/sources/imports)  # that imports read
install(FILES core/prior/formats/building_file.h DESTINATION ${header_dir}/core/prior/formats)
install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/enfilade DESTINATION ${header_dir} FILES_MATCHING PATTERN "*.pb.h")
install(DIRECTORY proto/enfilade DESTINATION ${CMAKE_INSTALL_DATADIR}/enfilade/proto FILES_MATCHING PATTERN "*.proto")

configure_package_config_file(cmake/enfilade-config.cmake.in enfilade-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(enfilade-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/enfilade-config.cmake ${PROJECT_BINARY_DIR}/enfilade-config-version.cmake
  DESTINATION ${package_dir})
