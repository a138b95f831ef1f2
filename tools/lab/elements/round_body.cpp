// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/elements/round_body.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <map>

#include "tools/base/signals.h"

namespace thew::tools {
namespace {

using Place = RoundBody::Place;
using Block = Eigen::Matrix<double, 12, 12>;  // r and z of six nodes, by turns
using Slope = Eigen::Matrix<double, 12, 1>;

constexpr double kTurn = 6.28318530717958647693;
constexpr double kFirmness = 2.5e9;  // Pa/m of obstacles

struct Sample {
  double weight, n[6], a[6], b[6];  // shape functions and their derivatives
};

// Dunavant's seven points, exact for quintics: an element's volume is a quartic.
const std::vector<Sample>& samples() {
  static const std::vector<Sample> kAll = [] {
    std::vector<Sample> out;
    const auto add = [&](double l1, double l2, double weight) {
      const double l0 = 1.0 - l1 - l2;
      out.push_back({0.5 * weight,
                     {l0 * (2 * l0 - 1), l1 * (2 * l1 - 1), l2 * (2 * l2 - 1), 4 * l0 * l1,
                      4 * l1 * l2, 4 * l2 * l0},
                     {1 - 4 * l0, 4 * l1 - 1, 0, 4 * (l0 - l1), 4 * l2, -4 * l2},
                     {1 - 4 * l0, 0, 4 * l2 - 1, -4 * l1, 4 * l1, 4 * (l0 - l2)}});
    };
    add(1.0 / 3.0, 1.0 / 3.0, 0.225);
    for (const double sign : {-1.0, 1.0}) {
      const double l = (6.0 + sign * std::sqrt(15.0)) / 21.0;
      const double weight = (155.0 + sign * std::sqrt(15.0)) / 1200.0;
      add(l, l, weight);
      add(1.0 - 2.0 * l, l, weight);
      add(l, 1.0 - 2.0 * l, weight);
    }
    return out;
  }();
  return kAll;
}

struct Local {
  double r = 0.0, ra = 0.0, rb = 0.0, za = 0.0, zb = 0.0;
  double det() const { return ra * zb - rb * za; }
};
Local local_at(const Sample& s, const std::array<int, 6>& element, const std::vector<Place>& x) {
  Local out;
  for (int k = 0; k < 6; ++k) {
    const auto& [r, z] = x[element[k]];
    out.r += s.n[k] * r;
    out.ra += s.a[k] * r;
    out.rb += s.b[k] * r;
    out.za += s.a[k] * z;
    out.zb += s.b[k] * z;
  }
  return out;
}

double ring_volume(const std::array<int, 6>& element, const std::vector<Place>& x) {
  double volume = 0.0;
  for (const Sample& s : samples()) {
    const Local at = local_at(s, element, x);
    volume += kTurn * s.weight * at.r * at.det();
  }
  return volume;
}

// shear/2 F:F, F = grad x in the section and r / R around: quadratic in x.
Block elastic_block(const RoundBody& body, const std::array<int, 6>& element) {
  Block k = Block::Zero();
  for (const Sample& s : samples()) {
    const Local at = local_at(s, element, body.rest);
    const double w = body.shear * kTurn * s.weight * at.r * at.det();
    double dr[6], dz[6];
    for (int i = 0; i < 6; ++i) {
      dr[i] = (s.a[i] * at.zb - s.b[i] * at.za) / at.det();
      dz[i] = (s.b[i] * at.ra - s.a[i] * at.rb) / at.det();
    }
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        const double flat = w * (dr[i] * dr[j] + dz[i] * dz[j]);
        k(2 * i, 2 * j) += flat + w * s.n[i] * s.n[j] / (at.r * at.r);
        k(2 * i + 1, 2 * j + 1) += flat;
      }
    }
  }
  return k;
}

// Gradient and Hessian of a ring's volume, a cubic of its nodes.
double volume_block(const std::array<int, 6>& element, const std::vector<Place>& x, Slope& slope,
                    Block& bend) {
  slope.setZero();
  bend.setZero();
  double volume = 0.0;
  for (const Sample& s : samples()) {
    const Local at = local_at(s, element, x);
    const double w = kTurn * s.weight;
    volume += w * at.r * at.det();
    double by_r[6], by_z[6];  // of the determinant
    for (int i = 0; i < 6; ++i) {
      by_r[i] = s.a[i] * at.zb - s.b[i] * at.za;
      by_z[i] = at.ra * s.b[i] - at.rb * s.a[i];
    }
    for (int i = 0; i < 6; ++i) {
      slope[2 * i] += w * (s.n[i] * at.det() + at.r * by_r[i]);
      slope[2 * i + 1] += w * at.r * by_z[i];
      for (int j = 0; j < 6; ++j) {
        bend(2 * i, 2 * j) += w * (s.n[i] * by_r[j] + s.n[j] * by_r[i]);
        const double mixed = w * (s.n[i] * by_z[j] + at.r * (s.a[i] * s.b[j] - s.b[i] * s.a[j]));
        bend(2 * i, 2 * j + 1) += mixed;
        bend(2 * j + 1, 2 * i) += mixed;
      }
    }
  }
  return volume;
}

