// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>

#include "rig/mesh.h"

namespace thew::tools {

// The paper's bodies as closed surfaces, about 1 m in size or as given; always the same bytes.

/// Unit ball: `triangles` (even) on points of a Fibonacci spiral.
TriMesh paper_ball(int triangles);
/// Unit ball: rings about y of `around` nodes each, and two poles.
TriMesh ringed_ball(int rings, int around);
/// A plate below y = thickness whose edge at x = 0 is rounded by `radius`, all convex: its flat
/// face is y = 0 from x = -length to 0, its width is along z.
TriMesh rounded_plate(double length, double width, double thickness, double radius);
/// Unit cube about the origin, n x n squares a face, of two triangles or of four each.
TriMesh paper_cube(int n, bool four);
/// Ring of radius `radius` about y, tube of radius `tube`.
TriMesh paper_torus(double radius, double tube, int around, int along);
/// Two rings grown together (genus 2), and a quadruped, both from smooth fields.
TriMesh paper_two_rings(int triangles);
TriMesh paper_cow(int triangles);
TriMesh paper_finger(int triangles);

/// Where a field is 0, over a grid of `cell` (m) from low to high: closed where the field is
/// positive on the grid's rim. Marching tetrahedra, so manifold.
TriMesh polygonise(const std::function<double(const Vec3&)>& field, const Vec3& low,
                   const Vec3& high, double cell);

/// Collapses the shortest or splits the longest edges until the closed surface has `triangles`, to
/// the last one (an even number). Error(kInput) where no edge can be collapsed any more.
TriMesh with_count(const TriMesh& mesh, int triangles);

std::string shape_text(const std::string& what, const TriMesh& shape);
void write_obj(const std::filesystem::path& file, const std::string& what, const TriMesh& shape);

}  // namespace thew::tools
