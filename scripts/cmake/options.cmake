# Warnings, sanitizers and the one floating-point rule, set once for every target of ours.
add_library(stillgrid_options INTERFACE)
add_library(stillgrid::options ALIAS stillgrid_options)

target_compile_options(stillgrid_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Werror
  -ffp-contract=off  # bit-identical recordings: a fused multiply-add rounds differently
)

set(STILLGRID_SANITIZE "" CACHE STRING "Value of -fsanitize, empty for none")
if(STILLGRID_SANITIZE)
  target_compile_options(stillgrid_options INTERFACE
    -fsanitize=${STILLGRID_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(stillgrid_options INTERFACE -fsanitize=${STILLGRID_SANITIZE})
endif()

# stillgrid_library(NAME): a static library stillgrid_NAME with alias stillgrid::NAME.
function(stillgrid_library name)
  add_library(stillgrid_${name} STATIC)
  add_library(stillgrid::${name} ALIAS stillgrid_${name})
  set_target_properties(stillgrid_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(stillgrid_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(stillgrid_${name} PRIVATE stillgrid::options)
endfunction()
