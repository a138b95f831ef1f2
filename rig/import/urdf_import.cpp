// SPDX-License-Identifier: Apache-2.0
#include "rig/import/urdf_import.h"

#include <console_bridge/console.h>
#include <tinyxml.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <limits>

#include "rig/import/child.h"
#include "rig/import/packed.h"
#include "rig/import/urdf_tree.h"
#include "rig/limits.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFileLimit = size_t{16} << 20;  // bytes; bounds memory and time
// Of the length of an axis: one printed with few digits is normalised.
constexpr double kUnitTolerance = 1e-3;

// Collects the errors of urdfdom. It only logs them through console_bridge and goes on, so every
// logged error counts as a failure.
class ErrorLog : public console_bridge::OutputHandler {
 public:
  ErrorLog() : former_(console_bridge::getOutputHandler()), level_(console_bridge::getLogLevel()) {
    console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_ERROR);
    console_bridge::useOutputHandler(this);
  }
  ~ErrorLog() override {
    console_bridge::useOutputHandler(former_);
    console_bridge::setLogLevel(level_);
  }
  ErrorLog(const ErrorLog&) = delete;
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (count++ == 0) first = text;
  }
  int count = 0;
  std::string first;

 private:
  console_bridge::OutputHandler* former_;
  console_bridge::LogLevel level_;
};

urdf::ModelInterfaceSharedPtr parse(const fs::path& file, const std::string& text) {
  ErrorLog log;
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(text);
  if (model && log.count == 0) return model;
  const std::string more =
      log.count > 1 ? " (and " + std::to_string(log.count - 1) + " more errors)" : "";
  throw Error(ErrorCode::kInput, file.string() + ": " + (log.count ? log.first : "is not a URDF") +
                                     more + "; correct it and try again");
}

Vec3 to_vec3(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

// Reads an <origin>, R = Rz(yaw) Ry(pitch) Rx(roll), from its text, because the rotation of urdfdom
// uses the sine of the C library, whose last bit differs between processors.
Transform read_origin(const UrdfTree& tree, const TiXmlElement& parent, const std::string& what) {
  Transform origin = Transform::Identity();
  const TiXmlElement* element = parent.FirstChildElement("origin");
  if (!element) return origin;
  const auto read = [&](const char* attribute) {
    Vec3 value = Vec3::Zero();
    const char* text = element->Attribute(attribute);
    if (!text) return value;
    const auto words = split_words(text);
    for (size_t k = 0; k < 3; ++k) {
      const auto number = words.size() == 3 ? parse_number(words[k]) : std::nullopt;
      if (!number || !std::isfinite(*number)) {
        refuse(tree, element->Row(),
               what + ": origin " + attribute + "=\"" + text +
                   "\" is not three finite numbers; write \"0 0 0\"");
      }
      value[static_cast<int>(k)] = *number;
    }
    return value;
  };
  origin.translation() = read("xyz");
  if (!is_bounded(origin.translation())) {
    refuse(tree, element->Row(),
           what + ": origin xyz=\"" + element->Attribute("xyz") +
               "\" is farther than 10 km; give metres");
  }
  const Vec3 rpy = read("rpy");
  if (!is_bounded(rpy, kMaxAngle)) {
    refuse(tree, element->Row(),
           what + ": origin rpy=\"" + element->Attribute("rpy") + "\" turns by more than " +
               number_text(kMaxAngle) + " rad; give what is left of it");
  }
  origin.linear() = rotation_about(Vec3::UnitZ(), rpy.z()) *
                    rotation_about(Vec3::UnitY(), rpy.y()) * rotation_about(Vec3::UnitX(), rpy.x());
  return origin;
}

Vec3 checked_axis(const UrdfTree& tree, const UrdfTree::Joint& at, const urdf::Joint& joint) {
  const Vec3 axis = to_vec3(joint.axis);
  const double length = axis.norm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    refuse(tree, at.row,
           "joint \"" + at.name + "\": its axis is " + point_text(axis) +
               "; give a unit vector, for instance \"0 0 1\"");
  }
  if (std::fabs(length - 1.0) > kUnitTolerance) {
    refuse(tree, at.row,
           "joint \"" + at.name + "\": its axis " + point_text(axis) + " has length " +
               number_text(length) + ", not 1; write " + point_text(axis / length));
  }
  return axis / length;
}

