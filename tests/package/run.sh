#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The packages, installed and removed in a bare Debian: run.sh BUILD SOURCE WORK. As root, with the
# network that apt needs; exits with 77 otherwise.
set -euo pipefail
build=$1 source=$2 work=$3
skip() { echo "skipped: $1"; exit 77; }
for program in lintian debootstrap dpkg-deb; do
  command -v $program >/dev/null || skip "$program is not installed"
done
((EUID == 0)) || skip "a bare root is made by root alone"

rm -rf "$work/deb"
mkdir -p "$work/deb"
cpack --config "$build/CPackConfig.cmake" -B "$work/deb" >"$work/cpack.txt" ||
  { cat "$work/cpack.txt"; exit 1; }
debs=("$work"/deb/{thew,libthew-dev,python3-thew}_*.deb)
ls -l "${debs[@]}"
lintian --allow-root --fail-on error "${debs[@]}"

# Debian once, kept as a file; of it a root for each run.
bare=$work/bare.tar root=$work/root
mirror=$(grep -rhoE 'https?://[^ ]*/debian/? ' /etc/apt/sources.list /etc/apt/sources.list.d \
  2>/dev/null | head -1 | tr -d ' ' || true)  # where this machine's own packages come from
clear_root() {
  umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$root" "$root.bundle"
}
trap clear_root EXIT
clear_root
if [[ ! -f $bare ]]; then
  debootstrap --variant=minbase --include=ca-certificates bookworm "$root" \
    ${mirror:+"$mirror"} >"$work/debootstrap.txt" 2>&1 ||
    skip "debootstrap did not come through; see $work/debootstrap.txt"
  tar -C "$root" -cf "$bare.part" . && mv "$bare.part" "$bare"
else
  mkdir -p "$root" && tar -C "$root" -xf "$bare"
fi
cp /etc/resolv.conf "$root/etc/resolv.conf"
mount -t proc proc "$root/proc"
inside() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    chroot "$root" "$@"
}
quiet() { "$@" >"$work/log.txt" 2>&1 || { tail -30 "$work/log.txt"; exit 1; }; }
mkdir "$root/try"
cp "${debs[@]}" "$root/try"
cp -r "$source/tests/scenes" "$source/tools/examples" "$root/try"
quiet inside apt-get -q update
# What the test itself needs comes first, so that what remains afterwards is of the packages.
quiet inside apt-get -q install -y --no-install-recommends man-db bash-completion cmake g++ make
quiet inside sh -c 'apt-get -q install -y --no-install-recommends /try/*.deb'

inside thew --version
inside thew bake /try/scenes/one_muscle/scene.toml --out /try/command --progress none
inside python3 - <<'END'
import json, thew
bake = thew.bake(thew.Scene.read("/try/scenes/one_muscle/scene.toml"), "/try/module")
hash = json.load(open("/try/command/report.json"))["hash"]
assert bake.hash == hash and bake.meshes["flexor"].positions.shape[0] == 24
assert thew.fit("/try/scenes/figure/figure.gltf", "/try/fit/figure.toml")["muscles"] == 24
END
inside python3 -m thew inspect /try/module/bake.h5 >/dev/null
quiet inside cmake -S /try/examples -B /try/consumer
quiet inside cmake --build /try/consumer
inside /try/consumer/example_bake_scene /try/scenes/one_muscle/scene.toml /try/consumer/bake |
  tail -1 | grep -F "$(grep -oE '"hash": "[0-9a-f]+' "$root/try/command/report.json" | cut -c10-)"
inside man thew | grep -q 'thew bake SCENE'
inside man thew-lab | grep -q 'thew chart'
inside bash -c '. /usr/share/bash-completion/bash_completion; _completion_loader thew
  COMP_WORDS=(thew bak) COMP_CWORD=1; _thew thew bak thew; [[ ${COMPREPLY[*]} == bake ]]'

quiet inside apt-get -q purge -y thew libthew-dev python3-thew
rm -r "$root/try"
# But for caches of apt and man themselves.
left=$(find "$root" -xdev -iname '*thew*' -not -path '*/var/cache/*')
[[ -z $left ]] || { echo "left behind: $left"; exit 1; }
echo "installed, used and removed without a trace"

command -v umoci >/dev/null || exit 0
image=$work/image
rm -rf "$image"
clear_root
quiet "$source/tools/package/image" "$work/deb" "$image" "$bare"
umoci unpack --image "$image:latest" "$root.bundle" >/dev/null
mv "$root.bundle/rootfs" "$root" && rm -r "$root.bundle"
mount -t proc proc "$root/proc"
cp -r "$source/tests/scenes" "$root/scenes"
inside thew bake /scenes/one_muscle/scene.toml --out /out --no-render --progress none
echo "and baked in an OCI image"
