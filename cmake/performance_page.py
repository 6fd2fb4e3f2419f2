"""Fills templates/docs/performance.md with the numbers that `granuscope bench SUITE --json FOLDER/SUITE.json` and
examples/python/numpy_piles.py measured: a line `@@name@@` becomes the table of that name. Writes the page to standard
output, and examples/figures/cost-for-equal-error.svg.

    python3 cmake/performance_page.py out/bench
"""
import json
import math
import pathlib
import subprocess
import sys
import textwrap

SUITES = ("sampler", "accuracy", "render", "numpy")
MADE_BY = {"numpy": "python3 examples/python/numpy_piles.py --json {file}"}
FIGURE = "examples/figures/cost-for-equal-error.svg"
# The paper: 1000 x 1000 beads take "few minutes" on its G4 of 400 MHz. Three are taken here.
PAPER_SECONDS_PER_BEAD, PAPER_PILES = 180e-6, 3461
BEADS = 500 * 200


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def digits(value, count=2):
    """`count` significant digits, without an exponent."""
    if value is None:
        return "–"
    rounded = float(f"{value:.{count}g}")
    return f"{rounded:.0f}" if abs(rounded) >= 10 ** (count - 1) else f"{rounded:.{count}g}"


def with_error(number):
    """0.00612(1): the error in units of the last digit, with one digit, or two if it begins with 1."""
    value, error = number.get("value"), number.get("stderr")
    if value is None or not error:
        return "–"
    leading = f"{error:.0e}"
    places = -int(leading[leading.index("e") + 1:]) + (1 if leading.startswith("1") else 0)
    return f"{value:.{places}f}({round(error * 10 ** places)})"


def paragraph(text):
    return textwrap.fill(text, 120, break_on_hyphens=False)


def waiting(suite):
    """By how much the cases took longer by the clock than on the processor: 1 where no other work ran."""
    times = [(c[wall], c[processor]) for c in suite.get("cases", [])
             for wall, processor in (("wall_ns_per_bead", "ns_per_bead"), ("wall_seconds", "seconds")) if wall in c]
    return sum(wall for wall, _ in times) / sum(processor for _, processor in times) if times else 1


def measured(suite):
    by = suite["measured"]
    changed = " with uncommitted changes" if by["changed"] else ""
    text = (f"Measured on {by['date']} by commit {by['commit'][:10]}{changed}, {by['compiler']}, on "
            f"{by['threads']} threads of {by['processor']}.")
    if waiting(suite) > 1.1:
        text += (" Other work ran on the same cores, which makes processor time longer, too: by the clock it took "
                 f"{waiting(suite):.1f} times as long.")
    return paragraph(text)


def targets(suite):
    """How many of its limits a suite kept, and which not."""
    missed = [f"{t['name']}: {digits(t['measured'], 3)}, {'at most' if 'at_most' in t else 'at least'} "
              f"{t.get('at_most', t.get('at_least')):g} is wanted" for t in suite["targets"] if not t["met"]]
    text = f"{len(suite['targets']) - len(missed)} of the suite's {len(suite['targets'])} limits were kept"
    if missed and waiting(suite) > 1.1:
        text += "; a run beside other work does not judge the rest"
    elif missed:
        text += ", these were not: " + "; ".join(missed)
    return paragraph(text + ".")


def sampler(suite):
    engines = ("scalar", "beads", "batch", "no-rejection")
    cases = {}
    for case in suite["cases"]:
        if case["threads"] == 1:
            place = (case["columns"], case["layers"], case["mu"])
            cases.setdefault(place, {})[case["engine"]] = case
    rows = []
    for (columns, layers, mu), by_engine in cases.items():
        times = [f"{by_engine[e]['ns_per_bead']:.1f}" if e in by_engine else "–" for e in engines]
        rows.append([f"{columns} × {layers}", f"{mu:g}", *times, f"{by_engine['batch']['draws_per_bead']:.3f}"])
    return table(["beads", "μ", *(f"`{e}`" for e in engines), "draws per bead"], rows)


def threads(suite):
    return table(["threads", "beads per second, times those of one", "arithmetic alone"],
                 [[str(s["threads"]), f"{s['batch']:.2f}", f"{s['arithmetic']:.2f}"] for s in suite["scaling"]])


