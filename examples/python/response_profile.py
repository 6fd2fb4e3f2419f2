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


def response(file, layer, overload):
    """x of each bead of that layer, and the mean response of it and of its mirror image, as in the figures."""
    layers = list(file["layers"])
    if layer not in layers:
        sys.exit(f"layer {layer} was not recorded; there are {layers}")
    x = file["x"][layer % 2]
    if "weight" in file:
        profile = file["weight/sum"][:, layers.index(layer), :].sum(axis=0) / file["count"][...].sum()
        profile = (profile - 1) / overload
    else:
        # By distance from the overloaded bead, which stands in the middle.
        moved, loads = (
            numpy.fft.rfft(numpy.fft.ifftshift(file["moved_weight/sum"][:, layers.index(row), :].sum(axis=0)))
            for row in (layer, 0)
        )
        modes = moved / numpy.where(loads.real > 1e-12 * loads.real[1], loads.real, numpy.inf)
        if loads.real[0] <= 1e-12 * loads.real[1]:  # it went with what piles share; no load is lost
            modes[0] = 1
        profile = numpy.fft.fftshift(numpy.fft.irfft(modes, len(x)))
    mirror = (len(x) // 2 * 2 - numpy.arange(len(x)) - layer % 2) % len(x)
    return x, (profile + profile[mirror]) / 2


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with h5py.File(sys.argv[1]) as file:
        settings = json.loads(file.attrs["configuration_json"])
        if settings["estimator"] != "point":
            sys.exit(f"the estimator of this ensemble is {settings['estimator']}, and not point; "
                     f"`granuscope export {sys.argv[1]} response.csv` writes its mean response at each layer")
        x, profile = response(file, int(sys.argv[2]), settings["overload"])
        print("x,P")
        print("#bead diameters,1/bead diameter")
        for place, value in sorted(zip(x, profile)):
            print(f"{place:g},{value:.6g}")


if __name__ == "__main__":
    main()
