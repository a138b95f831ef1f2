// SPDX-License-Identifier: Apache-2.0
//
// How thick the character's arm is, section by section and direction by direction, over the
// template's: so that what lies under the template's skin lies under the character's.
#include <algorithm>
#include <cmath>
#include <limits>

#include "rig/math.h"
#include "tools/new_arm.h"

namespace thew {
namespace {

constexpr double kRow = 0.01;         // m of the template, from section to section
constexpr int kAround = 24;           // directions
constexpr double kBeyondHand = 0.05;  // m past the wrist, the last section
constexpr double kUnderTop = 0.04;    // m below the shoulder's centre, the first: above is its cap
constexpr double kFat = 0.002;        // m, left over the flesh, if the limb's thickness allows ...
constexpr double kFatShare = 0.1;     // ... of the skin's distance from the axis
constexpr double kJoint = 0.08;       // of a segment's length, where the axis stays on the joint
// Of a segment's length, from the elbow to where the axis lies all in the middle of the flesh: in
// less the forearm's bones are kinked into what lies before them in a bent arm.
constexpr double kFromElbow = 0.35;
constexpr double kBeside = 0.05;  // m, how far from the flesh a bone is looked for
constexpr double kWidest = 1.5;   // a direction over its section's median
// The ratio's logarithm grows by no more than this: a short thin place stays thin.
constexpr double kSteepest = 12.0;       // a metre of the template, along
constexpr double kSteepestAround = 0.9;  // a radian, around

// A closed surface, or several that overlap, to be looked at along rays from within.
class Shell {
 public:
  explicit Shell(const TriMesh& mesh) : x_(mesh.vertices), triangles_(mesh.triangles) {
    for (const Triangle& t : triangles_) {
      const Vec3 middle = (x_[t[0]] + x_[t[1]] + x_[t[2]]) / 3.0;
      double reach = 0.0;
      for (const int i : t) reach = std::max(reach, (x_[i] - middle).squaredNorm());
      balls_.push_back({middle, 1.001 * reach});
    }
  }
  // m, where a ray leaves the last of the surfaces it began in; -1 where it began in none.
  double way_out(const Vec3& from, const Vec3& to) const;

 private:
  struct Ball {  // around a triangle, so that most of them cost little
    Vec3 middle;
    double reach_squared;
  };
  const std::vector<Vec3>& x_;
  const std::vector<Triangle>& triangles_;
  std::vector<Ball> balls_;
};

// Whether the axis passes left of the edge: of the two triangles at an edge one says yes.
bool left_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x() > 0.0;
}

double Shell::way_out(const Vec3& from, const Vec3& to) const {
  const Vec3 across = to.unitOrthogonal(), over = to.cross(across);
  struct Hit {
    double at;
    int out;  // +1 leaves, -1 enters
  };
  std::vector<Hit> hits;
  int inside = 0;
  for (size_t i = 0; i < triangles_.size(); ++i) {
    const Vec3 off = balls_[i].middle - from;
    const double ahead = to.dot(off);
    if (off.squaredNorm() - ahead * ahead > balls_[i].reach_squared) continue;
    const Triangle& t = triangles_[i];
    Eigen::Vector2d p[3];
    double depth[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = x_[t[k]] - from;
      p[k] = {across.dot(d), over.dot(d)};
      depth[k] = to.dot(d);
    }
    bool left[3];
    for (int k = 0; k < 3; ++k) {
      const int m = (k + 1) % 3;
      left[k] = t[k] < t[m] ? left_of(p[k], p[m]) : !left_of(p[m], p[k]);
    }
    if (left[0] != left[1] || left[1] != left[2]) continue;
    double share[3], sum = 0.0, at = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
      share[k] = a.x() * b.y() - a.y() * b.x();
      sum += share[k];
    }
    for (int k = 0; k < 3; ++k) at += sum == 0.0 ? depth[k] / 3.0 : share[k] / sum * depth[k];
    if (at <= 0.0) continue;
    hits.push_back({at, left[0] ? 1 : -1});
    inside += hits.back().out;
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.at < b.at; });
  for (const Hit& hit : hits) {
    if (inside <= 0) return -1.0;
    inside -= hit.out;
    if (inside <= 0) return hit.at;
  }
  return -1.0;
}

