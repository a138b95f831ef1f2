// SPDX-License-Identifier: Apache-2.0
#include "muscles/carry.h"

#include <algorithm>
#include <cmath>

#include "muscles/activation.h"

namespace thew::muscles {
namespace {

// Scale [1] of the offsets in the shape in which the springs have their rest lengths. It is a
// little tighter than the carried shape, because springs under tension do not wrinkle; the
// multiplier supplies the remaining volume. Chosen by trial.
constexpr double kTightness = 0.98;

// Share [1] of the force of a muscle that its surface carries. The remainder would run through the
// inside, which a surface model does not have. Chosen by trial.
constexpr double kSurfaceShare = 0.01;

// With shape = "target" the rest length of each spring is its length in the tightened carried
// shape. With shape = "weights" rest lengths follow the path along the fibres, and keep those of
// the rest shape across them.
void set_rest_lengths(const Muscle& muscle, const CarriedStep& step, std::vector<double>& rest) {
  const Springs& springs = muscle.springs;
  if (!muscle.has_path()) {
    rest = springs.rest_length;
    return;
  }
  if (muscle.swells) {
    spring_lengths(springs, step.tightened, rest);
    return;
  }
  rest.resize(springs.nodes.size());
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double stretch =
        0.5 * (stretch_at(muscle.shape, step.pose, a) + stretch_at(muscle.shape, step.pose, b));
    const double along = springs.fibre_share[k];  // cos^2 to the fibres
    rest[k] = springs.rest_length[k] * std::sqrt(along * stretch * stretch + 1.0 - along);
  }
}

// Shortens the rest lengths of the springs along the fibres, so that they pull with the tension of
// the muscle (Hill). Each of the `abreast` springs that cross a section carries an equal part.
void activate(const Muscle& muscle, double activation, double change, double path_velocity,
              std::vector<double>& rest) {
  if (muscle.settings.f_max <= 0.0 || activation <= 0.0) return;
  const Springs& springs = muscle.springs;
  const double belly = muscle.shape.belly[1] - muscle.shape.belly[0];
  const double fibre = muscle.settings.fibre_length;
  const double tension =
      kSurfaceShare * muscle_tension(muscle.settings.f_max, activation, 1.0 + change / fibre,
                                     path_velocity / fibre);
  double abreast = 0.0;
  for (int k = 0; k < springs.structural; ++k) {
    abreast += springs.fibre_share[k] * springs.rest_length[k] / belly;
  }
  for (int k = 0; k < springs.structural; ++k) {
    const double shortening = tension / abreast * springs.fibre_share[k] / springs.stiffness[k];
    rest[k] = std::max(rest[k] - shortening, 0.2 * rest[k]);  // as in stretch_at()
  }
}

}  // namespace

void carry_muscle(const Muscle& muscle, const Pose& pose, double activation, double h,
                  CarriedMotion& motion, CarriedStep& step) {
  const double length_before = motion.path_length;
  step.activation = activation;
  step.target_velocity.swap(motion.target);  // the target before
  carry_pose(muscle.shape, pose, step.carry, step.pose);
  motion.path_length = step.pose.path_length;
  carried_positions(muscle.shape, step.pose, muscle.swells, motion.target, kTightness,
                    muscle.swells ? &step.tightened : nullptr);
  if (muscle.shape.clear_bones) muscle.shape.clear_bones(pose, motion.target, step.carry.cleared);
  for (size_t i = 0; i < motion.target.size(); ++i) {
    step.target_velocity[i] = (motion.target[i] - step.target_velocity[i]) * (1.0 / h);
  }
  step.rest_length_before.swap(motion.rest_length);
  set_rest_lengths(muscle, step, motion.rest_length);
  activate(muscle, activation, step.pose.change, (motion.path_length - length_before) / h,
           motion.rest_length);
}

}  // namespace thew::muscles
