#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Submits the tasks of this folder to Slurm, an array for each line of arrays.txt. What it has
# submitted is in submitted.txt; if it breaks off, run it again, and it goes on. sbatch reads its
# own variables: SBATCH_PARTITION, SBATCH_ACCOUNT, ...
set -euo pipefail
cd -P -- "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")" >/dev/null
here=$PWD
if config=$(scontrol show config 2>/dev/null) &&
  ! grep -qE '^RequeueExit +=.*\b75\b' <<<"$config"; then
  echo "submit.sh: warning: slurm.conf has no RequeueExit=75: a task that its time limit" \
    "interrupts will count as failed; ask for it, or submit again" >&2
fi
declare -A job
touch submitted.txt
while read -r name id; do job[$name]=$id; done <submitted.txt
while read -r name first count threads memory minutes how after; do
  [[ -z ${job[$name]:-} ]] || continue
  dependency=()
  if [[ $how != none ]]; then
    ids=
    for one in $after; do ids+=:${job[$one]}; done
    dependency=(--dependency="$how$ids")
  fi
  id=$(sbatch --parsable --job-name="thew $name" --array="1-$count" "${dependency[@]}" \
    --cpus-per-task="$threads" --mem="${memory}M" --time="$minutes" \
    --requeue --signal=B:TERM@45 --kill-on-invalid-dep=yes \
    --open-mode=append --output="$here/logs/$name.%a.log" "$here/run.sh" "$here" "$first")
  job[$name]=${id%%;*}
  echo "$name ${job[$name]}" >>submitted.txt
done <arrays.txt
