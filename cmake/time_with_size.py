"""Processor time and memory of ensembles against their size: of `granuscope run FILE --shard 1/1 -j 1`, which draws,
checks and sums up piles and stops before the report, and of examples/python/numpy_piles.py. Each is run three times,
or once if it takes long, and the shortest counts.

    python3 cmake/time_with_size.py build/release/granuscope --json out/bench/size.json        # three minutes
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile

NUMPY = os.path.join(os.path.dirname(__file__), "../examples/python/numpy_piles.py")
REPETITIONS, LONG_SECONDS = 3, 2  # what takes long is run once
FRICTION = 0.1, 0.3
PILES = 64, 256, 1024, 4096, 8192  # of 500 x 200 beads
SIDES = 64, 125, 250, 500, 1000, 2000, 4000  # of square piles, at least 64, which are the fewest of a run, and
BEADS = 1.28e8  # so many beads
NUMPY_PILES = 8, 64, 512  # of 40 x 200 beads, at the first friction


def run(command, folder):
    """Processor seconds and bytes of a process, without what it prints."""
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(command)} ended with status {status}")
    return used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss


def shortest(command, folder):
    best = run(command, folder)
    for _ in range(1, REPETITIONS if best[0] < LONG_SECONDS else 1):
        best = min(best, run(command, folder))
    return best


def experiment(mu, columns, layers, piles):
    return (f"[lattice]\ncolumns = {columns}\nlayers = {layers}\n[friction]\nmu = {mu}\n"
            f"[response]\nsamples = {piles}\nblocks = {min(32, piles // 8)}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("granuscope")
    parser.add_argument("--json", required=True)
    options = parser.parse_args()
    program, cases = os.path.abspath(options.granuscope), []
    sizes = [(500, 200, piles) for piles in PILES]
    sizes += [(side, side, max(64, round(BEADS / side**2 / 8) * 8)) for side in SIDES]
    with tempfile.TemporaryDirectory() as folder:

        def add(name, mu, columns, layers, piles, command):
            seconds, peak = shortest(command, folder)
            cases.append({"program": name, "mu": mu, "columns": columns, "layers": layers, "piles": piles,
                          "seconds": seconds, "peak_bytes": peak})
            print(", ".join(f"{key} = {value}" for key, value in cases[-1].items()), flush=True)

        for mu in FRICTION:
            for columns, layers, piles in sizes:
                with open(os.path.join(folder, "size.toml"), "w", encoding="ascii") as out:
                    out.write(experiment(mu, columns, layers, piles))
                add("granuscope", mu, columns, layers, piles,
                    ["sh", "-c", 'rm -rf out && exec "$0" run size.toml --out out --shard 1/1 -j 1', program])
            for piles in NUMPY_PILES if mu == FRICTION[0] else ():
                add("NumPy", mu, 40, 200, piles,
                    [sys.executable, os.path.abspath(NUMPY), "--mu", str(mu), "--samples", str(piles)])
    with open(options.json, "w", encoding="utf-8") as out:
        json.dump({"cases": cases}, out, indent=1)
        out.write("\n")


if __name__ == "__main__":
    main()
