// SPDX-License-Identifier: Apache-2.0
//
// Each mesh NAME is a PolyMesh NAMEShape below an Xform NAME, which moves what moves as one piece.
// The archive's bounds are those of all meshes.
#include <algorithm>
#include <functional>
#include <numeric>

#include "sim/cache/version.h"
#include "tools/base/bake_mesh.h"
#include "tools/export/abc_archive.h"
#include "tools/export/character_skin.h"
#include "tools/export/fields.h"
#include "tools/export/formats.h"
#include "tools/export/looks.h"
#include "tools/export/motion.h"

namespace thew::tools {
namespace {

using P = AbcProperty;

constexpr const char* kMesh = "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1";
constexpr const char* kFaceSet = "schema=AbcGeom_FaceSet_v1;schemaBaseType=AbcGeom_GeomBase_v1";
constexpr const char* kTransform = "schema=AbcGeom_Xform_v3";

std::string titled(const std::string& schema, const std::string& compound) {
  const std::size_t begin = schema.find('=') + 1;
  return schema + ";schemaObjTitle=" + schema.substr(begin, schema.find(';') - begin) + ":" +
         compound;
}

// The meta of a value that a shader may read; `scope` is con, vtx or fvr.
std::string parameter(const std::string& scope, const std::string& interpretation, int extent,
                      const std::string& number = "float32_t", std::size_t count = 1) {
  return "arrayExtent=" + std::to_string(count) + ";geoScope=" + scope +
         (interpretation.empty() ? "" : ";interpretation=" + interpretation) +
         ";isGeomParam=true;podExtent=" + std::to_string(extent) + ";podName=" + number;
}

std::string floats(const std::vector<Vec3>& values) {
  std::string bytes;
  for (const Vec3& value : values) put_floats(bytes, value);
  return bytes;
}

template <typename T, typename Values>
std::string numbers(const Values& values) {
  std::string bytes;
  for (const auto& value : values) put(bytes, static_cast<T>(value));
  return bytes;
}

using Box = Eigen::AlignedBox3d;

Box box_of(const std::vector<Vec3>& positions) {
  Box box;
  for (const Vec3& p : positions) box.extend(p);
  return box;
}

std::string bytes_of(const Box& box) {
  std::string bytes;
  for (const Vec3& corner : {box.min(), box.max()}) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, corner[axis]);
  }
  return bytes;
}

// An object's name: / would be another below it.
std::string object_name(const std::string& name) {
  std::string result = one_line(name);
  std::replace(result.begin(), result.end(), '/', '_');
  return result.empty() ? "_" : result;
}

/// A mesh on its way into the file: by frame its bounds, points and normals, or its transform.
struct MeshObject {
  P bounds{".selfBnds", "interpretation=box", P::kScalar, P::kFloat64, 6};
  P positions{"P", "geoScope=vtx;interpretation=point", P::kArray, P::kFloat32, 3};
  P normals{"N", parameter("vtx", "normal", 3), P::kArray, P::kFloat32, 3};
  P matrix{".vals", "", P::kScalar, P::kFloat64, 16};
  std::vector<P> measured;  ///< what changes of its parameters
  std::vector<std::function<std::string(std::size_t i, const ShotFrame&)>> values;
  std::vector<P> constant, parameters;
};

void add_constant(AbcArchive& out, std::vector<P>& to, P property, const std::string& values) {
  out.add(property, values);
  to.push_back(std::move(property));
}

// Alembic's faces run clockwise, seen from outside. `corners`: what each corner of the faces has.
std::vector<int> clockwise(const std::vector<int>& counts, std::vector<int> corners) {
  auto first = corners.begin();
  for (const int count : counts) {
    std::reverse(first, first + count);
    first += count;
  }
  return corners;
}

