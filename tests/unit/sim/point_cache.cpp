// SPDX-License-Identifier: Apache-2.0
// PC2 and MDD as they are read, and what is refused.
#include "sim/cache/point_cache.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

template <typename T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string pc2(std::int32_t points, std::int32_t samples, float step,
                const std::vector<float>& x) {
  std::string bytes("POINTCACHE2\0", 12);
  put<std::int32_t>(bytes, 1);
  put(bytes, points);
  put(bytes, 7.0f);
  put(bytes, step);
  put(bytes, samples);
  for (const float value : x) put(bytes, value);
  return bytes;
}

std::string mdd(const std::vector<float>& times, const std::vector<float>& x) {
  std::string bytes;
  const auto big = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    for (size_t k = sizeof value; k-- > 0;) bytes += raw[k];
  };
  big(static_cast<std::int32_t>(times.size()));
  big(static_cast<std::int32_t>(x.size() / 3 / times.size()));
  for (const float value : times) big(value);
  for (const float value : x) big(value);
  return bytes;
}

class PointCaches : public TempFolder {
 protected:
  std::string error_of(const std::string& name, const std::string& bytes, size_t points = 1) {
    const auto file = write(name, bytes);
    const std::string error = input_error([&] { read_point_cache(file, points, 24.0); });
    return error.empty() ? "" : error.substr(file.string().size());
  }
};

TEST_F(PointCaches, SaySamplesAndTheirTimes) {
  const std::vector<float> x = {1, 2, 3, 4, 5, 6};
  const MeshSamples a = read_point_cache(write("a.pc2", pc2(1, 2, 12, x)), 1, 24.0);
  EXPECT_EQ(a.times, (std::vector<double>{0.0, 0.5}));
  EXPECT_EQ(a.positions[1][0], Vec3(4, 5, 6));
  const MeshSamples b = read_point_cache(write("b.mdd", mdd({2.0f, 2.25f}, x)), 1, 24.0);
  EXPECT_EQ(b.times, (std::vector<double>{0.0, 0.25}));
  EXPECT_EQ(b.positions[0][0], Vec3(1, 2, 3));
}

TEST_F(PointCaches, AreRefusedWithThePlaceAndTheNextMove) {
  const float nan = std::nanf("");
  EXPECT_HAS(error_of("a.pc2", pc2(1, 2, 1, {1, 2, 3, 4, nan, 6})),
             ": sample 1, point 0 lies at (4, no number, 6), which is no place; export it again");
  EXPECT_HAS(error_of("b.pc2", pc2(1, 3, 1, {1, 2, 3, 4, 5, 6})),
             ": has 24 bytes after its header in place of 36 for 3 samples");
  EXPECT_HAS(error_of("c.pc2", pc2(1, 2, 1, {1, 2, 3, 4, 5, 6}), 2),
             ": has 1 points, and its mesh 2 vertices");
  EXPECT_HAS(error_of("d.pc2", pc2(1, 1, 0, {1, 2, 3})), ": its samples are 0 frames apart");
  EXPECT_HAS(error_of("e.pc2", pc2(1, -4, 1, {})), ": has -4 samples");
  EXPECT_HAS(error_of("f.pc2", "POINTCACHE2"), ": is no PC2");
  EXPECT_HAS(error_of("g.pc2", pc2(1, 1, 1, {}).substr(0, 18)), ": its header is cut short");
  EXPECT_HAS(error_of("h.mdd", mdd({0.0f, 0.0f}, {1, 2, 3, 4, 5, 6})),
             ": sample 1 is at 0 s, which is not after the one before");
  EXPECT_HAS(error_of("i.mdd", mdd({0.0f, 1.0f}, {1, 2, 3, 4, 5, 6}) + "x"), ": has 33 bytes");
}

}  // namespace
}  // namespace thew::tests
