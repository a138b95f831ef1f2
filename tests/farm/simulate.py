# SPDX-License-Identifier: Apache-2.0
"""A show's tasks on a cluster that is only played: simulate.py THEW ROOT OUT SHOTS CHARACTERS

Plans, graph, arrays and submit.sh are the real ones. sbatch is a script that keeps what it is given,
and what stands in for Slurm here starts elements in any order that their dependencies allow, lets
one in a hundred fail and as many end with 75, and cancels what waits for a failed one. In place of
thew it leaves the files by which thew would know that a task is done. No element may start before
all that its task needs by the graph (--json) is done. What failed is submitted again, until the show
is complete.
"""
import json
import os
import random
import shlex
import shutil
import stat
import subprocess
import sys
import time

THEW, ROOT, OUT = (os.path.abspath(word) for word in sys.argv[1:4])
SHOTS, CHARACTERS = int(sys.argv[4]), int(sys.argv[5])
FAILURES = 0.01
chance = random.Random(29)


def write(path, text, mode="w"):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, mode, encoding="utf-8") as file:
        file.write(text)


def make_jobs():
    scene = os.path.relpath(os.path.join(ROOT, "tests/scenes/pair/scene.toml"), OUT)
    text = 'chunk = 40\npictures = 80\nexports = ["baked.usda"]\n'
    for c in range(CHARACTERS):
        text += f'[[character]]\nname = "c{c}"\nscene = "{scene}"\n'
        if c % 5 == 4:  # their frames stand alone
            text += 'set = ["solver.integrator=quasi_static"]\n'
    for s in range(SHOTS):
        text += f'[[shot]]\nname = "s{s}"\nset = ["scene.frames=1-{chance.randrange(24, 241)}"]\n'
    write(f"{OUT}/jobs.toml", text)


def make_programs():
    programs = {
        # Once, it is full.
        "sbatch": f'id=$(($(find {OUT}/queue -type f | wc -l) + 1))\n'
                  f"[[ $id != 20 || -e {OUT}/full ]] || {{ touch {OUT}/full; exit 1; }}\n"
                  f"printf '%s\\0' \"$@\" >{OUT}/queue/$id\necho $id\n",
        "scontrol": "echo 'RequeueExit             = 75'\n"}
    for name, text in programs.items():
        path = f"{OUT}/bin/{name}"
        write(path, "#!/usr/bin/env bash\n" + text)
        os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)


def farm(*more):
    """What thew farm prints. Where it could not submit all, submit.sh goes on with the rest."""
    path = {**os.environ, "PATH": f"{OUT}/bin:{os.environ['PATH']}"}
    done = subprocess.run([THEW, "farm", f"{OUT}/jobs.toml", "--json", *more], env=path,
                          stdout=subprocess.PIPE, text=True)
    told = json.loads(done.stdout)
    if done.returncode != 0:
        assert done.returncode == 75, told
        print("the queue is full; the rest by submit.sh")
        subprocess.run([told["error"]["message"].split()[0]], env=path, check=True)
    return told


def after_option(words, name):
    return words[words.index(name) + 1]


class Queue:
    """What was submitted, element by element."""

    def __init__(self):
        self.elements = {}  # (job, index): command line
        self.needs = {}  # (job, index): elements that have to be done, or over
        self.any_end = set()  # jobs that only wait for the end of others
        counts = {}
        for job in sorted(int(name) for name in os.listdir(f"{OUT}/queue")):
            with open(f"{OUT}/queue/{job}", encoding="utf-8") as file:
                words = file.read().split("\0")[:-1]
            options = dict(word.split("=", 1) for word in words if word.startswith("--") and "=" in word)
            flags = [word for word in words if word in ("--requeue", "--parsable")]
            assert len(flags) == 2 and options["--signal"] == "B:TERM@45", words
            assert options["--kill-on-invalid-dep"] == "yes", words
            first, last = options["--array"].split("-")
            assert first == "1" and int(last) <= 1000, words
            counts[job] = int(last)
            folder, line = words[-2:]
            with open(f"{folder}/tasks.txt", encoding="utf-8") as file:
                lines = file.read().splitlines()[int(line) - 1:int(line) - 1 + counts[job]]
            assert len(lines) == counts[job], words
            how, *others = options.get("--dependency", "none").split(":")
            assert how in ("none", "aftercorr", "afterany"), how
            if how == "afterany":
                self.any_end.add(job)
            for i, text in enumerate(lines, 1):
                self.elements[job, i] = text
                self.needs[job, i] = ([(int(o), i) for o in others] if how == "aftercorr" else
                                      [(int(o), k) for o in others
                                       for k in range(1, counts[int(o)] + 1)])


