// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "rig/text.h"
#include "sim/cache/durable_file.h"
#include "sim/framing.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/health.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/progress.h"
#include "tools/base/signals.h"
#include "tools/cli/bake_folder.h"
#include "tools/cli/bake_report.h"
#include "tools/cli/commands.h"
#include "tools/cli/inspect_command.h"
#include "tools/inspect/repair.h"
#include "tools/render/pictures.h"
#include "tools/render/turntable.h"
#include "tools/report/viewer.h"

namespace thew::tools {
namespace {

static_assert(std::atomic<bool>::is_always_lock_free);

std::vector<int> frames_of(const CommandOptions& options, const Scene& scene) {
  if (!options.frames.empty()) {
    return parse_frames(options.frames, scene.first_frame, scene.last_frame);
  }
  std::vector<int> frames;
  for (int frame = scene.first_frame; frame <= scene.last_frame; ++frame) frames.push_back(frame);
  return frames;
}

constexpr std::size_t kLongestScene = std::size_t{4} << 20;  // bytes, as it was read

void print_plan(const Scene& scene, const Model& model, const std::vector<int>& frames,
                const CommandOptions& options) {
  size_t triangles = 0;
  for (const Muscle& muscle : model.muscles) triangles += muscle.rest.triangles.size();
  const auto& tolerance = model.solver.tolerance;
  if (options.json) {
    return print_json(
        {{"dry_run", true},
         {"scene", model.name},
         {"fps", model.fps},
         {"frames", frames},
         {"threads", thread_count(options.threads)},
         {"solver",
          {{"integrator", scene.solver.integrator},
           {"volume", scene.solver.volume},
           {"tolerance_m", tolerance ? nlohmann::ordered_json(tolerance->position) : nullptr}}},
         {"muscles", model.muscles.size()},
         {"triangles", triangles},
         {"bones", model.bones.size()},
         {"skin_triangles", model.skin.surface.triangles.size()},
         {"out", options.out.string()},
         {"warnings", model.warnings}});
  }
  const std::string solver = tolerance ? "within " + number_text(1e3 * tolerance->position) + " mm"
                                       : scene.solver.integrator;
  const auto text = [](auto count) { return std::to_string(count); };
  print(model.name + ": " + text(frames.size()) + " frames (" + text(frames.front()) + "-" +
        text(frames.back()) + ") at " + number_text(model.fps) + " fps, " +
        text(model.muscles.size()) + " muscles (" + text(triangles) + " triangles), " +
        text(model.bones.size()) + " bones, skin " + text(model.skin.surface.triangles.size()) +
        " triangles\n" + solver + ", volume " + scene.solver.volume + ", " +
        text(thread_count(options.threads)) + " threads, to " + options.out.string() + "\n");
}

BakeOutput output_of(const Scene& scene, const CommandOptions& options) {
  return {scene.output.double_precision, read_whole(scene.file, kLongestScene), options.command,
          options.directory};
}

// Null stands for what is not a number.
void write_failure(const CommandOptions& options, const Scene& scene, const StepFailure& failure) {
  const StepDiagnosis& diagnosis = failure.diagnosis;
  nlohmann::ordered_json json = {{"error", failure.what()},
                                 {"frame", failure.frame},
                                 {"scene", scene.name},
                                 {"command", options.command},
                                 {"directory", options.directory}};
  if (failure.substeps > 0) {
    json["substep"] = failure.diagnosis.substep;
    json["substeps"] = failure.substeps;
  }
  if (diagnosis.node >= 0) {
    json["part"] = diagnosis.part;
    json["nodes"] = {diagnosis.node};
    json["quantity"] = cause_text(diagnosis.cause).quantity;
    json["value"] = diagnosis.value;
    json["limit"] = diagnosis.limit;
    json["unit"] = cause_text(diagnosis.cause).unit;
  }
  write_durably(options.out / "failure.json", json_text(json, 2) + "\n");
}

// What a killed bake may lack when its cache is complete: pictures and report.
BakeResult read_result(const Model& model, const BakeReader& reader, const CommandOptions& options,
                       Pictures& pictures) {
  BakeResult result;
  result.hash = reader.info().hash;
  result.resumed_frames = static_cast<int>(reader.info().frames.size());
  result.threads = thread_count(options.threads);
  for (int i = 0; i < result.resumed_frames; ++i) {
    const BakeFrame frame = reader.read(i);
    result.measures.push_back(unflatten(model, reader.info().metric_names, frame.metrics));
    pictures.keep(frame);
  }
  return result;
}

// Of this bake, unless a kill or a hand has spoiled it.
std::optional<nlohmann::ordered_json> kept_report(const std::filesystem::path& folder,
                                                  const std::string& hash) {
  std::ifstream file(folder / "report.json");
  const auto report = nlohmann::ordered_json::parse(file, nullptr, false);
  if (!report.is_object() || !report.contains("hash") || report["hash"] != hash) return {};
  return report;
}

// Of a bake that is complete only a report that is still to be written wants it.
void plan_into(const Model& model, const CommandOptions& options, BakeResult& result) {
  StopWatch watch;
  result.plan = plan_fidelity(model, thread_count(options.threads), [] { stop_if_interrupted(); });
  result.seconds.plan = watch.lap();
}

// Pictures of those frames of a cache that are not there yet.
void draw_all(const BakeReader& reader, const std::vector<int>& frames,
              const CommandOptions& options, Pictures& pictures) {
  Progress progress(progress_style(options), "drawing", static_cast<int>(frames.size()), stderr);
  const std::vector<int>& baked = reader.info().frames;
  int done = 0;
  for (size_t i = 0; i < baked.size(); ++i) {
    if (!std::binary_search(frames.begin(), frames.end(), baked[i])) continue;
    pictures.draw(reader.read(static_cast<int>(i)));
    progress.step(++done, baked[i]);
    stop_if_interrupted();
  }
}

void print_drawn(const std::vector<int>& frames, const std::vector<std::filesystem::path>& files) {
  nlohmann::ordered_json json = {{"frames", frames}, {"files", nlohmann::ordered_json::array()}};
  for (const std::filesystem::path& file : files) json["files"].push_back(file.string());
  print_json(json);
}

ExitCode check_bounds(const Report& report, const CommandOptions& options) {
  ExitCode code = ExitCode::kDone;
  for (const Report::Bound& bound : report.bounds) {
    if (bound.met()) continue;
    std::fprintf(stderr, "thew: %sbound not met: %s is %.3g, the limit is %.3g\n",
                 options.bounds_fail ? "" : "warning: ", bound.quantity.c_str(), bound.measured,
                 bound.limit);
    if (options.bounds_fail) code = ExitCode::kDifferent;
  }
  return code;
}

// The folders in `folder` that hold frames of a bake, by name.
std::vector<std::filesystem::path> chunks_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> chunks;
  for (const std::filesystem::path& path : paths_in(folder)) {
    std::error_code error;
    if (std::filesystem::is_directory(path / "bake.parts", error)) chunks.push_back(path);
  }
  std::sort(chunks.begin(), chunks.end());
  return chunks;
}

void print_chunk(const CommandOptions& options, const std::vector<int>& frames) {
  const std::filesystem::path parts = options.out / "bake.parts";
  if (options.json) return print_json({{"frames", frames}, {"parts", parts.string()}});
  std::fprintf(stderr, "thew: %zu frames are in %s; --join puts such chunks together\n",
               frames.size(), parts.c_str());
}

/// Seconds since the command began, and those of its stages so far.
struct Clock {
  StopWatch whole, stage;
  Report::Seconds seconds;