using Triplets = std::vector<Eigen::Triplet<double>>;
void add_block(const std::array<int, 6>& element, const Block& k, Triplets& out) {
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      out.emplace_back(2 * element[i / 2] + i % 2, 2 * element[j / 2] + j % 2, k(i, j));
    }
  }
}

Eigen::VectorXd flat(const std::vector<Place>& x) {
  return Eigen::Map<const Eigen::VectorXd>(x.data()->data(),
                                           2 * static_cast<Eigen::Index>(x.size()));
}

using Beyond = std::function<Place(const Place&)>;

double energy_of(const Beyond& beyond, const RoundBody& body) {
  const Eigen::VectorXd x = flat(body.x);
  double sum = 0.5 * x.dot(body.elastic * x);
  for (size_t e = 0; e < body.elements.size(); ++e) {
    const double change = ring_volume(body.elements[e], body.x) / body.rest_volume[e] - 1.0;
    sum += body.rest_volume[e] * change * (0.5 * body.penalty * change - body.shear);
  }
  for (size_t k = 0; beyond && k < body.rim.size(); ++k) {
    const auto [r, z] = beyond(body.x[body.rim[k]]);
    sum += 0.5 * kFirmness * body.rim_area[k] * (r * r + z * z);
  }
  return sum;
}

// Triplets of the Hessian without the elastic part; `positive`: each element's made so, with it.
void assemble(const Beyond& beyond, const RoundBody& body, bool positive, Triplets& hessian,
              Eigen::VectorXd& gradient) {
  hessian.clear();
  gradient = body.elastic * flat(body.x);
  Slope slope;
  Block bend;
  for (size_t e = 0; e < body.elements.size(); ++e) {
    const auto& element = body.elements[e];
    const double rest = body.rest_volume[e];
    const double change = volume_block(element, body.x, slope, bend) / rest - 1.0;
    const double pressure = body.penalty * change - body.shear;
    Block k = body.penalty / rest * slope * slope.transpose() + pressure * bend;
    if (positive) {
      const Block elastic = elastic_block(body, element);
      const Eigen::SelfAdjointEigenSolver<Block> eigen(k + elastic);
      k = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
          eigen.eigenvectors().transpose();
      k -= elastic;
    }
    for (int i = 0; i < 12; ++i) gradient[2 * element[i / 2] + i % 2] += pressure * slope[i];
    add_block(element, k, hessian);
  }
  for (size_t k = 0; beyond && k < body.rim.size(); ++k) {
    const int node = body.rim[k];
    const Place depth = beyond(body.x[node]);
    const double size = std::hypot(depth[0], depth[1]);
    if (size == 0.0) continue;
    for (int i = 0; i < 2; ++i) {
      gradient[2 * node + i] += kFirmness * body.rim_area[k] * depth[i];
      for (int j = 0; j < 2; ++j) {
        hessian.emplace_back(2 * node + i, 2 * node + j,
                             kFirmness * body.rim_area[k] * depth[i] * depth[j] / (size * size));
      }
    }
  }
}

// Newton's way; empty: the matrix is not positive.
Eigen::VectorXd way_of(const RoundBody& body, const Triplets& hessian, Eigen::VectorXd gradient) {
  Eigen::SparseMatrix<double> matrix(gradient.size(), gradient.size());
  matrix.setFromTriplets(hessian.begin(), hessian.end());
  matrix += body.elastic;
  for (size_t i = 0; i < body.x.size(); ++i) {
    for (int k = 0; k < 2; ++k) {
      if (!body.fixed[i][k]) continue;
      const Eigen::Index at = 2 * static_cast<Eigen::Index>(i) + k;
      matrix.coeffRef(at, at) += 1e9 * body.shear;
      gradient[at] = 0.0;
    }
  }
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0.0)) return {};
  return factor.solve(-gradient);
}

}  // namespace

void prepare(RoundBody& body) {
  if (body.x.empty()) body.x = body.rest;
  const Eigen::Index size = 2 * static_cast<Eigen::Index>(body.rest.size());
  Triplets triplets;
  for (const auto& element : body.elements) {
    body.rest_volume.push_back(ring_volume(element, body.rest));
    add_block(element, elastic_block(body, element), triplets);
  }
  body.elastic.resize(size, size);
  body.elastic.setFromTriplets(triplets.begin(), triplets.end());
  body.rim_area.assign(body.rim.size(), 0.0);
  for (size_t k = 0; k + 2 < body.rim.size(); k += 2) {
    const Place &a = body.rest[body.rim[k]], &m = body.rest[body.rim[k + 1]],
                &b = body.rest[body.rim[k + 2]];
    const double area = kTurn * m[0] * std::hypot(b[0] - a[0], b[1] - a[1]);
    for (int j = 0; j < 3; ++j) body.rim_area[k + j] += area * (j == 1 ? 4.0 : 1.0) / 6.0;
  }
}

