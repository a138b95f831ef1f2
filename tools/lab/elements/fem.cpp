// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/elements/fem.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "tools/base/signals.h"

namespace thew::tools {
namespace {

using Gradients = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 10, 3>;
using Dense = Eigen::MatrixXd;

struct Point {
  double l[4];    // barycentric
  double weight;  // of 1/6, the reference tetrahedron's volume
};

// Exact for cubics (Keast): volumes of quadratic elements are cubics.
const std::vector<Point>& points_of(int order) {
  static const std::vector<Point> kOne = {{{0.25, 0.25, 0.25, 0.25}, 1.0 / 6.0}};
  static const std::vector<Point> kFive = [] {
    std::vector<Point> points = {{{0.25, 0.25, 0.25, 0.25}, -2.0 / 15.0}};
    for (int k = 0; k < 4; ++k) {
      Point p{{1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0}, 3.0 / 40.0};
      p.l[k] = 0.5;
      points.push_back(p);
    }
    return points;
  }();
  return order == 1 ? kOne : kFive;
}

// Derivatives of the shape functions by the reference coordinates l1, l2, l3.
Gradients reference_gradients(int order, const Point& p) {
  Eigen::Matrix<double, 4, 3> dl;
  dl << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  if (order == 1) return dl;
  Gradients g(10, 3);
  for (int k = 0; k < 4; ++k) g.row(k) = (4.0 * p.l[k] - 1.0) * dl.row(k);
  for (int m = 0; m < 6; ++m) {
    const auto [a, b] = kMiddles[m];
    g.row(4 + m) = 4.0 * (p.l[a] * dl.row(b) + p.l[b] * dl.row(a));
  }
  return g;
}

const std::vector<Gradients>& all_gradients(int order) {
  const auto make = [](int o) {
    std::vector<Gradients> out;
    for (const Point& p : points_of(o)) out.push_back(reference_gradients(o, p));
    return out;
  };
  static const std::vector<Gradients> kFirst = make(1), kSecond = make(2);
  return order == 1 ? kFirst : kSecond;
}

// Point i: derivative of x_i by the reference coordinates.
Mat3 jacobian(const FemBody& body, int element, const std::vector<Vec3>& x, const Gradients& g) {
  const int n = body.nodes_per_element();
  Mat3 a = Mat3::Zero();
  for (int k = 0; k < n; ++k) a += x[body.elements[element * n + k]] * g.row(k);
  return a;
}

double element_volume(const FemBody& body, int element, const std::vector<Vec3>& x) {
  double volume = 0.0;
  const auto& points = points_of(body.order);
  for (size_t q = 0; q < points.size(); ++q) {
    volume +=
        points[q].weight * jacobian(body, element, x, all_gradients(body.order)[q]).determinant();
  }
  return volume;
}

// K: linear elasticity lambda tr(e)^2/2 + shear e:e, or shear/2 grad x : grad x.
Dense element_stiffness(const FemBody& body, int element) {
  const int n = body.nodes_per_element();
  Dense k = Dense::Zero(3 * n, 3 * n);
  const auto& points = points_of(body.order);
  const double mu = body.material.shear, lambda = body.material.lambda;
  for (size_t q = 0; q < points.size(); ++q) {
    const Gradients& g = all_gradients(body.order)[q];
    const Mat3 a = jacobian(body, element, body.rest, g);
    const Eigen::MatrixXd d = g * a.inverse();  // by place
    const double w = points[q].weight * a.determinant();
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const Vec3 di = d.row(i), dj = d.row(j);
        Mat3 block = mu * di.dot(dj) * Mat3::Identity();
        if (!body.material.neo_hookean) {
          block += lambda * di * dj.transpose() + mu * dj * di.transpose();
        }
        k.block<3, 3>(3 * i, 3 * j) += w * block;
      }
    }
  }
  return k;
}

