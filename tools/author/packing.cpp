// SPDX-License-Identifier: Apache-2.0
#include "tools/author/packing.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "skin/surface/surface.h"
#include "tools/author/middle_line.h"
#include "tools/author/outline.h"
#include "tools/author/poses.h"
#include "tools/author/smoothing.h"

namespace thew::tools {
namespace {

constexpr double kCorner = 0.004;  // m, over which the edges of sections are rounded
// Passes that press the sections apart, and then those that look at the meshes between nodes.
constexpr int kPasses = 40, kSettlingPasses = 30;
constexpr double kStray = 0.008;  // m, from where the table has a centre
// Of its radius, so far a belly may reach into a neighbour's part and into a bone when bent, where
// it does not swell; more where it does: contact presses it out.
constexpr double kSqueeze = 0.15, kPressed = 0.15;
// Bellies keep within the limb's outline and so much (m) beyond, as they fill it less well than
// real ones; not from this y (m) down, where muscles that are not here fill most of it.
constexpr double kBeyond = 0.0025, kForearm = -0.28;
constexpr double kBends[] = {45.0, 90.0, 130.0};  // degrees of the elbow at which there is room too

struct Packing {
  const std::vector<TableMuscle>& table;
  const Skeleton& skeleton;
  std::vector<SectionedMuscle> muscles;
  const std::vector<BoneShape>& bones;
  std::vector<PackingPose> poses;
};

// A point in the thickness of a muscle whose room is looked for.
struct Inside {
  Near near;
  double beyond;  // m, of its slab
  double away;    // m, from where the lines are searched

  Inside(const MiddleLine& line, const Vec3& p, double away)
      : near(line.near(p, away)), beyond(slab_distance(near.slab, near.point, p)), away(away) {}
};

// Signed distance beyond the border between two muscles: each gives way to what both slabs hold in
// proportion to what it is more than tendon. Antisymmetric, so that what it parts does not overlap.
double beyond_parting(const Inside& mine, const MiddleLine& line, const Vec3& p) {
  const Near other = line.near(p, mine.away);
  const double b = slab_distance(other.slab, other.point, p);
  return (mine.beyond * other.soft - b * mine.near.soft) / (mine.near.soft + other.soft);
}

// No less than it, without a search.
double most_beyond_parting(const Inside& mine, const MiddleLine& line) {
  const double inside = -line.least_distance(mine.away);  // of the other's slab
  const double share = mine.near.soft / (mine.near.soft + line.softest());
  return std::max(mine.beyond + share * (inside - mine.beyond), inside);
}

double smooth_max(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::max(a, b) + 0.25 * k * h * h;
}

// Muscles that may be in the way of a section, and its own.
struct Neighbours {
  MiddleLine own;
  std::vector<MiddleLine> others;
};

double widest(const Section& section) {
  return 1.2 * (section.slab.half + section.grow * section.slab.radius);
}

Neighbours neighbours(const std::vector<SectionedMuscle>& muscles, size_t m, size_t i) {
  const Section& section = muscles[m].sections[i];
  Neighbours found{MiddleLine(muscles[m], section.centre), {}};
  for (size_t j = 0; j < muscles.size(); ++j) {
    if (j == m) continue;
    const MiddleLine line(muscles[j], section.centre);
    const Near near = line.near(section.centre, 0.0);
    const double reach = widest(section) + 1.2 * (near.slab.half + near.slab.radius) + 0.005;
    if ((near.point - section.centre).norm() < reach) found.others.push_back(line);
  }
  return found;
}

// Where one section must not reach, at rest and bent.
struct Room {
  const Packing& packing;
  size_t m, i;
  Vec3 place;  // the section's centre, at first
  std::vector<int> bones;
  Neighbours at_rest;
  std::vector<Neighbours> bent;

