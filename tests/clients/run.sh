#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Lets one client read the exports: run.sh blender|alembic|paraview|web|usd|chromium|night BUILD,
# where BUILD/clients is what prepare.sh made; alembic is Blender's importer of that. Exits with 77 where
# the client is not installed. BLENDER=PATH: another Blender than the installed one.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
client=$1 build=$2
folders=("$build"/clients/{muscle,arm,figure})

skip() { echo "skipped: $1"; exit 77; }
modules=$build/clients_npm
install_readers() {
  command -v npm >/dev/null || skip "npm is not installed"
  mkdir -p "$modules"
  cp "$here/package.json" "$modules"
  npm install --prefix "$modules" --no-audit --no-fund --silent >/dev/null ||
    skip "npm could not install the readers"
}
case "$client" in
  blender | alembic)
    blender=${BLENDER:-blender}
    command -v "$blender" >/dev/null || skip "blender is not installed"
    more=()
    [[ $client == alembic ]] || more=("$build/clients/onto")
    # Its importers talk a lot; ours is what names it first.
    "$blender" -b --factory-startup --python "$here/blender_read.py" -- \
      "$client" "${folders[@]}" "${more[@]}" 2>&1 |
      grep -E '^(Blender [0-9.]+,|skipped:|  |Traceback|[A-Za-z]*Error)' ;;
  paraview)
    command -v pvpython >/dev/null || skip "python3-paraview is not installed"
    pvpython "$here/paraview_read.py" "${folders[@]}" ;;
  web)
    install_readers
    node "$here/web_read.mjs" "$modules" "${folders[@]}" "$build/clients/wave" \
      "$build/clients/onto"
    node "$here/babylon_read.mjs" "$modules" "${folders[@]}" "$build/clients/onto" ;;
  usd)
    install_readers
    node "$here/usd_read.mjs" "$modules" "${folders[@]}" "$build/clients/onto" ;;
  chromium)
    command -v chromium >/dev/null || skip "chromium is not installed"
    command -v node >/dev/null || skip "node is not installed"
    node "$here/viewer_read.mjs" "${folders[@]}" ;;
  night)
    command -v chromium >/dev/null || skip "chromium is not installed"
    page=$build/clients/night_checked.html profile=$(mktemp -d)
    trap 'rm -rf "$profile"' EXIT
    { cat "$build/clients/night.html"; echo "<script>"; cat "$here/night_check.js"; echo "</script>"; } >"$page"
    told=$(timeout 100 chromium --headless=new --no-sandbox --disable-gpu --user-data-dir="$profile" \
      --window-size=500,900 --dump-dom "file://$page" 2>/dev/null | grep -o '<title>[^<]*')
    tr ';' '\n' <<<"${told#<title>}"
    [[ $told == *right* && $told != *wrong* ]] ;;
esac
