// SPDX-License-Identifier: Apache-2.0
// Files that are not, or no longer, a bake: refused before memory is set aside, never believed.
#if __has_include(<hdf5.h>)
#include <hdf5.h>
#else
#include <hdf5/serial/hdf5.h>
#endif

#include <cmath>
#include <functional>
#include <vector>

#include "tests/unit/sim/cache_bake.h"

// HDF5 itself never gives back what it read of a damaged file.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

std::vector<BakeFrame> read_all(const fs::path& file) {
  const BakeReader reader(file);
  std::vector<BakeFrame> frames;
  for (int i = 0; i < static_cast<int>(reader.info().frames.size()); ++i) {
    frames.push_back(reader.read(i));
  }
  return frames;
}

class ForeignTest : public CacheTest {
 protected:
  ForeignTest() {
    bake_small(folder_, small_info(false));
    good_ = bytes_of(file_);
  }

  /// The bake after `change` by HDF5 itself.
  void expect_refused(const std::string& word, const std::function<void(hid_t)>& change) {
    put_bytes(file_, good_);
    const hid_t file = H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    change(file);
    H5Fclose(file);
    expect_error(ErrorCode::kInput, word, [&] { read_all(file_); });
  }

  /// Another dataset in the place of `name`.
  static void replace(hid_t file, const char* name, hid_t type, std::vector<hsize_t> dims,
                      const std::function<void(hid_t)>& lay_out) {
    H5Ldelete(file, name, H5P_DEFAULT);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    const hid_t space = H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    lay_out(creation);
    H5Dclose(H5Dcreate2(file, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Sclose(space);
    H5Pclose(creation);
  }

  static std::function<void(hid_t)> chunks(std::vector<hsize_t> chunk) {
    return [chunk](hid_t creation) {
      H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
      H5Pset_shuffle(creation);
      H5Pset_deflate(creation, 1);
      H5Pset_fletcher32(creation);
    };
  }

  const fs::path file_ = folder_ / "bake.h5";
  std::string good_;
};

TEST_F(ForeignTest, NoFileJunkAndOtherFormats) {
  expect_error(ErrorCode::kInput, "there", [&] { BakeReader(folder_ / "none.h5"); });
  expect_error(ErrorCode::kInput, "there", [&] { BakeReader reader(folder_); });
  for (const std::string& junk :
       {std::string(), std::string("junk"), std::string(100000, '\0'), good_.substr(1)}) {
    put_bytes(file_, junk);
    expect_error(ErrorCode::kInput, "bake.h5", [&] { BakeReader reader(file_); });
  }
  const hid_t file = H5Fcreate(file_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(file);
  expect_error(ErrorCode::kInput, "not a bake", [&] { BakeReader reader(file_); });
}

TEST_F(ForeignTest, EveryTruncation) {
  for (std::size_t length = 0; length < good_.size(); length += 61) {
    put_bytes(file_, good_.substr(0, length));
    expect_error(ErrorCode::kInput, "bake.h5", [&] { read_all(file_); });
  }
}

TEST_F(ForeignTest, AFlippedBitIsFoundOrChangesNothing) {
  const std::vector<BakeFrame> expected = read_all(file_);
  int found = 0, tried = 0;
  for (std::size_t byte = 0; byte < good_.size(); byte += 23, ++tried) {
    std::string bad = good_;
    bad[byte] = static_cast<char>(bad[byte] ^ (1 << byte % 8));
    put_bytes(file_, bad);
    try {
      const std::vector<BakeFrame> frames = read_all(file_);
      ASSERT_EQ(frames.size(), expected.size()) << byte;
      for (std::size_t f = 0; f < frames.size(); ++f) {
        EXPECT_EQ(frames[f].positions, expected[f].positions) << byte;
        EXPECT_EQ(frames[f].metrics, expected[f].metrics) << byte;
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput) << error.what();
      ++found;
    }
  }
  EXPECT_GT(found, tried / 2);
}

TEST_F(ForeignTest, LinksToElsewhere) {
  expect_refused("link", [](hid_t file) {
    H5Ldelete(file, "/meshes/ulna", H5P_DEFAULT);
    H5Lcreate_external("/etc/hostname", "/", file, "/meshes/ulna", H5P_DEFAULT, H5P_DEFAULT);
  });
  expect_refused("link", [](hid_t file) {
    H5Ldelete(file, "/meshes/ulna/rest", H5P_DEFAULT);
    H5Lcreate_soft("/meshes/skin/rest", file, "/meshes/ulna/rest", H5P_DEFAULT, H5P_DEFAULT);
  });
  expect_refused("second link", [](hid_t file) {  // a circle of hard links
    H5Lcreate_hard(file, "/metrics", file, "/metrics/again", H5P_DEFAULT, H5P_DEFAULT);
  });
}

// Valid to the last checksum.
TEST_F(ForeignTest, NumbersThatNoBakeHas) {
  const auto write = [](const char* name, double value, bool all = false) {
    return [=](hid_t file) {
      const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
      std::vector<double> values(static_cast<size_t>(H5Sget_simple_extent_npoints(space)), value);
      if (!all) {
        H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        values[values.size() / 2] = value;
      }
      H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      H5Sclose(space);
      H5Dclose(dataset);
    };
  };
  const auto rate = [](double value) {
    return [=](hid_t file) {
      const hid_t attribute = H5Aopen(file, "fps", H5P_DEFAULT);
      H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value);
      H5Aclose(attribute);
    };
  };
  const double none = std::nan(""), infinite = HUGE_VAL;
  for (const double value : {1e300, -1e300, 10001.0, none, infinite}) {
    expect_refused("biceps, frame ", write("/meshes/biceps/positions", value));
    expect_refused("lies where no place is", write("/meshes/biceps/positions", value));
    expect_refused("biceps lies at rest", write("/meshes/biceps/rest", value));
    expect_refused("biceps has weights or coord", write("/meshes/biceps/coordinates", value));
  }
  for (const double value : {1e300, -1.0, none, infinite}) {
    expect_refused("biceps has weights", write("/meshes/biceps/weights", value));
    expect_refused("its frame rate make", rate(value));
  }
  for (const double value : {1e300, none, infinite}) {
    expect_refused("its character lies at rest", write("/character/rest", value));
    expect_refused("a body of its character lies", write("/character/bodies", value));
  }
  for (const double value : {1e300, -1.7e308, none, infinite}) {
    expect_refused("the metric penetration is no number", write("/metrics/penetration", value));
  }
  expect_refused("all nodes lie in one place", write("/meshes/ulna/rest", 0.25, true));
  expect_refused("its frame rate make", write("/frames", 2e9));
}

TEST_F(ForeignTest, EachObjectHangsOnOneLink) {
  const auto link = [](const char* from, const char* to) {
    return [=](hid_t file) {
      for (int i = 0; i < 3000; ++i) {
        H5Lcreate_hard(file, from, file, (to + std::to_string(i)).c_str(), H5P_DEFAULT,
                       H5P_DEFAULT);
      }
    };
  };
  expect_refused("second link", link("/meshes/skin", "/meshes/skin"));
  expect_refused("second link", link("/metrics/penetration", "/metrics/more"));
  expect_refused("second link", link("/metrics", "/metrics/in_circles"));
}

TEST_F(ForeignTest, OtherStorage) {
  expect_refused("chunks", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {4, 3},
            [](hid_t creation) { H5Pset_external(creation, "/etc/hostname", 0, H5F_UNLIMITED); });
  });
  expect_refused("chunks", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {4, 3}, [](hid_t creation) {
      const hsize_t dims[] = {4, 3};
      const hid_t space = H5Screate_simple(2, dims, nullptr);
      H5Pset_virtual(creation, space, "other.h5", "/rest", space);
      H5Sclose(space);
    });
  });
  expect_refused("chunks", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {4, 3}, [](hid_t) {});
  });
  expect_refused("filters", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {4, 3}, [](hid_t creation) {
      const hsize_t chunk[] = {4, 3};
      H5Pset_chunk(creation, 2, chunk);
      H5Pset_shuffle(creation);
      H5Pset_deflate(creation, 1);
      H5Pset_filter(creation, 32001, H5Z_FLAG_OPTIONAL, 0, nullptr);  // blosc, by a plug-in
    });
  });
}

