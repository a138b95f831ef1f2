#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# symbols.sh THEW THEW_LAB: the product holds nothing of the yardsticks, whose symbols the
# laboratory shows: finite elements, Delaunay tetrahedra, the methods of others, and Bullet.
set -euo pipefail
yardsticks='FemBody|FemMaterial|RoundBody|RivalBody|nlopt_|TetMesh|delaunay|\bbt(SoftBody|CollisionShape|Vector3)|BulletBody'
count() { nm --demangle "$1" | grep -cE "$yardsticks" || true; }
in_product=$(count "$1")
in_laboratory=$(count "$2")
echo "$in_product of them in $1, $in_laboratory in $2"
[ "$in_product" -eq 0 ] && [ "$in_laboratory" -gt 10 ]
