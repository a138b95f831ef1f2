// SPDX-License-Identifier: Apache-2.0
// author_arm TABLE.csv FOLDER: makes the arm's rig, meshes and scene from its source table.
#include <cstdio>

#include "rig/types.h"
#include "tools/author/files.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: author_arm TABLE.csv FOLDER\n");
    return static_cast<int>(thew::ExitCode::kUsage);
  }
  try {
    thew::write_arm(argv[1], argv[2]);
  } catch (const thew::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
}
