// SPDX-License-Identifier: Apache-2.0
#include "tools/author/middle_line.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

Slab between(const Slab& a, const Slab& b, double t) {
  const double side = a.along.dot(b.along) < 0.0 ? -1.0 : 1.0;
  return {a.half + t * (b.half - a.half), a.radius + t * (b.radius - a.radius),
          ((1.0 - t) * a.along + t * side * b.along).normalized()};
}

}  // namespace

MiddleLine::MiddleLine(const SectionedMuscle& muscle, const Vec3& place)
    : tendon_radius_{muscle.tendon_radius[0], muscle.tendon_radius[1]} {
  const size_t n = muscle.sections.size();
  slabs_.push_back({0.0, tendon_radius_[0], muscle.sections.front().slab.along});
  for (const Section& section : muscle.sections) slabs_.push_back(grown(section));
  slabs_.push_back({0.0, tendon_radius_[1], slabs_.back().along});
  const double thinnest = std::min(tendon_radius_[0], tendon_radius_[1]);
  for (const Slab& slab : slabs_) {
    widest_ = std::max(widest_, slab.half + slab.radius);
    softest_ = std::max(softest_, slab.radius - thinnest);
  }
  for (size_t i = 0; i <= n; ++i) {
    const Vec3& a = i > 0 ? muscle.sections[i - 1].centre : muscle.origin;
    const Vec3& b = i < n ? muscle.sections[i].centre : muscle.insertion;
    const Vec3 d = b - a;
    Piece piece{a, d, std::max(d.squaredNorm(), 1e-12), 0.0, i};
    piece.distance = (place - (a + share(piece, place) * d)).norm();
    pieces_.push_back(piece);
  }
  std::sort(pieces_.begin(), pieces_.end(),
            [](const Piece& a, const Piece& b) { return a.distance < b.distance; });
}

double MiddleLine::share(const Piece& piece, const Vec3& p) {
  return std::clamp(piece.along.dot(p - piece.from) / piece.squared, 0.0, 1.0);
}

Near MiddleLine::near(const Vec3& p, double away) const {
  Near near;
  double best = 1e9, at = 0.0;
  size_t nearest = 0;
  for (const Piece& piece : pieces_) {
    const double least = piece.distance - away - 1e-9;  // by the triangle's inequality
    if (least > 0.0 && least * least > best) break;
    const double t = share(piece, p);
    const Vec3 q = piece.from + t * piece.along;
    const double distance = (p - q).squaredNorm();
    if (distance > best || (distance == best && piece.number > nearest)) continue;
    best = distance;
    nearest = piece.number;
    at = t;
    near.point = q;
  }
  near.slab = between(slabs_[nearest], slabs_[nearest + 1], at);
  const bool to_insertion = 2 * nearest + 2 > slabs_.size();
  near.soft = std::max(near.slab.radius - tendon_radius_[to_insertion], 1e-4);
  return near;
}

}  // namespace thew::tools
