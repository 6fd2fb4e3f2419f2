#!/usr/bin/env python3
"""Draws the force chains of one pile with granuscope, Cairo, matplotlib and gnuplot and compares the times.

    tests/render/compare_plotters.py build/release/granuscope [--columns 1000] [--layers 1000] [--width 2000] [--json FILE]

All start from the same pile file and end with a PNG on disk: the same bars, as wide and as dark, the stronger ones
on top, on a plot area of the same number of pixels. Each is run three times, or once if it takes long, and the shortest
counts. granuscope is timed as a whole process; matplotlib without starting Python and importing it; gnuplot as a whole
process, reading a binary table that is written beforehand, and so is Cairo, by a program of thirty lines that strokes
contact by contact. Processor seconds are printed, too, for which granuscope's own painter, everything drawn, stands beside
Cairo; and the mean grey of the plot areas, which tells whether the pictures are the same.

h5py, numpy and matplotlib are needed (Debian: python3-h5py, python3-matplotlib), gnuplot is compared where it is
installed, Cairo where libcairo.so.2 and a C compiler are. The exit status is 1 if granuscope is not at least 20 times as fast as matplotlib at 1000 x 1000 beads or more.
"""
import argparse
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time

WIDEST_BAR = 0.5  # bead diameters, at the upper end of the scale
SCALE_END = 1.5  # force / top load
REPETITIONS, LONG_SECONDS = 3, 5  # what takes long is run once
WIDTH_CLASSES = 32  # gnuplot has one width for each curve
LIMIT = 20