void make_pattern(FemBody& body) {
  const int n = body.nodes_per_element(), nodes = static_cast<int>(body.rest.size());
  std::vector<std::vector<int>> near(nodes);
  for (int e = 0; e < body.count(); ++e) {
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b) {
        near[body.elements[e * n + b]].push_back(body.elements[e * n + a]);
      }
    }
  }
  Eigen::VectorXi room(3 * nodes);
  for (int i = 0; i < nodes; ++i) {
    std::sort(near[i].begin(), near[i].end());
    near[i].erase(std::unique(near[i].begin(), near[i].end()), near[i].end());
    room.segment<3>(3 * i).setConstant(3 * static_cast<int>(near[i].size()));
  }
  body.matrix.resize(3 * nodes, 3 * nodes);
  body.matrix.reserve(room);
  for (int i = 0; i < nodes; ++i) {
    for (int k = 0; k < 3; ++k) {
      for (int j : near[i]) {
        for (int r = 0; r < 3; ++r) body.matrix.insert(3 * j + r, 3 * i + k) = 0.0;
      }
    }
  }
  body.matrix.makeCompressed();
  body.slot.clear();
  for (int e = 0; e < body.count(); ++e) {
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b) {
        const auto& column = near[body.elements[e * n + b]];
        body.slot.push_back(3 * static_cast<int>(std::lower_bound(column.begin(), column.end(),
                                                                  body.elements[e * n + a]) -
                                                 column.begin()));
      }
    }
  }
}

// The volume's part of gradient and Hessian; returns J.
double add_volume(FemBody& body, int element, Dense& k, Eigen::VectorXd& gradient) {
  const int n = body.nodes_per_element();
  const auto& points = points_of(body.order);
  const FemMaterial& material = body.material;
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(3 * n);
  double volume = 0.0;
  Mat3 a[5];
  for (size_t q = 0; q < points.size(); ++q) {
    const Gradients& g = all_gradients(body.order)[q];
    a[q] = jacobian(body, element, body.x, g);
    volume += points[q].weight * a[q].determinant();
    Mat3 cofactor;
    for (int i = 0; i < 3; ++i) {
      cofactor.row(i) = a[q].row((i + 1) % 3).cross(a[q].row((i + 2) % 3));
    }
    for (int i = 0; i < n; ++i) {
      slope.segment<3>(3 * i) += points[q].weight * cofactor * g.row(i).transpose();
    }
  }
  const double rest = body.rest_volume[element], j = volume / rest;
  const double pull = material.neo_hookean ? material.shear : 0.0;
  const double pressure = material.penalty * (j - 1.0) - pull;
  k.noalias() = material.penalty / rest * slope * slope.transpose();
  if (material.neo_hookean) {
    // d2 det / dx_ai dx_bj = e_ijk (row k of A) . (g_a x g_b)
    for (size_t q = 0; q < points.size(); ++q) {
      const Gradients& g = all_gradients(body.order)[q];
      for (int m = 0; m < n; ++m) {
        for (int o = 0; o < n; ++o) {
          const Vec3 cross = Vec3(g.row(m)).cross(Vec3(g.row(o)));
          const Vec3 r = pressure * points[q].weight * a[q] * cross;
          Mat3 twist;
          twist << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0;
          k.block<3, 3>(3 * m, 3 * o) += twist;
        }
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    gradient.segment<3>(3 * body.elements[element * n + i]) += pressure * slope.segment<3>(3 * i);
  }
  return j;
}

// Negative directions of an element's matrix are taken out, so that Newton descends.
void keep_positive(Dense& k) {
  Eigen::SelfAdjointEigenSolver<Dense> eigen(k);
  k = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
      eigen.eigenvectors().transpose();
}

Eigen::VectorXd displacement(const FemBody& body) {
  Eigen::VectorXd z(3 * body.rest.size());
  for (size_t i = 0; i < body.rest.size(); ++i) {
    z.segment<3>(3 * i) = body.material.neo_hookean ? body.x[i] : Vec3(body.x[i] - body.rest[i]);
  }
  return z;
}

// Gradient of the energy and its Hessian (Gauss-Newton for the linear body's penalty, so that it
// stays positive). Returns the number of elements turned inside out.
int assemble(FemBody& body, bool positive, Eigen::VectorXd& gradient) {
  double* values = body.matrix.valuePtr();
  const bool neo_hookean = body.material.neo_hookean;
  if (neo_hookean) {
    std::fill(values, values + body.matrix.nonZeros(), 0.0);
  } else {
    std::copy(body.constant.valuePtr(), body.constant.valuePtr() + body.constant.nonZeros(),
              values);
  }
  gradient = body.constant * displacement(body);
  const int n = body.nodes_per_element();
  Dense k(3 * n, 3 * n);
  int inverted = 0;
  for (int e = 0; e < body.count(); ++e) {
    inverted += !(add_volume(body, e, k, gradient) > 0.0);
    if (neo_hookean) {
      k += body.stiffness[e];
      if (positive) keep_positive(k);
    }
    add_block(body, e, k, values);
  }
  return inverted;
}

double energy(const FemBody& body) {
  const Eigen::VectorXd z = displacement(body);
  double sum = 0.5 * z.dot(body.constant * z);
  const FemMaterial& material = body.material;
  for (int e = 0; e < body.count(); ++e) {
    const double change = element_volume(body, e, body.x) / body.rest_volume[e] - 1.0;
    const double pull = material.neo_hookean ? material.shear : 0.0;
    sum += body.rest_volume[e] * change * (0.5 * material.penalty * change - pull);
  }
  return sum;
}

// Conjugate gradients as Newton needs them (Steihaug 1983): they end with what they have where the
// matrix curves down, which descends all the same; the steepest way where that is at once.
Eigen::VectorXd truncated(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& right,
                          double residual) {
  constexpr int kMost = 1000;
  const Eigen::VectorXd scale = matrix.diagonal().cwiseAbs().cwiseInverse();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size()), rest = right;
  Eigen::VectorXd way = scale.cwiseProduct(rest), image(right.size());
  double now = rest.dot(way);
  const double enough = residual * residual * right.squaredNorm();
  for (int k = 0; k < kMost && rest.squaredNorm() > enough; ++k) {
    image.noalias() = matrix.transpose() * way;  // symmetric; by rows
    const double curvature = way.dot(image);
    if (!(curvature > 0.0)) return k > 0 ? x : way;
    x += now / curvature * way;
    rest -= now / curvature * image;
    const Eigen::VectorXd scaled = scale.cwiseProduct(rest);
    const double next = rest.dot(scaled);
    way = scaled + next / now * way;
    now = next;
  }
  return x;
}

// Empty where the matrix is not positive definite.
Eigen::VectorXd solve(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& right,
                      const FemStep& step) {
  if (!step.direct) return truncated(matrix, right, step.residual);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0.0)) return {};
  return factor.solve(right);
}

}  // namespace

