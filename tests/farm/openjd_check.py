# SPDX-License-Identifier: Apache-2.0
"""Job templates against what is published of Open Job Description: openjd_check.py TEMPLATE...

First the schema (openjd_2023_09.json), then what a schema cannot say: names are unique, a step
depends on steps of the same job and on none in a circle, what a format string refers to is there,
and values that are combined task by task are as many. Then the tasks are run in the order that the
steps allow, by a worker of a few lines: --run stops at the first that fails, and each has to say how
far it is by openjd_progress. Ends with 77 where python3-jsonschema is not installed.
"""
import json
import os
import re
import subprocess
import sys

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed")
    sys.exit(77)

WORDS = re.compile(r"\{\{\s*([^}]*?)\s*\}\}")


def unique(names, what):
    assert len(set(names)) == len(names), f"{what} of the same name"


def tasks_of(step):
    """The values of the task parameters, task by task."""
    space = step.get("parameterSpace")
    if not space:
        return [{}]
    parameters = space["taskParameterDefinitions"]
    names = [one["name"] for one in parameters]
    unique(names, "task parameters")
    assert space["combination"] == "(" + ", ".join(names) + ")", space["combination"]
    counts = {len(one["range"]) for one in parameters}
    assert len(counts) == 1, f"{step['name']}: ranges of different lengths"
    return [dict(zip(names, values)) for values in zip(*(one["range"] for one in parameters))]


def check(job):
    parameters = [one["name"] for one in job["parameterDefinitions"]]
    unique(parameters, "job parameters")
    unique([step["name"] for step in job["steps"]], "steps")
    seen = set()
    for step in job["steps"]:
        for one in step.get("dependencies", []):
            assert one["dependsOn"] in seen, f"{step['name']}: no step {one['dependsOn']} before it"
        seen.add(step["name"])
        known = {"Param." + name for name in parameters}
        known |= {"Task.Param." + name for name in tasks_of(step)[0]}
        action = step["script"]["actions"]["onRun"]
        for text in [action["command"], *action["args"]]:
            for word in WORDS.findall(text):
                assert word in known, f"{step['name']}: {word} is nowhere defined"
        for parameter in step.get("parameterSpace", {}).get("taskParameterDefinitions", []):
            for value in parameter["range"]:  # PATH parameters are not known there: 7.3.1
                for word in WORDS.findall(value):
                    assert word in {"RawParam." + name for name in parameters}, word
    return seen


def run(job, folder):
    values = {}
    for one in job["parameterDefinitions"]:
        value = one["default"]
        if one["type"] == "PATH":  # joined with the folder of the template
            value = os.path.normpath(os.path.join(folder, value))
        values["Param." + one["name"]] = values["RawParam." + one["name"]] = value
    count = 0
    for step in job["steps"]:
        action = step["script"]["actions"]["onRun"]
        for task in tasks_of(step):
            known = dict(values)
            for name, value in task.items():
                known["Task.Param." + name] = WORDS.sub(lambda m: values[m[1]], value)
            words = [WORDS.sub(lambda m: known[m[1]], text)
                     for text in [action["command"], *action["args"]]]
            done = subprocess.run(words, capture_output=True, text=True)
            assert done.returncode == 0, f"{words}: {done.returncode}: {done.stderr}"
            if "--progress" in words:
                told = re.findall(r"^openjd_progress: ([0-9.]+)$", done.stdout, re.M)
                assert told and float(told[-1]) == 100.0, f"{words}: {done.stdout}"
            count += 1
    return count


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "openjd_2023_09.json"), encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    run_too = "--run" in sys.argv
    files = [word for word in sys.argv[1:] if word != "--run"]
    ran = 0
    for file in files:
        with open(file, encoding="utf-8") as text:
            job = json.load(text)
        validator.validate(job)
        check(job)
        if run_too:
            ran += run(job, os.path.dirname(os.path.abspath(file)))
    print(f"{len(files)} templates are as published" + (f", {ran} tasks ran" if run_too else ""))


main()
