# SPDX-License-Identifier: Apache-2.0
# What Debian asks of a package beyond `cmake --install`, done to each component's staging folder by
# cpack: licence and changes, pages compressed, libraries without what a debugger wants.
foreach(component command library python)
  set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}/usr)
  if(NOT IS_DIRECTORY ${root})
    continue()
  endif()
  string(TOUPPER ${component} upper)
  set(doc ${root}/share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  file(READ ${CMAKE_CURRENT_LIST_DIR}/copyright copyright)
  file(WRITE ${doc}/copyright "${copyright}")
  file(WRITE ${doc}/changelog "thew (${CPACK_PACKAGE_VERSION}) stable; urgency=medium\n
  * What a version changes is said in tools/RELEASES.md of its sources.\n
 -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  Thu, 01 Jan 1970 00:00:00 +0000\n")
  file(GLOB packages ${root}/lib/python3.*/dist-packages)
  foreach(folder ${packages})  # where Debian keeps what is of any version
    file(MAKE_DIRECTORY ${root}/lib/python3)
    file(RENAME ${folder} ${root}/lib/python3/dist-packages)
    cmake_path(GET folder PARENT_PATH folder)
    file(REMOVE_RECURSE ${folder})
  endforeach()
  file(GLOB pages ${root}/share/man/man1/*.1 ${doc}/changelog)
  foreach(page ${pages})
    execute_process(COMMAND gzip -9nf ${page} COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  file(GLOB_RECURSE libraries ${root}/*.a)
  foreach(library ${libraries})
    execute_process(COMMAND strip --strip-debug --enable-deterministic-archives ${library}
      COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  file(GLOB_RECURSE files LIST_DIRECTORIES true ${root}/*)
  foreach(file ${files})
    if(IS_DIRECTORY ${file} OR file MATCHES "/bin/")
      file(CHMOD ${file} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
        WORLD_READ WORLD_EXECUTE)
    else()
      file(CHMOD ${file} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
    endif()
  endforeach()
endforeach()
