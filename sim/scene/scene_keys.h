// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/keys.h"
#include "sim/scene/scene.h"

namespace thew::sim {

// The keys of all tables but [rig] and [[muscle]].

inline constexpr Key kFileKeys[] = {
    {.name = "scene", .type = KeyType::kTable, .meaning = "Name, time, gravity and size."},
    {.name = "rig",
     .type = KeyType::kTable,
     .meaning = "The bodies, and the motion that they follow.",
     .need = Need::kRequired},
    {.name = "muscle",
     .type = KeyType::kTables,
     .meaning = "The muscles and soft bodies, each a table of its own."},
    {.name = "collider",
     .type = KeyType::kTables,
     .meaning = "What presses on the character: props and other characters."},
    {.name = "skin",
     .type = KeyType::kTable,
     .meaning = "The skin; without this table there is none."},
    {.name = "solver", .type = KeyType::kTable, .meaning = "How a frame is solved."},
    {.name = "contact", .type = KeyType::kTable, .meaning = "Contact between muscles and bones."},
    {.name = "render",
     .type = KeyType::kTable,
     .meaning =
         "The pictures that a bake draws; drawing a bake again by this scene has to have it.",
     .need = Need::kConditional},
    {.name = "output", .type = KeyType::kTable, .meaning = "The cache that a bake writes."},
    {.name = "bound", .type = KeyType::kTables, .meaning = "Limits that a bake must keep."}};
inline constexpr Section kFile{"", "Tables of a scene", "A scene holds these tables.", kFileKeys};

inline constexpr Key kSceneKeys[] = {
    {.name = "name",
     .type = KeyType::kText,
     .meaning = "What reports and pictures call the scene.",
     .standard = default_of<&World::name>},
    {.name = "fps",
     .type = KeyType::kNumber,
     .meaning = "Frames in a second.",
     .unit = "1/s",
     .standard = default_of<&World::fps>,
     .range = {1e-2, 1e5}},
    {.name = "frames",
     .type = KeyType::kForm,
     .meaning =
         "The first and the last frame, \"1-120\" or [1, 120]; a single number is a single frame.",
     .standard =
         [] {
           return toml_text(std::to_string(World{}.first_frame) + "-" +
                            std::to_string(World{}.last_frame));
         },
     .range = kFrames,
     .form = "frames, \"FIRST-LAST\""},
    {.name = "settle",
     .type = KeyType::kNumber,
     .meaning =
         "The longest time before the first frame in which the bones go from the bind pose to the "
         "first pose and the muscles come to a standstill.",
     .unit = "s",
     .standard = default_of<&World::settle>,
     .range = {0.0, 1000.0}},
    {.name = "gravity",
     .type = KeyType::kVector,
     .meaning = "The acceleration of all free nodes.",
     .unit = "m/s²",
     .standard = default_of<&World::gravity>,
     .range = {-1e4, 1e4}},
    // From a mouse to what no animal is; beyond it other numbers are meant.
    {.name = "size",
     .type = KeyType::kNumber,
     .meaning = "The length of this body over that of a grown man: it multiplies every length that "
                "the scene "
                "does not give.",
     .standard = default_of<&World::size>,
     .range = {1e-3, 1e3}}};
inline constexpr Section kScene{"scene", "[scene]", "Name, time, gravity and size.", kSceneKeys};

inline constexpr Key kSkinKeys[] = {
    {.name = "kind",
     .type = KeyType::kWord,
     .meaning = "\"layer\" is a closed mesh of its own over muscle and bone, \"skinned\" the "
                "character's own "
                "mesh with the weights that its artist painted.",
     .words = {"layer", "skinned"}},
    {.name = "mesh",
     .type = KeyType::kFile,
     .meaning = "The mesh of a layer, which has to have one, or a bake as `cache`.",
     .need = Need::kConditional},
    {.name = "cache",
     .type = KeyType::kFile,
     .meaning = "The shape of a layer by frame where no flesh presses on it, such as an artist's "
                "skinned one: .pc2 or .mdd, with the mesh's vertices in their order; or a bake "
                "(.h5), which has the mesh itself."},
    {.name = "start",
     .type = KeyType::kNumber,
     .meaning = "The frame in which the cache has its first sample; by default the scene's first.",
     .range = kFrames},
    {.name = "thickness",
     .type = KeyType::kNumber,
     .meaning = "The least distance of the skin from muscle and bone.",
     .unit = "m",
     .standard = default_of<&SkinSettings::thickness>,
     .range = kLength},
    {.name = "smoothing",
     .type = KeyType::kNumber,
     .meaning = "Resistance of the skin to bending and stretch, against its hold on the bodies.",
     .standard = default_of<&SkinSettings::smoothing>,
     .range = kShare},
    {.name = "iterations",
     .type = KeyType::kInteger,
     .meaning = "Rounds of projection in each step of the skin.",
     .standard = default_of<&SkinSettings::iterations>,
     .range = {1, 10000}},
    {.name = "fold_gap",
     .type = KeyType::kNumber,
     .meaning = "The distance that skin keeps from skin in a fold.",
     .unit = "m",
     .standard = default_of<&SkinSettings::fold_gap>,
     .range = kLength},
    {.name = "reach",
     .type = KeyType::kNumber,
     .meaning = "A skinned skin moves with the muscles up to twice this distance from them.",
     .unit = "m",
     .standard = default_of<&SkinSettings::reach>,
     .range = kSize},
    {.name = "ignore",
     .type = KeyType::kForm,
     .meaning = "Bones that the skin does not feel, such as a hand of one piece in fingers that "
                "bend.",
     .form = "names, [\"bone\", ...]"},
    {.name = "fat",
     .type = KeyType::kForm,
     .meaning =
         "How far the rest shape lies over muscle and bone: it is moved there when it is "
         "bound. Where left out, it stays as modelled. A skinned skin takes it within `reach` "
         "of a muscle, and less and less up to twice that; a map of it is by vertex of the "
         "character's file, places in its bind pose, and parts without the attribute stay "
         "as modelled.",
     .unit = "m",
     .range = {0.0, 0.03},
     .form = "number or map"},
    {.name = "slide",
     .type = KeyType::kForm,
     .meaning = "How freely the skin moves over its flesh: 0 sticks to the point below it at rest, "
                "1 slides without friction. A map of a skinned skin is as that of `fat`.",
     .standard = default_of<&SceneSkin::slide>,
     .range = kShare,
     .form = "number or map"},
    {.name = "volume",
     .type = KeyType::kWord,
     .meaning = "\"exact\" keeps the volume that a layer encloses as it is at rest.",
     .words = {"none", "exact"}},
    {.name = "enabled",
     .type = KeyType::kTruth,
     .meaning = "With false the table is checked, and there is no skin.",
     .standard = default_of<&SceneSkin::enabled>}};
inline constexpr Section kSkin{"skin", "[skin]", "The skin over the muscles.", kSkinKeys};

inline constexpr Key kSolverKeys[] = {
    {.name = "integrator",
     .type = KeyType::kWord,
     .meaning = "How a muscle moves in a step; \"quasi_static\" has no inertia, and finds the rest "
                "shape of each frame from the bind pose on, so that a frame depends on its pose "
                "alone.",
     .standard = default_of<&SceneSolver::integrator>,
     .words = {"explicit", "xpbd", "local_global", "quasi_static"}},
    {.name = "volume",
     .type = KeyType::kWord,
     .meaning =
         "How the volume is held: \"exact\" and \"exact_always\" to rounding (the latter in every "
         "part "
         "of an explicit substep), \"zonal\" in each of a muscle's zones besides (local_global and "
         "quasi_static), \"linear\" by one linearised step, \"printed\" by the paper's formula as "
         "printed, \"penalty\" by a stiffness, \"none\" not at all.",
     .standard = default_of<&SceneSolver::volume>,
     .words = {"none", "penalty", "printed", "linear", "exact", "exact_always", "zonal"}},
    {.name = "substeps",
     .type = KeyType::kInteger,
     .meaning = "Steps in a frame; explicit divides each further where its stability asks for it.",
     .standard = default_of<&SceneSolver::substeps>,
     .range = {1, 1000000}},
    {.name = "iterations",
     .type = KeyType::kInteger,
     .meaning = "Rounds in each step; quasi_static takes at least so many.",
     .standard = default_of<&SceneSolver::iterations>,
     .range = {1, 10000}},
    {.name = "tolerance",
     .type = KeyType::kTable,
     .meaning = "Takes the place of integrator, substeps and iterations: each muscle gets the "
                "cheapest method "
                "whose measured error is within it."}};
inline constexpr Section kSolver{"solver", "[solver]", "How a frame is solved.", kSolverKeys};

// What is beyond these ranges no choice of method can promise.
inline constexpr Key kToleranceKeys[] = {
    {.name = "position",
     .type = KeyType::kLength,
     .meaning = "The largest error of any node in any frame, against a refined solution; a number "
                "in metres, "
                "or a text such as \"0.5 mm\".",
     .unit = "m",
     .need = Need::kRequired,
     .range = {1e-6, 1.0}},
    {.name = "volume",
     .type = KeyType::kNumber,
     .meaning = "The largest relative error of a muscle's volume.",
     .standard = default_of<&Tolerance::volume>,
     .range = {1e-12, 1.0}}};
inline constexpr Section kTolerance{"solver.tolerance", "[solver.tolerance]",
                                    "Errors that the solver may make.", kToleranceKeys};

inline constexpr Key kContactKeys[] = {
    {.name = "enabled",
     .type = KeyType::kTruth,
     .meaning = "With false nothing meets anything.",
     .standard = default_of<&ContactOptions::enabled>},
    {.name = "margin",
     .type = KeyType::kNumber,
     .meaning = "The distance at which contacts are looked for.",
     .unit = "m",
     .standard = default_of<&ContactSettings::margin>,
     .range = kLength},
    {.name = "max_depth",
     .type = KeyType::kNumber,
     .meaning =
         "The depth down to which contacts are found, twice as deep in what gives way itself.",
     .unit = "m",
     .standard = default_of<&ContactSettings::max_depth>,
     .range = kLength},
    {.name = "gap",
     .type = KeyType::kNumber,
     .meaning = "The distance that contact keeps between surfaces.",
     .unit = "m",
     .standard = default_of<&ContactSettings::gap>,
     .range = kLength},
    {.name = "spacing",
     .type = KeyType::kNumber,
     .meaning = "The distance between the points of tendons and sharp bone that are kept out of "
                "the faces of "
                "others.",
     .unit = "m",
     .standard = default_of<&ContactSettings::spacing>,
     .range = kSize},
    {.name = "friction",
     .type = KeyType::kNumber,
     .meaning = "Coefficient of friction of all surfaces (local_global and quasi_static).",
     .standard = default_of<&ContactOptions::friction>,
     .range = kNotNegative},
    {.name = "thickness",
     .type = KeyType::kForm,
     .meaning = "What lies on a muscle or bone and is kept free beside the gap, by its name: a "
                "number or a map.",
     .unit = "m",
     .range = kLength,
     .form = "name surfaces, { humerus = 0.001 }"},
    {.name = "self",
     .type = KeyType::kForm,
     .meaning = "Muscles that meet themselves (local_global and quasi_static).",
     .form = "names of muscles, [\"a\", ...]"},
    {.name = "ignore",
     .type = KeyType::kForm,
     .meaning = "Pairs of muscles or bones that pass through one another.",
     .form = "pairs of names, [[\"a\", \"b\"], ...]"}};
inline constexpr Section kContact{"contact", "[contact]", "Contact between muscles and bones.",
                                  kContactKeys};

inline constexpr Key kRenderKeys[] = {
    {.name = "size",
     .type = KeyType::kForm,
     .meaning = "Width and height of the pictures.",
     .unit = "pixels",
     .standard =
         [] {
           return "[" + toml_text(SceneRender{}.width) + ", " + toml_text(SceneRender{}.height) +
                  "]";
         },
     .range = {16, 16384},  // OSMesa draws nonsense beyond that
     .form = "pixels, [width, height]"},
    {.name = "view",
     .type = KeyType::kTables,
     .meaning = "The views that are drawn; without any a bake draws no pictures."}};
inline constexpr Section kRender{"render", "[render]", "The pictures that a bake draws.",
                                 kRenderKeys};

inline constexpr Key kViewKeys[] = {
    {.name = "name",
     .type = KeyType::kName,
     .meaning = "Names the folder of its pictures.",
     .need = Need::kRequired},
    {.name = "show",
     .type = KeyType::kWord,
     .meaning = "What is drawn, by default what the name says where it is one of these words; a "
                "\"cutaway\" "
                "shows the muscles where the skin is open.",
     .standard = default_of<&SceneView::show>,
     .words = {"skin", "muscles", "weights", "cutaway"}},
    {.name = "eye",
     .type = KeyType::kVector,
     .meaning = "Where the camera stands.",
     .unit = "m",
     .standard = default_of<&SceneView::eye>,
     .range = kPlace},
    {.name = "target",
     .type = KeyType::kVector,
     .meaning = "Where it looks.",
     .unit = "m",
     .standard = default_of<&SceneView::target>,
     .range = kPlace},
    {.name = "up",
     .type = KeyType::kVector,
     .meaning = "Which way is up in the picture; not along the view.",
     .standard = default_of<&SceneView::up>,
     .range = kDirection},
    {.name = "field_of_view",
     .type = KeyType::kNumber,
     .meaning = "Vertical angle of the picture.",
     .unit = "degrees",
     .standard = default_of<&SceneView::field_of_view>,
     .range = {1.0, 170.0}},
    {.name = "light",
     .type = KeyType::kVector,
     .meaning = "Direction towards the light; zero puts it over the left shoulder of the camera.",
     .standard = default_of<&SceneView::light>,
     .range = kDirection},
    {.name = "from",
     .type = KeyType::kDirection,
     .meaning = "In place of `eye` and `target`, the direction towards the camera: it stands as "
                "near as shows the bones, muscles and skin of what hangs on the body that it "
                "follows, or of all, in each frame of the scene. In a file without [rig], of the "
                "bake that is drawn, in the frames that are drawn.",
     .range = kDirection},
    {.name = "follow",
     .type = KeyType::kText,
     .meaning = "A body of the rig: the camera moves with it, from the rest pose on, without "
                "turning."},
    {.name = "cut",
     .type = KeyType::kForm,
     .meaning = "A cutaway has to have it: the skin is open at those points p of its rest pose "
                "where n · p > d for all planes, n made a unit normal.",
     .unit = "d: m",
     .need = Need::kConditional,
     .range = kDirection,
     .second = kPlace,
     .form = "planes, [[nx, ny, nz, d], ...]"}};
inline constexpr Section kView{"render.view", "[[render.view]]", "One view.", kViewKeys};

inline constexpr Key kOutputKeys[] = {{.name = "precision",
                                       .type = KeyType::kWord,
                                       .meaning = "Of the positions in the cache: \"single\" is "
                                                  "float32, which alone makes relative errors of "
                                                  "volume of some 1e-7, \"double\" float64.",
                                       .words = {"single", "double"}}};
inline constexpr Section kOutput{"output", "[output]", "The cache that a bake writes.",
                                 kOutputKeys};

inline constexpr Key kBoundKeys[] = {
    {.name = "volume_error",
     .type = KeyType::kNumber,
     .meaning = "Relative error of volume in any frame, as it is written, of muscles and of a skin "
                "that keeps its volume.",
     .range = kNotNegative},
    {.name = "substep_volume_error",
     .type = KeyType::kNumber,
     .meaning = "Relative error of any muscle's volume after any substep, as it is solved.",
     .range = kNotNegative},
    {.name = "penetration",
     .type = KeyType::kNumber,
     .meaning = "Depth of any node of muscle or skin inside another body.",
     .unit = "m",
     .range = kNotNegative},
    {.name = "poke_through",
     .type = KeyType::kNumber,
     .meaning = "Distance of any node of muscle or bone outside the skin.",
     .unit = "m",
     .range = kNotNegative},
    {.name = "attachment_gap",
     .type = KeyType::kNumber,
     .meaning = "Distance of any muscle's end from its origin or insertion on the bone.",
     .unit = "m",
     .range = kNotNegative}};
inline constexpr Section kBound{"bound", "[[bound]]",
                                "Limits: a bake that exceeds one says so and fails.", kBoundKeys};

}  // namespace thew::sim
