#!/bin/sh
# Shards that are killed at any moment lose nothing, and give the bytes of one process.
# Arguments: the folder with the programs, the source folder, how many kills.
. "$2/tests/cluster/common.sh"
trap 'rm -rf "$scratch"' EXIT
sed -i '/precision/,/most_samples/d' "$experiment"
draw_undivided
kill=0
while [ $kill -lt "$3" ]; do
  shard=$(awk "BEGIN { srand($kill); print 1 + int(3 * rand()) }")
  seconds=$(awk "BEGIN { srand($kill + 1000); print 0.02 + 0.2 * rand() }")
  timeout -s KILL "$seconds" granuscope run "$experiment" --shard "$shard/3" --threads 2 --out killed 2>>log
  kill=$((kill + 1))
done
for shard in 3 1 2; do
  granuscope run "$experiment" --shard $shard/3 --out killed 2>>log || fail "shard $shard after $3 kills: $(cat log)"
done
cp -r killed merged
granuscope merge merged 2>>log || fail "merge: $(tail -1 log)"
same merged
granuscope run "$experiment" --only sample --out killed 2>>log || fail "the run that joins: $(tail -1 log)"
same killed
