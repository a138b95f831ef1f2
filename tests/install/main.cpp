// SPDX-License-Identifier: Apache-2.0
// A program with an Eigen of its own, vectorised, beside Thew's, which must not be: consumer SCENE
// FOLDER bakes the scene and prints its hash. Ends with 1 where either is not what it has to be.
#include <thew/thew.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>

#ifdef EIGEN_DONT_VECTORIZE
#error "a flag of Thew's own build has reached its user"
#endif
#if defined(__x86_64__) && !defined(EIGEN_VECTORIZE)
#error "this program's Eigen is not vectorised: it proves nothing"
#endif
#ifdef Eigen
#error "Thew's own name for Eigen has reached its user"
#endif

namespace {

bool check(const char* what, bool holds) {
  if (!holds) std::printf("%s does not hold\n", what);
  return holds;
}

// Whether `read` of a file that is not there throws the package's Error with the code of bad input.
template <class Read>
bool refuses(Read read) {
  try {
    read("no such file");
  } catch (const thew::Error& error) {
    return error.code() == thew::ErrorCode::kInput;
  }
  return false;
}

// The same types and functions as Thew has inside, so that a shared one would be found by the
// linker.
bool check_eigen() {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(40, 40);
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) a(i, j) = std::cos(i * 7 + j) + (i == j ? 40.0 : 0.0);
  }
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(40, 1.0, 2.0);
  const Eigen::VectorXd x = a.partialPivLu().solve(b);
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2) / 3.0).matrix();
  m.topRightCorner<3, 1>() << 1, 2, 3;
  return check("Eigen: a x = b", (a * x - b).norm() < 1e-12) &
         check("Eigen: m m^-1 = 1", (m * m.inverse() - Eigen::Matrix4d::Identity()).norm() < 1e-14);
}

bool check_cube() {
  thew::Mesh cube;
  for (int i = 0; i < 8; ++i) {
    for (const int bit : {i & 1, i >> 1 & 1, i >> 2}) cube.positions.push_back(bit);
  }
  cube.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  const auto volume = [&] { return thew::enclosed_volume(cube.positions, cube.triangles); };
  bool fine = check("a cube's volume is 1", std::abs(volume() - 1.0) < 1e-15);
  fine &= check("a cube is sound", thew::find_defects(cube).empty());
  const std::vector<double> inverse_mass(8, 1.0);
  fine &=
      check("a cube is brought to 2",
            thew::restore_volume(cube.positions, cube.triangles, {}, inverse_mass, 2.0).reached);
  return fine & check("a cube's volume is 2", std::abs(volume() - 2.0) < 1e-14);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  bool fine = check_eigen() & check_cube();
  // These pull assimp, urdfdom and HDF5 into the link.
  fine &= check("a missing mesh is refused", refuses([](auto file) { thew::read_mesh(file); }));
  fine &= check("a missing bake is refused", refuses([](auto file) { thew::Bake bake(file); }));
  fine &= check("there is a version", thew::version()[0] != '\0');
  try {
    const thew::Bake bake(thew::bake(thew::Scene::read(argv[1]), argv[2]));
    std::printf("hash %s\n", bake.contents().hash.c_str());
  } catch (const thew::Error& error) {
    fine = check(error.what(), false);
  }
  return fine & check_eigen() ? 0 : 1;
}
