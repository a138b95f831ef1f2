#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A small show on a real Slurm cluster of this machine: slurm.sh THEW ROOT OUT
# While it runs, one bake gets TERM, one is requeued, one killed, one outlives its time limit round
# by round, the node goes down under another, one fails, and one misses a bound. The jobs are then
# submitted once more. At the end all bakes are the bytes of a bake by one process, all pictures
# are drawn, what depends on the failed ones has been cancelled and on the missed bound has not, and
# no process and no file outside of OUT is left. Ends with 77 where Slurm is not installed.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
thew=$(readlink -f "$1") root=$2 out=$3
for program in /usr/sbin/{munged,slurmctld,slurmd} /usr/bin/{sbatch,squeue,scontrol}; do
  [[ -x $program ]] || { echo "skipped: $program is not installed"; exit 77; }
done
. "$here/cluster.sh"

rm -rf "$out"
mkdir -p "$out"
out=$(cd "$out" && pwd -P)
fail() { echo "$*"; exit 1; }
outside() { find /etc /run /tmp /var/log /var/spool /var/lib -xdev -newer "$out/begin" \
  \( -iname '*slurm*' -o -iname '*munge*' -o -name 'thew_pilot*' \) -not -path "$out" -not -path "$out/*" 2>/dev/null; }
processes() { pgrep -f "$out" | grep -vxE "$$|$BASHPID" | xargs -r ps -o pid=,stat=,args= -p |
  awk '$2 !~ /^Z/ && !/pgrep|slurm\.sh/' || true; }
touch "$out/begin"
cp -r "$root/tests/scenes/pair" "$out/scene"
# Substeps by which the frames 1-16 take so many seconds here: bakes that can be hurt meanwhile.
milliseconds() { echo $(($(date +%s%N) / 1000000)); }
# The fastest of three: the machine may be busy with something else for a moment, and bakes that then
# end too soon are not hurt.
shortest=$(for i in 1 2 3; do
  begin=$(milliseconds)
  "$thew" bake "$out/scene/scene.toml" --out "$out/timed_$i" --no-render \
    --set solver.substeps=2000 --threads 1 --progress none >/dev/null 2>&1
  echo $(($(milliseconds) - begin))
done | sort -n | head -1)
per_second=$((2000 * 1000 / shortest))
slow=$((5 * per_second)) long=$((9 * per_second))
cat >"$out/jobs.toml" <<END
chunk = 6
pictures = 8
exports = ["baked.usda"]
[[character]]
name = "moving"
scene = "scene/scene.toml"
[[character]]
name = "posed"
scene = "scene/scene.toml"
set = ["solver.integrator=quasi_static", "scene.name=it's posed"]
[[shot]]
name = "calm"
frames = "1-12"
[[shot]]
name = "missed"
characters = ["moving"]
set = ["bound=[{volume_error=1e-30}]"]
[[shot]]
name = "long"
characters = ["moving"]
set = ["solver.substeps=$long", "scene.frames=1-96"]
frames = "1-96x6"
$(for shot in told requeued killed down; do
  printf '[[shot]]\nname = "%s"\ncharacters = ["moving"]\nframes = "1-16x8"\nset = [%s]\n' \
    $shot "\"solver.substeps=$slow\""
done)
[[shot]]
name = "broken"
characters = ["moving"]
frames = "1-4"
END
mkdir -p "$out/bakes/broken/moving"
echo "of somebody else" >"$out/bakes/broken/moving/bake.h5"

trap stop_cluster EXIT
start_cluster "$out"
"$thew" farm "$out/jobs.toml" --slurm "$out/jobs"
# The shortest time limit for the first array, calm, missed and long: TERM comes 45 s before the
# minute is over, and so every quarter of one.
sed -i -E 's/^(1\.bake\.1 1 3 1 [0-9]+) [0-9]+ /\1 1 /' "$out/jobs/1/arrays.txt"
grep -q '^1\.bake\.1 1 3 1 [0-9]* 1 ' "$out/jobs/1/arrays.txt" || fail "the first array is another"
"$out/jobs/1/submit.sh"
tasks=$(wc -l <"$out/jobs/1/tasks.txt")
((tasks >= 24)) || fail "only $tasks tasks"

