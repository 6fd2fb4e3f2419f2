#!/usr/bin/env python3
"""The law granusolve in NumPy, all samples at once: what its piles cost without granuscope.

    python3 examples/python/numpy_piles.py [--mu 0.1 0.3] [--samples 512] [--columns 40] [--layers 200] [--json FILE]

Every step works on the arrays of all samples, or of those in which a bead fails; loops go over layers, beads and
backtracks alone. Unlike granuscope's, all samples share the order in which their layers are solved. Piles carry the
load of the paper, 1 on every top bead and 2 on the middle one. Printed are processor seconds a pile, which grow as its
columns, and the means by which the law is held against granuscope's (`granuscope sample --load point --statistics`): the
thrust ratio and the variance of the weights w in layers 58 to 179.
`make -f Makefile.docs bench` runs it for the figure of docs/performance.md. It is for mu up to 0.5 or so: beyond, arcs
close into rings, which it does not have.
"""
import argparse
import json
import time

import numpy as np

SQRT3 = 3**0.5
WINDOW = 32  # layers held; deeper backtracks end the program
ROUNDING = 1e-14  # of the forces summed


def cut(a, b):
    """The intersection of two intervals (low, high)."""
    return np.maximum(a[0], b[0]), np.minimum(a[1], b[1])


def between(interval, u):
    return np.minimum(interval[0] + u * (np.maximum(interval[1], interval[0]) - interval[0]), interval[1])


def draw_pair(a, b, d, u, v):
    """a and b uniform on their intervals, given that a - b lies in d: the cut trapezoid, inverted."""
    low, high = cut(d, (a[0] - b[1], a[1] - b[0]))
    corners = a[0] - b[0], a[1] - b[1]
    knot1, knot2 = (np.minimum(np.maximum(f(*corners), low), high) for f in (np.minimum, np.maximum))
    plateau = np.minimum(a[1] - a[0], b[1] - b[0])
    y0, y1, y2, y3 = (np.minimum(np.minimum(plateau, x - (a[0] - b[1])), a[1] - b[0] - x) for x in (low, knot1, knot2, high))
    area1, area2, area3 = (knot1 - low) * (y0 + y1) / 2, (knot2 - knot1) * (y1 + y2) / 2, (high - knot2) * (y2 + y3) / 2
    grown = u * (area1 + area2 + area3)
    rising, flat = grown < area1, grown < area1 + area2
    grown -= np.where(rising, 0, np.where(flat, area1, area1 + area2))
    y = np.where(rising, y0, np.where(flat, y1, y2))
    root = np.sqrt(np.maximum(0, y * y + np.where(rising, 2, -2) * grown))
    below = y + np.where(flat & ~rising, y, root)
    difference = np.where(rising, low, np.where(flat, knot1, knot2)) + 2 * grown / np.where(below > 0, below, 1)
    first = between(cut(a, (difference + b[0], difference + b[1])), v)
    return first, first - difference


