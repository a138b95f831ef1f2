// SPDX-License-Identifier: Apache-2.0
#include "rig/clip.h"

#include "rig/math.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

Skeleton arm() {
  Skeleton s;
  s.body_names = {"torso", "humerus", "ulna", "slider", "hand"};
  s.joint_names = {"", "shoulder_elevation", "elbow", "slide", "wrist"};
  s.parent = {-1, 0, 1, 2, 3};
  using Type = Skeleton::JointType;
  s.joint_types = {Type::kFixed, Type::kRevolute, Type::kRevolute, Type::kPrismatic, Type::kFixed};
  s.joint_axes.assign(5, Vec3::UnitZ());
  s.joint_in_parent.assign(5, Transform::Identity());
  s.lower = {0.0, -90 * kDegree, 0.0, 0.0, 0.0};
  s.upper = {0.0, 130 * kDegree, 130 * kDegree, 0.1, 0.0};
  s.visuals.resize(5);
  return s;
}

Clip elbow_clip(std::vector<double> times, std::vector<double> values) {
  Clip clip;
  clip.joints = {"elbow"};
  clip.times = std::move(times);
  for (double v : values) clip.values.push_back({v});
  return clip;
}

double elbow_at(const Clip& clip, double time) {
  std::vector<double> values;
  sample_clip(clip, arm(), time, values);
  EXPECT_EQ(values.size(), 5u);
  EXPECT_EQ(values[1], 0.0);  // no column: zero
  return values[2];
}

TEST(SampleClip, ExactAtKeysAndHeldOutside) {
  Clip clip = elbow_clip({0.1, 0.4, 1.3, 2.0}, {0.1, 2.2, 0.7, 0.3});
  for (auto kind : {Clip::Interpolation::kLinear, Clip::Interpolation::kSmooth}) {
    clip.interpolation = kind;
    for (size_t k = 0; k < 4; ++k) EXPECT_EQ(elbow_at(clip, clip.times[k]), clip.values[k][0]);
    EXPECT_EQ(elbow_at(clip, -5.0), 0.1);
    EXPECT_EQ(elbow_at(clip, 50.0), 0.3);
  }
  EXPECT_EQ(elbow_at(elbow_clip({1.0}, {0.7}), 3.0), 0.7);
}

TEST(SampleClip, LinearHalfWay) {
  Clip clip = elbow_clip({0.0, 2.0}, {1.0, 2.0});
  clip.interpolation = Clip::Interpolation::kLinear;
  EXPECT_EQ(elbow_at(clip, 1.0), 1.5);
  EXPECT_EQ(elbow_at(clip, 0.5), 1.25);
}

TEST(SampleClip, SmoothIsMonotoneBetweenKeysAndC1) {
  const Clip clip = elbow_clip({0.0, 0.1, 0.9, 1.0, 2.0, 2.5}, {0.0, 0.01, 0.02, 2.0, 2.1, 0.5});
  double before = elbow_at(clip, -0.5), slope_before = 0.0;
  const double h = 1e-4;
  for (int i = 1; i <= 35000; ++i) {
    const double t = -0.5 + i * h, value = elbow_at(clip, t);
    ASSERT_TRUE(t < 2.0 ? value >= before : t < 2.0 + h || value <= before) << t;
    const double slope = (value - before) / h;
    ASSERT_LT(std::fabs(slope - slope_before), 0.25) << t;  // second derivative below 2,500 rad/s^2
    before = value;
    slope_before = slope;
  }
}

TEST(SampleClip, SmoothKeepsAStraightLineInside) {
  const Clip clip = elbow_clip({0.0, 1.0, 2.0, 3.0}, {0.0, 0.5, 1.0, 1.5});
  for (double t = 1.0; t <= 2.0; t += 0.07) EXPECT_NEAR(elbow_at(clip, t), 0.5 * t, 1e-15);
}

TEST(CheckClip, ClampsWithinHalfADegreeAndRefusesMore) {
  std::vector<std::string> warnings;
  Clip slight = elbow_clip({0.0, 1.0}, {-0.4 * kDegree, 130.5 * kDegree});
  check_clip(slight, arm(), "a.mot", warnings);
  EXPECT_EQ(slight.values[0][0], 0.0);
  EXPECT_EQ(slight.values[1][0], 130 * kDegree);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "a.mot: joint \"elbow\": 2 of 2 keys clamped to [0 deg, 130 deg], by at most 0.5 deg");
  Clip far = elbow_clip({0.0, 1.0}, {0.0, 131 * kDegree});
  const std::string message = input_error([&] { check_clip(far, arm(), "a.mot", warnings); });
  EXPECT_HAS(message, "a.mot: joint \"elbow\" is 131 deg at 1 s, outside its range");
}

