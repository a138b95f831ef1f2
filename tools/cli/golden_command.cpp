// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/cache/durable_file.h"
#include "sim/scene/reader.h"
#include "sim/scene/scene.h"
#include "tools/base/printing.h"
#include "tools/base/temporary_folder.h"
#include "tools/cli/commands.h"
#include "tools/compare/golden_files.h"
#include "tools/render/gl_context.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

// Small enough for a repository, large enough for a camera nudged by half a pixel to show.
constexpr const char* kSize = "render.size=[320, 180]";

// First, middle and last frame.
std::string some_frames(const CommandOptions& options) {
  const Scene scene = read_scene(options.input, options.overrides);
  const int first = scene.first_frame, last = scene.last_frame;
  const auto text = [](int frame) { return std::to_string(frame); };
  return text(first) + "," + text(first + (last - first) / 2) + "," + text(last);
}

// What the command line says, else what the goldens were made with.
GoldenRecipe recipe_for_update(const CommandOptions& options, const fs::path& golden) {
  GoldenRecipe recipe;
  if (has_goldens(golden)) recipe = read_recipe(golden);
  if (!options.overrides.empty()) recipe.set = options.overrides;
  if (!options.frames.empty()) recipe.frames = options.frames;
  if (recipe.frames.empty()) recipe.frames = some_frames(options);
  return recipe;
}

// Bakes the scene and draws it into `folder`, from nothing: what an earlier run has left there may
// be another program's. What is not Thew's stays, and ends it where it is in the way.
ExitCode bake_afresh(const CommandOptions& options, const GoldenRecipe& recipe,
                     const fs::path& folder) {
  CommandOptions bake = options;
  check_replaceable(folder / "frames", fs::file_type::directory);
  for (const auto& [name, about] : own_files(folder / "frames")) {
    remove_own(folder / "frames" / name);
  }
  claim({folder / "bake.h5"}, options.overwrite);
  remove_own(folder / "bake.h5");
  bake.out = folder;
  bake.frames = recipe.frames;
  bake.overrides = recipe.set;
  bake.overrides.push_back("output.precision=double");
  bake.pictures = bake.json = bake.resume = false;
  const ExitCode bounds = bake_command(bake);

  choose_driver("softpipe");  // the same pixels on every processor
  CommandOptions render = options;
  render.input = folder / "bake.h5";
  render.out = folder / "frames";
  render.frames.clear();
  render.json = false;
  render.overrides = {kSize};
  render.overrides.insert(render.overrides.end(), recipe.set.begin(), recipe.set.end());
  render_command(render, options.input);
  return bounds;
}

bool nothing_moved(const Comparison& comparison) {
  if (!comparison.geometry->same_hash || !comparison.same()) return false;
  for (const ImageComparison& image : comparison.images) {
    if (image.measures.largest > 0 || image.expected_renderer != image.actual_renderer)
      return false;
  }
  return true;
}

struct Moves {
  bool any = true;
  std::string text;
  std::optional<Comparison> comparison;
};

Moves what_moves(const fs::path& golden, const fs::path& baked) {
  if (!has_goldens(golden)) return {true, golden.string() + ": first goldens\n", {}};
  try {
    const Comparison comparison = compare(golden, baked, {});
    return {!nothing_moved(comparison), comparison_as_text(comparison), comparison};
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kRetry) throw;
    return {true, std::string("the old goldens cannot be compared: ") + error.what() + "\n", {}};
  }
}

void tell(const Moves& moves, const fs::path& golden, bool as_json) {
  if (!as_json) {
    return print(moves.text + golden.string() +
                 (moves.any ? ": rewritten\n" : ": nothing moved, left as they are\n"));
  }
  nlohmann::ordered_json json = {{"golden", golden.string()}, {"rewritten", moves.any}};
  if (moves.comparison) {
    json["comparison"] = nlohmann::ordered_json::parse(comparison_as_json(*moves.comparison));
  } else {
    json["note"] = moves.text;
  }
  print_json(json);
}

}  // namespace

ExitCode golden_update_command(const CommandOptions& options, const fs::path& golden) {
  check_goldens(golden, options.overwrite);
  const GoldenRecipe recipe = recipe_for_update(options, golden);
  std::optional<TemporaryFolder> temporary;
  if (options.out.empty()) temporary.emplace("golden");
  const fs::path folder = temporary ? temporary->path() : options.out;
  bake_afresh(options, recipe, folder);
  const Moves moves = what_moves(golden, folder);
  if (moves.any) keep_goldens(folder, recipe, golden, options.overwrite);
  tell(moves, golden, options.json);
  return ExitCode::kDone;
}

ExitCode golden_check_command(const CommandOptions& options, const fs::path& golden,
                              const CompareOptions& limits) {
  GoldenRecipe recipe = read_recipe(golden);
  recipe.set.insert(recipe.set.end(), options.overrides.begin(), options.overrides.end());
  std::optional<TemporaryFolder> temporary;
  if (options.out.empty()) temporary.emplace("golden");
  const fs::path folder = temporary ? temporary->path() : options.out;
  claim({folder / "compare.html"}, options.overwrite);
  const ExitCode bounds = bake_afresh(options, recipe, folder);
  const Comparison comparison = compare(golden, folder, limits);
  if (!comparison.same()) {
    if (temporary) temporary->keep();
    write_durably(folder / "compare.html", comparison_as_html(comparison));
  }
  print(options.json ? comparison_as_json(comparison) + "\n" : comparison_as_text(comparison));
  if (comparison.same()) return bounds;
  std::fprintf(stderr,
               "thew: expected, actual and difference: %s\n"
               "thew: if this is meant: thew golden update %s --golden %s\n",
               (folder / "compare.html").c_str(), options.input.c_str(), golden.c_str());
  return ExitCode::kDifferent;
}

}  // namespace thew::tools
