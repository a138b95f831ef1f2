# SPDX-License-Identifier: Apache-2.0
# cmake -D "FILES=a.css;b.frag" -D OUT=texts.cpp -P embed.cmake: writes each file as a constant of
# thew::tools that is named after it, kACss and kBFrag, without its line of licence. Who uses one
# declares it: extern const char* const kACss. A line #include "file" stands for that file's text.
function(read_text file out)
  file(READ ${file} text)
  string(REGEX REPLACE "^[^\n]*SPDX-License-Identifier[^\n]*\n" "" text "${text}")
  get_filename_component(folder ${file} DIRECTORY)
  while(text MATCHES "#include \"([^\"]+)\"\n")
    set(line "${CMAKE_MATCH_0}")
    read_text(${folder}/${CMAKE_MATCH_1} included)
    string(REPLACE "${line}" "${included}" text "${text}")
  endwhile()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

set(source "namespace thew::tools {\n")
foreach(file ${FILES})
  read_text(${file} text)
  set(name k)
  get_filename_component(words ${file} NAME)
  string(REGEX MATCHALL "[a-z0-9]+" words ${words})
  foreach(word ${words})
    string(SUBSTRING ${word} 0 1 initial)
    string(SUBSTRING ${word} 1 -1 others)
    string(TOUPPER ${initial} initial)
    string(APPEND name ${initial}${others})
  endforeach()
  string(APPEND source "extern const char* const ${name};\n"
    "const char* const ${name} = R\"embedded(${text})embedded\";\n")
endforeach()
file(WRITE ${OUT} "${source}}\n")
