// SPDX-License-Identifier: Apache-2.0
#include "rig/import/mesh_import.h"

#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "rig/import/character_import.h"
#include "rig/text.h"
#include "tests/unit/rig/shapes.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class Import : public TempFolder {
 protected:
  std::string error_of(const fs::path& file) {
    return input_error([&] { import_mesh(file); });
  }
};

template <typename T>
std::string bytes_of(std::initializer_list<T> values) {
  std::string bytes;
  for (T v : values) bytes.append(reinterpret_cast<const char*>(&v), sizeof v);
  return bytes;
}

// A cube as OBJ with one normal for each side, so that importers split its corners.
std::string cube_obj() {
  std::string text = "mtllib cube.mtl\n";
  for (const Vec3& p : unit_cube().vertices) {
    text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
            std::to_string(p.z()) + "\n";
  }
  text += "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n";
  int normal = 0;
  for (const char* quad : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
    text += "f";
    ++normal;
    for (const char* c = quad; *c; ++c) {
      text += *c == ' ' ? "" : std::string(" ") + *c + "//" + std::to_string(normal);
    }
    text += "\n";
  }
  return text;
}

TEST_F(Import, WordsThatAreNoNumbersAreRefusedWithTheirLine) {
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::string obj = cube_obj();
  const std::string first = "v 0.000000 0.000000 0.000000\n";
  for (const char* word :
       {"-0.01\x16"
        "27",
        "1,5", "0x10", "1.5m", "nan", "inf", "1e", "--1", "1e999", "0.1.2", "1e300x"}) {
    EXPECT_HAS(error_of(write("cube.obj", with(obj, first, std::string("v 0 ") + word + " 0\n"))),
               "cube.obj:2: \"")
        << word;
  }
  for (const char* corner : {"1,2", "0", "1.5", "1/x", "1/1/1/1", "one", "1//", "/1"}) {
    const std::string error =
        error_of(write("cube.obj", with(obj, "f 1//1", std::string("f ") + corner)));
    if (std::string(corner) == "1//") continue;  // left to assimp
    EXPECT_HAS(error, "cube.obj:16: \"") << corner;
  }
  EXPECT_EQ(error_of(write("cube.obj", with(obj, first, "v 0 \\\n 0 0 # one\n"))), "");
  EXPECT_EQ(error_of(write("cube.obj", with(obj, "vn 0 0 -1", "vn nan 0 -1#IND"))), "");
  const std::string stl =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1,5 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid a\n";
  EXPECT_HAS(error_of(write("a.stl", stl)), "a.stl:5: \"1,5\" is not a finite number");
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_HAS(error_of(write("a.ply", ply + "0 0 0\n1 0x 0\n0 1 0\n3 0 1 2\n")),
             "a.ply:11: \"0x\" is not a finite number");
}

TEST_F(Import, PlacesFartherThanTenKilometresAreRefused) {
  const auto cube = write("cube.obj", cube_obj());
  EXPECT_HAS(input_error([&] {
               import_closed_mesh(cube, Eigen::Affine3d(Eigen::Translation3d(0, 2e4, 0)));
             }),
             "cube.obj: vertex 0 lies at (0, 20000, 0) m, farther than 10 km; export the mesh");
  EXPECT_HAS(input_error([&] { import_closed_mesh(cube, Eigen::Affine3d(Eigen::Scaling(1e308))); }),
             "farther than 10 km");
  const std::string far = "v 0 0 0\nv 1e30 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_HAS(error_of(write("far.obj", far)), "vertex 1 lies at (1e+30, 0, 0), which is no place");
}

TEST_F(Import, ObjCubeIsTriangulatedAndWelded) {
  const ImportedMesh cube = import_mesh(write("cube.obj", cube_obj()));
  EXPECT_EQ(cube.mesh.vertices.size(), 8u);
  EXPECT_EQ(cube.mesh.triangles.size(), 12u);
  EXPECT_EQ(cube.imported_vertices, 8);
  EXPECT_EQ(cube.map_back.size(), 8u);
  EXPECT_EQ(enclosed_volume(cube.mesh), 1.0);
  EXPECT_NO_THROW(import_closed_mesh(folder / "cube.obj"));
}

