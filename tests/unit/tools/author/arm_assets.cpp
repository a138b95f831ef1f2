// SPDX-License-Identifier: Apache-2.0
// The committed arm against its specification: the paper's table 2, published volumes and moment
// arms, and its own source table.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "muscles/path.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/math.h"
#include "sim/scene/reader.h"
#include "sim/scene/scene.h"
#include "skin/surface/surface.h"
#include "tools/author/files.h"
#include "tools/author/table.h"
#include "tools/lab/results/anatomy.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kArm = fs::path(THEW_SOURCE_DIR) / "assets/arm";

struct Part {
  std::string name;
  TriMesh mesh;  // at rest, in the root's frame
  Surface surface;
  Points x;
  Bvh bvh;
};

Part make_part(const std::string& name, const fs::path& file, const Vec3& shift) {
  Part part{name, import_closed_mesh(file), {}, {}, {}};
  for (Vec3& p : part.mesh.vertices) p += shift;
  part.surface = make_surface(part.mesh.triangles, static_cast<int>(part.mesh.vertices.size()));
  part.x = to_points(part.mesh.vertices);
  part.bvh = build_bvh(part.surface, part.x);
  return part;
}

struct Arm {
  Skeleton skeleton = arm_skeleton();
  Pose rest = rest_pose(skeleton);
  std::vector<TableMuscle> table = read_muscle_table(kArm / "muscles.csv", skeleton);
  std::vector<Part> muscles, bones;
  Part skin = make_part("skin", kArm / "skin.obj", Vec3::Zero());

  Arm() {
    for (const TableMuscle& m : table) {
      muscles.push_back(make_part(m.name, kArm / "muscles" / (m.name + ".obj"), Vec3::Zero()));
    }
    for (int b = 0; b < skeleton.size(); ++b) {
      const std::string& name = skeleton.body_names[b];
      bones.push_back(make_part(name, kArm / "bones" / (name + ".obj"), rest[b].translation()));
    }
  }
};

const Arm& arm() {
  static const Arm arm;
  return arm;
}

size_t index_of(const std::string& name) {
  for (size_t m = 0; m < arm().table.size(); ++m) {
    if (arm().table[m].name == name) return m;
  }
  throw std::out_of_range(name);
}

double path_length(const std::string& name, double degrees) {
  const Skeleton& skeleton = arm().skeleton;
  std::vector<double> joints(skeleton.size(), 0.0);
  joints[find_body(skeleton, "ulna")] = degrees * kDegree;
  Pose pose;
  forward_kinematics(skeleton, joints, pose);
  return 1e3 * trace_path(arm().table[index_of(name)].path, pose).length;  // mm
}

// Hong, Jung, Choi, Welch 2006, table 2, in its order; volumes: published MRI means and, for 6 and
// 10 to 12, estimates (cm^3); the triceps' sum divided as BodyParts3D divides it.
TEST(ArmAssets, HaveThePapersTrianglesAndPublishedVolumes) {
  const std::vector<std::pair<int, double>> expected = {
      {680, 85}, {520, 58},  {760, 142}, {760, 67}, {1064, 150}, {440, 30},
      {280, 11}, {840, 145}, {680, 81}, {680, 28}, {660, 28},   {1380, 28}};
  ASSERT_EQ(arm().muscles.size(), expected.size());
  size_t total = 0;
  for (size_t m = 0; m < expected.size(); ++m) {
    const Part& part = arm().muscles[m];
    EXPECT_EQ(part.mesh.triangles.size(), static_cast<size_t>(expected[m].first)) << part.name;
    EXPECT_NEAR(enclosed_volume(part.mesh) * 1e6 / expected[m].second, 1.0, 1e-4) << part.name;
    total += part.mesh.triangles.size();
  }
  EXPECT_EQ(total, 8744u);
}

// import_closed_mesh has refused every other defect.
TEST(ArmAssets, HaveNeitherFoldsNorSelfIntersections) {
  const auto check = [](const Part& part) {
    const auto normal = [&](int t) {
      const Triangle& tri = part.mesh.triangles[t];
      const std::vector<Vec3>& v = part.mesh.vertices;
      return Vec3((v[tri[1]] - v[tri[0]]).cross(v[tri[2]] - v[tri[0]]));
    };
    int folds = 0;
    for (size_t t = 0; t < part.mesh.triangles.size(); ++t) {
      for (int other : part.surface.neighbours[t]) {
        folds += other > static_cast<int>(t) && normal(static_cast<int>(t)).dot(normal(other)) < 0;
      }
    }
    EXPECT_EQ(folds, 0) << part.name << ": dihedral beyond 90 degrees";
    EXPECT_TRUE(
        crossing_triangles(part.surface, part.bvh, part.x, part.surface, part.bvh, part.x).empty())
        << part.name;
  };
  for (const Part& part : arm().muscles) check(part);
  for (const Part& part : arm().bones) check(part);
  check(arm().skin);
}

