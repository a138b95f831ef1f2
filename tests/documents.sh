#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What a reader is sent to is there: documents.sh ROOT
#  - each link of a page to a file of the repository leads to one
#  - each page that a comment names is in the repository
#  - the README has 120 lines at most, its program is the example that the tests run, and the weights
#    that it sets are not those that the arm has
set -euo pipefail
cd "${1:-$(dirname "$0")/..}"
failed=0
complain() {
  echo "$1"
  failed=1
}

pages=$(find . -name '*.md' -not -path './build/*' -not -path './out/*')
[[ $(wc -l <<<"$pages") -ge 10 ]] || complain "fewer than 10 pages seen; is this the root?"
while read -r page; do
  while read -r link; do
    target=${link%%#*}
    [[ -z $target || $target == *:* ]] && continue
    [[ -e $(dirname "$page")/$target ]] || complain "$page: links to $target, which is not there"
  done < <(grep -oE '\]\([^)]+\)' "$page" | sed -E 's/^\]\(//; s/\)$//')
done <<<"$pages"

while IFS=: read -r file page; do
  [[ -n $(find . -name "$(basename "$page")" -not -path './build/*' -print -quit) ]] ||
    complain "$file: names $page, which is not there"
done < <(grep -roE --include='*.h' --include='*.cpp' '[A-Za-z_/]+\.md\b' rig muscles skin sim tools |
  LC_ALL=C sort -u)

lines=$(wc -l <README.md)
((lines <= 120)) || complain "README.md has $lines lines; 120 at most"
program=$(sed -n '/^```cpp$/,/^```$/p' README.md | grep -v '^```')
example=$(sed -n '/^#include <thew/,$p' tools/examples/bake_scene.cpp)
[[ $program == "$example" ]] || complain "README.md: its program is not tools/examples/bake_scene.cpp"
read -r muscle weights < <(
  sed -nE 's/.*--set muscle\.([a-z_]+)\.weights=([a-z]+).*/\1 \2/p' README.md)
own=$(sed -nE "/^name = \"$muscle\"/,/^weights/s/^weights = //p" assets/arm/arm.toml)
[[ -n $own && $own != "\"$weights\"" ]] ||
  complain "README.md: sets the weights of $muscle to \"$weights\"; the arm has $own"
exit $failed
