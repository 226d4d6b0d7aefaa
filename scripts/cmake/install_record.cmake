# Notes, before anything is installed, which of the folders that others use too are made by it, so that
# uninstall.cmake leaves the others alone. Included before the first rule of installation.
set(shared_folders . bin include lib libexec share lib/systemd lib/systemd/user lib/sysusers.d lib/udev
  lib/udev/rules.d lib/python3 lib/python3/dist-packages share/bash-completion share/bash-completion/completions
  ${CMAKE_INSTALL_LIBDIR} ${CMAKE_INSTALL_LIBDIR}/cmake ${CMAKE_INSTALL_LIBDIR}/pkgconfig share/doc share/man
  share/man/man1)
install(CODE "set(shared_folders ${shared_folders})
set(record \"${CMAKE_BINARY_DIR}/install_record.cmake\")" ALL_COMPONENTS)
install(CODE [[
  set(installed_prefix "")
  include(${record} OPTIONAL)
  if(NOT installed_prefix STREQUAL CMAKE_INSTALL_PREFIX)
    file(WRITE ${record} "set(installed_prefix \"${CMAKE_INSTALL_PREFIX}\")\nset(made_folders)\n")
  endif()
  foreach(folder IN LISTS shared_folders)
    if(NOT EXISTS "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/${folder}")
      file(APPEND ${record} "list(APPEND made_folders ${folder})\n")
    endif()
  endforeach()]] ALL_COMPONENTS)
