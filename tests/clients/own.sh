#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# An artist's own object out of Blender and back: own.sh THEW SOURCE OUT. It has quads and an order of
# vertices that no exporter keeps. Exits with 77 where Blender is not installed.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
thew=$1 source=$2 out=$3
blender=${BLENDER:-blender}

skip() { echo "skipped: $1"; exit 77; }
command -v "$blender" >/dev/null || skip "blender is not installed"
/usr/bin/python3 -c 'import h5py, numpy' 2>/dev/null || skip "python3-h5py is not installed"

in_blender() {
  "$blender" -b --factory-startup --python-exit-code 1 --python "$here/blender_own.py" -- "$@" \
    >"$out/blender.txt" 2>&1 || { tail "$out/blender.txt"; exit 1; }
  grep '^own object' "$out/blender.txt"
}

for character in "$source/tests/scenes/figure/dressed.gltf" \
  "$source"/../shared/data/{cesium_man.gltf,makehuman.glb,robot.glb}; do
  [[ -e $character ]] || { echo "  $(basename "$character") is not there"; continue; }
  echo "$(basename "$character")"
  rm -rf "$out"
  mkdir -p "$out"
  in_blender make "$character" "$out"
  for way in glb fbx; do
    folder=$out/$way
    mkdir "$folder"
    "$thew" new "$out/own.$way" --out "$folder/scene.toml" >"$folder/new.txt" 2>&1 ||
      { cat "$folder/new.txt"; exit 1; }
    "$thew" bake "$folder/scene.toml" --out "$folder" --no-render --progress none --frames 1-12
    "$thew" export "$folder/bake.h5" "$folder/placed.pc2" --onto "$out/own.obj" --progress none \
      >/dev/null
    "$thew" export "$folder/bake.h5" "$folder/own.usda" --onto "$out/own.obj" --progress none \
      >/dev/null
  done
  "$thew" export "$out/glb/bake.h5" "$out/glb/numbered.pc2" --onto "$out/own.glb" --progress none \
    >/dev/null
  /usr/bin/python3 "$here/own_check.py" "$out"
  in_blender check "$out" "$out/truth.npz" "$out/glb/numbered.own.pc2" 1
  in_blender check "$out" "$out/truth.npz" "$out/glb/placed.pc2" 1
done
