#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Job templates of a small show are as published, and their tasks, run as a worker would, make what
# --local makes: openjd.sh THEW ROOT OUT. Ends with 77 where python3-jsonschema is not installed.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
thew=$(readlink -f "$1") root=$2 out=$3
/usr/bin/python3 -c 'import jsonschema' 2>/dev/null ||
  { echo "skipped: python3-jsonschema is not installed"; exit 77; }
rm -rf "$out"
mkdir -p "$out"
cp -r "$root/tests/scenes/pair" "$out/scene"
cat >"$out/jobs.toml" <<'END'
chunk = 3
pictures = 4
exports = ["baked.usda", "baked.obj"]
[[character]]
name = "moving"
scene = "scene/scene.toml"
[[character]]
name = "posed"
scene = "scene/scene.toml"
set = ["solver.integrator=quasi_static", "scene.name=it's posed"]
[[shot]]
name = "calm"
frames = "1-7"
[[shot]]
name = "bent"
frames = "8-16x2"
END
"$thew" farm "$out/jobs.toml" --openjd "$out/jobs" >/dev/null
check() { /usr/bin/python3 "$here/openjd_check.py" "$@"; }
check --run "$out"/jobs/shots/*/template.json
check "$out/jobs/report/template.json"
if command -v openjd >/dev/null; then  # the project's own client
  for template in "$out"/jobs/shots/*/template.json "$out/jobs/report/template.json"; do
    openjd check "$template"
  done
fi
"$thew" farm "$out/jobs.toml" --local --out "$out/here" >/dev/null 2>"$out/here.txt" || true
[[ $(find "$out/here" -name bake.h5 | wc -l) == 4 ]] || { cat "$out/here.txt"; exit 1; }
while read -r file; do
  cmp "$out/here/$file" "$out/bakes/$file"
done < <(cd "$out/here" && find . -name bake.h5 -o -name '*.png' -o -name 'baked.*')

# A template that is not as published is found to be so.
for change in 's/"dependsOn": "[^"]*"/"dependsOn": "nothing"/' 's/NOTIFY_THEN_TERMINATE/NOTIFY/' \
  's/"default": "\.\./"default": "\/../' 's/{{Param.Bakes}}/{{Param.Bake}}/'; do
  sed "$change" "$out/jobs/shots/calm/template.json" >"$out/broken.json"
  check "$out/broken.json" >/dev/null 2>&1 && { echo "taken in spite of $change"; exit 1; }
done
echo "4 broken templates were refused"