TEST_F(ForeignTest, WrongTypesRanksAndSizes) {
  expect_refused("type", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_STD_I64LE, {4, 3}, chunks({4, 3}));
  });
  expect_refused("dimensions", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {12}, chunks({12}));
  });
  expect_refused("size", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {4, 2}, chunks({4, 2}));
  });
  expect_refused("missing", [](hid_t file) {  // never written
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {4, 3}, chunks({4, 3}));
  });
  expect_refused("by frame", [](hid_t file) {
    replace(file, "/meshes/ulna/positions", H5T_IEEE_F32LE, {3, 4, 3}, chunks({1, 4, 3}));
  });
  expect_refused("positions", [](hid_t file) { H5Ldelete(file, "/meshes/ulna/positions", 0); });
  expect_refused("kind", [](hid_t file) {
    const hid_t group = H5Gopen2(file, "/meshes/ulna", H5P_DEFAULT);
    H5Adelete(group, "kind");
    H5Gclose(group);
  });
}

TEST_F(ForeignTest, ClaimsOfMoreThanItHolds) {
  // 10^12 numbers in a file of some kilobytes, in one chunk or in many.
  expect_refused("room", [](hid_t file) {
    replace(file, "/meshes/ulna/rest", H5T_IEEE_F64LE, {170'000'000, 3}, chunks({170'000'000, 3}));
  });
  expect_refused("room", [](hid_t file) {
    replace(file, "/meshes/ulna/positions", H5T_IEEE_F32LE, {80'000'000'000, 4, 3},
            chunks({1, 4, 3}));
  });
}

}  // namespace
}  // namespace thew::tests
