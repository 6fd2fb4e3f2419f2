# What the tests of several processes share. Arguments: the folder with the programs, the source folder.
set -u
programs=$1 source=$2
PATH=$programs:$PATH
export PATH
scratch=$(mktemp -d)
experiment=$scratch/experiment.toml
cp "$source/tests/cluster/experiment.toml" "$experiment"
cd "$scratch" || exit 1

skip() {
  echo "skipped: $1"
  exit 77
}

fail() {
  echo "FAILED: $1"
  exit 1
}

# One line for all ensembles in a folder.
digest() { (cd "$1/ensembles" && sha256sum -- *) | sha256sum; }

# Whether the ensembles of a folder are those of the undivided run.
same() {
  [ "$(digest "$1")" = "$expected" ] || fail "the ensembles in $1 are not those of one process"
  echo "same bytes: $1"
}

draw_undivided() {
  granuscope run "$experiment" --only sample --out one 2>one.log || fail "the undivided run: $(cat one.log)"
  expected=$(digest one)
}
