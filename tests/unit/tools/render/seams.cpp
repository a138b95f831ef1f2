// SPDX-License-Identifier: Apache-2.0
//
// A muscle whose file has a place several times, as along the seam of a texture: simulated as one
// surface, written as its file has it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "sim/scene/reader.h"
#include "tests/unit/tools/export/export.h"
#include "tools/cli/inspect_command.h"
#include "tools/render/renderer.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kScene = fs::path(THEW_SOURCE_DIR) / "tests/scenes/one_muscle";

std::string line_of(const char* key, const Vec3& p) {
  char text[100];
  std::snprintf(text, sizeof text, "%s %.9g %.9g %.9g\n", key, p.x(), p.y(), p.z());
  return text;
}

/// A muscle cut open lengthwise: the vertices in the plane z = 0 are in its file twice, one after
/// the other, and each side of the plane has its own.
struct Cut {
  TriMesh whole, in_file;
  std::vector<int> node;  // of each vertex of the file

  explicit Cut(const TriMesh& mesh) : whole(mesh) {
    std::vector<int> behind, before;
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
      const bool twice = std::abs(mesh.vertices[i].z()) < 1e-9;
      if (twice) whole.vertices[i].z() = 0.0;
      behind.push_back(static_cast<int>(node.size()));
      for (int k = 0; k < (twice ? 2 : 1); ++k) {
        node.push_back(static_cast<int>(i));
        in_file.vertices.push_back(whole.vertices[i]);
      }
      before.push_back(static_cast<int>(node.size()) - 1);
    }
    for (const Triangle& t : mesh.triangles) {
      double z = 0.0;
      for (const int i : t) z += mesh.vertices[i].z();
      const std::vector<int>& side = z > 0.0 ? before : behind;
      in_file.triangles.push_back({side[t[0]], side[t[1]], side[t[2]]});
    }
  }
};

std::string obj_of(const TriMesh& mesh) {
  std::string text;
  for (const Vec3& p : mesh.vertices) text += line_of("v", p);
  for (const auto& [a, b, c] : mesh.triangles) {
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
            std::to_string(c + 1) + "\n";
  }
  return text;
}

class Seams : public ExportTest {
 protected:
  Seams() : cut_(build_model(read_scene(kScene / "scene.toml")).muscles[0].rest) {
    put_bytes(folder_ / "rig.urdf", bytes_of(kScene / "rig.urdf"));
    std::string scene = bytes_of(kScene / "scene.toml");
    const size_t begin = scene.find("[muscle.profile]"), end = scene.find("[output]");
    put_bytes(folder_ / "scene.toml", scene.replace(begin, end - begin, "mesh = \"flexor.obj\"\n"));
  }
  /// bake.h5 of the mesh in FOLDER/name.
  fs::path bake_of(const std::string& name, const TriMesh& mesh) {
    put_bytes(folder_ / "flexor.obj", obj_of(mesh));
    CommandOptions options;
    options.input = folder_ / "scene.toml";
    options.out = folder_ / name;
    options.progress = "none";
    options.frames = "1-24x23";
    options.pictures = false;
    EXPECT_EQ(bake_command(options), ExitCode::kDone);
    return options.out / "bake.h5";
  }
  Cut cut_;
};

TEST_F(Seams, ABakeHasTheFilesVerticesAndWhatTheWholeMuscleDoes) {
  const BakeReader whole(bake_of("whole", cut_.whole)), cut(bake_of("cut", cut_.in_file));
  const BakeMesh &one = whole.info().meshes[0], &mesh = cut.info().meshes[0];
  ASSERT_GT(cut_.node.size(), cut_.whole.vertices.size() + 10);
  ASSERT_EQ(one.rest.vertices.size(), cut_.whole.vertices.size());
  ASSERT_EQ(mesh.rest.vertices.size(), cut_.node.size());
  EXPECT_EQ(mesh.rest.triangles, cut_.in_file.triangles);
  for (size_t i = 0; i < cut_.node.size(); ++i) {
    const int node = cut_.node[i];
    EXPECT_EQ(mesh.rest.vertices[i].cast<float>(), cut_.in_file.vertices[i].cast<float>());
    EXPECT_EQ(mesh.weights[i], one.weights[node]);
    EXPECT_EQ(mesh.coordinates[i], one.coordinates[node]);
    for (int f = 0; f < 2; ++f) {
      EXPECT_EQ(cut.read(f).positions[0][i], whole.read(f).positions[0][node]) << i << ", " << f;
    }
  }
}

struct Obj {
  std::vector<Vec3> v, vn;
  explicit Obj(const fs::path& file) {
    std::istringstream in(bytes_of(file));
    for (std::string key; in >> key; std::getline(in, key)) {
      if (key != "v" && key != "vn") continue;
      Vec3& p = (key == "v" ? v : vn).emplace_back();
      in >> p[0] >> p[1] >> p[2];
    }
  }
};

TEST_F(Seams, ExportsGoOnTheFilesVerticesAndShadeNoSeam) {
  options_.input = bake_of("whole", cut_.whole);
  write("whole.####.obj", {});
  options_.input = bake_of("cut", cut_.in_file);
  const BakeReader bake(options_.input);
  write("cut.####.obj", {});
  const Obj one(folder_ / "whole.0024.obj"), obj(folder_ / "cut.0024.obj");
  EXPECT_EQ(obj.v, bake.read(1).positions[0]);
  ASSERT_EQ(obj.vn.size(), cut_.node.size());
  for (size_t i = 0; i < obj.vn.size(); ++i) EXPECT_EQ(obj.vn[i], one.vn[cut_.node[i]]) << i;
  ByteReader cache{bytes_of(write("a.pc2", {"flexor"}))};
  cache.at = 16;  // "POINTCACHE2\0", version
  ASSERT_EQ(cache.take<std::int32_t>(), static_cast<std::int32_t>(cut_.node.size()));
  cache.at += 12;  // first frame, step, frames
  const BakeFrame first = bake.read(0);
  for (const Vec3& p : first.positions[0]) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(cache.take<float>(), static_cast<float>(p[k]));
  }
}

TEST_F(Seams, PicturesAndInspectionSeeTheWholeMuscle) {
  const fs::path whole = bake_of("whole", cut_.whole), cut = bake_of("cut", cut_.in_file);
  const BakeReader one(whole), other(cut);
  for (const char* show : {"muscles", "weights"}) {
    SceneView view;
    view.show = show, view.eye = Vec3(0.1, -0.3, 1.2), view.target = Vec3(0, -0.3, 0);
    Renderer first(320, 240, one.info().meshes), second(320, 240, other.info().meshes);
    EXPECT_EQ(first.draw(view, one.read(1).positions).rgb,
              second.draw(view, other.read(1).positions).rgb)
        << show;
  }
  const json found = json::parse(inspect(cut, true).text);
  EXPECT_EQ(found.at("crossings"), json::parse(inspect(whole, true).text).at("crossings"));
  EXPECT_LT(found.at("meshes")[0].at("max_volume_error_written").get<double>(), 1e-12);
}

}  // namespace
}  // namespace thew::tests
