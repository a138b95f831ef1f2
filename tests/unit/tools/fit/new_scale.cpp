// SPDX-License-Identifier: Apache-2.0
//
// Characters of other units: a humerus that no person has is made an adult's, unless --scale says
// otherwise.
#include <nlohmann/json.hpp>

#include "rig/text.h"
#include "tests/unit/tools/fit/new.h"

namespace thew::tests {
namespace {

class NewScale : public NewScene {
 protected:
  // The figure, whose humerus is 0.2629 m, so many times as large.
  fs::path sized(double times) {
    auto json = nlohmann::json::parse(read_whole(kFigure, size_t{1} << 20));
    const std::vector<double> scale(3, times);
    json["nodes"].push_back({{"name", "Unit"}, {"scale", scale}, {"children", {0, 10}}});
    json["scenes"][0]["nodes"] = {11};
    return write("sized.gltf", json.dump());
  }
  std::string scene(const fs::path& character, std::optional<double> scale, std::string& said) {
    NewOptions options = asked(character, "right");
    options.scale = scale;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const ExitCode code = new_command(options);
    said = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, ExitCode::kDone);
    return read_whole(options.out, size_t{1} << 20);
  }
};

size_t count_of(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(part, at)) != text.npos; at += part.size()) ++count;
  return count;
}

TEST_F(NewScale, WhatNoPersonHasIsMadeAnAdults) {
  std::string said;
  for (const auto& [times, factor] : {std::pair(100.0, "0.0122"), {0.4, "3.04"}}) {
    const std::string text = scene(sized(times), {}, said);
    EXPECT_HAS(text, std::string("\nscale = ") + factor + "\n");
    EXPECT_HAS(said, std::string("scaled by ") + factor + ":");
    EXPECT_HAS(said, "humerus 0.32");
    EXPECT_EQ(count_of(said, "scale"), 2u) << said;  // the one line, which names --scale 1
  }
}

TEST_F(NewScale, APersonIsLeftAsItIs) {
  std::string said;
  for (const double times : {0.78, 1.0, 1.69}) {  // 0.205 to 0.444 m
    EXPECT_EQ(scene(sized(times), {}, said).find("\nscale = "), std::string::npos) << times;
    EXPECT_EQ(count_of(said, "scale"), 0u) << said;
  }
}

TEST_F(NewScale, OneRefuses) {
  std::string said;
  EXPECT_EQ(scene(sized(0.5), 1.0, said).find("\nscale = "), std::string::npos);
  EXPECT_EQ(count_of(said, "left as --scale has it"), 1u) << said;
}

}  // namespace
}  // namespace thew::tests
