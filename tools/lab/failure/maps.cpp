// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/maps.h"

#include <algorithm>
#include <mutex>

#include "sim/solver/parallel.h"
#include "tools/lab/failure/grid.h"
#include "tools/lab/failure/rival_cell.h"
#include "tools/lab/failure/thew_cell.h"

namespace thew::tools {
namespace {

// What a map is run with: Thew's method or another's.
struct Runner {
  const ThewMethod* thew = nullptr;
  RelatedMethod rival = {};
  const Quantity* quantity = nullptr;
};

struct Work {
  StabilityMap map;
  Runner by;
};

int class_of(const MapCell& cell) {
  return 100 * static_cast<int>(cell.verdict) + static_cast<int>(cell.mechanism);
}

std::vector<Work> lay_out(const MapAsk& ask, const MapBody& body) {
  std::vector<Work> all;
  const auto add = [&](const std::string& method, const std::string& what,
                       const std::vector<double>& steps, const Runner& by) {
    if (!ask.only_method.empty() && method != ask.only_method) return;
    for (const Quantity& quantity : map_quantities()) {
      if (!ask.only_quantity.empty() && quantity.name != ask.only_quantity) continue;
      if (!by.thew && !can_load(quantity.load)) continue;
      Work& work = all.emplace_back();
      work.by = by;
      work.by.quantity = &quantity;
      work.map = {method,
                  what,
                  quantity.name,
                  quantity.unit,
                  by.thew != nullptr,
                  quantity.columns,
                  steps,
                  {},
                  0,
                  0,
                  {}};
      work.map.cells.assign(steps.size(), std::vector<MapCell>(quantity.columns.size()));
    }
  };
  for (const ThewMethod& method : thew_methods()) {
    add(method.integrator, "Thew's, exact volume", method.steps, {&method, {}, nullptr});
  }
  for (const RelatedMethod& method : map_rivals(body)) {
    add(method.name, method.what, rival_steps(method), {nullptr, method, nullptr});
  }
  return all;
}

MapCell run_one(const MapBody& body, const Runner& by, double value, double h, Points& last) {
  const Load load = by.quantity->load;
  if (!by.thew) return run_rival_cell(body, load, value, by.rival, h, last);
  ThewRun run = run_thew_cell(body, load, value, *by.thew, h, false);
  last = std::move(run.last);
  return run.cell;
}

// Of each mechanism by which Thew's solver gave up in a map, its coarsest run cell once more as a
// bake runs it.
void try_rungs(const MapBody& body, const Runner& by, StabilityMap& map) {
  for (int k = 0; k <= static_cast<int>(Mechanism::kEnergy); ++k) {
    const Mechanism mechanism = static_cast<Mechanism>(k);
    for (int s = static_cast<int>(map.steps.size()) - 1; s >= 0; --s) {
      const auto found =
          std::find_if(map.cells[s].begin(), map.cells[s].end(), [&](const MapCell& cell) {
            return cell.mechanism == mechanism && cell.verdict == Verdict::kDiverged &&
                   !cell.inferred && !cell.failure.empty();
          });
      if (found == map.cells[s].end()) continue;
      const double value = map.columns[found - map.cells[s].begin()];
      const MapBody loaded = loaded_body(body, by.quantity->load, value);
      ThewRun run = run_thew_cell(loaded, by.quantity->load, value, *by.thew, map.steps[s], true);
      judge_cell({}, run.last, body.size.norm(), run.cell);
      map.with_rungs.emplace_back(
          mechanism, run.last.empty() ? "the bake ends, and says: " + run.cell.failure
                                      : "a bake goes on (" + run.rung + ") and is " +
                                            verdict_name(run.cell.verdict) + " at the end");
      break;
    }
  }
}

void run_map(const MapBody& body, bool every_cell, Work& work) {
  StabilityMap& map = work.map;
  std::vector<Points> finest(map.columns.size());
  const auto run = [&](int row, int column) {
    const double value = map.columns[column];
    const MapBody loaded = loaded_body(body, work.by.quantity->load, value);
    Points last;
    MapCell& cell = map.cells[row][column];
    cell = run_one(loaded, work.by, value, map.steps[row], last);
    judge_cell(finest[column], last, body.size.norm(), cell);
    if (row == 0) finest[column] = std::move(last);
    return class_of(cell);
  };
  const GridFill fill = fill_grid({.rows = static_cast<int>(map.steps.size()),
                                   .columns = static_cast<int>(map.columns.size()),
                                   .run = run,
                                   .all = every_cell});
  for (size_t r = 0; r < map.steps.size(); ++r) {
    for (size_t c = 0; c < map.columns.size(); ++c) {
      if (!fill.inferred[r][c]) continue;
      map.cells[r][c].inferred = true;
      map.cells[r][c].verdict = static_cast<Verdict>(fill.found[r][c] / 100);
      map.cells[r][c].mechanism = static_cast<Mechanism>(fill.found[r][c] % 100);
    }
  }
  map.checked = fill.checked;
  map.differed = fill.differed;
  if (work.by.thew) try_rungs(body, work.by, map);
}

}  // namespace

std::vector<StabilityMap> run_maps(const MapAsk& ask) {
  const MapBody body = map_body(ask.scene);
  std::vector<Work> all = lay_out(ask, body);
  const int total = static_cast<int>(all.size());
  int done = 0;
  std::mutex one_at_a_time;
  Parallel parallel(ask.threads);
  parallel.each(total, [&](int k) {
    run_map(body, ask.every_cell, all[total - 1 - k]);  // those of elements take longest: first
    const std::lock_guard lock(one_at_a_time);
    ask.on_map(++done, total);
  });
  std::vector<StabilityMap> maps;
  for (Work& work : all) maps.push_back(std::move(work.map));
  return maps;
}

}  // namespace thew::tools
