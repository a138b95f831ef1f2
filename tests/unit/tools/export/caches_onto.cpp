// SPDX-License-Identifier: Apache-2.0
//
// A character of several meshes as point caches.
#include <gtest/gtest.h>

#include <map>

#include "tests/unit/tools/export/onto.h"

namespace thew::tests {
namespace {

TEST_F(OntoTest, PointCachesAreOneForEachMesh) {
  bake_character({-0.2, 1.45, 0.0});
  choice_.character = character_;
  write("bent.pc2", {});
  std::map<std::string, std::string> last;  // frame by node: parts are one after another
  const std::vector<float> all = as_floats(positions("skin", kFrames - 1));
  for (std::size_t p = 0, at = 0; p < plain_.parts.size(); ++p) {
    const std::size_t end = 3 * (p + 1 < plain_.parts.size() ? plain_.parts[p + 1].first_vertex
                                                             : plain_.mesh.vertices.size());
    last[plain_.parts[p].node].append(reinterpret_cast<const char*>(&all[at]), 4 * (end - at));
    at = end;
  }
  EXPECT_EQ(last.size(), 3u);
  for (const auto& [name, points] : last) {
    EXPECT_TRUE(bytes_of(folder_ / ("bent." + name + ".pc2")).ends_with(points)) << name;
    EXPECT_TRUE(fs::exists(folder_ / ("bent." + name + ".rest.obj"))) << name;
  }
}

}  // namespace
}  // namespace thew::tests