def estimator(case):
    name = f"`{case['estimator']}`" + (", coupled" if case.get("coupled") else "")
    if "epsilon" in case:
        name += f", ε = {case['epsilon']:g}"
    if case.get("opposite"):
        name += ", opposite"
    if case.get("sign_run", 1) > 1:
        name += f", runs of {case['sign_run']}"
    return name


def accuracy(suite):
    rows = []
    for speedup in suite["speedup_by_options"]:
        same = [c for c in suite["cases"] if c["mu"] == speedup["mu"] and estimator(c) == estimator(speedup)
                and c["columns"] * c["layers"] >= BEADS]
        rows.append([f"{speedup['mu']:g}", estimator(speedup), digits(speedup["D"]), digits(speedup["c_peaks"]),
                     digits(speedup["c_thrust"]), with_error(same[0]["D"]) if same else "–"])
    return table(["μ", "estimator", "D", "c", "c_thrust", "D itself"], rows)


def point(suite):
    rows = [[f"{c['mu']:g}", with_error(c["c"]), with_error(c["D"]), f"{c['samples']:.0f}", digits(c["seconds"]),
             digits(c["stderr_c"]), digits(c["stderr_D"])]
            for c in suite["cases"] if estimator(c) == "`point`" and c["columns"] * c["layers"] >= BEADS]
    return table(["μ", "c", "D", "piles", "seconds", "error of c", "error of D"], rows)


def to_one_percent(case):
    """Processor seconds for 1 % of c0 - c and of D, as the case itself measures them."""
    c, D = (case[name]["value"] for name in "cD")
    return [case["seconds"] * (error / (0.01 * value))**2
            for error, value in ((case["stderr_c"], 1 / math.sqrt(3) - c), (case["stderr_D"], D))]


def costs(suites):
    """{method: {mu: [seconds for c, seconds for D]}}, the dearest first."""
    numpy = {c["mu"]: c["seconds"] * BEADS / (c["columns"] * c["layers"]) for c in suites["numpy"]["cases"]}
    of = {name: {} for name in ("the paper's machine", "NumPy", "`point`", "`point`, coupled",
                                "`multiplexed`, ε = 0.25, opposite", "`fluctuation`")}
    for case in suites["accuracy"]["cases"]:
        mu, name = case["mu"], estimator(case).removesuffix(", runs of 2")
        if name not in of or case["columns"] * case["layers"] < BEADS:
            continue
        cost = to_one_percent(case)
        of[name][mu] = [min(pair) for pair in zip(cost, of[name].get(mu, cost))]  # runs of 1 or 2
        if name == "`point`":  # the same piles, drawn otherwise
            piles = [seconds * case["samples"] / case["seconds"] for seconds in cost]
            of["the paper's machine"][mu] = [n * PAPER_SECONDS_PER_BEAD * BEADS for n in piles]
            if mu in numpy:
                of["NumPy"][mu] = [n * numpy[mu] for n in piles]
    return of


def in_time(seconds):
    for unit, name in ((86400, "d"), (3600, "h"), (60, "min")):
        if seconds >= 2 * unit:
            return f"{digits(seconds / unit)} {name}"
    return f"{digits(seconds)} s"


def cost(suites):
    of = costs(suites)
    rows = [[f"{mu:g}", *(", ".join(in_time(s) for s in by_mu[mu]) if mu in by_mu else "–" for by_mu in of.values())]
            for mu in of["`point`"]]
    return table(["μ", *of], rows)


def aims(suite):
    """What was wanted of the coupled form and of the linear response, against `point`, and what came out."""
    def gains(mu, quantity, *names):
        return {estimator(s): s[quantity] for s in suite["speedup_by_options"]
                if s["mu"] == mu and s[quantity] and estimator(s).startswith(names)}

    parts = []
    for mu, wanted in ((0.1, 9), (0.3, 4)):
        c, D = (gains(mu, q, "`point`")["`point`, coupled"] for q in ("c_peaks", "D"))
        parts.append(f"{digits(c)} (c) and {digits(D)} (D) at μ = {mu:g}, where {wanted} were wanted")
    text = "The coupled form is cheaper than `point` by a factor of " + ", and ".join(parts) + ". "
    parts = []
    for mu in (0.1, 0.3):
        c, D = (max(gains(mu, q, "`multiplexed`", "`fluctuation`").items(), key=lambda g: g[1]) for q in ("c_peaks", "D"))
        thrust = max(gains(mu, "c_thrust", "").values())
        parts.append(f"{digits(c[1])} (c; by c_thrust {digits(thrust)}) and {digits(D[1])} (D) at μ = {mu:g}")
    return paragraph(text + "Of the linear response 300 were wanted, by the best estimator of each: it is " +
                     ", and ".join(parts) + ".")


