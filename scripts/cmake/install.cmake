# What is installed besides programs and libraries: scripts, manual pages, completion, rights, the pages.
set(share ${CMAKE_INSTALL_DATADIR}/stillgrid)

install(FILES VERSION DESTINATION ${share})  # for the scripts' --version
foreach(component IN ITEMS replay_check scene_fit stiffness_fit stillgrid_import)
  install(FILES VERSION DESTINATION ${share} COMPONENT ${component})
  install(PROGRAMS scripts/${component} TYPE BIN COMPONENT ${component})
endforeach()
# What two of them share.
set(ends scripts/replay/endings.py scripts/replay/whole_file.py)
set(replays ${ends} scripts/replay/expectation.py scripts/replay/forces.py scripts/replay/recorded_frame.py
  scripts/replay/servers.py shared/python/stillgrid/metadata.py)
install(FILES ${replays} scripts/replay/picture.py scripts/replay/verdict.py
  DESTINATION ${share}/replay COMPONENT replay_check)
install(DIRECTORY scripts/stiffness DESTINATION ${share} COMPONENT stiffness_fit
  FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE)
install(FILES ${replays} DESTINATION ${share}/replay COMPONENT stiffness_fit)
install(FILES scripts/fit/toml_edit.py DESTINATION ${share}/fit COMPONENT stiffness_fit)
install(DIRECTORY scripts/imports DESTINATION ${share} COMPONENT stillgrid_import
  FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE PATTERN endings.py EXCLUDE PATTERN whole_file.py EXCLUDE
  PATTERN metadata.py EXCLUDE)
install(FILES ${ends} shared/python/stillgrid/metadata.py DESTINATION ${share}/imports COMPONENT stillgrid_import)
install(DIRECTORY scripts/fit DESTINATION ${share} COMPONENT scene_fit
  FILES_MATCHING PATTERN "*.py" PATTERN __pycache__ EXCLUDE PATTERN recorded_frame.py EXCLUDE)
install(FILES scripts/replay/recorded_frame.py DESTINATION ${share}/fit COMPONENT scene_fit)

install(PROGRAMS scripts/launch TYPE BIN RENAME stillgrid_launch)
install(PROGRAMS scripts/demo TYPE BIN RENAME stillgrid_demo)
install(PROGRAMS scripts/summary.py DESTINATION ${share}/demo)
install(PROGRAMS scripts/gallery/plot_recording.py DESTINATION ${share}/demo/gallery)
install(FILES scripts/gallery/cyclictest.py scripts/gallery/drawing.py scripts/gallery/recording.py
  DESTINATION ${share}/demo/gallery)

# Where systemd and udev look, under /usr and /usr/local; limits have one place alone, /etc.
install(FILES scripts/udev/60-stillgrid.rules DESTINATION lib/udev/rules.d)
install(FILES scripts/system/stillgrid.conf DESTINATION lib/sysusers.d)
install(FILES scripts/system/stillgrid@.service DESTINATION lib/systemd/user)
install(FILES scripts/system/95-stillgrid.conf DESTINATION ${share}/limits.d)

install(FILES LICENSE THIRD_PARTY_NOTICES.md README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR}
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg" PATTERN "*.csv" PATTERN examples EXCLUDE)
# What pages link to outside docs.
foreach(file IN ITEMS
    proto/dds/scene_relay.idl proto/device_plugin.h proto/ros/geometry_msgs.idl proto/stillgrid.h proto/stillgrid.hpp
    scripts/gallery/charts.toml sim_server/dynamics/choice/memory_need.hpp
    sim_server/scene/method.hpp sim_server/scene/scene.schema.json tests/network/dds_security.py)
  cmake_path(GET file PARENT_PATH folder)
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder})
endforeach()
install(DIRECTORY docs/examples DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs PATTERN __pycache__ EXCLUDE)

# Completion is looked for by a program's name.
set(programs sim_server haptic_server segment_inspect scene_viewer scene_relay device_check sphere_decompose)
foreach(program IN LISTS programs)
  if(NOT TARGET ${program})  # of a part that is left out
    list(REMOVE_ITEM programs ${program})
  endif()
endforeach()
set(scripts replay_check scene_fit stiffness_fit stillgrid_import)
set(completions ${CMAKE_BINARY_DIR}/share/bash-completion/completions)
configure_file(scripts/system/completion.bash ${completions}/stillgrid_launch COPYONLY)
foreach(program IN ITEMS ${programs} ${scripts} stillgrid_demo)
  file(CREATE_LINK stillgrid_launch ${completions}/${program} SYMBOLIC)
endforeach()
install(DIRECTORY ${completions} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion)

# Manual pages, of what each program says itself: those of programs that run here.
find_package(Python3 COMPONENTS Interpreter)
if(CMAKE_CROSSCOMPILING OR STILLGRID_SANITIZE OR CMAKE_CXX_CLANG_TIDY OR NOT Python3_FOUND)
  return()
endif()
set(pages)
function(stillgrid_man_page name program)
  set(page ${CMAKE_BINARY_DIR}/share/man/man1/${name}.1)
  add_custom_command(OUTPUT ${page}
    COMMAND ${PROJECT_SOURCE_DIR}/scripts/man_page --name ${name} --docs ${CMAKE_INSTALL_FULL_DOCDIR}/docs
      --out ${page} ${program}
    DEPENDS ${program} ${PROJECT_SOURCE_DIR}/scripts/man_page VERSION
    VERBATIM)
  list(APPEND pages ${page})
  set(pages ${pages} PARENT_SCOPE)
endfunction()
foreach(program IN LISTS programs)
  stillgrid_man_page(${program} $<TARGET_FILE:${program}>)
endforeach()
foreach(script IN LISTS scripts)
  stillgrid_man_page(${script} ${PROJECT_SOURCE_DIR}/scripts/${script})
endforeach()
stillgrid_man_page(stillgrid_launch ${PROJECT_SOURCE_DIR}/scripts/launch)
stillgrid_man_page(stillgrid_demo ${PROJECT_SOURCE_DIR}/scripts/demo)
add_custom_target(man_pages ALL DEPENDS ${pages})
install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
