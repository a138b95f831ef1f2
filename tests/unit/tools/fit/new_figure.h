// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/unit/tools/fit/new.h"
#include "tools/base/html_page.h"

namespace thew::tests {

/// The project's own figure, to be dressed, cut and scaled, and written as glTF.
struct Figure {
  struct Joint {
    std::string name;
    int parent;
    Vec3 place;
  };
  struct Mesh {
    std::string name;
    std::vector<Vec3> positions;
    std::vector<std::array<std::uint8_t, 4>> joints;
    std::vector<std::array<float, 4>> weights;
    std::vector<Triangle> triangles;

    /// Of its weights, what is on the joints from `first` to `last`.
    double share(size_t vertex, int first, int last) const {
      double sum = 0.0;
      for (int k = 0; k < 4; ++k) {
        const int joint = joints[vertex][k];
        if (joint >= first && joint <= last) sum += weights[vertex][k];
      }
      return sum;
    }
    /// Drops the triangles whose corners are all in the test.
    template <typename Test>
    void cut(Test test) {
      std::erase_if(triangles, [&](const Triangle& t) {
        return test(positions[t[0]]) && test(positions[t[1]]) && test(positions[t[2]]);
      });
    }
  };
  std::vector<Joint> joints;
  std::vector<Mesh> meshes;
  /// m, where the first joint goes from where it is bound, one a second: animation "Walk".
  std::vector<Vec3> walk;

