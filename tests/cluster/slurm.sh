#!/bin/sh
# The jobs of examples/cluster under a real Slurm, whose daemons run on the loopback interface.
# Arguments: the folder with the programs, the source folder.
. "$2/tests/cluster/common.sh"
controller='' worker=''
end() {
  [ -z "$worker" ] || kill "$worker"
  [ -z "$controller" ] || kill "$controller"
  wait
  rm -rf "$scratch"
}
trap end EXIT
for program in slurmctld slurmd sbatch srun; do
  command -v $program >/dev/null || skip "there is no $program; install slurm-wlm"
done
[ "$(id -u)" -eq 0 ] || skip "slurmd needs root"
mkdir state spool
port=$((20000 + $$ % 10000))
cat >slurm.conf <<END
ClusterName=granuscope
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$scratch/state
SlurmdSpoolDir=$scratch/spool
SlurmctldPidFile=$scratch/slurmctld.pid
SlurmdPidFile=$scratch/slurmd.pid
SlurmctldLogFile=$scratch/slurmctld.log
SlurmdLogFile=$scratch/slurmd.log
SlurmdParameters=config_overrides
NodeName=localhost NodeAddr=127.0.0.1 CPUs=8 RealMemory=8000 State=UNKNOWN
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$scratch/slurm.conf
slurmctld -D >ctld.out 2>&1 &
controller=$!
slurmd -D -N localhost >slurmd.out 2>&1 &
worker=$!
tries=0
until sinfo -h -o %T 2>/dev/null | grep -q idle; do
  tries=$((tries + 1))
  [ $tries -lt 30 ] || fail "Slurm does not start: $(tail -3 slurmctld.log slurmd.log)"
  sleep 1
done

# Waits until no job is left.
finish() {
  tries=0
  while [ -n "$(squeue -h -o %i)" ]; do
    tries=$((tries + 1))
    [ $tries -lt 120 ] || fail "jobs do not end: $(squeue)"
    sleep 1
  done
}

sed '/precision/,/most_samples/d' "$experiment" >fixed.toml
granuscope run fixed.toml --only sample --out one 2>log || fail "the undivided run: $(cat log)"
expected=$(digest one)
sh "$source/examples/cluster/submit.sh" fixed.toml array 4 || fail "submit.sh"
finish
[ -e array/ensembles/mu-0.3.h5 ] || fail "nothing was merged: $(cat slurm-*.out)"
same array

timeout 120 srun --input=none -n 3 granuscope run fixed.toml --shard auto --out steps 2>log || fail "srun: $(cat log)"
granuscope merge steps 2>log || fail "merge: $(cat log)"
same steps

if command -v granuscope-mpi >/dev/null && srun --mpi=list 2>&1 | grep -q pmix; then
  draw_undivided
  sbatch --ntasks=3 "$source/examples/cluster/mpi.sbatch" "$experiment" mpi
  finish
  [ -e mpi/summary.json ] || fail "the MPI job: $(cat slurm-*.out)"
  same mpi
fi
