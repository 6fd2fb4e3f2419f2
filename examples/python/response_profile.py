"""Print the mean response below a point load, from an ensemble file of granuscope.

usage: python3 response_profile.py ENSEMBLE.h5 LAYER >profile.csv

Needs h5py (Debian: python3-h5py). The ensemble is one that `granuscope run` leaves in ensembles/, of the estimator point:
each bead's mean weight minus the 1 that it has under a uniform load, per unit of the overload. With `coupled = true` the
file holds the response to several known loads, which layer 0 shows, so that each mode of it is divided by theirs.
"""
import json
import sys

try:
    import h5py
    import numpy
except ImportError as missing:
    print(f"{missing.name} is missing: apt-get install python3-h5py", file=sys.stderr)
    sys.exit(2)


def response(file, layer):
    """x and the mean response of each bead of that layer."""
    layers = list(file["layers"])
    if layer not in layers:
        sys.exit(f"layer {layer} was not recorded; there are {layers}")
    x = file["x"][layer % 2]
    if "weight" in file:
        return x, file["weight/sum"][:, layers.index(layer), :].sum(axis=0) / file["count"][...].sum() - 1
    moved, loads = (file["moved_weight/sum"][:, layers.index(row), :].sum(axis=0) for row in (layer, 0))
    # Not mode 0, which is 1: no load is lost. Nor the last one of an even number, whose sine no column sees.
    k = 2 * numpy.pi * numpy.arange(1, (len(x) + 1) // 2) / len(x)
    modes = numpy.exp(-1j * numpy.outer(k, x)) @ moved / (numpy.cos(numpy.outer(k, file["x"][0])) @ loads)
    return x, (1 + 2 * (numpy.exp(1j * numpy.outer(x, k)) @ modes).real) / len(x)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with h5py.File(sys.argv[1]) as file:
        settings = json.loads(file.attrs["configuration_json"])
        if settings["estimator"] != "point":
            sys.exit(f"the estimator of this ensemble is {settings['estimator']}, and not point")
        x, profile = response(file, int(sys.argv[2]))
        print("x,response")
        print(f"#{file['x'].attrs['units'].decode()},per unit of the overload")
        for place, value in sorted(zip(x, profile)):
            print(f"{place:g},{value:.6g}")


if __name__ == "__main__":
    main()
