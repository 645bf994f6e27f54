#!/bin/bash
# Sweeps on Slurm: a real cluster of one node, started here: an array of 50 points, tasks cancelled
# in the middle, tables equal to those of the local engine.
set -u
cd "$(dirname "$0")/../.." || exit 2
case ${BUILD:-build} in /*) ;; *) BUILD=$PWD/${BUILD:-build} ;; esac
export BUILD
sweep=$PWD/scripts/sweep scene=$PWD/geometries/simoloyer-2l.cfg
work=$(mktemp -d) || exit 2
chmod 755 "$work"
PATH=$PATH:/usr/sbin:/sbin
number=0 failed=0 running=

finish() {
  [ -z "$running" ] || scancel -u "$(id -un)" 2>/dev/null
  sleep 1
  for name in slurmd slurmctld munged; do
    [ -s "$work/$name.pid" ] && kill "$(cat "$work/$name.pid")" 2>/dev/null
  done
  sleep 1
  rm -rf "$work"
}
trap finish EXIT
skip() {
  echo "ok 1 - skipped: $*"
  exit 0
}
report() { # verdict text
  number=$((number + 1))
  echo "$1 $number - $2"
  [ "$1" = ok ] || { failed=1; tail -n 20 "$work/err" | sed 's/^/# /'; }
}
check() { # TEXT COMMAND...
  local text=$1
  shift
  if "$@" >"$work/out" 2>"$work/err"; then report ok "$text"; else report "not ok" "$text"; fi
}
wait_for() { # SECONDS COMMAND...: until it succeeds
  local until=$((SECONDS + $1))
  shift
  until "$@" >/dev/null 2>&1; do
    [ $SECONDS -lt $until ] || return 1
    sleep 0.3
  done
}

# ---------------------------------------------------------------- the cluster
[ "$(id -u)" -eq 0 ] || skip "starting a Slurm of one's own takes root"
scripts/setup slurm >"$work/setup" 2>&1
for program in munged slurmctld slurmd sbatch; do
  command -v $program >/dev/null || skip "$program cannot be installed: $(tail -n 1 "$work/setup")"
done
mkdir "$work"/{state,spool}
host=$(hostname -s)
port=$((20000 + $$ % 20000))
cat >"$work/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,batch_sched_delay=0
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
MaxArraySize=101
MinJobAge=5
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$work/slurm.conf
head -c 1024 /dev/urandom >"$work/munge.key"
chmod 400 "$work/munge.key"
munged --force --socket="$work/munge.socket" --key-file="$work/munge.key" \
  --pid-file="$work/munged.pid" --log-file="$work/munged.log" --seed-file="$work/munge.seed" \
  >"$work/out" 2>&1 || skip "munged does not start: $(tail -n 1 "$work/out" "$work/munged.log")"
slurmctld >"$work/out" 2>&1 || skip "slurmctld does not start: $(tail -n 1 "$work/slurmctld.log")"
slurmd -N "$host" >"$work/out" 2>&1 || skip "slurmd does not start: $(tail -n 1 "$work/slurmd.log")"
wait_for 60 bash -c 'sinfo -h -o %T | grep -q idle' ||
  skip "the node does not come up: $(tail -n 1 "$work/slurmd.log")"
running=1
cd "$work" || exit 2

# ---------------------------------------------------------------- 50 points
points=("$scene" rotor.rpm=800:100:1700 balls.count=30:10:70 duration=0.05 -q)
check "50 points, locally" "$sweep" "${points[@]}" -o local
check "50 points, as an array" "$sweep" "${points[@]}" -o array --on slurm --chunk 5 --wait
check "in ten tasks" grep -q "TASK_ID \* 5" array/task.sh
check "all are done" test "$(ls array/runs/*.json 2>/dev/null | wc -l)" -eq 50
for table in table.csv mean.csv; do
  check "the same $table as locally" cmp "local/$table" "array/$table"
done

# ---------------------------------------------------------------- cancelled tasks
points=("$scene" rotor.rpm=800:200:2000 balls.count=800 duration=0.5 -q)
check "longer runs, locally" "$sweep" "${points[@]}" -o local-long
check "sent as an array" "$sweep" "${points[@]}" -o cancelled --on slurm
job=$(cat cancelled/job)
wait_for 60 bash -c 'ls cancelled/runs/*.h5'
sleep 0.5
check "some tasks are cancelled" scancel "${job}_0" "${job}_1" "${job}_5"
"$sweep" "${points[@]}" -o cancelled --on slurm >"$work/out" 2>"$work/err" && verdict="not ok" || verdict=ok
grep -q "still in the queue" "$work/err" || verdict="not ok"
report "$verdict" "not sent again while the array is in the queue"
wait_for 300 bash -c "[ -z \"\$(squeue -h)\" ]"
check "some runs are missing" test "$(ls cancelled/runs/*.json | wc -l)" -lt 7
check "the table by the chained job holds the others" bash -c "
  [ \$(grep -vc '^#' cancelled/table.csv) -eq \$((1 + \$(ls cancelled/runs/*.json | wc -l))) ]"
check "sent again, they go on" "$sweep" "${points[@]}" -o cancelled --on slurm --wait
check "with the same table" cmp local-long/table.csv cancelled/table.csv

# ---------------------------------------------------------------- failures
"$sweep" "$scene" balls.count=40,400000 duration=0.02 -o bad -q --on slurm --wait --retries 0 \
  >"$work/out" 2>"$work/err"
status=$?
report "$([ $status -eq 1 ] && grep -q '1 of 2 runs failed' err && echo ok || echo not ok)" \
  "a point that fails is told"
exit $failed