double direction_of(int k) { return 2.0 * kPi * k / kAround; }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double between_joints(double from_elbow) {  // none at either joint
  return smoothstep(0.0, kFromElbow, from_elbow) *
         smoothstep(kJoint, 2.0 * kJoint, 1.0 - from_elbow);
}

// The middle of a shell's section and its radius there; in the plane of two vectors.
struct Middle {
  bool found = false;
  Vec3 place = Vec3::Zero();
  double radius = 0.0;
};

Middle middle_near(const Shell& shell, const Vec3& start, const Vec3& a, const Vec3& b,
                   double reach) {
  Middle middle{false, start, 0.0};
  const auto is_within = [&](const Vec3& p) { return shell.way_out(p, a) > 0.0; };
  const auto around = [&](int k) -> Vec3 {
    const SinCos turn = sin_cos(direction_of(k));
    return turn.cos * a + turn.sin * b;
  };
  // A joint may lie outside: from the first place within, in growing circles.
  middle.found = is_within(start);
  for (int ring = 1; ring <= 8 && !middle.found; ++ring) {
    for (int k = 0; k < kAround && !middle.found; k += 2) {
      middle.place = start + ring / 8.0 * reach * around(k);
      middle.found = is_within(middle.place);
    }
  }
  // Of a disk the mean of the ways out leads half the way to its middle.
  for (int pass = 0; pass < 6 && middle.found; ++pass) {
    std::vector<double> ways;
    for (int k = 0; k < kAround; ++k) ways.push_back(shell.way_out(middle.place, around(k)));
    middle.radius = median(ways);
    if (middle.radius <= 0.0) return {};
    Vec3 mean = Vec3::Zero();
    for (int k = 0; k < kAround; ++k) {
      const double way = ways[k] < 0.0 ? middle.radius : ways[k];
      mean += std::min(way, kWidest * middle.radius) / kAround * around(k);
    }
    middle.place += 2.0 * mean;
    middle.found = is_within(middle.place);
  }
  return middle;
}

// A character's bones may run anywhere within its flesh, or beside it. Between its joints the
// template's axis is laid where it would be by its place in the template's flesh.
void find_shift(const ArmTemplate& from, const TriMesh& skin, ArmFit& fit) {
  const Shell theirs(skin), ours(from.skin);
  GirthField& girth = fit.girth;
  std::vector<Vec3> shift(girth.rows, Vec3::Zero());
  std::vector<char> known(girth.rows, 0);
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow;
    const Mat3 linear = linear_at(fit, y);
    const Vec3 axis = axis_point(fit, y), mapped = map_point(fit, axis);
    const Vec3 a = linear.col(0).normalized();
    const Vec3 b = (linear.col(2) - a.dot(linear.col(2)) * a).normalized();
    const Middle mine = middle_near(ours, axis, Vec3::UnitX(), Vec3::UnitZ(), 0.0);
    const Middle other = middle_near(theirs, mapped, a, b, kBeside);
    known[row] = mine.found && other.found;
    if (!known[row]) continue;
    shift[row] = other.place - mapped - other.radius / mine.radius * (linear * (mine.place - axis));
  }
  girth.shift.assign(girth.rows, Vec3::Zero());
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow, elbow = fit.elbow_template.y();
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (int other = std::max(row - 2, 0); other <= std::min(row + 2, girth.rows - 1); ++other) {
      if (known[other]) sum += shift[other], ++count;
    }
    const double share = y > elbow ? between_joints(1.0 - y / elbow)
                                   : between_joints((y - elbow) / (fit.wrist_template.y() - elbow));
    if (count > 0) girth.shift[row] = share / count * sum;
  }
}

