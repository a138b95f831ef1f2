// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/model_hash.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "sim/cache/hash.h"
#include "sim/cache/version.h"

namespace thew::sim {
namespace {

void hash_character(const ModelDef& def, const Model& model, Hash& hash) {
  if (!model.character) return;
  const CharacterRig& rig = *model.character;
  const auto numbers = [&](const auto& list) {
    const double count = static_cast<double>(list.size());
    hash.add(&count, sizeof count);
    hash.add(list.data(), list.size() * sizeof list[0]);
  };
  const auto affines = [&](const std::vector<Affine>& list) {
    for (const Affine& one : list) hash.add(one.data(), 16 * sizeof(double));
  };
  affines(rig.rest);
  affines(rig.character.rest);
  for (const Forearm& forearm : rig.forearms) {
    for (const Vec3& p : {forearm.head, forearm.wrist}) hash.add(p.data(), 3 * sizeof(double));
  }
  for (const Scapula& scapula : rig.scapulae) {
    for (const Vec3& p : {scapula.axis, scapula.hanging}) hash.add(p.data(), 3 * sizeof(double));
    for (const double value : {scapula.from, scapula.share}) hash.add(&value, sizeof value);
  }
  const auto turns = [&](const std::vector<Eigen::Quaterniond>& list) {
    for (const auto& q : list) hash.add(q.coeffs().data(), 4 * sizeof(double));
  };
  const auto bent = [&](const auto& curve, const auto& add) {
    if (curve.interpolation == CurveInterpolation::kLinear) return;
    hash.add(&curve.interpolation, sizeof curve.interpolation);
    add(curve.slopes_in);
    add(curve.slopes_out);
  };
  for (const BodyTrack& track : rig.clip.tracks) {
    hash.add(&track.body, sizeof track.body);
    numbers(track.translation.times);
    numbers(track.translation.values);
    numbers(track.rotation.times);
    turns(track.rotation.values);
    numbers(track.scale.times);
    numbers(track.scale.values);
    bent(track.translation, numbers);
    bent(track.rotation, turns);
    bent(track.scale, numbers);
  }
  if (!model.skinned) return;
  numbers(model.skinned->weights.link);
  numbers(model.skinned->weights.weight);
  const SkinSettings& settings = def.skin.settings;
  for (double value : {settings.reach, settings.bridging, settings.thickness, settings.smoothing,
                       settings.fold_gap}) {
    hash.add(&value, sizeof value);
  }
  hash.add(&settings.iterations, sizeof settings.iterations);
  hash.add(model.skin_feels.data(), model.skin_feels.size());
}

// One hash of all, and one of each part.
class PartedHash {
 public:
  void add(const void* bytes, std::size_t count) {
    whole_.add(bytes, count);
    part_->add(bytes, count);
  }
  void add(std::string_view text) { add(text.data(), text.size()); }
  void number(double value) { add(&value, sizeof value); }
  void list(const std::vector<double>& values) {
    number(static_cast<double>(values.size()));
    add(values.data(), values.size() * sizeof(double));
  }
  void point(const Vec3& p) { add(p.data(), 3 * sizeof(double)); }
  void points(const std::vector<Vec3>& values) {
    number(static_cast<double>(values.size()));
    for (const Vec3& p : values) point(p);
  }
  void faces(const std::vector<Triangle>& triangles) {
    number(static_cast<double>(triangles.size()));
    add(triangles.data(), triangles.size() * sizeof(Triangle));
  }
  void add_character(const ModelDef& def, const Model& model) {
    hash_character(def, model, whole_);
    hash_character(def, model, *part_);
  }
  void end_part(const std::string& name, Model& model) {
    model.part_hashes.emplace_back(name, part_->hex());
    part_.emplace();
  }
  std::string hex() const { return whole_.hex(); }

