// SPDX-License-Identifier: Apache-2.0
//
// The contacts of an explicit step. Each is a plane that moves during the frame. It stops its node
// by an impulse and bears the normal part of the force of the volume multiplier there.
#pragma once

#include <vector>

#include "skin/contact/multipliers.h"

namespace thew::skin {

// Always inlined, for the same reason as sum3.
[[gnu::always_inline]] inline double dot3(const Point& a, const Point& b) { return sum3(a * b); }

/// A contact during a frame: the plane normal . x = level + t motion, with t from 0 to 1. Its size
/// is one cache line; what a substep adds is in ActivePlane.
struct ContactPlane {
  Point normal;
  double level, motion;  // m, the gap is included in level
  double impulse = 0.0;  // N s along the normal, so far
  int node;
  bool active = false;  // in this substep
  bool shared = false;  // whether its node has another plane
};
static_assert(sizeof(ContactPlane) == 64);
using ContactPlanes = std::vector<ContactPlane, AlignedAllocator<ContactPlane>>;
/// The planes of the contacts of a body, for the step that ends with the colliders in their present
/// positions.
void find_contact_planes(const ContactSolve& solve, const std::vector<Contact>& contacts,
                         ContactPlanes& planes);

/// The nodes of a body within a substep.
struct ExplicitNodes {
  const Points& x;                      ///< m
  Points& v;                            ///< m/s
  const Points& gradient;               ///< dV/dx, m^2
  Points& direction;                    ///< d = W dV/dx / m
  const std::vector<double>& mobility;  ///< W / m, 1/kg
};
/// Impulse (N s) and angular impulse (N m s, about the origin) by contact since the start.
struct ContactImpulse {
  Vec3 impulse = Vec3::Zero();
  Vec3 angular_impulse = Vec3::Zero();
};

struct ActivePlane {
  ContactPlane* plane;
  double multiplier_part;  // m^2/kg, part of `direction` along the normal, which the plane bears
  double velocity_change;  // m/s along the normal, in this substep
};
struct NearPlanes {
  std::vector<ContactPlane*> all, shared;  // shared: their nodes have other planes as well
  // As long as `all`; the first active_count are active in this substep.
  std::vector<ActivePlane> active;
  size_t active_count = 0;
};

/// Finds the planes that nodes may reach within `span` (s) from the part t of the frame on, even at
/// twice the highest present speed. `frame` is the length of the frame (s).
void find_near_planes(double t, double frame, double span, const Points& x, const Points& v,
                      ContactPlanes& planes, NearPlanes& near);

/// Sums that the linear multiplier needs in a substep.
struct VolumeSums {
  double volume = 0.0;    // m^3
  double rate = 0.0;      // dV/dx . v, m^3/s
  double weighted = 0.0;  // dV/dx . d
};

/// Stops the nodes that would be behind a plane at the part t of the frame, under the multiplier
/// lambda. From then on the multiplier does not move them across the plane, and `sums` are updated.
/// `whole`: `direction` is stored for all nodes, else only for nodes of shared planes. True if a
/// plane became active.
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole,
                    NearPlanes& near, const ExplicitNodes& nodes, VolumeSums& sums);

/// Ends a substep: adds to the impulses of the planes their velocity changes and the part of the
/// multiplier's force that they bear, and makes all planes inactive. With `whole` that part has
/// been taken out of the velocities already.
void release_contacts(double lambda, bool whole, const std::vector<double>& mass, NearPlanes& near,
                      const ExplicitNodes& nodes, ContactImpulse& impulse);

}  // namespace thew::skin
