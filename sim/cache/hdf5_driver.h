// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <hdf5.h>

#include <cstdint>

namespace thew::sim {

/// Sets file access properties by which HDF5, in a reader's child process, reads the file that the
/// parent has opened for it; the child itself may open nothing. H5Fopen with these properties
/// ignores the name. Returns the size of the file in bytes, 0 where there is none.
std::uint64_t use_file_of_child(hid_t access);

}  // namespace thew::sim
