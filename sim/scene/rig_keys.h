// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/math.h"
#include "sim/scene/keys.h"
#include "sim/scene/scene.h"

namespace thew::sim {

// The keys of [rig] and of the tables in it.

inline constexpr Key kRigKeys[] = {
    {.name = "file",
     .type = KeyType::kFile,
     .meaning =
         "The bodies and joints: a URDF, or a character (.gltf, .glb, .vrm, .fbx, .dae). Or a "
         "bake (.h5) whose bones move as they do there, each a body of its name; a rig without "
         "a file has such bones by `bone`, each with its `cache`.",
     .need = Need::kConditional},
    {.name = "scale",
     .type = KeyType::kNumber,
     .meaning = "Multiplies all lengths of a character's file or of cached bones.",
     .standard = default_of<&SceneCharacter::scale>,
     .range = kScale},
    {.name = "hinge",
     .type = KeyType::kTables,
     .meaning = "Joints of a character that keys can drive."},
    {.name = "bone",
     .type = KeyType::kTables,
     .meaning = "Bones of a character, whose file has none, or bones from caches."},
    {.name = "start",
     .type = KeyType::kNumber,
     .meaning = "The frame in which cached bones have their first sample; by default the scene's "
                "first. They stay where their samples end.",
     .range = kFrames},
    {.name = "bind",
     .type = KeyType::kNumber,
     .meaning =
         "The frame in whose pose of cached bones the muscles were made; by default a bake's "
         "first, and for other caches the meshes as their files have them.",
     .range = kFrames},
    {.name = "clip",
     .type = KeyType::kTable,
     .meaning = "The motion; without this table the rig stays in its rest pose."}};
inline constexpr Section kRig{"rig", "[rig]", "The bodies, and the motion that they follow.",
                              kRigKeys};

inline constexpr Key kClipKeys[] = {
    {.name = "keys",
     .type = KeyType::kForm,
     .meaning =
         "Values of each joint by frame, between which it moves smoothly. A clip has `keys` or a "
         "`file`, or the `animation` of a character.",
     .unit = "angles: `unit`; sliding joints: m",
     .need = Need::kConditional,
     .range = kFrames,
     .second = {-kMaxAngle / kDegree, kMaxAngle / kDegree},
     .form = "{ JOINT = [[frame, value], ...] }"},
    {.name = "file",
     .type = KeyType::kFile,
     .meaning =
         "A motion: .mot, .sto or .csv drives joints; .bvh, or another character's file, drives a "
         "character's bodies.",
     .need = Need::kConditional},
    {.name = "columns",
     .type = KeyType::kForm,
     .meaning = "Which joint a column of the file drives, \"\" for none; of a motion of bodies, "
                "which body of "
                "the character is meant by a name of the file.",
     .form = "{ THEIRS = \"OURS\" }"},
    {.name = "animation",
     .type = KeyType::kText,
     .meaning = "An animation of the character; beside a file that holds several, which of them."},
    {.name = "interpolation",
     .type = KeyType::kWord,
     .meaning = "The way from one value to the next.",
     .words = {"smooth", "linear"}},
    {.name = "unit",
     .type = KeyType::kWord,
     .meaning = "The unit of `keys`; with \"deg\" they may drive joints that turn, and no others.",
     .words = {"rad", "deg"}}};
inline constexpr Section kClip{"rig.clip", "[rig.clip]", "The motion.", kClipKeys};

inline constexpr Key kHingeKeys[] = {
    {.name = "name",
     .type = KeyType::kText,
     .meaning = "The joint's name, by which keys drive it.",
     .need = Need::kRequired},
    {.name = "body",
     .type = KeyType::kText,
     .meaning = "The body of the character that it turns.",
     .need = Need::kRequired},
    {.name = "axis",
     .type = KeyType::kDirection,
     .meaning = "The axis about which it turns, in the body's frame.",
     .need = Need::kRequired,
     .range = kDirection},
    {.name = "at_bind",
     .type = KeyType::kNumber,
     .meaning =
         "Its angle in the character's bind pose; muscles are made in the pose in which it is 0.",
     .unit = "degrees",
     .standard = [] { return toml_text(SceneHinge{}.at_bind / kDegree); },
     .range = kTurn},
    {.name = "along",
     .type = KeyType::kDirection,
     .meaning = "The direction along the body in its frame, about which `roll` turns it; it goes "
                "with a roll that is not 0, and with no other.",
     .need = Need::kConditional,
     .range = kDirection},
    {.name = "roll",
     .type = KeyType::kNumber,
     .meaning = "Turn about `along` from the bind pose to the pose in which the muscles are made.",
     .unit = "degrees",
     .standard = [] { return toml_text(SceneHinge{}.roll / kDegree); },
     .range = kTurn},
    {.name = "range",
     .type = KeyType::kForm,
     .meaning = "The angles between which it may turn.",
     .unit = "degrees",
     .standard =
         [] {
           const auto range = SceneHinge{}.range;
           return "[" + toml_text(range[0] / kDegree) + ", " + toml_text(range[1] / kDegree) + "]";
         },
     .range = kTurn,
     .form = "degrees, [from, to]"},
    {.name = "forearm",
     .type = KeyType::kTable,
     .meaning = "Two bodies more where the body is a forearm."},
    {.name = "scapula",
     .type = KeyType::kTable,
     .meaning =
         "One body more where the body is a humerus. The skin is tied to the muscles with this "
         "hinge as in the bind pose."}};
inline constexpr Section kHinge{"rig.hinge", "[[rig.hinge]]",
                                "A joint that turns a body of a character about one axis.",
                                kHingeKeys};

inline constexpr Key kForearmKeys[] = {
    {.name = "ulna",
     .type = KeyType::kText,
     .meaning = "Name of a new body for paths and bones, which follows the hinge without the "
                "forearm's roll.",
     .need = Need::kRequired},
    {.name = "radius",
     .type = KeyType::kText,
     .meaning =
         "Name of a new body that turns by that roll, about the line from `head` to `wrist`.",
     .need = Need::kRequired},
    {.name = "head",
     .type = KeyType::kVector,
     .meaning = "The head of the radius, in the forearm's frame.",
     .unit = "m",
     .need = Need::kRequired,
     .range = kPlace},
    {.name = "wrist",
     .type = KeyType::kVector,
     .meaning = "The wrist, in the forearm's frame.",
     .unit = "m",
     .need = Need::kRequired,
     .range = kPlace}};
inline constexpr Section kForearm{"rig.hinge.forearm", "[rig.hinge.forearm]",
                                  "The two bones of a character's forearm, which is one body.",
                                  kForearmKeys};

inline constexpr Key kScapulaKeys[] = {
    {.name = "body",
     .type = KeyType::kText,
     .meaning = "Name of a new body for paths and bones, which turns about the shoulder joint as "
                "the arm is raised.",
     .need = Need::kRequired},
    {.name = "on",
     .type = KeyType::kText,
     .meaning = "The body that carries it, such as the clavicle's.",
     .need = Need::kRequired},
    {.name = "axis",
     .type = KeyType::kDirection,
     .meaning = "The axis of its upward turn, in the frame of `on`.",
     .need = Need::kRequired,
     .range = kDirection},
    {.name = "hanging",
     .type = KeyType::kDirection,
     .meaning = "The direction of the humerus where the muscles are made, from which the arm's "
                "elevation counts, in the frame of `on`.",
     .need = Need::kRequired,
     .range = kDirection},
    {.name = "from",
     .type = KeyType::kNumber,
     .meaning = "Elevation of the arm beyond which it turns. It begins gently, from 0 on, and has "
                "its full rate at twice this.",
     .unit = "degrees",
     .standard = [] { return toml_text(SceneScapula{}.from / kDegree); },
     .range = {.least = 1.0, .most = 90.0}},
    {.name = "share",
     .type = KeyType::kNumber,
     .meaning = "Its turn, of the arm's elevation beyond `from`.",
     .standard = [] { return toml_text(SceneScapula{}.share); },
     .range = {.least = 0.0, .most = 1.0}}};
inline constexpr Section kScapula{"rig.hinge.scapula", "[rig.hinge.scapula]",
                                  "The shoulder blade of a character, which has no body of it.",
                                  kScapulaKeys};

inline constexpr Key kBoneKeys[] = {{.name = "name",
                                     .type = KeyType::kName,
                                     .meaning = "What contact and the bake call it.",
                                     .need = Need::kRequired},
                                    {.name = "body",
                                     .type = KeyType::kText,
                                     .meaning = "The body of the character that carries it; a "
                                                "cached bone is a body of its own name.",
                                     .need = Need::kConditional},
                                    {.name = "mesh",
                                     .type = KeyType::kFile,
                                     .meaning = "A closed mesh in the body's frame, in one piece or in several.",
                                     .need = Need::kRequired},
                                    {.name = "cache",
                                     .type = KeyType::kFile,
                                     .meaning = "The positions of the mesh's vertices by frame, in "
                                                "their order: .pc2 or .mdd. Where it bends, its "
                                                "body has the nearest rigid motion.",
                                     .need = Need::kConditional}};
inline constexpr Section kBone{"rig.bone", "[[rig.bone]]", "A bone of a character or from a cache.",
                               kBoneKeys};

inline constexpr Key kColliderKeys[] = {
    {.name = "name",
     .type = KeyType::kName,
     .meaning = "What contact and the bake call it.",
     .need = Need::kRequired},
    {.name = "mesh",
     .type = KeyType::kFile,
     .meaning = "A closed mesh; without a cache it stays where it is.",
     .need = Need::kConditional},
    {.name = "cache",
     .type = KeyType::kFile,
     .meaning = "Animates `mesh`: .pc2 or .mdd, with its vertices in their order; or a bake (.h5), "
                "which has the mesh itself. Between frames it turns evenly and bends linearly; it "
                "stays where its samples end.",
     .need = Need::kConditional},
    {.name = "part",
     .type = KeyType::kText,
     .meaning = "Which mesh of a bake it is, where that has several: \"skin\"."},
    {.name = "start",
     .type = KeyType::kNumber,
     .meaning = "The frame in which it has its first sample; by default the scene's first.",
     .range = kFrames},
    {.name = "scale",
     .type = KeyType::kNumber,
     .meaning = "Multiplies all lengths of its files.",
     .standard = default_of<&SceneCollider::scale>,
     .range = kScale}};
inline constexpr Section kCollider{
    "collider", "[[collider]]",
    "A mesh that is no part of the character, such as a prop or somebody else, still or moving. "
    "Muscles meet it as they meet bones, and the skin keeps out of it. It has a `mesh`, a `cache`, "
    "or both.",
    kColliderKeys};

}  // namespace thew::sim
