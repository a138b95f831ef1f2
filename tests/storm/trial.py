# SPDX-License-Identifier: Apache-2.0
"""One command as a process with its limits, and the count of what came of all of them."""
import importlib.util
import os
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
NOT_A_NUMBER = re.compile(r"(?<![\w.])[-+]?(nan|inf|infinity)(?![\w.])", re.IGNORECASE)
KINDS = ["crashes", "hangs", "beyond memory", "silent", "ill told", "lost", "foreign touched",
         "different"]
# Of names that Thew's own files might have, in a folder that a bake is told to write to.
USERS_FILES = ["notes.txt", "skin.png", "bake.h5.old", "frames/holiday.png", "frames/muscles.png",
               "frames/skin.reference.png", "frames/kept/skin.0001.png", "bake.parts.mine/part"]


LIST = ".thew.jsonl"  # of what Thew wrote to a folder; it may outlive what it names


def put_users_files(out):
    for name in USERS_FILES:
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text(f"mine: {name}\n")


class Skipped(Exception):
    """What this machine lacks."""


def need_h5py():
    if not importlib.util.find_spec("h5py"):
        raise Skipped("python3-h5py is not installed")


@dataclass
class Ended:
    words: list
    code: int  # -n: by signal n
    out: str
    errors: list  # lines of stderr, but for warnings of the scene
    seconds: float  # of processor time, with its children's
    mebibytes: float  # the largest resident set of it and its children
    hung: bool  # ended by us

    def command(self):
        return shlex.join(str(word) for word in self.words)


@dataclass
class Limits:
    seconds: float = 2.0  # of processor time
    mebibytes: float = 1024.0
    wall: float = 120.0  # s, then it is killed
    patience: float = 0.0  # s, then it is interrupted as a user would; 0: never
    address_kib: int = 4_000_000  # ulimit -v, for the machine's sake
    file_blocks: int = 0  # ulimit -f, of 512 bytes; 0: none


