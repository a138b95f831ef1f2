// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>

namespace thew::muscles {

/// Bounds in m of the rounding error of positions within some kilometres of the origin: of sums in
/// double precision (kRounding), of the boxes of a tree, which are in single precision
/// (kBoxRounding), and of a node that was moved onto a bone (kNodeRounding). They do not depend on
/// the size of the body.
inline constexpr double kRounding = 1e-9, kBoxRounding = 1e-6, kNodeRounding = 1e-12;  // m

/// All lengths of the method that a scene does not give, in m, for a body of the size of a grown
/// man. The key `size` of a scene multiplies them all, so that similar bodies move alike. Where no
/// reason is given, the value was chosen by trial on the arm and on characters; no source gives it.
struct Lengths {
  // Paths and carried shapes.
  /// Length over which corners of a path are rounded: half of the length over which a tendon bends.
  double corner_length = 0.007;
  /// Length over which tendon turns into belly.
  double junction_length = 0.012;
  /// Nodes farther along a muscle than the larger of this and 0.35 of its length are not of a
  /// section.
  double section_reach = 0.05;

  // Contact.
  /// Below this distance rounding would determine the direction from a point to its nearest point.
  double least_direction = 1e-7;
  /// How much smaller the gap of another contact of a node must be for it to take over as the one
  /// that counts; without this two contacts would take turns.
  double switch_lead = 1e-5;
  /// Least step of the march along the path of a node into a bone.
  double march_step = 5e-4;

  // Solvers.
  /// Speed in m/s of the fastest node, below which bodies have settled.
  double settled_speed = 1e-4;
  /// Motion of a node in an iteration, below which quasi-static iterations stop.
  double converged_motion = 1e-8;
  /// Motion of a node in an iteration, up to which a pinched muscle that finds no rest may swing in
  /// a frame that is solved by itself; a figure's brachialis does by 0.2 mm in the bent elbow.
  double pinched_swing = 5e-4;
  /// Depth of two bodies in one another in the rest pose, above which the user is warned.
  double reported_overlap = 1e-3;
  /// Size that is assumed for a rig whose joints all lie at one position.
  double least_rig_size = 0.1;

  // The skin layer.
  /// Flesh farther from a node of the skin than this is ignored.
  double flesh_reach = 0.03;
  /// Motion of a node after which the flesh below it is searched for again.
  double lookup_motion = 3e-4;
  /// Depth below the triangles of the skin that nodes of the flesh keep.
  double cover = 0.001;
  /// Depth below the skin within which nodes of the flesh are kept under it: twice `cover`.
  double cover_depth = 0.002;
  /// Height above the skin within which nodes of the flesh that came through are still found.
  double cover_reach = 0.006;
  /// Distance within which the other wall of a fold is searched for.
  double fold_reach = 0.006;
  /// What a node is moved beyond its least distance, so that rounding leaves it no nearer.
  double clearance = 1e-6;
  /// Thickness of fat from which on it gives way freely to the volume of the skin.
  double yielding_fat = 0.006;
  /// Distance of a node from its bound position, beyond which its anchor slips.
  double anchor_slip = 0.006;
  /// Longest step of a prediction towards the equilibrium with the forces of the step before.
  double max_return = 0.001;
  /// Height of a node above its level, at which the pull of the flesh on it has faded out.
  double pull_range = 0.01;
  /// Longest step of one projection of a node onto its level.
  double max_climb = 0.003;
  /// Thickness of fat that flesh does not press out of the way.
  double firm_fat = 0.006;
  /// How far a node may leave its prediction in any step, whatever it did in the step before.
  double free_correction = 1.5e-4;
  /// Mean motion of the nodes in a step, below which the skin rests. Single nodes in a fold may go
  /// on by some tenths of a millimetre.
  double skin_at_rest = 1e-6;
  /// Below this separation of the walls of a fold its direction is not defined.
  double least_separation = 1e-7;
  /// A node of the skin that is farther from all bones belongs to the root.
  double farthest_bone = 1.0;
  /// Length over which a part of the skin that is anchored to its body draws its neighbours along.
  double anchor_length = 0.12;
  /// Height over the flesh beyond which flesh does not carry the skin.
  double fat_reach = 0.03;

  // A character's own skin.
  /// Longest edge of the triangles that its layer is divided into.
  double point_spacing = 0.01;
};

/// All lengths multiplied by the size of a body [1].
inline Lengths times(const Lengths& lengths, double size) {
  auto all = std::bit_cast<std::array<double, sizeof(Lengths) / sizeof(double)>>(lengths);
  for (double& length : all) length *= size;
  return std::bit_cast<Lengths>(all);
}

}  // namespace thew::muscles
