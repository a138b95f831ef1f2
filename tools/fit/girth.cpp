// SPDX-License-Identifier: Apache-2.0
//
// How thick the character's arm is, section by section and direction by direction, over the
// template's: so that what lies under the template's skin lies under the character's.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "rig/math.h"
#include "tools/base/median.h"
#include "tools/fit/limb.h"

namespace thew::tools {
namespace {

constexpr double kRow = GirthField::kRow;
constexpr int kAround = GirthField::kAround;
constexpr double kBeyondHand = 0.05;  // m past the wrist, the last section
constexpr double kUnderTop = 0.04;    // m below the shoulder's centre, the first: above is its cap
constexpr double kFat = 0.002;  // m of an arm of the template's length, left over the flesh, if the
                                // limb's thickness allows ...
constexpr double kFatShare = 0.1;  // ... of the skin's distance from the axis
constexpr double kJoint = 0.08;    // of a segment's length, where the axis stays on the joint
// Of a segment's length, from the elbow to where the axis lies all in the middle of the flesh: in
// less the forearm's bones are kinked into what lies before them in a bent arm.
constexpr double kFromElbow = 0.35;
// ... and from the shoulder: beside its joint a humerus' head turns into what it meets.
constexpr double kFromShoulder = 0.35;
// Of a section's radius: nearer to its edge the axis tells nothing of it ...
constexpr double kInside = 0.25;
constexpr double kWell = 0.4;    // ... and farther in than this there is room behind an elbow
constexpr double kSame = 1e-4;   // m, of two distances to one surface
constexpr double kReach = 0.45;  // of a segment's length: what is farther from its bone is no limb
constexpr double kWidest = 1.5;  // a direction over its section's median
constexpr double kTrunk = 1.8;   // ... beyond which a section's outline is the trunk's
constexpr int kNear = 3;         // sections to either side ...
constexpr int kBeside = 2;       // ... and directions, the median of which is usual
// Of the skin's distance around, below which a ray has met an inner wall through a hole.
constexpr double kHole = 0.75;
constexpr double kPieceEnd = 0.5;  // ... or has left a closed piece through its end
// ... of a section's outline, which may be flat beside the template's.
constexpr double kInnerWall = 0.6;
constexpr double kStrap = 1.3;                 // ... above which it has met what the limb wears
constexpr int kJointAround = kAround * 3 / 4;  // directions in which a joint is narrower
// The ratio's logarithm grows by no more than this: a short thin place stays thin.
constexpr double kSteepest = 12.0;       // a metre of the template, along
constexpr double kSteepestAround = 0.9;  // a radian, around

double direction_of(int k) { return 2.0 * kPi * k / kAround; }

double between_joints(double from_elbow, bool upper) {  // none at either joint
  return smoothstep(0.0, kFromElbow, from_elbow) *
         smoothstep(kJoint, upper ? kFromShoulder : 2.0 * kJoint, 1.0 - from_elbow);
}

// The least share of a shift into the middle of a section that brings a point well within it.
double share_to_lie_within(const Limb::Section& section, const Vec3& p, const Vec3& shift) {
  const auto is_well_within = [&](double share) {
    return section.within(p + share * shift) > kWell * section.radius;
  };
  if (is_well_within(0.0)) return 0.0;
  double least = 0.0, most = 1.0;  // the outline is convex: there is one such place
  for (int k = 0; k < 20; ++k) {
    const double half = 0.5 * (least + most);
    (is_well_within(half) ? most : least) = half;
  }
  return most;
}

// Unit, at right angles, in the plane of the mapped section.
std::array<Vec3, 2> plane_of(const Mat3& linear) {
  const Vec3 a = linear.col(0).normalized();
  return {a, (linear.col(2) - a.dot(linear.col(2)) * a).normalized()};
}

// m, in the template and in the character.
std::array<double, 2> reach_at(const ArmFit& fit, double y) {
  const bool upper = y > fit.elbow_template.y();
  const double own =
      kReach * (upper ? fit.elbow_template : Vec3(fit.wrist_template - fit.elbow_template)).norm();
  return {own, own * (upper ? fit.along_upper : fit.along_fore)};
}

// A character's bones may run anywhere within its flesh, or beside it. Between its joints the
// template's axis is laid where it would be by its place in the template's flesh; at an elbow that
// lies in its own skin, so far that there is room behind it.
void find_shift(const ArmTemplate& from, const Limb& theirs, ArmFit& fit) {
  const Limb ours(from.skin);
  GirthField& girth = fit.girth;
  std::vector<std::optional<Vec3>> known(girth.rows);
  std::vector<double> share(girth.rows);
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow, elbow = fit.elbow_template.y();
    const double from_elbow =
        y > elbow ? 1.0 - y / elbow : (y - elbow) / (fit.wrist_template.y() - elbow);
    share[row] = between_joints(from_elbow, y > elbow);
    const Mat3 linear = linear_at(fit, y);
    const Vec3 axis = axis_point(fit, y), mapped = map_point(fit, axis);
    const auto [a, b] = plane_of(linear);
    const auto [own_reach, reach] = reach_at(fit, y);
    const Limb::Section mine = ours.section(axis, Vec3::UnitX(), Vec3::UnitZ(), own_reach, kTrunk);
    const Limb::Section other = theirs.section(mapped, a, b, reach, kTrunk);
    if (mine.radius <= 0.0 || other.radius <= 0.0) continue;
    known[row] = other.middle - mapped -
                 other.radius / (mine.radius * fit.across) * (linear * (mine.middle - axis));
    if (from_elbow < kFromElbow) {
      share[row] = std::max(share[row], share_to_lie_within(other, mapped, *known[row]));
    }
  }
  girth.shift.assign(girth.rows, Vec3::Zero());
  for (int row = 0; row < girth.rows; ++row) {
    for (int k = 0; k < 3; ++k) {  // a piece that stands out moves no median
      std::vector<double> near;
      for (int other = std::max(row - kNear, 0); other <= std::min(row + kNear, girth.rows - 1);
           ++other) {
        if (known[other]) near.push_back((*known[other])[k]);
      }
      if (!near.empty()) girth.shift[row][k] = share[row] * median(near);
    }
  }
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<Vec3> before = girth.shift;
    for (int row = 1; row + 1 < girth.rows; ++row) {
      girth.shift[row] = 0.25 * (before[row - 1] + before[row + 1]) + 0.5 * before[row];
    }
  }
}

