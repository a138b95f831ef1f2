// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/scene/reader.h"
#include "sim/scene/scene.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {

using Settings = std::vector<std::string>;

// The message of the Error(kUsage) that reading throws, from the file's name on; "" where none is
// thrown.
inline std::string usage_error(const std::filesystem::path& file, const Settings& overrides = {}) {
  try {
    read_scene(file, overrides);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage) << error.what();
    const std::string message = error.what();
    return message.starts_with("--set") ? message : message.substr(file.string().size());
  }
  return "";
}

#define EXPECT_STARTS(text, start) EXPECT_EQ((text).substr(0, std::string(start).size()), start)

class SceneFile : public TempFolder {
 protected:
  // Lines 1 to 12 are a sound scene; `more` begins on line 13.
  std::filesystem::path scene(const std::string& more = "") const {
    write("rig.urdf", "<robot/>");
    return write("arm.toml",
                 "[scene]\n"
                 "frames = \"1-10\"\n"
                 "[rig]\n"
                 "file = \"rig.urdf\"\n"
                 "[[muscle]]\n"
                 "name = \"biceps\"\n"
                 "path = [\n"
                 "  [\"humerus\", 0, 0, 0],\n"
                 "  [\"ulna\", 0, 0.1, 0],\n"
                 "]\n"
                 "profile = { radius = [[0, 0.01]] }\n"
                 "\n" +
                     more);
  }
  std::string error_of(const std::string& more, const Settings& overrides = {}) const {
    return usage_error(scene(more), overrides);
  }
};

}  // namespace thew::tests
