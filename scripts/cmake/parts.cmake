# Parts that need more than the rest does. All are on by default, and what is on must be found. scripts/demo
# builds without them (preset demo); another machine's build is without those that link the host's libraries.
include(CMakeDependentOption)
cmake_dependent_option(STILLGRID_RELAY "scene_relay, over Cyclone DDS"
  ON "NOT CMAKE_CROSSCOMPILING" OFF)
cmake_dependent_option(STILLGRID_SUNDIALS "The integrator cvode_bdf; the laboratory and fit_run"
  ON "NOT CMAKE_CROSSCOMPILING" OFF)  # Debian's SUNDIALS for ARM cannot be installed beside the host's
cmake_dependent_option(STILLGRID_SPACEMOUSE "The driver of SpaceMice, over libspnav"
  ON "NOT CMAKE_CROSSCOMPILING" OFF)
cmake_dependent_option(STILLGRID_PAGE "The page of scene_viewer, for which npm fetches three.js"
  ON "NOT CMAKE_CROSSCOMPILING;NOT CMAKE_CXX_CLANG_TIDY" OFF)  # clang-tidy looks at C++ alone
cmake_dependent_option(STILLGRID_PEERS "Tests and benchmarks beside Bullet, MuJoCo and Fast DDS"
  ON "NOT CMAKE_CROSSCOMPILING" OFF)

# stillgrid_expect(OPTION PACKAGE VARIABLE): ends with one line unless VARIABLE tells that PACKAGE was found.
function(stillgrid_expect option package variable)
  if(NOT ${variable})
    message(FATAL_ERROR "${option}=ON: expected Debian's ${package}: run scripts/setup, or set ${option}=OFF")
  endif()
endfunction()

if(STILLGRID_RELAY)
  find_package(CycloneDDS 0.10 QUIET)
  stillgrid_expect(STILLGRID_RELAY cyclonedds-dev CycloneDDS_FOUND)
endif()
if(STILLGRID_SUNDIALS)
  find_package(SUNDIALS 6.4 QUIET COMPONENTS cvode nvecserial sunlinsolspgmr)
  stillgrid_expect(STILLGRID_SUNDIALS libsundials-dev SUNDIALS_FOUND)
endif()
if(STILLGRID_SPACEMOUSE)
  find_library(STILLGRID_SPNAV spnav)
  stillgrid_expect(STILLGRID_SPACEMOUSE libspnav-dev STILLGRID_SPNAV)
endif()
if(STILLGRID_PAGE)
  find_program(STILLGRID_NPM npm)
  stillgrid_expect(STILLGRID_PAGE npm STILLGRID_NPM)
endif()
