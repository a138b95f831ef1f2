// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/warped.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <memory>

namespace thew::tools {
namespace {

// The rotation nearest to a deformation, never a reflection.
Mat3 rotation_of(const Mat3& f) {
  const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) *= -1.0;
  return u * svd.matrixV().transpose();
}

Mat3 sides(const FemBody& body, int e, const std::vector<Vec3>& x) {
  Mat3 out;
  const int* const node = body.elements.data() + 4 * e;
  for (int k = 0; k < 3; ++k) out.col(k) = x[node[k + 1]] - x[node[0]];
  return out;
}

// What obstacles add: a stiffness along the normal where a node would be inside.
int add_obstacles(const std::function<Vec3(const Vec3&)>& beyond, const FemBody& body,
                  const Eigen::VectorXd& way, double h, Eigen::SparseMatrix<double>& a,
                  Eigen::VectorXd& right) {
  int touched = 0;
  for (size_t i = 0; i < body.x.size(); ++i) {
    if (!body.surface[i]) continue;
    const Vec3 depth = beyond(body.x[i] + way.segment<3>(3 * i));
    if (depth.isZero(0.0)) continue;
    ++touched;
    const Vec3 n = depth.normalized();
    const double gap = n.dot(way.segment<3>(3 * i)) - depth.norm();  // way that is still free
    for (int r = 0; r < 3; ++r) {
      right[3 * i + r] += h * h * kFirmness * gap * n[r];
      for (int c = 0; c < 3; ++c)
        a.coeffRef(3 * i + r, 3 * i + c) += h * h * kFirmness * n[r] * n[c];
    }
  }
  return touched;
}

}  // namespace

void warped_forces(FemBody& body, bool turned, WarpedForces& out) {
  if (out.k.nonZeros() == 0) out.k = body.matrix;
  std::fill(out.k.valuePtr(), out.k.valuePtr() + out.k.nonZeros(), 0.0);
  out.f.setZero(3 * static_cast<Eigen::Index>(body.rest.size()));
  Eigen::MatrixXd block(12, 12);
  for (int e = 0; e < body.count(); ++e) {
    const int* const node = body.elements.data() + 4 * e;
    const Mat3 turn =
        turned ? rotation_of(sides(body, e, body.x) * sides(body, e, body.rest).inverse())
               : Mat3::Identity();
    const Eigen::MatrixXd& k = body.stiffness[e];
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        const Mat3 part = turn * k.block<3, 3>(3 * a, 3 * b);
        out.f.segment<3>(3 * node[a]) -=
            part * (turn.transpose() * body.x[node[b]] - body.rest[node[b]]);
        block.block<3, 3>(3 * a, 3 * b) = part * turn.transpose();
      }
    }
    add_block(body, e, block, out.k.valuePtr());
  }
}

Stepper warped_stepper(const RivalBody& start, const FemMaterial& material, double drag,
                       bool turned, const ActiveForces& active) {
  const auto body = std::make_shared<FemBody>(elements_of(start, material));
  return [body, drag, turned, active, forces = WarpedForces()](
             const Surroundings& around, double time, double h, RivalBody& now) mutable {
    const Points before = now.x;
    drive_nodes(around, time, h, now);
    const Eigen::Index size = 3 * static_cast<Eigen::Index>(now.x.size());
    Eigen::VectorXd way = Eigen::VectorXd::Zero(size);
    for (size_t i = 0; i < now.x.size(); ++i) {
      body->x[i] = to_vec(before[i]);
      way.segment<3>(3 * i) = now.driven[i] ? to_vec(now.x[i] - before[i]) : h * to_vec(now.v[i]);
    }
    warped_forces(*body, turned, forces);
    if (active) active(*body, forces.f);
    // (M (1 + h drag) + h^2 K) way = M h v + h^2 f
    for (int round = 0; round < 3; ++round) {
      Eigen::SparseMatrix<double> a = h * h * forces.k;
      Eigen::VectorXd right = h * h * forces.f;
      for (size_t i = 0; i < now.x.size(); ++i) {
        const Vec3 part = now.mass[i] * h * to_vec(now.v[i]);
        right.segment<3>(3 * i) += part;
        for (int k = 0; k < 3; ++k) {
          a.coeffRef(3 * i + k, 3 * i + k) += now.mass[i] * (1.0 + h * drag);
        }
      }
      if (around.beyond) {
        const auto beyond = [&](const Vec3& p) { return around.beyond(time, p); };
        add_obstacles(beyond, *body, way, h, a, right);
      }
      for (size_t i = 0; i < now.x.size(); ++i) {  // driven: their way is given
        for (Eigen::Index k = 3 * i; now.driven[i] && k < 3 * static_cast<Eigen::Index>(i) + 3;
             ++k) {
          const double held = 1e9 * a.coeff(k, k);
          a.coeffRef(k, k) += held;
          right[k] = held * way[k];
        }
      }
      Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
      solver.setTolerance(1e-6);
      solver.setMaxIterations(2000);
      solver.compute(a);
      way = solver.solveWithGuess(right, way);
      if (!around.beyond || !way.allFinite()) break;
    }
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (now.driven[i]) continue;
      now.x[i] = before[i] + to_point(way.segment<3>(3 * i));
      now.v[i] = 1.0 / h * (now.x[i] - before[i]);
    }
  };
}

}  // namespace thew::tools
