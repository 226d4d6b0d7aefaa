# What the tests and benchmarks run beside, all of it or none (STILLGRID_PEERS).
find_package(PkgConfig QUIET)
stillgrid_expect(STILLGRID_PEERS pkg-config PkgConfig_FOUND)
foreach(module IN ITEMS bullet bullet-float64)
  pkg_check_modules(${module} QUIET IMPORTED_TARGET ${module})
endforeach()
stillgrid_expect(STILLGRID_PEERS libbullet-dev bullet_FOUND)
stillgrid_expect(STILLGRID_PEERS libbullet-dev bullet-float64_FOUND)
# Not by its package file, which names a folder that Debian's has not.
find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h)
find_library(MUJOCO_LIBRARY mujoco)
stillgrid_expect(STILLGRID_PEERS libmujoco-dev MUJOCO_INCLUDE_DIR)
stillgrid_expect(STILLGRID_PEERS libmujoco-dev MUJOCO_LIBRARY)
# Fast DDS 2. Debian 13 has 3, for whose functions the subscriber is not written: ros_test skips there.
find_package(fastrtps QUIET)
find_package(fastdds 3 QUIET)
if(NOT fastdds_FOUND)
  stillgrid_expect(STILLGRID_PEERS libfastrtps-dev fastrtps_FOUND)
endif()
