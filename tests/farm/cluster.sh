#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A Slurm cluster of this machine alone, to be sourced: start_cluster FOLDER, stop_cluster. Its
# daemons, key, sockets, state and logs are in FOLDER/cluster and nowhere else, on ports of its own.

# free_ports N: so many, one a line, that nobody listens on
free_ports() {
  /usr/bin/python3 - "$1" <<'END'
import socket, sys
held = [socket.socket() for _ in range(int(sys.argv[1]))]
for one in held:
    one.bind(("127.0.0.1", 0))
    print(one.getsockname()[1])
END
}

# daemon NAME COMMAND...: starts it and keeps its process id in cluster/NAME.id
daemon() {
  local name=$1
  shift
  "$@" </dev/null >>"$cluster/$name.out" 2>&1 &
  echo $! >"$cluster/$name.id"
}

start_cluster() {
  cluster=$1/cluster
  mkdir -p "$cluster"/{state,spool}
  chmod 700 "$cluster"
  local ports me host
  ports=($(free_ports 2)) me=$(id -un) host=$(hostname -s)
  (umask 077 && head -c 1024 /dev/urandom >"$cluster/munge.key")
  cat >"$cluster/slurm.conf" <<END
ClusterName=thew
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$me
SlurmdUser=$me
AuthType=auth/munge
AuthInfo=socket=$cluster/munge.socket
CredType=cred/munge
SlurmctldPort=${ports[0]}
SlurmdPort=${ports[1]}
StateSaveLocation=$cluster/state
SlurmdSpoolDir=$cluster/spool
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmdPidFile=$cluster/slurmd.pid
SlurmctldLogFile=$cluster/slurmctld.log
SlurmdLogFile=$cluster/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
MailProg=/bin/true
ReturnToService=2
RequeueExit=75
SlurmdParameters=config_overrides
SchedulerParameters=defer_batch,sched_interval=2,bf_interval=2
KillWait=5
MinJobAge=3600
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=8192
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
  export SLURM_CONF=$cluster/slurm.conf
  daemon munged /usr/sbin/munged --foreground --force --num-threads=2 --socket="$cluster/munge.socket" \
    --key-file="$cluster/munge.key" --pid-file="$cluster/munged.pid" \
    --log-file="$cluster/munged.log" --seed-file="$cluster/munge.seed"
  for ((i = 0; i < 50; ++i)); do [[ -S $cluster/munge.socket ]] && break || sleep 0.1; done
  daemon slurmctld /usr/sbin/slurmctld -D -i
  daemon slurmd /usr/sbin/slurmd -D -N "$host"
  for ((i = 0; i < 100; ++i)); do
    [[ $(sinfo -h -o %T 2>/dev/null) == idle ]] && return
    sleep 0.2
  done
  echo "the cluster did not come up; see $cluster" >&2
  return 1
}

# Ends the daemons by their process ids, the last started first.
stop_cluster() {
  local name id
  for name in slurmd slurmctld munged; do
    [[ -e $cluster/$name.id ]] || continue
    id=$(<"$cluster/$name.id")
    kill "$id" 2>/dev/null || true
    wait "$id" 2>/dev/null || true
    rm -f "$cluster/$name.id"
  done
}
