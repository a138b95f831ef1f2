#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One character by all ways out of Blender gives one bake: routes.sh THEW SOURCE OUT [FRAMES]. Exits
# with 77 where Blender is not installed. Characters that only the project's authors have are taken
# where they are. The frames are those of the elbow's flexion before its deepest fold, in which a
# rounding error still grows (skin/notes.md, known limits).
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
thew=$1 source=$2 out=$3 frames=${4:-1-24}
blender=${BLENDER:-blender}

skip() { echo "skipped: $1"; exit 77; }
command -v "$blender" >/dev/null || skip "blender is not installed"
/usr/bin/python3 -c 'import h5py, numpy, scipy' 2>/dev/null ||
  skip "python3-h5py or python3-scipy is not installed"

bake() {  # CHARACTER FOLDER [OPTION...]
  mkdir -p "$2"
  "$thew" new "$1" --out "$2/scene.toml" >"$2/new.txt" 2>&1 || { cat "$2/new.txt"; return 1; }
  "$thew" bake "$2/scene.toml" --out "$2" --no-render --progress none --frames "$frames" "${@:3}"
}

# The figure without its animation: Thew takes the elbow's axis from one, and Blender interpolates
# between its keys in another way.
mkdir -p "$out"
/usr/bin/python3 - "$source/tests/scenes/figure/figure.gltf" "$out/figure.gltf" <<'EOF'
import json, sys
document = json.load(open(sys.argv[1]))
del document["animations"]
json.dump(document, open(sys.argv[2], "w"))
EOF

wrong=0
for character in "$out/figure.gltf" \
  "$source"/../shared/data/{cesium_man.gltf,makehuman.glb}; do
  [[ -e $character ]] || { echo "  $(basename "$character") is not there"; continue; }
  name=$(basename "${character%.*}")
  folder=$out/$name
  rm -rf "$folder"
  mkdir -p "$folder"
  "$blender" -b --factory-startup --python-exit-code 1 --python "$here/blender_routes.py" -- \
    "$character" "$folder" >"$folder/blender.txt" 2>&1 || { tail "$folder/blender.txt"; exit 1; }
  bake "$character" "$folder/input"
  for file in "$folder"/*.{glb,fbx,dae}; do
    bake "$file" "$folder/$(basename "$file" | tr . _)" || wrong=1
  done
  /usr/bin/python3 "$here/routes_check.py" "$folder" "$name" || wrong=1
done

# A rig of Rigify's in its own animation, by all its bones and by those alone that deform it.
folder=$out/rigify
rm -rf "$folder"
mkdir -p "$folder"
"$blender" -b --factory-startup --python-exit-code 1 --python "$here/blender_rigify.py" -- \
  "$folder" >"$folder/blender.txt" 2>&1 || { tail "$folder/blender.txt"; exit 1; }
own=(--set 'rig.clip={animation="rigAction"}' --set 'scene.frames="1-24"')
bake "$folder/all.glb" "$folder/input" "${own[@]}" || wrong=1
bake "$folder/deforming.glb" "$folder/deforming" "${own[@]}" || wrong=1
/usr/bin/python3 "$here/routes_check.py" "$folder" rigify || wrong=1
exit $wrong
