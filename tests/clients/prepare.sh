#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Bakes and exports what the clients read: prepare.sh THEW SOURCE OUT
set -euo pipefail
thew=$1 source=$2 out=$3
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")

skip() { echo "skipped: $1"; exit 77; }
/usr/bin/python3 -c 'import h5py, numpy' 2>/dev/null || skip "python3-h5py is not installed"

rm -rf "$out"
mkdir -p "$out"
bake() {  # FOLDER SCENE MESH [arguments]
  local folder=$out/$1 scene=$2 mesh=$3 file
  shift 3
  "$thew" bake "$scene" --out "$folder" --no-render --progress none "$@"
  "$thew" export "$folder/bake.h5" "$folder/all.glb" --onto none --progress none >/dev/null
  for file in all.usda all.usdc all.usdz all.xdmf all.abc obj/all.####.obj; do
    "$thew" export "$folder/bake.h5" "$folder/$file" --progress none >/dev/null
  done
  for file in one.pc2 one.mdd ply/one.####.ply; do
    "$thew" export "$folder/bake.h5" "$folder/$file" --mesh "$mesh" --progress none >/dev/null
  done
  "$thew" export "$folder/bake.h5" "$folder/quantized.glb" --quantized --onto none \
    --progress none >/dev/null
  "$thew" export "$folder/bake.h5" "$folder/fields.usdc" --fields --progress none >/dev/null
  "$thew" export "$folder/bake.h5" "$folder/basis.glb" --basis 4 --onto none --progress none |
    tee "$folder/basis.txt" | tail -n 1
  # The truth, by a reader of HDF5 that is not ours.
  /usr/bin/python3 "$here/truth.py" "$folder" "$mesh"
}
bake muscle "$source/tests/scenes/one_muscle/scene.toml" flexor  # double precision
bake arm "$source/assets/arm/arm.toml" skin --set 'scene.frames="1-6"'
# A whole character, its own skin in its own vertex order: its elbows flexed, all formats ...
character=$source/tests/scenes/figure/figure.gltf
"$thew" new "$character" --template arm --out "$out/scene/figure.toml"
bake figure "$out/scene/figure.toml" skin --set 'scene.frames="20-36"'
cp "$character" "$out/figure/input.gltf"
# ... the same in pieces, materials and centimetres, put back onto the file ...
dressed=$source/tests/scenes/figure/dressed.gltf
"$thew" new "$dressed" --template arm --out "$out/pieces/dressed.toml"
"$thew" bake "$out/pieces/dressed.toml" --out "$out/onto" --no-render --progress none \
  --set 'scene.frames="20-36"'
onto() {  # FILE [arguments]
  local file=$out/onto/$1
  shift
  "$thew" export "$out/onto/bake.h5" "$file" --onto "$dressed" --progress none "$@" >/dev/null
}
onto onto.glb
onto onto_basis.glb --basis 4
onto correctives.glb --correctives
onto correctives_basis.glb --correctives --basis 4
for ending in usda usdc usdz; do onto onto.$ending; done
onto caches.pc2
# Morph targets and correctives hold the same skin.
"$thew" compare "$out/onto/onto.glb" "$out/onto/correctives.glb" --distance 0.001
/usr/bin/python3 "$here/truth.py" "$out/onto" skin
cp "$dressed" "$out/onto/input.gltf"
# ... and its own animation, for clients that play that themselves.
wave() {  # FOLDER [arguments]
  local folder=$out/$1
  shift
  "$thew" bake "$out/scene/figure.toml" --out "$folder" --no-render --progress none \
    --set 'rig.clip={ animation = "wave" }' --set 'scene.frames="1-49"' "$@"
  /usr/bin/python3 "$here/truth.py" "$folder" skin
}
wave wave
wave wave/weights --set skin.reach=1e-6  # muscles reach no skin
cp "$character" "$out/wave/input.gltf"
# One page over them all. A missed bound, 1, is as good.
"$thew" report "$out" --html "$out/night.html" || (($? == 1))
