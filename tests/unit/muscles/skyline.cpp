// SPDX-License-Identifier: Apache-2.0
#include "muscles/skyline.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <stdexcept>
#include <string>

namespace thew::tests {
namespace {

// Springs of a ring of rings with every seventh node driven, and the same matrix by Eigen, dense.
struct Case {
  std::vector<std::array<int, 2>> pairs;
  std::vector<char> driven;
  Eigen::MatrixXd dense;
};

Case make_case(int around, int rings) {
  Case c;
  const int n = around * rings;
  c.driven.assign(n, 0);
  for (int i = 0; i < n; i += 7) c.driven[i] = 1;
  c.dense = Eigen::MatrixXd::Zero(n, n);
  const auto connect = [&](int a, int b) {
    c.pairs.push_back({a, b});
    const double k = 1.0 + 0.1 * ((a * 31 + b * 17) % 13);
    c.dense(a, a) += k;
    c.dense(b, b) += k;
    c.dense(a, b) -= k;
    c.dense(b, a) -= k;
  };
  for (int r = 0; r < rings; ++r) {
    for (int j = 0; j < around; ++j) {
      connect(r * around + j, r * around + (j + 1) % around);
      if (r + 1 < rings) connect(r * around + j, (r + 1) * around + j);
      if (r + 2 < rings) connect(r * around + j, (r + 2) * around + (j + 1) % around);
    }
  }
  return c;
}

TEST(Skyline, SolvesAsEigenDoes) {
  const Case c = make_case(9, 14);
  const int n = static_cast<int>(c.driven.size());
  Skyline matrix = make_skyline(n, c.pairs, c.driven);
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b <= a; ++b) {
      if (c.dense(a, b) != 0.0) add_entry(matrix, a, b, c.dense(a, b));
    }
  }
  std::vector<double> extra(matrix.size());
  for (int i = 0; i < matrix.size(); ++i) extra[i] = 0.5 + 0.01 * i;
  Eigen::MatrixXd free(matrix.size(), matrix.size());
  Eigen::MatrixXd rhs(matrix.size(), 8);
  PointPairs b(matrix.size());
  for (int i = 0; i < matrix.size(); ++i) {
    for (int j = 0; j < matrix.size(); ++j) free(i, j) = c.dense(matrix.order[i], matrix.order[j]);
    free(i, i) += extra[i];
    for (int k = 0; k < 8; ++k) b[i][k] = rhs(i, k) = (i * (k + 3)) % 11 - 5.0;
  }
  SkylineFactor factor;
  ASSERT_TRUE(factorise(matrix, extra, factor));
  solve(matrix, factor, b);
  const Eigen::MatrixXd expected = free.ldlt().solve(rhs);
  for (int i = 0; i < matrix.size(); ++i) {
    for (int k = 0; k < 8; ++k) EXPECT_NEAR(b[i][k], expected(i, k), 1e-11);
  }
}

TEST(Skyline, OrderHoldsEachFreeNodeOnce) {
  const Case c = make_case(6, 5);
  const Skyline matrix = make_skyline(30, c.pairs, c.driven);
  std::vector<int> seen(30, 0);
  for (int node : matrix.order) ++seen[node];
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(seen[i], c.driven[i] ? 0 : 1);
    EXPECT_EQ(matrix.position[i] < 0, c.driven[i] != 0);
  }
}

TEST(Skyline, RowsOfATubeStayShort) {
  const int around = 20, rings = 60;
  Case c = make_case(around, rings);
  c.driven.assign(c.driven.size(), 0);
  const Skyline matrix = make_skyline(around * rings, c.pairs, c.driven);
  EXPECT_LT(static_cast<double>(matrix.values.size()) / matrix.size(), 2.6 * around);
}

TEST(Skyline, WhatNoMemoryHoldsIsRefusedBeforeItIsTaken) {
  constexpr int kNodes = 40000;  // joined at random: no order keeps the rows short
  std::mt19937 random(1);
  std::vector<std::array<int, 2>> pairs;
  for (int i = 0; i < 4 * kNodes; ++i) {
    pairs.push_back({static_cast<int>(random() % kNodes), static_cast<int>(random() % kNodes)});
  }
  try {
    make_skyline(kNodes, pairs, std::vector<char>(kNodes, 0));
    FAIL() << "nothing was thrown";
  } catch (const std::length_error& error) {
    EXPECT_NE(std::string(error.what()).find("MiB, more than 2048; use a coarser mesh"),
              std::string::npos)
        << error.what();
  }
}

TEST(Skyline, RefusesAnIndefiniteMatrix) {
  const Case c = make_case(5, 4);
  const Skyline matrix = make_skyline(20, c.pairs, c.driven);
  SkylineFactor factor;
  EXPECT_FALSE(factorise(matrix, std::vector<double>(matrix.size(), -1.0), factor));
}

}  // namespace
}  // namespace thew::tests
