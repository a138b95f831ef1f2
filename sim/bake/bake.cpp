// SPDX-License-Identifier: Apache-2.0
#include "sim/bake/bake.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <utility>

#include "muscles/weights.h"
#include "rig/text.h"
#include "sim/cache/cache_parts.h"
#include "sim/lone_frame.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"

namespace thew::sim {
namespace {

std::vector<Vec3> to_points(const Points& rows) {
  std::vector<Vec3> points;
  points.reserve(rows.size());
  for (const Point& row : rows) points.push_back(to_vec(row));
  return points;
}

std::vector<BodyFrame> body_frames(const std::vector<Affine>& bodies) {
  std::vector<BodyFrame> frames(bodies.size());
  for (size_t b = 0; b < frames.size(); ++b) {
    Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(frames[b].data()) =
        bodies[b].matrix().topRows<3>();
  }
  return frames;
}

constexpr size_t kLinePoints = 33;  // of a line of action: it shows a bend, and costs a frame 400 B

std::vector<Vec3> line_of_action(const CarriedShape& shape, const CarriedPose& pose) {
  std::vector<Vec3> line(kLinePoints);
  Vec3 tangent;
  for (size_t k = 0; k < kLinePoints; ++k) {
    const double share = static_cast<double>(k) / (kLinePoints - 1);
    curve_at(shape, pose, share * shape.rest_path_length, line[k], tangent);
  }
  return line;
}

// s, what a killed bake has to simulate again at most. A state is five times as large as the
// positions of its frame.
constexpr double kMostRepeated = 0.5;

double wall_of(const StageSeconds& step) {
  return step.rig.wall + step.contact.wall + step.muscles.wall + step.skin.wall;
}

[[noreturn]] void stop_bake() { throw Error(ErrorCode::kRetry, "interrupted; run again"); }

// Sets all of a frame but its state. Adds to `measures` those of the written positions.
void set_frame(const Model& model, const BakeInfo& info, int number, const State& state,
               FrameMeasures& measures, BakeFrame& frame) {
  frame.frame = number;
  frame.positions.clear();
  for (size_t m = 0; m < state.muscles.size(); ++m) {
    frame.positions.push_back(in_file_order(model.muscles[m].order, to_points(state.muscles[m].x)));
  }
  for (const BoneState& bone : state.bones) frame.positions.push_back(to_points(bone.x));
  if (!state.skin.x.empty()) frame.positions.push_back(to_points(state.skin.x));
  frame.lines.assign(frame.positions.size(), {});
  for (size_t m = 0; m < state.muscles.size(); ++m) {
    if (info.meshes[m].line == 0) continue;
    frame.lines[m] = line_of_action(model.muscles[m].shape, state.muscles[m].pose);
  }
  frame.bodies.clear();
  if (model.skinned) frame.bodies = body_frames(state.bodies);
  measure_written(model, info, frame.positions, measures);
  frame.metrics = flatten(measures);
}

BakeMesh bake_mesh(const Muscle& muscle) {
  const FileOrder& order = muscle.order;
  // Normalised as in the paper, so that a scene may give them as a list and bake the same.
  const std::vector<char> all_free(muscle.authored_weights.size(), 0);
  BakeMesh mesh{muscle.name,
                BakeMesh::Kind::kMuscle,
                muscle.rest,
                normalised_weights(muscle.authored_weights, all_free),
                {}};
  for (size_t i = 0; muscle.shape.fixed_to.empty() && i < muscle.rest.vertices.size(); ++i) {
    mesh.coordinates.push_back(fibre_coordinates(muscle.shape, static_cast<int>(i)));
  }
  if (muscle.has_path()) mesh.line = kLinePoints;
  mesh.rest.vertices = in_file_order(order, std::move(mesh.rest.vertices));
  if (!order.node.empty()) mesh.rest.triangles = order.triangles;
  mesh.weights = in_file_order(order, std::move(mesh.weights));
  mesh.coordinates = in_file_order(order, std::move(mesh.coordinates));
  return mesh;
}

}  // namespace

BakeInfo bake_info(const Model& model, const std::vector<int>& frames, const BakeOutput& output) {
  BakeInfo info;
  info.scene_name = model.name;
  info.scene_hash = model.hash;
  info.part_hashes = model.part_hashes;
  info.scene_text = output.scene_text;
  info.command = output.command;
  info.directory = output.directory;
  info.fps = model.fps;
  info.double_precision = output.double_precision;
  info.frames = frames;
  info.metric_names = measure_names(model);
  for (const Muscle& muscle : model.muscles) {
    info.meshes.push_back(bake_mesh(muscle));
  }
  for (const Bone& bone : model.bones) {
    const auto kind = bone.prop ? BakeMesh::Kind::kProp : BakeMesh::Kind::kBone;
    info.meshes.push_back({bone.name, kind, bone.in_body, {}, {}});
  }
  if (model.has_skin) {
    TriMesh rest{to_points(model.skin.rest), model.skin.surface.triangles};
    info.meshes.push_back({"skin", BakeMesh::Kind::kSkin, std::move(rest), {}, {}});
  }
  if (model.skinned) {
    info.character = {model.character->file, model.character->scale,
                      body_frames(model.skinned->bodies)};
  }
  return info;
}

namespace {

// A scene with a tolerance, which is planned first.
BakeResult bake_as_planned(const Model& model, const BakeOptions& options,
                           const OnFrame& on_frame) {
  StopWatch watch;
  Model planned = model;
  const FidelityPlan plan = plan_fidelity(model, options.threads, [&] {
    if (options.stop && options.stop()) stop_bake();
  });
  planned.fidelity = plan.fidelity;
  const Seconds seconds = watch.lap();
  BakeResult result = bake(planned, options, on_frame);
  result.plan = plan;
  result.seconds.plan = seconds;
  result.seconds.setup += seconds;
  return result;
}

// Reads the frames that are there, up to which `state` is then brought by the newest of their
// states, and returns the last that need not be simulated again.
template <typename OnRead>
int read_completed(const Model& model, const BakeInfo& info, const BakeWriter& writer,
                   BakeResult& result, State& state, OnRead&& on_read) {
  int done = model.first_frame - 1;
  std::vector<double> newest_state;
  for (const int number : writer.completed()) {
    BakeFrame frame = writer.read_completed(number);
    result.measures.push_back(unflatten(model, info.metric_names, frame.metrics));
    const bool has_state = !frame.state.empty();
    if (has_state) newest_state.swap(frame.state);
    if (has_state || stands_alone(model) || number == info.frames.back()) done = number;
    ++result.resumed_frames;
    on_read(frame);
  }
  if (!newest_state.empty()) unpack_state(model, newest_state, state);
  return done;
}

// Writes one frame after another, each while the next one is computed: most of a frame's writing
// is waiting for the disk. Where no thread is to be had, a frame is written when it is waited for.
class FrameWriting {
 public:
  /// `on_written` is called for each frame once it is on the disk.
  FrameWriting(BakeWriter& writer, std::function<void(const BakeFrame&)> on_written)
      : writer_(writer), on_written_(std::move(on_written)) {}
  FrameWriting(const FrameWriting&) = delete;
  FrameWriting& operator=(const FrameWriting&) = delete;
  ~FrameWriting() {
    try {
      finish();
    } catch (...) {  // the error that ends the bake is told
    }
  }