// In one child, each below its own folder, and as each is by itself; a bad one harms no other.
TEST_F(Import, ASharedReaderReadsWhatEachOfItsOwnReads) {
  fs::create_directories(folder / "below");
  const fs::path cube = write("cube.obj", cube_obj());
  const fs::path other = write("below/cube.obj", "v 0 0 5\n" + cube_obj());
  const fs::path bad = write("bad.obj", "v 0 0 x\n");
  const std::string refused = error_of(bad);
  const ImportedMesh alone = import_mesh(cube), other_alone = import_mesh(other);
  const auto expect_same = [](const ImportedMesh& mesh, const ImportedMesh& as) {
    EXPECT_EQ(mesh.mesh.vertices, as.mesh.vertices);
    EXPECT_EQ(mesh.mesh.triangles, as.mesh.triangles);
    EXPECT_EQ(mesh.map_back, as.map_back);
  };
  const SharedReader outer;
  for (int round = 0; round < 2; ++round) {
    const SharedReader inner;
    expect_same(import_mesh(cube), alone);
    EXPECT_EQ(error_of(bad), refused);
    expect_same(import_mesh(other), other_alone);
    expect_same(import_mesh(cube), alone);
  }
}

TEST_F(Import, PointsAndLinesAreLeftOut) {
  const auto file = write("mixed.obj", cube_obj() + "v 9 9 9\nv 8 8 8\np 9\nl 9 10\nf 1 1 2\n");
  const TriMesh mesh = import_closed_mesh(file);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_HAS(error_of(write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")), "lines.obj: ");
}

TEST_F(Import, ClosedMeshListsEveryDefect) {
  std::string text = cube_obj();
  text.erase(text.rfind("f "));
  for (size_t at = 0; (at = text.find("1.0", at)) != text.npos;) text.replace(at, 3, "900.");
  const auto file = write("open.obj", text);
  const std::string message = input_error([&] { import_closed_mesh(file); });
  EXPECT_HAS(message, "open.obj: is not a sound closed surface");
  EXPECT_HAS(message, "open edges: 4, first edge ");
  EXPECT_HAS(message, "looks like millimetres");
}

// The bones of a hand in one file; a muscle, whose volume is one, has to be one surface.
TEST_F(Import, ABoneMayBeInPieces) {
  std::string text;
  for (const char* x : {"0.", "0.3"}) {
    const std::string at(x);
    text += "v " + at + " 0 0\nv " + at + "1 0 0\nv " + at + " 0.1 0\nv " + at + " 0 0.1\n";
  }
  const auto file = write("pieces.obj", text +
                                            "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
                                            "f 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n");
  EXPECT_EQ(import_bone(file).triangles.size(), 8u);
  EXPECT_HAS(input_error([&] { import_closed_mesh(file); }), "components where one is wanted: 2");
}

TEST_F(Import, RefusesFilesByKind) {
  EXPECT_HAS(error_of(folder / "none.obj"), "no such file");
  EXPECT_HAS(error_of(write("a.blend", "x")), "save it as OBJ");
  fs::create_directory(folder / "dir.obj");
  EXPECT_HAS(error_of(folder / "dir.obj"), "not a regular file");
  fs::create_symlink("/dev/zero", folder / "zero.stl");
  EXPECT_HAS(error_of(folder / "zero.stl"), "not a regular file");
  write("large.stl", "solid");
  fs::resize_file(folder / "large.stl", (uintmax_t{256} << 20) + 1);  // sparse
  EXPECT_HAS(error_of(folder / "large.stl"), "256 MiB");
}

TEST_F(Import, RefusesWhatCannotBeRead) {
  for (const char* name : {"a.obj", "a.stl", "a.ply", "a.gltf", "a.glb", "a.fbx", "a.dae"}) {
    EXPECT_HAS(error_of(write(name, "")), std::string(name) + ": ");
    EXPECT_HAS(error_of(write(name, "nonsense, and not much of it")), std::string(name) + ": ");
  }
  EXPECT_HAS(error_of(write("b.stl", cube_obj())), "b.stl: ");  // no guessing by content
}

TEST_F(Import, RefusesVerticesThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string stl = std::string(80, ' ') + bytes_of<uint32_t>({1}) +
                          bytes_of<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, nan, 0}) +
                          bytes_of<uint16_t>({0});
  EXPECT_HAS(error_of(write("nan.stl", stl)), "vertex 2 is not finite: (0, no number, 0)");
}

