// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/peers/bullet_body.h"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <algorithm>

namespace thew::tools {

struct BulletBody::Data {
  btSoftBodyWorldInfo world;
  std::unique_ptr<btSoftBody> body;
  std::vector<char> held;
};

BulletBody::BulletBody(const TriMesh& mesh, const std::vector<double>& mass,
                       const std::vector<char>& held, const BulletSetting& setting)
    : data_(new Data) {
  data_->held = held;
  data_->world.m_gravity.setValue(0, 0, 0);
  data_->world.m_sparsesdf.Initialize();
  std::vector<btScalar> vertices;
  for (const Vec3& p : mesh.vertices) {
    for (int k = 0; k < 3; ++k) vertices.push_back(static_cast<btScalar>(p[k]));
  }
  btSoftBody* body = btSoftBodyHelpers::CreateFromTriMesh(
      data_->world, vertices.data(), mesh.triangles.front().data(),
      static_cast<int>(mesh.triangles.size()), false);
  data_->body.reset(body);
  body->m_materials[0]->m_kLST = static_cast<btScalar>(setting.link_stiffness);
  body->generateBendingConstraints(2);
  for (int i = 0; i < body->m_nodes.size(); ++i) {
    body->setMass(i, held[i] ? 0 : static_cast<btScalar>(mass[i]));
  }
  body->m_cfg.kVC = static_cast<btScalar>(setting.volume_stiffness);
  body->m_cfg.collisions = 0;
  body->setPose(true, false);  // its volume is to be kept, not its shape
}

BulletBody::~BulletBody() = default;

void BulletBody::hold(int node, const Point& x) {
  btSoftBody::Node& n = data_->body->m_nodes[node];
  n.m_x = n.m_q = btVector3(static_cast<btScalar>(x[0]), static_cast<btScalar>(x[1]),
                            static_cast<btScalar>(x[2]));
  n.m_v.setZero();
}

void BulletBody::step(double h, double height) {
  btSoftBody& body = *data_->body;
  const btScalar most = static_cast<btScalar>(height);
  const auto clamp = [&] {
    for (int i = 0; most > 0 && i < body.m_nodes.size(); ++i) {
      btSoftBody::Node& n = body.m_nodes[i];
      if (std::abs(n.m_x.y()) <= most) continue;
      n.m_x.setY(std::clamp(n.m_x.y(), -most, most));
      n.m_v.setY(0);
    }
  };
  body.predictMotion(static_cast<btScalar>(h));
  clamp();
  body.solveConstraints();
  clamp();
  body.integrateMotion();
}

Points BulletBody::positions() const {
  Points x;
  for (int i = 0; i < data_->body->m_nodes.size(); ++i) {
    const btVector3& p = data_->body->m_nodes[i].m_x;
    x.push_back(Point{p.x(), p.y(), p.z(), 0.0});
  }
  return x;
}

}  // namespace thew::tools