  Room(const Packing& packing, size_t m, size_t i)
      : packing(packing),
        m(m),
        i(i),
        place(packing.muscles[m].sections[i].centre),
        at_rest(neighbours(packing.muscles, m, i)) {
    const Section& section = packing.muscles[m].sections[i];
    const double reach = widest(section) + 0.02;
    for (size_t b = 0; b < packing.bones.size(); ++b) {
      if (bone_distance(packing.bones[b], section.centre) < reach) {
        bones.push_back(static_cast<int>(b));
      }
    }
    for (const PackingPose& pose : packing.poses) bent.push_back(neighbours(pose.muscles, m, i));
  }

  // The section's centre was moved, at rest alone.
  void follow_centre() { at_rest.own = MiddleLine(packing.muscles[m], place); }

  // Positive beyond the section's own size, a neighbour's or a bone's border.
  double operator()(const Vec3& p) const {
    const SectionedMuscle& mine = packing.muscles[m];
    const Section& section = mine.sections[i];
    const Slab slab = grown(section);
    double out = slab_distance(slab, section.centre, p);
    const double corner = std::min(kCorner, 0.6 * slab.radius);
    for (int b : bones) {
      const double depth = allowed_depth(mine, section.belly, b, p);
      out = smooth_max(out, kGap - depth - bone_distance(packing.bones[b], p), corner);
    }
    if (section.belly && section.centre.y() > kForearm) {
      out = smooth_max(out, limb_level(p) - kBeyond, corner);
    }
    const Inside inside(at_rest.own, p, (p - place).norm());
    for (const MiddleLine& other : at_rest.others) {
      if (most_beyond_parting(inside, other) + 0.5 * kGap < out - corner) continue;
      out = smooth_max(out, beyond_parting(inside, other, p) + 0.5 * kGap, corner);
    }
    for (size_t k = 0; k < bent.size(); ++k) {
      out = smooth_max(out, outside_bent(k, p, out - corner), corner);
    }
    return out;
  }