void add_block(const FemBody& body, int element, const Eigen::MatrixXd& k, double* values) {
  const int n = body.nodes_per_element();
  const int* outer = body.matrix.outerIndexPtr();
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      const int at = body.slot[(element * n + a) * n + b];
      const int column = 3 * body.elements[element * n + b];
      for (int c = 0; c < 3; ++c) {
        double* to = values + outer[column + c] + at;
        for (int r = 0; r < 3; ++r) to[r] += k(3 * a + r, 3 * b + c);
      }
    }
  }
}

void prepare(FemBody& body) {
  if (body.x.empty()) body.x = body.rest;
  body.v.resize(body.rest.size(), Vec3::Zero());
  body.fixed.resize(3 * body.rest.size(), 0);
  body.surface.resize(body.rest.size(), 0);
  body.mass.assign(body.rest.size(), 0.0);
  body.rest_volume.clear();
  body.stiffness.clear();
  make_pattern(body);
  double* values = body.matrix.valuePtr();
  std::fill(values, values + body.matrix.nonZeros(), 0.0);
  const int n = body.nodes_per_element();
  for (int e = 0; e < body.count(); ++e) {
    body.rest_volume.push_back(element_volume(body, e, body.rest));
    for (int k = 0; k < n; ++k) {
      body.mass[body.elements[e * n + k]] += body.material.density * body.rest_volume[e] / n;
    }
    const Dense k = element_stiffness(body, e);
    add_block(body, e, k, values);
    body.stiffness.push_back(k);
  }
  body.constant = body.matrix;
}

double fem_volume(const FemBody& body) {
  double volume = 0.0;
  for (int e = 0; e < body.count(); ++e) volume += element_volume(body, e, body.x);
  return volume;
}

namespace {

// What a step adds to the body's own energy: inertia, drag, load, planes.
struct StepTerms {
  const FemBody& body;
  const FemStep& step;
  std::vector<Vec3> start, guess;
  double inertia, drag;

