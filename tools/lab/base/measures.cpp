// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/base/measures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "rig/math.h"
#include "tools/base/exit_code.h"

namespace thew::tools {

double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

Bounds bounds_of(const std::vector<Vec3>& points, std::size_t count) {
  Bounds bounds;
  for (std::size_t i = 0; i < (count > 0 ? count : points.size()); ++i) bounds.add(points[i]);
  return bounds;
}

double NodeDistance::rms() const { return std::sqrt(sum / std::max(count, 1.0)); }

double add_distance(const Points& here, const Points& there, NodeDistance& out) {
  double largest = 0.0;
  for (std::size_t i = 0; i < there.size(); ++i, ++out.count) {
    const double mm = 1e3 * (to_vec(here[i]) - to_vec(there[i])).norm();
    largest = std::max(largest, mm);
    out.sum += mm * mm;
  }
  out.largest = std::max(out.largest, largest);
  return largest;
}

int run_or_tell(const char* program, int (*run)(int argc, char** argv), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return static_cast<int>(exit_code_of(error.code()));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return static_cast<int>(ExitCode::kSolver);
  }
}

}  // namespace thew::tools
