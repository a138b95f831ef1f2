// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/claims.h"

#include <algorithm>

#include "tools/lab/base/table.h"

namespace thew::tools {
namespace {

constexpr const char *kBall = "ball_1470", *kFlexed = "flexed";
constexpr const char* kNamed[] = {
    "Promayon 1997", "Zordan 2004", "Nedel 1998", "Bourguignon 2000", "linear FEM",
    "Mueller 2004",  "Hirota 1999", "Chen 1992",  "Scheepers 1997",   "Aubel 2001"};
constexpr const char* kToday[] = {"Smith 2018", "Chen 2024"};

std::string percent(double share) { return number(100.0 * share) + " %"; }

// Largest volume error of a method's best runs in all scenes.
double worst_volume(const Study& study, const std::string& name) {
  double worst = -1.0;
  for (const StudiedScene& in : study.scenes) {
    const RelatedRun* const run = study.best(name, in.scene.key);
    if (run) worst = std::max(worst, run->volume_error);
  }
  return worst;
}

RelatedClaim not_run(const std::string& claim) {
  return {claim, "no stable setting, or not in this run", "not run"};
}

RelatedClaim loses(const Study& study, const std::string& name, const std::string& claim,
                   double more_than) {
  const double worst = worst_volume(study, name);
  if (worst < 0.0) return not_run(claim);
  return {claim, "largest volume error " + percent(worst), worst > more_than ? "true" : "false"};
}

RelatedClaim keeps(const Study& study, const std::string& name, const std::string& claim,
                   double up_to) {
  const double worst = worst_volume(study, name);
  if (worst < 0.0) return not_run(claim);
  return {claim, "largest volume error " + number(worst, 2), worst <= up_to ? "true" : "false"};
}

RelatedClaim velocities(const Study& study) {
  const std::string claim =
      "Promayon's projection keeps the volume and not the velocities: they do not know of it";
  const RelatedRun* const ours = study.best(kOurs, kBall);
  std::string figures;
  bool differs = false;
  for (const RelatedRun& run :
       study.scenes[study.scene(kBall)].sweeps[study.method("Promayon 1997")].runs) {
    const bool unaware = run.dial == kUnaware;
    figures += run.dial + ", " + std::to_string(run.steps) + " steps: ";
    if (run.failure.empty()) {
      figures += "they would gain or lose " + percent(run.volume_rate) + " of it a second; ";
      differs = differs || (unaware && ours && run.volume_rate > 3.0 * ours->volume_rate);
    } else {
      figures += run.failure + "; ";
      differs = differs || unaware;
    }
  }
  if (!ours || study.quick) return {claim, figures, "not run"};
  return {claim, figures + "the multiplier " + percent(ours->volume_rate),
          differs ? "only where they are left as they are" : "false"};
}

RelatedClaim pressure(const Study& study) {
  const std::string claim =
      "Zordan's pressure holds the volume as far as its modulus goes, and that asks for small "
      "steps";
  const int m = study.method("Zordan 2004"), s = study.scene(kBall);
  const RelatedSweep& found = study.scenes[s].sweeps[m];
  std::string figures;
  const RelatedRun *soft = nullptr, *hard = nullptr;  // by their errors, at the fewest steps
  std::string told;
  for (const RelatedRun& run : found.runs) {
    if (run.dial == told) continue;  // the same, finer
    told = run.dial;
    figures += run.dial + ": ";
    if (!run.failure.empty()) {
      figures += run.failure + "; ";
      continue;
    }
    figures += percent(run.volume_error) + " in " + std::to_string(run.steps) + " steps; ";
    if (!soft || run.volume_error > soft->volume_error) soft = &run;
    if (!hard || run.volume_error < hard->volume_error) hard = &run;
  }
  if (soft == hard) return {claim, figures, "not run"};
  return {claim, figures, hard->steps > soft->steps ? "true" : "only beyond these moduli"};
}

RelatedClaim stiffens(const Study& study) {
  const std::string claim = "barycentre springs stiffen the body";
  const int m = study.method("Bourguignon 2000");
  if (study.stiffening[m] < 0.0) return not_run(claim);
  const double times = study.stiffening[m], ours = study.stiffening[study.method(kOurs)];
  return {claim,
          "against a stretch that keeps the volume " + number(times) +
              " times as stiff as without them, the multiplier " + number(ours),
          times > 1.05 ? "true" : "false"};
}

// Cost of another over ours where ours is as near to the truth, or at our best; each ball.
RelatedClaim dearer(const Study& study, const std::string& name, const std::string& claim,
                    double times) {
  std::string figures;
  int balls = 0, dear = 0;
  for (const StudiedScene& in : study.scenes) {
    if (in.scene.key.find("ball_") != 0) continue;
    const RelatedRun *other = study.best(name, in.scene.key),
                     *ours = study.cheapest(kOurs, in.scene.key);
    if (!other || !ours) continue;
    if (ours->distance > other->distance) ours = study.best(kOurs, in.scene.key);
    const double ratio = other->milliseconds / ours->milliseconds;
    figures += in.scene.key + ": " + number(ratio) + " times our cost";
    if (other->distance >= 0.0) {
      figures += ", distance " + percent(other->distance) + ", ours " + percent(ours->distance);
    }
    figures += "; ";
    ++balls;
    dear += ratio > times;
  }
  if (balls == 0) return not_run(claim);
  return {claim, figures, dear == balls ? "true" : dear > 0 ? "only for some sizes" : "false"};
}

RelatedClaim near_conventional(const Study& study) {
  const std::string claim =
      "the paper's method costs about what a conventional system does (table 1)";
  const RelatedRun *none = study.thew(kThewBare, kFlexed), *ours = study.thew(kThew, kFlexed);
  if (!none || !ours) return not_run(claim);
  const double times = ours->milliseconds / none->milliseconds;
  return {claim,
          number(times) + " times, Thew's own explicit steps with and without it, flexed (no " +
              "contact); printed 1.08 to 1.38",
          times <= 1.4 ? "true" : "false"};
}

// The nearest of ours in a scene: Thew's own settings, and its method on the others' footing.
const RelatedRun* our_nearest(const Study& study, const StudiedScene& in) {
  const RelatedRun* nearest = study.best(kOurs, in.scene.key);
  for (const RelatedRun& run : in.thew) {
    if (!run.failure.empty() || run.distance < 0.0 || run.method == kThewBare) continue;
    if (!nearest || run.distance < nearest->distance) nearest = &run;
  }
  return nearest;
}

// Scenes in which another is nearer to the truth than ours, by more than the truth is sure of, and
// those in which it is cheaper as well.
RelatedClaim better_than(const Study& study, const std::string& claim,
                         const std::vector<std::string>& others) {
  std::string figures;
  int nearer = 0, beaten = 0;
  for (const StudiedScene& in : study.scenes) {
    const RelatedRun* const ours = our_nearest(study, in);
    if (!ours || ours->distance < 0.0) continue;
    const double unsure = in.truth.error / in.scene.size;
    std::string found;
    for (const std::string& name : others) {
      const RelatedRun* const run = study.best(name, in.scene.key);
      if (!run || run->distance < 0.0 || run->distance > ours->distance - unsure) continue;
      ++nearer;
      beaten += run->milliseconds < ours->milliseconds;
      found += std::string(found.empty() ? "" : ", ") + name + " " + percent(run->distance) +
               " at " + number(run->milliseconds / ours->milliseconds) + " times the cost";
    }
    figures += in.scene.key + ": ours " + percent(ours->distance) + " (" + ours->method + ")" +
               (found.empty() ? ", none nearer; " : ", nearer are " + found + "; ");
  }
  return {claim, figures,
          nearer == 0  ? "true"
          : beaten > 0 ? "false"
                       : "only among what costs as little"};
}

// The biceps of the arm at the last angle: "; on the arm at 130 degrees ...", or nothing.
std::string of_the_arm(const Study& study, bool elements) {
  const ArmSection* found = nullptr;
  for (const ArmSection& row : study.arm) {
    if (row.muscle == "biceps_long") found = &row;
  }
  if (!found) return "";
  const std::string begin = "; the biceps of the arm at " + number(found->degrees) + " degrees: ";
  if (elements) {
    return begin + "volume error " + percent(found->elements.volume_error) + ", section " +
           number(found->elements.section) + " times, of constant volume " +
           number(1.0 / (1.0 - found->shortening));
  }
  return begin + "sections " + number(found->ellipsoid.section) + " and " +
         number(found->profile.section) + " times, of constant volume " +
         number(1.0 / (1.0 - found->shortening)) + ", Thew beside its neighbours " +
         number(found->ours.section);
}

RelatedClaim hill_elements(const Study& study) {
  RelatedClaim claim =
      loses(study, "Chen 1992", "finite elements with Hill's fibres lose volume", 1e-3);
  claim.figures += of_the_arm(study, true);
  return claim;
}

RelatedClaim geometric(const Study& study) {
  const std::string claim =
      "ellipsoids and profiles keep their own volume; they move with the joint alone";
  const RelatedRun *ellipsoid = study.best("Scheepers 1997", kFlexed),
                   *profile = study.best("Aubel 2001", kFlexed), *ours = study.best(kOurs, kFlexed);
  if (!ellipsoid || !profile || !ours) return not_run(claim);
  const std::string figures =
      "flexed: volume error " + percent(ellipsoid->volume_error) + " and " +
      percent(profile->volume_error) + ", distance " + percent(ellipsoid->distance) + " and " +
      percent(profile->distance) + ", ours " + percent(ours->distance) +
      "; nothing meets them, so no other scene is theirs" + of_the_arm(study, false);
  const bool kept = std::max(ellipsoid->volume_error, profile->volume_error) < 1e-3;
  return {claim, figures, kept ? "true" : "only where the whole body is the belly"};
}

RelatedClaim large_steps(const Study& study) {
  const std::string claim = "warped stiffness and neo-Hookean elements are stable at large steps";
  const StudiedScene& in = study.scenes[study.scene(kBall)];
  std::string figures = "largest stable step, ms: ";
  bool all = true;
  for (const char* name : {"Mueller 2004", "Smith 2018", "Chen 2024", kOurs}) {
    const double step = in.sweeps[study.method(name)].largest_step;
    if (name != kOurs) all = all && step > 0.9 * in.scene.frame_seconds();
    figures += std::string(name) + " " + number(1e3 * step) + "; ";
  }
  return {claim, figures, all ? "true" : "only some"};
}

}  // namespace

std::vector<RelatedClaim> judge_claims(const Study& study) {
  std::vector<RelatedClaim> all;
  const auto add = [&](const char* source, RelatedClaim claim) {
    claim.source = source;
    if (claim.figures.ends_with("; ")) claim.figures.erase(claim.figures.size() - 2);
    all.push_back(std::move(claim));
  };
  constexpr const char *kPrinted = "printed", *kSense = "paraphrase", *kAuthors = "its authors";
  add(kPrinted, loses(study, "conventional",
                      "a conventional mass-spring system loses its volume (figures 7, 8)", 0.05));
  add(kPrinted, keeps(study, kOurs, "the paper's method keeps it to 0.01 % (table 2)", 1e-4));
  add(kPrinted, near_conventional(study));
  add(kAuthors,
      keeps(study, "Promayon 1997", "Promayon's projection keeps the volume exactly", 1e-9));
  add(kSense, velocities(study));
  add(kSense, pressure(study));
  add(kSense, loses(study, "Nedel 1998", "angular springs do not keep the volume", 0.01));
  add(kSense,
      loses(study, "Bourguignon 2000", "barycentre springs keep it softly, not exactly", 1e-3));
  add(kSense, stiffens(study));
  add(kSense,
      dearer(study, "Hirota 1999", "a lattice that is optimised is ten times dearer", 10.0));
  add(kSense, loses(study, "Hirota 1999", "its penalty leaves some volume error", 1e-6));
  add(kPrinted,
      dearer(study, "linear FEM",
             "finite elements are a hundred times dearer (table 1: 138 to 199 times)", 100.0));
  add(kSense,
      loses(study, "linear FEM", "linear elements with a penalty do not keep the volume", 1e-3));
  add(kSense, loses(study, "Mueller 2004", "warped elements do not keep it either", 1e-3));
  add(kSense, hill_elements(study));
  add(kSense, geometric(study));
  add(kAuthors, large_steps(study));
  add("ours", better_than(study, "of the methods that the paper names none is nearer to a solid",
                          {std::begin(kNamed), std::end(kNamed)}));
  add("ours", better_than(study, "nor of those of today", {std::begin(kToday), std::end(kToday)}));
  return all;
}

}  // namespace thew::tools
