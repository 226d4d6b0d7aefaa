# What drivers and engines outside this tree need, in-tree and installed: headers, the rules to link by,
# examples, and where they are found; libstillgrid itself is installed beside its sources. Nothing of it names a folder, so that an installed tree may be moved.
include(CMakePackageConfigHelpers)
include(${CMAKE_CURRENT_LIST_DIR}/package/stillgrid_add_device.cmake)

add_library(stillgrid_device_plugin INTERFACE)
add_library(stillgrid::device_plugin ALIAS stillgrid_device_plugin)
target_include_directories(stillgrid_device_plugin INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
set_target_properties(stillgrid_device_plugin PROPERTIES EXPORT_NAME device_plugin)

install(FILES ${PROJECT_SOURCE_DIR}/proto/device_plugin.h ${PROJECT_SOURCE_DIR}/proto/stillgrid.h
  ${PROJECT_SOURCE_DIR}/proto/stillgrid.hpp DESTINATION include/stillgrid)
install(DIRECTORY
  ${PROJECT_SOURCE_DIR}/tests/install/handle ${PROJECT_SOURCE_DIR}/tests/install/udp_knob
  ${PROJECT_SOURCE_DIR}/tests/install/publish_ball
  ${PROJECT_SOURCE_DIR}/docs/examples/mujoco ${PROJECT_SOURCE_DIR}/docs/examples/bullet
  DESTINATION share/stillgrid/examples)
install(TARGETS stillgrid_device_plugin EXPORT stillgrid)
install(EXPORT stillgrid
  NAMESPACE stillgrid:: FILE stillgridTargets.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillgrid)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/package/stillgridConfig.cmake.in
  ${CMAKE_BINARY_DIR}/package/stillgridConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillgrid
  NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/stillgridConfigVersion.cmake
  COMPATIBILITY SameMajorVersion)
install(FILES
  ${CMAKE_BINARY_DIR}/package/stillgridConfigVersion.cmake
  ${CMAKE_BINARY_DIR}/package/stillgridConfig.cmake
  ${CMAKE_CURRENT_LIST_DIR}/package/stillgrid_add_device.cmake
  ${CMAKE_CURRENT_LIST_DIR}/package/device_plugin.map
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillgrid)

# From a folder of pkg-config files, which may lie deeper, to the prefix.
file(RELATIVE_PATH prefix_from_pc /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" prefix_from_pc ${prefix_from_pc})
foreach(pc IN ITEMS stillgrid-device.pc stillgrid.pc)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/package/${pc}.in ${CMAKE_BINARY_DIR}/package/${pc} @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/package/${pc} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