// Pole, rings, pole: an importer that splits and welds corners must give that order back.
TEST(ArmAssets, ImportInTheOrderOfTheirRings) {
  for (size_t m = 0; m < arm().table.size(); ++m) {
    const TableMuscle& row = arm().table[m];
    const std::vector<Vec3>& nodes = arm().muscles[m].mesh.vertices;
    const std::vector<Vec3> path = trace_path(row.path, arm().rest).points;
    ASSERT_EQ(nodes.size(), static_cast<size_t>(row.around * row.rings + 2));
    EXPECT_LT((nodes.front() - path.front()).norm(), 1e-7) << row.name;
    EXPECT_LT((nodes.back() - path.back()).norm(), 1e-7) << row.name;
    for (int ring = 0; ring < row.rings; ++ring) {  // neighbours on a ring are neighbours in number
      double step = 0.0, across = 0.0;
      for (int k = 0; k < row.around; ++k) {
        const Vec3& p = nodes[1 + ring * row.around + k];
        step += (nodes[1 + ring * row.around + (k + 1) % row.around] - p).norm();
        across += (nodes[1 + ring * row.around + (k + row.around / 2) % row.around] - p).norm();
      }
      EXPECT_LT(step, 0.3 * across) << row.name << ", ring " << ring;
    }
  }
}

TEST(ArmAssets, BelliesAreSpindlesWithOneMaximum) {
  for (size_t m = 0; m < arm().table.size(); ++m) {
    const TableMuscle& row = arm().table[m];
    std::vector<double> areas;
    const int first = static_cast<int>(row.before.size());
    for (int ring = first; ring < row.rings - static_cast<int>(row.after.size()); ++ring) {
      const Vec3* p = &arm().muscles[m].mesh.vertices[1 + ring * row.around];
      Vec3 area = Vec3::Zero();
      for (int k = 0; k < row.around; ++k) area += 0.5 * p[k].cross(p[(k + 1) % row.around]);
      areas.push_back(area.norm());
    }
    int maxima = 0;  // a bump within 3 % of the largest section is no maximum to the eye
    const double slack = 0.03 * *std::max_element(areas.begin(), areas.end());
    double low = 0.0, high = 0.0;
    bool rising = true;
    for (double area : areas) {
      if (rising && area < high - slack) {
        ++maxima;
        rising = false;
        low = area;
      } else if (!rising && area > low + slack) {
        rising = true;
        high = area;
      }
      high = std::max(high, area);
      low = std::min(low, area);
    }
    EXPECT_EQ(maxima, 1) << row.name;
  }
}

TEST(ArmAssets, MusclesDoNotCrossOneAnother) {
  for (size_t i = 0; i < arm().muscles.size(); ++i) {
    for (size_t j = i + 1; j < arm().muscles.size(); ++j) {
      const Part &a = arm().muscles[i], &b = arm().muscles[j];
      EXPECT_TRUE(crossing_triangles(a.surface, a.bvh, a.x, b.surface, b.bvh, b.x).empty())
          << a.name << " and " << b.name;
    }
  }
}

// They enter bone only where they are attached to it: within 12 mm of origin or insertion.
TEST(ArmAssets, MusclesEnterBonesOnlyAtTheirAttachments) {
  constexpr double kPatch = 0.012;
  for (size_t m = 0; m < arm().muscles.size(); ++m) {
    const Part& muscle = arm().muscles[m];
    const auto& path = arm().table[m].path.points;
    const std::vector<Vec3>& nodes = muscle.mesh.vertices;
    for (size_t b = 0; b < arm().bones.size(); ++b) {
      const Part& bone = arm().bones[b];
      const auto attached = [&](const Vec3& p) {
        return (path.front().body == static_cast<int>(b) && (p - nodes.front()).norm() < kPatch) ||
               (path.back().body == static_cast<int>(b) && (p - nodes.back()).norm() < kPatch);
      };
      int outside = 0;
      for (const auto& pair : crossing_triangles(muscle.surface, muscle.bvh, muscle.x, bone.surface,
                                                 bone.bvh, bone.x)) {
        const Triangle& t = muscle.mesh.triangles[pair[0]];
        outside += !attached(nodes[t[0]]) && !attached(nodes[t[1]]) && !attached(nodes[t[2]]);
      }
      EXPECT_EQ(outside, 0) << muscle.name << " and " << bone.name;
    }
  }
}

TEST(ArmAssets, PathsAreAsLongAsThoseOfArm26) {
  for (const auto& [name, angles, lengths] : kArm26Lengths) {
    for (size_t k = 0; k < lengths.size(); ++k) {
      EXPECT_NEAR(path_length(name, angles[k]), lengths[k], 2.5) << name << " at " << angles[k];
    }
  }
}

