# SPDX-License-Identifier: Apache-2.0
"""import thew: module.py THEW SOURCE FOLDER [TEST...], with PYTHONPATH on the module that was built."""
import _thread
import gc
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

import thew

COMMAND, SOURCE, WORK = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
SCENES = SOURCE / "tests/scenes"
PAIR = SCENES / "pair/scene.toml"
LOADS = int(os.environ.get("THEW_LOADS", "100"))
SANITIZED = "ASAN_OPTIONS" in os.environ


def fresh(name):
    shutil.rmtree(WORK / name, ignore_errors=True)
    return WORK / name


def spindle(length=0.32, radius=0.018, around=12, rings=15):
    """Rings along -y, and a pole at both ends."""
    u = np.arange(1, rings + 1)[:, None] / (rings + 1)
    angle = 2 * np.pi * np.arange(around) / around
    r = radius * np.sin(np.pi * u)
    body = np.stack(np.broadcast_arrays(r * np.cos(angle), -u * length, r * np.sin(angle)), -1)
    positions = np.concatenate([[[0, 0, 0]], body.reshape(-1, 3), [[0, -length, 0]]])
    last, triangles = rings * around + 1, []
    for k in range(around):
        n = (k + 1) % around
        triangles.append((0, 1 + n, 1 + k))
        for first in range(1, last - around, around):
            a, b = first + k, first + n
            triangles += [(a, b, a + around), (b, b + around, a + around)]
        triangles.append((last, last - around + k, last - around + n))
    # numpy's sines differ in the last bit with where their arrays lie in memory.
    return np.round(positions + [0.03, -0.03, 0], 12), np.array(triangles)


def elbow(**more):
    return thew.Scene(
        name="elbow", frames=(1, 12),
        bodies=[thew.Body("humerus"),
                thew.Body("ulna", "humerus", thew.Joint("elbow", position=(0, -0.3, 0)))],
        clip=thew.Clip(["elbow"], [1, 12], [[0], [1]]),
        muscles=[thew.Muscle("flexor", spindle(),
                             [("humerus", (0.03, -0.03, 0)), ("ulna", (0.03, -0.05, 0))], **more)])


def volume(positions, triangles):
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij", a, np.cross(b, c)) / 6


def command(*words):
    """Without what a sanitizer has this process load, since the command has its own."""
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    subprocess.run([COMMAND, *words], check=True, stderr=subprocess.DEVNULL, env=environment)


