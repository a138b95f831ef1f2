# SPDX-License-Identifier: Apache-2.0
"""Thew: muscles and skin of animated characters, baked.

    import thew
    bake = thew.bake(thew.Scene.read("arm.toml"), "out/arm")   # or thew.load("out/arm")
    bake.meshes["skin"].positions                              # [frames, vertices, 3], in m

Lengths are in m, angles in rad, times in s; +Y is up. Arrays are numpy's, those of a bake read-only:
copy() one to change it. What goes wrong is one exception, thew.Error. Every call may be made from any
thread, and lets the others run on meanwhile.
"""

from __future__ import annotations

import dataclasses
import json
import os
from functools import cached_property
from typing import Any, Callable, Iterable, Mapping, NamedTuple, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _thew
from ._thew import Error

__all__ = ["Bake", "BakedMesh", "Body", "Bone", "Clip", "Error", "Joint", "JointActivation",
           "Muscle", "Progress", "Scene", "Simulation", "Skin", "Solver", "Wrap", "bake", "compare",
           "export", "fit", "load", "set_import_mode"]
__version__: str = _thew.version
__commit__: str = _thew.commit

Path = Union[str, "os.PathLike[str]"]
Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
#: (positions [N, 3] in m, triangles [T, 3] counter-clockwise seen from outside)
Mesh = tuple[npt.ArrayLike, npt.ArrayLike]
Vector3 = Sequence[float]


# A bake that is read

class BakedMesh:
    """One mesh of a bake, in the vertex order of the file or array that it came from."""

    name: str
    kind: str
    """"muscle", "bone", "skin" or "prop"."""
    rest: Floats
    """[N, 3], m, in the rest pose; a bone in its body's frame."""
    triangles: Ints
    """[T, 3], vertices from 0, counter-clockwise seen from outside."""
    weights: Floats
    """[N] of a muscle: of the volume correction, mean 1; of others empty."""

    def __init__(self, of: _thew.Bake, name: str, kind: str, rest: Floats, triangles: Ints,
                 weights: Floats) -> None:
        self._of = of
        self.name, self.kind = name, kind
        self.rest, self.triangles, self.weights = rest, triangles, weights

    @cached_property
    def positions(self) -> Floats:
        """[F, N, 3], m, in world space: all frames, read when first asked for, and then kept."""
        positions = self._of.all_positions(self.name)
        positions.setflags(write=False)
        return positions

    def at(self, frame: int) -> Floats:
        """[N, 3], m: one frame, by its number; no other is read."""
        return self._of.positions(self.name, frame)

    def __repr__(self) -> str:
        return (f"<thew.BakedMesh {self.kind} {self.name!r}: {len(self.rest)} vertices, "
                f"{len(self.triangles)} triangles>")


class Bake:
    """A baked scene: bake.h5, and the report beside it. See load()."""

    path: str
    scene: str
    """The scene's name."""
    hash: str
    """Of all positions in double precision, 32 hex digits."""
    fps: float
    frames: Ints
    """[F]: their numbers, rising."""
    meshes: dict[str, BakedMesh]
    """By name. Positions of one are read without those of the others."""

    def __init__(self, path: Path) -> None:
        file = os.fspath(path)
        if os.path.isdir(file):
            file = os.path.join(file, "bake.h5")
        self.path = file
        self._of = _thew.Bake(file)
        contents = self._of.contents
        self.scene, self.hash, self.fps = contents["scene"], contents["hash"], contents["fps"]
        self.frames = contents["frames"]
        self.meshes = {name: BakedMesh(self._of, name, *what)
                       for name, what in contents["meshes"].items()}
        self._measures: list[str] = contents["measures"]

    @cached_property
    def metrics(self) -> dict[str, Floats]:
        """What is stated of each frame, [F]: "length/NAME" (m), "volume_error/NAME" and so on."""
        return {name: self._of.measure(name) for name in self._measures}

    @cached_property
    def report(self) -> Optional[dict[str, Any]]:
        """What report.json beside the cache says of this very bake; None where there is none."""
        try:
            with open(os.path.join(os.path.dirname(self.path), "report.json"),
                      encoding="utf-8") as file:
                report = json.load(file)
        except (OSError, ValueError):
            return None
        return report if isinstance(report, dict) and report.get("hash") == self.hash else None

    def __repr__(self) -> str:
        return (f"<thew.Bake {self.scene!r}: {len(self.frames)} frames, "
                f"{len(self.meshes)} meshes, {self.path}>")


def load(path: Path) -> Bake:
    """Opens a bake: bake.h5, or the folder in which it is."""
    return Bake(path)


# A scene from arrays. Meshes, paths and bodies are given in the rest pose, in which all joint values
# are 0 and all bodies' axes are the world's.

@dataclasses.dataclass
class Joint:
    """How a body hangs on its parent."""

    name: str = ""  #: that a clip calls it by
    kind: str = "hinge"  #: hinge: turns about the axis (rad); slider: shifts along it (m); fixed
    position: Vector3 = (0.0, 0.0, 0.0)  #: of the body's frame, in its parent's
    axis: Vector3 = (0.0, 0.0, 1.0)  #: in the body's frame, of any length but 0
    range: tuple[float, float] = (-3.2, 3.2)  #: that its value may take


