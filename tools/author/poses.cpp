// SPDX-License-Identifier: Apache-2.0
#include "tools/author/poses.h"

#include "muscles/carried_shape.h"
#include "muscles/weights.h"

namespace thew::tools {
namespace {

// Three more nodes for each section, of no triangle: its place on the path and two beside it, by
// which the carried shape shows where it takes the section's plane.
constexpr double kBeside = 0.01;  // m

Pose bent_pose(const Skeleton& skeleton, double elbow) {
  std::vector<double> joints(skeleton.size(), 0.0);
  joints[find_joint(skeleton, "elbow")] = elbow;
  Pose bent;
  forward_kinematics(skeleton, joints, bent);
  return bent;
}

TriMesh with_probes(const SectionedMuscle& muscle) {
  TriMesh mesh = mesh_of(muscle);
  for (const Section& section : muscle.sections) {
    const CurvePoint& path = section.on_path;
    mesh.vertices.push_back(path.point);
    for (int k = 1; k < 3; ++k) {
      mesh.vertices.push_back(path.point + kBeside * path.frame.col(k));
    }
  }
  return mesh;
}

}  // namespace

PackingPose make_packing_pose(const std::vector<TableMuscle>& table,
                              const std::vector<SectionedMuscle>& muscles, const Skeleton& skeleton,
                              double elbow) {
  const Pose rest = rest_pose(skeleton);
  const Pose bent = bent_pose(skeleton, elbow);
  const Vec3 humerus = rest[find_body(skeleton, "humerus")].translation();
  PackingPose pose;
  for (int b = 0; b < skeleton.size(); ++b) {
    const Transform bend = bent[b] * rest[b].inverse();
    pose.bend.push_back(Eigen::Translation3d(-humerus) * bend * Eigen::Translation3d(humerus));
  }
  for (size_t m = 0; m < muscles.size(); ++m) {
    const std::vector<Vec3> carried =
        carried_nodes(table[m], with_probes(muscles[m]), skeleton, elbow);
    size_t probe = carried.size() - 3 * muscles[m].sections.size();
    std::vector<PosedSection> sections;
    for (const Section& section : muscles[m].sections) {
      PosedSection out;
      out.at = section.on_path.point;
      out.point = carried[probe];
      const Vec3 u = (carried[probe + 1] - out.point) / kBeside;
      const Vec3 v = (carried[probe + 2] - out.point) / kBeside;
      Mat3 there;
      there << u.cross(v).normalized(), u, v;
      out.linear = there * section.on_path.frame.transpose();
      out.swell = 0.5 * (u.norm() + v.norm());
      sections.push_back(out);
      probe += 3;
    }
    pose.sections.push_back(sections);
    pose.muscles.push_back(muscles[m]);
    follow(muscles[m], m, pose);
  }
  return pose;
}

std::vector<Vec3> carried_nodes(const TableMuscle& muscle, TriMesh mesh, const Skeleton& skeleton,
                                double elbow) {
  const Pose rest = rest_pose(skeleton);
  const Vec3 humerus = rest[find_body(skeleton, "humerus")].translation();
  for (Vec3& p : mesh.vertices) p += humerus;
  const std::vector<double> weights =
      profile_weights(muscle.weights, belly_coordinates(mesh, muscle.path, rest, muscle.belly));
  const CarriedShape shape =
      make_carried_shape(mesh, muscle.path, rest, muscle.belly, weights, muscle.twist_from);
  Points carried;
  carried_positions(shape, carry_pose(shape, bent_pose(skeleton, elbow)), true, carried);
  for (size_t i = 0; i < carried.size(); ++i) mesh.vertices[i] = to_vec(carried[i]) - humerus;
  return mesh.vertices;
}

Vec3 posed(const PosedSection& section, const Vec3& p) {
  return section.point + section.linear * (p - section.at);
}

void follow(const SectionedMuscle& muscle, size_t m, PackingPose& pose) {
  SectionedMuscle& there = pose.muscles[m];
  there.origin = pose.bend[muscle.origin_body] * muscle.origin;
  there.insertion = pose.bend[muscle.insertion_body] * muscle.insertion;
  for (size_t i = 0; i < muscle.sections.size(); ++i) {
    const PosedSection& section = pose.sections[m][i];
    there.sections[i].centre = posed(section, muscle.sections[i].centre);
    there.sections[i].grow = section.swell * muscle.sections[i].grow;
    there.sections[i].slab.along = (section.linear * muscle.sections[i].slab.along).normalized();
  }
}

}  // namespace thew::tools