  Figure();
  template <typename Map>
  void place(Map map) {
    for (Joint& joint : joints) joint.place = map(joint.place);
    for (Mesh& mesh : meshes) {
      for (Vec3& p : mesh.positions) p = map(p);
    }
  }
  /// Of a mesh, toward the arms' bones, beyond the shoulders.
  static void thin(double share, Mesh& mesh);
  void write(const fs::path& file) const;
};

/// The point of the figure's left arm's line, shoulder to wrist, that is nearest.
inline Vec3 on_left_arm(const Vec3& p) {
  const Vec3 joints[] = {{0.17, 1.38, -0.02}, {0.37, 1.21, -0.035}, {0.53, 1.075, 0.02}};
  Vec3 nearest = joints[0];
  for (int k = 0; k < 2; ++k) {
    const Vec3 d = joints[k + 1] - joints[k];
    const Vec3 q = joints[k] + std::clamp(d.dot(p - joints[k]) / d.squaredNorm(), 0.0, 1.0) * d;
    if ((q - p).norm() < (nearest - p).norm()) nearest = q;
  }
  return nearest;
}

inline void Figure::thin(double share, Mesh& mesh) {
  for (Vec3& p : mesh.positions) {
    const double side = p.x() < 0.0 ? -1.0 : 1.0;
    const Vec3 left(side * p.x(), p.y(), p.z()), middle = on_left_arm(left);
    const double beyond = smoothstep(0.17, 0.2, left.x());
    const Vec3 now = left + beyond * (1.0 - share) * (middle - left);
    p = Vec3(side * now.x(), now.y(), now.z());
  }
}

inline Figure::Figure() {
  std::ifstream in(kFigure);
  const nlohmann::json json = nlohmann::json::parse(in);
  const std::string uri = json["buffers"][0]["uri"];
  const std::string bytes = from_base64(uri.substr(uri.find(',') + 1));
  const auto read = [&](const nlohmann::json& index, auto& out) {
    const nlohmann::json& accessor = json["accessors"][index.get<size_t>()];
    const nlohmann::json& view = json["bufferViews"][accessor["bufferView"].get<size_t>()];
    out.resize(accessor["count"].get<size_t>());
    std::memcpy(out.data(), &bytes[view["byteOffset"].get<size_t>()], out.size() * sizeof out[0]);
  };
  for (const nlohmann::json& index : json["skins"][0]["joints"]) {
    const nlohmann::json& node = json["nodes"][index.get<size_t>()];
    const nlohmann::json& at = node["translation"];
    joints.push_back({node["name"], -1, Vec3(at[0], at[1], at[2])});
  }
  for (size_t i = 0; i < joints.size(); ++i) {  // parents before children
    const nlohmann::json& node = json["nodes"][i];
    for (const int child : node.value("children", std::vector<int>{})) {
      joints[child].parent = static_cast<int>(i);
    }
  }
  for (Joint& joint : joints) {
    if (joint.parent >= 0) joint.place += joints[joint.parent].place;
  }
  const nlohmann::json& primitive = json["meshes"][0]["primitives"][0];
  Mesh& mesh = meshes.emplace_back();
  mesh.name = "Body";
  std::vector<std::array<float, 3>> positions;
  std::vector<std::uint16_t> corners;
  read(primitive["attributes"]["POSITION"], positions);
  read(primitive["attributes"]["JOINTS_0"], mesh.joints);
  read(primitive["attributes"]["WEIGHTS_0"], mesh.weights);
  read(primitive["indices"], corners);
  for (const auto& p : positions) mesh.positions.emplace_back(p[0], p[1], p[2]);
  for (size_t i = 0; i + 2 < corners.size(); i += 3) {
    mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  }
}

inline void Figure::write(const fs::path& file) const {
  std::string bytes;
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  const auto add = [&](const auto& values, const char* type, int component) {
    nlohmann::json& views = json["bufferViews"];
    views.push_back({{"buffer", 0},
                     {"byteOffset", bytes.size()},
                     {"byteLength", values.size() * sizeof values[0]}});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
    bytes.resize((bytes.size() + 3) / 4 * 4);
    nlohmann::json& accessors = json["accessors"];
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component},
                         {"count", values.size()},
                         {"type", type}});
    return accessors.size() - 1;
  };
  std::vector<std::array<float, 16>> binds;
  std::vector<int> all, roots;
  for (size_t i = 0; i < joints.size(); ++i) {
    const Joint& joint = joints[i];
    const Vec3 at = joint.parent < 0 ? joint.place : Vec3(joint.place - joints[joint.parent].place);
    json["nodes"].push_back({{"name", joint.name}, {"translation", {at.x(), at.y(), at.z()}}});
    if (joint.parent >= 0) json["nodes"][joint.parent]["children"].push_back(i);
    if (joint.parent < 0) roots.push_back(static_cast<int>(i));
    const Vec3 p = -joint.place;
    binds.push_back({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, static_cast<float>(p.x()),
                     static_cast<float>(p.y()), static_cast<float>(p.z()), 1});
    all.push_back(static_cast<int>(i));
  }
  json["skins"].push_back({{"joints", all}, {"inverseBindMatrices", add(binds, "MAT4", 5126)}});
  for (const Mesh& mesh : meshes) {
    std::vector<std::array<float, 3>> positions;
    std::array<float, 3> low{1e9f, 1e9f, 1e9f}, high{-1e9f, -1e9f, -1e9f};
    for (const Vec3& p : mesh.positions) {
      const std::array<float, 3> x{static_cast<float>(p.x()), static_cast<float>(p.y()),
                                   static_cast<float>(p.z())};
      positions.push_back(x);
      for (int k = 0; k < 3; ++k)
        low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
    }
    std::vector<std::uint32_t> corners;
    for (const Triangle& t : mesh.triangles) {
      for (const int i : t) corners.push_back(static_cast<std::uint32_t>(i));
    }
    const auto place = add(positions, "VEC3", 5126);
    json["accessors"][place]["min"] = low;
    json["accessors"][place]["max"] = high;
    const nlohmann::json attributes = {{"POSITION", place},
                                       {"JOINTS_0", add(mesh.joints, "VEC4", 5121)},
                                       {"WEIGHTS_0", add(mesh.weights, "VEC4", 5126)}};
    json["meshes"].push_back(
        {{"name", mesh.name},
         {"primitives",
          {{{"attributes", attributes}, {"indices", add(corners, "SCALAR", 5125)}}}}});
    roots.push_back(static_cast<int>(json["nodes"].size()));
    json["nodes"].push_back(
        {{"name", mesh.name + "Node"}, {"mesh", json["meshes"].size() - 1}, {"skin", 0}});
  }
  if (!walk.empty()) {
    std::vector<float> times;
    std::vector<std::array<float, 3>> places;
    for (const Vec3& step : walk) {
      const Eigen::Vector3f at = (joints[0].place + step).cast<float>();
      times.push_back(static_cast<float>(times.size()));
      places.push_back({at.x(), at.y(), at.z()});
    }
    json["animations"].push_back(
        {{"name", "Walk"},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
         {"samplers",
          {{{"input", add(times, "SCALAR", 5126)}, {"output", add(places, "VEC3", 5126)}}}}});
  }
  json["scenes"].push_back({{"nodes", roots}});
  json["buffers"].push_back({{"byteLength", bytes.size()},
                             {"uri", "data:application/octet-stream;base64," + base64(bytes)}});
  std::ofstream(file) << json;
}

/// Scenes of figures.
class FigureScene : public NewScene {
 protected:
  NewOptions options(const Figure& figure, const std::string& side = "both", double scale = 1.0) {
    figure.write(folder / "figure.gltf");
    NewOptions asked_for = asked(folder / "figure.gltf", side, scale);
    asked_for.out = folder / "scene" / "character.toml";
    return asked_for;
  }
  Model built(const NewOptions& asked_for, const std::vector<std::string>& overrides) {
    EXPECT_EQ(new_command(asked_for), ExitCode::kDone);
    return build_model(read_scene(asked_for.out, overrides));
  }
};

}  // namespace thew::tests
