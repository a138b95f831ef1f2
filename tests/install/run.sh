#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs a build afresh and builds and runs a consumer of the package:
# run.sh CMAKE BUILD_FOLDER CONSUMER_SOURCE GENERATOR COMPILER
set -euo pipefail
cmake=$1 build=$2 source=$3 generator=$4 compiler=$5
work=$build/install_test
scene=$source/../scenes/one_muscle/scene.toml
rm -rf "$work"
"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null

# The command is small, stripped of what debuggers read.
if grep -q '^CMAKE_BUILD_TYPE:[A-Z]*=RelWithDebInfo$' "$build/CMakeCache.txt" &&
  grep -q '^THEW_SANITIZE:[A-Z]*=$' "$build/CMakeCache.txt"; then
  strip -o "$work/stripped" "$work/prefix/bin/thew"
  bytes=$(stat -c %s "$work/stripped")
  echo "the stripped command has $bytes bytes"
  ((bytes <= 6000000)) || { echo "6,000,000 at most, see tools/CMakeLists.txt" >&2; exit 1; }
fi

# What is installed is the public headers, each of which stands by itself and shows no Eigen, and
# libraries without a symbol that a host's Eigen has too.
headers=$(cd "$work/prefix/include" && find . -type f | LC_ALL=C sort)
echo "$headers"
[[ $(wc -l <<<"$headers") -le 20 ]]
[[ $(grep -cv '^\./thew/[a-z_]*\.h$' <<<"$headers") == 0 ]]
for header in $headers; do
  echo "#include \"$header\"" >"$work/header.cpp"
  "$compiler" -std=c++20 -Wall -Wextra -Werror -I"$work/prefix/include" -c "$work/header.cpp" \
    -o "$work/header.o"
done
for library in "$work"/prefix/lib*/libthew_*.a "$work"/prefix/lib/*/libthew_*.a; do
  [[ -e $library ]] || continue
  count=$((${count:-0} + 1))
  nm -C "$library" >"$work/symbols.txt" 2>/dev/null
  if grep -m1 -E '(^|[^_[:alnum:]])Eigen::' "$work/symbols.txt"; then
    echo "$library: has symbols of namespace Eigen" >&2
    exit 1
  fi
done
[[ ${count:-0} == 4 ]]
if grep -rE 'EIGEN_|Eigen3|thew_eigen|ffp-contract' "$work/prefix" --include='thew-targets*.cmake'; then
  echo "the package hands flags or Eigen on to its users" >&2
  exit 1
fi

"$cmake" -S "$source" -B "$work/consumer" -G "$generator" -DCMAKE_CXX_COMPILER="$compiler" \
  -DCMAKE_PREFIX_PATH="$work/prefix"
"$cmake" --build "$work/consumer"
"$work/consumer/consumer" "$scene" "$work/bake" | tee "$work/consumer.txt"
"$(dirname "$cmake")/ctest" --test-dir "$work/consumer" --output-on-failure --no-tests=error

[[ -x $work/prefix/bin/thew ]] || exit 0  # built without THEW_TOOLS
# The same bytes from the command.
"$work/prefix/bin/thew" bake "$scene" --out "$work/command" --no-render --progress none
hash=$(sed -n 's/^ *"hash": *"\([0-9a-f]*\)".*/\1/p' "$work/command/report.json")
grep -qx "hash $hash" "$work/consumer.txt"
# And from Python, which finds the template of `thew new` and the command below the same prefix.
packages=$(echo "$work"/prefix/lib/python3*/dist-packages)
if [[ -d $packages ]]; then
  PYTHONPATH=$packages /usr/bin/python3 - "$scene" "$work/python" "$source/../scenes/figure/figure.gltf" \
    "$hash" <<'END'
import sys, subprocess, thew
scene, out, character, hash = sys.argv[1:]
assert thew.bake(thew.Scene.read(scene), out).hash == hash
assert thew.fit(character, out + "/figure.toml", side="left")["muscles"] == 12
subprocess.run([sys.executable, "-m", "thew", "inspect", out + "/bake.h5"], check=True)
END
fi
# The render test can fail: a stiffness changed by 1 % is found and named.
status=0
"$work/prefix/bin/thew" golden check "$scene" --progress none \
  --golden "$source/../golden/one_muscle" --out "$work/stiffer" \
  --set muscle.flexor.material.stiffness=1010 >"$work/stiffer.txt" || status=$?
cat "$work/stiffer.txt"
[[ $status == 1 ]] && grep -q "flexor moved" "$work/stiffer.txt"
