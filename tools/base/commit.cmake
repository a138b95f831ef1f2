# SPDX-License-Identifier: Apache-2.0
# cmake -D SOURCE=folder -D OUT=commit.cpp -P commit.cmake: writes the commit of the folder, where it
# is a checkout itself and does not merely lie in one. OUT keeps its time where it says so already.
set(commit unknown)
find_package(Git QUIET)
if(GIT_FOUND)
  set(git ${CMAKE_COMMAND} -E env GIT_OPTIONAL_LOCKS=0 ${GIT_EXECUTABLE} -C ${SOURCE})
  execute_process(COMMAND ${git} rev-parse --show-cdup
    OUTPUT_VARIABLE up OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed AND up STREQUAL "")
    execute_process(COMMAND ${git} describe --always --dirty --abbrev=40 --exclude=*
      OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
    if(NOT failed AND described MATCHES "^[0-9a-f]+(-dirty)?$")
      set(commit ${described})
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[
#include "tools/base/commit.h"
namespace thew::tools {
const char* const kCommit = "@commit@";
}
]])