  // m, outside the planes, along the direction in which that grows.
  Vec3 beyond(int i) const {
    if (step.obstacle) return step.obstacle(body.x[i]);
    const double x = body.x[i].x(), y = body.x[i].y();
    const double depth = y > step.high ? y - step.high : y < step.low ? y - step.low : 0.0;
    if (depth == 0.0 || x <= step.edge) return {0.0, depth, 0.0};
    const double round = step.rounding;
    const Vec3 out(x - step.edge, std::copysign(std::min(std::abs(depth) - round, 0.0), -depth), 0);
    return std::min(1.0 - round / out.norm(), 0.0) * out;
  }

  double energy() const {
    double sum = 0.0;
    for (size_t i = 0; i < body.x.size(); ++i) {
      sum += 0.5 * body.mass[i] *
             (inertia * (body.x[i] - guess[i]).squaredNorm() +
              drag * (body.x[i] - start[i]).squaredNorm());
      if (!body.load.empty()) sum -= body.load[i].dot(body.x[i]);
      if (body.surface[i]) sum += 0.5 * step.firmness * beyond(i).squaredNorm();
    }
    return sum;
  }

  // Without the edge's curvature, so that the matrix stays positive.
  void add_plane(int i, Eigen::SparseMatrix<double>& matrix, Eigen::VectorXd& gradient) const {
    const Vec3 depth = beyond(i);
    if (depth.isZero(0.0)) return;
    gradient.segment<3>(3 * i) += step.firmness * depth;
    const Vec3 n = depth.normalized();
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        if (n[a] * n[b] == 0.0) continue;
        matrix.coeffRef(3 * i + a, 3 * i + b) += step.firmness * n[a] * n[b];
      }
    }
  }

  void add(Eigen::SparseMatrix<double>& matrix, Eigen::VectorXd& gradient) const {
    for (size_t i = 0; i < body.x.size(); ++i) {
      const double m = body.mass[i];
      gradient.segment<3>(3 * i) +=
          m * (inertia * (body.x[i] - guess[i]) + drag * (body.x[i] - start[i]));
      if (!body.load.empty()) gradient.segment<3>(3 * i) -= body.load[i];
      if (body.surface[i]) add_plane(static_cast<int>(i), matrix, gradient);
      for (size_t d = 3 * i; d < 3 * i + 3; ++d) {
        matrix.coeffRef(d, d) += m * (inertia + drag);
        if (!body.fixed[d]) continue;
        matrix.coeffRef(d, d) *= 1e9;
        gradient[d] = 0.0;
      }
    }
  }
};

}  // namespace

FemResult solve_step(FemBody& body, const FemStep& step) {
  FemResult result;
  const int nodes = static_cast<int>(body.rest.size());
  StepTerms terms{body, step, body.x, body.x, 0.0, 0.0};
  if (step.h > 0.0) {
    terms.inertia = 1.0 / (step.h * step.h);
    terms.drag = step.damping / step.h;
    for (int i = 0; i < nodes; ++i) terms.guess[i] += step.h * body.v[i];
  }
  Eigen::VectorXd gradient;
  double before = energy(body) + terms.energy();
  while (result.iterations < step.iterations && !result.converged) {
    stop_if_interrupted();
    ++result.iterations;
    Eigen::VectorXd way;
    for (bool positive : {false, true}) {  // Newton's own matrix where it descends
      result.inverted = assemble(body, positive, gradient);
      terms.add(body.matrix, gradient);
      way = solve(body.matrix, -gradient, step);
      if (way.size() > 0) break;
    }
    if (way.size() == 0) break;
    result.correction = way.cwiseAbs().maxCoeff();
    if (!std::isfinite(result.correction)) break;
    const double slope = gradient.dot(way);
    const std::vector<Vec3> from = body.x;
    bool descends = false;
    for (double part = 1.0; part > 1e-4 && !descends; part *= 0.5) {
      for (int i = 0; i < nodes; ++i) body.x[i] = from[i] + part * way.segment<3>(3 * i);
      const double after = energy(body) + terms.energy();
      descends = after <= before + 1e-4 * part * slope + 1e-12 * std::abs(before);
      if (descends) before = after;
    }
    if (!descends) {
      body.x = from;
      break;
    }
    result.converged = result.correction < step.tolerance;
  }
  for (int i = 0; i < nodes; ++i) {
    if (step.h > 0.0) body.v[i] = (body.x[i] - terms.start[i]) / step.h;
    if (body.surface[i]) {
      result.penetration = std::max(result.penetration, terms.beyond(i).norm());
    }
  }
  return result;
}

}  // namespace thew::tools
