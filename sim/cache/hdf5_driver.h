// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <hdf5.h>

#include <cstdint>

namespace thew::sim {

/// Lets HDF5 read the file of a reader's child by the descriptor that its parent opened, as the
/// child can open nothing: H5Fopen with these properties takes any name. The number of its bytes;
/// 0 where there is no such file.
std::uint64_t use_file_of_child(hid_t access);

}  // namespace thew::sim
