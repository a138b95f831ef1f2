// SPDX-License-Identifier: Apache-2.0
#include "rig/text.h"

#include <gtest/gtest.h>

namespace thew::tests {
namespace {

TEST(Text, WhatAForeignFileNamesStaysOnOneLine) {
  EXPECT_EQ(printable("bücher.toml:3: \"a b\" is 1.5 m"), "bücher.toml:3: \"a b\" is 1.5 m");
  EXPECT_EQ(printable("a\nb\x1b[31m\x7f"), "a\\x0ab\\x1b[31m\\x7f");
  EXPECT_EQ(printable(std::string(60000, 'x')).size(), 2004u);
}

TEST(Text, NamesFillALineAtMost) {
  EXPECT_EQ(names_text({}), "");
  EXPECT_EQ(names_text({"a", "b\n"}), "a, b\\x0a");
  EXPECT_EQ(names_text({std::string(60000, 'x'), "b"}), std::string(100, 'x') + " ..., b");
  const std::string all = names_text(std::vector<std::string>(300, "biceps"));
  EXPECT_LT(all.size(), 1100u);
  EXPECT_EQ(all.substr(all.rfind(',')), ", 174 more");
}

TEST(Text, NumbersThatAreNoneAreSaidInWords) {
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(1.0 / 0.0), "infinite");
  EXPECT_EQ(number_text(-1.0 / 0.0), "minus infinite");
  EXPECT_EQ(number_text(std::nan("")), "no number");
}

}  // namespace
}  // namespace thew::tests
