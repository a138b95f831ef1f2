// SPDX-License-Identifier: Apache-2.0
//
// What is wrong in print, shown on meshes of ours: the sidebar's factor, the weights missing in the
// denominator, the missing pi, the ghost force of weights on a free body.
#include <cmath>

#include "muscles/volume.h"
#include "muscles/weights.h"
#include "muscles/zone.h"
#include "rig/import/mesh_import.h"
#include "tools/lab/paper/report.h"
#include "tools/lab/paper/run.h"

namespace thew::tools {
namespace {

double dot(const Points& a, const Points& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += to_vec(a[i]).dot(to_vec(b[i]));
  return sum;
}

// Relative volume errors, one a step, of x <- x + s d with d = W G: s over G W G or, as printed,
// over G G; the gradient times `factor`.
std::vector<double> errors_by_step(const TriMesh& mesh, const std::vector<double>& weights,
                                   bool printed, double factor, int steps) {
  Points x = to_points(mesh.vertices), g;
  const double wanted = enclosed_volume(x, mesh.triangles);
  const Vec3 centre = to_vec(x[0]);
  for (Point& p : x) p = to_point(centre) + 0.983 * (p - to_point(centre));  // 5 % too small
  std::vector<double> errors;
  for (int step = 0; step <= steps; ++step) {
    const double error = enclosed_volume(x, mesh.triangles) / wanted - 1.0;
    errors.push_back(error);
    if (std::abs(error) > 10.0) break;
    volume_gradient(x, mesh.triangles, g);
    Points d = g;
    for (size_t i = 0; i < d.size(); ++i) {
      g[i] *= factor;
      d[i] = weights[i] * g[i];
    }
    const double s = -error * wanted / (printed ? dot(g, g) : dot(g, d));
    for (size_t i = 0; i < x.size(); ++i) x[i] += s * d[i];
  }
  return errors;
}

std::string percents(const std::vector<double>& errors) {
  std::string text;
  for (double e : errors) text += (text.empty() ? "" : ", ") + number(100.0 * e, 2) + " %";
  return text;
}

// Weights about the middle of the longest extent, as an artist paints a belly.
std::vector<double> belly_weights(const TriMesh& mesh) {
  const Bounds bounds = bounds_of(mesh.vertices);
  const Vec3 low = bounds.low, high = bounds.high;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::vector<double> weights;
  for (const Vec3& p : mesh.vertices) {
    const double from_middle = std::abs(2.0 * (p[axis] - low[axis]) / (high - low)[axis] - 1.0);
    weights.push_back(zone_weight(from_middle, 0.6));
  }
  return normalised_weights(weights, std::vector<char>(weights.size(), 0));
}

void add_sidebar(const TriMesh& cow, Table& table) {
  const std::vector<double> even(cow.vertices.size(), 1.0);
  Points x = to_points(cow.vertices), g;
  const double volume = enclosed_volume(x, cow.triangles);
  volume_gradient(x, cow.triangles, g);
  table.rows.push_back({"sidebar A: x . dV/dx over V (3 by Euler's identity)",
                        number(-3.0 * dot(x, g) / volume), number(dot(x, g) / volume)});
  table.rows.push_back({"sidebar A: the error step by step, which grows by 4/3",
                        percents(errors_by_step(cow, even, false, -3.0, 4)),
                        percents(errors_by_step(cow, even, false, 1.0, 4))});
}

void add_weights(const std::string& name, const TriMesh& mesh, Table& table) {
  const std::vector<double> weights = belly_weights(mesh);
  Points g, d;
  volume_gradient(to_points(mesh.vertices), mesh.triangles, g);
  d = g;
  for (size_t i = 0; i < d.size(); ++i) d[i] *= weights[i];
  table.rows.push_back(
      {"weights missing in the denominator, " + name + ", rho = " + number(dot(g, d) / dot(g, g)),
       percents(errors_by_step(mesh, weights, true, 1.0, 5)),
       percents(errors_by_step(mesh, weights, false, 1.0, 5))});
}

void add_zone(Table& table) {
  const double r = 1.0, d = 0.77;
  table.rows.push_back(
      {"eq. 15 without pi: weight at 0.77 r, and at r where the zone ends",
       number(0.5 * (std::cos(d / r) + 1.0)) + ", " + number(0.5 * (std::cos(1.0) + 1.0)),
       number(zone_weight(d, r)) + ", " + number(zone_weight(r * (1 - 1e-12), r), 2)});
}

// Weights about the first vertex, which leave a net force.
void add_ghost_force(const TriMesh& cow, Table& table) {
  Points x = to_points(cow.vertices), g;
  volume_gradient(x, cow.triangles, g);
  std::vector<double> mass(x.size(), 1.0), near_head;
  for (const Vec3& p : cow.vertices) {
    near_head.push_back(zone_weight((p - cow.vertices[0]).norm(), 0.3));
  }
  const std::vector<double> head =
      normalised_weights(near_head, std::vector<char>(near_head.size(), 0));
  Points d = g;
  Point net = {};
  double size = 0.0;
  for (size_t i = 0; i < d.size(); ++i) {
    d[i] *= head[i];
    net += d[i];
    size += to_vec(d[i]).norm();
  }
  remove_net_motion(x, mass, d);
  Point left = {};
  for (const Point& row : d) left += row;
  table.rows.push_back({"ghost force of local weights on a free body, share of all forces",
                        number(to_vec(net).norm() / size), number(to_vec(left).norm() / size, 2)});
}

}  // namespace

void paper_errors(PaperReport& report) {
  report.section("What is wrong in print",
                 "Each formula as printed, and mended, on the cow: a volume 5 % too small is "
                 "corrected again and again.");
  const TriMesh cow = import_closed_mesh(report.scenes / "cow.obj");
  Table table{"printed_errors.csv", "Printed errors", "", {"what", "as printed", "mended"}, {}};
  add_sidebar(cow, table);
  add_weights("cow", cow, table);
  add_weights("the arm's biceps",
              import_closed_mesh(report.scenes / "../arm/muscles/biceps_long.obj"), table);
  const std::filesystem::path biceps = report.scenes / "../../../shared/data/biceps.stl";
  if (std::filesystem::exists(biceps)) {
    TriMesh mesh = import_mesh(biceps).mesh;  // in millimetres
    for (Vec3& p : mesh.vertices) p *= 1e-3;
    add_weights("biceps.stl", mesh, table);
  }
  add_zone(table);
  add_ghost_force(cow, table);
  report.add(table);
  report.done();
}

}  // namespace thew::tools
