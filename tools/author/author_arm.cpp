// SPDX-License-Identifier: Apache-2.0
// author_arm TABLE.csv FOLDER: makes the arm's rig, meshes and scene from its source table.
#include <cstdio>

#include "rig/types.h"
#include "tools/author/files.h"
#include "tools/base/exit_code.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: author_arm TABLE.csv FOLDER\n");
    return static_cast<int>(thew::tools::ExitCode::kUsage);
  }
  try {
    thew::tools::write_arm(argv[1], argv[2]);
  } catch (const thew::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(thew::tools::exit_code_of(error.code()));
  }
}