  /// Pictures are drawn beside the other stages: what the stages have not used up to here is
  /// theirs. On the wall it is what the bake had to wait for them.
  void end_pictures() {
    Seconds others = seconds.setup;
    for (const Seconds& stage : {seconds.settle, seconds.rig, seconds.muscles, seconds.contact,
                                 seconds.skin, seconds.measure, seconds.write}) {
      others += stage;
    }
    seconds.total += whole.lap();
    seconds.render.wall += stage.lap().wall;
    seconds.render.cpu = seconds.total.cpu - others.cpu;
  }
};

void add_bake(const BakeSeconds& bake, Report::Seconds& seconds) {
  seconds.setup += bake.setup;
  seconds.settle = bake.settle;
  seconds.measure = bake.measure;
  seconds.write = bake.write;
  seconds.rig = bake.step.rig;
  seconds.muscles = bake.step.muscles;
  seconds.contact = bake.step.contact;
  seconds.skin = bake.step.skin;
}

// Report, and whether the scene's bounds are met.
ExitCode conclude(const Scene& scene, const Model& model, const CommandOptions& options,
                  const std::vector<int>& frames, const BakeResult& result, Pictures& pictures,
                  Clock& clock) {
  if (result.threads < thread_count(options.threads)) {
    std::fprintf(stderr, "thew: warning: only %d of %d threads could be started; allow more\n",
                 result.threads, thread_count(options.threads));
  }
  pictures.finish();
  const std::string no_movie = pictures.movies(frames, model.fps);
  std::filesystem::path sheet;
  const Image image = pictures.sheet(frames);
  if (image.width > 0) {
    sheet = pictures.sheet_file();
    write_png(sheet, image);
  }
  clock.end_pictures();
  Report report = make_report(scene, model, options, frames, result);
  if (!no_movie.empty()) report.warnings.push_back(no_movie);
  for (size_t i = model.warnings.size(); i < report.warnings.size(); ++i) {
    std::fprintf(stderr, "thew: warning: %s\n", report.warnings[i].c_str());
  }
  if (!image.renderer.empty()) report.origin.renderer = image.renderer;
  report.pictured = pictures.sheet_frames(frames);
  report.sheet_columns = pictures.sheet_columns(frames);
  report.files = files_beside_report(
      options.out, options.pictures ? scene.render.views : std::vector<SceneView>{});
  const std::string viewer = report_viewer(BakeReader(options.out / "bake.h5"));
  clock.seconds.report = clock.stage.lap();  // all of it but writing what says so
  clock.seconds.total += clock.whole.lap();
  report.seconds = clock.seconds;
  write_report(options.out, report, sheet, viewer);
  list_report(options.out, pictures.key());
  if (options.json) print(report_as_json(report));
  return check_bounds(report, options);
}

}  // namespace

