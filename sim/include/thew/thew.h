// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Thew's public interface: this header includes all of it. Link thew::sim.
///
/// What is stable. Before 1.0.0 a new MINOR may add, rename and remove here, and its list of
/// changes says what; a PATCH changes neither names nor meanings, so that a program has only to be
/// built anew. find_package(thew 0.1) therefore takes 0.1.x alone. A bake's bytes may change in any
/// version whose list of changes says so; within one they are the same on every machine. Headers
/// beside these are not installed and promise nothing, and the libraries are static: there is no
/// binary interface to keep.
///
/// What holds everywhere. Arrays are flat and are copied: positions x, y, z of each vertex in m,
/// triangles three vertices each from 0. +Y is up, angles are rad, times s. What goes wrong is one
/// exception, Error (error.h), whose text says where, what and what to do next. Nothing prints
/// (import.h names an exception). Eigen is not seen, and no flag of Thew's own build reaches a
/// program that links it.

#include "thew/bake.h"
#include "thew/cache.h"
#include "thew/error.h"
#include "thew/import.h"
#include "thew/mesh.h"
#include "thew/scene.h"
#include "thew/simulation.h"
#include "thew/volume.h"

namespace thew {

/// "0.1.0", of the library that is linked.
const char* version();

}  // namespace thew
