// SPDX-License-Identifier: Apache-2.0
// A bake goes through its parts into bake.h5 and back.
#include "sim/cache/cache.h"

#if __has_include(<hdf5.h>)
#include <hdf5.h>
#else
#include <hdf5/serial/hdf5.h>
#endif
#define XXH_INLINE_ALL
#include <sys/resource.h>
#include <xxhash.h>

#include <csignal>
#include <cstdio>
#include <cstring>
#include <limits>

#include "tests/unit/sim/cache_bake.h"

// HDF5 itself never gives back what it could not flush to a full disk.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

TEST_F(CacheTest, DoubleComesBackToTheBit) {
  const BakeInfo info = small_info(true);
  const std::string hash = bake_small(folder_, info);
  const BakeReader reader(folder_ / "bake.h5");
  const BakeInfo& back = reader.info();
  EXPECT_EQ(back.scene_name, "small");
  EXPECT_EQ(back.scene_hash, info.scene_hash);
  EXPECT_EQ(back.fps, 24.0);
  EXPECT_TRUE(back.double_precision);
  EXPECT_EQ(back.frames, info.frames);
  EXPECT_EQ(back.hash, hash);
  EXPECT_EQ(back.metric_names,
            (std::vector<std::string>{"length/biceps", "penetration", "volume_error/biceps"}));
  EXPECT_EQ(back.character.file, info.character.file);
  EXPECT_EQ(back.character.scale, 0.5);
  EXPECT_EQ(back.character.rest, info.character.rest);
  const int from[] = {1, 2, 0};  // biceps, skin, ulna
  const int metric_from[] = {1, 2, 0};
  ASSERT_EQ(back.meshes.size(), 3u);
  for (int m = 0; m < 3; ++m) {
    const BakeMesh& written = info.meshes[from[m]];
    EXPECT_EQ(back.meshes[m].name, written.name);
    EXPECT_EQ(back.meshes[m].kind, written.kind);
    EXPECT_EQ(back.meshes[m].rest.vertices, written.rest.vertices);
    EXPECT_EQ(back.meshes[m].rest.triangles, written.rest.triangles);
    EXPECT_EQ(back.meshes[m].weights, written.weights);
    EXPECT_EQ(back.meshes[m].coordinates, written.coordinates);
  }
  for (int f = 0; f < 4; ++f) {
    const BakeFrame written = small_frame(info, info.frames[f]), read = reader.read(f);
    EXPECT_EQ(read.frame, written.frame);
    EXPECT_EQ(read.bodies, written.bodies);
    for (int m = 0; m < 3; ++m) {
      EXPECT_EQ(read.positions[m], written.positions[from[m]]);
      EXPECT_EQ(read.metrics[m], written.metrics[metric_from[m]]);
    }
  }
  expect_error(ErrorCode::kInput, "no frame", [&] { reader.read(4); });
  EXPECT_FALSE(fs::exists(folder_ / "bake.parts"));
  EXPECT_FALSE(fs::exists(folder_ / "bake.h5.tmp"));
}

TEST_F(CacheTest, SingleIsRoundedToFloat) {
  const BakeInfo info = small_info(false);
  bake_small(folder_, info);
  const BakeReader reader(folder_ / "bake.h5");
  EXPECT_FALSE(reader.info().double_precision);
  double worst = 0.0;
  for (int f = 0; f < 4; ++f) {
    const Vec3 written = small_frame(info, info.frames[f]).positions[1][1];
    const Vec3 read = reader.read(f).positions[0][1];
    for (int k = 0; k < 3; ++k) EXPECT_EQ(read[k], static_cast<float>(written[k]));
    worst = std::max(worst, (read - written).norm() / written.norm());
  }
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worst, 1e-7);
}

TEST_F(CacheTest, EqualBakesHaveEqualBytes) {
  for (const bool precision : {false, true}) {
    bake_small(folder_ / "a", small_info(precision));
    bake_small(folder_ / "b", small_info(precision));
    const std::string bytes = bytes_of(folder_ / "a/bake.h5");
    EXPECT_GT(bytes.size(), 1000u);
    EXPECT_EQ(bytes, bytes_of(folder_ / "b/bake.h5"));
  }
}