@dataclasses.dataclass
class Body:
    """A rigid part of the rig. The first is the root, at the origin; others come after their parent."""

    name: str
    parent: str = ""
    joint: Optional[Joint] = None  #: None: fixed, at its parent's origin


@dataclasses.dataclass
class Clip:
    """The motion: values [K, J] of the joints in rising frames [K], smooth between these."""

    joints: Sequence[str]
    frames: npt.ArrayLike
    values: npt.ArrayLike


@dataclasses.dataclass
class Wrap:
    """A cylinder fixed to a body, around which a path bends after its point `segment`."""

    segment: int
    body: str
    centre: Vector3
    axis: Vector3
    radius: float
    turn: float = 1.0  #: +1: counter-clockwise around it, seen from the axis' tip; or -1


@dataclasses.dataclass
class JointActivation:
    """How hard a muscle pulls by what a joint does: the sum of its parts, within 0 to 1."""

    joint: str
    curve: Sequence[tuple[float, float]] = ()  #: (degrees, or m of a slider; activation)
    speed: Sequence[tuple[float, float]] = ()  #: (degrees/s or m/s; activation)
    load: float = 0.0  #: kg, held with all muscles that have it
    load_body: str = ""  #: which carries it, at `load_at` in its frame
    load_at: Vector3 = (0.0, 0.0, 0.0)


@dataclasses.dataclass
class Muscle:
    """A closed mesh along a path from origin to insertion."""

    name: str
    mesh: Mesh
    path: Sequence[tuple[str, Vector3]]  #: (body, position in its frame), two at least
    weights: Optional[npt.ArrayLike] = None  #: [N], of the volume correction; None: all alike
    wraps: Sequence[Wrap] = ()
    belly: tuple[float, float] = (0.0, 0.0)  #: m along the path; both 0: a tenth from its ends
    stiffness: float = 1000.0  #: N/m, across the fibres
    f_max: float = 0.0  #: N, with which it can pull of itself
    activation: Sequence[tuple[float, float]] = ()  #: (frame, 0 to 1), frames rising
    by_joint: Optional[JointActivation] = None  #: in place of `activation`
    maps: Mapping[str, npt.ArrayLike] = dataclasses.field(default_factory=dict)
    """[N] each: "stiffness" (N/m) in place of the number, "thickness" (m) that contact keeps free"""


@dataclasses.dataclass
class Bone:
    """A rigid mesh fixed to a body, in the body's frame."""

    name: str
    body: str
    mesh: Mesh


@dataclasses.dataclass
class Skin:
    """A closed mesh over muscles and bones."""

    mesh: Mesh
    keeps_volume: bool = False  #: what it encloses stays what it is at rest
    maps: Mapping[str, npt.ArrayLike] = dataclasses.field(default_factory=dict)
    """[N] each: "fat" (m) under the rest shape, "slide" (0 sticks to the flesh, 1 slides freely)"""


@dataclasses.dataclass
class Solver:
    """How it is simulated."""

    integrator: str = "local_global"  #: or explicit, xpbd, quasi_static
    substeps: int = 1  #: in each frame
    iterations: int = 3  #: in each substep


@dataclasses.dataclass
class _Definition:
    name: str
    fps: float
    frames: tuple[int, int]
    bodies: Sequence[Body]
    clip: Optional[Clip]
    muscles: Sequence[Muscle]
    bones: Sequence[Bone]
    skin: Optional[Skin]
    solver: Optional[Solver]
    settle: float
    gravity: Vector3
    size: float


def _setting(key: str, value: Any) -> str:
    """As --set takes it: a word as it is, all else as TOML writes it."""
    if isinstance(value, str):
        return f"{key}={value}"
    return f"{key}={json.dumps(value, default=lambda one: np.asarray(one).tolist())}"


