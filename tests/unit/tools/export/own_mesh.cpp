// SPDX-License-Identifier: Apache-2.0
//
// A skin put back onto the mesh of the program that it came from.
#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <sstream>

#include "tests/unit/rig/temp.h"
#include "tests/unit/tools/export/onto.h"

namespace thew::tests {
namespace {

/// An artist's mesh: one vertex a place, backwards, with quads where two triangles follow each
/// other along an edge, and a material from face 7 on.
struct Artist {
  std::vector<int> of_bake;             // by vertex, the bake's first at the place
  std::vector<std::vector<int>> faces;  // vertices of the artist's
};

class OwnMeshTest : public OntoTest {
 protected:
  OwnMeshTest() {
    bake_character({-0.2, 1.45, 0.0});
    std::map<int, int> number;  // of a place
    for (int v = static_cast<int>(plain_.map_back.size()); v-- > 0;) {
      if (plain_.map_back[v] != v) continue;
      number[v] = static_cast<int>(artist_.of_bake.size());
      artist_.of_bake.push_back(v);
    }
    const auto own = [&](int v) { return number.at(plain_.map_back[v]); };
    for (const Triangle& t : plain_.mesh.triangles) {
      const std::vector<int> face = {own(t[0]), own(t[1]), own(t[2])};
      if (!artist_.faces.empty() && join(face, artist_.faces.back())) continue;
      artist_.faces.push_back(face);
    }
    choice_.character = folder_ / "own.obj";
    write_obj();
  }

  /// Makes a quad of a triangle and one that has an edge of it. False where it has none.
  static bool join(const std::vector<int>& face, std::vector<int>& last) {
    if (last.size() != 3) return false;
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        if (face[j] != last[(k + 1) % 3] || face[(j + 1) % 3] != last[k]) continue;
        last.insert(last.begin() + k + 1, face[(j + 2) % 3]);
        return true;
      }
    }
    return false;
  }

  /// In the character's file's own units, which the scene scaled by kScale.
  void write_obj(const std::string& more = "") {
    std::ostringstream text;
    text.precision(9);
    for (const int v : artist_.of_bake) {
      text << "v " << (plain_.mesh.vertices[v] / kScale).transpose() << "\nvt 0." << v << " 0.5\n";
    }
    for (std::size_t f = 0; f < artist_.faces.size(); ++f) {
      if (f == 0) text << "usemtl cloth\n";
      if (f == 7) text << "usemtl skin\n";
      text << "f";
      for (const int v : artist_.faces[f]) text << " " << v + 1 << "/" << v + 1;
      text << "\n";
    }
    put_bytes(choice_.character, text.str() + more);
  }

  std::string expected_points() const {
    std::string points;
    for (int i = 0; i < kFrames; ++i) {
      const std::vector<Vec3> baked = positions("skin", i);
      for (const int v : artist_.of_bake) {
        for (int axis = 0; axis < 3; ++axis) {
          const auto x = static_cast<float>(baked[v][axis]);
          points.append(reinterpret_cast<const char*>(&x), sizeof x);
        }
      }
    }
    return points;
  }

  Artist artist_;
};

TEST_F(OwnMeshTest, PointCacheIsInItsOrder) {
  EXPECT_TRUE(bytes_of(write("own.pc2", {})).ends_with(expected_points()));
  EXPECT_HAS(said_, "Up to -Y");
  EXPECT_TRUE(bytes_of(write("own.mdd", {})).size() > expected_points().size());
}

TEST_F(OwnMeshTest, PolygonsAndTextureCoordinatesAreItsOwn) {
  std::size_t quads = 0;
  for (const auto& face : artist_.faces) quads += face.size() == 4;
  EXPECT_GT(quads, artist_.faces.size() / 3);
  options_.frames = "6";
  write("own.####.obj", {"skin"});
  std::istringstream in(bytes_of(folder_ / "own.0006.obj"));
  std::vector<std::vector<int>> faces, uvs;
  std::vector<std::string> materials;
  std::vector<Vec3> vertices;
  for (std::string line, word; std::getline(in, line);) {
    std::istringstream words(line);
    words >> word;
    if (word == "usemtl") materials.push_back(line.substr(7));
    if (word == "v") {
      Vec3& p = vertices.emplace_back();
      words >> p.x() >> p.y() >> p.z();
    }
    if (word != "f") continue;
    faces.emplace_back();
    uvs.emplace_back();
    for (int v, vt, vn; words >> v && words.get() && words >> vt && words.get() && words >> vn;) {
      faces.back().push_back(v - 1);
      uvs.back().push_back(vt - 1);
    }
  }
  EXPECT_EQ(faces, artist_.faces);
  EXPECT_EQ(uvs, artist_.faces);
  EXPECT_EQ(materials, (std::vector<std::string>{"cloth", "skin"}));
  const std::vector<Vec3> baked = positions("skin", kFrames - 1);
  ASSERT_EQ(vertices.size(), artist_.of_bake.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    EXPECT_LT((vertices[v] - baked[artist_.of_bake[v]]).norm(), 1e-12);
  }
  const std::string usd = bytes_of(write("own.usda", {}));
  std::string counts;
  for (const auto& face : artist_.faces) counts += ", " + std::to_string(face.size());
  std::string flat;  // without the writer's line breaks
  for (const char c : usd.substr(usd.find("faceVertexCounts = ["))) {
    if (c == ']') break;
    if (c != '\n' && !(c == ' ' && (flat.empty() || flat.back() == ' '))) flat += c;
  }
  EXPECT_EQ(", " + flat.substr(20), counts);
}

