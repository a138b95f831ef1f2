#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# hash_bake for AArch64, to run on this machine: tests/determinism/aarch64.sh FOLDER
# Debian's packages for it go into FOLDER/root, not into the system; FOLDER/hash_bake runs it by qemu.
set -euo pipefail
source=$(cd -P -- "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.." >/dev/null && pwd)
for program in apt-get aarch64-linux-gnu-g++ qemu-aarch64-static; do
  command -v $program >/dev/null || { echo "aarch64.sh: there is no $program" >&2; exit 1; }
done
mkdir -p "$1"
cd -P -- "$1"
here=$PWD

if [[ ! -e root/complete ]]; then
  rm -rf root apt
  mkdir -p apt/state/lists/partial apt/cache/archives/partial root/usr/{lib,bin,sbin}
  ln -s usr/lib usr/bin usr/sbin root
  touch apt/status
  cat >apt/conf <<END
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "root";
Dir::State "$here/apt/state";
Dir::State::status "$here/apt/status";
Dir::Cache "$here/apt/cache";
END
  wanted=(libstdc++-12-dev $(awk '!/^#/ && NF == 1 && /-dev$/ { print $1 }' \
    "$source/tools/packages.txt"))
  export APT_CONFIG=$here/apt/conf
  apt-get -qq update
  apt-get -qq install -y --download-only "${wanted[@]}"
  for package in apt/cache/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -x -C root --keep-directory-symlink
  done
  # Links and CMake's files with absolute paths.
  find root -type l -lname '/*' -printf '%p %l\n' | while read -r link target; do
    ln -sfn "$here/root$target" "$link"
  done
  grep -rlE '[":; ]/usr/(lib|include)' root/usr/lib/aarch64-linux-gnu/cmake root/usr/share/*/cmake |
    xargs sed -Ei "s#([\":; ])/usr/(lib|include)#\1$here/root/usr/\2#g"
  unset APT_CONFIG
  rm -rf apt
  touch root/complete
fi

# FindHDF5 would ask the compiler wrapper of this machine.
hdf5=$here/root/usr/lib/aarch64-linux-gnu/hdf5/serial/libhdf5.so
export PKG_CONFIG_SYSROOT_DIR=$here/root
export PKG_CONFIG_LIBDIR=$here/root/usr/lib/aarch64-linux-gnu/pkgconfig:$here/root/usr/share/pkgconfig
cmake -S "$source" -B build -G Ninja -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
  -DCMAKE_C_COMPILER=aarch64-linux-gnu-gcc -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ \
  -DCMAKE_SYSROOT="$here/root" -DCMAKE_FIND_ROOT_PATH="$here/root" \
  -DCMAKE_FIND_ROOT_PATH_MODE_PROGRAM=NEVER -DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=ONLY \
  -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY \
  -DCMAKE_LIBRARY_ARCHITECTURE=aarch64-linux-gnu -DHDF5_C_LIBRARY_hdf5="$hdf5" \
  -DTHEW_TOOLS=OFF -DTHEW_TESTS=OFF
cmake --build build --target hash_bake
cat >hash_bake <<END
#!/bin/sh
exec qemu-aarch64-static -L "$here/root" "$here/build/tests/determinism/hash_bake" "\$@"
END
chmod +x hash_bake