  /// Waits for the frame before, and takes this one.
  Seconds start(BakeFrame& frame) {
    const Seconds spent = finish();
    std::swap(frame, frame_);
    writing_ = std::async([this] {
      const Parallel this_thread(1);
      StopWatch watch(this_thread);
      writer_.write(frame_);
      return watch.lap();
    });
    return spent;
  }
  /// What the processor has spent on it beside. Throws what the writing does.
  Seconds finish() {
    if (!writing_.valid()) return {};
    const Seconds spent{0.0, writing_.get().cpu};
    on_written_(frame_);
    return spent;
  }

 private:
  BakeWriter& writer_;
  std::function<void(const BakeFrame&)> on_written_;
  BakeFrame frame_;  // used again, so that its memory is
  std::future<Seconds> writing_;
};

}  // namespace

BakeResult bake(const Model& model, const BakeOptions& options, const OnFrame& on_frame) {
  if (model.solver.tolerance && !model.fidelity) return bake_as_planned(model, options, on_frame);
  StopWatch watch;
  const BakeInfo info = bake_info(model, options.frames, options.output);
  BakeWriter writer(options.folder, info, options.resume);
  std::optional<Parallel> threads(options.threads);
  Parallel& parallel = *threads;
  BakeResult result;
  result.threads = parallel.threads();
  BakeSeconds& seconds = result.seconds;
  seconds.setup = watch.lap();
  watch = StopWatch(parallel);  // pictures may be drawn beside
  State state = initial_state(model);
  Measuring measuring = start_measuring(model, state);

  const auto check_stop = [&] {
    if (options.stop && options.stop()) stop_bake();
  };
  const auto report_frame = [&](const BakeFrame& frame) {
    if (!on_frame(frame)) stop_bake();
    watch.lap();  // the caller's time is not measured
  };

  const bool alone = stands_alone(model);
  const int done = read_completed(model, info, writer, result, state, [&](const BakeFrame& frame) {
    seconds.setup += watch.lap();
    report_frame(frame);
  });
  seconds.setup += watch.lap();
  result.settled.converged = alone;
  if (done < model.first_frame && !alone) {
    result.settled = settle(model, parallel, state, check_stop);
  }
  seconds.settle = watch.lap();

  BakeFrame frame;          // used again, so that its memory is
  double next_state = 0.0;  // s of steps
  FrameWriting writing(writer, [&](const BakeFrame& written) {
    seconds.write += watch.lap();
    report_frame(written);
  });
  const std::vector<int>& there = writer.completed();
  const auto first = info.frames.begin() + static_cast<std::ptrdiff_t>(there.size());
  for (int number = done + 1; number <= info.frames.back(); ++number) {
    const double time = (number - model.first_frame) / model.fps;
    const bool written = std::binary_search(first, info.frames.end(), number);
    if (alone) {
      if (written) solve_lone_frame(model, time, parallel, state, seconds.step, check_stop);
    } else if (number > model.first_frame) {
      step_frame(model, time, parallel, state, seconds.step);
    }
    if (!written) {
      check_stop();
      continue;
    }
    watch.lap();  // step_frame() has measured it by stage
    FrameMeasures measures = measure(model, measuring, parallel, state);
    set_frame(model, info, number, state, measures, frame);
    seconds.measure += watch.lap();
    frame.state.clear();
    if (!alone && wall_of(seconds.step) >= next_state) {
      pack_state(state, frame.state);
      next_state = wall_of(seconds.step) + kMostRepeated;
    }
    seconds.write += writing.start(frame);
    result.measures.push_back(measures);
    seconds.write += watch.lap();
  }
  seconds.write += writing.finish();
  seconds.write += watch.lap();
  const Parallel this_thread(1);
  watch = StopWatch(this_thread);
  threads.reset();  // packing starts a process, and a limit of the system may count threads too
  if (!options.is_chunk) result.hash = writer.pack(check_stop);
  seconds.write += watch.lap();
  return result;
}

BakeResult join_chunks(const Model& model, const BakeOptions& options,
                       const std::vector<std::filesystem::path>& chunks, const OnFrame& on_frame) {
  StopWatch watch;
  const BakeInfo info = bake_info(model, options.frames, options.output);
  const std::map<int, PlacedPart> parts = parts_of_chunks(chunks, info);
  BakeWriter writer(options.folder, info, options.resume);
  BakeResult result;
  result.settled.converged = true;
  result.threads = options.threads;
  const auto check_stop = [&] {
    if (options.stop && options.stop()) stop_bake();
  };
  for (size_t i = 0; i < info.frames.size(); ++i) {
    const bool is_there = i < writer.completed().size();
    const PlacedPart& part = parts.at(info.frames[i]);
    const BakeFrame frame =
        is_there ? writer.read_completed(info.frames[i]) : read_part(part.folder, part.part, info);
    if (!is_there) writer.write(frame);
    result.resumed_frames += is_there;
    result.measures.push_back(unflatten(model, info.metric_names, frame.metrics));
    result.seconds.write += watch.lap();
    if (!on_frame(frame)) stop_bake();
    watch.lap();  // the caller's time is not measured
  }
  result.hash = writer.pack(check_stop);
  result.seconds.write += watch.lap();
  return result;
}

}  // namespace thew::sim