// m, from the axis to the template's own skin.
std::vector<double> own_skin(const ArmFit& fit, const ArmTemplate& from, int rows, double top) {
  const Limb ours(from.skin);
  std::vector<double> own(static_cast<size_t>(rows) * kAround, 0.0);
  for (int row = 0; row < rows; ++row) {
    const double y = top - row * kRow;
    for (int k = 0; k < kAround; ++k) {
      const SinCos turn = sin_cos(direction_of(k));
      own[row * kAround + k] = std::max(
          0.0,
          ours.outermost(axis_point(fit, y), Vec3(turn.cos, 0.0, turn.sin), reach_at(fit, y)[0]));
    }
  }
  return own;
}

// The skin's distance over the template's, section by section; -1 all around where the axis is not
// well within it.
void measure(const ArmFit& fit, const Limb& theirs, const Limb& body,
             const std::vector<double>& own, GirthField& girth) {
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow;
    const Mat3 linear = linear_at(fit, y);
    const Vec3 axis = map_point(fit, axis_point(fit, y));
    const auto [a, b] = plane_of(linear);
    const double reach = reach_at(fit, y)[1];
    std::vector<double> known;
    std::array<bool, kAround> by_trunk{};  // the way out is through the trunk
    const Limb::Section section = theirs.section(axis, a, b, reach);
    const bool within = body.closed() || section.within(axis) > kInside * section.radius;
    for (int k = 0; k < kAround; ++k) {
      const SinCos turn = sin_cos(direction_of(k));
      const Vec3 mapped = linear * Vec3(turn.cos, 0.0, turn.sin);
      const double in_template = own[row * kAround + k];
      const Vec3 to = mapped.normalized();
      const double here = body.closed() ? body.way_out(axis, to)
                          : within      ? theirs.outermost(axis, to, reach)
                                        : -1.0;
      const double ratio =
          in_template > 0.0 && here > 0.0 ? here / mapped.norm() / in_template : -1.0;
      girth.at(row, k) = ratio;
      if (ratio < 0.0) continue;
      known.push_back(ratio);
      by_trunk[k] = body.closed() && theirs.outermost(axis, to, here + kSame) < here - kSame;
    }
    if (known.size() < kAround / 4) known.clear();
    const double middle = known.empty() ? -1.0 : median(known);
    // The trunk's skin says of the limb only that there is room; its length tells more.
    const double by_length =
        (y > fit.elbow_template.y() ? fit.along_upper : fit.along_fore) / fit.across;
    for (int k = 0; k < kAround; ++k) {
      double& ratio = girth.at(row, k);
      const double most = kWidest * (by_trunk[k] ? std::min(by_length, middle) : middle);
      ratio = middle < 0.0 || ratio < 0.0 ? middle : std::min(ratio, most);
    }
  }
}

