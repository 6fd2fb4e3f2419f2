"""Fills templates/docs/performance.md with the numbers that `granuscope bench SUITE --json FOLDER/SUITE.json` and
other programs (MADE_BY) measured: a line `@@name@@` becomes the table of that name. Writes the page to standard output,
and the numbers of its charts to CSV files in examples/figures, which cmake/performance_charts.gp draws.

    python3 cmake/performance_page.py out/bench
"""
import json
import math
import pathlib
import sys
import textwrap

PLOTTERS = tuple(f"plotters-{side}" for side in (100, 300, 1000))  # beads along the side of a pile
SUITES = ("sampler", "accuracy", "render", "numpy", "size", *PLOTTERS)
MADE_BY = {"numpy": "python3 examples/python/numpy_piles.py --json {file}",
           "size": "python3 cmake/time_with_size.py build/release/granuscope --json {file}",
           **{name: "python3 tests/render/compare_plotters.py build/release/granuscope --columns {side} --layers {side} "
                    "--json {file}" for name in PLOTTERS}}
FIGURES = pathlib.Path("examples/figures")
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
    missed = [(t["name"], digits(t["measured"], 3), f"at most {t['at_most']:g}" if "at_most" in t else f"at least {t['at_least']:g}")
              for t in suite["targets"] if not t["met"]]
    text = f"{len(suite['targets']) - len(missed)} of the suite's {len(suite['targets'])} limits were kept"
    if missed and waiting(suite) > 1.1:
        return paragraph(text + "; a run beside other work does not judge the rest.")
    return paragraph(text + ".") + ("\n\n" + table(["limit not kept", "measured", "wanted"], missed) if missed else "")


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

    rows = []
    for mu, wanted in ((0.1, 9), (0.3, 4)):
        coupled = (gains(mu, q, "`point`")["`point`, coupled"] for q in ("c_peaks", "D"))
        linear = (max(gains(mu, q, "`multiplexed`", "`fluctuation`").values()) for q in ("c_peaks", "D"))
        thrust = max(gains(mu, "c_thrust", "").values())
        rows.append([f"{mu:g}", *map(digits, coupled), str(wanted), *map(digits, linear), digits(thrust), "300"])
    return table(["μ", "coupled: c", "D", "wanted", "linear response: c", "D", "c_thrust", "wanted"], rows)


def write_csv(name, head, units, rows):
    lines = [",".join(head), "#" + ",".join(units), *(",".join(map(str, row)) for row in rows)]
    (FIGURES / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_charts(suites):
    """The numbers of the three charts."""
    write_csv("cost-for-equal-error", ("method", "mu", "c0_minus_c", "D"), ("", "", "processor s for 1 %", "processor s for 1 %"),
              [(name.replace("`", "").split(", ε")[0].replace(", ", " "), f"{mu:g}", *(f"{s:.4g}" for s in by_mu[mu]))
               for name, by_mu in costs(suites).items() for mu in sorted(by_mu)])
    write_csv("time-with-size", ("program", "mu", "columns", "layers", "piles", "processor_time", "memory"),
              ("", "", "beads", "beads", "", "s", "MB"),
              [(c["program"], c["mu"], c["columns"], c["layers"], c["piles"], f"{c['seconds']:.3g}",
                f"{c['peak_bytes'] / 1e6:.0f}") for c in suites["size"]["cases"]])
    write_csv("painting", ("program", "contacts", "processor_time"), ("", "", "us per contact"),
              [(program, contacts, f"{us:.3g}") for program, contacts, us in painting(suites)])


def painting(suites):
    """Microseconds per contact, and the rows of the chart."""
    names = {"granuscope, its own painter, all drawn": "granuscope", "Cairo": "Cairo", "gnuplot": "gnuplot",
             "matplotlib": "matplotlib"}
    rows = []
    for suite in (suites[s] for s in PLOTTERS):
        contacts = 2 * suite["columns"] * suite["layers"]
        for name, shown in names.items():
            rows.append((shown, contacts, 1e6 * suite["processor_seconds"][name] / contacts))
    return rows


def painting_table(suites):
    rows = painting(suites)
    programs = list(dict.fromkeys(row[0] for row in rows))
    return table(["contacts", *programs], [[f"{n}", *(digits(us) for _, m, us in rows if m == n)]
                                           for n in dict.fromkeys(row[1] for row in rows)])


def size(suite):
    """What a bead takes in piles of all sizes, and in NumPy."""
    def per_bead(program, mu, square):
        return [1e9 * c["seconds"] / (c["columns"] * c["layers"] * c["piles"]) for c in suite["cases"]
                if (c["program"], c["mu"], c["columns"] == c["layers"]) == (program, mu, square)]

    squares = [c["columns"] for c in suite["cases"] if c["columns"] == c["layers"]]
    ranges = [f"{digits(min(ns))} to {digits(max(ns))} ns at μ = {mu:g}"
              for mu, ns in ((mu, per_bead("granuscope", mu, True)) for mu in (0.1, 0.3))]
    return paragraph("Time grows as the beads of all piles (left). In square piles of "
                     f"{min(squares)} to {max(squares)} layers (right) a bead takes {' and '.join(ranges)}. That is drawing, checks, "
                     f"the sums of the response, and files. By NumPy it takes "
                     f"{digits(min(per_bead('NumPy', 0.1, False)) / 1e3)} µs at μ = 0.1.")


def beside(suites):
    """What the two charts of time were measured beside."""
    wall, processor = (sum(sum(suites[s][key].values()) for s in PLOTTERS) for key in ("seconds", "processor_seconds"))
    return paragraph("Both charts were measured beside other work on the same cores, which makes processor time longer, too."
                     if wall > 1.5 * processor else "Both charts were measured on cores that did nothing else.")


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
            made_by = MADE_BY.get(name, f"granuscope bench {name} --json {{file}}").format(
                file=file, side=name.removeprefix("plotters-"))
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
        "painting": painting_table(suites),
        "size": size(suites["size"]),
        "beside": beside(suites),
    }
    write_charts(suites)
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
