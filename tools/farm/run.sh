#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs one task of an array: run.sh FOLDER FIRST, the line of tasks.txt that the array's first is on.
set -euo pipefail
line=$(($2 + SLURM_ARRAY_TASK_ID - 1))
command=$(sed -n "${line}{p;q}" "$1/tasks.txt")
[[ -n $command ]] || { echo "run.sh: $1/tasks.txt has no line $line" >&2; exit 2; }
eval "exec $command"  # in this process, which the signal before the time limit goes to