TEST(CheckClip, SlideByHalfAMillimetre) {
  std::vector<std::string> warnings;
  Clip clip = elbow_clip({0.0}, {0.1004});
  clip.joints = {"slide"};
  check_clip(clip, arm(), "a", warnings);
  EXPECT_EQ(clip.values[0][0], 0.1);
  EXPECT_EQ(warnings.size(), 1u);
  clip.values[0][0] = 0.1006;
  EXPECT_HAS(input_error([&] { check_clip(clip, arm(), "a", warnings); }), "0.1006 m");
  clip.values[0][0] = 0.05;
  clip.angles_only = true;
  EXPECT_HAS(input_error([&] { check_clip(clip, arm(), "a", warnings); }), "prismatic");
}

TEST(CheckClip, RefusesByName) {
  std::vector<std::string> warnings;
  const auto error_of = [&](const char* joint, double value) {
    Clip clip = elbow_clip({0.0}, {value});
    clip.joints = {joint};
    return input_error([&] { check_clip(clip, arm(), "a.csv", warnings); });
  };
  EXPECT_EQ(error_of("elbow", 1.0), "");
  EXPECT_HAS(error_of("elbw", 1.0), "not in the rig; did you mean \"elbow\"?");
  EXPECT_HAS(error_of("wrist", 0.0), "is fixed");
  EXPECT_HAS(error_of("elbow", std::nan("")), "not finite");
  Clip unsorted = elbow_clip({0.0, 0.0}, {0.0, 0.1});
  EXPECT_HAS(input_error([&] { check_clip(unsorted, arm(), "a", warnings); }), "not after");
  Clip ragged = elbow_clip({0.0, 1.0}, {0.0, 0.1});
  ragged.values[1].push_back(0.0);
  EXPECT_HAS(input_error([&] { check_clip(ragged, arm(), "a", warnings); }), "2 values for 1");
  Clip twice = ragged;
  twice.joints = {"elbow", "elbow"};
  twice.values = {{0, 0}, {0, 0}};
  EXPECT_HAS(input_error([&] { check_clip(twice, arm(), "a", warnings); }), "two columns");
  Clip empty;
  EXPECT_HAS(input_error([&] { check_clip(empty, arm(), "a", warnings); }), "no keys");
}

class ClipFile : public TempFolder {
 protected:
  std::string mot_error(const std::string& text) {
    const auto file = write("a.mot", text);
    return input_error([&] { read_mot(file, {{"flex", "elbow"}, {"pelvis", ""}}); });
  }
  std::string csv_error(const std::string& text) {
    const auto file = write("a.csv", text);
    return input_error([&] { read_csv(file, {{"elbow_deg", "elbow"}}); });
  }
};

const std::string kHead = "motion\nnRows=2\nnColumns=3\ninDegrees=yes\nendheader\n";
const std::string kLabels = "time\tflex\tpelvis\n";

TEST_F(ClipFile, AValueBeyondItsRangeIsNamedByFileAndRow) {
  std::vector<std::string> warnings;
  const std::filesystem::path csv = write("a.csv", "time,elbow_deg\n0,10\n\n1,131\n");
  Clip of_csv = read_csv(csv, {{"elbow_deg", "elbow"}});
  EXPECT_HAS(input_error([&] { check_clip(of_csv, arm(), "scene.toml:4", warnings); }),
             csv.string() + ":4: joint \"elbow\" is 131 deg at 1 s, outside its range");
  const std::filesystem::path mot =
      write("a.mot", "inDegrees=yes\nendheader\ntime flex\n0 10\n1 20\n2 -1\n");
  Clip of_mot = read_mot(mot, {{"flex", "elbow"}});
  EXPECT_HAS(input_error([&] { check_clip(of_mot, arm(), "scene.toml:4", warnings); }),
             mot.string() + ":6: joint \"elbow\" is -1 deg at 2 s, outside its range");
}

TEST_F(ClipFile, MotInDegreesAndRadians) {
  const ColumnMap map{{"flex", "elbow"}, {"pelvis", ""}};
  std::string text = kHead + kLabels + "0 90 7\r\n  0.5\t+45.0 8\n\n";
  const Clip degrees = read_mot(write("a.mot", text), map);
  EXPECT_EQ(degrees.joints, std::vector<std::string>{"elbow"});
  EXPECT_EQ(degrees.times, (std::vector<double>{0.0, 0.5}));
  EXPECT_EQ(degrees.values[0], std::vector<double>{90 * kDegree});
  EXPECT_EQ(degrees.values[1], std::vector<double>{45 * kDegree});
  EXPECT_TRUE(degrees.angles_only);
  text.replace(text.find("yes"), 3, "no");
  const Clip radians = read_mot(write("a.mot", text), map);
  EXPECT_EQ(radians.values[0][0], 90.0);
  EXPECT_FALSE(radians.angles_only);
}