  // Tendons give way to nothing, and follow their path into bones. What is less than `least` does
  // not matter.
  double outside_bent(size_t k, const Vec3& p, double least) const {
    const PackingPose& pose = packing.poses[k];
    const SectionedMuscle& mine = pose.muscles[m];
    const PosedSection& section = pose.sections[m][i];
    const bool belly = mine.sections[i].belly;
    const double soft = grown(mine.sections[i]).radius;
    const Vec3 there = posed(section, p);
    double out = std::max(least * section.swell, -1.0);
    const Inside inside(bent[k].own, there, (there - mine.sections[i].centre).norm());
    const double squeeze = belly ? kSqueeze * soft : -0.5 * kGap;
    for (const MiddleLine& other : bent[k].others) {
      if (most_beyond_parting(inside, other) - squeeze < out) continue;
      out = std::max(out, beyond_parting(inside, other, there) - squeeze);
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
// slab, where borders meet at an angle; tendons nearly keep its shape.
void round_off(Section& section) {
  const size_t n = section.reach.size();
  std::vector<double> own(n), share(n);
  for (size_t k = 0; k < n; ++k) {
    own[k] = slab_reach(section.slab, section.directions[k]);
    share[k] = section.reach[k] / own[k];
  }
  for (int pass = 0; pass < 6; ++pass) {
    const std::vector<double> before = share;
    for (size_t k = 0; k < n; ++k) {
      const double mean = 0.5 * (before[(k + 1) % n] + before[(k + n - 1) % n]);
      share[k] = std::min(before[k], 0.5 * before[k] + 0.51 * mean);
    }
  }
  if (section.area <= kThin) {
    const double least = *std::min_element(share.begin(), share.end());
    for (double& s : share) s = std::min(s, 1.3 * least);
  }
  for (size_t k = 0; k < n; ++k) section.reach[k] = share[k] * own[k];
}

// The first way out along each direction.
template <typename Outside>
void cast(const Outside& out, double least, Section& section) {
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
  round_off(section);
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

// A centre stays in its plane and by its place.
void keep_in_place(Section& section) {
  const Vec3 away = section.centre - section.wanted;
  section.centre = section.wanted + std::min(1.0, kStray / std::max(away.norm(), 1e-9)) * away;
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
    keep_in_place(muscle.sections[i - 1]);
  }
}

// No ridge across the rings of the belly either: what sticks out from the rings before and after.
void round_along(SectionedMuscle& muscle) {
  constexpr double kMost = 1.3;  // of the mean of both
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
// what they lack goes to the muscle's other sections.
void press(double fill, Section& section) {
  if (!section.belly) return;
  const double pressure = std::sqrt(std::sqrt(section.area * fill / area_of(section)));
  section.grow = std::clamp(section.grow * std::clamp(pressure, 0.9, 1.1), 0.6, 1.8);
}

void relax(size_t m, Packing& packing) {
  SectionedMuscle& muscle = packing.muscles[m];
  for (size_t i = 0; i < muscle.sections.size(); ++i) {
    Section& section = muscle.sections[i];
    const Room out(packing, m, i);
    cast(out, least_reach(muscle), section);
    const double tendon = std::min(muscle.tendon_radius[0], muscle.tendon_radius[1]);
    const Vec3 push = way_in(out, section.centre, 0.7 * tendon);
    Vec3 pull = 0.3 * (section.wanted - section.centre);
    if (section.belly) pull += 0.1 * (centroid_of(section) - section.centre);
    section.centre += push + (push.squaredNorm() > 0.0 ? 0.2 : 1.0) * pull;
    keep_in_place(section);
    press(muscle.fill, section);
  }
  smooth_centres(muscle);
  for (PackingPose& pose : packing.poses) follow(muscle, m, pose);
}

// The places of the centres lie by measured bones. Those that ours contain are moved out of them.
void clear_places(const Packing& packing, SectionedMuscle& muscle) {
  constexpr int kSteps = 20;  // of 3 mm at most
  const double least = 0.7 * std::min(muscle.tendon_radius[0], muscle.tendon_radius[1]);
  for (Section& section : muscle.sections) {
    const Vec3 tangent = section.on_path.frame.col(0);
    for (int step = 0; step < kSteps; ++step) {
      for (size_t b = 0; b < packing.bones.size(); ++b) {
        const auto out = [&](const Vec3& p) {
          const double depth = allowed_depth(muscle, section.belly, static_cast<int>(b), p);
          return least - depth - bone_distance(packing.bones[b], p);
        };
        const Vec3 push = way_in(out, section.wanted, 0.0);
        section.wanted += push - tangent.dot(push) * tangent;
      }
    }
    section.centre = section.wanted;
  }
}

void settle(const std::vector<Measured>& bones, bool last, Packing& packing) {
  std::vector<Measured> measured;
  for (size_t m = 0; m < packing.muscles.size(); ++m) {
    SectionedMuscle& muscle = packing.muscles[m];
    for (size_t i = 0; i < muscle.sections.size(); ++i) {
      Section& section = muscle.sections[i];
      Room out(packing, m, i);
      // A centre that others have overrun would leave its ring no size.
      section.centre += way_in(out, section.centre, 0.5 * least_reach(muscle));
      keep_in_place(section);
      out.follow_centre();
      cast(out, 5e-4, section);
    }
    round_along(muscle);
    for (PackingPose& pose : packing.poses) follow(muscle, m, pose);
    measured.emplace_back(mesh_of(muscle));
    // What a muscle lacks it takes where nothing is in its way.
    const double lacks = std::sqrt(muscle.volume / enclosed_volume(measured.back().mesh));
    for (Section& section : muscle.sections) {
      if (!section.belly) continue;
      const double of_section = std::sqrt(std::sqrt(section.area / area_of(section)));
      section.grow *= std::clamp(of_section * lacks, 0.97, 1.04);
    }
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
  for (SectionedMuscle& muscle : packing.muscles) clear_places(packing, muscle);
  for (double bend : kBends) {
    packing.poses.push_back(make_packing_pose(table, packing.muscles, skeleton, bend * kDegree));
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    for (size_t m = 0; m < packing.muscles.size(); ++m) relax(m, packing);
    for (SectionedMuscle& muscle : packing.muscles) {
      muscle.fill = std::clamp(
          muscle.fill * std::sqrt(muscle.volume / enclosed_volume(mesh_of(muscle))), 0.8, 1.8);
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