// Two pyramids on the square between them, each with its own four corners of it.
std::string two_halves(const char* vertex, const char* face, int from, const char* between) {
  std::string text;
  const int at[10][3] = {{1, 0, 0},  {0, 1, 0},  {-1, 0, 0}, {0, -1, 0}, {0, 0, 1},
                         {0, 0, -1}, {0, -1, 0}, {1, 0, 0},  {0, 1, 0},  {-1, 0, 0}};
  for (const auto& p : at) {
    text += vertex;
    for (const int value : p) text += std::to_string(value) + " ";
    text += "\n";
  }
  const int faces[8][3] = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                           {8, 7, 5}, {9, 8, 5}, {6, 9, 5}, {7, 6, 5}};
  for (const auto& f : faces) {
    text += face;
    for (const int i : f) text += " " + std::to_string(i + from) + between;
    text += "\n";
  }
  return text;
}

TEST_F(Import, VerticesAtOnePlaceStayApartInTheFilesOrder) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\nproperty float y\n"
      "property float z\nelement face 8\nproperty list uchar int vertex_indices\nend_header\n";
  const fs::path files[] = {write("a.obj", two_halves("v ", "f", 1, "")),
                            write("b.obj", two_halves("v ", "f", -10, "")),
                            write("c.obj", "vt 0 0\n" + two_halves("v ", "f", 1, "/1")),
                            write("d.ply", ply + two_halves("", "3", 0, ""))};
  for (const fs::path& file : files) {
    const ImportedMesh mesh = import_closed_mesh_whole(file, Eigen::Affine3d::Identity());
    EXPECT_EQ(mesh.mesh.vertices.size(), 6u) << file;
    EXPECT_EQ(mesh.order.node, (std::vector<int>{0, 1, 2, 3, 4, 5, 3, 0, 1, 2})) << file;
    EXPECT_EQ(mesh.order.triangles, (std::vector<Triangle>{{0, 1, 4},
                                                           {1, 2, 4},
                                                           {2, 3, 4},
                                                           {3, 0, 4},
                                                           {8, 7, 5},
                                                           {9, 8, 5},
                                                           {6, 9, 5},
                                                           {7, 6, 5}}))
        << file;
  }
  const auto apart = import_mesh(write("e.obj", two_halves("v ", "f", 1, "") + "l 1 2\n"));
  EXPECT_EQ(apart.order.node.size(), 10u);
  EXPECT_TRUE(import_mesh(write("cube.obj", cube_obj())).order.node.empty());
}

// The seams of the figure, as in its skin.
TEST_F(Import, GltfKeepsItsVerticesAtOnePlaceApart) {
  const fs::path file = fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf";
  const TriMesh skin = import_character(file).mesh;
  const FileOrder order = import_mesh(file).order;
  EXPECT_EQ(order.node, weld(skin).map_back);
  EXPECT_EQ(order.triangles, skin.triangles);
}