TEST_F(ClipFile, MotErrorsNameTheLine) {
  const std::string rows = "0 90 7\n0.5 45 8\n";
  EXPECT_EQ(mot_error(kHead + kLabels + rows), "");
  EXPECT_HAS(mot_error(kHead + kLabels + "0 90 7\n0.5 45\n"), "a.mot:8: the row has 2 values");
  EXPECT_HAS(mot_error(kHead + kLabels + "0 90 7\n0.5 4,5 8\n"), "a.mot:8: column 2: \"4,5\"");
  EXPECT_HAS(mot_error(kHead + kLabels + "0 nan 7\n0.5 45 8\n"), "a.mot:7: column 2: \"nan\"");
  EXPECT_HAS(mot_error(kHead + kLabels + "0.5 90 7\n0.5 45 8\n"), "a.mot:8: time 0.5");
  EXPECT_HAS(mot_error(kHead + kLabels + "0 90 7\n"), "1 rows, but nRows=2");
  EXPECT_HAS(mot_error(kHead + kLabels), "no rows");
  EXPECT_HAS(mot_error(kHead + "time flex\n" + rows), "2 column labels, but nColumns=3");
  EXPECT_HAS(mot_error(kHead + "t flex pelvis\n" + rows), "first column is \"t\"");
  EXPECT_HAS(mot_error(kHead + "time flex knee\n" + rows), "no column \"pelvis\"");
  EXPECT_HAS(mot_error(kHead + "time flax pelvis\n" + rows), "did you mean \"flax\"?");
  EXPECT_HAS(mot_error(kHead), "column labels are missing");
  EXPECT_HAS(mot_error("motion\n"), "no endheader");
  EXPECT_HAS(mot_error("nColumns=x\nendheader\n"), "a.mot:1: \"x\" is not a count");
  EXPECT_HAS(mot_error("endheader\n" + kLabels + rows), "no inDegrees");
  EXPECT_HAS(mot_error("inDegrees=maybe\nendheader\n"), "write yes or no");
  EXPECT_HAS(input_error([&] { read_mot(folder / "none.mot", {}); }), "no such file");
  const auto file = write("b.mot", kHead + kLabels + rows);
  EXPECT_HAS(input_error([&] {
               read_mot(file, {{"flex", "elbow"}});
             }),
             "\"pelvis\" is mapped to no");
  const ColumnMap both{{"flex", "elbow"}, {"pelvis", "elbow"}};
  EXPECT_HAS(input_error([&] { read_mot(file, both); }), "two columns");
}

TEST_F(ClipFile, Csv) {
  const auto file =
      write("a.csv", "\xEF\xBB\xBFtime, elbow_deg ,slide\r\n0,90,0.01\r\n1,0,0.02\r\n");
  const Clip clip = read_csv(file, {{"elbow_deg", "elbow"}, {"slide", "slide"}});
  EXPECT_EQ(clip.joints, (std::vector<std::string>{"elbow", "slide"}));
  EXPECT_EQ(clip.values[0], (std::vector<double>{90 * kDegree, 0.01}));
  EXPECT_EQ(clip.values[1], (std::vector<double>{0.0, 0.02}));
}

TEST_F(ClipFile, CsvErrors) {
  EXPECT_HAS(csv_error(""), "empty");
  EXPECT_HAS(csv_error("time;elbow_deg\n0;1\n"), "parted by commas");
  EXPECT_HAS(csv_error("time,elbow_deg\n0,1\n1,\n"), "a.csv:3: column 2: \"\"");
  EXPECT_HAS(csv_error("time,elbow_deg\n0,1,2\n"), "a.csv:2: the row has 3 values");
  EXPECT_HAS(csv_error("time,elbow_deg,elbow_deg\n0,1,2\n"), "twice");
  EXPECT_HAS(csv_error("time,elbow_deg\n"), "no rows");
}

TEST(RealClip, RecordedElbowFlexion) {
  const auto file = std::filesystem::path(THEW_SHARED_DATA) / "arm26_elbow_flexion.mot";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  Clip clip =
      read_mot(file, {{"r_elbow_flex", "elbow"}, {"r_shoulder_elev", "shoulder_elevation"}});
  EXPECT_EQ(clip.times.size(), 121u);
  EXPECT_EQ(clip.times.back(), 1.0);
  EXPECT_EQ(clip.joints, (std::vector<std::string>{"shoulder_elevation", "elbow"}));
  EXPECT_NEAR(clip.values[0][1], -0.05440752 * kDegree, 1e-17);
  std::vector<std::string> warnings;
  check_clip(clip, arm(), file.filename().string(), warnings);
  EXPECT_EQ(clip.values[0][1], 0.0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_HAS(warnings[0], "joint \"elbow\": 1 of 121 keys clamped");
  std::vector<double> values;
  sample_clip(clip, arm(), 1.0, values);
  EXPECT_NEAR(values[2] / kDegree, 90.17066638, 1e-12);
}

}  // namespace
}  // namespace thew::tests
