#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Poses of the arm, and the example that is fitted to them: run.sh THEW ROOT OUT POSES HELD_OUT
# The set reads the same as HDF5 and as .npz, and on the poses that were held out the fit's error is
# at most a third of linear blend skinning's. Ends with 77 where numpy or h5py is missing.
set -euo pipefail
thew=$1 root=$2 out=$3 poses=$4 held_out=$5
python=/usr/bin/python3  # Debian's own
"$python" -c 'import numpy, h5py' 2>/dev/null || { echo "skipped: no numpy or no h5py"; exit 77; }
rm -rf "$out"  # of another arm
mkdir -p "$out"
sed -e "s|^scene = .*|scene = \"$(realpath -m --relative-to="$out" "$root/assets/arm/arm.toml")\"|" \
    -e "s|^random = .*|random = $poses|" "$root/tools/examples/arm_poses.toml" >"$out/ranges.toml"
for ending in npz h5; do
  "$thew" poses "$out/ranges.toml" --out "$out/arm.$ending" --overwrite --resume --progress none
done
"$python" - "$out" "$poses" <<'END'
import sys, numpy, h5py
packed, tree = numpy.load(sys.argv[1] + "/arm.npz"), h5py.File(sys.argv[1] + "/arm.h5", "r")
assert set(packed) == set(tree) | set(tree.attrs)
for name in tree:
    assert packed[name].dtype == tree[name].dtype and (packed[name] == tree[name][:]).all(), name
assert len(packed["displacement"]) == int(sys.argv[2])
assert packed["joint_names"].item() == tree.attrs["joint_names"]
END
"$python" "$root/tools/examples/fit_poses.py" "$out/arm.npz" "$held_out" | tee "$out/errors.txt"
awk '/^linear/ { alone = $6 } /^fitted/ { fitted = $3 }
     END { exit !(fitted > 0 && 3 * fitted <= alone) }' "$out/errors.txt" ||
  { echo "the fit's error is more than a third of linear blend skinning's"; exit 1; }
