#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# House rules that a machine can check: include_order.sh ROOT
#  - include only to the left: rig < muscles < skin < sim < tools < tests, and inside of these the
#    rooms in the order of the list below; tools/author and tools/lab come after the product, so that
#    nothing of it includes them
#  - a folder holds 30 files of code at most
#  - public headers are those in FOLDER/include/thew, 20 at most; they include nothing but one another
#    and the standard library
#  - GL lives in tools only
#  - rig, muscles and skin print nothing, read no clock, start no thread; up to sim no function of
#    libm whose bytes differ by processor
#  - no two headers define a type of one name in one namespace: the linker takes either
#  - a file is read in one sitting and names its licence
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
find rig muscles skin sim tools tests \
    \( -name '*.h' -o -name '*.cpp' -o -name 'CMakeLists.txt' -o -name '*.cmake' \
       -o -name '*.sh' -o -name '*.py' \) |
  LC_ALL=C sort | xargs -d '\n' awk '
  BEGIN {
    count = split("rig muscles skin sim tools tests", order, " ")
    for (i = 1; i <= count; ++i) rank[order[i]] = i
    count = split("rig rig/import rig/api muscles muscles/api skin/surface skin/contact skin " \
        "sim/cache sim/maps sim/scene sim/solver sim sim/fidelity sim/bake sim/api tools/examples " \
        "tools/base tools/render tools/report tools/night tools/export tools/export/gltf tools/export/usd " \
        "tools/compare tools/inspect tools/fit tools/poses tools/farm tools/cli tools/python tools/author " \
        "tools/lab/base " \
        "tools/lab/elements tools/lab/rivals tools/lab/paper tools/lab/chart tools/lab/related tools/lab/failure " \
        "tools/lab/peers tools/lab/bench tools/lab/results tools/lab", rooms, " ")
    for (i = 1; i <= count; ++i) room_rank[rooms[i]] = i
  }
  function complain(what) { print FILENAME ":" FNR ": " what; bad = 1 }
  FNR == 1 {
    ++files
    folder = substr(FILENAME, 1, index(FILENAME, "/") - 1)
    room = FILENAME
    sub(/\/[^\/]*$/, "", room)
    code = FILENAME ~ /\.(h|cpp)$/
    if (code && ++filled[room] == 31) complain(room " holds more than 30 files of code")
    if (code && folder != "tests" && !(room in room_rank) && room !~ /\/include\/thew$/)
      complain(room " is in no order; give it a place in tests/include_order.sh")
    public = room ~ /\/include\/thew$/
    if (public && ++headers == 21) complain("more than 20 public headers")
    example = room == "tools/examples"
    licensed = 0
  }
  FNR <= 2 && /^(\/\/|#) SPDX-License-Identifier: Apache-2\.0$/ { licensed = 1 }
  FNR == 2 && !licensed { complain("no line SPDX-License-Identifier: Apache-2.0 at the top") }
  FNR == 451 { complain("more than 450 lines; split it by idea") }
  FILENAME ~ /\.h$/ && /^namespace / { space = $2 }
  FILENAME ~ /\.h$/ && folder != "tests" && /^(struct|class) [A-Za-z]+ .*{/ {
    type = space "::" $2
    if (type in defined) complain(type " is defined in " defined[type] " as well")
    defined[type] = FILENAME
  }
  /^[ \t]*#[ \t]*include[ \t]*"/ {
    split($0, part, "\"")
    target = substr(part[2], 1, index(part[2], "/") - 1)
    if (target == "thew") next  # the public headers
    if (public) complain("public header includes \"" part[2] "\", which is not installed")
    if (example) complain("an example includes \"" part[2] "\", which is not installed")
    if (!(target in rank) && folder != "tests")
      complain("\"" part[2] "\" has no folder; write \"folder/file.h\"")
    if (rank[target] > rank[folder]) complain(folder " includes " target ", to its right")
    their_room = part[2]
    sub(/\/[^\/]*$/, "", their_room)
    if (room in room_rank && room_rank[their_room] > room_rank[room])
      complain(room " includes " their_room ", to its right")
  }
  /^[ \t]*#[ \t]*include[ \t]*</ {
    split($0, part, /[<>]/)
    if (public && part[2] ~ /[.\/]/)
      complain("public header includes <" part[2] ">; only the standard library may be seen")
    if (part[2] ~ /^(GL|GLES[23]?|EGL|KHR)\// && folder != "tools")
      complain("<" part[2] "> outside tools")
  }
  rank[folder] < rank["sim"] &&
      /#[ \t]*include[ \t]*<(iostream|chrono|ctime|random|thread|future)>/ {
    complain("a library that prints nothing, reads no clock and starts no thread")
  }
  rank[folder] < rank["tools"] && /std::(sin|cos|tan|asin|acos|atan2?|pow|exp|log)\(/ {
    complain("its bytes differ by processor; use rig/math.h")
  }
  END {
    if (files < 10) { print "only " files + 0 " files seen; is this the root?"; bad = 1 }
    exit bad
  }'