def plot_costs(of):
    """Two panels, c and D, with a curve for each method."""
    colours = ("#7f7f7f", "#b15928", "#1f78b4", "#33a02c", "#e31a1c", "#6a3d9a")
    blocks, curves = [], [[], []]
    for k, (name, by_mu) in enumerate(of.items()):
        lines = [f"{mu:g} {by_mu[mu][0]:.6g} {by_mu[mu][1]:.6g}" for mu in sorted(by_mu)]
        blocks.append(f"$data{k} << EOD\n" + "\n".join(lines) + "\nEOD\n")
        title = name.replace("`", "").split(", ε")[0]
        for q in range(2):
            curves[q].append(f"$data{k} using 1:{q + 2} with linespoints lc rgb '{colours[k]}' lw 1.5 pt {k + 4} ps 0.6 "
                             f"title \"{title}\"")
    script = "".join(blocks) + """set terminal svg size 760,360 dynamic background rgb 'white' font 'DejaVu Sans,11'
set encoding utf8
set multiplot
set logscale y
set format y '10^{%L}'
set xrange [0.08:0.42]
set yrange [0.1:3e7]
set xlabel 'friction coefficient μ'
set border 3
set tics nomirror
set key at screen 0.5,0.99 center top maxrows 2 samplen 1.5
set tmargin at screen 0.8
set bmargin at screen 0.15
"""
    for q, quantity in enumerate(("c_0 − c", "D")):
        script += (f"set lmargin at screen {0.09 + 0.5 * q}\nset rmargin at screen {0.48 + 0.5 * q}\n"
                   f"set ylabel 'processor seconds for 1 % of {quantity}'\n"
                   f"paper = {PAPER_PILES * PAPER_SECONDS_PER_BEAD * BEADS:g}\n"
                   "set label 1 'the paper: 3461 piles' at 0.415,paper*2.6 right textcolor rgb '#7f7f7f'\n"
                   "plot " + ", ".join(curves[q]) + ", paper with lines lc rgb '#7f7f7f' dt 2 notitle\nunset key\n")
    svg = subprocess.run(["gnuplot", "-d"], input=script, check=True, capture_output=True, text=True).stdout
    pathlib.Path(FIGURE).write_text(svg, encoding="utf-8")


def render(suite):
    rows = []
    for picture in suite["pictures"]:
        seconds = picture["seconds"]
        if seconds is None:
            rows.append([picture["name"], picture["reason"], "–", "–", "–", "–", "–"])
            continue
        parts = [f"{seconds[part]:.3f}" for part in ("all", "read", "build", "draw", "encode")]
        rows.append([picture["name"], *parts, f"{picture['peak_bytes'] / 1e6:.0f} MB"])
    return table(["picture", "all", "read", "build", "draw", "encode", "memory"], rows)


def main(folder):
    suites = {}
    for name in SUITES:
        file = pathlib.Path(folder) / f"{name}.json"
        if not file.is_file():
            made_by = MADE_BY.get(name, f"granuscope bench {name} --json {{file}}").format(file=file)
            sys.exit(f"{file} is missing, so its numbers are; `{made_by}` makes it")
        suites[name] = json.loads(file.read_text(encoding="utf-8"))
    tables = {
        "sampler": sampler(suites["sampler"]),
        "threads": threads(suites["sampler"]),
        "accuracy": accuracy(suites["accuracy"]),
        "point": point(suites["accuracy"]),
        "cost": cost(suites),
        "aims": aims(suites["accuracy"]),
        "render": render(suites["render"]),
    }
    plot_costs(costs(suites))
    for name, suite in suites.items():
        if "measured" not in suite:
            continue
        tables[f"measured {name}"] = measured(suite)
        if "targets" in suite:
            tables[f"targets {name}"] = targets(suite)
    page = pathlib.Path("templates/docs/performance.md").read_text(encoding="utf-8")
    for name, text in tables.items():
        if f"@@{name}@@" not in page:
            sys.exit(f"templates/docs/performance.md has no place for {name}")
        page = page.replace(f"@@{name}@@", text)
    print(page, end="")


if __name__ == "__main__":
    main(*sys.argv[1:])
