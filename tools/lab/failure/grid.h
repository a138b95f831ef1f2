// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace thew::tools {

/// A grid of runs, of which those are left out that their surroundings tell. Every second row and
/// column is run. A cell between takes over what all of those say at the corners of the blocks that
/// it lies in or borders on, if they agree; else it is run. So is each that touches a run cell that
/// came out otherwise, until none does: the boundary is followed wherever one was found.
struct GridAsk {
  int rows = 0, columns = 0;
  /// Runs a cell and says what became of it. Row 0 of a column comes before its other rows.
  std::function<int(int row, int column)> run;
  int check_every = 8;  ///< of the cells left out, one in so many is run after all; 0: none
  bool all = false;     ///< leaves none out
};
struct GridFill {
  std::vector<std::vector<int>> found;      ///< by row and column
  std::vector<std::vector<char>> inferred;  ///< 1: not run
  int checked = 0, differed = 0;            ///< cells run as a check; those that were not as told
};
GridFill fill_grid(const GridAsk& ask);

}  // namespace thew::tools
