// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "thew/error.h"

namespace thew {

// The kernel of Hong, Jung, Choi and Welch, "Fast Volume Preservation for a Mass-Spring System"
// (2006), on arrays, for any solver. All of a closed triangle surface: positions in m, x, y, z of
// each vertex; triangles counter-clockwise seen from outside, vertices of one place joined.

/// dV/dx (m^2), x, y, z of each vertex; the paper's sidebar A, which prints -3 times it. Exact for
/// a closed surface only. Error(kUsage) for arrays that do not fit.
std::vector<double> volume_gradient(std::span<const double> positions,
                                    std::span<const int> triangles);

struct RestoredVolume {
  double multiplier = 0.0;  ///< s, in kg/m
  bool reached = true;      ///< false: no motion along that direction leads to the volume
  double volume = 0.0;      ///< m^3, that the moved surface encloses
};
/// Moves each vertex to x_i + s w_i / m_i dV/dx_i, the correction of the paper's eqs 9 to 14, with
/// the exact multiplier s: the root nearest 0 of the cubic V(x + s d) = `volume`, not its
/// linearisation, so that one call reaches the volume (m^3) to rounding error. `weights` (0 or
/// more, in any unit) says where the correction goes; `inverse_mass` (1/kg) is 0 for a vertex that
/// must not move. One of each per vertex, or no weights: all 1. Where the volume cannot be reached
/// the vertices go where it comes nearest. Error(kUsage) for arrays that do not fit.
RestoredVolume restore_volume(std::span<double> positions, std::span<const int> triangles,
                              std::span<const double> weights, std::span<const double> inverse_mass,
                              double volume);

}  // namespace thew