 private:
  Hash whole_;
  std::optional<Hash> part_{std::in_place};
};

void add_settings(const ModelDef& def, PartedHash& hash) {
  hash.add(std::string("thew ") + kVersion);
  for (double value : {def.fps,
                       def.settle,
                       def.size,
                       def.gravity.x(),
                       def.gravity.y(),
                       def.gravity.z(),
                       1.0 * def.first_frame,
                       1.0 * def.solver.substeps,
                       1.0 * def.solver.iterations,
                       1.0 * def.contact.enabled,
                       def.contact.settings.margin,
                       def.contact.settings.max_depth,
                       def.contact.settings.gap,
                       def.contact.settings.spacing,
                       def.contact.friction,
                       def.skin.settings.thickness,
                       def.skin.settings.smoothing,
                       1.0 * def.skin.settings.iterations,
                       def.skin.settings.fold_gap,
                       def.skin.settings.reach,
                       1.0 * def.skin.settings.keeps_volume}) {
    hash.number(value);
  }
  const bool zonal = std::any_of(def.muscles.begin(), def.muscles.end(),
                                 [](const MuscleDef& muscle) { return muscle.zones > 1; });
  hash.add(kIntegrators[static_cast<int>(def.solver.integrator)]);
  hash.add(zonal ? "zonal" : kVolumeMethods[static_cast<int>(def.solver.volume)]);
  if (const auto& tolerance = def.solver.tolerance) {
    hash.add("tolerance");
    hash.list({tolerance->position, tolerance->volume});
  }
}

void add_clip(const Clip& clip, PartedHash& hash) {
  hash.list(clip.times);
  for (size_t j = 0; j < clip.joints.size(); ++j) hash.add(clip.joints[j]);
  for (const std::vector<double>& key : clip.values) hash.list(key);
  hash.number(static_cast<double>(clip.interpolation));
}

void add_rig(const Skeleton& skeleton, PartedHash& hash) {
  for (int i = 0; i < skeleton.size(); ++i) {
    hash.number(skeleton.parent[i]);
    hash.add(skeleton.joint_in_parent[i].data(), 16 * sizeof(double));
    hash.point(skeleton.joint_axes[i]);
    hash.number(static_cast<double>(skeleton.joint_types[i]));
    hash.add(skeleton.joint_names[i]);
  }
}

void add_motion(const MeshMotion& motion, PartedHash& hash) {
  hash.list(motion.times);
  for (const Transform& pose : motion.poses) hash.add(pose.data(), 16 * sizeof(double));
  for (const Points& shape : motion.shapes) hash.add(shape.data(), shape.size() * sizeof(Point));
}

void add_path(const MusclePath& path, PartedHash& hash) {
  for (const PathPoint& point : path.points) {
    hash.number(point.body);
    hash.point(point.position);
    if (point.with >= 0) hash.list({1.0 * point.with, point.share});
  }
  for (const WrapCylinder& wrap : path.wraps) {
    for (double value : {1.0 * wrap.segment, 1.0 * wrap.body, wrap.radius, wrap.turn}) {
      hash.number(value);
    }
    hash.point(wrap.centre);
    hash.point(wrap.axis);
  }
}

void add_muscle(const Muscle& muscle, PartedHash& hash) {
  hash.add(muscle.name);
  hash.points(muscle.rest.vertices);
  hash.faces(muscle.rest.triangles);
  hash.add(muscle.order.node.data(), muscle.order.node.size() * sizeof(int));
  hash.faces(muscle.order.triangles);
  add_path(muscle.shape.path, hash);
  hash.list({muscle.shape.belly[0], muscle.shape.belly[1], muscle.shape.twist_from,
             muscle.settings.guide, muscle.settings.damping, muscle.settings.material.shape,
             muscle.settings.f_max, muscle.settings.fibre_length, 1.0 * muscle.swells});
  if (const auto& zone = muscle.settings.zone) {
    hash.list({zone->smallest_radius, zone->largest_radius, zone->per_impulse, zone->along_load});
  }
  for (const auto& key : muscle.settings.activation) hash.list({key[0], key[1]});
  if (const auto& by = muscle.settings.by_joint) {
    hash.number(by->body);
    for (const auto* curve : {&by->curve, &by->speed}) {
      hash.number(static_cast<double>(curve->size()));
      for (const auto& key : *curve) hash.list({key[0], key[1]});
    }
    if (by->load) {
      hash.list({by->load->mass, 1.0 * by->load->index});
      hash.point(by->load->at);
    }
  }
  hash.list(muscle.shape.bulge);
  if (!muscle.shape.fixed_to.empty()) {
    hash.add(muscle.shape.fixed_to.data(), muscle.shape.fixed_to.size() * sizeof(int));
    hash.points(muscle.shape.offset);
  }
  if (muscle.zones.count() > 0) hash.list(muscle.zones.rest_before);
  hash.list(muscle.weights);
  hash.list(muscle.mass);
  hash.list(muscle.springs.stiffness);
}

}  // namespace

void hash_model(const ModelDef& def, Model& model) {
  PartedHash hash;
  add_settings(def, hash);
  hash.end_part("a setting of scene, solver, contact or skin", model);
  add_clip(model.clip, hash);
  hash.end_part("the clip", model);
  add_rig(model.skeleton, hash);
  hash.end_part("the rig", model);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    const std::string name = "muscle \"" + model.muscles[m].name + "\"";
    add_muscle(model.muscles[m], hash);
    hash.end_part(name, model);
    if (def.muscles[m].stiffness.empty()) continue;
    hash.list(def.muscles[m].stiffness);
    hash.end_part("material.stiffness of " + name, model);
  }
  for (size_t b = 0; b < model.bones.size(); ++b) {
    hash.add(&model.bones[b].body, sizeof(int));
    hash.points(model.bones[b].in_body.vertices);
    hash.faces(model.bones[b].in_body.triangles);
    if (model.bones[b].prop) hash.add("prop");
    if (model.bones[b].motion) add_motion(*model.bones[b].motion, hash);
  }
  hash.end_part("the bones' meshes", model);
  for (const std::vector<char>& row : model.ignore) hash.add(row.data(), row.size());
  hash.end_part("contact.ignore", model);
  for (const auto& [name, metres] : model.contact.thickness) {
    hash.add(name);
    hash.number(metres);
  }
  hash.end_part("contact.thickness", model);
  for (const ContactSurface& surface : model.surfaces) {
    if (surface.thicknesses.empty()) continue;
    hash.list(surface.thicknesses);
    hash.end_part("contact.thickness of \"" + surface.name + "\", by node", model);
  }
  const SkinModel& layer = model.skinned ? model.skinned->layer : model.skin;
  if (!layer.stick.empty()) {
    hash.list(layer.stick);
    hash.end_part("skin.slide", model);
  }
  if (!def.skin.maps.fat.empty()) {
    hash.list(def.skin.maps.fat);
    hash.end_part("skin.fat", model);
  }
  for (const Point& row : model.skin.rest) hash.add(&row, 3 * sizeof(double));
  hash.faces(model.skin.surface.triangles);
  if (model.skin_motion) add_motion(*model.skin_motion, hash);
  hash.end_part("the skin's mesh", model);
  hash.add_character(def, model);
  hash.end_part("the character", model);
  model.hash = hash.hex();
}

}  // namespace thew::sim