// The skin's distance over the template's, where both are known, else -1.
void measure(const ArmFit& fit, const ArmTemplate& from, const TriMesh& skin, GirthField& girth) {
  const Shell theirs(skin), ours(from.skin);
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow;
    const Vec3 axis = axis_point(fit, y);
    std::vector<double> known;
    for (int k = 0; k < kAround; ++k) {
      const SinCos turn = sin_cos(direction_of(k));
      const Vec3 out(turn.cos, 0.0, turn.sin), mapped = linear_at(fit, y) * out;
      const double in_template = ours.way_out(axis, out);
      const double here = theirs.way_out(map_point(fit, axis), mapped.normalized());
      const double ratio =
          in_template > 0.0 && here > 0.0 ? here / mapped.norm() / in_template : -1.0;
      girth.at(row, k) = ratio;
      if (ratio > 0.0) known.push_back(ratio);
    }
    if (known.size() < kAround / 4) known.clear();
    const double middle = known.empty() ? -1.0 : median(known);
    for (int k = 0; k < kAround; ++k) {
      double& ratio = girth.at(row, k);
      ratio = middle < 0.0 || ratio < 0.0 ? middle : std::min(ratio, kWidest * middle);
    }
  }
}

// A section of which the skin tells nothing is as the nearest that it tells of.
void fill_rows(GirthField& girth) {
  const std::vector<double> known = girth.ratio;
  for (int row = 0; row < girth.rows; ++row) {
    for (int away = 0; away < girth.rows && girth.at(row, 0) < 0.0; ++away) {
      for (const int other : {row - away, row + away}) {
        if (other < 0 || other >= girth.rows || known[other * kAround] < 0.0) continue;
        for (int k = 0; k < kAround; ++k) girth.at(row, k) = known[other * kAround + k];
        break;
      }
    }
  }
}

// The largest field below this one that grows nowhere faster than it may.
void make_gentle(GirthField& girth) {
  const std::vector<double> bound = girth.ratio;
  for (int row = 0; row < girth.rows; ++row) {
    for (int k = 0; k < kAround; ++k) {
      double least = girth.at(row, k);
      for (int other = 0; other < girth.rows; ++other) {
        for (int m = 0; m < kAround; ++m) {
          const int turn = std::min((k - m + kAround) % kAround, (m - k + kAround) % kAround);
          const double grown =
              kSteepest * kRow * std::abs(row - other) + kSteepestAround * direction_of(turn);
          least = std::min(least, bound[other * kAround + m] * std::exp(grown));
        }
      }
      girth.at(row, k) = least;
    }
  }
}

void smooth(GirthField& girth) {
  for (int pass = 0; pass < 4; ++pass) {
    const std::vector<double> before = girth.ratio;
    for (int row = 0; row < girth.rows; ++row) {
      const int above = std::max(row - 1, 0), below = std::min(row + 1, girth.rows - 1);
      for (int k = 0; k < kAround; ++k) {
        const double mean = 0.25 * (before[above * kAround + k] + before[below * kAround + k] +
                                    before[row * kAround + (k + 1) % kAround] +
                                    before[row * kAround + (k + kAround - 1) % kAround]);
        double& ratio = girth.at(row, k);
        ratio = std::min(ratio, 0.5 * (before[row * kAround + k] + mean));
      }
    }
  }
}

}  // namespace

double& GirthField::at(int row, int k) { return ratio[row * kAround + k]; }

std::array<GirthField::Share, 4> GirthField::shares(double y, double angle) const {
  const double row = std::clamp((top - y) / kRow, 0.0, rows - 1.0);
  const double turn = (angle < 0.0 ? angle + 2.0 * kPi : angle) / (2.0 * kPi) * kAround;
  const int i = std::min(static_cast<int>(row), rows - 2), k = static_cast<int>(turn) % kAround;
  const double u = row - i, v = turn - static_cast<int>(turn);
  const int next = (k + 1) % kAround;
  return {{{i * kAround + k, (1.0 - u) * (1.0 - v)},
           {i * kAround + next, (1.0 - u) * v},
           {(i + 1) * kAround + k, u * (1.0 - v)},
           {(i + 1) * kAround + next, u * v}}};
}