// Parameters that change by frame.
void add_measured(const Shot& shot, std::size_t m, const RigidMotion& rigid, MeshObject& object) {
  const BakeMesh& mesh = shot.mesh(m);
  const auto add = [&](P property, auto values) {
    object.measured.push_back(std::move(property));
    object.values.push_back(std::move(values));
  };
  for (const auto& [metric, values] : metrics_of(shot, mesh)) {
    add({"thew_" + metric, parameter("con", "", 1, "float64_t"), P::kArray, P::kFloat64},
        [values = values](auto, const ShotFrame& frame) {
          return numbers<double>(std::vector<double>{(*values)[frame.place]});
        });
  }
  if (mesh.line > 0) {
    add({"thew_line", parameter("con", "point", 3, "float32_t", mesh.line), P::kArray, P::kFloat32,
         3},
        [m, &rigid](std::size_t i, const ShotFrame& frame) {
          return floats(line_of_action(frame, m, i, rigid));
        });
  }
  if (shot.fields && mesh.line > 0 && !mesh.coordinates.empty()) {
    add({"thew_fibre", parameter("vtx", "vector", 3), P::kArray, P::kFloat32, 3},
        [m, &rigid, &mesh](std::size_t i, const ShotFrame& frame) {
          return floats(fibre_directions(mesh, line_of_action(frame, m, i, rigid)));
        });
  }
  if (shot.fields && mesh.kind == BakeMesh::Kind::kSkin) {
    add({"thew_stretch", parameter("vtx", "vector", 2), P::kArray, P::kFloat32, 2},
        [m, &mesh, first = first_at_position(mesh.rest)](auto, const ShotFrame& frame) {
          std::string bytes;
          for (const auto& of : principal_stretches(mesh.rest, first, frame.positions[m])) {
            bytes += numbers<float>(of);
          }
          return bytes;
        });
  }
}

MeshObject begin_mesh(AbcArchive& out, const Shot& shot, std::size_t m, const RigidMotion& rigid) {
  const BakeMesh& mesh = shot.mesh(m);
  const Faces faces = faces_of(shot, m);
  MeshObject object;
  add_constant(out, object.constant, {".faceIndices", "", P::kArray, P::kInt32},
               numbers<std::int32_t>(clockwise(faces.counts, faces.corners)));
  add_constant(out, object.constant, {".faceCounts", "", P::kArray, P::kInt32},
               numbers<std::int32_t>(faces.counts));
  if (const Uvs uvs = uvs_of(shot, m); !uvs.values.empty()) {
    P compound{"uv", parameter("fvr", "vector", 2)};
    std::string values;
    for (const auto& uv : uvs.values) values += numbers<float>(uv);
    add_constant(out, compound.below,
                 {".vals", parameter("fvr", "vector", 2), P::kArray, P::kFloat32, 2}, values);
    add_constant(out, compound.below, {".indices", "", P::kArray, P::kUint32},
                 numbers<std::uint32_t>(clockwise(faces.counts, uvs.corners)));
    object.constant.push_back(std::move(compound));
  }
  add_constant(out, object.parameters,
               {"Pref", parameter("vtx", "point", 3), P::kArray, P::kFloat32, 3},
               floats(mesh.rest.vertices));
  add_constant(out, object.parameters,
               {"Cd", parameter("con", "rgb", 3), P::kArray, P::kFloat32, 3},
               numbers<float>(kind_colour(mesh.kind)));
  if (!mesh.weights.empty()) {
    add_constant(out, object.parameters,
                 {"thew_weight", parameter("vtx", "", 1), P::kArray, P::kFloat32},
                 numbers<float>(mesh.weights));
  }
  add_measured(shot, m, rigid, object);
  return object;
}

void add_shape(AbcArchive& out, const Shot& shot, std::size_t m, const std::vector<Vec3>& positions,
               MeshObject& object) {
  out.add(object.bounds, bytes_of(box_of(positions)));
  out.add(object.positions, floats(positions));
  out.add(object.normals, floats(unit_normals(shot, m, positions)));
}

AbcObject face_set(AbcArchive& out, const SkinLooks::Part& part, const P& bounds) {
  P compound{".faceset", kFaceSet};
  compound.below = {bounds};
  add_constant(out, compound.below, {".faces", "", P::kArray, P::kInt32},
               numbers<std::int32_t>(part.faces));
  add_constant(out, compound.below, {".facesExclusive", "", P::kScalar, P::kUint32},
               numbers<std::uint32_t>(std::vector<int>{1}));
  return {object_name(part.material), titled(kFaceSet, ".faceset"), {std::move(compound)}};
}

AbcObject finish_transform(AbcArchive& out, const std::string& name, const P& matrix) {
  P compound{".xform", kTransform};
  add_constant(out, compound.below, {".inherits", "", P::kScalar, P::kBool}, "\1");
  if (!matrix.samples.empty()) {
    add_constant(out, compound.below, {"isNotConstantIdentity", "", P::kScalar, P::kBool}, "\1");
    add_constant(out, compound.below, {".ops", "", P::kScalar, P::kUint8}, "\x30");  // a matrix
    compound.below.push_back(matrix);
    std::vector<int> moving(16);
    std::iota(moving.begin(), moving.end(), 0);
    add_constant(out, compound.below, {".animChans", "", P::kArray, P::kUint32},
                 numbers<std::uint32_t>(moving));
  }
  return {name, titled(kTransform, ".xform"), {std::move(compound)}};
}

