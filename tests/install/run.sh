#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs a build afresh and builds and runs a consumer of the package:
# run.sh CMAKE BUILD_FOLDER CONSUMER_SOURCE GENERATOR COMPILER
set -euo pipefail
cmake=$1 build=$2 source=$3 generator=$4 compiler=$5
work=$build/install_test
rm -rf "$work"
"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null
"$cmake" -S "$source" -B "$work/consumer" -G "$generator" -DCMAKE_CXX_COMPILER="$compiler" \
  -DCMAKE_PREFIX_PATH="$work/prefix"
"$cmake" --build "$work/consumer"
"$work/consumer/consumer"
