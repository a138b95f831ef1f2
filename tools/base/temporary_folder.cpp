// SPDX-License-Identifier: Apache-2.0
#include "tools/base/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "rig/types.h"

namespace thew::tools {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(const std::string& what) {
  const char* folder = std::getenv("TMPDIR");
  std::string name = (fs::path(folder && *folder ? folder : "/tmp") / ("thew_" + what)).string();
  name += "_XXXXXX";
  if (!mkdtemp(name.data())) {
    throw Error(ErrorCode::kOutput, name + ": cannot be made (" + std::strerror(errno) +
                                        "); set TMPDIR to a folder with space");
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!kept_) fs::remove_all(path_, ignored);
}

}  // namespace thew::tools