// A tetrahedron of volume 1/6 in an external buffer, under two nodes: moved, and mirrored.
std::string tetrahedron_gltf(const std::string& buffer) {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"children": [1], "translation": [10, 0, 0]},
          {"children": [2], "scale": [-2, 1, 1]}, {"mesh": 0, "translation": [0.5, 0, 0]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
               "min": [0, 0, 0], "max": [1, 1, 1]},
              {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48},
                {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
"buffers": [{"byteLength": 72, "uri": ")" +
         buffer + "\"}]}";
}

std::string tetrahedron_bytes() {
  return bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         bytes_of<uint16_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
}

TEST_F(Import, NodeTransformsApplyAndMirrorsStayOutward) {
  write("scene/t.bin", tetrahedron_bytes());
  const TriMesh mesh = import_mesh(write("scene/t.gltf", tetrahedron_gltf("t.bin"))).mesh;
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.vertices[0], Vec3(9, 0, 0));  // 10 - 2 (0 + 0.5)
  EXPECT_EQ(mesh.vertices[1], Vec3(7, 0, 0));
  EXPECT_NEAR(enclosed_volume(mesh), 2.0 / 6.0, 1e-15);
}

TEST_F(Import, BuffersOutsideTheFolderAreNotOpened) {
  const std::string outside = write("t.bin", tetrahedron_bytes()).string();
  fs::create_directory(folder / "scene");
  fs::create_symlink(outside, folder / "scene/link.bin");
  for (const std::string& uri : {std::string("../t.bin"), outside, std::string("link.bin")}) {
    const auto message = error_of(write("scene/t.gltf", tetrahedron_gltf(uri)));
    EXPECT_HAS(message, "which is no regular file in its folder");
    EXPECT_HAS(message, uri);
  }
}

// Opening a pipe to which nobody writes would block forever.
TEST_F(Import, MaterialLibrariesAreRegularFilesOfTheFolder) {
  fs::create_directory(folder / "scene");
  ASSERT_EQ(mkfifo((folder / "pipe.mtl").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo((folder / "scene/pipe.mtl").c_str(), 0600), 0);
  for (const char* library : {"../pipe.mtl", "pipe.mtl"}) {
    std::string text = cube_obj();
    text.replace(text.find("cube.mtl"), 8, library);
    EXPECT_EQ(import_mesh(write("scene/cube.obj", text)).mesh.triangles.size(), 12u);
  }
}

// A tetrahedron of 100 units, 50 along x.
constexpr char kFbx[] = R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",1
		P: "UpAxisSign", "int", "Integer", "",1
		P: "FrontAxis", "int", "Integer", "",2
		P: "FrontAxisSign", "int", "Integer", "",1
		P: "CoordAxis", "int", "Integer", "",0
		P: "CoordAxisSign", "int", "Integer", "",1
		P: "UnitScaleFactor", "double", "Number", "",1
	}
}
Objects:  {
	Geometry: 1001, "Geometry::tetrahedron", "Mesh" {
		Vertices: *12 {
			a: 0,0,0,100,0,0,0,100,0,0,0,100
		}
		PolygonVertexIndex: *12 {
			a: 0,2,-2,0,1,-4,0,3,-3,1,2,-4
		}
		GeometryVersion: 124
	}
	Model: 1002, "Model::tetrahedron", "Mesh" {
		Version: 232
		Properties70:  {
			P: "Lcl Translation", "Lcl Translation", "", "A",50,0,0
		}
	}
}
Connections:  {
	C: "OO",1002,0
	C: "OO",1001,1002
}
)";

// Faces from the last to the first; two vertices are written twice, as at a seam, and one is in no
// face.
TEST_F(Import, ObjKeepsTheFilesOrderOfVertices) {
  const TriMesh cube = unit_cube();
  std::string text;
  const auto vertex = [&](const Vec3& p) {
    text += "v " + number_text(0.3 * p.x() - 0.1) + " " + number_text(p.y() - 0.7) + " " +
            number_text(1e-3 * p.z()) + "\n";
  };
  for (const Vec3& p : cube.vertices) vertex(p);
  vertex(cube.vertices[5]);
  vertex(Vec3(9, 9, 9));
  vertex(cube.vertices[2]);
  for (size_t t = cube.triangles.size(); t-- > 0;) {
    text += "f";
    for (int i : cube.triangles[t]) text += " " + std::to_string((t < 6 && i == 2 ? 10 : i) + 1);
    text += "\n";
  }
  const ImportedMesh imported = import_mesh(write("c.obj", text));
  ASSERT_EQ(imported.mesh.vertices.size(), 8u);
  EXPECT_EQ(imported.map_back, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 5, 2}));
  for (int i = 0; i < 8; ++i) {
    const Vec3 p = cube.vertices[i];
    const Vec3 expected(0.3 * p.x() - 0.1, p.y() - 0.7, 1e-3 * p.z());
    EXPECT_LT((imported.mesh.vertices[i] - expected).norm(), 1e-7) << i;
  }
  for (size_t t = 0; t < 12; ++t) EXPECT_EQ(imported.mesh.triangles[t], cube.triangles[11 - t]);
}

