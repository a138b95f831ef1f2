// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/explicit_contact.h"

#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"

namespace thew::skin {
namespace {

ContactPlane plane_of(const ContactSolve& solve, const Contact& contact) {
  const Collider& other = solve.colliders[contact.other];
  const Point after = contact_point(solve.colliders, contact);
  const Point before = other.soft ? after : contact_point_before(solve.colliders, contact);
  const Point normal = to_point(contact.normal);
  return {.normal = normal,
          .level = dot(normal, before) + solve.settings.gap + contact.offset,
          .motion = dot(normal, after - before),
          .node = contact.node};
}

}  // namespace

void find_contact_planes(const ContactSolve& solve, const std::vector<Contact>& contacts,
                         ContactPlanes& planes) {
  planes.clear();
  for (const Contact& contact : contacts) {
    planes.push_back(plane_of(solve, contact));
    const size_t last = planes.size() - 1;
    if (last > 0 && planes[last - 1].node == contact.node) {  // planes are sorted by node
      planes[last - 1].shared = planes[last].shared = true;
    }
  }
}

THEW_VECTORISED
void find_near_planes(double t, double frame, double span, const Points& x, const Points& v,
                      ContactPlanes& planes, NearPlanes& near) {
  near.all.clear();
  near.shared.clear();
  if (planes.empty()) return;
  Point most = {};
  for (const Point& one : v) most = one * one > most ? one * one : most;
  const double fastest = std::sqrt(sum3(most));
  for (ContactPlane& plane : planes) {
    const double open = dot3(plane.normal, x[plane.node]) - plane.level - t * plane.motion;
    if (open >= span * (2.0 * fastest + std::abs(plane.motion) / frame)) continue;
    near.all.push_back(&plane);
    if (plane.shared) near.shared.push_back(&plane);
  }
  near.active.resize(near.all.size());
}

THEW_VECTORISED
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole,
                    NearPlanes& near, const ExplicitNodes& now, VolumeSums& sums) {
  const size_t before = near.active_count;
  size_t count = before;
  // In registers, because each sum waits for the one before.
  double rate = sums.rate, weighted = sums.weighted;
  for (ContactPlane* plane : near.all) {
    if (plane->active) continue;
    const int i = plane->node;
    const Point n = plane->normal;
    Point v = now.v[i];
    if (lambda != 0.0) v -= lambda * now.direction[i];
    const double open = dot3(n, now.x[i] + h * v) - plane->level - t * plane->motion;
    if (open >= 0.0) continue;
    plane->active = true;
    ActivePlane& active = near.active[count++];
    active = {plane, 0.0, -open / h};
    now.v[i] += active.velocity_change * n;
    if (!has_volume) continue;
    const bool stored = whole || plane->shared;
    const double slope = dot3(n, now.gradient[i]);
    active.multiplier_part = stored ? dot3(n, now.direction[i]) : now.mobility[i] * slope;
    rate += slope * active.velocity_change;
    weighted -= slope * active.multiplier_part;
    if (stored) now.direction[i] -= active.multiplier_part * n;
  }
  sums.rate = rate;
  sums.weighted = weighted;
  near.active_count = count;
  return count > before;
}

THEW_VECTORISED
void release_contacts(double lambda, bool whole, const std::vector<double>& mass, NearPlanes& near,
                      const ExplicitNodes& now, ContactImpulse& given_in_all) {
  Point impulse = {}, angular = {};
  for (size_t k = 0; k < near.active_count; ++k) {
    const auto& [plane, multiplier_part, velocity_change] = near.active[k];
    const double given = mass[plane->node] * (velocity_change + lambda * multiplier_part);
    plane->impulse += given;
    if (!whole) now.v[plane->node] += lambda * multiplier_part * plane->normal;
    const Point along = given * plane->normal;
    impulse += along;
    angular += cross3(now.x[plane->node], along);
    plane->active = false;
  }
  near.active_count = 0;
  given_in_all.impulse += to_vec(impulse);
  given_in_all.angular_impulse += to_vec(angular);
}

}  // namespace thew::skin
