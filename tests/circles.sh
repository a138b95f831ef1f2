#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# No file depends on one that depends on it: circles.sh ROOT
# A file is a header together with the source of its name. Prints each circle, and ends with 1.
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
grep -rnoE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"[^"]+"' \
    --include='*.h' --include='*.cpp' rig muscles skin sim tools |
  sed -E 's/\.(h|cpp):[0-9]+:.*"([^"]+)\.h".*/ \2/' | awk '$1 != $2' | LC_ALL=C sort -u |
  awk '
  { ++edges; from[$1] = from[$1] " " $2; names[$1]; names[$2] }
  # The oldest of the names that are still being looked at and that lead back to one another (Tarjan
  # 1972).
  function visit(name,   list, count, i, next_) {
    order[name] = low[name] = ++seen
    stack[++top] = name
    open[name] = 1
    count = split(from[name], list, " ")
    for (i = 1; i <= count; ++i) {
      next_ = list[i]
      if (!(next_ in order)) visit(next_)
      if (open[next_] && low[next_] < low[name]) low[name] = low[next_]
    }
    if (low[name] != order[name]) return
    list_ = ""
    members = 0
    do {
      next_ = stack[top--]
      open[next_] = 0
      list_ = list_ " " next_
      ++members
    } while (next_ != name)
    if (members > 1) {
      print "include each other in a circle:" list_
      bad = 1
    }
  }
  END {
    if (edges < 100) { print "only " edges + 0 " includes seen; is this the root?"; exit 1 }
    for (name in names) if (!(name in order)) visit(name)
    exit bad
  }'
