// SPDX-License-Identifier: Apache-2.0
//
// What of the skin is the arm's own, and what hard or worn over it.
#include "tools/fit/worn.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "rig/math.h"
#include "skin/sides.h"
#include "tools/fit/limb.h"
#include "tools/fit/target.h"

namespace thew::tools {
namespace {

struct Pieces {
  Points x;  // m
  skin::Surface surface;
  skin::Shell shell;
};

Pieces pieces_of(const TriMesh& whole) {
  Pieces out;
  out.x = to_points(whole.vertices);
  const int nodes = static_cast<int>(out.x.size());
  std::vector<Triangle> triangles;
  std::copy_if(whole.triangles.begin(), whole.triangles.end(), std::back_inserter(triangles),
               [](const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; });
  out.surface = skin::make_surface(std::move(triangles), nodes);
  out.shell = skin::make_shell(out.surface, nodes);
  return out;
}

// The arm's axis, a share of the way from the shoulder to the elbow, or on from there to the wrist.
Vec3 on_axis(const ArmFit& fit, double share) {
  const double elbow = fit.elbow_template.y(), wrist = fit.wrist_template.y();
  const double y = share < 1.0 ? share * elbow : elbow + (share - 1.0) * (wrist - elbow);
  return map_point(fit, axis_point(fit, y));
}

// From the middle of the upper arm to the forearm's.
std::vector<skin::Span> across_elbow(const ArmFit& fit) {
  return {{on_axis(fit, 0.5), on_axis(fit, 1.5)}};
}

// m, in the mean; of what no ray meets none.
double distance_from_axis(const TriMesh& whole, const std::vector<Triangle>& triangles,
                          const ArmFit& fit) {
  constexpr int kPlaces = 8, kAround = 8;
  constexpr double kReach = 0.2;  // m, of an arm like the template's; beyond it is another's side
  const TriMesh piece{whole.vertices, triangles};
  const Limb limb(piece);
  double sum = 0.0;
  int hits = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const double share = 0.5 + (k + 0.5) / kPlaces;
    const Mat3& across = share < 1.0 ? fit.upper : fit.fore;
    for (int a = 0; a < kAround; ++a) {
      const SinCos turn = sin_cos(2.0 * kPi * a / kAround);
      const Vec3 out = (across * Vec3(turn.cos, 0.0, turn.sin)).normalized();
      const double far = limb.outermost(on_axis(fit, share), out, kReach * fit.across);
      if (far < 0.0) continue;
      sum += far;
      ++hits;
    }
  }
  return hits > 0 ? sum / hits : 0.0;
}

// By vertex, whether it is of a piece that tells nothing of the girth: the first answer, and ever
// more of them.
std::vector<std::vector<char>> find_worn(const TriMesh& whole, const ArmFit& fit) {
  constexpr int kPlaces = 16;  // along the axis, to the wrist
  const Pieces pieces = pieces_of(whole);
  const std::vector<int>& piece = pieces.shell.piece_of;
  std::vector<skin::Surface> surfaces(pieces.shell.pieces.size());
  for (const Triangle& t : pieces.surface.triangles) surfaces[piece[t[0]]].triangles.push_back(t);
  const auto surrounds = [&](size_t p, int place) {
    const Vec3 at = on_axis(fit, (place + 0.5) * 2.0 / kPlaces);
    return skin::winding_number(surfaces[p], pieces.x, at) > 0.5;
  };
  std::vector<std::pair<double, size_t>> bending;  // how far it is from the axis, the piece
  std::vector<char> surrounded(kPlaces, 0);
  for (size_t p = 0; p < surfaces.size(); ++p) {
    if (!skin::bends(surfaces[p], pieces.x, across_elbow(fit))) continue;
    const double distance = distance_from_axis(whole, surfaces[p].triangles, fit);
    if (!(distance > 0.0)) continue;  // a sky
    bending.emplace_back(distance, p);
    for (int k = 0; k < kPlaces; ++k) surrounded[k] |= surrounds(p, k);
  }
  std::vector<char> is_worn(surfaces.size(), !bending.empty());
  for (const auto& [distance, p] : bending) is_worn[p] = 0;
  for (size_t p = 0; p < surfaces.size(); ++p) {
    for (int k = 0; k < kPlaces && is_worn[p]; ++k) is_worn[p] = surrounded[k] || !surrounds(p, k);
  }
  std::sort(bending.begin(), bending.end());
  std::vector<std::vector<char>> worn;
  do {
    std::vector<char>& of = worn.emplace_back();
    for (const int p : piece) of.push_back(p >= 0 && is_worn[p]);
    if (!bending.empty()) is_worn[bending.back().second] = 1;
    if (!bending.empty()) bending.pop_back();
  } while (!bending.empty());
  return worn;
}

TriMesh without(const std::vector<char>& worn, TriMesh part) {
  const auto is_worn = [&](const Triangle& t) { return worn[t[0]] != 0; };
  part.triangles.erase(std::remove_if(part.triangles.begin(), part.triangles.end(), is_worn),
                       part.triangles.end());
  return part;
}

}  // namespace

bool is_hard(const TriMesh& whole, const TriMesh& limb, const ArmFit& fit) {
  const Pieces pieces = pieces_of(whole);
  const std::vector<int>& piece = pieces.shell.piece_of;
  const int nodes = static_cast<int>(pieces.x.size());
  std::vector<char> of_limb(nodes, 0);
  for (const Triangle& t : limb.triangles) of_limb[t[0]] = of_limb[t[1]] = of_limb[t[2]] = 1;
  // A trunk of which a part hangs on the limb is none of its pieces.
  std::vector<int> balance(nodes, 0);
  for (int i = 0; i < nodes; ++i) {
    if (piece[i] >= 0) balance[piece[i]] += of_limb[i] ? 1 : -1;
  }
  for (int i = 0; i < nodes; ++i) of_limb[i] &= piece[i] >= 0 && balance[piece[i]] > 0;
  const std::vector<char> hard =
      skin::find_hard(pieces.surface, pieces.x, pieces.shell, of_limb, across_elbow(fit));
  const auto of_hard = [&](const Triangle& t) { return hard[t[0]] != 0; };
  return 2 * std::count_if(limb.triangles.begin(), limb.triangles.end(), of_hard) >
         static_cast<std::ptrdiff_t>(limb.triangles.size());
}

OwnSkin fit_own_skin(const ArmTemplate& from, const TriMesh& skin, const TriMesh& whole,
                     ArmFit& fit) {
  const auto fit_without = [&](const std::vector<char>& worn) {
    OwnSkin own{without(worn, skin), without(worn, whole)};
    fit_girth(from, Limb(own.limb), Limb(own.body), fit);
    return own;
  };
  const std::vector<std::vector<char>> answers = find_worn(whole, fit);
  OwnSkin own = fit_without(answers.front());
  for (size_t i = 1; i < answers.size() && is_too_thick(fit); ++i) {
    const ArmFit outer = fit;
    OwnSkin inner = fit_without(answers[i]);
    if (std::min(fit.girth.thick[0], fit.girth.thick[1]) < kSlender) {
      fit = outer;
      break;
    }
    own = std::move(inner);
  }
  return own;
}

}  // namespace thew::tools