# job SHOT: the array's element that bakes it, "12_3"
job() {
  local line name first count id
  line=$(grep -nF " bake $out/scene/scene.toml --out $out/bakes/$1/moving " "$out/jobs/1/tasks.txt" |
    grep -- --no-render)
  line=${line%%:*}
  while read -r name first count _; do
    ((line >= first && line < first + count)) || continue
    id=$(awk -v name="$name" '$1 == name { print $2 }' "$out/jobs/1/submitted.txt")
    echo "${id}_$((line - first + 1))"
  done <"$out/jobs/1/arrays.txt"
}
process() { pgrep -of "^$thew bake .* --out $out/bakes/$1/moving "; }
log() { cat "$out"/jobs/1/logs/*.bake.1.*.log; }
# started SHOT: waits until frames of it are on the disk
started() {
  local shot=$1
  for ((i = 0; i < 600; ++i)); do
    [[ -s $out/bakes/$shot/moving/bake.parts/manifest.jsonl ]] && return
    hasten
    sleep 0.3
  done
  fail "$shot did not start: $(squeue -r)"
}
# A task that is requeued waits two minutes, unless it is told not to. After a few seconds only: the
# machine still holds its last round's credential for revoked, and would end the next one with 1.
hasten() {
  local id until
  until=$(date -d '+115 seconds' +%FT%T)
  for id in $(squeue -h -r -t PENDING -o '%i %r %S' |
    awk -v until="$until" '$2 == "BeginTime" && $3 <= until { print $1 }'); do
    scontrol update JobId="$id" StartTime=now 2>/dev/null || true
  done
}
finish() {
  while [[ -n $(squeue -h) ]]; do
    hasten
    sleep 1
  done
}

started told
kill -TERM "$(process told)"
started requeued
scontrol requeue "$(job requeued)"
started killed
kill -KILL "$(process killed)"
started down
node=$(sinfo -h -N -o %N)
scontrol update NodeName="$node" State=DOWN Reason=test
sleep 2
scontrol update NodeName="$node" State=RESUME 2>/dev/null || true  # it may be back by itself
finish

rounds=$(grep -hc 'interrupted' "$out"/jobs/1/logs/*.log | awk '{ most = $1 > most ? $1 : most } END { print most }')
((rounds >= 2)) || fail "the time limit ended no task twice: $rounds"
for shot in killed broken; do
  for left in frames report.json baked.usda; do
    [[ ! -e $out/bakes/$shot/moving/$left ]] || fail "$shot/moving/$left is there, before its bake"
  done
done
grep -q 'warning: bound not met' <(log) || fail "no bound was missed"
[[ -e $out/bakes/missed/moving/baked.usda ]] || fail "a missed bound has cancelled what follows"

rm "$out/bakes/broken/moving/bake.h5"
"$thew" farm "$out/jobs.toml" --slurm "$out/jobs" --submit | tee "$out/again.txt"
grep -q '^9 bakes, of which 7 are complete; 9 tasks' "$out/again.txt" || fail "not the two alone"
finish
"$thew" farm "$out/jobs.toml" --dry-run | grep '^9 bakes, of which 9 are complete; 1 tasks' ||
  fail "something is not complete"
if "$thew" report --help | grep -q -- --against; then
  [[ -s $out/bakes/report.html ]] || fail "there is no page over all bakes"
fi
stop_cluster
trap - EXIT

# alone "BAKE..." FRAMES SET...: what these bakes of the show are when one process makes them
alone() {
  local bakes=$1 frames=$2 sets=() bake file
  shift 2
  for one; do sets+=(--set "$one"); done
  rm -rf "$out/alone"
  "$thew" bake "$out/scene/scene.toml" --out "$out/alone" --frames "$frames" "${sets[@]}" \
    --progress none 2>/dev/null
  for bake in $bakes; do
    for file in bake.h5 $(cd "$out/alone" && ls frames/*.png); do
      cmp "$out/alone/$file" "$out/bakes/$bake/$file" || fail "$bake/$file is not that of one process"
    done
  done
}
alone calm/moving 1-12
alone calm/posed 1-12 solver.integrator=quasi_static "scene.name=it's posed"
alone missed/moving 1-16
alone broken/moving 1-4
alone long/moving 1-96x6 solver.substeps=$long scene.frames=1-96
alone "told/moving requeued/moving killed/moving down/moving" 1-16x8 solver.substeps=$slow

[[ -z $(processes) ]] || fail "processes are left: $(processes)"
[[ -z $(outside) ]] || fail "files are left: $(outside)"
echo "$tasks tasks, the longest interrupted $rounds times; $SECONDS s"
