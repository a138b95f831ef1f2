# SPDX-License-Identifier: Apache-2.0
# thew_add_render_test(NAME name SCENE scene.toml [GOLDEN folder])
#
# A test that bakes and draws the scene as its goldens were and fails where a vertex moved or a pixel
# changed: it prints what, and writes NAME/compare.html into the build folder. GOLDEN is golden/
# beside the scene unless given. Goldens are made once by
#   thew golden update SCENE --golden FOLDER --frames ...
# and rewritten on purpose by the same, or for all tests at once by building `golden_update`.
function(thew_add_render_test)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME;SCENE;GOLDEN" "")
  if(NOT arg_NAME OR NOT arg_SCENE OR arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "thew_add_render_test(NAME name SCENE scene.toml [GOLDEN folder]), "
      "not \"${ARGV}\"")
  endif()
  if(NOT TARGET thew::thew)
    message(FATAL_ERROR "thew_add_render_test: this build of Thew has no command; "
      "configure it with THEW_TOOLS=ON")
  endif()
  cmake_path(ABSOLUTE_PATH arg_SCENE BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  if(NOT arg_GOLDEN)
    cmake_path(GET arg_SCENE PARENT_PATH arg_GOLDEN)
    set(arg_GOLDEN ${arg_GOLDEN}/golden)
  endif()
  cmake_path(ABSOLUTE_PATH arg_GOLDEN BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  set(arguments ${arg_SCENE} --golden ${arg_GOLDEN} --progress none)
  add_test(NAME ${arg_NAME} COMMAND $<TARGET_FILE:thew::thew> golden check ${arguments}
    --out ${CMAKE_CURRENT_BINARY_DIR}/${arg_NAME})
  set_tests_properties(${arg_NAME} PROPERTIES LABELS golden)
  if(NOT TARGET golden_update)
    add_custom_target(golden_update)
  endif()
  add_custom_target(${arg_NAME}_update VERBATIM
    COMMAND $<TARGET_FILE:thew::thew> golden update ${arguments})
  add_dependencies(golden_update ${arg_NAME}_update)
endfunction()
