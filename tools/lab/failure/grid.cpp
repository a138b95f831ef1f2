// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/grid.h"

#include <algorithm>
#include <array>

namespace thew::tools {
namespace {

constexpr int kUnknown = -1;

struct Filling {
  const GridAsk& ask;
  GridFill& fill;

  bool is_coarse(int at, int count) const { return at % 2 == 0 || at == count - 1; }
  bool is_run(int r, int c) const { return !fill.inferred[r][c] && fill.found[r][c] != kUnknown; }

  void run(int r, int c) const {
    if (is_run(r, c)) return;
    if (r > 0) run(0, c);
    fill.found[r][c] = ask.run(r, c);
    fill.inferred[r][c] = 0;
  }

  // First and last of the coarse rows (columns) around one, those of the next blocks too where it
  // is between two.
  std::array<int, 2> around(int at, int count) const {
    const int reach = is_coarse(at, count) ? 2 : 1;
    return {std::max(at - reach, 0), std::min(at + reach, count - 1)};
  }

  // What all coarse cells around it say; kUnknown: they do not agree.
  int told(int row, int column) const {
    const auto [top, bottom] = around(row, ask.rows);
    const auto [left, right] = around(column, ask.columns);
    int what = kUnknown;
    for (int r = top; r <= bottom; ++r) {
      for (int c = left; c <= right; ++c) {
        if (!is_coarse(r, ask.rows) || !is_coarse(c, ask.columns)) continue;
        if (what != kUnknown && fill.found[r][c] != what) return kUnknown;
        what = fill.found[r][c];
      }
    }
    return what;
  }

  bool touches_another(int row, int column) const {
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, ask.rows - 1); ++r) {
      for (int c = std::max(column - 1, 0); c <= std::min(column + 1, ask.columns - 1); ++c) {
        if (is_run(r, c) && fill.found[r][c] != fill.found[row][column]) return true;
      }
    }
    return false;
  }

  template <typename Visit>
  void each(const Visit& visit) const {
    for (int r = 0; r < ask.rows; ++r) {
      for (int c = 0; c < ask.columns; ++c) visit(r, c);
    }
  }

  void follow_boundaries() const {
    for (bool more = true; more;) {
      more = false;
      each([&](int r, int c) {
        if (!fill.inferred[r][c] || !touches_another(r, c)) return;
        run(r, c);
        more = true;
      });
    }
  }
};

}  // namespace

GridFill fill_grid(const GridAsk& ask) {
  GridFill fill;
  fill.found.assign(ask.rows, std::vector<int>(ask.columns, kUnknown));
  fill.inferred.assign(ask.rows, std::vector<char>(ask.columns, 0));
  const Filling grid{ask, fill};
  grid.each([&](int r, int c) {
    if (ask.all || (grid.is_coarse(r, ask.rows) && grid.is_coarse(c, ask.columns))) grid.run(r, c);
  });
  grid.each([&](int r, int c) {
    if (grid.is_run(r, c)) return;
    fill.found[r][c] = grid.told(r, c);
    fill.inferred[r][c] = fill.found[r][c] != kUnknown;
  });
  grid.each([&](int r, int c) {
    if (fill.found[r][c] == kUnknown) grid.run(r, c);
  });
  grid.follow_boundaries();
  int left_out = 0;
  grid.each([&](int r, int c) {
    if (ask.check_every <= 0 || !fill.inferred[r][c] || ++left_out % ask.check_every) return;
    const int told = fill.found[r][c];
    grid.run(r, c);
    ++fill.checked;
    fill.differed += fill.found[r][c] != told;
  });
  grid.follow_boundaries();
  return fill;
}

}  // namespace thew::tools
