// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/methods.h"

#include "tools/lab/base/table.h"
#include "tools/lab/rivals/aubel.h"
#include "tools/lab/rivals/bourguignon.h"
#include "tools/lab/rivals/chen_zeltzer.h"
#include "tools/lab/rivals/descent.h"
#include "tools/lab/rivals/hirota.h"
#include "tools/lab/rivals/multiplier.h"
#include "tools/lab/rivals/nedel.h"
#include "tools/lab/rivals/promayon.h"
#include "tools/lab/rivals/scheepers.h"
#include "tools/lab/rivals/zordan.h"

namespace thew::tools {
namespace {

constexpr double kShear = 1000.0, kYoung = 3.0 * kShear;  // Pa, incompressible

using Make = std::function<Stepper(const RivalBody&, double)>;

Make zordan(double modulus) {
  return [=](const RivalBody& b, double drag) { return zordan_stepper(b, drag, modulus); };
}
Make nedel(double stiffness) {
  return [=](const RivalBody& b, double drag) { return nedel_stepper(b, drag, stiffness); };
}
Make bourguignon(double stiffness) {
  return [=](const RivalBody& b, double drag) {
    return bourguignon_stepper(b, drag, kYoung, stiffness);
  };
}
Make elements(const FemMaterial& material) {
  return [=](const RivalBody& b, double drag) {
    return element_stepper(b, {material, drag, 8, false});
  };
}
Make warped(double lambda) {
  return [=](const RivalBody& b, double drag) {
    return warped_stepper(b, {.shear = kShear, .lambda = lambda, .penalty = 0.0}, drag);
  };
}
Make chen_zeltzer(double lambda) {
  return [=](const RivalBody& b, double drag) {
    return chen_zeltzer_stepper(b, {.shear = kShear, .lambda = lambda, .penalty = 0.0}, drag,
                                HillFibres{});
  };
}
Make descent(double penalty, int iterations) {
  return [=](const RivalBody& b, double drag) {
    return descent_stepper(b, {.neo_hookean = true, .shear = kShear, .penalty = penalty}, drag,
                           iterations);
  };
}
Make hirota(int cells, double modulus) {
  return [=](const RivalBody& b, double) {
    return hirota_stepper(b, {.cells = cells, .young = kYoung, .modulus = modulus});
  };
}

std::function<double(const RivalBody&, const Vec3&)> lattice_energy(int cells, double modulus) {
  return [=](const RivalBody& b, const Vec3& stretch) {
    return stretched_energy(b, {.cells = cells, .young = kYoung, .modulus = modulus}, stretch);
  };
}

std::string pascals(const char* what, double value) {
  return std::string(what) + " " + number(value) + " Pa";
}

std::vector<RelatedMethod> surfaces() {
  RelatedMethod none{"conventional", "springs, nothing for the volume", false};
  none.dials = {{"", zordan(0.0), zordan(0.0)}};
  RelatedMethod multiplier{kOurs, "the exact multiplier, obstacles as the others'", false};
  multiplier.dials = {{"",
                       [](const RivalBody& b, double drag) { return multiplier_stepper(b, drag); },
                       zordan(0.0)}};
  RelatedMethod promayon{"Promayon 1997", "projection along the volume's gradient", false};
  for (const bool reaction : {true, false}) {
    promayon.dials.push_back(
        {reaction ? "reaction in the velocities" : kUnaware,
         [=](const RivalBody& b, double drag) { return promayon_stepper(b, drag, reaction); },
         zordan(0.0)});
  }
  RelatedMethod pressure{"Zordan 2004", "pressure by the missing volume", false};
  for (const double modulus : {1e5, 1e4, 1e6, 1e7}) {
    pressure.dials.push_back({pascals("modulus", modulus), zordan(modulus), zordan(0.0)});
  }
  RelatedMethod angular{"Nedel 1998", "angular springs", false};
  for (const double stiffness : {1e-3, 1e-2}) {
    angular.dials.push_back({number(stiffness) + " N m", nedel(stiffness), nedel(0.0)});
  }
  return {none, multiplier, promayon, pressure, angular};
}

std::vector<RelatedMethod> solids() {
  RelatedMethod barycentre{"Bourguignon 2000", "springs to barycentres", true};
  for (const double stiffness : {100.0, 10.0}) {
    barycentre.dials.push_back(
        {number(stiffness) + " N/m", bourguignon(stiffness), bourguignon(0.0)});
  }
  RelatedMethod linear{"linear FEM", "linear elements, penalty on the volume", true};
  const FemMaterial elastic{.shear = kShear, .lambda = kShear, .penalty = 1e5};
  FemMaterial loose = elastic;
  loose.penalty = 0.0;
  linear.dials = {{pascals("penalty", 1e5), elements(elastic), elements(loose)}};
  linear.implicit = true;
  RelatedMethod turned{"Mueller 2004", "warped stiffness", true};
  for (const double lambda : {1e4, 1e5}) {
    turned.dials.push_back({pascals("Lame", lambda), warped(lambda), warped(0.0)});
  }
  turned.implicit = true;
  RelatedMethod flesh{"Smith 2018", "stable neo-Hookean elements", true};
  const FemMaterial soft{.neo_hookean = true, .shear = kShear, .penalty = 1e4};
  FemMaterial hard = soft, compressible = soft;
  hard.penalty = 1e5;
  compressible.penalty = 0.0;
  flesh.dials = {{pascals("Lame", 1e4), elements(soft), elements(compressible)},
                 {pascals("Lame", 1e5), elements(hard), elements(compressible)}};
  flesh.implicit = true;
  RelatedMethod blocks{"Chen 2024", "vertex block descent on the same elements", true};
  for (const int iterations : {5, 50}) {
    blocks.dials.push_back({pascals("Lame", 1e4) + ", " + std::to_string(iterations) + " passes",
                            descent(1e4, iterations), descent(0.0, iterations)});
  }
  return {barycentre, linear, turned, flesh, blocks};
}

}  // namespace

std::vector<RelatedMethod> related_methods(bool quick) {
  std::vector<RelatedMethod> all = surfaces();
  for (RelatedMethod& method : solids()) all.push_back(std::move(method));
  RelatedMethod lattice{"Hirota 1999", "free-form lattice, energy minimised"};
  lattice.has_step = false;
  for (const int cells : {4, 8}) {
    lattice.dials.push_back({std::to_string(cells) + " cells a side",
                             hirota(cells, 1e6),
                             {},
                             lattice_energy(cells, 1e6),
                             lattice_energy(cells, 0.0)});
  }
  all.push_back(lattice);
  RelatedMethod hill{"Chen 1992", "linear elements with Hill's fibres", true};
  hill.implicit = true;
  hill.of = "flexed";
  hill.dials = {{pascals("Lame", 1e5), chen_zeltzer(1e5), chen_zeltzer(0.0)}};
  all.push_back(hill);
  RelatedMethod ellipsoid{"Scheepers 1997", "ellipsoid of constant volume"};
  RelatedMethod profile{"Aubel 2001", "sections on an action line"};
  ellipsoid.has_step = profile.has_step = ellipsoid.meets = profile.meets = false;
  ellipsoid.of = profile.of = "flexed";
  ellipsoid.dials = {{"", [](const RivalBody& b, double) { return scheepers_stepper(b); }}};
  profile.dials = {{"", [](const RivalBody& b, double) { return aubel_stepper(b); }}};
  all.push_back(ellipsoid);
  all.push_back(profile);
  if (quick) {
    for (RelatedMethod& method : all) method.dials.resize(std::min<size_t>(1, method.dials.size()));
  }
  return all;
}

}  // namespace thew::tools