AbcObject finish_mesh(AbcArchive& out, const Shot& shot, std::size_t m, MeshObject& object) {
  P compound{".geom", kMesh};
  compound.below = {object.bounds, object.positions, object.normals};
  std::move(object.constant.begin(), object.constant.end(), std::back_inserter(compound.below));
  P parameters{".arbGeomParams", ""};
  parameters.below = std::move(object.parameters);
  std::move(object.measured.begin(), object.measured.end(), std::back_inserter(parameters.below));
  compound.below.push_back(std::move(parameters));
  const std::string name = object_name(shot.mesh(m).name);
  AbcObject mesh{name + "Shape", titled(kMesh, ".geom"), {std::move(compound)}};
  if (shot.meshes[m] == skin_mesh(shot.info())) {
    for (const SkinLooks::Part& part : shot.looks.parts) {
      mesh.children.push_back(face_set(out, part, object.bounds));
    }
  }
  AbcObject above = finish_transform(out, name, object.matrix);
  above.children.push_back(std::move(mesh));
  return above;
}

AbcTimes times_of(const Shot& shot) {
  AbcTimes times{static_cast<std::uint32_t>(shot.places.size()), 0.0, {}};
  bool even = true;
  for (std::size_t i = 0; i < shot.places.size(); ++i) {
    times.seconds.push_back(shot.frame(i) / shot.info().fps);
    if (i > 1) even &= shot.frame(i) - shot.frame(i - 1) == shot.frame(1) - shot.frame(0);
  }
  const int step = times.count > 1 ? shot.frame(1) - shot.frame(0) : 1;
  if (even) times.every = step / shot.info().fps;
  if (even) times.seconds.resize(1);
  return times;
}

// "key=value;…", so that neither sign may stand in a value.
std::string archive_meta(const Shot& shot) {
  std::string description;
  for (const auto& [name, value] : facts_of(shot)) {
    description += (description.empty() ? "" : ", ") + name + ": " + value;
  }
  std::replace(description.begin(), description.end(), ';', ',');
  std::replace(description.begin(), description.end(), '=', '-');
  return std::string("_ai_AlembicVersion=Alembic 1.7.9;_ai_Application=Thew ") + kVersion +
         ";_ai_DCC_FPS=" + digits(shot.info().fps) + ";_ai_Description=" + description;
}

}  // namespace

Exported export_alembic(const Shot& shot, const std::filesystem::path& file) {
  const std::vector<RigidMotion> rigid = rigid_motions(shot);
  AbcArchive out(file);
  std::vector<MeshObject> meshes;
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    meshes.push_back(begin_mesh(out, shot, m, rigid[m]));
    if (!rigid[m].empty()) add_shape(out, shot, m, shot.mesh(m).rest.vertices, meshes[m]);
  }
  P bounds{".childBnds", "interpretation=box", P::kScalar, P::kFloat64, 6};
  std::size_t i = 0;
  for_each_frame(shot, [&](const ShotFrame& frame) {
    Box all;
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      all.extend(box_of(frame.positions[m]));
      if (rigid[m].empty()) {
        add_shape(out, shot, m, frame.positions[m], meshes[m]);
      } else {
        // By columns in memory: Alembic's vectors are rows, and so its matrices ours transposed.
        const double* matrix = rigid[m][i].matrix().data();
        out.add(meshes[m].matrix, numbers<double>(std::vector<double>(matrix, matrix + 16)));
      }
      for (std::size_t k = 0; k < meshes[m].measured.size(); ++k) {
        out.add(meshes[m].measured[k], meshes[m].values[k](i, frame));
      }
    }
    out.add(bounds, bytes_of(all));
    ++i;
  });
  AbcObject top{"", "", {bounds}};
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    top.children.push_back(finish_mesh(out, shot, m, meshes[m]));
  }
  out.finish(top, archive_meta(shot), times_of(shot));
  return {{file},
          "time is frame / fps, in seconds; rigid meshes move by a transform, Pref is the rest "
          "pose"};
}

}  // namespace thew::tools