TEST_F(CacheTest, HashIsThatOfThePositions) {
  for (const bool precision : {false, true}) {  // before any rounding, so the same for both
    const BakeInfo info = small_info(precision);
    std::string bytes;
    for (const int frame : info.frames) {
      const BakeFrame written = small_frame(info, frame);
      for (const int m : {1, 2, 0}) {  // biceps, skin, ulna
        for (const Vec3& p : written.positions[m]) {
          for (int k = 0; k < 3; ++k) {
            char number[8];
            std::memcpy(number, &p[k], 8);
            bytes.append(number, 8);
          }
        }
      }
    }
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    char hex[33];
    std::snprintf(hex, sizeof hex, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    EXPECT_EQ(bake_small(folder_, info), hex);
  }
}

TEST_F(CacheTest, AnotherNumberIsAnotherHash) {
  const BakeInfo info = small_info(false);
  const std::string hash = bake_small(folder_ / "a", info);
  BakeWriter writer(folder_ / "b", info, false);
  for (const int number : info.frames) {
    BakeFrame frame = small_frame(info, number);
    // Too little for float32 to show.
    if (number == 4) frame.positions[0][3].x() += 1e-12;
    writer.write(frame);
  }
  EXPECT_NE(writer.pack(), hash);
}

std::string text_attribute(hid_t object, const char* name) {
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  const hid_t type = H5Aget_type(attribute);
  std::string text(H5Tget_size(type), '\0');
  H5Aread(attribute, type, text.data());
  H5Tclose(type);
  H5Aclose(attribute);
  return text;
}

void expect_dataset(hid_t file, const char* name, hid_t type, const std::vector<hsize_t>& dims,
                    const std::vector<hsize_t>& chunk) {
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
  ASSERT_GE(dataset, 0) << name;
  const hid_t stored = H5Dget_type(dataset), space = H5Dget_space(dataset);
  EXPECT_GT(H5Tequal(stored, type), 0) << name;
  std::vector<hsize_t> found(dims.size());
  ASSERT_EQ(H5Sget_simple_extent_ndims(space), static_cast<int>(dims.size())) << name;
  H5Sget_simple_extent_dims(space, found.data(), nullptr);
  EXPECT_EQ(found, dims) << name;
  const hid_t creation = H5Dget_create_plist(dataset);
  hbool_t times = true;
  H5Pget_obj_track_times(creation, &times);
  EXPECT_FALSE(times) << name;
  H5Pget_chunk(creation, static_cast<int>(dims.size()), found.data());
  EXPECT_EQ(found, chunk) << name;
  EXPECT_EQ(H5Pget_nfilters(creation), 3) << name;
  for (const H5Z_filter_t filter :
       {H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE, H5Z_FILTER_FLETCHER32}) {
    unsigned flags = 0;
    EXPECT_GE(H5Pget_filter_by_id2(creation, filter, &flags, nullptr, nullptr, 0, nullptr, nullptr),
              0)
        << name;
  }
  H5Pclose(creation);
  H5Sclose(space);
  H5Tclose(stored);
  H5Dclose(dataset);
}

TEST_F(CacheTest, IsLaidOutAsPromised) {
  bake_small(folder_, small_info(false));
  const hid_t file = H5Fopen((folder_ / "bake.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  EXPECT_EQ(text_attribute(file, "format"), "thew-bake");
  EXPECT_EQ(text_attribute(file, "units"), "m");
  EXPECT_EQ(text_attribute(file, "up_axis"), "Y");
  EXPECT_EQ(text_attribute(file, "scene_hash"), "0123456789abcdef");
  for (const char* name : {"version", "fps", "frames_done"}) {
    EXPECT_GT(H5Aexists(file, name), 0) << name;
  }
  expect_dataset(file, "/frames", H5T_STD_I32LE, {4}, {4});
  expect_dataset(file, "/meshes/biceps/triangles", H5T_STD_U32LE, {4, 3}, {4, 3});
  expect_dataset(file, "/meshes/biceps/rest", H5T_IEEE_F64LE, {4, 3}, {4, 3});
  expect_dataset(file, "/meshes/biceps/positions", H5T_IEEE_F32LE, {4, 4, 3}, {1, 4, 3});
  expect_dataset(file, "/meshes/biceps/weights", H5T_IEEE_F64LE, {4}, {4});
  expect_dataset(file, "/meshes/biceps/coordinates", H5T_IEEE_F64LE, {4, 3}, {4, 3});
  expect_dataset(file, "/meshes/skin/positions", H5T_IEEE_F32LE, {4, 5, 3}, {1, 5, 3});
  expect_dataset(file, "/metrics/volume_error/biceps", H5T_IEEE_F64LE, {4}, {4});
  expect_dataset(file, "/metrics/penetration", H5T_IEEE_F64LE, {4}, {4});
  EXPECT_EQ(H5Lexists(file, "/meshes/ulna/weights", H5P_DEFAULT), 0);
  const std::pair<const char*, const char*> kinds[] = {
      {"/meshes/biceps", "muscle"}, {"/meshes/ulna", "bone"}, {"/meshes/skin", "skin"}};
  for (const auto& [mesh, kind] : kinds) {
    const hid_t group = H5Gopen2(file, mesh, H5P_DEFAULT);
    EXPECT_EQ(text_attribute(group, "kind"), kind);
    H5Gclose(group);
  }
  H5Fclose(file);
}

TEST_F(CacheTest, RefusesWhatCannotBeABake) {
  const auto expect = [&](const char* word, auto change) {
    BakeInfo info = small_info(true);
    change(info);
    expect_error(ErrorCode::kUsage, word, [&] { BakeWriter(folder_, info, false); });
  };
  expect("no frame", [](BakeInfo& info) { info.frames.clear(); });
  expect("ascending", [](BakeInfo& info) { info.frames = {1, 1}; });
  expect("two meshes", [](BakeInfo& info) { info.meshes[1].name = "ulna"; });
  expect("name", [](BakeInfo& info) { info.meshes[1].name = "../ulna"; });
  expect("empty", [](BakeInfo& info) { info.meshes[1].rest = {}; });
  expect("weights", [](BakeInfo& info) { info.meshes[1].weights.pop_back(); });
}

TEST_F(CacheTest, NeverWritesWhatIsNotANumber) {
  const BakeInfo info = small_info(true);
  BakeWriter writer(folder_, info, false);
  writer.write(small_frame(info, -2));
  BakeFrame frame = small_frame(info, 0);
  frame.positions[1][2].y() = std::numeric_limits<double>::quiet_NaN();
  expect_error(ErrorCode::kSolver, "\"biceps\", node 2", [&] { writer.write(frame); });
  frame = small_frame(info, 0);
  frame.metrics[1] = std::numeric_limits<double>::infinity();
  expect_error(ErrorCode::kSolver, "length/biceps", [&] { writer.write(frame); });
  expect_error(ErrorCode::kUsage, "next", [&] { writer.write(small_frame(info, 2)); });
  writer.write(small_frame(info, 0));
}

TEST_F(CacheTest, SaysWhatCannotBeWritten) {
  put_bytes(folder_ / "file", "in the way");
  expect_error(ErrorCode::kOutput, "file", [&] { bake_small(folder_ / "file", small_info(true)); });
  expect_error(ErrorCode::kOutput, "file",
               [&] { bake_small(folder_ / "file/sub", small_info(true)); });
}

/// No file of this process may grow beyond `bytes` while this lives, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(CacheTest, AFullDiskIsToldAndCostsNothingThatWasDone) {
  const BakeInfo info = small_info(true);
  bake_small(folder_ / "whole", info);
  const std::string whole = bytes_of(folder_ / "whole/bake.h5");
  bake_small(folder_ / "full", info, false, 3);
  for (rlim_t bytes = 0; bytes < 600; bytes += 97) {
    const FullDisk full(bytes);
    expect_error(ErrorCode::kOutput, "free some space", [&] { bake_small(folder_ / "new", info); });
  }
  BakeWriter writer(folder_ / "full", info, true);
  ASSERT_EQ(writer.completed().size(), 3u);
  writer.write(small_frame(info, 4));
  for (rlim_t bytes = 0; bytes < whole.size(); bytes += 512) {
    const FullDisk full(bytes);
    expect_error(ErrorCode::kOutput, "free some space", [&] { writer.pack(); });
    EXPECT_FALSE(fs::exists(folder_ / "full/bake.h5"));
  }
  writer.pack();
  EXPECT_EQ(bytes_of(folder_ / "full/bake.h5"), whole);
}

}  // namespace
}  // namespace thew::tests
