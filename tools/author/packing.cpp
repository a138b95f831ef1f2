// SPDX-License-Identifier: Apache-2.0
#include "tools/author/packing.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "skin/surface/surface.h"
#include "tools/author/poses.h"
#include "tools/author/smoothing.h"

namespace thew::tools {
namespace {

constexpr double kCorner = 0.010;  // m, over which the edges of sections are rounded
// Passes that press the sections apart, and then those that look at the meshes between nodes.
constexpr int kPasses = 40, kSettlingPasses = 30;
// Of its radius, so far a belly may reach into a neighbour's part and into a bone when bent, where
// it does not swell; more where it does: contact presses it out.
constexpr double kSqueeze = 0.1, kPressed = 0.3;
constexpr double kBends[] = {45.0, 90.0, 130.0};  // degrees of the elbow at which there is room too

// The muscle's thickness near a point: the nearest point of the line through its sections' centres.
struct Near {
  Vec3 point = Vec3::Zero();
  double radius = 0.0, tendon = 0.0;
};

struct Packing {
  const std::vector<TableMuscle>& table;
  const Skeleton& skeleton;
  std::vector<SectionedMuscle> muscles;
  const std::vector<BoneShape>& bones;
  std::vector<PackingPose> poses;
};

Near near_of(const SectionedMuscle& muscle, const Vec3& p) {
  Near near;
  double best = 1e9;
  Vec3 a = muscle.origin;
  double ra = muscle.tendon_radius[0];
  const size_t n = muscle.sections.size();
  for (size_t i = 0; i <= n; ++i) {
    const Vec3& b = i < n ? muscle.sections[i].centre : muscle.insertion;
    const double rb = i < n ? muscle.sections[i].radius : muscle.tendon_radius[1];
    const Vec3 d = b - a;
    const double t = std::clamp(d.dot(p - a) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
    const Vec3 q = a + t * d;
    const double distance = (p - q).squaredNorm();
    if (distance < best) {
      best = distance;
      near.point = q;
      near.radius = ra + t * (rb - ra);
      near.tendon = std::min(near.radius, muscle.tendon_radius[2 * i > n]);
    }
    a = b;
    ra = rb;
  }
  return near;
}

// How far a flat section of this radius reaches along the unit direction n.
double reach_along(const SectionedMuscle& muscle, double radius, const Vec3& n) {
  const double c = n.dot(muscle.flat_along);
  return radius * std::sqrt(1.0 + (muscle.flat * muscle.flat - 1.0) * c * c);
}

// Signed distance beyond the plane that parts two muscles: where d^2 - r^2 is the same for both,
// but leaving each at least its tendon. Antisymmetric, so that what it parts does not overlap.
double beyond_parting(const SectionedMuscle& mine, const Near& a, const SectionedMuscle& other,
                      const Vec3& p) {
  const Near b = near_of(other, p);
  const Vec3 across = b.point - a.point;
  const double distance = std::max(across.norm(), 1e-4);
  const Vec3 n = across / distance;
  const double ra = reach_along(mine, a.radius, n), rb = reach_along(other, b.radius, n);
  double x = (distance * distance + ra * ra - rb * rb) / (2.0 * distance);
  const double low = a.tendon + 0.5 * kGap, high = distance - b.tendon - 0.5 * kGap;
  x = low < high ? std::clamp(x, low, high)
                 : distance * a.tendon / (a.tendon + b.tendon);  // no room for both
  return (p - a.point).dot(n) - x;
}

double smooth_max(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::max(a, b) + 0.25 * k * h * h;
}

// Muscles that may be in the way of a section.
using Neighbours = std::vector<const SectionedMuscle*>;

double widest(const SectionedMuscle& muscle, const Section& section) {
  return 1.5 * section.radius * muscle.flat;
}

Neighbours neighbours(const std::vector<SectionedMuscle>& muscles, size_t m, size_t i) {
  Neighbours found;
  const Section& section = muscles[m].sections[i];
  for (size_t j = 0; j < muscles.size(); ++j) {
    if (j == m) continue;
    const Near near = near_of(muscles[j], section.centre);
    const double reach = widest(muscles[m], section) + 1.5 * near.radius * muscles[j].flat + 0.005;
    if ((near.point - section.centre).norm() < reach) found.push_back(&muscles[j]);
  }
  return found;
}

// Where one section must not reach, at rest and bent.
struct Room {
  const Packing& packing;
  size_t m, i;
  std::vector<int> bones;
  Neighbours at_rest;
  std::vector<Neighbours> bent;

  Room(const Packing& packing, size_t m, size_t i) : packing(packing), m(m), i(i) {
    const Section& section = packing.muscles[m].sections[i];
    const double reach = widest(packing.muscles[m], section) + 0.02;
    for (size_t b = 0; b < packing.bones.size(); ++b) {
      if (bone_distance(packing.bones[b], section.centre) < reach) {
        bones.push_back(static_cast<int>(b));
      }
    }
    at_rest = neighbours(packing.muscles, m, i);
    for (const PackingPose& pose : packing.poses) bent.push_back(neighbours(pose.muscles, m, i));
  }

  // Positive beyond the section's own size, a neighbour's or a bone's border.
  double operator()(const Vec3& p) const {
    const SectionedMuscle& mine = packing.muscles[m];
    const Section& section = mine.sections[i];
    const Vec3 v = p - section.centre;
    const double along = v.dot(mine.flat_along);
    const double flat2 = mine.flat * mine.flat;
    double out = std::sqrt(std::max(v.squaredNorm() - (1.0 - 1.0 / flat2) * along * along, 0.0)) -
                 section.radius;
    const double corner = std::min(kCorner, 0.6 * section.radius);
    for (int b : bones) {
      const double depth = allowed_depth(mine, section.belly, b, p);
      out = smooth_max(out, kGap - depth - bone_distance(packing.bones[b], p), corner);
    }
    const Near near = near_of(mine, p);
    for (const SectionedMuscle* other : at_rest) {
      out = smooth_max(out, beyond_parting(mine, near, *other, p) + 0.5 * kGap, corner);
    }
    for (size_t k = 0; k < bent.size(); ++k) {
      out = smooth_max(out, outside_bent(k, p), corner);
    }
    return out;
  }

  // Tendons give way to nothing, and follow their path into bones.
  double outside_bent(size_t k, const Vec3& p) const {
    const PackingPose& pose = packing.poses[k];
    const SectionedMuscle& mine = pose.muscles[m];
    const PosedSection& section = pose.sections[m][i];
    const bool belly = mine.sections[i].belly;
    const double soft = section.swell * mine.sections[i].radius;
    const Vec3 there = posed(section, p);
    double out = -1.0;
    const Near near = near_of(mine, there);
    const double squeeze = belly ? kSqueeze * soft : -0.5 * kGap;
    for (const SectionedMuscle* other : bent[k]) {
      out = std::max(out, beyond_parting(mine, near, *other, there) - squeeze);
    }
    for (int b : bones) {
      if (!belly) break;
      const Vec3 at_bone = pose.bend[b].inverse() * there;
      out = std::max(out, kGap - kPressed * soft - bone_distance(packing.bones[b], at_bone));
    }
    return out / section.swell;
  }
};

constexpr double kThin = 6e-5;  // m^2: sections of tendon

// Rounds off what sticks out from its neighbours round the ring, measured by the section's own
// ellipse, where borders meet at an angle; tendons are nearly round.
void round_off(const SectionedMuscle& muscle, Section& section) {
  const size_t n = section.reach.size();
  std::vector<double> own(n), share(n);
  for (size_t k = 0; k < n; ++k) {
    const double c = section.directions[k].dot(muscle.flat_along);
    own[k] = 1.0 / std::sqrt(1.0 - (1.0 - 1.0 / (muscle.flat * muscle.flat)) * c * c);
    share[k] = section.reach[k] / own[k];
  }
  for (int pass = 0; pass < 6; ++pass) {
    const std::vector<double> before = share;
    for (size_t k = 0; k < n; ++k) {
      const double mean = 0.5 * (before[(k + 1) % n] + before[(k + n - 1) % n]);
      share[k] = std::min(before[k], 1.08 * mean);
    }
  }
  for (size_t k = 0; k < n; ++k) section.reach[k] = share[k] * own[k];
  if (section.area > kThin) return;
  const double least = *std::min_element(section.reach.begin(), section.reach.end());
  for (double& reach : section.reach) reach = std::min(reach, 1.3 * least);
}

// The first way out along each direction.
template <typename Outside>
void cast(const Outside& out, const SectionedMuscle& muscle, double least, Section& section) {
  for (size_t k = 0; k < section.reach.size(); ++k) {
    const Vec3& d = section.directions[k];
    double inside = 0.0, t = 0.0, value = out(section.centre);
    while (value < 0.0 && t < 0.08) {
      inside = t;
      t += std::max(-0.8 * value, 2e-4);
      value = out(section.centre + t * d);
    }
    for (int i = 0; i < 14; ++i) {
      const double middle = 0.5 * (inside + t);
      (out(section.centre + middle * d) < 0.0 ? inside : t) = middle;
    }
    section.reach[k] = std::max(std::min(inside, section.limit[k]), least);
  }
  round_off(muscle, section);
}

// Out of what is in the way, by the slope of `out`.
template <typename Outside>
Vec3 way_in(const Outside& out, const Vec3& p, double depth) {
  constexpr double kStep = 2e-4;  // m, of the differences
  const double value = out(p) + depth;
  if (value <= 0.0) return Vec3::Zero();
  Vec3 g;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = kStep * Vec3::Unit(k);
    g[k] = (out(p + d) - out(p - d)) / (2.0 * kStep);
  }
  return -std::min(value, 0.003) * g / std::max(g.norm(), 0.3);
}

void keep_in_plane(Section& section) {
  const Vec3 tangent = section.on_path.frame.col(0);
  section.centre -= tangent.dot(section.centre - section.on_path.point) * tangent;
}

void smooth_centres(SectionedMuscle& muscle) {
  const size_t n = muscle.sections.size();
  std::vector<Vec3> off(n + 2, Vec3::Zero()), path(n + 2, muscle.origin);
  path.back() = muscle.insertion;
  for (size_t i = 0; i < n; ++i) {
    path[i + 1] = muscle.sections[i].on_path.point;
    off[i + 1] = muscle.sections[i].centre - path[i + 1];
  }
  for (size_t i = 1; i <= n; ++i) {
    const double before = (path[i] - path[i - 1]).norm(), after = (path[i + 1] - path[i]).norm();
    const Vec3 between = (after * off[i - 1] + before * off[i + 1]) / (before + after);
    muscle.sections[i - 1].centre = path[i] + 0.6 * off[i] + 0.4 * between;
    keep_in_plane(muscle.sections[i - 1]);
  }
}

// No ridge across the rings of the belly either: what sticks out from the rings before and after.
void round_along(SectionedMuscle& muscle) {
  constexpr double kMost = 1.15;  // of the mean of both
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<Section> was = muscle.sections;
    for (size_t i = 1; i + 1 < was.size(); ++i) {
      if (!was[i].belly) continue;
      for (size_t k = 0; k < was[i].reach.size(); ++k) {
        const double mean = 0.5 * (was[i - 1].reach[k] + was[i + 1].reach[k]);
        double& reach = muscle.sections[i].reach[k];
        reach = std::min(reach, kMost * mean);
      }
    }
  }
}

double least_reach(const SectionedMuscle& muscle) {
  return 0.4 * std::min(muscle.tendon_radius[0], muscle.tendon_radius[1]);
}

// Sections that have too little room press harder, yet not so hard that a neighbour loses its own:
// what they lack goes to the muscle's other sections. `give`: most change of the radius in a pass.
void press(double give, const SectionedMuscle& muscle, Section& section) {
  if (!section.belly) return;
  const double area = section.area * muscle.fill;
  const double even = std::sqrt(area / (kPi * muscle.flat));
  const double pressure = std::sqrt(std::sqrt(area / area_of(section)));
  section.radius = std::clamp(section.radius * std::clamp(pressure, 1.0 - give, 1.0 + give),
                              0.6 * even, 1.4 * even);
}

void relax(size_t m, Packing& packing) {
  SectionedMuscle& muscle = packing.muscles[m];
  for (size_t i = 0; i < muscle.sections.size(); ++i) {
    Section& section = muscle.sections[i];
    const Room out(packing, m, i);
    cast(out, muscle, least_reach(muscle), section);
    const double tendon = std::min(muscle.tendon_radius[0], muscle.tendon_radius[1]);
    const Vec3 push = way_in(out, section.centre, 0.7 * tendon);
    Vec3 pull = 0.3 * (section.wanted - section.centre);
    if (section.belly) pull += 0.1 * (centroid_of(section) - section.centre);
    section.centre += push + (push.squaredNorm() > 0.0 ? 0.2 : 1.0) * pull;
    keep_in_plane(section);
    press(0.1, muscle, section);
  }
  smooth_centres(muscle);
  for (PackingPose& pose : packing.poses) follow(muscle, m, pose);
}

void settle(const std::vector<Measured>& bones, bool last, Packing& packing) {
  std::vector<Measured> measured;
  for (size_t m = 0; m < packing.muscles.size(); ++m) {
    SectionedMuscle& muscle = packing.muscles[m];
    for (size_t i = 0; i < muscle.sections.size(); ++i) {
      Section& section = muscle.sections[i];
      const Room out(packing, m, i);
      // A centre that others have overrun would leave its ring no size.
      section.centre += way_in(out, section.centre, 0.5 * least_reach(muscle));
      keep_in_plane(section);
      cast(out, muscle, 5e-4, section);
      if (!last) press(0.03, muscle, muscle.sections[i]);
    }
    round_along(muscle);
    for (PackingPose& pose : packing.poses) follow(muscle, m, pose);
    measured.emplace_back(mesh_of(muscle));
    muscle.fill *= std::sqrt(muscle.volume / enclosed_volume(measured.back().mesh));
  }
  if (last) return;
  for (size_t m = 0; m < measured.size(); ++m) {
    const std::vector<Vec3>& nodes = measured[m].mesh.vertices;
    blunt(measured[m], nodes, packing.muscles[m]);
    for (const double bend : kBends) {
      blunt(measured[m],
            carried_nodes(packing.table[m], measured[m].mesh, packing.skeleton, bend * kDegree),
            packing.muscles[m]);
    }
    for (size_t j = 0; j < measured.size(); ++j) {
      if (j != m) draw_back(measured[j], false, -1, measured[m], packing.muscles[m]);
    }
    for (size_t b = 0; b < bones.size(); ++b) {
      draw_back(bones[b], true, static_cast<int>(b), measured[m], packing.muscles[m]);
    }
  }
}

}  // namespace

