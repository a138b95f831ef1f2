#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Draws the picture of the first page: first_page.sh THEW BAKE.h5 OUT.png, from a bake of arm.toml
# (frames 1, 42 and 60: 0, 90 and 130 degrees). Needs ImageMagick.
set -euo pipefail
thew=$1 bake=$2 out=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
{
  printf '[render]\nsize = [1600, 1600]\n'
  for kind in muscles skin; do
    printf '[[render.view]]\nname = "%s"\nshow = "%s"\nfrom = [0.62, 0.06, 0.78]\n' $kind $kind
  done
} >"$work/views.toml"
rows=()
for kind in muscles skin; do
  panels=()
  for frame in 1 42 60; do  # each as near as shows it
    "$thew" render "$bake" --scene "$work/views.toml" --frames $frame --out "$work/$frame" \
      >"$work/said.txt" 2>&1 || { cat "$work/said.txt"; exit 1; }
    panels+=("$work/$frame/$kind.$(printf %04d $frame).png")
  done
  convert "${panels[0]}" -crop 1120x1600+480+0 +repage "$work/hanging.png"
  convert "$work/hanging.png" "${panels[1]}" "${panels[2]}" +append "$work/$kind.png"
  rows+=("$work/$kind.png")
done
convert "${rows[@]}" -append -resize 1296x -strip "$out"
