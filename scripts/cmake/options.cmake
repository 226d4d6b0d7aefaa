# Warnings, sanitizers and the one floating-point rule, set once for every target of ours.
add_library(stillgrid_options INTERFACE)
add_library(stillgrid::options ALIAS stillgrid_options)

# Off where a compiler that nobody of us has tried may warn of more: packages.
option(STILLGRID_WARNINGS_AS_ERRORS "Stop at a compiler's warning" ON)
target_compile_options(stillgrid_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion
  $<$<BOOL:${STILLGRID_WARNINGS_AS_ERRORS}>:-Werror>
  -ffp-contract=off  # bit-identical recordings: a fused multiply-add rounds differently
)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # Of "text" + std::to_string(n), by what was inlined (GCC's bugs 105329 and 105651): no reason to stop.
  target_compile_options(stillgrid_options INTERFACE
    -Wno-error=array-bounds -Wno-error=restrict -Wno-error=stringop-overflow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  target_compile_options(stillgrid_options INTERFACE -Wno-maybe-uninitialized)  # g++ 14: of an empty std::optional
endif()

set(STILLGRID_SANITIZE "" CACHE STRING "Value of -fsanitize, empty for none")
# Checks of pointers that the address sanitizer makes at the access take a third of what compiling takes.
set(STILLGRID_NO_SANITIZE "" CACHE STRING "Value of -fno-sanitize, empty for none")
if(STILLGRID_SANITIZE)
  target_compile_options(stillgrid_options INTERFACE
    -fsanitize=${STILLGRID_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(stillgrid_options INTERFACE -fsanitize=${STILLGRID_SANITIZE})
  if(STILLGRID_NO_SANITIZE)
    target_compile_options(stillgrid_options INTERFACE -fno-sanitize=${STILLGRID_NO_SANITIZE})
  endif()
endif()

# Much of what compiling takes is reading Eigen: read once for all libraries. Not beside a compiler
# cache, which could keep nothing then, nor for clang-tidy, which finds the include that a file forgot, nor
# for ARM, whose g++ 12 crashes in <arm_sve.h> behind a precompiled header.
if(CMAKE_CXX_COMPILER_LAUNCHER OR CMAKE_CXX_CLANG_TIDY OR CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64)
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
add_library(stillgrid_precompiled STATIC ${CMAKE_CURRENT_LIST_DIR}/precompiled.cpp)
set_target_properties(stillgrid_precompiled PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_link_libraries(stillgrid_precompiled PRIVATE stillgrid::options Eigen3::Eigen)
target_precompile_headers(stillgrid_precompiled PRIVATE
  <Eigen/Core> <Eigen/Geometry> <algorithm> <string> <vector>)

# stillgrid_library(NAME): a static library stillgrid_NAME with alias stillgrid::NAME.
function(stillgrid_library name)
  add_library(stillgrid_${name} STATIC)
  add_library(stillgrid::${name} ALIAS stillgrid_${name})
  set_target_properties(stillgrid_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(stillgrid_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(stillgrid_${name} PRIVATE stillgrid::options)
  target_precompile_headers(stillgrid_${name} REUSE_FROM stillgrid_precompiled)
endfunction()

# stillgrid_command_line(TARGET MAIN): a program whose source MAIN reads its options and knows its version.
# Options are read once a run: making that fast would take half of what compiling the source takes. Not -O0:
# of the functions of std that the source and the rest both have, a program takes the source's.
function(stillgrid_command_line target main)
  target_link_libraries(${target} PRIVATE CLI11::CLI11)
  set_source_files_properties(${main} PROPERTIES
    COMPILE_DEFINITIONS STILLGRID_VERSION="${PROJECT_VERSION}"
    COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
endfunction()
