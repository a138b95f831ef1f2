// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace thew::sim {

/// Numbers of one name and shape, in the order of rows.
struct NamedArray {
  enum class Type { kInt32, kFloat32, kFloat64 };  ///< as a file holds them
  std::string name;
  Type type = Type::kFloat64;
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// Writes texts as attributes of the root, and arrays as datasets, into an HDF5 file that is listed
/// as ours. Equal content gives equal bytes. Error(kOutput).
void write_array_file(const std::filesystem::path& file,
                      const std::vector<std::pair<std::string, std::string>>& texts,
                      const std::vector<NamedArray>& arrays);

}  // namespace thew::sim