void read_limits(const UrdfTree& tree, const UrdfTree::Joint& at, const urdf::Joint& joint,
                 double& lower, double& upper) {
  if (joint.type == urdf::Joint::CONTINUOUS) {
    upper = std::numeric_limits<double>::infinity();
    lower = -upper;
    return;
  }
  if (!joint.limits) {
    refuse(tree, at.row, "joint \"" + at.name + "\": has no limits; add <limit lower upper ...>");
  }
  lower = joint.limits->lower;
  upper = joint.limits->upper;
  if (!std::isfinite(lower) || !std::isfinite(upper)) {
    refuse(tree, at.row, "joint \"" + at.name + "\": a limit is not finite; use type continuous");
  }
  const bool turns = joint.type == urdf::Joint::REVOLUTE;
  const double most = turns ? kMaxAngle : kMaxCoordinate;
  if (std::fabs(lower) > most || std::fabs(upper) > most) {
    refuse(tree, at.row,
           "joint \"" + at.name + "\": a limit is beyond " + number_text(most) +
               (turns ? " rad; use type continuous" : " m; give metres"));
  }
  if (lower > upper) {
    refuse(tree, at.row,
           "joint \"" + at.name + "\": lower limit " + number_text(lower) +
               " exceeds upper limit " + number_text(upper) + "; exchange them");
  }
}

Skeleton::JointType joint_type(const UrdfTree& tree, const UrdfTree::Joint& at,
                               const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::FIXED:
      return Skeleton::JointType::kFixed;
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
      return Skeleton::JointType::kRevolute;
    case urdf::Joint::PRISMATIC:
      return Skeleton::JointType::kPrismatic;
    default:
      refuse(tree, at.row,
             "joint \"" + at.name +
                 "\": floating and planar joints are not supported; build it of "
                 "revolute and prismatic ones");
  }
}

std::vector<Skeleton::Visual> read_visuals(const UrdfTree& tree, const UrdfTree::Link& at,
                                           const urdf::Link& link, std::vector<int>& rows) {
  std::vector<Skeleton::Visual> visuals;
  if (link.visual_array.size() != at.visuals.size()) {  // urdfdom drops what it cannot read
    refuse(tree, at.row, "link \"" + at.name + "\": a visual cannot be read; correct its geometry");
  }
  for (size_t i = 0; i < at.visuals.size(); ++i) {
    const auto& geometry = link.visual_array[i]->geometry;
    if (!geometry || geometry->type != urdf::Geometry::MESH) continue;
    const auto& mesh = static_cast<const urdf::Mesh&>(*geometry);
    const int row = at.visuals[i]->Row();
    Skeleton::Visual visual;
    visual.mesh_file = mesh.filename;
    rows.push_back(row);
    visual.in_body = read_origin(tree, *at.visuals[i], "link \"" + at.name + "\"");
    visual.scale = to_vec3(mesh.scale);
    const auto size = visual.scale.array().abs();
    if (!((size >= kMinScale).all() && (size <= kMaxScale).all())) {
      refuse(tree, row,
             "link \"" + at.name + "\": mesh scale " + point_text(visual.scale) +
                 " is zero, not finite or no unit's; write scale=\"1 1 1\"");
    }
    visuals.push_back(std::move(visual));
  }
  return visuals;
}

// The result of the child: the skeleton with the names of meshes as in the file, and the line of
// each.
struct ParsedUrdf {
  Skeleton skeleton;
  std::vector<int> rows;
};

ParsedUrdf read_skeleton(const fs::path& file, const std::string& text) {
  const UrdfTree tree = read_urdf_tree(file, text);
  const urdf::ModelInterfaceSharedPtr model = parse(file, text);
  ParsedUrdf parsed;
  Skeleton& s = parsed.skeleton;
  for (const UrdfTree::Body& body : tree.bodies) {
    const UrdfTree::Link& link = tree.links[body.link];
    s.body_names.push_back(link.name);
    s.parent.push_back(body.parent);
    s.visuals.push_back(read_visuals(tree, link, *model->getLink(link.name), parsed.rows));
    s.joint_in_parent.push_back(Transform::Identity());
    s.joint_names.emplace_back();
    s.joint_types.push_back(Skeleton::JointType::kFixed);
    s.joint_axes.push_back(Vec3::UnitX());
    s.lower.push_back(0.0);
    s.upper.push_back(0.0);
    if (body.joint < 0) continue;
    const UrdfTree::Joint& at = tree.joints[body.joint];
    const urdf::Joint& joint = *model->getJoint(at.name);
    s.joint_names.back() = at.name;
    s.joint_in_parent.back() = read_origin(tree, *at.element, "joint \"" + at.name + "\"");
    s.joint_types.back() = joint_type(tree, at, joint);
    if (s.joint_types.back() == Skeleton::JointType::kFixed) continue;
    s.joint_axes.back() = checked_axis(tree, at, joint);
    read_limits(tree, at, joint, s.lower.back(), s.upper.back());
  }
  return parsed;
}

template <typename Archive>
void walk(Archive& archive, ParsedUrdf& parsed) {
  Skeleton& s = parsed.skeleton;
  archive.list(parsed.rows);
  const auto text = [](Archive& in, std::string& value) { in.list(value); };
  archive.each(s.body_names, text);
  archive.list(s.parent);
  archive.list(s.joint_in_parent);
  archive.each(s.joint_names, text);
  archive.list(s.joint_types);
  archive.list(s.joint_axes);
  archive.list(s.lower);
  archive.list(s.upper);
  archive.each(s.visuals, [](Archive& of_bodies, std::vector<Skeleton::Visual>& visuals) {
    of_bodies.each(visuals, [](Archive& of_body, Skeleton::Visual& visual) {
      of_body.list(visual.mesh_file);
      of_body.number(visual.in_body);
      of_body.number(visual.scale);
    });
  });
}

