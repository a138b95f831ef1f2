// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rig/mesh.h"

namespace thew::tools {

/// How Bullet's soft body is stepped.
struct BulletSetting {
  int steps = 1;                  ///< a frame
  double volume_stiffness = 0.0;  ///< kVC
  double link_stiffness = 1.0;  ///< kLST, a share: at 1 the surface keeps its area, not its volume
};

/// A closed surface as Bullet's soft body: links on edges and second neighbours, the volume by its
/// pose's kVC. Floats, as Debian builds it. Contact with planes is a clamp of our own, which is
/// less work than Bullet's.
class BulletBody {
 public:
  /// `mass` by node, kg; 0 where `held`.
  BulletBody(const TriMesh& mesh, const std::vector<double>& mass, const std::vector<char>& held,
             const BulletSetting& setting);
  ~BulletBody();
  BulletBody(const BulletBody&) = delete;
  BulletBody& operator=(const BulletBody&) = delete;

  /// Moves a held node, m.
  void hold(int node, const Point& x);
  /// One step of h seconds; free nodes stay within |y| <= height (m) where it is positive.
  void step(double h, double height = 0.0);
  Points positions() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace thew::tools
