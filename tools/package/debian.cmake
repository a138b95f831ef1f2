# SPDX-License-Identifier: Apache-2.0
# cpack --config build/release/CPackConfig.cmake: thew, libthew-dev and python3-thew, as .deb.
if(NOT THEW_TOOLS)
  return()
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL command library)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/stage.cmake)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "Thew's maintainers <maintainers@thew.invalid>")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME thew)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_COMMAND_PACKAGE_DEPENDS libosmesa6)  # loaded, not linked: render/gl_context.cpp
set(CPACK_DEBIAN_COMMAND_PACKAGE_SUGGESTS ffmpeg)
set(CPACK_COMPONENT_COMMAND_DESCRIPTION "muscles and skin of animated characters
Reads a rig and its motion, carries muscles along that keep their volume to
rounding error, lays the skin over them, and writes a geometry cache, pictures
and a report that states the error of every frame.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libthew-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
string(JOIN ", " CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "thew (= ${PROJECT_VERSION})"
  libassimp-dev liburdfdom-dev libhdf5-dev libseccomp-dev libdeflate-dev pkg-config)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "muscles and skin of animated characters (C++)
Headers, static libraries and the CMake package of Thew: scenes from files and
arrays, simulation, bakes, caches.")

if(TARGET thew_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-thew)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  get_target_property(versions thew_python THEW_PYTHON_VERSIONS)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "thew (= ${PROJECT_VERSION}), python3-numpy, ${versions}")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    ${CMAKE_CURRENT_LIST_DIR}/postinst ${CMAKE_CURRENT_LIST_DIR}/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-matplotlib)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "muscles and skin of animated characters (Python 3)
Module thew: scenes from files and numpy arrays, bakes with progress, caches
as arrays, simulation by steps.")
endif()
include(CPack)