def processor_seconds():
    """Of this process and of those that it has waited for."""
    return sum(u.ru_utime + u.ru_stime for u in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def shortest(draw):
    """Seconds by the clock and of the processor."""
    seconds = []
    for _ in range(REPETITIONS):
        start, processor = time.perf_counter(), processor_seconds()
        draw()
        seconds.append((time.perf_counter() - start, processor_seconds() - processor))
        if seconds[-1][0] > LONG_SECONDS:
            break
    return [min(values) for values in zip(*seconds)]


def contacts_of(pile_file):
    """Ends (x0, z0, x1, z1) and strengths of all contacts, the strongest last."""
    import h5py
    import numpy

    with h5py.File(pile_file) as pile:
        V = {side: pile[f"V_{side}"][:] for side in "LR"}
        H = {side: pile[f"H_{side}"][:] for side in "LR"}
    layers, columns = V["L"].shape
    n = numpy.arange(layers)[:, None]
    x = (numpy.arange(columns)[None, :] - columns // 2) + 0.5 * (n % 2)
    z = numpy.broadcast_to(0.5 + n * math.sqrt(3) / 2, x.shape)
    ends, strengths = [], []
    for side, sideways in (("L", -0.5), ("R", 0.5)):
        ends.append(numpy.stack([x, z, x + sideways, z + math.sqrt(3) / 2], axis=-1).reshape(-1, 4))
        strengths.append((numpy.hypot(V[side], H[side]) / SCALE_END).clip(0, 1).ravel())
    ends, strengths = numpy.concatenate(ends), numpy.concatenate(strengths)
    order = numpy.argsort(strengths, kind="stable")
    return ends[order], strengths[order], columns, layers


def draw_with_matplotlib(pile_file, image, width):
    import numpy
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    ends, strengths, columns, layers = contacts_of(pile_file)
    depth = 1 + (layers - 1) * math.sqrt(3) / 2
    height = round(width * depth / columns)
    dpi = 100
    figure = Figure(figsize=(width / dpi, height / dpi), dpi=dpi)
    FigureCanvasAgg(figure)
    axes = figure.add_axes([0, 0, 1, 1])
    axes.set_xlim(-columns / 2, columns / 2)
    axes.set_ylim(depth, 0)
    axes.axis("off")
    points_per_diameter = width / columns * 72 / dpi
    axes.add_collection(LineCollection(ends.reshape(-1, 2, 2), linewidths=strengths * WIDEST_BAR * points_per_diameter,
                                       colors=numpy.repeat(1 - strengths[:, None], 3, axis=1), capstyle="round"))
    figure.savefig(image, dpi=dpi)


def prepare_gnuplot(pile_file, folder, width):
    import numpy

    ends, strengths, columns, layers = contacts_of(pile_file)
    depth = 1 + (layers - 1) * math.sqrt(3) / 2
    height = round(width * depth / columns)
    classes = numpy.minimum((strengths * WIDTH_CLASSES).astype(int), WIDTH_CLASSES - 1)
    curves = []
    for k in range(WIDTH_CLASSES):
        chosen = classes == k
        if not chosen.any():
            continue
        grey = numpy.round(255 * (1 - strengths[chosen])).astype(int) * 0x010101
        table = numpy.column_stack([ends[chosen, 0], ends[chosen, 1], ends[chosen, 2] - ends[chosen, 0],
                                    ends[chosen, 3] - ends[chosen, 1], grey]).astype("<f8")
        table.tofile(os.path.join(folder, f"class-{k}.bin"))
        line = (k + 0.5) / WIDTH_CLASSES * WIDEST_BAR * width / columns
        curves.append(f"'class-{k}.bin' binary format='%5float64' using 1:2:3:4:5 with vectors nohead "
                      f"linewidth {line:.6g} linecolor rgb variable notitle")
    with open(os.path.join(folder, "plot.gp"), "w", encoding="ascii") as script:
        script.write(f"set terminal pngcairo size {width},{height} rounded\nset output 'gnuplot.png'\n"
                     "set margins 0,0,0,0\nunset border\nunset tics\nunset key\n"
                     f"set xrange [{-columns / 2}:{columns / 2}]\nset yrange [{depth}:0]\n"
                     "plot " + ", \\\n  ".join(curves) + "\n")


CAIRO = r"""
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#define USE(result, name, ...) result (*name)(__VA_ARGS__) = (result (*)(__VA_ARGS__))dlsym(cairo, "cairo_" #name)
int main(int count, char** names) {
  void* cairo = dlopen("libcairo.so.2", RTLD_NOW);
  if (count < 3 || !cairo) return 2;
  USE(void*, image_surface_create, int, int, int);
  USE(int, surface_write_to_png, void*, const char*);
  USE(void*, create, void*);
  USE(void, paint, void*);
  USE(void, stroke, void*);
  USE(void, set_line_cap, void*, int);
  USE(void, set_line_width, void*, double);
  USE(void, set_source_rgb, void*, double, double, double);
  USE(void, move_to, void*, double, double);
  USE(void, line_to, void*, double, double);
  FILE* file = fopen(names[1], "rb");
  double head[3], bar[6];
  if (!file || fread(head, 8, 3, file) != 3) return 2;
  void* surface = image_surface_create(1, head[0], head[1]); /* RGB24 */
  void* on = create(surface);
  set_source_rgb(on, 1, 1, 1), paint(on), set_line_cap(on, 1);
  double* bars = malloc(48 * (size_t)head[2]);
  size_t bars_there = fread(bars, 48, head[2], file);
  clock_t start = clock();
  for (double* b = bars; b < bars + 6 * bars_there; b += 6) {
    set_source_rgb(on, b[5], b[5], b[5]), set_line_width(on, b[4]);
    move_to(on, b[0], b[1]), line_to(on, b[2], b[3]), stroke(on);
  }
  printf("%g\n", (double)(clock() - start) / CLOCKS_PER_SEC);
  return surface_write_to_png(surface, names[2]);
}
"""


def prepare_cairo(pile_file, folder, width):
    """The program and its table; False where there is no Cairo or no compiler."""
    import numpy

    program = os.path.join(folder, "cairo")
    compiled = shutil.which("cc") and subprocess.run(["cc", "-O2", "-x", "c", "-", "-o", program, "-ldl"], input=CAIRO,
                                                     text=True, capture_output=True).returncode == 0
    if not compiled or subprocess.run([program], capture_output=True).returncode != 2:
        return False
    ends, strengths, columns, layers = contacts_of(pile_file)
    scale = width / columns
    height = round(scale * (1 + (layers - 1) * math.sqrt(3) / 2))
    ends[:, [0, 2]] += columns / 2
    table = numpy.column_stack([ends * scale, strengths * WIDEST_BAR * scale, 1 - strengths]).astype("<f8")
    with open(os.path.join(folder, "cairo.bin"), "wb") as out:
        out.write(numpy.array([width, height, len(table)], "<f8").tobytes() + table.tobytes())
    return True


def mean_grey(image, plot_width, plot_height):
    """Of the picture's plot area, which stands at the right below the upper edge where there is decorations."""
    import matplotlib.image
    import numpy

    pixels = matplotlib.image.imread(image)
    grey = pixels if pixels.ndim == 2 else pixels[..., :3].mean(axis=2)
    if grey.shape[1] > plot_width:  # granuscope's frame is the first long line from above and from the left
        dark = grey < 0.9
        top = int(numpy.argmax(dark.mean(axis=1) > 0.8)) + 2
        left = int(numpy.argmax(dark.mean(axis=0) > 0.6)) + 2
        grey = grey[top:top + plot_height, left:left + plot_width]
    return float(grey.mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("granuscope")
    parser.add_argument("--columns", type=int, default=1000)
    parser.add_argument("--layers", type=int, default=1000)
    parser.add_argument("--width", type=int, default=2000)
    parser.add_argument("--json")
    options = parser.parse_args()
    try:
        import h5py  # noqa: F401
        import matplotlib.image
    except ImportError as missing:
        sys.exit(f"nothing can be compared without {missing.name}; install python3-h5py and python3-matplotlib")

    program = os.path.abspath(options.granuscope)
    with tempfile.TemporaryDirectory() as folder:
        pile, image = os.path.join(folder, "pile.h5"), os.path.join(folder, "granuscope.png")
        subprocess.run([program, "sample", "--mu", "0.3", "--columns", str(options.columns), "--layers",
                        str(options.layers), "--load", "point", "--out", pile], check=True, capture_output=True)

        def render(*flags):
            subprocess.run([program, "render", pile, "--image", image, "--width", str(options.width),
                            f"--range=0,{SCALE_END}", *flags], check=True, capture_output=True)

        seconds = {"granuscope": shortest(render), "granuscope, all drawn": shortest(lambda: render("--no-skip"))}

        def spans():
            render("--no-skip", "--backend", "none")

        seconds["granuscope, its own painter, all drawn"] = shortest(spans)
        render()
        # The others get the pixels of its plot area, without axes and legend around it.
        pixels = matplotlib.image.imread(image)
        row = pixels.reshape(pixels.shape[0], pixels.shape[1], -1).mean(axis=2)
        frame = (row < 0.9).mean(axis=1) > 0.8
        dark = row[int(frame.argmax())] < 0.9
        plot_width = int(dark.sum()) - 4  # the frame is two pixels thick at 300 dpi
        plot_height = round(plot_width * (1 + (options.layers - 1) * math.sqrt(3) / 2) / options.columns)

        other = os.path.join(folder, "matplotlib.png")
        seconds["matplotlib"] = shortest(lambda: draw_with_matplotlib(pile, other, plot_width))
        grey = {"granuscope": mean_grey(image, plot_width, plot_height),
                "matplotlib": mean_grey(other, plot_width, plot_height)}
        if shutil.which("gnuplot"):
            prepare_gnuplot(pile, folder, plot_width)
            seconds["gnuplot"] = shortest(
                lambda: subprocess.run(["gnuplot", "-d", "plot.gp"], cwd=folder, check=True, capture_output=True))
            grey["gnuplot"] = mean_grey(os.path.join(folder, "gnuplot.png"), plot_width, plot_height)
        if prepare_cairo(pile, folder, plot_width):
            strokes = []

            def cairo():
                strokes.append(float(subprocess.run(["./cairo", "cairo.bin", "cairo.png"], cwd=folder, check=True,
                                                    capture_output=True, text=True).stdout))

            seconds["Cairo"] = shortest(cairo)
            grey["Cairo"] = mean_grey(os.path.join(folder, "cairo.png"), plot_width, plot_height)
            print(f"strokes of Cairo: {1e9 * min(strokes) / (2 * options.columns * options.layers):.0f} ns a contact")

    print(f"{options.columns} x {options.layers} beads, plot area {plot_width} x {plot_height} pixels, "
          f"matplotlib {matplotlib.__version__}")
    for name, (value, processor) in seconds.items():
        times = value / seconds["granuscope"][0]
        tone = f"  mean grey {grey[name]:.3f}" if name in grey else ""
        print(f"{name:40}{value:9.3f} s  {times:7.1f} x  {processor:9.3f} s of the processor{tone}")
    ratio = seconds["matplotlib"][0] / seconds["granuscope"][0]
    large = options.columns * options.layers >= 1000 * 1000
    met = ratio >= LIMIT or not large
    if options.json:
        with open(options.json, "w", encoding="utf-8") as out:
            json.dump({"columns": options.columns, "layers": options.layers, "plot_width_px": plot_width,
                       "seconds": {name: wall for name, (wall, _) in seconds.items()},
                       "processor_seconds": {name: processor for name, (_, processor) in seconds.items()},
                       "mean_grey": grey, "times_faster_than_matplotlib": ratio,
                       "at_least": LIMIT if large else None, "met": met}, out, indent=2)
            out.write("\n")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