double GirthField::value(double y, double angle) const {
  if (ratio.empty()) return even;
  double sum = 0.0;
  for (const Share& share : shares(y, angle)) sum += share.share * ratio[share.node];
  return sum;
}

Vec3 GirthField::shift_at(double y) const {
  if (shift.empty()) return Vec3::Zero();
  const double row = std::clamp((top - y) / kRow, 0.0, rows - 1.0);
  const int i = std::min(static_cast<int>(row), rows - 2);
  return (1.0 - (row - i)) * shift[i] + (row - i) * shift[i + 1];
}

double GirthField::mean(double from, double to) const {
  if (ratio.empty()) return even;
  double sum = 0.0;
  int count = 0;
  for (int row = 0; row < rows; ++row) {
    const double y = top - row * kRow;
    if (y > from || y < to) continue;
    for (int k = 0; k < kAround; ++k, ++count) sum += ratio[row * kAround + k];
  }
  return count > 0 ? sum / count : value(0.5 * (from + to), 0.0);
}

void fit_girth(const ArmTemplate& from, const TriMesh& skin, ArmFit& fit) {
  fit.girth = {};  // while it is measured, across is as in the template
  fit.girth.top = -kUnderTop;
  fit.girth.rows = static_cast<int>((kBeyondHand - kUnderTop - from.wrist.y()) / kRow) + 1;
  find_shift(from, skin, fit);
  GirthField girth = fit.girth;
  girth.ratio.assign(static_cast<size_t>(girth.rows) * kAround, -1.0);
  measure(fit, from, skin, girth);
  fill_rows(girth);
  if (girth.ratio[0] < 0.0) {  // no skin around the arm
    fit.girth = {};
    fit.girth.even = fit.along_upper;
    return;
  }
  // Of flesh beyond the sections too.
  const Shell shell(skin);
  for (const Vec3& p : from.flesh) {
    const Vec3 axis = axis_point(fit, p.y()), d = p - axis, mapped = linear_at(fit, p.y()) * d;
    const double reach = mapped.norm();
    if (reach < 1e-4) continue;
    const double out = shell.way_out(map_point(fit, axis), mapped / reach);
    if (out < 0.0) continue;
    const double most = (out - std::min(kFat, kFatShare * out)) / reach;
    for (const GirthField::Share& share : girth.shares(p.y(), arc_tan2(d.z(), d.x()))) {
      girth.ratio[share.node] = std::min(girth.ratio[share.node], most);
    }
  }
  make_gentle(girth);
  smooth(girth);
  make_gentle(girth);
  fit.girth = girth;
}

double least_fat(const ArmFit& fit, const TriMesh& skin, const std::vector<Vec3>& points) {
  const Shell shell(skin);
  double least = std::numeric_limits<double>::max();
  for (const Vec3& p : points) {
    const Vec3 axis = map_point(fit, axis_point(fit, p.y())), d = map_point(fit, p) - axis;
    const double reach = d.norm();
    if (reach < 1e-4) continue;
    const double out = shell.way_out(axis, d / reach);
    least = std::min(least, out < 0.0 ? -reach : out - reach);
  }
  return least;
}

Rows skin_in_pose(const Character& character, const Pose& pose) {
  std::vector<Affine> world;
  for (int b = 0; b < character.skeleton.size(); ++b) {
    world.push_back(pose[b] * (rigid_part(character.bind[b]).inverse() * character.bind[b]));
  }
  Rows x;
  skin_vertices(character.skin, character.mesh, world, x);
  return x;
}

TriMesh skin_at_rest(const Character& character, const Pose& rest) {
  const Rows x = skin_in_pose(character, rest);
  WeldResult welded = weld(character.mesh);
  for (size_t i = x.size(); i-- > 0;) welded.mesh.vertices[welded.map_back[i]] = to_vec(x[i]);
  if (enclosed_volume(welded.mesh) < 0.0) {  // inside out
    for (Triangle& t : welded.mesh.triangles) std::swap(t[1], t[2]);
  }
  return std::move(welded.mesh);
}

}  // namespace thew
