// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/volume_zones.h"
#include "sim/scene/keys.h"
#include "sim/scene/scene.h"

namespace thew::sim {

inline constexpr int kMostPathPoints = 1000;

// The keys of [[muscle]] and of the tables in it.

inline constexpr Key kMuscleKeys[] = {
    {.name = "name",
     .type = KeyType::kName,
     .meaning = "What contact, reports and the bake call it.",
     .need = Need::kRequired},
    {.name = "mesh",
     .type = KeyType::kFile,
     .meaning = "Its closed surface in the rest pose. A muscle has a `mesh` or a `profile`.",
     .need = Need::kConditional},
    {.name = "profile",
     .type = KeyType::kTable,
     .meaning = "A tube along the path in place of a mesh.",
     .need = Need::kConditional},
    {.name = "transform",
     .type = KeyType::kTable,
     .meaning = "From the mesh file to the rest pose."},
    {.name = "path",
     .type = KeyType::kForm,
     .meaning = "The line along which it pulls, origin first: a body and a point in its frame "
                "each. Without a path it is a soft body; a profile has to have one.",
     .unit = "m",
     .need = Need::kConditional,
     .range = kPlace,
     .form = "two points or more, [[\"body\", x, y, z], ...]"},
    {.name = "mirror",
     .type = KeyType::kTruth,
     .meaning = "Takes the mesh of the other side's muscle, with its maps: all is reflected at "
                "the plane x = 0 of the rest pose. Path and wraps are this side's.",
     .standard = default_of<&SceneMuscle::mirror>},
    {.name = "wrap", .type = KeyType::kTables, .meaning = "Cylinders around which the path bends."},
    {.name = "belly",
     .type = KeyType::kForm,
     .meaning = "First and last ring of the belly along the rest path; where left out, a tenth of "
                "the path from its ends.",
     .unit = "m",
     .range = kLength,
     .form = "metres along the path, [from, to]"},
    {.name = "twist_from",
     .type = KeyType::kNumber,
     .meaning = "Length along the rest path beyond which the muscle takes the twist of its "
                "insertion; 0 gives the twist to all of it.",
     .unit = "m",
     .standard = default_of<&SceneMuscle::twist_from>,
     .range = kLength},
    {.name = "shape",
     .type = KeyType::kWord,
     .meaning = "\"target\" draws the muscle to the shape that its path carries along; with "
                "\"weights\" only the rest lengths follow the path, and the weights alone shape "
                "the belly.",
     .words = {"target", "weights"}},
    {.name = "weights",
     .type = KeyType::kForm,
     .meaning = "Where the belly swells and takes the correction of its volume: a word for the "
                "end towards which it does (left: the origin), or a table.",
     .standard =
         [] {
           const bool even = preset_profile("even").keys == WeightProfile{}.keys;
           return toml_text(std::string(even ? "even" : "see weights.h"));
         },
     .words = {"left", "even", "right"},
     .form = "word or table"},
    {.name = "guide",
     .type = KeyType::kNumber,
     .meaning = "Pull to the carried shape, as acceleration over distance; a soft body has none.",
     .unit = "1/s²",
     .standard = default_of<&SceneMuscle::guide>,
     .range = kNotNegative},
    {.name = "damping",
     .type = KeyType::kNumber,
     .meaning = "Rate at which the velocity fades to that of the carried shape; of a soft body, "
                "whose default is 0, drag that keeps its momentum.",
     .unit = "1/s",
     .standard = default_of<&SceneMuscle::damping>,
     .range = kNotNegative},
    {.name = "f_max",
     .type = KeyType::kNumber,
     .meaning = "Greatest active force; 0: a passive muscle.",
     .unit = "N",
     .standard = default_of<&SceneMuscle::f_max>,
     .range = kNotNegative},
    {.name = "fibre_length",
     .type = KeyType::kNumber,
     .meaning = "Length of the fibres at which the force is greatest.",
     .unit = "m",
     .standard = [] { return sized_text(SceneMuscle{}.fibre_length); },
     .range = kSize},
    {.name = "activation",
     .type = KeyType::kForm,
     .meaning = "How hard it pulls, by frame or by what a joint does; where left out, not at all.",
     .range = kFrames,
     .second = kShare,
     .form = "pairs, [[frame, activation], ...], or table"},
    {.name = "material", .type = KeyType::kTable, .meaning = "Stiffness and density."},
    {.name = "colour",
     .type = KeyType::kVector,
     .meaning = "Red, green and blue in pictures.",
     .standard = default_of<&SceneMuscle::colour>,
     .range = kShare,
     .form = "[red, green, blue]"},
    {.name = "zones",
     .type = KeyType::kInteger,
     .meaning = "Parts that each keep their volume with solver.volume = \"zonal\": along the "
                "belly or, of a soft body, along its longest axis.",
     .standard = default_of<&SceneMuscle::zones>,
     .range = {1, kMaxZones}},
    {.name = "fixed",
     .type = KeyType::kTables,
     .meaning = "Boxes in which a body holds the nodes of a soft body."}};
inline constexpr Section kMuscle{
    "muscle", "[[muscle]]",
    "A muscle, or a soft body: a mesh without a path, which keeps its volume, whose springs keep "
    "their rest lengths, and which has none of wrap, belly, twist_from, shape, guide, f_max, "
    "fibre_length and activation.",
    kMuscleKeys};

// Degrees, or m of a slider; and the same a second.
inline constexpr Range kJointValue{-1e6, 1e6};
inline constexpr Key kActivationKeys[] = {
    {.name = "joint",
     .type = KeyType::kText,
     .meaning = "The joint that it goes by.",
     .need = Need::kRequired},
    {.name = "preset",
     .type = KeyType::kWord,
     .meaning = "A curve by kind of muscle: \"flexor\" is 0.05 + 0.45 sin q, as it holds the "
                "weight of a hanging limb; \"extensor\" goes along with a fifth of that, 0.05 + "
                "0.09 sin q. The shape is that of the moment, the amounts are chosen.",
     .need = Need::kConditional,
     .words = {"flexor", "extensor"}},
    {.name = "curve",
     .type = KeyType::kPairs,
     .meaning = "Activation by the joint's angle, or by the way of a slider. The table has a "
                "`preset`, a `curve`, a `speed` or a `load`; several are added, up to 1.",
     .unit = "degrees or m",
     .need = Need::kConditional,
     .range = kJointValue,
     .second = kShare,
     .form = "[angle, activation]"},
    {.name = "speed",
     .type = KeyType::kPairs,
     .meaning = "Activation by the joint's speed, which \"quasi_static\" does not have and "
                "refuses.",
     .unit = "degrees/s or m/s",
     .need = Need::kConditional,
     .range = kJointValue,
     .second = kShare,
     .form = "[speed, activation]"},
    {.name = "load",
     .type = KeyType::kTable,
     .meaning = "A weight that the muscle holds, with all others that have a load on this joint.",
     .need = Need::kConditional}};
inline constexpr Section kActivation{
    "muscle.activation", "[muscle.activation]",
    "Activation that follows the rig: a function of the pose, and of its speed where asked for.",
    kActivationKeys};
inline constexpr Key kLoadKeys[] = {{.name = "mass",
                                     .type = KeyType::kNumber,
                                     .meaning = "What hangs there.",
                                     .unit = "kg",
                                     .need = Need::kRequired,
                                     .range = {0.0, 1e6}},
                                    {.name = "body",
                                     .type = KeyType::kText,
                                     .meaning = "The body that carries it.",
                                     .need = Need::kRequired},
                                    {.name = "at",
                                     .type = KeyType::kVector,
                                     .meaning = "Where, in the body's frame.",
                                     .unit = "m",
                                     .need = Need::kRequired,
                                     .range = kPlace}};
inline constexpr Section kLoad{
    "muscle.activation.load", "[muscle.activation.load]",
    "A weight. Its moment about the joint, over the sum of moment arm times f_max of the muscles "
    "that oppose it, is the activation of each of these.",
    kLoadKeys};

inline constexpr Key kProfileKeys[] = {
    {.name = "around",
     .type = KeyType::kInteger,
     .meaning = "Nodes in a ring.",
     .standard = default_of<&TubeProfile::around>,
     .range = {3, 1000}},
    {.name = "rings",
     .type = KeyType::kInteger,
     .meaning = "Rings along the path, between two poles.",
     .standard = default_of<&TubeProfile::rings>,
     .range = {2, 1000}},
    {.name = "radius",
     .type = KeyType::kPairs,
     .meaning = "Radius by the share u of the path from origin to insertion.",
     .unit = "m",
     .need = Need::kRequired,
     .range = kShare,
     .second = {1e-6, 10.0},
     .form = "[u, metres]"}};
inline constexpr Section kProfile{"muscle.profile", "[muscle.profile]",
                                  "A tube along the path in place of a mesh.", kProfileKeys};

inline constexpr Key kTransformKeys[] = {
    {.name = "scale",
     .type = KeyType::kNumber,
     .meaning = "Multiplies all lengths of the file, 0.001 for millimetres.",
     .standard = default_of<&MeshTransform::scale>,
     .range = kScale},
    {.name = "axis",
     .type = KeyType::kDirection,
     .meaning = "The axis of the turn.",
     .standard = default_of<&MeshTransform::axis>,
     .range = kDirection},
    {.name = "angle",
     .type = KeyType::kNumber,
     .meaning = "The turn about `axis`.",
     .unit = "degrees",
     .standard = default_of<&MeshTransform::angle>,
     .range = kTurn},
    {.name = "move",
     .type = KeyType::kVector,
     .meaning = "The way after the turn.",
     .unit = "m",
     .standard = default_of<&MeshTransform::move>,
     .range = kPlace}};
inline constexpr Section kTransform{"muscle.transform", "[muscle.transform]",
                                    "From the mesh file to the rest pose: scaled, turned, moved.",
                                    kTransformKeys};

inline constexpr Key kPathPointKeys[] = {
    {.name = "body",
     .type = KeyType::kText,
     .meaning = "The body that carries it.",
     .need = Need::kRequired},
    {.name = "at",
     .type = KeyType::kVector,
     .meaning = "The point in the body's frame.",
     .unit = "m",
     .need = Need::kRequired,
     .range = kPlace},
    {.name = "with", .type = KeyType::kText, .meaning = "Another body.", .need = Need::kRequired},
    {.name = "share",
     .type = KeyType::kNumber,
     .meaning = "The share that the point takes of how the body turns against the other.",
     .need = Need::kRequired,
     .range = kShare}};
inline constexpr Section kPathPoint{
    "muscle.path", "A point of `path` as a table",
    "A point between origin and insertion that lies between two bodies.", kPathPointKeys};

inline constexpr Key kWrapKeys[] = {
    {.name = "segment",
     .type = KeyType::kInteger,
     .meaning = "Which piece of the path bends; piece 0 goes from the first point to the second, "
                "and the last piece is the largest number that is allowed.",
     .need = Need::kRequired,
     .range = {0, kMostPathPoints - 2}},
    {.name = "body",
     .type = KeyType::kText,
     .meaning = "The body that carries the cylinder.",
     .need = Need::kRequired},
    {.name = "centre",
     .type = KeyType::kVector,
     .meaning = "A point of the cylinder's axis, in the body's frame.",
     .unit = "m",
     .need = Need::kRequired,
     .range = kPlace},
    {.name = "axis",
     .type = KeyType::kDirection,
     .meaning = "Direction of the cylinder's axis, in the body's frame.",
     .need = Need::kRequired,
     .range = kDirection},
    {.name = "radius",
     .type = KeyType::kNumber,
     .meaning = "Radius of the cylinder.",
     .unit = "m",
     .need = Need::kRequired,
     .range = kSize},
    {.name = "turn",
     .type = KeyType::kInteger,
     .meaning = "1 or -1: the side on which the path goes round, by its sense of rotation seen "
                "from the tip of the axis.",
     .standard = default_of<&SceneWrap::turn>,
     .range = {-1, 1}}};
inline constexpr Section kWrap{"muscle.wrap", "[[muscle.wrap]]",
                               "A cylinder around which a piece of the path bends.", kWrapKeys};

inline constexpr Key kWeightsKeys[] = {
    {.name = "profile",
     .type = KeyType::kPairs,
     .meaning = "Value by the share u of the belly from origin to insertion. A map has a "
                "`profile`, a `list`, `places`, a `file`, a `colour` or an `attribute`; weights "
                "may have a `zone` instead.",
     .need = Need::kConditional,
     .range = kShare,
     .second = kNotNegative,
     .form = "[u, value]"},
    {.name = "list",
     .type = KeyType::kForm,
     .meaning = "A value for each vertex of the mesh, in the order of its file.",
     .need = Need::kConditional,
     .form = "numbers, [value, ...]"},
    {.name = "file",
     .type = KeyType::kFile,
     .meaning = "Text with a value in each line, in the order of the mesh's vertices, or with \"x "
                "y z value\"; beside a colour or an attribute, the mesh that has it.",
     .need = Need::kConditional},
    {.name = "places",
     .type = KeyType::kForm,
     .meaning = "Balls in the rest pose (of a bone: in its body's frame), from the middle of "
                "which the value fades to `base` at the rim.",
     .unit = "m",
     .need = Need::kConditional,
     .range = kPlace,
     .form = "[x, y, z, radius, value]"},
    {.name = "base",
     .type = KeyType::kNumber,
     .meaning = "The value outside of all places, which need one.",
     .need = Need::kConditional,
     .range = kNotNegative},
    {.name = "colour",
     .type = KeyType::kWord,
     .meaning = "Which vertex colour is the value, of the mesh itself or of `file`.",
     .need = Need::kConditional,
     .words = {"red", "green", "blue", "alpha"}},
    {.name = "attribute",
     .type = KeyType::kText,
     .meaning = "Which vertex attribute is the value, of the mesh itself or of `file`: a property "
                "of a PLY's points, or one of glTF, \"_THEW_FAT\".",
     .need = Need::kConditional},
    {.name = "scale",
     .type = KeyType::kForm,
     .meaning = "What a colour or attribute of 0 and of 1 stand for: [0, 0.008] for 8 mm of white.",
     .standard = [] { return std::string("[0, 1]"); },
     .range = kNotNegative,
     .form = "two values, [black, white]"},
    {.name = "tolerance",
     .type = KeyType::kNumber,
     .meaning = "How far a vertex may lie from the place that its value was given for.",
     .unit = "m",
     .standard = [] { return sized_text(NodeMap{}.tolerance); },
     .range = kLength},
    {.name = "zone",
     .type = KeyType::kTable,
     .meaning = "Of weights alone: they gather around a load by themselves.",
     .need = Need::kConditional}};
inline constexpr Section kWeights{
    "muscle.weights", "A map: `weights` of a muscle, and others",
    "A map is a number by vertex. `weights` of a muscle is one; `material.stiffness`, `skin.fat`, "
    "`skin.slide` and each of `contact.thickness` may be one. A map that has one value everywhere "
    "is that number. `thew inspect` draws them.",
    kWeightsKeys};

inline constexpr Key kZoneKeys[] = {
    {.name = "smallest_radius",
     .type = KeyType::kNumber,
     .meaning = "Radius of the zone when a load begins.",
     .unit = "m",
     .standard = default_of<&ZoneSettings::smallest_radius>,
     .range = kLength},
    {.name = "largest_radius",
     .type = KeyType::kNumber,
     .meaning = "Radius beyond which it does not grow, at least the smallest.",
     .unit = "m",
     .range = kLength},
    {.name = "per_impulse",
     .type = KeyType::kNumber,
     .meaning = "Growth of the radius by amount and duration of the load.",
     .unit = "m/(N s)",
     .standard = default_of<&ZoneSettings::per_impulse>,
     .range = kNotNegative},
    {.name = "along_load",
     .type = KeyType::kNumber,
     .meaning = "Stretch of the zone along the load's direction.",
     .standard = default_of<&ZoneSettings::along_load>,
     .range = kShare}};
inline constexpr Section kZone{"muscle.weights.zone", "[muscle.weights.zone]",
                               "Weights that gather around a load by themselves.", kZoneKeys};

inline constexpr Key kMaterialKeys[] = {
    {.name = "stiffness",
     .type = KeyType::kForm,
     .meaning = "Stiffness of the surface across the fibres: tension over strain.",
     .unit = "N/m",
     .standard = default_of<&SpringMaterial::stiffness>,
     .range = kPositive,
     .form = "number or map",
     .old = "young"},
    {.name = "anisotropy",
     .type = KeyType::kNumber,
     .meaning = "Stiffness along the fibres over that across.",
     .standard = default_of<&SpringMaterial::anisotropy>,
     .range = kPositive},
    {.name = "shear",
     .type = KeyType::kNumber,
     .meaning = "Share of the stiffness in the springs between the vertices opposite an edge.",
     .standard = default_of<&SpringMaterial::shear>,
     .range = kNotNegative},
    {.name = "bending",
     .type = KeyType::kNumber,
     .meaning = "Resistance to bending, in the same springs.",
     .unit = "N m",
     .standard = default_of<&SpringMaterial::bending>,
     .range = kNotNegative},
    {.name = "shape",
     .type = KeyType::kNumber,
     .meaning = "Resistance against leaving the carried shape, over that against leaving its "
                "lengths; of a soft body 0.",
     .standard = default_of<&SpringMaterial::shape>,
     .range = kNotNegative},
    {.name = "density",
     .type = KeyType::kNumber,
     .meaning = "Mass over volume.",
     .unit = "kg/m³",
     .standard = default_of<&SpringMaterial::density>,
     .range = kPositive}};
inline constexpr Section kMaterial{"muscle.material", "[muscle.material]",
                                   "What a muscle is made of.", kMaterialKeys};

inline constexpr Key kFixedKeys[] = {
    {.name = "body",
     .type = KeyType::kText,
     .meaning = "The body that holds the nodes.",
     .need = Need::kRequired},
    {.name = "low",
     .type = KeyType::kVector,
     .meaning = "Lowest corner of the box, in the rest pose; where left out there is no limit.",
     .unit = "m",
     .range = kPlace},
    {.name = "high",
     .type = KeyType::kVector,
     .meaning = "Highest corner of the box, in the rest pose; where left out there is no limit.",
     .unit = "m",
     .range = kPlace}};
inline constexpr Section kFixed{"muscle.fixed", "[[muscle.fixed]]",
                                "A box in which a body holds the nodes of a soft body.",
                                kFixedKeys};

}  // namespace thew::sim
