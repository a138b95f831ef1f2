// SPDX-License-Identifier: Apache-2.0
//
// Alembic's layout inside Ogawa, as its reference library reads it. Each mesh is a PolyMesh below
// the top object, with the compound .geom: P, N, .velocities and .selfBnds by frame, the rest
// constant.
#include <algorithm>
#include <limits>

#include "sim/cache/hash.h"
#include "sim/cache/version.h"
#include "tools/export/formats.h"
#include "tools/export/ogawa.h"

namespace thew::tools {
namespace {

enum Pod { kInt32 = 6, kFloat32 = 10, kFloat64 = 11 };
enum PropertyType { kCompound = 0, kScalar = 1, kArray = 2 };

constexpr std::int32_t kFileVersion = 0;
constexpr std::int32_t kLibraryVersion = 10709;  // the version of the layout: Alembic 1.7.9
constexpr const char* kMeshSchema = "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1";

/// Texts that many headers share are written once and numbered from 1.
struct SharedTexts {
  std::vector<std::string> texts;

  std::uint32_t number(const std::string& text) {
    if (text.empty()) return 0;
    const auto found = std::find(texts.begin(), texts.end(), text);
    if (found == texts.end()) texts.push_back(text);
    return static_cast<std::uint32_t>(std::find(texts.begin(), texts.end(), text) - texts.begin()) +
           1;
  }
};

/// One property of a mesh; its samples are written as they come.
struct Property {
  std::string name, meta;  // meta: "key=value;…", keys rising
  PropertyType type;
  Pod pod;
  std::uint32_t extent;  // numbers in a value
  bool constant;
  std::vector<std::uint64_t> children;
};

// Each sample begins with 16 bytes that readers take for its identity.
std::string digest_of(std::string_view bytes) {
  const std::string hex = hash_of(bytes);
  std::string digest;
  for (std::size_t i = 0; i < 32; i += 2) {
    digest += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return digest;
}

void add_sample(OgawaFile& out, Property& property, const std::string& values, Hash& content) {
  const std::string digest = digest_of(values);
  content.add(digest);
  property.children.push_back(out.add_leaf(digest + values));
  // The dimensions of a plain array follow from its size.
  if (property.type == kArray) property.children.push_back(OgawaFile::kLeaf);
}

// Bits of a header: 0-1 type, 2-3 width of the counts below (2: 32 bits), 4-7 number type, 8 has a
// time sampling, 10 all samples of one size, 11 constant, 12-19 numbers in a value, 20-27 shared
// text.
std::string property_header(const Property& property, std::uint32_t samples, SharedTexts& shared) {
  std::string bytes;
  std::uint32_t bits = 2u << 2 | shared.number(property.meta) << 20;
  if (property.type == kCompound) {
    put(bytes, bits);
  } else {
    bits |= property.type | static_cast<std::uint32_t>(property.pod) << 4 | 1u << 8 | 1u << 10 |
            property.extent << 12;
    if (property.constant || samples == 1) bits |= 1u << 11;
    put(bytes, bits);
    put(bytes, samples);
    put<std::uint32_t>(bytes, 1);  // the second time sampling, the shot's
  }
  put(bytes, static_cast<std::uint32_t>(property.name.size()));
  return bytes + property.name;
}

std::string floats(const std::vector<Vec3>& values) {
  std::string bytes;
  for (const Vec3& value : values) put_floats(bytes, value);
  return bytes;
}

std::string box(const std::vector<Vec3>& positions) {
  Vec3 low = positions.front(), high = low;
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  std::string bytes;
  for (const Vec3& corner : {low, high}) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, corner[axis]);
  }
  return bytes;
}

/// A mesh on its way into the file.
struct MeshObject {
  std::vector<Property> properties;
  Hash content;
};

enum Slot { kBounds, kPositions, kNormals, kVelocities, kIndices, kCounts };

void begin_mesh(OgawaFile& out, const TriMesh& rest, MeshObject& object) {
  object.properties = {
      {".selfBnds", "interpretation=box", kScalar, kFloat64, 6, false, {}},
      {"P", "geoScope=vtx;interpretation=point", kArray, kFloat32, 3, false, {}},
      {"N",
       "arrayExtent=1;geoScope=vtx;interpretation=normal;isGeomParam=true;podExtent=3;"
       "podName=float32_t",
       kArray,
       kFloat32,
       3,
       false,
       {}},
      {".velocities", "geoScope=vtx;interpretation=vector", kArray, kFloat32, 3, false, {}},
      {".faceIndices", "", kArray, kInt32, 1, true, {}},
      {".faceCounts", "", kArray, kInt32, 1, true, {}}};
  std::string indices, counts;
  for (const Triangle& triangle : rest.triangles) {
    // Alembic's faces run clockwise, seen from outside.
    for (int corner = 2; corner >= 0; --corner) put<std::int32_t>(indices, triangle[corner]);
    put<std::int32_t>(counts, 3);
  }
  add_sample(out, object.properties[kIndices], indices, object.content);
  add_sample(out, object.properties[kCounts], counts, object.content);
}

// Object: its compound, then its children, then their headers with 32 bytes of identity.
std::string object_identity(const std::string& content) {
  return digest_of(content) + std::string(16, '\0');
}

std::uint64_t finish_mesh(OgawaFile& out, const MeshObject& object, std::uint32_t samples,
                          SharedTexts& shared) {
  std::vector<std::uint64_t> children;
  std::string headers;
  for (const Property& property : object.properties) {
    children.push_back(out.add_group(property.children));
    headers += property_header(property, samples, shared);
  }
  children.push_back(out.add_leaf(headers));
  const std::uint64_t geometry = out.add_group(children);
  const Property compound{".geom", kMeshSchema, kCompound, kFloat32, 0, true, {}};
  const std::uint64_t properties =
      out.add_group({geometry, out.add_leaf(property_header(compound, 0, shared))});
  return out.add_group({properties, out.add_leaf(object_identity(object.content.hex()))});
}

// By sampling: its samples, seconds from one to the next, the first seconds. The first sampling is
// every archive's own; frames at uneven steps are listed one by one.
std::string time_samplings(const Shot& shot) {
  const auto samples = static_cast<std::uint32_t>(shot.places.size());
  std::vector<double> seconds;
  bool even = true;
  for (std::size_t i = 0; i < shot.places.size(); ++i) {
    seconds.push_back(shot.frame(i) / shot.info().fps);
    if (i > 1) even &= shot.frame(i) - shot.frame(i - 1) == shot.frame(1) - shot.frame(0);
  }
  const int step = samples > 1 ? shot.frame(1) - shot.frame(0) : 1;
  std::string bytes;
  put<std::uint32_t>(bytes, 0);
  put(bytes, 1.0);
  put<std::uint32_t>(bytes, 1);
  put(bytes, 0.0);
  put(bytes, samples);
  put(bytes, even ? step / shot.info().fps : std::numeric_limits<double>::max() / 32.0);
  if (even) seconds.resize(1);
  put(bytes, static_cast<std::uint32_t>(seconds.size()));
  for (const double time : seconds) put(bytes, time);
  return bytes;
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
  OgawaFile out(file);
  SharedTexts shared;
  std::vector<MeshObject> meshes(shot.meshes.size());
  for (std::size_t m = 0; m < meshes.size(); ++m) begin_mesh(out, shot.mesh(m).rest, meshes[m]);
  for_each_frame(shot, [&](const ShotFrame& frame) {
    const auto velocity = velocities(shot, frame.place);
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      const std::vector<Vec3>& positions = frame.positions[m];
      const auto add = [&](Slot slot, const std::string& values) {
        add_sample(out, meshes[m].properties[slot], values, meshes[m].content);
      };
      add(kBounds, box(positions));
      add(kPositions, floats(positions));
      add(kNormals, floats(unit_normals(shot.mesh(m), positions)));
      add(kVelocities, floats(velocity[m]));
    }
  });
  std::vector<std::uint64_t> children = {0};  // the top object has no properties
  std::string headers, content;
  const std::string meta = std::string(kMeshSchema) + ";schemaObjTitle=AbcGeom_PolyMesh_v1:.geom";
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    children.push_back(
        finish_mesh(out, meshes[m], static_cast<std::uint32_t>(shot.places.size()), shared));
    content += meshes[m].content.hex();
    put(headers, static_cast<std::uint32_t>(shot.mesh(m).name.size()));
    headers += shot.mesh(m).name;
    headers += static_cast<char>(shared.number(meta));
  }
  children.push_back(out.add_leaf(headers + object_identity(content)));
  const std::uint64_t top = out.add_group(children);
  std::string file_version, library_version, texts;
  put(file_version, kFileVersion);
  put(library_version, kLibraryVersion);
  for (const std::string& text : shared.texts) texts += static_cast<char>(text.size()) + text;
  const std::uint64_t versions[] = {out.add_leaf(file_version), out.add_leaf(library_version)};
  const std::uint64_t infos[] = {out.add_leaf(archive_meta(shot)),
                                 out.add_leaf(time_samplings(shot)), out.add_leaf(texts)};
  out.finish(out.add_group({versions[0], versions[1], top, infos[0], infos[1], infos[2]}));
  return {{file}, "time is frame / fps, in seconds; normals and velocities by frame"};
}

}  // namespace thew::tools
