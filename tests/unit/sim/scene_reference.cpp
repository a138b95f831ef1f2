// SPDX-License-Identifier: Apache-2.0
// The declared keys against what the reader reads, and the page that is written of them.
#include <algorithm>
#include <set>

#include "rig/text.h"
#include "sim/scene/reader.h"
#include "sim/scene/reference.h"
#include "sim/scene/toml.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kEveryKey = fs::path(THEW_SOURCE_DIR) / "tests/scenes/every_key";

std::string joined(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

struct Given {
  std::string path;  ///< "muscle.material.shear"
  const Key* key;    ///< null: it is not declared
  TomlValue value;
};

// All keys of a table, and of the tables in it; not the names of the user's.
void gather(const TomlValue& table, const std::string& path, std::vector<Given>& all) {
  const auto sections = scene_sections();
  const auto section = std::find_if(sections.begin(), sections.end(),
                                    [&](const Section& one) { return one.path == path; });
  if (section == sections.end()) return;
  for (std::size_t i = 0; i < table.items.size(); ++i) {
    const std::string here = joined(path, table.keys[i]);
    const auto key = std::find_if(section->keys.begin(), section->keys.end(),
                                  [&](const Key& one) { return one.name == table.keys[i]; });
    all.push_back({here, key == section->keys.end() ? nullptr : &*key, table.items[i]});
    const TomlValue& value = table.items[i];
    if (value.type == TomlValue::Type::kTable) gather(value, here, all);
    for (const TomlValue& item : value.items) {
      if (value.type == TomlValue::Type::kArray && item.type == TomlValue::Type::kTable) {
        gather(item, here, all);
      }
    }
  }
}

std::vector<Given> keys_in(const std::string& scene) {
  std::vector<Given> all;
  gather(read_toml(kEveryKey / scene), "", all);
  return all;
}

// What is read has to be declared and what is declared has to be read: the scenes hold every key,
// and the reader refuses a key that it does not ask for.
TEST(SceneReference, HasTheKeysThatScenesHave) {
  std::set<std::string> declared, given;
  for (const Section& section : scene_sections()) {
    for (const Key& key : section.keys) {
      EXPECT_TRUE(declared.insert(joined(section.path, key.name)).second) << key.name;
      EXPECT_EQ(std::string(key.meaning).back(), '.') << key.name;
    }
  }
  for (const char* scene : {"scene.toml", "character.toml", "cached.toml"}) {
    EXPECT_NO_THROW(read_scene(kEveryKey / scene));
    for (const Given& one : keys_in(scene)) given.insert(one.path);
  }
  EXPECT_EQ(declared, given);
}

// Values that the declaration of a key does not allow.
std::vector<std::string> wrong_values(const Key& key) {
  const std::string beyond = number_text(2.0 * key.range.most + 1.0);
  switch (key.type) {
    case KeyType::kNumber:
    case KeyType::kInteger:
    case KeyType::kLength:
      return {beyond, "\"text\"", number_text(2.0 * std::min(key.range.least, 0.0) - 1.0)};
    case KeyType::kVector:
    case KeyType::kDirection:
      return {"[" + beyond + ", 0, 1]", "1", "[1, 1]"};
    case KeyType::kPairs:
      return {"[[" + beyond + ", 0.5]]", "[[0, " + number_text(2.0 * key.second.most + 1.0) + "]]",
              "1"};
    case KeyType::kTruth:
      return {"1"};
    case KeyType::kTable:
    case KeyType::kTables:
      return {"1"};
    default:
      return {"1979-05-27"};
  }
}

TEST(SceneReference, TypesAndRangesAreThoseOfTheReader) {
  int tried = 0;
  for (const char* scene : {"scene.toml", "character.toml", "cached.toml"}) {
    for (const Given& one : keys_in(scene)) {
      ASSERT_TRUE(one.key) << one.path;
      for (const std::string& value : wrong_values(*one.key)) {
        const std::string setting = one.value.name + "=" + value;
        const std::string error = usage_error(kEveryKey / scene, {setting});
        EXPECT_STARTS(error, "--set " + one.value.name) << setting;
        ++tried;
      }
    }
  }
  EXPECT_GT(tried, 200);
}

// Another key may not go with the default; the default itself is never refused.
TEST(SceneReference, DefaultsAreAllowed) {
  int tried = 0;
  for (const char* scene : {"scene.toml", "character.toml", "cached.toml"}) {
    for (const Given& one : keys_in(scene)) {
      if (!one.key->standard) continue;
      std::string value = one.key->standard();
      const std::size_t sized = value.find(" × size");
      if (sized != value.npos) value.resize(sized);
      const std::string error = usage_error(kEveryKey / scene, {one.value.name + "=" + value});
      EXPECT_FALSE(error.starts_with("--set")) << error;
      ++tried;
    }
  }
  EXPECT_GT(tried, 60);
}

TEST(SceneReference, PageIsWhatTheDeclarationsSay) {
  const fs::path page = fs::path(THEW_SOURCE_DIR) / "sim/scene/reference.md";
  EXPECT_TRUE(fs::exists(page) && read_whole(page, 1 << 20) == scene_reference())
      << page << " is not what the declarations of the keys say; write it anew:\n"
      << "build/release/tools/thew inspect --keys > sim/scene/reference.md";
}

TEST_F(SceneFile, SmallSceneOfTheReference) {
  const std::string page = scene_reference(), begin = "```toml\n";
  const std::size_t first = page.find(begin) + begin.size();
  write("rig.urdf", "<robot/>");
  const fs::path file = write("small.toml", page.substr(first, page.find("```", first) - first));
  const Scene scene = read_scene(file);
  ASSERT_EQ(scene.muscles.size(), 1u);
  EXPECT_EQ(scene.last_frame, 24);
  EXPECT_EQ(scene.render.views[0].show, "muscles");
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_FALSE(read_scene(file, {"muscle.flexor.weights=left", "muscle.flexor.path.1.3=0.02"})
                   .muscles[0]
                   .weights.keys.empty());
}

TEST_F(SceneFile, KeyByItsOldName) {
  const fs::path file = scene("material = { young = 900, shear = 0.3 }\n");
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.muscles[0].material.stiffness, 900.0);
  EXPECT_EQ(scene.warnings,
            std::vector<std::string>{file.string() +
                                     ":13: the key muscle.biceps.material.young is called "
                                     "\"stiffness\" now; rename it"});
  EXPECT_EQ(usage_error(file, {"muscle.biceps.material.stiffness=5"}).substr(3),
            ": muscle.biceps.material.young is 900, but its new name, \"stiffness\", is given as "
            "well; remove it, or the one at --set muscle.biceps.material.stiffness");
  EXPECT_EQ(error_of("material = { young = 0 }\n"),
            ":13: muscle.biceps.material.young is 0; give a number from 1e-12 to 1e+12");
  EXPECT_TRUE(read_scene(this->scene("material = { stiffness = 900 }\n")).warnings.empty());
}

}  // namespace
}  // namespace thew::tests