ExitCode bake_command(const CommandOptions& options) {
  Clock clock;
  const Scene scene = read_scene(options.input, options.overrides);
  Model model = build_model(scene);
  const std::vector<int> frames = frames_of(options, scene);
  for (const std::string& line : rest_overlaps(model)) {
    model.warnings.push_back(options.input.string() + ": " + line);
  }
  for (const std::string& warning : model.warnings) {
    std::fprintf(stderr, "thew: warning: %s\n", warning.c_str());
  }
  const std::vector<SceneView> views = options.pictures && !options.chunk
                                           ? frame_views(model, scene.render)
                                           : std::vector<SceneView>{};
  if (options.dry_run) {
    print_plan(scene, model, frames, options);
    return ExitCode::kDone;
  }
  const BakeOutput output = output_of(scene, options);
  const BakeInfo info = bake_info(model, frames, output);
  const auto pictures_of = [&](const std::vector<BakeMesh>& meshes) {
    return std::make_unique<Pictures>(options.out / "frames", info.scene_hash, scene.render.width,
                                      scene.render.height, views, meshes);
  };
  const BakeStart start = look_into_folder(options, info);
  if (start == BakeStart::kComplete) {
    const FolderLock lock(options.out);
    const BakeReader reader(options.out / "bake.h5");
    const auto pictures = pictures_of(reader.info().meshes);
    pictures->claim(frames, options.overwrite);
    remove_own(options.out / "failure.json");
    BakeResult result = read_result(model, reader, options, *pictures);
    const auto kept = kept_report(options.out, reader.info().hash);
    if (kept && has_report(options.out, pictures->key()) && pictures->complete()) {
      std::fprintf(stderr, "thew: %s is complete; nothing to do%s\n", options.out.c_str(),
                   options.resume ? "" : ", --overwrite bakes anew");
      if (options.json) print_json(*kept);
      return check_bounds(make_report(scene, model, options, frames, result), options);
    }
    if (model.solver.tolerance) plan_into(model, options, result);
    clock.seconds.setup = clock.stage.lap();
    draw_all(reader, frames, options, *pictures);
    return conclude(scene, model, options, frames, result, *pictures, clock);
  }
  const auto pictures = pictures_of(info.meshes);
  pictures->claim(frames, options.overwrite);
  remove_own(options.out / "failure.json");
  Progress progress(progress_style(options), "baking", static_cast<int>(frames.size()), stderr);
  BakeResult result;
  clock.seconds.setup = clock.stage.lap();
  try {
    int done = 0;
    const auto on_frame = [&](const BakeFrame& frame) {
      StopWatch waiting;
      pictures->draw(frame);
      clock.seconds.render.wall += waiting.lap().wall;
      progress.step(++done, frame.frame);
      return !interrupted();
    };
    const BakeOptions how{
        options.out, frames,       thread_count(options.threads), start == BakeStart::kGoOn, output,
        interrupted, options.chunk};
    result = options.chunks.empty() ? bake(model, how, on_frame)
                                    : join_chunks(model, how, chunks_in(options.chunks), on_frame);
  } catch (const StepFailure& failure) {
    write_failure(options, scene, failure);
    throw;
  }
  if (options.chunk) {
    print_chunk(options, frames);
    return ExitCode::kDone;
  }
  clock.stage.lap();  // of the bake, by stage
  add_bake(result.seconds, clock.seconds);
  return conclude(scene, model, options, frames, result, *pictures, clock);
}

