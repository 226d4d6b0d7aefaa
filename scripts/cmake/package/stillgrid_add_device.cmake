# stillgrid_add_device(NAME SOURCE ...): NAME.so, a device plugin that shows nothing but
# stillgrid_device_negotiate, keeps its symbols from the programs', and refuses to link while one of
# them is missing. To build with a sanitizer, whose symbols are the program's, add
# target_link_options(NAME PRIVATE -Wl,-z,undefs).
function(stillgrid_add_device name)
  set(map ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/device_plugin.map)
  add_library(${name} MODULE ${ARGN})
  target_link_libraries(${name} PRIVATE stillgrid::device_plugin)
  target_link_options(${name} PRIVATE -Wl,--version-script=${map} -Wl,-z,defs)
  set_target_properties(${name} PROPERTIES
    PREFIX "" SUFFIX .so
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LINK_DEPENDS ${map})
endfunction()
