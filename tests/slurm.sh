#!/usr/bin/env bash
# A SLURM of one machine, from nothing to a finished sweep and back: installs it (Debian, as root),
# starts it in a mount namespace of its own, and runs the smoke sweep through profiles/slurm, with replicates until
# the drag is known within 20 %. Kills a job,
# then Snakemake, goes on, and compares the result bit by bit with that of a local run.
#
#     bash tests/slurm.sh [folder for logs]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

if [ -z "${IN_NAMESPACE:-}" ]; then
    command -v slurmctld >/dev/null || { apt-get update -q && apt-get install -qy slurm-wlm munge; }
    python -c "import snakemake_executor_plugin_slurm" 2>/dev/null ||
        { echo "The plugin is missing: pip install snakemake-executor-plugin-slurm" >&2; exit 2; }
    exec env IN_NAMESPACE=1 unshare -m bash tests/slurm.sh "$@"
fi

LOGS=$(mkdir -p "${1:-results/slurm_logs}" && cd "${1:-results/slurm_logs}" && pwd)
HOME_OF=$(mktemp -d)
chmod 755 "$HOME_OF"

stop() {
    for name in slurmd slurmctld munged; do
        [ -f "$HOME_OF/$name.pid" ] && kill "$(cat "$HOME_OF/$name.pid")" 2>/dev/null || true
    done
    sleep 3  # the controller writes its state as it ends
    rm -rf "$HOME_OF" || true
}
trap stop EXIT

# munge: who is who
mkdir -p "$HOME_OF/munge"
dd if=/dev/urandom of="$HOME_OF/munge/key" bs=1024 count=1 status=none
chmod 400 "$HOME_OF/munge/key"
munged --force --key-file="$HOME_OF/munge/key" --socket="$HOME_OF/munge/socket" \
    --pid-file="$HOME_OF/munged.pid" --log-file="$LOGS/munged.log" --seed-file="$HOME_OF/munge/seed"

# slurm: one node with all cores
mkdir -p "$HOME_OF/state" "$HOME_OF/spool" "$HOME_OF/etc"
HOST=$(hostname -s)
cat >"$HOME_OF/etc/slurm.conf" <<CONF
ClusterName=alone
SlurmctldHost=$HOST(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$HOME_OF/munge/socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MinJobAge=300
StateSaveLocation=$HOME_OF/state
SlurmdSpoolDir=$HOME_OF/spool
SlurmctldPidFile=$HOME_OF/slurmctld.pid
SlurmdPidFile=$HOME_OF/slurmd.pid
NodeName=$HOST NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(free -m | awk "NR==2 {print \$2}") State=UNKNOWN
PartitionName=main Nodes=$HOST Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p /etc/slurm
mount --bind "$HOME_OF/etc" /etc/slurm
slurmctld -L "$LOGS/slurmctld.log"
slurmd -L "$LOGS/slurmd.log"
for _ in $(seq 60); do
    sinfo -h -o %T 2>/dev/null | grep -q idle && break
    sleep 0.5
done
sinfo
sinfo -h -o %T | grep -q idle || { echo "The node does not come up; see $LOGS/slurmd.log" >&2; exit 1; }

# the same sweep twice: through SLURM, with seeds that nobody has made yet, and all again here
FIRST=$((1000 * RANDOM))
for place in slurm local; do
    sed -e "s#results/smoke#results/${place}_smoke#" -e "s/^  seed: .*/  seed: {until: 20 %, first: $FIRST, least: 6, most: 24}\n\nbatch: 6\nfailures: 0.1/" \
        config/smoke.yaml >"$HOME_OF/$place.yaml"
    rm -rf "results/${place}_smoke"
done
export PYTHONPATH=$PWD
through_slurm() {
    exec python -m snakemake results/slurm_smoke/drag.nc --workflow-profile profiles/slurm \
        --configfile "$HOME_OF/slurm.yaml" --slurm-status-command squeue --slurm-logdir "$LOGS/jobs" \
        --slurm-init-seconds-before-status-checks 2 --seconds-between-status-checks 2 --latency-wait 20 \
        --slurm-keep-successful-logs
}
# Batch jobs that run, by their number in SLURM; another one than the first argument.
running() { squeue -h -r -t RUNNING -o "%A %k" | awk -v other="${1:-}" '/rule_batch/ && $1 != other {print $1; exit}'; }
until_running() {
    local found
    for _ in $(seq 600); do
        found=$(running "${1:-}")
        [ -n "$found" ] && { echo "$found"; return; }
        kill -0 "$WORKFLOW" 2>/dev/null || break
        sleep 0.2
    done
    echo "No job of a batch runs; see $LOGS/snakemake.log" >&2
    return 1
}

# a job is killed, and sent again; while another runs, Snakemake itself is killed. Some seeds make no bed.
(through_slurm) >"$LOGS/snakemake.log" 2>&1 &
WORKFLOW=$!
JOB=$(until_running)
scancel --signal=KILL --full "$JOB"
for _ in $(seq 120); do
    grep -q "Trying to restart job" "$LOGS/snakemake.log" && break
    sleep 1
done
grep "Trying to restart job" "$LOGS/snakemake.log" || { echo "The killed job is not sent again" >&2; exit 1; }
OTHER=$(until_running "$JOB")
kill -KILL "$WORKFLOW"
wait "$WORKFLOW" || true
echo "Killed job $JOB, and Snakemake while job $OTHER ran; jobs that go on:"
squeue -r
[ ! -e results/slurm_smoke/drag.nc ]

# the same command goes on
(through_slurm) 2>&1 | tee "$LOGS/again.log"
python -m snakemake results/local_smoke/drag.nc -j2 -R batch --configfile "$HOME_OF/local.yaml" -q all
python - <<'PY'
import sys

import numpy as np
import xarray as xr

one, two = (xr.open_dataset(f"results/{place}_smoke/drag.nc") for place in ("slurm", "local"))
different = [name for name in two.variables if name not in ("run_time", "spent")
             and not one[name].identical(two[name])]
print(f"{int(two.replicates.sum())} runs;",
      f"different: {', '.join(different)}" if different else "SLURM and local: same bits")
sys.exit(bool(different))
PY
