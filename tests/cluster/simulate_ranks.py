#!/usr/bin/env python3
"""Simulates, event by event, a run of many ranks that no machine here has: 3 x 10^6 piles of 2000 x 2000 beads.

Measured on one core (see examples/cluster/README.md): what a pile takes, how large a block is, what a block costs the
rank that joins them. Assumed: speeds of machines, network and file system, which are options.

    tests/cluster/simulate_ranks.py [--blocks 1000] [--ranks 10 100 1000 10000] ...
"""
import argparse
import heapq
import random

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--ranks", type=int, nargs="+", default=[10, 100, 1000, 10000])
parser.add_argument("--ensembles", type=int, default=3)
parser.add_argument("--piles", type=float, default=1e6, help="of each ensemble")
parser.add_argument("--blocks", type=int, default=1000, help="of each ensemble (response.blocks)")
parser.add_argument("--pile-seconds", type=float, default=0.09, help="measured")
parser.add_argument("--block-bytes", type=float, default=10e6, help="measured, of 561 layers and 2000 columns")
parser.add_argument("--join-seconds", type=float, default=0.003, help="measured: to look into the file of one block")
parser.add_argument("--join-rate", type=float, default=0.3e9, help="measured: bytes/s read, checked and written")
parser.add_argument("--put-seconds", type=float, default=0.03, help="measured: to put a block at its place")
parser.add_argument("--note-bytes", type=float, default=190, help="measured: of what rank 0 is told of a block")
parser.add_argument("--finish-seconds", type=float, default=20e-6, help="measured: rank 0, each block at its place")
parser.add_argument("--slow", type=float, default=0.02, help="share of ranks on machines at 0.7 of the speed")
parser.add_argument("--scatter", type=float, default=0.03, help="scatter of the speed of the others")
parser.add_argument("--network", type=float, default=1.2e9, help="bytes/s into one machine")
parser.add_argument("--client", type=float, default=1.0e9, help="bytes/s from one machine to the file system")
parser.add_argument("--storage", type=float, default=20e9, help="bytes/s of the file system in all")
parser.add_argument("--files", type=float, default=10e3, help="files/s that it makes")
parser.add_argument("--counter", type=float, default=0.5e-3, help="s that a rank waits for the shared counter")


class Queue:
    """One server that takes one thing after another: a network card, a file system."""

    def __init__(self):
        self.free = 0.0

    def serve(self, now, seconds):
        self.free = max(self.free, now) + seconds
        return self.free


def simulate(a, ranks, way):
    """Seconds until the last block is where it is to be, and until the ensembles are joined."""
    rng = random.Random(1)
    speed = [0.7 if rng.random() < a.slow else max(0.5, rng.gauss(1, a.scatter)) for _ in range(ranks)]
    atoms = a.ensembles * a.blocks
    work = a.piles / a.blocks * a.pile_seconds
    into_rank_0, metadata, storage = Queue(), Queue(), Queue()
    leaders = [Queue() for _ in range(max(1, round(ranks**0.5)))]
    events = [(a.counter, rank, "asks") for rank in range(ranks)]  # when, who, does what
    heapq.heapify(events)
    end, taken = 0.0, 0
    while events:
        now, rank, does = heapq.heappop(events)
        if does == "asks":
            if taken < atoms:
                taken += 1
                heapq.heappush(events, (now + work / speed[rank], rank, "writes"))
            continue
        if way in ("files", "places"):
            if does == "writes":
                now = metadata.serve(now, 1 / a.files)
            now = max(now + a.block_bytes / a.client, storage.serve(now, a.block_bytes / a.storage))
            if way == "places" and does == "writes":  # once more, into the file of all
                heapq.heappush(events, (now + a.put_seconds, rank, "puts"))
                continue
        elif way == "one level":
            now = into_rank_0.serve(now, a.block_bytes / a.network)
        else:  # the rank goes on once its leader has the block, which hands it to rank 0
            now = leaders[rank % len(leaders)].serve(now, a.block_bytes / a.network)
            end = max(end, into_rank_0.serve(now, a.block_bytes / a.network))
        end = max(end, now)
        heapq.heappush(events, (now + a.counter, rank, "asks"))
    # Rank 0 reads each block and writes it into its ensemble; gathered blocks only need the latter, and of those at
    # their places only notes. Files of single blocks are removed after that, as fast as the file system allows.
    per_block = a.block_bytes / a.client
    if way == "files":
        per_block = a.join_seconds + a.block_bytes / a.join_rate + 1 / a.files
    if way == "places":
        per_block = a.note_bytes / a.network + a.finish_seconds + 1 / a.files
    return end, end + atoms * per_block, sum(speed)


def main():
    a = parser.parse_args()
    total = a.ensembles * a.piles * a.pile_seconds
    print(f"work: {total / 3600:.0f} h of one core; {a.ensembles * a.blocks} blocks of {a.block_bytes / 1e6:.0f} MB")
    print(f"{'ranks':>6} {'way':>11} {'drawing s':>10} {'efficiency':>10} {'joined s':>9} {'efficiency':>10}")
    for ranks in a.ranks:
        for way in ["one level", "two levels", "files", "places"]:
            drawn, joined, speed = simulate(a, ranks, way)
            ideal = total / speed
            print(f"{ranks:6} {way:>11} {drawn:10.0f} {ideal / drawn:10.1%} {joined:9.0f} {ideal / joined:10.1%}")


main()