class Piles:
    def __init__(self, mu, columns, layers, samples, seed):
        cone, angle = np.pi / 6, np.arctan(mu)
        self.minus, self.plus = np.tan(cone - angle), np.tan(cone + angle)
        self.k = SQRT3 * (self.minus + self.plus) - 1
        self.columns, self.layers, self.samples = columns, layers, samples
        self.random = np.random.default_rng(seed)
        self.V_R, self.V_L, self.H, self.H_R = (np.zeros((WINDOW, columns, samples)) for _ in range(4))
        self.waiting = np.zeros((WINDOW, columns, samples), bool)  # beads that a backtrack has unsolved
        self.backtracks = np.zeros((WINDOW, columns, samples), np.uint8)  # that set out from a bead
        self.all = np.arange(samples)
        self.order = []  # of each layer: first bead and direction
        self.topmost = layers
        self.counts = dict.fromkeys(("first", "pairs", "arcs", "backtracks"), 0)
        self.load = np.ones(columns)
        self.load[columns // 2] = 2
        self.thrust, self.variance = [], []

    def pair_of(self, n, i):
        """The two beads above one of layer n, or the two below it: left and right."""
        return ((i - 1) % self.columns, i) if n % 2 == 0 else (i, (i + 1) % self.columns)

    def solved(self, n, i, s):
        if n == self.front:
            first, direction = self.order[n]
            if (i - first) * direction % self.columns >= self.cursor:
                return np.zeros(len(s), bool)
        return ~self.waiting[n % WINDOW, i, s]

    def solvable(self, V_UL, V_UR):
        minus, plus = self.minus / self.k, self.plus / self.k
        return (np.maximum(-V_UR / SQRT3, minus * V_UL - plus * V_UR), np.minimum(V_UL / SQRT3, plus * V_UL - minus * V_UR))

    def split(self, V_R, V_L, H):
        return (np.maximum(self.minus * V_R, self.minus * V_L + H), np.minimum(self.plus * V_R, self.plus * V_L + H))

    def interval(self, n, i, s):
        at = n % WINDOW, i, s
        return self.split(self.V_R[at], self.V_L[at], self.H[at])

    def band(self, n, i, s):
        """Where H_R(A) - H_R(B) of the parents must lie for the bead to have a solution."""
        A, B = self.pair_of(n, i)
        up = (n - 1) % WINDOW
        low, high = self.solvable(self.V_R[up, A, s], self.V_L[up, B, s])
        H = self.H[up, B, s]
        return low - H, high - H

    def draw(self, n, i, s):
        """In which of the samples the bead has a solution, which it then takes."""
        if n == 0:
            V_UL = V_UR = np.full(len(s), self.load[i] / 2)
            H = np.zeros(len(s))
        else:
            A, B = self.pair_of(n, i)
            up = (n - 1) % WINDOW
            V_UL, V_UR = self.V_R[up, A, s], self.V_L[up, B, s]
            H = self.H_R[up, A, s] + (self.H[up, B, s] - self.H_R[up, B, s])
        low, high = self.solvable(V_UL, V_UR)
        inside = np.minimum(np.maximum(H, low), high)
        good = np.abs(H - inside) <= ROUNDING * (V_UL + V_UR + np.abs(H))
        if not good.all():
            s, V_UL, V_UR, inside = s[good], V_UL[good], V_UR[good], inside[good]
        V_R, V_L = V_UR + SQRT3 * inside, V_UL - SQRT3 * inside
        # At the front nobody has seen what came of the bead's first number.
        u = self.first[i, s] if n == self.front else self.random.random(len(s))
        at = n % WINDOW, i, s
        self.V_R[at], self.V_L[at], self.H[at] = V_R, V_L, inside
        self.H_R[at] = between(self.split(V_R, V_L, inside), u)
        self.waiting[at] = False
        return good

    def unsolve(self, n, first, count, s):
        """Some beads and all that hangs below them."""
        self.topmost = min(self.topmost, n)
        while n <= self.front:
            beads = (first + np.arange(min(count, self.columns))) % self.columns
            if n == self.front:
                start, direction = self.order[n]
                beads = beads[(beads - start) * direction % self.columns < self.cursor]
            self.waiting[n % WINDOW, beads[:, None], s] = True
            n, first, count = n + 1, self.pair_of(n, first)[0], count + 1

    def renew(self, n, i, s):
        s = s[self.solved(n, i, s)]
        if not len(s):
            return
        good = self.draw(n, i, s)
        if not good.all():
            self.unsolve(n, i, 1, s[~good])
        if n < self.front:
            self.unsolve(n + 1, self.pair_of(n, i)[0], 2, s[good])

    def pair(self, n, i, s):
        """The parents of the bead draw again together; in which of the samples that helped."""
        A, B = self.pair_of(n, i)
        up = (n - 1) % WINDOW
        left, right = (i - 1) % self.columns, (i + 1) % self.columns
        a, b = self.interval(n - 1, A, s), self.interval(n - 1, B, s)
        held, band = self.H_R[up, self.pair_of(n, left)[0], s], self.band(n, left, s)
        solved = self.solved(n, left, s)
        a = cut(a, (np.where(solved, held - band[1], -np.inf), np.where(solved, held - band[0], np.inf)))
        held, band = self.H_R[up, self.pair_of(n, right)[1], s], self.band(n, right, s)
        solved = self.solved(n, right, s)
        b = cut(b, (np.where(solved, held + band[0], -np.inf), np.where(solved, held + band[1], np.inf)))
        d = self.band(n, i, s)
        good = (a[0] <= a[1]) & (b[0] <= b[1]) & (np.maximum(d[0], a[0] - b[1]) <= np.minimum(d[1], a[1] - b[0]))
        a, b, d = ((x[0][good], x[1][good]) for x in (a, b, d))
        s = s[good]
        self.H_R[up, A, s], self.H_R[up, B, s] = draw_pair(a, b, d, *self.random.random((2, len(s))))
        self.counts["pairs"] += len(s)
        self.renew(n, left, s)
        self.renew(n, right, s)
        return good

    def arc(self, n, i, s, parents):
        """The same for several parents; in which samples that helped, and in which more parents may."""
        step = self.order[n][1]
        near = self.pair_of(n, i)[0 if step > 0 else 1]

        def parent(k):
            return (near + step * (k + 1 - parents // 2)) % self.columns

        def child_after(k):
            return self.pair_of(n - 1, parent(k))[1 if step > 0 else 0]

        def step_band(k):
            child = child_after(k)
            low, high = self.band(n, child, s)
            free = ~self.solved(n, child, s) & (child != i)
            low, high = np.where(free, -np.inf, low), np.where(free, np.inf, high)
            return (low, high) if step > 0 else (-high, -low)

        up = (n - 1) % WINDOW
        own = [self.interval(n - 1, parent(k), s) for k in range(parents)]
        bands = [step_band(k) for k in range(-1, parents)]  # bands[k + 1]: from parent k to the next

        def filtered(first):
            passed, nonempty = [], np.ones(len(s), bool)
            for k in range(parents):
                last = first if k == 0 else passed[-1]
                passed.append(cut(own[k], (last[0] - bands[k][1], last[1] - bands[k][0])) if last else own[k])
                nonempty &= passed[-1][0] <= passed[-1][1]
            return passed, nonempty

        feasible = filtered(None)[1]
        held = self.H_R[up, parent(-1), s]
        passed, good = filtered((held, held))
        held = self.H_R[up, parent(parents), s]
        passed[-1] = cut(passed[-1], (held + bands[-1][0], held + bands[-1][1]))
        good &= passed[-1][0] <= passed[-1][1]
        these, u = s[good], self.random.random((parents, np.count_nonzero(good)))
        drawn = None
        for k in reversed(range(parents)):
            interval = passed[k][0][good], passed[k][1][good]
            if drawn is not None:
                interval = cut(interval, (drawn + bands[k + 1][0][good], drawn + bands[k + 1][1][good]))
            drawn = between(interval, u[k])
            self.H_R[up, parent(k), these] = drawn
        self.counts["arcs"] += len(these)
        for k in range(-1, parents):
            if child_after(k) != i:
                self.renew(n, child_after(k), these)
        return good, feasible & ~good

    def repair(self, n, i, s):
        """The samples in which no change of parents helps; in the others the bead has been solved."""
        if n == 0 or not len(s):
            return s
        good = self.pair(n, i, s)
        self.draw(n, i, s[good])
        left, hopeless, parents = s[~good], [], 4
        while len(left):
            if parents >= self.columns:
                raise RuntimeError("an arc would close into a ring")
            good, more = self.arc(n, i, left, parents)
            self.draw(n, i, left[good])
            hopeless.append(left[~good & ~more])
            left, parents = left[more], 2 * parents
        return np.concatenate(hopeless) if hopeless else left

    def backtrack(self, n, i, s):
        """Unsolves the ancestors 2 layers up, one more with each further backtrack of a bead, and all below them."""
        tries = self.backtracks[n % WINDOW, i, s]
        self.backtracks[n % WINDOW, i, s] += 1
        self.counts["backtracks"] += len(s)
        for tried in np.unique(tries):
            top = max(0, n - 2 - tried)
            if self.front - top > WINDOW - 4:
                raise RuntimeError("a backtrack would leave the layers that are held")
            first, sideways = i, 2 + tried - (n - top)
            for layer in range(n, top, -1):
                first = self.pair_of(layer, first)[0]
            self.unsolve(top, first - sideways, n - top + 1 + 2 * sideways, s[tries == tried])

    def solve_waiting(self, s):
        """Solves again what backtracks have unsolved in these samples, topmost layer first."""
        layer = max(0, self.front + 1 - WINDOW)
        while layer <= self.front:
            first, direction = self.order[layer]
            beads = np.flatnonzero(self.waiting[layer % WINDOW][:, s].any(axis=1))
            self.topmost, stopped = layer + 1, np.zeros(self.samples, bool)
            for i in beads[np.argsort((beads - first) * direction % self.columns)]:
                these = s[self.waiting[layer % WINDOW, i, s] & ~stopped[s]]
                if not len(these):
                    continue
                hopeless = self.repair(layer, i, these[~self.draw(layer, i, these)])
                self.backtrack(layer, i, hopeless)
                stopped[hopeless] = True
            layer = min(self.topmost, layer + 1)

    def run(self):
        for n in range(self.layers):
            direction = 1 if self.random.random() < 0.5 else -1
            start = int(self.random.integers(self.columns))
            self.order.append((start, direction))
            self.front = n
            self.first = self.random.random((self.columns, self.samples))
            self.waiting[n % WINDOW], self.backtracks[n % WINDOW] = False, 0
            for self.cursor in range(self.columns):
                i = (start + direction * self.cursor) % self.columns
                failing = self.all[~self.draw(n, i, self.all)]
                self.counts["first"] += self.samples
                while len(failing):
                    hopeless = self.repair(n, i, failing)
                    if not len(hopeless):
                        break
                    self.backtrack(n, i, hopeless)
                    self.solve_waiting(hopeless)
                    failing = hopeless[~self.draw(n, i, hopeless)]
            self.cursor = self.columns
            if n >= WINDOW - 1:
                self.measure(n - WINDOW + 1)
        for n in range(max(0, self.layers - WINDOW + 1), self.layers):
            self.measure(n)

    def measure(self, n):
        """Of a layer that stays as it is."""
        V_R, V_L, H, H_R = (x[n % WINDOW] for x in (self.V_R, self.V_L, self.H, self.H_R))
        w = V_R + V_L
        self.thrust.append(SQRT3 * (2 * H_R - H).sum(axis=0) / w.sum(axis=0))
        self.variance.append(w.var(axis=0))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--mu", type=float, nargs="+", default=[0.1, 0.15, 0.2, 0.3, 0.4])
    parser.add_argument("--samples", type=int, default=512)
    parser.add_argument("--columns", type=int, default=40)
    parser.add_argument("--layers", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json")
    options = parser.parse_args()
    cases = []
    for mu in options.mu:
        start = time.process_time()
        piles = Piles(mu, options.columns, options.layers, options.samples, options.seed)
        piles.run()
        case = {"mu": mu, "samples": options.samples, "columns": options.columns, "layers": options.layers,
                "seconds": (time.process_time() - start) / options.samples}
        beads = options.samples * options.columns * options.layers
        for name in ("pairs", "arcs", "backtracks"):
            case[f"{name}_per_bead"] = piles.counts[name] / beads
        for name, values in (("thrust", piles.thrust), ("variance", piles.variance)):
            means = np.mean(values[58:180], axis=0)
            case[name], case[f"stderr_{name}"] = means.mean(), means.std(ddof=1) / len(means)**0.5
        cases.append(case)
        print(", ".join(f"{name} = {value:.6g}" for name, value in case.items()), flush=True)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as out:
            json.dump({"numpy": np.__version__, "cases": cases}, out, indent=1)
            out.write("\n")


if __name__ == "__main__":
    main()