TEST(ArmAssets, OtherPathsShortenAsTheMomentArmsSay) {
  for (const auto& [name, angles, shortening] : kShortenings) {
    const double rest = path_length(name, 0.0);
    for (size_t k = 0; k < shortening.size(); ++k) {
      EXPECT_NEAR(rest - path_length(name, angles[k]), shortening[k], 2.5)
          << name << " at " << angles[k];
    }
  }
}

TEST(ArmAssets, PathsChangeContinuouslyWithTheAngle) {
  for (const TableMuscle& row : arm().table) {
    double before = path_length(row.name, 0.0);
    for (int degrees = 1; degrees <= 130; ++degrees) {
      const double now = path_length(row.name, degrees);
      EXPECT_LT(std::abs(now - before), 72.0 * kDegree) << row.name;  // moment arm below 72 mm
      before = now;
    }
  }
}

TEST(ArmAssets, SkinEnclosesAllWithTwoMillimetres) {
  const Part& skin = arm().skin;
  const auto check = [&](const Part& part) {
    for (const Point& x : part.x) {
      const ClosestPoint near = closest_point(skin.surface, skin.bvh, skin.x, to_vec(x), 0.2);
      ASSERT_LT(near.distance, -0.002) << part.name;
    }
    for (const Triangle& t : skin.mesh.triangles) {  // nodes and middles of triangles and edges
      for (const Vec3& w : {Vec3(1, 0, 0), Vec3(0.5, 0.5, 0), Vec3(1. / 3, 1. / 3, 1. / 3)}) {
        const Vec3 p = w[0] * skin.mesh.vertices[t[0]] + w[1] * skin.mesh.vertices[t[1]] +
                       w[2] * skin.mesh.vertices[t[2]];
        const ClosestPoint near = closest_point(part.surface, part.bvh, part.x, p, 0.002);
        ASSERT_EQ(near.triangle, -1) << part.name << " is " << near.distance << " m below the skin";
      }
    }
  };
  for (const Part& part : arm().muscles) check(part);
  for (const Part& part : arm().bones) check(part);
}

TEST(ArmAssets, SceneAndRigAgreeWithTheTable) {
  const Scene scene = read_scene(kArm / "arm.toml");
  const Skeleton rig = import_urdf(kArm / "arm.urdf", kArm);
  const Skeleton& skeleton = arm().skeleton;
  ASSERT_EQ(rig.body_names, skeleton.body_names);
  EXPECT_EQ(rig.joint_names, skeleton.joint_names);
  for (int b = 1; b < rig.size(); ++b) {
    EXPECT_LT((rig.joint_in_parent[b].matrix() - skeleton.joint_in_parent[b].matrix()).norm(),
              1e-9);
    EXPECT_LT((rig.joint_axes[b] - skeleton.joint_axes[b]).norm(), 1e-8);
    EXPECT_NEAR(rig.upper[b], skeleton.upper[b], 1e-8);
  }
  ASSERT_EQ(scene.muscles.size(), arm().table.size());
  for (size_t m = 0; m < scene.muscles.size(); ++m) {
    const SceneMuscle& muscle = scene.muscles[m];
    const TableMuscle& row = arm().table[m];
    ASSERT_EQ(muscle.name, row.name);
    EXPECT_NEAR(muscle.belly[0], row.belly[0], 1e-9);
    EXPECT_NEAR(muscle.belly[1], row.belly[1], 1e-9);
    EXPECT_NEAR(muscle.twist_from, row.twist_from, 1e-9);
    EXPECT_NEAR(muscle.f_max, row.f_max, 1e-6);
    ASSERT_EQ(muscle.path.size(), row.path.points.size());
    for (size_t k = 0; k < muscle.path.size(); ++k) {
      EXPECT_EQ(muscle.path[k].body, skeleton.body_names[row.path.points[k].body]);
      EXPECT_LT((muscle.path[k].position - row.path.points[k].position).norm(), 1e-8);
    }
    ASSERT_EQ(muscle.wraps.size(), row.path.wraps.size());
    for (size_t k = 0; k < muscle.wraps.size(); ++k) {
      EXPECT_NEAR(muscle.wraps[k].radius, row.path.wraps[k].radius, 1e-9);
      EXPECT_EQ(muscle.wraps[k].turn, row.path.wraps[k].turn);
    }
  }
}

std::string bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(ArmAssets, AuthorWritesTheCommittedBytesAgain) {
#ifdef THEW_SANITIZED
  GTEST_SKIP() << "many minutes there of one thread's arithmetic";
#endif
  const fs::path folder =
      fs::path(testing::TempDir()) / ("thew_arm_assets_" + std::to_string(getpid()));
  fs::remove_all(folder);
  write_arm(kArm / "muscles.csv", folder);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const fs::path name = fs::relative(entry.path(), folder);
    EXPECT_TRUE(bytes(entry.path()) == bytes(kArm / name)) << name << ": run author_arm again";
    ++files;
  }
  EXPECT_EQ(files, 12 + 20 + 7);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace thew::tests