TEST_F(Import, ObjThatNamesNoVertexOrNoNumberIsRefused) {
  for (const char* bad :
       {"f 1 2 4\n", "f 0 1 2\n", "f 1 2 99999999999\n", "v 1e99 0 0\nf 1 2 4\n"}) {
    const std::string text = std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\n") + bad;
    EXPECT_HAS(error_of(write("bad.obj", text)), "bad.obj:") << bad;
  }
}

// 100 units of a centimetre are a metre.
TEST_F(Import, FbxUnitsBecomeMetres) {
  const TriMesh mesh = import_mesh(write("t.fbx", kFbx)).mesh;
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 6.0, 1e-6);
  EXPECT_LT((mesh.vertices[0] - Vec3(0.5, 0, 0)).norm(), 1e-6);
}

// The axes of 3ds Max and Blender: Z up and -Y to the front.
TEST_F(Import, FbxAxesAreTurnedUpright) {
  std::string fbx = kFbx;
  const auto set = [&](const std::string& axis, const char* value) {
    const std::string before = '"' + axis + R"(", "int", "Integer", "",)";
    fbx.replace(fbx.find(before) + before.size(), 1, value);
  };
  set("UpAxis", "2");
  set("FrontAxis", "1");
  set("FrontAxisSign", "-1");
  const TriMesh mesh = import_mesh(write("t.fbx", fbx)).mesh;
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 6.0, 1e-6);
  EXPECT_LT((mesh.vertices[0] - Vec3(0.5, 0, 0)).norm(), 1e-6);
  EXPECT_LT((mesh.vertices[1] - Vec3(0.5, 0, -1)).norm(), 1e-6);
  EXPECT_LT((mesh.vertices[3] - Vec3(0.5, 1, 0)).norm(), 1e-6);
}

TEST(RealMesh, ArmBonesAreClosed) {
  const struct {
    const char* name;
    size_t triangles;
  } bones[] = {{"humerus.stl", 676}, {"ulna.stl", 392}, {"radius.stl", 384}};
  for (const auto& bone : bones) {
    const auto file = fs::path(THEW_SHARED_DATA) / bone.name;
    if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
    const TriMesh mesh = import_closed_mesh(file);
    EXPECT_EQ(mesh.triangles.size(), bone.triangles);
    EXPECT_EQ(mesh.vertices.size(), bone.triangles / 2 + 2);  // genus 0
  }
}

TEST(RealMesh, BicepsIsClosedButInMillimetres) {
  const auto file = fs::path(THEW_SHARED_DATA) / "biceps.stl";
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  const TriMesh mesh = import_mesh(file).mesh;
  EXPECT_EQ(mesh.triangles.size(), 3840u);
  EXPECT_NEAR(enclosed_volume(mesh) * 1e-3, 320.0, 0.5);  // cm^3
  const auto defects = find_defects(mesh);
  ASSERT_EQ(defects.size(), 1u);
  EXPECT_EQ(defects[0].kind, Defect::kWrongScale);
  EXPECT_HAS(defects[0].where, "looks like millimetres");
  EXPECT_HAS(input_error([&] { import_closed_mesh(file); }), "wrong scale");
}

}  // namespace
}  // namespace thew::tests
