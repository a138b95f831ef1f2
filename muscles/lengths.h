// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>

namespace thew::muscles {

/// Rounding of what is computed of places within kilometres: of sums in double precision, of boxes
/// in single precision, and what a node may lie in bone by. No size multiplies them.
inline constexpr double kRounding = 1e-9, kBoxRounding = 1e-6, kNodeRounding = 1e-12;  // m

/// Every length of the method that a scene does not give: m, on a body of a grown man's size.
/// Another size multiplies them all ([scene] size), so that what is similar moves alike.
struct Lengths {
  // Paths and carried shapes.
  double corner = 0.007;        ///< over which a path's corners are rounded: half a tendon's bend
  double junction = 0.012;      ///< over which tendon turns into belly
  double section_reach = 0.05;  ///< along a muscle, beyond which it is not of a section

  // Contact.
  double touching = 1e-7;  ///< nearer, rounding would set a contact's direction
  double nearer = 1e-5;    ///< by which another of a node's holds has to be, or two take turns
  double march = 5e-4;     ///< least step of a node's way into a bone

  // Solvers.
  double settled = 1e-4;    ///< way of the fastest node in a second below which a body has settled
  double converged = 1e-8;  ///< motion of an iteration below which quasi-static ones rest
  double told_overlap = 1e-3;  ///< of two bodies at rest, above which it is said
  double least_rig = 0.1;      ///< of a rig whose joints all lie in one place

  // The skin layer.
  double flesh_reach = 0.03;      ///< flesh farther from the skin is not felt
  double stale = 3e-4;            ///< of motion after which the flesh is looked up again
  double cover = 0.001;           ///< flesh nodes stay this deep under the skin's triangles
  double cover_depth = 0.002;     ///< at which they are looked after
  double cover_reach = 0.006;     ///< through the skin at which they are still found
  double fold_reach = 0.006;      ///< between the walls of a fold
  double clearance = 1e-6;        ///< beyond the least distance, so that rounding leaves none short
  double plenty = 0.006;          ///< of fat that gives way freely
  double yield = 0.006;           ///< from its bound place beyond which an anchor slips
  double longest_return = 0.001;  ///< of a step towards the balance of the forces before
  double slack = 0.01;            ///< above its level at which the flesh's pull has faded
  double longest_climb = 0.003;   ///< of one projection onto the level
  double firm = 0.006;            ///< of fat that flesh does not press out of the way
  double always_eased = 1.5e-4;   ///< that a node may leave its prediction by in any step
  double least_parted = 1e-7;     ///< by which walls are moved apart: less tells no direction
  double farthest_bone = 1.0;     ///< beyond it a node of the skin belongs to the root
  double anchor = 0.12;           ///< over which a held patch draws its neighbours along
  double fat_reach = 0.03;        ///< beyond which flesh does not carry the skin

  // A character's own skin.
  double flat = 1e-5;      ///< what the weights leave of a distance: less tells no direction
  double beside = 0.008;   ///< from a point's line, within which a sample lifts the point
  double smoothed = 0.01;  ///< over which the displacement is evened out ...
  double spread = 0.02;    ///< ... in the fewest passes no farther than this: it would flatten
  double crease = 0.05;    ///< within which a sharp crease that the weights do not have is evened
  double point_spacing = 0.01;  ///< from point to point within a triangle
  double sampled = 0.008;       ///< longest edge of what a sample of a muscle stands for
};

inline Lengths times(const Lengths& lengths, double size) {
  auto all = std::bit_cast<std::array<double, sizeof(Lengths) / sizeof(double)>>(lengths);
  for (double& length : all) length *= size;
  return std::bit_cast<Lengths>(all);
}

}  // namespace thew::muscles
