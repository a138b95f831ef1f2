#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Two machines that write into one folder: shared.sh THEW ROOT OUT [ROUNDS]
# Each is a mount and process namespace of its own, which sees the folder by another path and no
# process of the other. (OUT may lie on a file system of a network; that is the better test.) One
# folder is baked by both, again and again, one of them being killed: never do two write at once,
# nothing that was kept is lost, and the end is the bytes of one process. Pictures are drawn by both
# into one folder: its list of files loses no line. Ends with 77 where namespaces are not allowed.
set -euo pipefail
thew=$(readlink -f "$1") root=$(readlink -f "$2") out=$3 rounds=${4:-6}
unshare --mount --pid --fork true 2>/dev/null || { echo "skipped: no namespaces of one's own"; exit 77; }

fail() { echo "$*"; exit 1; }
rm -rf "$out"
mkdir -p "$out"/{shared,a,b}
out=$(cd "$out" && pwd -P)
cp -r "$root/tests/scenes/pair" "$out/scene"
common=(--threads 1 --progress none --set solver.substeps=1500)
"$thew" bake "$out/scene/scene.toml" --out "$out/alone" "${common[@]}" 2>/dev/null

# on MACHINE COMMAND...: becomes it there, where HERE stands for the shared folder
on() {
  local machine=$1
  shift
  exec unshare --mount --pid --fork --kill-child bash -c '
    out=$1 here=$out/$2
    shift 2
    mount --bind "$out/shared" "$here" && mount -t proc proc /proc && exec "${@//HERE/$here}"
    ' on "$out" "$machine" "$@"
}
bake() { on "$1" "$thew" bake "$out/scene/scene.toml" --out HERE/bake --no-render --resume "${common[@]}"; }
code() { local code=0; ("$@") >/dev/null 2>"$out/errors.txt" || code=$?; echo $code; }

kept() { cat "$out/shared/bake/bake.parts/manifest.jsonl" 2>/dev/null | wc -l; }

lines=0 locked=0
for ((round = 1; round <= rounds; ++round)); do
  bake a >/dev/null 2>&1 &
  first=$!
  while kill -0 $first 2>/dev/null && (($(kept) <= lines)); do sleep 0.02; done
  b=$(code bake b)
  if [[ $b == 75 ]]; then
    locked=$((locked + 1))
  elif [[ $b != 0 ]]; then
    fail "the second ended with $b: $(<"$out/errors.txt")"
  fi
  kill -KILL $first 2>/dev/null || true
  wait $first 2>/dev/null || true
  [[ -e $out/shared/bake/bake.h5 ]] && break
  ((lines < $(kept))) || fail "there were $lines frames, and there are $(kept)"
  lines=$(kept)
done
((locked > 0)) || fail "the second machine was never kept out"
b=$(code bake b)
[[ $b == 0 ]] || fail "at the end: $b: $(<"$out/errors.txt")"
cmp "$out/alone/bake.h5" "$out/shared/bake/bake.h5" || fail "not the bytes of one process"

draw() {
  on "$1" "$thew" render HERE/bake/bake.h5 --scene "$out/scene/scene.toml" --out HERE/bake/frames \
    --frames "$2" --chunk "${common[@]}"
}
draw a 1-15x2 & first=$!
draw b 2-16x2 & second=$!
wait $first
wait $second
listed=$(grep -c '"skin\.[0-9]*\.png","bytes"' "$out/shared/bake/frames/.thew.jsonl")
((listed == 16)) || fail "$listed of 16 pictures are listed"
for ((i = 1; i <= 16; ++i)); do
  picture=$(printf 'frames/skin.%04d.png' $i)
  cmp "$out/alone/$picture" "$out/shared/bake/$picture" || fail "$picture differs"
done
echo "kept out $locked times of $rounds, $lines frames kept over kills, 16 pictures by two"
