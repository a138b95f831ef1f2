# SPDX-License-Identifier: Apache-2.0
# find_package(thew CONFIG): thew::rig, thew::muscles, thew::skin, thew::sim, the command thew::thew
# and thew_add_render_test(). Found here is what static libraries have to be linked with; no header
# of these packages is seen by a user, and Eigen is not needed at all.
include(CMakeFindDependencyMacro)
enable_language(C)  # FindHDF5 needs it
find_dependency(assimp 5.2)
find_dependency(urdfdom)
find_dependency(HDF5 COMPONENTS C)
find_dependency(Threads)
find_dependency(PkgConfig)
pkg_check_modules(seccomp REQUIRED IMPORTED_TARGET libseccomp)
pkg_check_modules(deflate REQUIRED IMPORTED_TARGET libdeflate)
include(${CMAKE_CURRENT_LIST_DIR}/thew-targets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/thew-render-test.cmake)