bool rest_round(const Beyond& beyond, double tolerance, RoundBody& body) {
  Triplets hessian;
  Eigen::VectorXd gradient;
  double before = energy_of(beyond, body);
  for (int iteration = 0; iteration < 100; ++iteration) {
    stop_if_interrupted();
    Eigen::VectorXd way;
    for (const bool positive : {false, true}) {
      assemble(beyond, body, positive, hessian, gradient);
      way = way_of(body, hessian, gradient);
      if (way.size() > 0) break;
    }
    if (way.size() == 0 || !way.allFinite()) return false;
    for (size_t i = 0; i < body.x.size(); ++i) {
      for (int k = 0; k < 2; ++k) {
        if (body.fixed[i][k]) way[2 * i + k] = gradient[2 * i + k] = 0.0;
      }
    }
    const double slope = gradient.dot(way);
    const std::vector<Place> from = body.x;
    double after = before;
    for (double part = 1.0; part > 1e-4; part *= 0.5) {
      for (size_t i = 0; i < from.size(); ++i) {
        for (int k = 0; k < 2; ++k) body.x[i][k] = from[i][k] + part * way[2 * i + k];
      }
      after = energy_of(beyond, body);
      if (after <= before + 1e-4 * part * slope + 1e-12 * std::abs(before)) break;
    }
    before = after;
    if (way.cwiseAbs().maxCoeff() < tolerance) return true;
  }
  return false;
}

double volume_of(const RoundBody& body) {
  double volume = 0.0;
  for (const auto& element : body.elements) volume += ring_volume(element, body.x);
  return volume;
}

std::vector<Place> rim_line(const RoundBody& body, int parts) {
  std::vector<Place> line = {body.x[body.rim.front()]};
  for (size_t k = 0; k + 2 < body.rim.size(); k += 2) {
    for (int p = 1; p <= parts; ++p) {
      const double t = static_cast<double>(p) / parts;
      const double n[3] = {(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)};
      Place& at = line.emplace_back(Place{0.0, 0.0});
      for (int j = 0; j < 3; ++j) {
        for (int c = 0; c < 2; ++c) at[c] += n[j] * body.x[body.rim[k + j]][c];
      }
    }
  }
  return line;
}

namespace {

using Lattice2 = std::array<int, 2>;

// Adds triangles of a lattice, twice as fine as they are, that `place` puts into the section.
struct Mesher {
  RoundBody body = {};
  std::map<Lattice2, int> index = {};
  std::function<Place(const Lattice2&)> place;

  int node(const Lattice2& at) {
    const auto [found, added] = index.try_emplace(at, static_cast<int>(body.rest.size()));
    if (added) {
      body.rest.push_back(place(at));
      const Place& p = body.rest.back();
      body.fixed.push_back({p[0] == 0.0, p[1] == 0.0});
    }
    return found->second;
  }
  void add(const Lattice2& a, const Lattice2& b, const Lattice2& c) {
    const auto middle = [](const Lattice2& p, const Lattice2& q) {
      return Lattice2{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2};
    };
    body.elements.push_back(
        {node(a), node(b), node(c), node(middle(a, b)), node(middle(b, c)), node(middle(c, a))});
  }
};

}  // namespace

RoundBody round_ellipsoid(double across, double along, int n) {
  Mesher mesher;
  mesher.place = [=](const Lattice2& at) {
    // What lies at distance s in the sum norm goes to s in the Euclidean.
    const double i = at[0], j = at[1], length = std::hypot(i, j);
    const double scale = length > 0.0 ? (i + j) / (2.0 * n * length) : 0.0;
    return Place{across * scale * i, along * scale * j};
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      const int r = 2 * i, z = 2 * j;
      mesher.add({r, z}, {r + 2, z}, {r, z + 2});
      if (i + j + 1 < n) mesher.add({r + 2, z}, {r + 2, z + 2}, {r, z + 2});
    }
  }
  for (int i = 0; i <= 2 * n; ++i) mesher.body.rim.push_back(mesher.node({i, 2 * n - i}));
  prepare(mesher.body);
  return mesher.body;
}

RoundBody round_spindle(double across, double along, double held, int n, int m) {
  Mesher mesher;
  mesher.place = [=](const Lattice2& at) {
    const double z = held * at[1] / (2 * m), u = z / along;
    return Place{across * std::sqrt(1.0 - u * u) * at[0] / (2 * n), z};
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      const int r = 2 * i, z = 2 * j;
      mesher.add({r, z}, {r + 2, z}, {r, z + 2});
      mesher.add({r + 2, z}, {r + 2, z + 2}, {r, z + 2});
    }
  }
  for (int i = 0; i <= 2 * n; ++i) mesher.body.fixed[mesher.node({i, 2 * m})] = {1, 1};
  for (int j = 0; j <= 2 * m; ++j) mesher.body.rim.push_back(mesher.node({2 * n, j}));
  prepare(mesher.body);
  return mesher.body;
}

}  // namespace thew::tools