TEST_F(OwnMeshTest, BadFilesAreRefusedWithLineOrVertex) {
  const auto refused = [&](const std::string& word) {
    expect_refused(ErrorCode::kInput, word, "own.pc2", {});
  };
  const std::string lines = std::to_string(2 * artist_.of_bake.size() + artist_.faces.size() + 3);
  write_obj("f 1 2\n");
  refused("own.obj:" + lines + ": a face has fewer than three corners");
  write_obj("f 1 2 99999\n");
  refused("a face names vertex \"99999\"");
  write_obj("f 1 2 x\n");
  refused("a face names vertex \"x\"");
  write_obj("v 1 2 nan\n");
  refused("v needs a number as its word 3");
  write_obj("v 5 5 5\n");
  refused("1 of " + std::to_string(artist_.of_bake.size() + 1) +
          " vertices are none of the bake's skin; vertex " +
          std::to_string(artist_.of_bake.size() + 1) + " lies ");
  put_bytes(choice_.character, "v 0 0 0\n");
  refused("holds no faces");
  choice_.character = folder_ / "none.obj";
  refused("none.obj");
  choice_.character = folder_ / "own.obj";
  write_obj();
  expect_refused(ErrorCode::kUsage, "convert the character", "own.glb", {});
}

/// The character as a program writes it that numbers its own points: backwards here.
class NumberedTest : public OntoTest {
 protected:
  void number(const std::function<float(std::size_t part, std::size_t v)>& of) {
    json doc = was_.doc;
    std::string numbers = was_.numbers;
    for (std::size_t p = 0; p < plain_.parts.size(); ++p) {
      const MeshPart& part = plain_.parts[p];
      json& attributes = doc["meshes"][part.mesh_index]["primitives"][part.primitive]["attributes"];
      const std::size_t count = was_.accessor(attributes["POSITION"])["count"];
      while (numbers.size() % 4 != 0) numbers += '\0';
      doc["bufferViews"].push_back(
          {{"buffer", 0}, {"byteOffset", numbers.size()}, {"byteLength", 4 * count}});
      for (std::size_t v = 0; v < count; ++v) {
        const float value = of(p, v);
        numbers.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
      attributes["__THEW_VERTEX"] = doc["accessors"].size();
      doc["accessors"].push_back({{"bufferView", doc["bufferViews"].size() - 1},
                                  {"componentType", 5126},
                                  {"count", count},
                                  {"type", "SCALAR"}});
    }
    doc["buffers"][0] = {{"byteLength", numbers.size()}, {"uri", "numbered.bin"}};
    put_bytes(folder_ / "numbered.bin", numbers);
    put_bytes(folder_ / "numbered.gltf", doc.dump());
    choice_.character = folder_ / "numbered.gltf";
  }
};

TEST_F(NumberedTest, PointCachesAreByTheNumbers) {
  bake_character({-0.2, 1.45, 0.0});
  // By node, vertices of its parts one after another; a number for each, backwards.
  std::map<std::string, std::vector<std::size_t>> of_node;
  std::vector<std::size_t> first(plain_.parts.size());
  for (std::size_t p = 0; p < plain_.parts.size(); ++p) {
    const std::size_t end = p + 1 < plain_.parts.size() ? plain_.parts[p + 1].first_vertex
                                                        : plain_.mesh.vertices.size();
    std::vector<std::size_t>& vertices = of_node[plain_.parts[p].node];
    first[p] = vertices.size();
    for (std::size_t v = plain_.parts[p].first_vertex; v < end; ++v) vertices.push_back(v);
  }
  number([&](std::size_t p, std::size_t v) {
    return static_cast<float>(of_node[plain_.parts[p].node].size() - 1 - first[p] - v);
  });
  write("bent.pc2", {});
  const std::vector<Vec3> last = positions("skin", kFrames - 1);
  for (auto& [name, vertices] : of_node) {
    std::string points;
    for (std::size_t i = vertices.size(); i-- > 0;) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto x = static_cast<float>(last[vertices[i]][axis]);
        points.append(reinterpret_cast<const char*>(&x), sizeof x);
      }
    }
    EXPECT_TRUE(bytes_of(folder_ / ("bent." + name + ".pc2")).ends_with(points)) << name;
  }
}

TEST_F(NumberedTest, NumbersWithoutSenseAreRefused) {
  bake_character({-0.2, 1.45, 0.0});
  number([](auto, auto) { return 0.0f; });
  expect_refused(ErrorCode::kInput, "_thew_vertex is 0 at two places", "bent.pc2", {});
  number([](auto, std::size_t v) { return 0.5f + static_cast<float>(v); });
  expect_refused(ErrorCode::kInput, " is 0.5; number the points", "bent.pc2", {});
  number([](auto p, std::size_t v) { return static_cast<float>(10000 * p + 2 * v); });
  expect_refused(ErrorCode::kInput, "_thew_vertex has no ", "bent.pc2", {});
}

}  // namespace
}  // namespace thew::tests
