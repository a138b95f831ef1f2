// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::tools {

/// What became of a run. Each frame's volume error is at most kMapVolume, no triangle is inverted
/// (its normal against the mean of its neighbours') and the energy does not grow while the rig
/// rests: kAccurate, if it also ends where the run of the finest step does. kRecovered: only the
/// last frame is so. kDegraded: not even that. kDiverged: the solver gave up, the energy grew
/// tenfold while the rig rested, or the volume is off by more than 1 % at the end.
enum class Verdict { kAccurate, kDegraded, kRecovered, kDiverged, kNotRun };
const char* verdict_name(Verdict verdict);

/// The criterion that a run failed, the first that holds in this order.
enum class Mechanism {
  kNone,
  kNotRun,       ///< more work than a cell may take
  kFliesOff,     ///< a position that is no number, too far off or too fast
  kTorn,         ///< an edge ten times its length
  kTurnedOver,   ///< half of the surface inside out, or no volume left
  kTunnels,      ///< it would pass into an obstacle within a step
  kNoSolution,   ///< the solver says that it found none
  kEnergy,       ///< energy grew while the rig rested
  kVolumeLost,   ///< more than 1 % off at the end
  kFolded,       ///< triangles inverted at the end
  kFoldedThere,  ///< inverted on the way, and well again
  kMoving,       ///< not at rest at the end
  kElsewhere,    ///< it ends elsewhere than the finest step's run
  kVolumeSoft    ///< the volume is held to less than rounding
};
struct MechanismText {
  const char *sign, *name;
  const char* why;   ///< what brings it about, a sentence
  const char* thew;  ///< what Thew does there, a sentence
};
const MechanismText& mechanism_text(Mechanism mechanism);

inline constexpr double kMapVolume = 1e-9;    ///< |V/V0 - 1|
inline constexpr double kMapLost = 0.01;      ///< |V/V0 - 1| at the end
inline constexpr double kMapGrowth = 1.05;    ///< of the energy while the rig rests
inline constexpr double kMapDistance = 0.02;  ///< RMS, of the body's size
inline constexpr double kMapSpeed = 0.05;     ///< sizes a second, fastest node of the last frame

struct MapCell {
  Verdict verdict = Verdict::kNotRun;
  Mechanism mechanism = Mechanism::kNone;
  bool inferred = false;                         ///< not run: its surroundings tell
  std::string failure;                           ///< what the solver said, or why it was not run
  double volume_error = 0.0, last_volume = 0.0;  ///< largest; of the last frame
  int inverted = 0, last_inverted = 0;           ///< triangles, most; in the last frame
  double growth = 1.0;                           ///< of the energy while the rig rests, largest
  double speed = 0.0;                            ///< sizes a second, last frame
  double distance = 0.0;                         ///< RMS from the finest step's, over the size
};

/// Watches a run frame by frame: the rig moves in the even phases and rests in the odd ones.
class CellWatch {
 public:
  CellWatch(std::vector<Triangle> triangles, double rest_volume, int frames_a_phase);
  /// Energy in J; positions after frame 1, 2 ...
  void see(int frame, const Points& x, double energy, MapCell& cell);

 private:
  std::vector<Triangle> triangles_;
  double rest_volume_;
  int phase_;
  double at_rest_ = 0.0, floor_ = 0.0;  // J when the rig came to rest; what does not count
};

/// Gives a cell that ran its verdict and mechanism. `finest`: where the finest step ends, empty
/// where this is it or it failed.
void judge_cell(const Points& finest, const Points& last, double size, MapCell& cell);

}  // namespace thew::tools
