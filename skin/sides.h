// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "skin/surface/surface.h"

namespace thew::skin {

/// How a surface hangs together, which does not change as it moves.
struct Shell {
  std::vector<int> piece_of;           ///< by node; a piece is what edges connect; -1: none
  std::vector<int> pieces;             ///< one node of each piece
  std::vector<int> loose;              ///< nodes of no triangle
  std::vector<std::vector<int>> rims;  ///< for each hole the nodes around it
};
Shell make_shell(const Surface& surface, int nodes);
/// The triangles, those of a piece that is inside out turned, such as the hull that draws a
/// character's outline. A sheet, which has hardly an inside, stays as it is. `x` (m): by vertex,
/// one for each position.
std::vector<Triangle> turned_outwards(const std::vector<Vec3>& x, std::vector<Triangle> triangles);
/// By triangle, whether one before it has the same corners, either way round: as where a mesh is
/// doubled to be seen from both sides. Such have no inside.
std::vector<char> find_doubled(const std::vector<Triangle>& triangles);
/// Two points (m) that run along a limb from one bone to the next, such as those near the ends of a
/// muscle.
using Span = std::array<Vec3, 2>;
/// Whether the piece (`x`: m) surrounds both ends of at least three in four of the spans of which
/// it surrounds one, and so bends where they do.
bool bends(const Surface& piece, const Points& x, const std::vector<Span>& spans);
/// By node, whether it is of a piece that goes through another one at rest (m), both where nodes
/// are `near`: as those of armour, of a robot or of a wooden mannequin do. Such pieces are hard,
/// there is no skin between them that could stretch. A piece that bends() is skin, whatever goes
/// through it, such as a weapon in the hand or a plate on the shoulder.
std::vector<char> find_hard(const Surface& surface, const Points& rest, const Shell& shell,
                            const std::vector<char>& near, const std::vector<Span>& spans);

/// A surface in its present position. The tree is fitted to it.
struct PlacedShell {
  const Surface* surface = nullptr;
  const Bvh* bvh = nullptr;
  const Points* x = nullptr;
  const Shell* shell = nullptr;
  const std::vector<char>* counted = nullptr;  ///< nodes whose depth counts; null: all
};

/// Largest distance (m) from the surface `of` of the counted nodes of `body` that lie inside it, or
/// outside it; 0 if none does. It is that of deepest_inside() or farthest_outside() (depth.h) for
/// all these nodes. But nodes that edges connect are on one side of a surface that comes through no
/// triangle between them, and so one of them tells for all. `near` are the pairs of
/// find_near_crossings() for the two; `column` is the place of the body's triangles there, 0 or 1.
double deepest_inside(const PlacedShell& body, const PlacedShell& of,
                      const std::vector<std::array<int, 2>>& near, int column);
double farthest_outside(const PlacedShell& body, const PlacedShell& of,
                        const std::vector<std::array<int, 2>>& near, int column);

}  // namespace thew::skin
