// SPDX-License-Identifier: Apache-2.0
#include "rig/import/urdf_import.h"
#include "rig/math.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

const char kArm[] = R"(<?xml version="1.0"?>
<robot name="arm">
  <!-- <deep><deep></deep> in a comment does not count -->
  <link name="torso"/>
  <link name="humerus">
    <visual><geometry><box size="1 1 1"/></geometry></visual>
    <visual>
      <origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/>
      <geometry><mesh filename="meshes/bone.stl" scale="1 2 1"/></geometry>
    </visual>
  </link>
  <link name="ulna"/>
  <link name="slider"/>
  <joint name="elbow" type="revolute">
    <parent link="humerus"/><child link="ulna"/>
    <origin xyz="0 -0.29 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="2.27" effort="1" velocity="1"/>
  </joint>
  <joint name="shoulder" type="continuous">
    <parent link="torso"/><child link="humerus"/><axis xyz="0.0494 0.0366 0.9981"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="ulna"/><child link="slider"/><axis xyz="0 1 0"/>
    <limit lower="-0.1" upper="0.2" effort="1" velocity="1"/>
  </joint>
</robot>
)";

class Urdf : public TempFolder {
 protected:
  Urdf() { write("meshes/bone.stl", "solid\nendsolid\n"); }

  // The arm with the first `from` replaced by `to`.
  std::string mutant(const std::string& from, const std::string& to) {
    std::string text = kArm;
    const size_t at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    text.replace(at, from.size(), to);
    return error_of(text);
  }
  std::string error_of(const std::string& text) {
    const auto file = write("arm.urdf", text);
    return input_error([&] { import_urdf(file, folder); });
  }
};

TEST_F(Urdf, ReadsTheArm) {
  const Skeleton s = import_urdf(write("arm.urdf", kArm), folder);
  EXPECT_EQ(s.body_names, (std::vector<std::string>{"torso", "humerus", "ulna", "slider"}));
  EXPECT_EQ(s.joint_names, (std::vector<std::string>{"", "shoulder", "elbow", "slide"}));
  EXPECT_EQ(s.parent, (std::vector<int>{-1, 0, 1, 2}));
  EXPECT_EQ(s.joint_in_parent[2].translation(), Vec3(0, -0.29, 0));
  EXPECT_EQ(s.upper[2], 2.27);
  EXPECT_EQ(s.lower[1], -std::numeric_limits<double>::infinity());
  EXPECT_EQ(s.joint_types[3], Skeleton::JointType::kPrismatic);
  EXPECT_NEAR(s.joint_axes[1].norm(), 1.0, 1e-15);
  ASSERT_EQ(s.visuals[1].size(), 1u);  // the box is no mesh
  const Skeleton::Visual& visual = s.visuals[1][0];
  EXPECT_EQ(visual.mesh_file, std::filesystem::canonical(folder / "meshes/bone.stl").string());
  EXPECT_EQ(visual.scale, Vec3(1, 2, 1));
  EXPECT_LT((visual.in_body * Vec3(1, 0, 0) - Vec3(0.1, 1, 0)).norm(), 1e-15);
}

TEST_F(Urdf, RpyTurnsAboutFixedXThenYThenZ) {
  std::string text = kArm;
  text.replace(text.find("xyz=\"0 -0.29 0\""), 15, "rpy=\"0.3 -0.7 1.1\"");
  const Skeleton s = import_urdf(write("arm.urdf", text), folder);
  const Mat3 expected =
      (Eigen::AngleAxisd(1.1, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.7, Vec3::UnitY()) *
       Eigen::AngleAxisd(0.3, Vec3::UnitX()))
          .toRotationMatrix();
  EXPECT_LT((s.joint_in_parent[2].linear() - expected).norm(), 1e-15);
}

