"""Fills templates/docs/performance.md with the numbers that `granuscope bench SUITE --json FOLDER/SUITE.json` measured:
a line `@@name@@` becomes the table of that name. Writes the page to standard output.

    python3 cmake/performance_page.py out/bench
"""
import json
import pathlib
import sys
import textwrap

SUITES = ("sampler", "accuracy", "render")


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
    ratios = [c["wall_ns_per_bead"] / c["ns_per_bead"] for c in suite.get("cases", []) if "wall_ns_per_bead" in c]
    return sum(ratios) / len(ratios) if ratios else 1


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
    name = f"`{case['estimator']}`"
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
                and c["columns"] * c["layers"] >= 100000]
        rows.append([f"{speedup['mu']:g}", estimator(speedup), digits(speedup["D"]), digits(speedup["c_peaks"]),
                     digits(speedup["c_thrust"]), with_error(same[0]["D"]) if same else "–"])
    return table(["μ", "estimator", "D", "c", "c_thrust", "D itself"], rows)


def point(suite):
    rows = [[f"{c['mu']:g}", with_error(c["c"]), with_error(c["D"]), f"{c['samples']:.0f}", digits(c["seconds"]),
             digits(c["stderr_c"]), digits(c["stderr_D"])]
            for c in suite["cases"] if c["estimator"] == "point" and c["columns"] * c["layers"] >= 100000]
    return table(["μ", "c", "D", "piles", "seconds", "error of c", "error of D"], rows)


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
            sys.exit(f"{file} is missing, so its numbers are; `granuscope bench {name} --json {file}` makes it")
        suites[name] = json.loads(file.read_text(encoding="utf-8"))
    tables = {
        "sampler": sampler(suites["sampler"]),
        "threads": threads(suites["sampler"]),
        "accuracy": accuracy(suites["accuracy"]),
        "point": point(suites["accuracy"]),
        "render": render(suites["render"]),
    }
    for name, suite in suites.items():
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
