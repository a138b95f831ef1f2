// SPDX-License-Identifier: Apache-2.0
#include "sim/framing.h"

#include <algorithm>
#include <array>

#include "rig/character_bones.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"

namespace thew::sim {
namespace {

/// Of a scene of more frames the camera is fitted to every second one, or every third, and so on:
/// 2 ms a frame for a character of 19,000 vertices, of which each picture's process has to wait.
constexpr int kFitted = 2000;

/// What a view is to show: of the muscles and bones their indices, of the skin each vertex by the
/// body that carries most of it.
struct Subject {
  struct Carried {
    int body;
    Vec3 in_body;  ///< m, with the stretch of a character's body
  };
  std::vector<int> muscles, bones;
  std::vector<Carried> skin;
};

std::vector<Subject::Carried> carried_skin(const Model& model) {
  std::vector<Subject::Carried> carried;
  if (model.skinned) {
    const SkinWeights& weights = model.skinned->weights;
    for (size_t i = 0; i < model.skinned->mesh.vertices.size(); ++i) {
      const auto* first = weights.weight.data() + weights.first[i];
      const auto* end = weights.weight.data() + weights.first[i + 1];
      if (first == end) continue;
      const int most = static_cast<int>(std::max_element(first, end) - weights.weight.data());
      const SkinWeights::Link& link = weights.links[weights.link[most]];
      carried.push_back({link.body, link.from_bind * model.skinned->mesh.vertices[i]});
    }
    return carried;
  }
  const SkinModel& skin = model.skin;
  for (size_t i = 0; i < skin.bodies.size(); ++i) {
    const auto most = std::max_element(skin.shares[i].begin(), skin.shares[i].end());
    const int body = skin.bodies[i][most - skin.shares[i].begin()];
    if (body < 0) continue;
    carried.push_back({body, skin.bind_pose[body].inverse() * to_vec(skin.rest[i])});
  }
  return carried;
}

// A muscle belongs to what hangs on the body if any of its bodies does, and with it their bones:
// its origin is to be seen as well.
Subject subject_of(const Model& model, int followed) {
  std::vector<char> hang(model.skeleton.size(), 1);
  for (int b = 0; b < model.skeleton.size() && followed >= 0; ++b) {
    hang[b] = hangs_on(model.skeleton, b, followed);
  }
  Subject subject;
  for (const Subject::Carried& vertex : carried_skin(model)) {
    if (hang[vertex.body]) subject.skin.push_back(vertex);
  }
  std::vector<char> with_muscles = hang;
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    const std::vector<int>& bodies = model.muscles[m].bodies;
    if (std::none_of(bodies.begin(), bodies.end(), [&](int b) { return hang[b]; })) continue;
    subject.muscles.push_back(static_cast<int>(m));
    for (const int body : bodies) with_muscles[body] = 1;
  }
  for (size_t b = 0; b < model.bones.size(); ++b) {
    const Bone& bone = model.bones[b];
    if (!bone.prop && with_muscles[bone.body]) subject.bones.push_back(static_cast<int>(b));
  }
  return subject;
}

/// The camera, in axes (right, up, towards it), that sees all points within `share` of its
/// picture's half width and height (tangents). That of x asks |p.x - eye.x| <= share.x (eye.z -
/// p.z): the sum of both bounds gives the least eye.z, their difference eye.x; of y likewise.
struct Fit {
  Mat3 axes;
  std::array<double, 2> share;
  std::array<std::array<double, 2>, 2> most = {{{-1e30, -1e30}, {-1e30, -1e30}}};
  double nearest = -1e30, farthest = 1e30;

  void add(const Vec3& world) {
    const Vec3 p = axes * world;
    for (int k : {0, 1}) {
      most[k][0] = std::max(most[k][0], share[k] * p.z() - p[k]);
      most[k][1] = std::max(most[k][1], share[k] * p.z() + p[k]);
    }
    nearest = std::max(nearest, p.z());
    farthest = std::min(farthest, p.z());
  }
  bool empty() const { return nearest < farthest; }

