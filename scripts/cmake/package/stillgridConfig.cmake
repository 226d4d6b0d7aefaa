# find_package(stillgrid): stillgrid::stillgrid (libstillgrid), stillgrid::device_plugin (the header of
# the device interface), the programs stillgrid::haptic_server, ..., and stillgrid_add_device().
include(${CMAKE_CURRENT_LIST_DIR}/stillgridTargets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/stillgrid_add_device.cmake)