class Storm:
    """What a part is given, and what it found."""

    def __init__(self, part, build, work, kept, given):
        self.part, self.build, self.work, self.kept = part, build, work, kept
        self.share, self.jobs = max(1, given.share), max(1, given.jobs)
        self.sanitized = given.sanitized
        self.thew = build / "tools/thew"
        self.lock = threading.Lock()
        self.failures = {}  # kind -> cases
        self.tried = self.commands = 0
        self.slowest = self.largest = 0.0
        self.notes = []

    def every(self, cases):
        """The share of them, one at least."""
        cases = list(cases)
        return cases[self.share // 2 % max(1, len(cases))::self.share]

    def over(self, function, cases):
        cases = list(cases)
        with ThreadPoolExecutor(self.jobs) as pool:
            for done in [pool.submit(function, case) for case in cases]:
                done.result()
        self.tried += len(cases)

    def start(self, words, limits=Limits()):
        """The command as a Popen; its output in files, so that nothing waits for a reader."""
        out, errors = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        set_limits = "ulimit -c 0;"
        if not self.sanitized:
            set_limits += (f" ulimit -t {int(4 * limits.seconds) + 4};"
                           f" ulimit -v {limits.address_kib};")
        if limits.file_blocks:
            set_limits += f" ulimit -f {limits.file_blocks};"
        process = subprocess.Popen(
            ["/bin/sh", "-c", set_limits + ' exec "$@"', "sh", self.thew, *words],
            stdin=subprocess.DEVNULL, stdout=out, stderr=errors)
        process.words, process.files = ["thew", *words], (out, errors)
        return process

    def finish(self, process, limits=Limits()):
        hung = threading.Event()

        # Not by Popen, which would take away what wait4 waits for.
        def kill():
            hung.set()
            os.kill(process.pid, signal.SIGKILL)
        timers = [threading.Timer(limits.wall, kill)]
        if limits.patience > 0:
            timers.append(
                threading.Timer(limits.patience, os.kill, [process.pid, signal.SIGTERM]))
        for timer in timers:
            timer.daemon = True
            timer.start()
        _, status, used = os.wait4(process.pid, 0)
        for timer in timers:
            timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for file in process.files:
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
            file.close()
        told = [line for line in texts[1].splitlines() if not line.startswith("thew: warning: ")]
        ended = Ended(process.words, process.returncode, texts[0], told,
                      used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, hung.is_set())
        with self.lock:
            self.commands += 1
            self.slowest = max(self.slowest, ended.seconds)
            self.largest = max(self.largest, ended.mebibytes)
        return ended

    @staticmethod
    def has_ended(process):
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def run(self, words, limits=Limits()):
        return self.finish(self.start(words, limits), limits)

    def check(self, ended, case, codes, limits=Limits(), inputs=(), may_say_nan=False):
        """What holds of any command: it ends by itself with one of the codes, and a code other
        than 0 and 1 with one message that says what is wrong."""
        def bad(kind, why):
            self.fail(kind, case, why, ended, inputs)
        text = "\n".join(ended.errors)
        if "Sanitizer" in text or "runtime error:" in text:
            return bad("crashes", text[:500])
        if self.sanitized:
            limits = Limits(seconds=30 * limits.seconds, mebibytes=16384)
        if ended.seconds > limits.seconds or ended.hung:
            bad("hangs", f"{ended.seconds:.1f} s of processor time")
        if ended.mebibytes > limits.mebibytes:
            bad("beyond memory", f"{ended.mebibytes:.0f} MiB")
        if ended.code < 0:
            is_ours = ended.hung or ended.seconds > 4 * limits.seconds  # who ended it
            return None if is_ours else bad("crashes", f"signal {-ended.code}")
        if "defect of Thew" in text or ended.code not in codes:
            return bad("crashes" if ended.code not in (0, 1, 2, 3, 4, 5, 75) else "ill told",
                       f"code {ended.code}: {text}")
        if not may_say_nan and NOT_A_NUMBER.search(text + ended.out):
            bad("ill told", "it speaks of nan or inf: " + (text or ended.out)[:300])
        # One message; the defects of a mesh follow it, each on a line of its own.
        is_one = (len(ended.errors) > 0 and text.startswith("thew: ") and len(text) < 4000 and
                  all(line.startswith("  ") for line in ended.errors[1:]))
        if ended.code == 3 and ended.words[1] == "inspect" and ended.out and not text:
            return None  # what is wrong with a file is what was asked for
        if ended.code > 1 and not is_one:
            return bad("ill told", f"{len(ended.errors)} lines: {text[:500]}")
        if ended.code == 0 and ended.errors and "nothing to do" not in text:
            return bad("ill told", f"code 0, yet: {text[:500]}")
        return None

    def check_users_files(self, out, case, ended):
        for name in USERS_FILES:
            file = out / name
            if not file.is_file() or file.read_text() != f"mine: {name}\n":
                self.fail("foreign touched", case, name, ended)

    def fail(self, kind, case, why, ended=None, inputs=()):
        assert kind in KINDS, kind
        with self.lock:
            found = self.failures.setdefault(kind, [])
            if case in found:  # by another command before
                return
            found.append(case)
            number = sum(len(cases) for cases in self.failures.values())
            if len(found) <= 12:
                print(f"{self.part}: {kind}: {case}: {why.splitlines()[0][:200]}"
                      f"{': ' + ended.command() if ended else ''}", flush=True)
            if len(found) > 50:
                return
            folder = self.kept / f"{number:03d}"
            folder.mkdir(parents=True, exist_ok=True)
            for file in inputs:
                if Path(file).is_dir():
                    shutil.copytree(file, folder / Path(file).name, symlinks=True)
                elif Path(file).exists():
                    shutil.copy(file, folder)
            said = [f"{kind}: {case}: {why}"]
            if ended:
                said += [ended.command(), f"code {ended.code}, {ended.seconds:.2f} s,"
                         f" {ended.mebibytes:.0f} MiB", *ended.errors, ended.out]
            (folder / "what").write_text("\n".join(said) + "\n")

    def line(self):
        counts = ", ".join(f"{len(self.failures.get(kind, []))} {kind}" for kind in KINDS)
        notes = "".join(f"; {note}" for note in self.notes)
        return (f"{self.part}: {self.tried:,} tried, {self.commands:,} commands: {counts}; slowest"
                f" {self.slowest:.1f} s, largest {self.largest:.0f} MiB{notes}")