class Bakes(unittest.TestCase):
    maxDiff = None

    def test_the_bytes_are_the_commands(self):
        for name in ("one_muscle", "pair", "slope"):
            scene = SCENES / name / "scene.toml"
            theirs = fresh(f"command_{name}")
            command("bake", scene, "--out", theirs, "--frames", "1-8", "--no-render",
                    "--progress", "none")
            bake = thew.bake(thew.Scene.read(scene), fresh(f"module_{name}"), frames="1-8")
            self.assertEqual(bake.hash, json.loads((theirs / "report.json").read_text())["hash"])
            self.assertEqual(pathlib.Path(bake.path).read_bytes(), (theirs / "bake.h5").read_bytes())
            self.assertTrue(thew.compare(theirs / "bake.h5", bake.path)["same"])

    def test_a_report_like_the_commands(self):
        theirs, ours = fresh("report_command"), fresh("report_module")
        command("bake", PAIR, "--out", theirs, "--no-render", "--progress", "none")
        bake = thew.bake(thew.Scene.read(PAIR), ours)
        expected = json.loads((theirs / "report.json").read_text())
        self.assertGreater(bake.report["seconds"]["total"], 0)
        self.assertTrue((ours / "report.html").is_file())
        (ours / "report.json").unlink()  # of a complete bake it is written again
        for report in (bake.report, thew.bake(thew.Scene.read(PAIR), ours).report):
            self.assertEqual(set(report), set(expected))
            for name in set(expected) - {"seconds", "cpu_seconds", "origin"}:  # of this run
                self.assertEqual(report[name], expected[name], name)

    def test_settings_change_the_scene(self):
        bakes = [thew.bake(thew.Scene.read(SCENES / "one_muscle/scene.toml",
                                           set={"muscle.flexor.weights": weights,
                                                "scene.frames": "1-4", "rig.clip.keys.elbow":
                                                [[1, 0], [24, 90]]}), fresh("set_" + weights))
                 for weights in ("left", "right")]
        self.assertNotEqual(bakes[0].hash, bakes[1].hash)
        self.assertEqual(list(bakes[0].frames), [1, 2, 3, 4])

    def test_cancelled_and_resumed(self):
        scene, told = thew.Scene.read(PAIR), []
        whole = thew.bake(scene, fresh("whole"), progress=told.append)
        self.assertEqual(told, [thew.Progress(n, n, 16) for n in range(1, 17)])
        out = fresh("cancelled")
        with self.assertRaises(thew.Error) as caught:
            thew.bake(scene, out, progress=lambda now: now.done < 5)
        self.assertEqual(caught.exception.code, 75)
        self.assertFalse((out / "bake.h5").exists())
        with self.assertRaises(ZeroDivisionError):  # what a callback raises comes through
            thew.bake(scene, out, progress=lambda now: 1 // (now.done - 9))
        count = []
        resumed = thew.bake(scene, out, progress=count.append)
        self.assertEqual(len(count), 16)
        self.assertEqual(resumed.hash, whole.hash)
        self.assertEqual(pathlib.Path(resumed.path).read_bytes(),
                         pathlib.Path(whole.path).read_bytes())
        other = thew.Scene.read(PAIR, set={"scene.frames": "1-3"})
        with self.assertRaises(thew.Error) as caught:
            thew.bake(other, out)
        self.assertEqual(caught.exception.code, 2)
        self.assertIn("resume=False", caught.exception.next)
        self.assertEqual(len(thew.bake(other, out, resume=False).frames), 3)

    @unittest.skipUnless(signal.getsignal(signal.SIGINT) is signal.default_int_handler,
                         "Blender keeps Ctrl-C for itself")
    def test_control_c(self):
        scene = thew.Scene.read(PAIR, set={"scene.frames": "1-20000"})
        threading.Timer(0.3, _thread.interrupt_main).start()
        began = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            thew.bake(scene, fresh("interrupted"))
        self.assertTrue((WORK / "interrupted/bake.parts").is_dir())
        self.assertLess(time.monotonic() - began, 60)

    def test_other_threads_run_on_and_bake_too(self):
        """With readers all the while: none waits for a lock that a fork has copied, or for the GIL."""
        scene = thew.Scene.read(PAIR, set={"scene.frames": "1-6"})
        reference = thew.bake(scene, fresh("threads_0"))
        hashes, failures = [], []

        def work(out):
            try:
                for _ in range(2):
                    hashes.append(thew.bake(scene, out, resume=False).hash)
            except BaseException as error:
                failures.append(error)

        for mode in ("in_process", "isolated"):
            thew.set_import_mode(mode)
            threads = [threading.Thread(target=work, args=[fresh(f"threads_{n}")]) for n in (1, 2)]
            for thread in threads:
                thread.start()
            turns = 0
            while any(thread.is_alive() for thread in threads):
                thew.load(WORK / "threads_0").meshes["skin"].at(1)
                turns += 1
            self.assertEqual(failures, [])
            self.assertGreater(turns, 3)
        self.assertEqual(hashes, [reference.hash] * 8)


class Reading(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = WORK / "read"
        thew.bake(thew.Scene.read(PAIR), fresh("read"))

    def test_what_a_bake_holds(self):
        import h5py
        bake = thew.load(self.folder)
        self.assertEqual(sorted(bake.meshes), ["front", "humerus", "side", "skin", "ulna"])
        with h5py.File(bake.path) as file:
            self.assertEqual(list(bake.frames), list(file["frames"]))
            self.assertEqual(bake.hash, file.attrs["hash"].decode())
            for name, mesh in bake.meshes.items():
                truth = file["meshes"][name]
                self.assertEqual(mesh.kind, truth.attrs["kind"].decode())
                np.testing.assert_array_equal(mesh.rest, truth["rest"])
                np.testing.assert_array_equal(mesh.triangles, truth["triangles"])
                np.testing.assert_array_equal(mesh.positions, truth["positions"])
                np.testing.assert_array_equal(mesh.at(7), truth["positions"][6])
                if mesh.kind == "muscle":
                    np.testing.assert_array_equal(mesh.weights, truth["weights"])
            np.testing.assert_array_equal(bake.metrics["length/front"], file["metrics/length/front"])
        self.assertIs(bake.meshes["skin"].positions, bake.meshes["skin"].positions)
        for array in (bake.frames, mesh.rest, mesh.triangles, mesh.positions):
            self.assertFalse(array.flags.writeable)

    def test_an_array_outlives_its_bake(self):
        def arrays():
            bake = thew.load(self.folder)
            mesh = bake.meshes["front"]
            return [bake.frames, mesh.rest, mesh.triangles, mesh.weights, mesh.positions, mesh.at(3),
                    bake.metrics["length/front"]]

        kept = arrays()
        before = [array.copy() for array in kept]
        gc.collect()
        trash = [np.full(100_000, 7.0) for _ in range(50)]  # over whatever was given back
        del trash
        for array, copy in zip(kept, before):
            np.testing.assert_array_equal(array, copy)

    def test_loads_do_not_grow(self):
        """A hundred; a thousand in the long tests."""
        def resident():
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * resource.getpagesize()

        def load():
            bake = thew.load(self.folder)
            bake.meshes["skin"].positions.sum()
            for frame in bake.frames:
                bake.meshes["skin"].at(frame)
            bake.metrics

        for _ in range(20):
            load()
        files, before = len(os.listdir("/proc/self/fd")), resident()
        for _ in range(LOADS):
            load()
        self.assertEqual(len(os.listdir("/proc/self/fd")), files)
        if not SANITIZED:  # which keeps what was freed
            self.assertLess(resident() - before, 2 << 20)  # bytes


class Arrays(unittest.TestCase):
    def test_a_scene_from_arrays(self):
        scene, rest = elbow(), spindle()
        self.assertEqual((scene.joints, scene.meshes), (["elbow"], ["flexor"]))
        self.assertAlmostEqual(scene.pose(12)["elbow"], 1.0)
        bake = thew.bake(scene, fresh("arrays"))
        simulation = thew.Simulation(scene)
        simulation.settle()
        while simulation.step() < 12:
            pass
        positions = simulation.positions("flexor")
        np.testing.assert_array_equal(positions.astype(np.float32), bake.meshes["flexor"].at(12))
        np.testing.assert_array_equal(simulation.triangles("flexor"), rest[1])
        self.assertEqual(simulation.joints(), [1.0])
        self.assertLess(abs(volume(positions, rest[1]) / volume(*rest) - 1), 1e-12)
        self.assertIn("length/flexor", simulation.measures())
        self.assertAlmostEqual(simulation.time, 11 / 24)
        self.assertEqual(bake.report["muscles"][0]["name"], "flexor")
        weights = np.linspace(0, 1, len(rest[0]))
        self.assertNotEqual(thew.bake(elbow(weights=weights), fresh("weights")).hash, bake.hash)
        bent = thew.JointActivation("elbow", curve=[(0, 0.2), (57, 0.9)])
        self.assertNotEqual(thew.bake(elbow(by_joint=bent, f_max=300), fresh("bent")).hash,
                            bake.hash)

    def test_maps_are_arrays(self):
        count = len(spindle()[0])
        bakes = [thew.bake(elbow(**more), fresh("map")).hash for more in (
            {"stiffness": 700}, {"maps": {"stiffness": np.full(count, 700)}},
            {"maps": {"stiffness": np.linspace(500, 900, count)}})]
        self.assertEqual(bakes[0], bakes[1])
        self.assertNotEqual(bakes[0], bakes[2])

    def test_every_definition(self):
        box = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.02
        faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7),
                 (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
        scene = thew.Scene(
            name="all", fps=30, frames=(5, 6), settle=0, gravity=(0, 0, 0), size=0.9,
            bodies=[thew.Body("a"), thew.Body("b", "a", thew.Joint("slide", "slider", (0, -0.3, 0),
                                                                  (0, 1, 0), (-0.1, 0.1)))],
            clip=thew.Clip(["slide"], [5, 6], [[0.0], [0.01]]),
            bones=[thew.Bone("block", "b", (box, faces))],
            skin=thew.Skin((box * 20 - 0.2, faces), maps={"slide": np.linspace(0, 1, 8)}),
            muscles=[thew.Muscle("flexor", spindle(), [("a", (0.03, -0.03, 0)),
                                                       ("b", (0.03, -0.05, 0))],
                                 wraps=[thew.Wrap(0, "a", (0, -0.2, 0), (0, 0, 1), 0.01)],
                                 belly=(0.05, 0.25), stiffness=900, f_max=10,
                                 activation=[(5, 0), (6, 1)])],
            solver=thew.Solver("xpbd", 4, 2))
        self.assertEqual((scene.fps, scene.frames), (30, (5, 6)))
        self.assertEqual(scene.meshes, ["flexor", "block", "skin"])
        self.assertEqual(thew.Simulation(scene, threads=2).step(), 6)


class Errors(unittest.TestCase):
    def check(self, code, said, call):
        with self.assertRaises(thew.Error) as caught:
            call()
        self.assertEqual(caught.exception.code, code, caught.exception)
        self.assertIn(said, str(caught.exception))
        return caught.exception

    def test_place_cause_and_next_move(self):
        shutil.copytree(PAIR.parent, fresh("wrong"))
        scene = WORK / "wrong/scene.toml"
        text = PAIR.read_text().replace('name = "front"', 'name = "front"\nwrong = 1', 1)
        scene.write_text(text)
        error = self.check(2, "unknown key", lambda: thew.Scene.read(scene))
        self.assertEqual(error.file, str(scene))
        self.assertEqual(text.splitlines()[error.line - 1], "wrong = 1")
        error = self.check(3, "", lambda: thew.load(SOURCE / "README.md"))
        self.assertEqual(error.file, str(SOURCE / "README.md"))
        self.assertTrue(error.message and error.next)
        self.check(4, "", lambda: thew.bake(elbow(), "/proc/nowhere"))
        self.check(2, "did you mean", lambda: thew.Scene.read(PAIR, {"solver.iteratons": 3}))
        self.check(2, "integrator", lambda: thew.Scene(bodies=[thew.Body("a")],
                                                       solver=thew.Solver("xpdb")))
        self.assertIsInstance(error, RuntimeError)

    def test_arrays_that_do_not_fit(self):
        positions, triangles = spindle()
        wrong = {"rows of three": (positions[:, :2], triangles),
                 "whole numbers": (positions, triangles * 1.0),
                 "vertex": (positions, triangles + 1),
                 "closed": (positions, triangles[1:]),
                 "pair": (positions,),
                 "no numbers": ([["a"]], triangles)}
        for said, mesh in wrong.items():
            self.check(2, said, lambda: thew.Scene(
                bodies=[thew.Body("a")],
                muscles=[thew.Muscle("m", mesh, [("a", (0, 0, 0)), ("a", (0, -1, 0))])]))
        self.check(2, "name", lambda: thew.Scene(bodies=[thew.Body(3)]))
        self.check(2, "kind", lambda: thew.Scene(
            bodies=[thew.Body("a"), thew.Body("b", "a", thew.Joint("j", "ball"))]))
        self.check(2, "weights", lambda: elbow(weights=[1, 2]))
        self.check(2, "stiffness has 2 values", lambda: elbow(maps={"stiffness": [1, 2]}))
        self.check(2, "did you mean", lambda: elbow(maps={"stifness": [1, 2]}))

    def test_no_such_mesh_or_frame(self):
        bake = thew.bake(elbow(), fresh("no_such"))
        self.check(2, "frame 99", lambda: bake.meshes["flexor"].at(99))
        self.check(2, "did you mean", lambda: thew.Simulation(elbow()).positions("flexr"))


class Commands(unittest.TestCase):
    def test_export_and_compare(self):
        bake = thew.bake(thew.Scene.read(PAIR), WORK / "read")
        out = fresh("exports") / "skin.pc2"
        out.parent.mkdir()
        self.assertEqual(thew.export(bake, out, meshes=["skin"])["files"][0], str(out))
        header = np.frombuffer(out.read_bytes()[:32], "<i4")
        self.assertEqual((header[4], header[7]), (len(bake.meshes["skin"].rest), 16))
        with self.assertRaises(thew.Error):
            thew.export(bake, out.with_suffix(".xyz"))
        other = thew.bake(thew.Scene.read(PAIR, set={"scene.settle": 0}),
                          fresh("unsettled"))
        result = thew.compare(bake.path, other.path)
        self.assertFalse(result["same"])
        self.assertGreater(result["geometry"]["meshes"][0]["max_distance_mm"], 0)

    def test_fit(self):
        out = fresh("fit") / "figure.toml"
        fitted = thew.fit(SCENES / "figure/figure.gltf", out, side="right")
        self.assertEqual((fitted["scene"], fitted["muscles"]), (str(out), 12))
        self.assertIn("skin", thew.Scene.read(fitted["scene"]).meshes)
        shutil.copy(SCENES / "figure/figure.gltf", fresh("fit_beside").parent)  # beside the character
        self.assertEqual(thew.fit(WORK / "figure.gltf", side="left", overwrite=True)["scene"],
                         str(WORK / "figure.toml"))

    def test_all_that_is_offered_is_explained(self):
        for name in thew.__all__:
            offered = getattr(thew, name)
            self.assertTrue(offered.__doc__, name)
            for method, what in vars(offered).items() if isinstance(offered, type) else ():
                if callable(what) and not method.startswith("_"):
                    self.assertTrue(what.__doc__, f"{name}.{method}")
        for method in ("settle", "step", "step_to", "positions", "triangles", "joints", "measures"):
            self.assertIn("\n\n", getattr(thew.Simulation, method).__doc__, method)

    @unittest.skipIf(SANITIZED, "the command has the sanitizer's own runtime")
    def test_the_command_by_python(self):
        version = subprocess.run([sys.executable, "-m", "thew", "--version"], check=True,
                                 capture_output=True, text=True).stdout
        self.assertIn(thew.__version__, version)
        self.assertEqual(subprocess.run([sys.executable, "-m", "thew", "bake"],
                                        capture_output=True).returncode, 2)

    def test_the_example_prints_its_table(self):
        program = "import sys; sys.modules['matplotlib'] = None; sys.argv[1:] = sys.argv[2:]; " \
                  f"exec(open({str(SOURCE / 'tools/examples/plot_length.py')!r}).read())"
        printed = subprocess.run(
            [sys.executable, "-c", program, "-", PAIR, WORK / "read", "front"], check=True,
            capture_output=True, text=True).stdout.split("\n")
        rows = [row.split("\t") for row in printed if "\t" in row]
        self.assertEqual(rows[0], ["elbow (deg)", "front (mm)"])
        self.assertEqual((len(rows), rows[1][1]), (17, "320.00"))


if __name__ == "__main__":
    WORK.mkdir(parents=True, exist_ok=True)
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
