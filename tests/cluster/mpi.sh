#!/bin/sh
# Any number of ranks gives the bytes of one process, also after one of them was killed at any moment.
# Arguments: the folder with the programs, the source folder, how many kills.
. "$2/tests/cluster/common.sh"
trap 'rm -rf "$scratch"' EXIT
command -v mpirun >/dev/null || skip "there is no mpirun; install openmpi-bin"
command -v granuscope-mpi >/dev/null || skip "granuscope-mpi was not built; install libopenmpi-dev"
export OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_hwloc_base_binding_policy=none
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
draw_undivided

for ranks in 1 2 3 4 7; do
  timeout 120 mpirun -n $ranks granuscope-mpi run "$experiment" --only sample --out "ranks-$ranks" 2>log || fail "$ranks ranks: $(cat log)"
  same "ranks-$ranks"
done
[ "$(grep -c 'drawing on' log)" -ge 2 ] || fail "no ensemble grew on all ranks: $(cat log)"
[ "$(grep -c 'drawing on' log)" -eq "$(grep -c 'drawing on 7 ranks' log)" ] || fail "more than rank 0 tells progress"

# A rank on a machine with other vector instructions.
least=$programs/tests/libleast_vectors.so
timeout 120 mpirun -n 1 env LD_PRELOAD="$least" granuscope-mpi run "$experiment" --only sample --out mixed : \
  -n 1 granuscope-mpi run "$experiment" --only sample --out mixed 2>log || fail "ranks of two instruction sets: $(cat log)"
same mixed
words=$(sed -n 's/^vectors of \(.*\) instead of \(.*\)/\1 \2/p' log)
[ "$(echo "$words" | wc -w)" -eq 2 ] || fail "no rank kept to the least vector instructions: $(cat log)"
[ "${words% *}" != "${words#* }" ] || echo "skipped: the machine has only the vector instructions ${words% *}"

# Input that is wrong ends all ranks with status 2 and one message.
timeout 120 mpirun -n 2 granuscope-mpi run nowhere.toml >log 2>&1
[ $? -eq 2 ] || fail "a missing experiment does not end with 2"
[ "$(grep -c 'nowhere.toml' log)" -eq 1 ] || fail "a missing experiment is not told once: $(cat log)"

# A rank that is killed ends the others with status 4 within ten seconds.
cat >rank.sh <<'END'
trap : TERM  # mpirun sends it to the shell, too
if [ "$OMPI_COMM_WORLD_RANK" = "$1" ]; then date +%s >begun; exec timeout -s KILL "$2" granuscope-mpi run "$3" --only sample --out "$4"; fi
granuscope-mpi run "$3" --only sample --out "$4"
echo $? >"status-$OMPI_COMM_WORLD_RANK"
date +%s >"ended-$OMPI_COMM_WORLD_RANK"
END
sed 's/samples = 1500/samples = 150000/; s/8000/150000/' "$experiment" >long.toml
# Open MPI waits so many seconds before it sends SIGTERM, and as many again before SIGKILL.
export OMPI_MCA_odls_base_sigkill_timeout=3
for victim in 0 2; do
  rm -f status-* ended-*
  timeout 120 mpirun -n 3 sh rank.sh $victim 3 long.toml "long-$victim" >log 2>&1
  for ended in ended-*; do  # begun, three seconds, and then ten; mpirun itself waits longer
    [ $(($(cat "$ended") - $(cat begun))) -le 14 ] || fail "$ended: not within ten seconds of killed rank $victim"
  done
  for status in status-*; do
    [ "$(cat "$status")" = 4 ] || fail "$status of killed rank $victim is $(cat "$status")"
  done
  [ "$(cat status-* | wc -l)" -ge 1 ] || fail "no other rank told how it ended"
done
unset OMPI_MCA_odls_base_sigkill_timeout

kill=0
while [ $kill -lt "$3" ]; do
  victim=$(awk "BEGIN { srand($kill); print int(3 * rand()) }")
  seconds=$(awk "BEGIN { srand($kill + 1000); print 0.4 + 0.8 * rand() }")
  timeout 120 mpirun -n 3 sh rank.sh "$victim" "$seconds" "$experiment" killed >log 2>&1
  kill=$((kill + 1))
done
timeout 120 mpirun -n 3 granuscope-mpi run "$experiment" --only sample --out killed 2>log || fail "after $3 kills: $(cat log)"
same killed

# More piles go on from those that are there.
sed '/precision/,/most_samples/d' "$experiment" >more.toml
sed 's/samples = 1500/samples = 800/' more.toml >fewer.toml
for which in fewer more; do
  timeout 120 mpirun -n 2 granuscope-mpi run $which.toml --only sample --out grown 2>log || fail "growing: $(cat log)"
done
granuscope run more.toml --only sample --out at-once 2>log || fail "at once: $(cat log)"
expected=$(digest at-once)
same grown