bool is_sound(const ParsedUrdf& parsed) {
  const Skeleton& s = parsed.skeleton;
  size_t visuals = 0;
  for (const auto& of_body : s.visuals) visuals += of_body.size();
  const size_t bodies = s.body_names.size();
  bool sound = bodies > 0 && s.parent.size() == bodies && s.joint_in_parent.size() == bodies &&
               s.joint_names.size() == bodies && s.joint_types.size() == bodies &&
               s.joint_axes.size() == bodies && s.lower.size() == bodies &&
               s.upper.size() == bodies && s.visuals.size() == bodies &&
               parsed.rows.size() == visuals;
  for (size_t i = 0; sound && i < bodies; ++i) {
    sound = s.parent[i] >= -1 && s.parent[i] < static_cast<int>(i) &&
            s.joint_in_parent[i].matrix().allFinite() && s.joint_axes[i].allFinite() &&
            s.joint_types[i] >= Skeleton::JointType::kFixed &&
            s.joint_types[i] <= Skeleton::JointType::kPrismatic && s.lower[i] <= s.upper[i];
    for (const Skeleton::Visual& visual : s.visuals[i]) {
      sound = sound && visual.in_body.matrix().allFinite() && visual.scale.allFinite();
    }
  }
  return sound;
}

// The absolute path of a visual's mesh; `root` and `folder` (the URDF's) are canonical.
std::string resolve_mesh(const std::string& location, const std::string& name, const fs::path& root,
                         const fs::path& folder) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kInput, location + ": mesh \"" + name + "\" " + what);
  };
  constexpr std::string_view kPackage = "package://", kFile = "file://";
  fs::path path;
  if (name.starts_with(
          kPackage)) {  // package://NAME/path: NAME is a folder of the root or the root itself
    const fs::path relative = name.substr(kPackage.size());
    path = root / relative;
    std::error_code error;
    if (!fs::exists(path, error)) path = root / relative.lexically_relative(*relative.begin());
  } else if (name.starts_with(kFile)) {
    path = name.substr(kFile.size());
  } else if (name.find("://") != name.npos) {
    fail("is fetched by a protocol; copy the file beside the URDF");
  } else {
    path = folder / name;
  }
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  if (error) fail("does not exist; correct the path or remove the visual");
  if (!is_below(real, root)) {
    fail("lies outside " + root.string() + "; copy it there or allow another folder");
  }
  if (!fs::is_regular_file(real, error)) fail("is not a regular file; name a mesh file");
  return real.string();
}

// The origin of each joint was checked alone, but a chain of joints may still lead too far away.
void check_rest_pose(const fs::path& file, const Skeleton& skeleton) {
  Pose rest;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), rest);
  for (int b = 0; b < skeleton.size(); ++b) {
    check_position(rest[b].translation(),
                   file.string() + ": link \"" + skeleton.body_names[b] + "\" at rest",
                   "give the origins in metres");
  }
}

// Runs in the parent process, because the child cannot look up files.
void resolve_meshes(const fs::path& file, const fs::path& allowed_root, ParsedUrdf& parsed) {
  std::error_code error;
  const fs::path root = fs::canonical(allowed_root, error);
  if (error) {
    throw Error(ErrorCode::kInput, file.string() + ":1: the allowed folder " +
                                       allowed_root.string() + " does not exist");
  }
  const fs::path folder = fs::canonical(file).parent_path();
  size_t next = 0;
  for (auto& visuals : parsed.skeleton.visuals) {
    for (Skeleton::Visual& visual : visuals) {
      const std::string location = file.string() + ":" + std::to_string(parsed.rows[next++]);
      visual.mesh_file = resolve_mesh(location, visual.mesh_file, root, folder);
    }
  }
}

}  // namespace

Skeleton import_urdf(const fs::path& file, const fs::path& allowed_root) {
  const std::string text = read_whole(file, kFileLimit);
  Child child(file, "correct the URDF and try again", [&](std::string_view) {
    ParsedUrdf parsed = read_skeleton(file, text);
    Packer packer;
    walk(packer, parsed);
    return packer.bytes;
  });
  const std::string bytes = child.ask();
  ParsedUrdf parsed;
  Unpacker unpacker{bytes};
  walk(unpacker, parsed);
  if (!unpacker.finished() || !is_sound(parsed)) child.refuse("its reader sent nonsense");
  check_rest_pose(file, parsed.skeleton);
  resolve_meshes(file, allowed_root, parsed);
  return std::move(parsed.skeleton);
}

}  // namespace thew::rig