TEST_F(Urdf, PackagePathsAreOfTheAllowedRoot) {
  for (const char* path : {"package://arm/meshes/bone.stl", "package://meshes/bone.stl"}) {
    std::string text = kArm;
    text.replace(text.find("meshes/bone.stl"), 15, path);
    const Skeleton s = import_urdf(write("arm.urdf", text), folder);
    EXPECT_EQ(s.visuals[1].size(), 1u) << path;
  }
}

TEST_F(Urdf, RefusesLimitsAndAxes) {
  EXPECT_HAS(mutant("lower=\"0\"", "lower=\"3\""), "lower limit 3 exceeds upper limit 2.27");
  EXPECT_HAS(mutant("lower=\"0\"", "lower=\"3\""), "arm.urdf:14: joint \"elbow\"");
  EXPECT_NE(mutant("lower=\"0\"", "lower=\"nan\""), "");
  EXPECT_HAS(mutant("0 0 1\"/>", "0 0 0\"/>"), "joint \"elbow\": its axis is (0, 0, 0)");
  EXPECT_HAS(mutant("0 0 1\"/>", "0 0 2\"/>"), "has length 2, not 1; write (0, 0, 1)");
  EXPECT_HAS(mutant("    <limit lower=\"0\" upper=\"2.27\" effort=\"1\" velocity=\"1\"/>\n", ""),
             "elbow");
  EXPECT_HAS(mutant("type=\"revolute\"", "type=\"floating\""), "not supported");
}

TEST_F(Urdf, NumbersThatAreNoPlacesAreRefusedWithTheirLine) {
  for (const char* far : {"1e200", "-1e308", "10001", "1e300"}) {
    const std::string x = far;
    EXPECT_HAS(mutant("xyz=\"0 -0.29 0\"", "xyz=\"0 " + x + " 0\""),
               "arm.urdf:16: joint \"elbow\": origin xyz=\"0 " + x + " 0\" is farther than 10 km");
    EXPECT_HAS(mutant("xyz=\"0.1 0 0\"", "xyz=\"" + x + " 0 0\""), "is farther than 10 km");
    EXPECT_NE(mutant("scale=\"1 2 1\"", "scale=\"1 " + x + "00 1\""), "");
    EXPECT_NE(mutant("1.5707963267948966\"", x + "\""), "");
    EXPECT_NE(mutant("upper=\"0.2\"", "upper=\"" + x + "\""), "");
    EXPECT_NE(mutant("upper=\"2.27\"", "upper=\"" + x + "\""), "");
  }
  for (const char* none : {"nan", "inf", "-inf", "1e999", "1,5", "0x10"}) {
    EXPECT_NE(mutant("xyz=\"0 -0.29 0\"", "xyz=\"0 " + std::string(none) + " 0\""), "") << none;
  }
  for (const char* scale : {"1e308", "-1e308", "1e7", "1e-9", "0"}) {
    EXPECT_HAS(mutant("scale=\"1 2 1\"", "scale=\"1 " + std::string(scale) + " 1\""),
               "is zero, not finite or no unit's");
  }
  EXPECT_EQ(mutant("xyz=\"0 -0.29 0\"", "xyz=\"0 -9999 0\""), "");
}

TEST_F(Urdf, AChainOfNearOriginsThatLeadsFarAwayIsRefused) {
  std::string text = "<robot name=\"chain\"><link name=\"l0\"/>";
  for (int i = 1; i < 5; ++i) {
    const std::string n = std::to_string(i);
    text += "<link name=\"l" + n + "\"/><joint name=\"j" + n +
            "\" type=\"fixed\"><parent link=\"l" + std::to_string(i - 1) + "\"/><child link=\"l" +
            n + "\"/><origin xyz=\"4000 0 0\"/></joint>";
  }
  EXPECT_HAS(error_of(text + "</robot>"), "link \"l3\" at rest lies at (12000, 0, 0) m, farther");
}

