// SPDX-License-Identifier: Apache-2.0
//
// The contacts of an explicit step: each a plane that moves through the frame, that stops its node
// and bears its part of the multiplier's force.
#pragma once

#include <vector>

#include "skin/contact/multipliers.h"

namespace thew::skin {

// Inlined as sum3 is.
[[gnu::always_inline]] inline double dot3(const Point& a, const Point& b) { return sum3(a * b); }

/// A contact within a frame: a plane that goes from one place to another, normal . x = from + t
/// way. One line of the cache; what a substep adds is in Held.
struct Touch {
  Point normal;
  double from, way;     // m, the gap included
  double pushed = 0.0;  // N s so far, all along the normal
  int node;
  bool held = false;    // in this substep
  bool shared = false;  // its node has another one
};
static_assert(sizeof(Touch) == 64);
using Touches = std::vector<Touch, AlignedAllocator<Touch>>;
/// Of a body's contacts in the step that ends where the colliders are.
void find_touches(const ContactSolve& solve, const std::vector<Contact>& contacts,
                  Touches& touches);

/// A body's nodes within a substep.
struct ExplicitNodes {
  const Points& x;                      ///< m
  Points& v;                            ///< m/s
  const Points& gradient;               ///< dV/dx, m^2
  Points& direction;                    ///< d = W dV/dx / m
  const std::vector<double>& mobility;  ///< W / m, 1/kg
};
/// N s and N m s about the origin, given by contact since the start.
struct ContactImpulse {
  Vec3 impulse = Vec3::Zero();
  Vec3 angular_impulse = Vec3::Zero();
};

struct Held {
  Touch* touch;
  double across;  // m, part of the multiplier's direction that the plane bears
  double kick;    // m/s, in this substep
};
struct Near {
  std::vector<Touch*> all, shared;  // these have nodes of others as well
  std::vector<Held> held;           // room for all; the first `holds` hold in this substep
  size_t holds = 0;
};

/// Keeps those that may close within `span` (s) from the part `t` of the frame on, were all twice
/// as fast as now.
void look_for_near(double t, double frame, double span, const Points& x, const Points& v,
                   Touches& touches, Near& near);

/// What the linear multiplier takes of a substep.
struct VolumeSums {
  double volume = 0.0;    // m^3
  double rate = 0.0;      // dV/dx . v, m^3/s
  double weighted = 0.0;  // dV/dx . d
};

/// Stops the nodes that would cross a plane by the part `t` of the frame, under `lambda`; from then
/// on the multiplier no longer moves them across. `whole`: its direction is stored for all nodes.
/// True where there was one.
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole, Near& near,
                    const ExplicitNodes& nodes, VolumeSums& sums);

/// Books what the planes gave: their own kicks, and what they bear of the multiplier's force, given
/// back beforehand where the step goes along all of its direction.
void release_contacts(double lambda, bool whole, const std::vector<double>& mass, Near& near,
                      const ExplicitNodes& nodes, ContactImpulse& impulse);

}  // namespace thew::skin
