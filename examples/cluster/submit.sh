#!/bin/sh
# An experiment on a cluster with Slurm: an array of shards draws it, and a job that waits for all of them joins it.
#     examples/cluster/submit.sh EXPERIMENT FOLDER [SHARDS]
# Then `granuscope run EXPERIMENT --out FOLDER` goes on to the report; it also draws what a lost shard has left out.
set -eu
[ $# -ge 2 ] || { echo "usage: $0 EXPERIMENT FOLDER [SHARDS]" >&2; exit 2; }
here=$(dirname "$0")
array=$(sbatch --parsable --array="1-${3:-16}" "$here/shard.sbatch" "$1" "$2")
array=${array%%;*}  # JOB;CLUSTER where there are several clusters
sbatch --parsable --dependency="afterok:$array" "$here/merge.sbatch" "$2"