TEST_F(Urdf, RefusesWhatIsNoTree) {
  EXPECT_HAS(mutant("<axis xyz=\"0 0 1\"/>", "<mimic joint=\"shoulder\"/>"), "mimic");
  EXPECT_HAS(mutant("<parent link=\"torso\"/>", "<parent link=\"ulna\"/>"), "cycle");
  EXPECT_HAS(mutant("<link name=\"torso\"/>", "<link name=\"torso\"/><link name=\"hat\"/>"),
             "links \"torso\" and \"hat\" are both roots");
  EXPECT_HAS(mutant("<child link=\"slider\"/>", "<child link=\"humerus\"/>"),
             "link \"humerus\" hangs on joint \"shoulder\" already");
  EXPECT_HAS(mutant("<parent link=\"humerus\"/>", "<parent link=\"humrus\"/>"),
             "did you mean \"humerus\"?");
  EXPECT_HAS(mutant("joint name=\"slide\"", "joint name=\"elbow\""), "is also at line 14");
  EXPECT_HAS(mutant("link name=\"slider\"", "link name=\"ulna\""), "is also at line");
}

TEST_F(Urdf, RefusesMeshesThatAreMissingOrElsewhere) {
  EXPECT_HAS(mutant("meshes/bone.stl", "meshes/bones.stl"), "does not exist");
  EXPECT_HAS(mutant("meshes/bone.stl", "meshes"), "not a regular file");
  const char* outside[] = {"../../../../../../../../../../etc/passwd", "/etc/passwd",
                           "file:///etc/passwd", "package://../../../../../../../../etc/passwd"};
  for (const char* path : outside) EXPECT_HAS(mutant("meshes/bone.stl", path), "lies outside");
  EXPECT_HAS(mutant("meshes/bone.stl", "http://example.org/bone.stl"), "protocol");
  std::filesystem::create_symlink("/etc/passwd", folder / "meshes/link.stl");
  EXPECT_HAS(mutant("meshes/bone.stl", "meshes/link.stl"), "lies outside");
  EXPECT_HAS(mutant("scale=\"1 2 1\"", "scale=\"1 0 1\""), "scale");
}

TEST_F(Urdf, WhatUrdfdomOnlyLogsIsAnError) {
  EXPECT_HAS(mutant("<box size=\"1 1 1\"/>", "<box size=\"a b c\"/>"), "arm.urdf: ");
  EXPECT_HAS(mutant("<box size=\"1 1 1\"/>", ""), "arm.urdf");
  EXPECT_HAS(mutant("0 -0.29 0", "0 x 0"), "arm.urdf");
}

TEST_F(Urdf, DeepNestingIsRefusedBeforeParsing) {
  const auto nested = [](int levels) {
    std::string text = "<robot name=\"r\"><link name=\"a\"/>";
    for (int i = 0; i < levels; ++i)
      text += "<x a='/>'>";  // a quoted /> does not close the element
    for (int i = 0; i < levels; ++i) text += "</x>";
    return text + "</robot>";
  };
  EXPECT_EQ(error_of(nested(199)), "");
  EXPECT_HAS(error_of(nested(200)), "nested deeper than 200");
  EXPECT_HAS(error_of(nested(200000)), "nested deeper than 200");
}

TEST_F(Urdf, RefusesWhatIsNoUrdf) {
  EXPECT_HAS(error_of(""), "arm.urdf");
  EXPECT_HAS(error_of("<sdf/>"), "no <robot>");
  EXPECT_HAS(error_of("<robot name='r'><link name='a'></robot>"), "not well-formed");
  EXPECT_HAS(error_of(std::string("<robot name='r'>\0</robot>", 26)), "zero byte");
  EXPECT_HAS(error_of("<robot name='r'/>"), "no links");
  EXPECT_HAS(error_of(std::string((16u << 20) + 1, ' ')), "16 MiB");
  EXPECT_HAS(input_error([&] { import_urdf(folder / "none.urdf", folder); }), "no such file");
  EXPECT_HAS(input_error([&] { import_urdf(folder, folder); }), "not a regular file");
}

}  // namespace
}  // namespace thew::tests
