// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tools/base/output_file.h"

namespace thew::tools {

/// A crate, USD's binary container, of version 0.8: values as they come, then tables of tokens,
/// fields, paths and specs, and last where these stand.
/// A value's place: bit 63 an array, 62 the value itself in place of its place, 48-55 its type,
/// 0-47 its place, counted from the crate's first byte.
class Crate {
 public:
  using Rep = std::uint64_t;
  enum Type : std::uint8_t {
    kFloat = 8,
    kDouble = 9,
    kString = 10,
    kToken = 11,
    kAsset = 12,
    kMatrix = 15,
    kDictionary = 31,
    kTokenList = 32,
    kPathList = 34,
    kTokenVector = 41,
    kSpecifier = 42,
    kVariability = 44,
    kTimeSamples = 46,
    kDoubleVector = 48,
    kBool = 1
  };
  enum class Spec { kAttribute = 1, kPrim = 6, kRoot = 7, kRelationship = 8 };
  using Fields = std::vector<std::pair<std::string, Rep>>;

  /// Begins where `out` is.
  explicit Crate(ExportFile& out);

  static Rep inlined(Type type, std::uint32_t value);
  Rep token(const std::string& text) { return inlined(kToken, number_of(text)); }
  Rep string(const std::string& text);
  Rep asset(const std::string& place) { return inlined(kAsset, number_of(place)); }
  Rep number(double value);
  Rep number(float value);
  /// A list edit that puts these before what other layers have.
  Rep prepended(const std::vector<std::string>& tokens);
  /// A list edit that is these, by what add() has returned or will return for them.
  Rep paths(const std::vector<int>& numbers);
  Rep tokens(const std::vector<std::string>& texts);  ///< a list of names of prims or properties
  Rep strings(const std::vector<std::pair<std::string, std::string>>& entries);  ///< by key
  Rep samples(const std::vector<double>& times, const std::vector<Rep>& values);
  /// `count` values of one type in memory; the same again stands at the same place.
  Rep array(std::uint8_t type, std::size_t count, std::string_view bytes);
  Rep token_array(const std::vector<std::string>& texts);
  Rep value(std::uint8_t type, std::string_view bytes);

  /// The root first, then each prim or attribute after its parent: depth first, attributes before
  /// prims. Returns its number.
  int add(int parent, const std::string& name, Spec spec, const Fields& fields);
  /// Writes the tables.
  void finish();

 private:
  struct Node {
    int parent;
    std::int32_t name;  ///< a token's number, negative of an attribute
    Spec spec;
    std::uint32_t fields;  ///< where its set of fields begins
  };
  struct Section {
    const char* name;
    std::uint64_t place, size;
  };

  std::uint32_t number_of(const std::string& token);
  std::uint32_t string_number(const std::string& text);
  std::uint64_t place() const { return out_.size() - start_; }
  void align();
  template <typename Work>
  void section(const char* name, const Work& work);
  std::vector<std::int32_t> jumps() const;

  ExportFile& out_;
  std::uint64_t start_;
  std::vector<std::string> tokens_;
  std::unordered_map<std::string, std::uint32_t> token_numbers_;
  std::vector<std::uint32_t> strings_;  ///< numbers of tokens
  std::map<std::uint32_t, std::uint32_t> string_numbers_;
  std::vector<std::pair<std::uint32_t, Rep>> fields_;
  std::map<std::pair<std::uint32_t, Rep>, std::uint32_t> field_numbers_;
  std::vector<std::uint32_t> field_sets_;
  std::vector<Node> nodes_;
  std::vector<Section> sections_;
  std::unordered_map<std::string, Rep> kept_;  ///< by type and digest
};

}  // namespace thew::tools
