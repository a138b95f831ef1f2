// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "rig/types.h"

/// A folder of its own for each test, removed after it.
class TempFolder : public testing::Test {
 protected:
  TempFolder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder = std::filesystem::path(testing::TempDir()) /
             (std::string("thew_") + info->test_suite_name() + "_" + info->name() + "_" +
              std::to_string(getpid()));
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  ~TempFolder() override { std::filesystem::remove_all(folder); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }

  std::filesystem::path folder;
};

/// The message of the Error(kInput) that `call` throws; "" where it throws none.
template <typename Call>
std::string input_error(Call call) {
  try {
    call();
  } catch (const thew::Error& error) {
    EXPECT_EQ(error.code(), thew::ErrorCode::kInput);
    return error.what();
  }
  return "";
}

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)
