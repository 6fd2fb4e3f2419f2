"""Plot the contact forces of a pile with matplotlib.

usage: python3 force_chains.py PILE.h5 PICTURE.png

Needs h5py and matplotlib (Debian: python3-h5py, python3-matplotlib). The pile is one that `granuscope sample --out` or
`granuscope run` (in piles/) has written. Its own `render` is some seventy times as fast.
"""
import sys

try:
    import h5py
    import matplotlib
    import numpy as np

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.collections import LineCollection
except ImportError as missing:
    print(f"{missing.name} is missing: apt-get install python3-h5py python3-matplotlib", file=sys.stderr)
    sys.exit(2)


def contacts(file):
    """From each bead to the two below it: ends of the lines, and the size of the forces."""
    lines, forces = [], []
    layers, columns = file["V_R"].shape
    x = file["x"][...][np.arange(layers) % 2]
    z = file["z"][...][:, None] * np.ones(columns)
    for side, step in (("R", 0.5), ("L", -0.5)):
        start = np.stack([x, z], axis=-1)
        end = np.stack([x + step, z + np.sqrt(3) / 2], axis=-1)
        lines.append(np.stack([start, end], axis=-2).reshape(-1, 2, 2))
        forces.append(np.hypot(file[f"V_{side}"], file[f"H_{side}"]).ravel())
    return np.concatenate(lines), np.concatenate(forces)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with h5py.File(sys.argv[1]) as file:
        lines, forces = contacts(file)
    figure, axes = pyplot.subplots(figsize=(6.7, 5))
    axes.add_collection(LineCollection(lines, array=forces, cmap="Greys", linewidths=2))
    axes.set(xlabel="x (bead diameters)", ylabel="z (bead diameters)", aspect="equal")
    axes.autoscale()
    axes.invert_yaxis()
    figure.savefig(sys.argv[2], dpi=150)


if __name__ == "__main__":
    main()
