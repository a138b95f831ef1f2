// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace thew::tools {

/// What is known of a muscle at angles of the elbow.
template <int kCount>
struct AnatomyRow {
  const char* muscle;
  std::array<double, kCount> angles;       ///< degrees of flexion
  std::array<double, kCount> millimetres;  ///< length, or how much shorter it is than at 0
};

/// Musculotendon lengths of OpenSim's arm26 (Holzbaur, Murray, Delp 2005), the cylinders that they
/// wrap solved exactly.
inline constexpr AnatomyRow<6> kArm26Lengths[] = {
    {"biceps_long", {0, 30, 60, 90, 120, 130}, {421.2, 411.7, 394.0, 370.3, 344.9, 337.3}},
    {"biceps_short", {0, 30, 60, 90, 120, 130}, {341.7, 332.2, 314.5, 290.8, 265.4, 257.8}},
    {"triceps_long", {0, 30, 60, 90, 120, 130}, {277.6, 289.8, 301.8, 312.3, 322.7, 326.1}}};

/// Shortening: by arm26 of those whose mesh begins on its bone before the line of action does, by
/// published regressions of moment arms, integrated, of the others.
inline constexpr AnatomyRow<5> kShortenings[] = {
    {"brachialis", {30, 60, 90, 120, 130}, {7.3, 14.4, 24.9, 37.3, 41.3}},
    {"triceps_lateral", {30, 60, 90, 120, 130}, {-12.2, -24.2, -34.7, -45.1, -48.5}},
    {"brachioradialis", {30, 60, 90, 120, 130}, {11, 27, 52, 84, 96}},
    {"extensor_carpi_radialis_longus", {30, 60, 90, 120, 130}, {6, 13, 23, 36, 40}},
    {"pronator_teres", {30, 60, 90, 120, 130}, {4, 8, 14, 20, 22}},
    {"flexor_carpi_radialis", {30, 60, 90, 120, 130}, {1, 2, 4, 5, 6}},
    {"anconeus", {30, 60, 90, 120, 130}, {-6, -12, -18, -22, -22}},
    {"coracobrachialis", {30, 60, 90, 120, 130}, {0, 0, 0, 0, 0}}};

}  // namespace thew::tools