class Scene:
    """All that does not change while it is simulated, read and checked."""

    def __init__(self, *, bodies: Sequence[Body], name: str = "scene", fps: float = 24.0,
                 frames: tuple[int, int] = (1, 1), clip: Optional[Clip] = None,
                 muscles: Sequence[Muscle] = (), bones: Sequence[Bone] = (),
                 skin: Optional[Skin] = None, solver: Optional[Solver] = None,
                 settle: float = 2.0, gravity: Vector3 = (0.0, -9.81, 0.0),
                 size: float = 1.0) -> None:
        """From arrays, which are copied.

        frames: first and last. settle: s at most, before the first. size: this arm's length over a
        grown man's, by which all lengths that are not given are multiplied.
        """
        self._take(_thew.Scene(_Definition(name, fps, frames, bodies, clip, muscles, bones, skin,
                                           solver, settle, gravity, size)))

    @classmethod
    def read(cls, path: Path, set: Optional[Mapping[str, Any]] = None) -> Scene:
        """From a scene file. `set` changes keys of it: {"solver.iterations": 5}."""
        scene = cls.__new__(cls)
        scene._take(_thew.Scene.read(os.fspath(path),
                                     [_setting(*item) for item in (set or {}).items()]))
        return scene

    def _take(self, of: _thew.Scene) -> None:
        self._of = of
        info = of.info
        self.name: str = info["name"]
        self.fps: float = info["fps"]
        self.frames: tuple[int, int] = info["frames"]  #: first and last
        self.joints: list[str] = info["joints"]  #: those that can move
        self.meshes: list[str] = info["meshes"]  #: muscles, then bones, then "skin" if there is one
        self.warnings: list[str] = info["warnings"]

    def pose(self, frame: float) -> dict[str, float]:
        """Joint values in a frame of the clip: rad, or m of sliders."""
        return self._of.pose(frame)

    def __repr__(self) -> str:
        return (f"<thew.Scene {self.name!r}: frames {self.frames[0]} to {self.frames[1]}, "
                f"{len(self.meshes)} meshes>")


# What is done with scenes and bakes

def _document(text: str) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(text)
    return document


class Progress(NamedTuple):
    """Where a bake is."""

    frame: int  #: that has been written
    done: int  #: how many have been
    of: int  #: how many are to be


def bake(scene: Scene, out: Path, *, progress: Optional[Callable[[Progress], Any]] = None,
         resume: bool = True, frames: str = "", threads: int = 0) -> Bake:
    """Simulates the scene into the folder `out`: bake.h5, report.json and report.html, to the byte
    of positions as the command makes them; `python3 -m thew render` adds pictures.

    progress is called after each written frame, and cancels the bake by returning False; so does
    Ctrl-C. Frames that are written stay, and the next call goes on from them. resume=False bakes
    anew, and replaces what Thew itself has left there. frames: "1-120x2", "" for all. threads: 0
    for all; the result does not depend on them.
    """
    told = None if progress is None else lambda *now: progress(Progress(*now))
    return Bake(_thew.bake(scene._of, os.fspath(out), frames, threads, told, resume))


class Simulation(_thew.Simulation):
    """A scene in motion, frame by frame, without files."""

    def __init__(self, scene: Scene, threads: int = 1) -> None:
        super().__init__(scene._of, threads)


def compare(expected: Path, actual: Path, *, distance: float = 1e-7,
            frames: str = "") -> dict[str, Any]:
    """Two bakes, PNGs, or folders of them: ["same"], and how far each mesh is apart.

    distance: m that a vertex may move. The rest is what `thew compare --json` prints.
    """
    return _document(_thew.compare(os.fspath(expected), os.fspath(actual), 1e3 * distance, frames))


def export(bake: Union[Bake, Path], out: Path, *, meshes: Iterable[str] = (), frames: str = "",
           basis: int = 0, onto: Optional[Path] = None, correctives: bool = False,
           quantized: bool = False, fields: bool = False, overwrite: bool = False) -> dict[str, Any]:
    """A bake for other programs; the ending of `out` says which (.pc2 .mdd .obj .ply .glb .xdmf
    .usda .abc).

    meshes: by name, all where empty. onto: the character whose skin it is, for .glb, or an OBJ of the
    skin in the artist's order, for .pc2, .mdd, .usd*, .abc and .obj; "none" for the bake's own meshes.
    quantized: .glb, half as large. fields: by node, .usd* and .abc. overwrite: also a file that Thew
    did not write. Returns what was written.
    """
    flags = {name for name, given in [("correctives", correctives), ("quantized", quantized), ("fields", fields),
                                      ("overwrite", overwrite)] if given}
    path = bake.path if isinstance(bake, Bake) else os.fspath(bake)
    return _document(_thew.export(path, os.fspath(out), list(meshes), frames, basis,
                                  os.fspath(onto or ""), flags))


def fit(character: Path, out: Optional[Path] = None, *, side: str = "both",
        scale: Optional[float] = None, map: Optional[Mapping[str, str]] = None,
        skin: Iterable[str] = (), overwrite: bool = False) -> dict[str, Any]:
    """Puts the arm's muscles on a skinned character, and writes a scene to go on with.

    out: SCENE.toml; None: beside the character, under its name. side: left, right or both. scale:
    times all lengths of the file; None: as a person's size asks for. map: {"humerus": BODY}, of parts
    that are not found. skin: meshes around the arm, of several. Returns {"scene": ..., "warnings":
    ..., "arms": ...}.
    """
    scene = os.path.splitext(os.fspath(character))[0] + ".toml" if out is None else os.fspath(out)
    return _document(_thew.fit(os.fspath(character), scene, side, scale, dict(map or {}),
                               list(skin), overwrite))


def set_import_mode(mode: str) -> None:
    """Where foreign files are parsed, from the next one on: "isolated", in a process of its own,
    which nothing hostile gets out of; or "in_process", for a host that must not fork."""
    _thew.set_import_mode(mode)