// Of the sections from one y down to another, those that the skin tells of.
double share_told(GirthField& girth, double from, double to) {
  int told = 0, all = 0;
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow;
    if (y > from || y < to) continue;
    told += girth.at(row, 0) > 0.0, ++all;
  }
  return all > 0 ? static_cast<double>(told) / all : 0.0;
}

// A hole shows an inner wall, a strap stands out, a corner whose weights are wrong leads inwards:
// what differs so much from the median around it is that instead. A whole section that is narrower
// is a joint. What stands out of a closed body is its own.
void mend_outliers(GirthField& girth, bool closed) {
  const std::vector<double> known = girth.ratio;
  for (int row = 0; row < girth.rows; ++row) {
    std::array<double, kAround> usual{};
    int low = 0;
    for (int k = 0; k < kAround && girth.at(row, k) > 0.0; ++k) {
      std::vector<double> near;
      for (int other = std::max(row - kNear, 0); other <= std::min(row + kNear, girth.rows - 1);
           ++other) {
        for (int turn = -kBeside; turn <= kBeside; ++turn) {
          const double ratio = known[other * kAround + (k + turn + kAround) % kAround];
          if (ratio > 0.0) near.push_back(ratio);
        }
      }
      usual[k] = median(near);
      low += girth.at(row, k) < kInnerWall * usual[k];
    }
    for (int k = 0; k < kAround && girth.at(row, k) > 0.0; ++k) {
      double& ratio = girth.at(row, k);
      const bool stands_out = !closed && ratio > kStrap * usual[k];
      if (stands_out || (ratio < kInnerWall * usual[k] && low < kJointAround)) ratio = usual[k];
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
  // Above the sections lies the humerus' head, which turns: as narrow all around as anywhere there.
  const double round = smoothstep(0.0, -top, y - top);
  return sum + round * (*std::min_element(ratio.begin(), ratio.begin() + kAround) - sum);
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

double GirthField::skin_at(double y, double angle) const {
  double sum = 0.0;
  for (const Share& share : shares(y, angle)) sum += share.share * skin[share.node];
  return sum;
}

namespace {

// m, from the mapped axis outwards to the skin, or as far as it is around where a hole is, or the
// end of a piece at a joint; `d`: from the template's axis at y.
double way_out(const ArmFit& fit, const Limb& limb, const Limb& body, double y, const Vec3& d) {
  const Vec3 mapped = linear_at(fit, y) * d;
  const double longer = mapped.norm() / d.norm();
  const double usual = fit.girth.skin_at(y, arc_tan2(d.z(), d.x())) * longer;
  // Where the skin steps from thin to thick, the thin counts.
  double least = usual;
  for (const GirthField::Share& share : fit.girth.shares(y, arc_tan2(d.z(), d.x()))) {
    if (share.share > 0.0) least = std::min(least, fit.girth.skin[share.node] * longer);
  }
  const Vec3 axis = map_point(fit, axis_point(fit, y)), to = mapped.normalized();
  if (body.closed()) {
    const double out = body.way_out(axis, to);
    return out < kPieceEnd * least ? usual : out;
  }
  double out = limb.outermost(axis, to, kWidest * usual);
  if (out < 0.0)
    out = body.outermost(axis, to, kWidest * usual);  // the shoulder's cap is the trunk's
  return out < kHole * least ? usual : out;
}

ArmSize size_of(const ArmFit& fit, const GirthField& girth, const std::vector<double>& skin,
                bool in_template) {
  ArmSize size;
  const double elbow = fit.elbow_template.y();
  for (int row = 0; row < girth.rows; ++row) {
    const double y = girth.top - row * kRow;
    if (y < fit.wrist_template.y()) break;
    const Mat3 linear = in_template ? Mat3(Mat3::Identity()) : linear_at(fit, y);
    const double along = in_template ? 1.0 : y > elbow ? fit.along_upper : fit.along_fore;
    double around = 0.0, area = 0.0;
    for (int k = 0; k < kAround; ++k) {
      const auto at = [&](int m) -> Vec3 {
        const SinCos turn = sin_cos(direction_of(m));
        return skin[row * kAround + m % kAround] * (linear * Vec3(turn.cos, 0.0, turn.sin));
      };
      around += (at(k + 1) - at(k)).norm();
      area += 0.5 * at(k).cross(at(k + 1)).norm();
    }
    size.room += area * kRow * along;
    double& girth_here = y > elbow ? size.upper_girth : size.fore_girth;
    // Of the upper arm the middle: above lies the shoulder.
    if (y < 0.35 * elbow && (y > 0.65 * elbow || y < elbow)) {
      girth_here = std::max(girth_here, around);
    }
  }
  return size;
}

}  // namespace

void fit_girth(const ArmTemplate& from, const Limb& limb, const Limb& body, ArmFit& fit) {
  fit.girth = {};  // while it is measured, across is as in the template
  fit.girth.top = -kUnderTop;
  fit.girth.rows = static_cast<int>((kBeyondHand - kUnderTop - from.wrist.y()) / kRow) + 1;
  find_shift(from, limb, fit);
  GirthField girth = fit.girth;
  const std::vector<double>& own = girth.own = own_skin(fit, from, girth.rows, girth.top);
  girth.ratio.assign(own.size(), -1.0);
  measure(fit, limb, body, own, girth);
  const double elbow = from.elbow.y(), wrist = from.wrist.y();
  girth.told = {share_told(girth, girth.top, elbow), share_told(girth, elbow, wrist)};
  mend_outliers(girth, body.closed());
  fill_rows(girth);
  if (girth.ratio[0] < 0.0) {  // no skin around the arm
    girth.ratio.clear();
    fit.girth = girth;
    return;
  }
  girth.thick = {fit.across * girth.mean(girth.top, elbow) / fit.along_upper,
                 fit.across * girth.mean(elbow, wrist) / fit.along_fore};
  girth.skin = own;
  for (size_t i = 0; i < own.size(); ++i) girth.skin[i] *= girth.ratio[i];
  fit.girth.skin = girth.skin;
  fit.own_size = size_of(fit, girth, own, true);
  fit.size = size_of(fit, girth, girth.skin, false);
  const double fat = kFat * fit.across;
  // Of flesh beyond the sections too.
  for (const Vec3& p : from.flesh) {
    const Vec3 d = p - axis_point(fit, p.y());
    const double reach = (linear_at(fit, p.y()) * d).norm();
    if (reach < 1e-4) continue;
    const double out = way_out(fit, limb, body, p.y(), d);
    const double most = (out - std::min(fat, kFatShare * out)) / reach;
    for (const GirthField::Share& share : girth.shares(p.y(), arc_tan2(d.z(), d.x()))) {
      girth.ratio[share.node] = std::min(girth.ratio[share.node], most);
    }
  }
  make_gentle(girth);
  smooth(girth);
  make_gentle(girth);
  fit.girth = girth;
}

double least_fat(const ArmFit& fit, const Limb& limb, const Limb& body,
                 const std::vector<Vec3>& points) {
  double least = std::numeric_limits<double>::max();
  for (const Vec3& p : points) {
    const Vec3 d = p - axis_point(fit, p.y());
    const double reach = (map_point(fit, p) - map_point(fit, axis_point(fit, p.y()))).norm();
    if (reach < 1e-4) continue;
    least = std::min(least, way_out(fit, limb, body, p.y(), d) - reach);
  }
  return least;
}

Points skin_in_pose(const Character& character, const Pose& pose) {
  std::vector<Affine> world;
  for (int b = 0; b < character.skeleton.size(); ++b) {
    world.push_back(pose[b] * (rigid_part(character.bind[b]).inverse() * character.bind[b]));
  }
  Points x;
  skin_vertices(character.skin, character.mesh, world, x);
  return x;
}

}  // namespace thew::tools
