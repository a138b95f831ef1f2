// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "rig/text.h"

namespace thew {
namespace {

TEST(Text, WhatAForeignFileNamesStaysOnOneLine) {
  EXPECT_EQ(printable("bücher.toml:3: \"a b\" is 1.5 m"), "bücher.toml:3: \"a b\" is 1.5 m");
  EXPECT_EQ(printable("a\nb\x1b[31m\x7f"), "a\\x0ab\\x1b[31m\\x7f");
  EXPECT_EQ(printable(std::string(60000, 'x')).size(), 4004u);
}

TEST(Text, NumbersThatAreNoneAreSaidInWords) {
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(1.0 / 0.0), "infinite");
  EXPECT_EQ(number_text(-1.0 / 0.0), "minus infinite");
  EXPECT_EQ(number_text(std::nan("")), "no number");
}

}  // namespace
}  // namespace thew
