// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/array_file.h"

#include "sim/cache/durable_file.h"
#include "sim/cache/hdf5_file.h"

namespace thew::sim {
namespace {

hid_t hdf5_type(NamedArray::Type type) {
  switch (type) {
    case NamedArray::Type::kInt32:
      return H5T_STD_I32LE;
    case NamedArray::Type::kFloat32:
      return H5T_IEEE_F32LE;
    default:
      return H5T_IEEE_F64LE;
  }
}

}  // namespace

void write_array_file(const std::filesystem::path& file,
                      const std::vector<std::pair<std::string, std::string>>& texts,
                      const std::vector<NamedArray>& arrays) {
  const Temporary temporary(file);
  Hdf5File out(temporary.path, Hdf5File::Mode::kCreate);
  for (const auto& [name, text] : texts) out.write_attribute(out.root(), name, text);
  for (const NamedArray& array : arrays) {
    const Hdf5Dims dims(array.shape.begin(), array.shape.end());
    const hsize_t rows = dims.size() > 2 ? 1 : dims[0];  // of a chunk
    Hdf5Dataset dataset =
        out.create_dataset(out.root(), array.name, hdf5_type(array.type), dims, rows);
    const std::size_t each = array.values.size() / dims[0];
    for (hsize_t row = 0; row < dims[0]; row += rows) {
      out.write_chunk(dataset, H5T_NATIVE_DOUBLE, row, &array.values[row * each]);
    }
    out.close(dataset.id);
  }
  out.close();
  place_durably(temporary.path, file);
}

}  // namespace thew::sim
