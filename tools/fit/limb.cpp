// SPDX-License-Identifier: Apache-2.0
//
// The outermost surface around a limb.
#include "tools/fit/limb.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rig/math.h"
#include "rig/text.h"
#include "skin/sides.h"
#include "tools/base/median.h"

namespace thew::tools {
namespace {

using Point2 = Eigen::Vector2d;

// Of a triangle's weight, the least on a limb's bodies: at the shoulder and the armpit, where half
// is the trunk's, the arm's section is still to be told.
constexpr double kLeastShare = 0.35;
// Shares of a triangle by which a ray may pass beside it: one that passes between two triangles at
// an edge of both meets one of them.
constexpr double kRounding = 1e-9;

double cross(const Point2& a, const Point2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Counter-clockwise (Andrew 1979).
std::vector<Point2> convex_hull(std::vector<Point2> points) {
  std::sort(points.begin(), points.end(), [](const Point2& p, const Point2& q) {
    return p.x() < q.x() || (p.x() == q.x() && p.y() < q.y());
  });
  std::vector<Point2> hull;
  for (const bool back : {false, true}) {
    const size_t least = hull.size() + 1;
    for (const Point2& p : points) {
      while (hull.size() > least &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    if (!back) std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Whether each edge lies between two triangles that run along it either way.
bool is_closed(const TriMesh& mesh) {
  std::map<std::pair<int, int>, int> sides;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (a != b) sides[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

// Whether the axis passes left of the edge: of the two triangles at an edge one says yes.
bool left_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x() > 0.0;
}

}  // namespace

Limb::Limb(const TriMesh& mesh) : mesh_(mesh) {
  for (const Triangle& t : mesh.triangles) {
    const Vec3 middle = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
    double reach = 0.0;
    for (const int i : t) reach = std::max(reach, (mesh.vertices[i] - middle).norm());
    balls_.push_back({middle, 1.001 * reach});
  }
  for (size_t first = 0; first < balls_.size(); first += kGroup) {
    const size_t end = std::min(first + kGroup, balls_.size());
    Ball group{Vec3::Zero(), 0.0};
    for (size_t i = first; i < end; ++i) group.middle += balls_[i].middle / (end - first);
    for (size_t i = first; i < end; ++i) {
      const double away = (balls_[i].middle - group.middle).norm();
      group.reach = std::max(group.reach, 1.001 * (away + balls_[i].reach));
    }
    groups_.push_back(group);
  }
  closed_ = is_closed(mesh);
}

double Limb::way_out(const Vec3& from, const Vec3& to) const {
  const std::vector<Vec3>& x = mesh_.vertices;
  const Vec3 across = to.unitOrthogonal(), over = to.cross(across);
  struct Hit {
    double at;
    int out;  // +1 leaves, -1 enters
  };
  std::vector<Hit> hits;
  int inside = 0;
  const auto misses = [&](const Ball& ball) {
    const Vec3 off = ball.middle - from;
    const double ahead = to.dot(off);
    return ahead < -ball.reach || off.squaredNorm() - ahead * ahead > ball.reach * ball.reach;
  };
  look_at(misses, [&](size_t i) {
    const Triangle& t = mesh_.triangles[i];
    Eigen::Vector2d p[3];
    double depth[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = x[t[k]] - from;
      p[k] = {across.dot(d), over.dot(d)};
      depth[k] = to.dot(d);
    }
    bool left[3];
    for (int k = 0; k < 3; ++k) {
      const int m = (k + 1) % 3;
      left[k] = t[k] < t[m] ? left_of(p[k], p[m]) : !left_of(p[m], p[k]);
    }
    if (left[0] != left[1] || left[1] != left[2]) return;
    double share[3], sum = 0.0, at = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
      share[k] = a.x() * b.y() - a.y() * b.x();
      sum += share[k];
    }
    for (int k = 0; k < 3; ++k) at += sum == 0.0 ? depth[k] / 3.0 : share[k] / sum * depth[k];
    if (at <= 0.0) return;
    hits.push_back({at, left[0] ? 1 : -1});
    inside += hits.back().out;
  });
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.at < b.at; });
  for (const Hit& hit : hits) {
    if (inside <= 0) return -1.0;
    inside -= hit.out;
    if (inside <= 0) return hit.at;
  }
  return -1.0;
}

double Limb::outermost(const Vec3& from, const Vec3& to, double reach) const {
  double last = -1.0;
  const auto misses = [&](const Ball& ball) {
    const Vec3 off = ball.middle - from;
    const double ahead = to.dot(off), around = ball.reach;
    return ahead + around < last || ahead - around > reach ||
           off.squaredNorm() - ahead * ahead > around * around;
  };
  look_at(misses, [&](size_t i) {
    // from + s to = a + u (b - a) + v (c - a) (Möller, Trumbore 1997)
    const Triangle& t = mesh_.triangles[i];
    const Vec3& a = mesh_.vertices[t[0]];
    const Vec3 ab = mesh_.vertices[t[1]] - a, ac = mesh_.vertices[t[2]] - a;
    const Vec3 p = to.cross(ac), d = from - a, q = d.cross(ab);
    const double scale = ab.dot(p);
    if (std::abs(scale) < 1e-12 * ab.norm() * ac.norm()) return;  // seen edge-on
    const double u = d.dot(p) / scale, v = to.dot(q) / scale, s = ac.dot(q) / scale;
    if (u < -kRounding || v < -kRounding || u + v > 1.0 + kRounding) return;
    if (s > 0.0 && s <= reach) last = std::max(last, s);
  });
  return last;
}

double Limb::Section::within(const Vec3& p) const {
  if (radius <= 0.0) return -1.0;
  const Point2 here(a.dot(p - at), b.dot(p - at));
  double least = radius;
  for (size_t k = 0; k < outline.size(); ++k) {
    const Point2 &one = outline[k], &next = outline[(k + 1) % outline.size()];
    least = std::min(least, cross(next - one, here - one) / (next - one).norm());
  }
  return least;
}

namespace {

// Where a plane cuts a triangle, seen from what is in the middle of a limb.
struct Cut {
  Point2 from, to;
  bool outwards;  // the triangle faces away from the middle

  // Whether the way from the middle to a point goes through it.
  bool hides(const Point2& p) const {
    const double at_from = cross(from, p), at_to = cross(to, p);
    if ((at_from < 0.0) == (at_to < 0.0)) return false;
    const Point2 met = from + at_from / (at_from - at_to) * (to - from);
    return met.dot(p) > 0.0 && met.squaredNorm() < (1.0 - kRounding) * p.squaredNorm();
  }
};

// What faces the middle behind the limb's own outside is the trunk's side, beside which the arm
// hangs and which weights often give to it in part.
bool is_beyond(const Cut& cut, const std::vector<Cut>& all) {
  if (cut.outwards) return false;
  const Point2 middle = 0.5 * (cut.from + cut.to);
  return std::any_of(all.begin(), all.end(),
                     [&](const Cut& other) { return other.outwards && other.hides(middle); });
}

}  // namespace

Limb::Section Limb::section(const Vec3& at, const Vec3& a, const Vec3& b, double reach,
                            double widest) const {
  Section out;
  out.at = out.middle = at;
  out.a = a;
  out.b = b;
  const Vec3 normal = a.cross(b);
  std::vector<Cut> cuts;
  const auto misses = [&](const Ball& ball) {
    return std::abs(normal.dot(ball.middle - at)) > ball.reach;
  };
  look_at(misses, [&](size_t i) {
    const Triangle& t = mesh_.triangles[i];
    std::vector<Point2> ends;
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = mesh_.vertices[t[k]] - at, q = mesh_.vertices[t[(k + 1) % 3]] - at;
      const double over = normal.dot(p), under = normal.dot(q);
      if ((over < 0.0) == (under < 0.0)) continue;
      const Vec3 cut = p + over / (over - under) * (q - p);
      if (cut.norm() <= reach) ends.emplace_back(a.dot(cut), b.dot(cut));
    }
    if (ends.empty()) return;
    const Vec3 corner = mesh_.vertices[t[0]];
    const Vec3 face = (mesh_.vertices[t[1]] - corner).cross(mesh_.vertices[t[2]] - corner);
    cuts.push_back({ends.front(), ends.back(), face.dot(corner - at) > 0.0});
  });
  std::vector<Point2> points;
  for (const Cut& cut : cuts) {
    if (!is_beyond(cut, cuts)) points.insert(points.end(), {cut.from, cut.to});
  }
  if (points.size() < 3) return out;
  std::vector<double> far;
  for (const Point2& p : points) far.push_back(p.norm());
  const double most = widest * median(far);
  for (Point2& p : points) {
    if (p.norm() > most) p *= most / p.norm();
  }
  out.outline = convex_hull(std::move(points));
  double twice = 0.0;
  Point2 moment = Point2::Zero();
  for (size_t k = 0; k < out.outline.size(); ++k) {
    const Point2 &p = out.outline[k], &q = out.outline[(k + 1) % out.outline.size()];
    twice += cross(p, q);
    moment += cross(p, q) * (p + q);
  }
  if (!(twice > 0.0)) return out;
  moment /= 3.0 * twice;
  out.middle = at + moment.x() * a + moment.y() * b;
  out.radius = std::sqrt(0.5 * twice / kPi);
  return out;
}

std::vector<int> hand_bodies(const Character& character, const ArmBodies& arm) {
  const Skeleton& skeleton = character.skeleton;
  const auto place = [&](int body) { return position_of(character, body); };
  if (!arm.has_hand()) return {};
  std::vector<int> bodies = {arm.hand};
  for (int b = 0; b < skeleton.size(); ++b) {
    const bool has_more =
        std::find(skeleton.parent.begin(), skeleton.parent.end(), b) != skeleton.parent.end();
    const bool at_wrist =  // what lies halfway twists the forearm
        (place(b) - place(arm.hand)).norm() < 0.5 * (place(b) - place(arm.forearm)).norm();
    if (b != arm.hand && skeleton.parent[b] == arm.forearm && has_more && at_wrist)
      bodies.push_back(b);
  }
  return bodies;
}

namespace {

bool is_named(const MeshPart& part, const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return name == part.mesh || name == part.node;
  });
}

}  // namespace

std::vector<std::string> mesh_names(const Character& character) {
  std::set<std::string> names;
  for (const MeshPart& part : character.parts)
    names.insert(part.mesh.empty() ? part.node : part.mesh);
  return {names.begin(), names.end()};
}

TriMesh skin_around(const Character& character, const std::vector<int>& bodies,
                    const std::vector<std::string>& meshes, const Points& x,
                    const std::string& place) {
  for (const std::string& name : meshes) {
    const auto has_name = [&](const MeshPart& part) { return is_named(part, {name}); };
    if (std::any_of(character.parts.begin(), character.parts.end(), has_name)) continue;
    const std::vector<std::string> each = mesh_names(character);
    throw Error(ErrorCode::kUsage, "--skin " + name + ": is no mesh of " + place +
                                       did_you_mean(name, each) + "; it has: " + names_text(each));
  }
  const SkinWeights& weights = character.skin;
  std::vector<double> share(x.size(), 0.0);
  std::vector<char> chosen(x.size(), meshes.empty());
  for (size_t i = 0; i < x.size(); ++i) {
    for (int k = weights.first[i]; k < weights.first[i + 1]; ++k) {
      const int on = weights.links[weights.link[k]].body;
      const auto is_above = [&](int body) { return hangs_on(character.skeleton, on, body); };
      if (std::any_of(bodies.begin(), bodies.end(), is_above)) share[i] += weights.weight[k];
    }
  }
  for (size_t m = 0; m < character.parts.size() && !meshes.empty(); ++m) {
    const bool take = is_named(character.parts[m], meshes);
    const size_t end = m + 1 < character.parts.size()
                           ? static_cast<size_t>(character.parts[m + 1].first_vertex)
                           : x.size();
    for (size_t i = character.parts[m].first_vertex; i < end; ++i) chosen[i] = take;
  }
  TriMesh out;
  for (const Point& row : x) out.vertices.push_back(to_vec(row));
  std::vector<Triangle> joined = character.mesh.triangles;
  for (Triangle& t : joined) {
    const bool is_chosen = chosen[t[0]] != 0;
    for (int& i : t) i = character.map_back[i];  // one place, one vertex: no ray goes along a seam
    if (!is_chosen) t[1] = t[2] = t[0];
  }
  const std::vector<char> doubled = skin::find_doubled(joined);
  for (size_t i = 0; i < joined.size(); ++i) {
    if (doubled[i]) joined[i][1] = joined[i][2] = joined[i][0];  // of no volume
  }
  joined = skin::turned_outwards(character.mesh.vertices, std::move(joined));
  for (size_t i = 0; i < joined.size(); ++i) {
    const Triangle& t = character.mesh.triangles[i];
    if (doubled[i] || !chosen[t[0]]) continue;
    if (share[t[0]] + share[t[1]] + share[t[2]] < 3.0 * kLeastShare) continue;
    out.triangles.push_back(joined[i]);
  }
  return out;
}

}  // namespace thew::tools
