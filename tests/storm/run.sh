#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Storms over the built command, one line a part: run.sh BUILD [--share N] [--jobs N] [PART...]
# Ends with 1 after a failure, with 77 where nothing that was asked for could be tried.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# Debian's own, whose h5py reads and writes with the same HDF5 as Thew.
python=/usr/bin/python3
[[ -x $python ]] || { echo "skipped: $python is not installed"; exit 77; }
exec "$python" -B "$here/storm.py" "$@"