def play(words):
    """What thew would leave of a task that is done."""
    command, where = words[1], words[2]
    if command == "bake":
        folder = after_option(words, "--out")
        if "--join" in words:
            chunks = sorted(os.listdir(after_option(words, "--join")))
            assert chunks, "joined before its chunks"
        write(f"{folder}/chunk" if "--chunk" in words else f"{folder}/report.json",
              json.dumps({"origin": {"command": shlex.join(words)}}))
    elif command == "render":
        assert os.path.exists(os.path.join(os.path.dirname(where), "report.json")), words
    elif command == "export":
        assert os.path.exists(os.path.join(os.path.dirname(where), "report.json")), words
        folder, name = os.path.split(words[3])
        write(words[3], "")
        write(f"{folder}/.thew.jsonl", f'{{"file":"{name}","bytes":0,"hash":"","of":""}}\n', "a")


def run_wave(graph, counted):
    queue = Queue()
    tasks = {shlex.join(task["command"]): task for task in graph["tasks"]}
    commands = {task["task"]: shlex.join(task["command"]) for task in graph["tasks"]}
    lines = {element: shlex.join(shlex.split(text)) for element, text in queue.elements.items()}
    assert sorted(lines.values()) == sorted(tasks), "what is submitted is not the graph"
    state = {}  # by element; by command line too
    waiting = {}
    for element, needs in queue.needs.items():
        for need in needs:
            waiting.setdefault(need, []).append(element)
    left = {element: len(needs) for element, needs in queue.needs.items()}
    ready = [element for element, count in left.items() if count == 0]

    def end(element, what):
        state[element] = state[lines[element]] = what
        counted[what] += 1
        for other in waiting.get(element, []):
            left[other] -= 1
            if other in state:
                continue
            if what != "done" and other[0] not in queue.any_end:
                end(other, "cancelled")
            elif left[other] == 0:
                ready.append(other)

    while ready:
        at = chance.randrange(len(ready))
        ready[at], ready[-1] = ready[-1], ready[at]
        element = ready.pop()
        if element in state:
            continue
        task = tasks[lines[element]]
        for need in task["after"]:
            over = state.get(commands[need])
            assert over == "done" or (over and task["task"] == "report.1"), (task, need, over)
        luck = chance.random()
        if luck < FAILURES:
            end(element, "failed")
        elif luck < 2 * FAILURES:  # interrupted: RequeueExit=75
            counted["requeued"] += 1
            ready.append(element)
        else:
            play(shlex.split(queue.elements[element]))
            end(element, "done")
    assert len(state) == 2 * len(lines), "elements that wait for ever"


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    make_jobs()
    make_programs()
    graph = farm("--dry-run")
    first = len(graph["tasks"])
    print(f"{graph['bakes']} bakes, {first} tasks")
    for wave in range(1, 20):
        shutil.rmtree(f"{OUT}/queue", ignore_errors=True)
        os.makedirs(f"{OUT}/queue")
        graph = farm("--dry-run")
        begin = time.monotonic()
        farm("--slurm", f"{OUT}/jobs", "--submit")
        seconds = time.monotonic() - begin
        graph = graph if wave > 1 else farm("--dry-run")  # the pilot changes what is asked for
        calls = len(os.listdir(f"{OUT}/queue"))
        counted = {"done": 0, "failed": 0, "cancelled": 0, "requeued": 0}
        run_wave(graph, counted)
        now = farm("--dry-run")
        told = ", ".join(f"{count} {what}" for what, count in counted.items())
        print(f"submission {wave}: {len(graph['tasks'])} tasks in {calls} arrays, planned and "
              f"submitted in {seconds:.0f} s; {told}; {now['complete']} of {now['bakes']} bakes complete")
        if now["complete"] == now["bakes"]:
            break
    assert now["complete"] == now["bakes"] and wave > 1, "not complete, or nothing failed"


main()