  void set(SceneView& view) const {
    constexpr double kLeast = 0.01;  // m, before what is a point alone
    Vec3 eye(0.0, 0.0, nearest + kLeast);
    for (int k : {0, 1}) {
      eye[k] = 0.5 * (most[k][1] - most[k][0]);
      eye.z() = std::max(eye.z(), 0.5 * (most[k][0] + most[k][1]) / share[k]);
    }
    view.eye = axes.transpose() * eye;
    view.target = axes.transpose() * Vec3(eye.x(), eye.y(), 0.5 * (nearest + farthest));
  }
};

Fit fit_of(const SceneView& view, double aspect) {
  const Vec3 back = view.from.normalized(), right = view.up.cross(back).normalized();
  Mat3 axes;
  axes << right.transpose(), back.cross(right).transpose(), back.transpose();
  const SinCos half = sin_cos(0.5 * view.field_of_view * kDegree);
  const double tangent = kFill * half.sin / half.cos;
  return {axes, {tangent * aspect, tangent}};
}

// All points less `moved` (m), in the pose of the state.
void add_all(const Model& model, const Subject& subject, State& state, const Vec3& moved,
             Fit& fit) {
  Points x;
  for (const int m : subject.muscles) {
    const Muscle& muscle = model.muscles[m];
    MuscleState& now = state.muscles[m];
    carry_pose(muscle.shape, state.pose, now.carry, now.pose);
    carried_positions(muscle.shape, now.pose, muscle.swells, x);
    for (size_t i = 0; i < x.size(); ++i) {
      if (muscle.has_path() || muscle.shape.fixed_to[i] >= 0) fit.add(to_vec(x[i]) - moved);
    }
  }
  for (const int b : subject.bones) {
    const Bone& bone = model.bones[b];
    for (const Vec3& p : bone.in_body.vertices) fit.add(state.pose[bone.body] * p - moved);
  }
  for (const auto& [body, p] : subject.skin) {
    fit.add((model.skinned ? state.bodies[body] * p : state.pose[body] * p) - moved);
  }
}

[[noreturn]] void refuse(const SceneView& view, const std::string& why) {
  throw Error(ErrorCode::kUsage, view.location + ": view \"" + view.name + "\" " + why);
}

void frame_view(const Model& model, double aspect, SceneView& view) {
  const int followed = view.follow.empty() ? -1 : find_body(model.skeleton, view.follow);
  if (!view.follow.empty() && followed < 0) {
    refuse(view, "follows \"" + view.follow + "\", which is no body of the rig" +
                     did_you_mean(view.follow, model.skeleton.body_names));
  }
  const bool fits = !view.from.isZero();
  const Subject subject = fits ? subject_of(model, followed) : Subject{};
  Fit fit = fit_of(view, aspect);
  State state = initial_state(model);
  const auto place = [&] {
    return followed < 0 ? Vec3(Vec3::Zero()) : Vec3(state.pose[followed].translation());
  };
  pose_bodies(model, {0.0, 0.0}, state);  // the rest pose
  const Vec3 rest = place();
  view.first_frame = model.first_frame;
  const int frames = model.last_frame - model.first_frame + 1, every = 1 + (frames - 1) / kFitted;
  for (int k = 0; k < frames; ++k) {
    pose_bodies(model, {k / model.fps, 1.0}, state);
    const Vec3 moved = place() - rest;
    if (followed >= 0) view.moves.push_back(moved);
    if (fits && k % every == 0) add_all(model, subject, state, moved, fit);
  }
  if (!fits) return;
  if (fit.empty()) {
    refuse(view,
           "has nothing to look at: no muscle, bone or skin is on what it follows; name another "
           "body");
  }
  fit.set(view);
}

}  // namespace

bool follows_motion(const SceneRender& render) {
  return std::any_of(render.views.begin(), render.views.end(), [](const SceneView& view) {
    return !view.from.isZero() || !view.follow.empty();
  });
}

std::vector<SceneView> frame_views(const Model& model, const SceneRender& render) {
  std::vector<SceneView> views = render.views;
  for (size_t v = 0; v < views.size(); ++v) {
    SceneView& view = views[v];
    if (view.from.isZero() && view.follow.empty()) continue;
    const auto same = std::find_if(
        views.begin(), views.begin() + static_cast<long>(v), [&](const SceneView& other) {
          return other.from == view.from && !other.from.isZero() && other.follow == view.follow &&
                 other.up == view.up && other.field_of_view == view.field_of_view;
        });
    if (same == views.begin() + static_cast<long>(v)) {
      frame_view(model, 1.0 * render.width / render.height, view);
      continue;
    }
    view.eye = same->eye, view.target = same->target;
    view.moves = same->moves, view.first_frame = same->first_frame;
  }
  return views;
}

bool shows(const SceneView& view, BakeMesh::Kind kind) {
  const bool of_skin = view.show == "skin";
  switch (kind) {
    case BakeMesh::Kind::kSkin:
      return of_skin || view.show == "cutaway";
    case BakeMesh::Kind::kProp:
      return true;
    default:
      return !of_skin;
  }
}

std::vector<SceneView> frame_views(const BakeReader& bake, const std::vector<int>& frames,
                                   const SceneRender& render) {
  std::vector<SceneView> views = render.views;
  std::vector<std::pair<SceneView*, Fit>> fits;
  for (SceneView& view : views) {
    if (!view.follow.empty()) {
      refuse(view,
             "follows \"" + view.follow + "\", but its file has no [rig]; give the bake's scene");
    }
    if (view.from.isZero()) continue;
    fits.emplace_back(&view, fit_of(view, 1.0 * render.width / render.height));
  }
  const BakeInfo& info = bake.info();
  for (size_t i = 0; i < info.frames.size(); ++i) {
    if (std::find(frames.begin(), frames.end(), info.frames[i]) == frames.end()) continue;
    const BakeFrame frame = bake.read(static_cast<int>(i));
    for (size_t m = 0; m < info.meshes.size(); ++m) {
      if (info.meshes[m].kind == BakeMesh::Kind::kProp) continue;
      for (auto& [view, fit] : fits) {
        if (!shows(*view, info.meshes[m].kind)) continue;
        for (const Vec3& p : frame.positions[m]) fit.add(p);
      }
    }
  }
  for (const auto& [view, fit] : fits) {
    if (fit.empty()) refuse(*view, "has nothing to look at in these frames of the bake");
    fit.set(*view);
  }
  return views;
}

SceneView view_at(const SceneView& view, int frame) {
  SceneView now = view;
  if (view.moves.empty()) return now;
  const int last = static_cast<int>(view.moves.size()) - 1;
  now.moved = view.moves[std::clamp(frame - view.first_frame, 0, last)];
  now.eye += now.moved;
  now.target += now.moved;
  now.moves.clear();
  return now;
}

}  // namespace thew::sim
