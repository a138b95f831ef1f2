// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "tools/export/ogawa.h"

namespace thew::tools {

/// A property of an Alembic object: samples by frame, or properties below it.
struct AbcProperty {
  enum Type : std::uint8_t { kCompound = 0, kScalar = 1, kArray = 2 };
  enum Number : std::uint8_t {
    kBool = 0,
    kUint8 = 1,
    kUint32 = 5,
    kInt32 = 6,
    kFloat32 = 10,
    kFloat64 = 11
  };

  std::string name, meta;  ///< meta: "key=value;…", keys rising
  Type type = kCompound;
  Number number = kFloat32;
  std::uint32_t extent = 1;  ///< numbers in a value
  std::vector<AbcProperty> below = {};
  std::vector<std::uint64_t> samples = {};  ///< their places in the file
};

struct AbcObject {
  std::string name, meta;
  std::vector<AbcProperty> properties = {};
  std::vector<AbcObject> children = {};
};

/// When samples are: the seconds of all, one cycle after another where `every` is not 0.
struct AbcTimes {
  std::uint32_t count = 0;
  double every = 0.0;           ///< s; 0: at uneven steps
  std::vector<double> seconds;  ///< of the first, or of all at uneven steps
};

/// An Alembic archive in Ogawa, of layout 1.7.9, as its reference library reads it.
class AbcArchive {
 public:
  explicit AbcArchive(const std::filesystem::path& file) : out_(file) {}

  /// The next sample. The same bytes stand in the file once, however many samples they are.
  void add(AbcProperty& property, const std::string& values);
  void finish(const AbcObject& top, const std::string& meta, const AbcTimes& times);

 private:
  struct Written {
    std::uint64_t place;
    std::string identity;  ///< of all that is below
  };
  std::uint32_t number_of(const std::string& text);
  std::string header(const AbcProperty& property);
  Written write(const std::vector<AbcProperty>& properties);
  Written write(const AbcProperty& property);
  Written write(const AbcObject& object);

  OgawaFile out_;
  std::uint32_t count_ = 0;         ///< of samples that there are
  std::vector<std::string> texts_;  ///< that many headers share, numbered from 1
  std::unordered_map<std::string, std::uint64_t> places_;   ///< by digest
  std::unordered_map<std::uint64_t, std::string> digests_;  ///< by place
};

}  // namespace thew::tools