namespace {

// Of a scene all of whose cameras stand still, nothing else is looked at. Where it has no rig they
// go by what is drawn.
SceneRender render_of(const std::filesystem::path& file, const CommandOptions& options,
                      const BakeReader& bake, const std::vector<int>& frames) {
  SceneRender render = read_render(file, options.overrides);
  if (!follows_motion(render)) return render;
  if (!render.has_rig) {
    render.views = frame_views(bake, frames, render);
    return render;
  }
  const Model model = build_model(read_scene(file, options.overrides));
  if (model.hash != bake.info().scene_hash) {
    std::fprintf(stderr,
                 "thew: warning: %s is a bake of another scene or other settings than %s: the "
                 "cameras go by the latter's clip; give the bake's --set and --scene\n",
                 options.input.c_str(), file.c_str());
  }
  render.views = frame_views(model, render);
  return render;
}

}  // namespace

ExitCode render_command(const CommandOptions& options, const std::filesystem::path& scene_file,
                        int turntable) {
  if (scene_file.empty() && !options.overrides.empty()) {
    throw Error(ErrorCode::kUsage, "--set " + options.overrides.front() +
                                       " sets a key of a scene, but none is given; add --scene");
  }
  const BakeReader reader(options.input);
  const BakeInfo& info = reader.info();
  const std::vector<int> frames =
      options.frames.empty()
          ? info.frames
          : parse_frames(options.frames, info.frames.front(), info.frames.back());
  SceneRender render;
  if (!scene_file.empty()) render = render_of(scene_file, options, reader, frames);
  if (render.views.empty()) render.views = views_of(reader);
  if (turntable > 0) {
    if (frames.size() != 1 ||
        !std::binary_search(info.frames.begin(), info.frames.end(), frames[0])) {
      throw Error(ErrorCode::kUsage,
                  "--turntable turns about one frame of the bake; give it by "
                  "--frames " +
                      std::to_string(info.frames.front()));
    }
    std::vector<std::filesystem::path> files;
    const std::string no_movie = draw_turntable(reader, frames[0], render, turntable, options.out,
                                                options.overwrite, progress_style(options), files);
    if (!no_movie.empty()) std::fprintf(stderr, "thew: warning: %s\n", no_movie.c_str());
    if (options.json) print_drawn(frames, files);
    return ExitCode::kDone;
  }
  Pictures pictures(options.out, info.hash, render.width, render.height, render.views, info.meshes);
  pictures.claim(frames, options.overwrite);
  draw_all(reader, frames, options, pictures);
  pictures.finish(!options.chunk);
  const std::string no_movie = options.chunk ? "" : pictures.movies(frames, info.fps);
  if (!no_movie.empty()) std::fprintf(stderr, "thew: warning: %s\n", no_movie.c_str());
  if (options.json) print_drawn(frames, pictures.files(frames));
  return ExitCode::kDone;
}

ExitCode inspect_command(const CommandOptions& options, const std::filesystem::path& repaired,
                         const std::filesystem::path& maps) {
  if (std::error_code error; std::filesystem::is_directory(options.input, error)) {
    throw Error(ErrorCode::kInput, options.input.string() + ": is a folder; name a file in it");
  }
  if (!repaired.empty()) {
    const std::vector<std::string> done = repair_file(options.input, repaired, options.overwrite);
    for (const std::string& line : done) std::fprintf(stderr, "%s\n", line.c_str());
    if (done.empty()) std::fprintf(stderr, "nothing that could be repaired safely\n");
    CommandOptions again = options;
    again.input = repaired;
    return inspect_command(again, {}, {});
  }
  const Inspection inspection = maps.empty() ? inspect(options.input, options.json, options.frames)
                                             : inspect_maps(options.input, maps, options);
  print(inspection.text + (options.json ? "" : "\n"));
  return inspection.sound ? ExitCode::kDone : ExitCode::kInput;
}

}  // namespace thew::tools