std::vector<TriMesh> pack_muscles(const std::vector<TableMuscle>& table, const Skeleton& skeleton,
                                  const std::vector<BoneShape>& bones) {
  const Pose rest = rest_pose(skeleton);
  const Vec3 humerus = rest[find_body(skeleton, "humerus")].translation();
  Packing packing{table, skeleton, {}, bones, {}};
  for (const TableMuscle& muscle : table) {
    packing.muscles.push_back(make_sections(muscle, rest, humerus));
  }
  for (double bend : kBends) {
    packing.poses.push_back(make_packing_pose(table, packing.muscles, skeleton, bend * kDegree));
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    for (size_t m = 0; m < packing.muscles.size(); ++m) relax(m, packing);
    for (SectionedMuscle& muscle : packing.muscles) {
      for (Section& section : muscle.sections) even_out(section);
    }
  }
  std::vector<Measured> measured;
  for (const BoneShape& bone : bones) measured.emplace_back(bone_mesh(bone));
  for (int pass = 0; pass <= kSettlingPasses; ++pass) {
    settle(measured, pass == kSettlingPasses, packing);
  }
  std::vector<TriMesh> meshes;
  for (const SectionedMuscle& muscle : packing.muscles) {
    meshes.push_back(exact_mesh_of(muscle));
  }
  return meshes;
}

}  // namespace thew::tools
