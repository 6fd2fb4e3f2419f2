# Reads what `granuscope export` made of a pile with the libraries that others read it with, and holds each number
# against the pile file. python3 read_exports.py PILE.h5 FOLDER; FOLDER/pile.csv, beads.csv, pile.graphml, ...
# Prints which readers took part; what a file says that is not in the pile ends it with a message and status 1.
import sys

import h5py
import numpy

pile = h5py.File(sys.argv[1], "r")
folder = sys.argv[2]
mu = pile.attrs["mu"]
V_R, V_L, H_R, H_L = (pile[name][()] for name in ("V_R", "V_L", "H_R", "H_L"))
layers, columns = V_R.shape
x_of_row, z = pile["x"][()], pile["z"][()]
x = numpy.array([x_of_row[layer % 2] for layer in range(layers)])
number = numpy.arange(layers * columns).reshape(layers, columns)


def same(what, found, expected, tolerance=1e-12):
    found, expected = numpy.asarray(found, float), numpy.asarray(expected, float)
    if found.shape != expected.shape or not numpy.allclose(found, expected, rtol=tolerance, atol=tolerance, equal_nan=True):
        sys.exit(f"{what}: not as in the pile\n{found}\n{expected}")


# Each contact from the pile's arrays and the axes alone: numbers of both beads (-1 is the floor), N, T, H, V, branch, seam.
contacts = []
for layer in range(layers):
    for column in range(columns):
        for side, V, H in ((-1, V_L, H_L), (1, V_R, H_R)):
            lower, seam = -1, 0
            if layer + 1 < layers:
                away = x[layer + 1] - x[layer, column] - side / 2
                lower = number[layer + 1, numpy.argmin(abs(away - columns * numpy.round(away / columns)))]
                seam = int(abs(x.flat[lower] - x[layer, column]) > 1)
            force = numpy.array([H[layer, column], V[layer, column]])
            along = numpy.array([side / 2, 3**0.5 / 2])
            across = numpy.array([along[1], -along[0]])  # to the right of the branch
            contacts.append([number[layer, column], lower, seam, force @ along, force @ across, *force, *along])
contacts = numpy.array(contacts)
upper, lower, seam, N, T, H, V, branch_x, branch_z = contacts.T
of_beads = lower >= 0
with numpy.errstate(invalid="ignore", divide="ignore"):
    share = numpy.where(mu * N > 0, abs(T) / (mu * N), numpy.nan)
weight = (V_R + V_L).ravel()
depth = numpy.repeat(z, columns)
# Balance of the layers inside, from what enters from above and leaves below.
vertical = numpy.zeros((layers, columns))
for up, low, down in zip(upper, lower, V):
    vertical.flat[int(up)] -= down
    if low >= 0:
        vertical.flat[int(low)] += down
vertical[0] += pile["load"][()]
assert abs(vertical).max() < 1e-9, "the pile itself is out of balance"


def table(name):
    with open(f"{folder}/{name}") as file:
        head = file.readline().strip().split(",")
        return dict(zip(head, numpy.genfromtxt(file, delimiter=",", comments="#").T))


found = table("pile.csv")
for name, expected in dict(upper=upper, lower=lower, across_seam=seam, N=N, T=T, T_over_mu_N=share, force_x=H, force_z=V,
                           x_upper=x.ravel()[upper.astype(int)], z_upper=depth[upper.astype(int)], branch_x=branch_x,
                           branch_z=branch_z).items():
    same("pile.csv, " + name, found.pop(name), expected)
assert not found, found.keys()
found = table("beads.csv")
for name, expected in dict(bead=number.ravel(), x=x.ravel(), z=depth, weight=weight).items():
    same("beads.csv, " + name, found[name], expected)
assert (found["radius"] == 0.5).all() and (found["residual"] < 1e-12).all()

# LAMMPS: doc of `dump`; the order of the items is that of its writer.
def dump(name, kind):
    lines = open(f"{folder}/{name}").read().splitlines()
    assert lines[:2] == ["ITEM: TIMESTEP", "0"] and lines[2] == "ITEM: NUMBER OF " + kind, lines[:4]
    assert lines[4] == "ITEM: BOX BOUNDS pp ff pp", lines[4]
    box = [[float(bound) for bound in line.split()] for line in lines[5:8]]
    head = lines[8].split()
    assert head[:2] == ["ITEM:", kind] and int(lines[3]) == len(lines) - 9
    rows = numpy.array([[float(word) for word in line.split()] for line in lines[9:]])
    return box, dict(zip(head[2:], rows.T))


box, atoms = dump("beads.dump", "ATOMS")
same("beads.dump", [atoms[name] for name in ("id", "x", "y", "weight")],
     [number.ravel() + 1, x.ravel(), -depth, weight])
assert box[0][1] - box[0][0] == columns and box[1][0] < atoms["y"].min() and box[1][1] >= atoms["y"].max()
assert (atoms["x"] >= box[0][0]).all() and (atoms["x"] <= box[0][1]).all()
_, bonds = dump("pile.local", "ENTRIES")
same("pile.local", [bonds[name] for name in ("id1", "id2", "periodic")],
     [upper[of_beads] + 1, lower[of_beads] + 1, seam[of_beads]])
first = numpy.array([bonds["x1"], bonds["y1"]])
branch = numpy.array([bonds["x2"], bonds["y2"]]) - first
same("ends in pile.local", first, [x.ravel()[upper[of_beads].astype(int)], -depth[upper[of_beads].astype(int)]])
# Of a contact under pressure the force on the first bead points away from the second, with -N along the branch.
same("N of pile.local", -(bonds["fx"] * branch[0] + bonds["fy"] * branch[1]), N[of_beads])
same("forces of pile.local", [-bonds["fx"], bonds["fy"]], [H[of_beads], V[of_beads]])

_, walls = dump("walls.local", "ENTRIES")
same("walls.local", [walls[name] for name in ("id1", "fx", "fy", "x1", "y1", "contact_x", "contact_y")],
     numpy.array([upper + 1, -H, V, x.ravel()[upper.astype(int)], -depth[upper.astype(int)],
                  x.ravel()[upper.astype(int)] + branch_x / 2, -depth[upper.astype(int)] - branch_z / 2])[:, ~of_beads])

rows = numpy.genfromtxt(f"{folder}/pile.txt", delimiter=",")
from_above = rows[(rows[:, 2] < 0) | (rows[:, 2] > rows[:, 1])]
same("pegs", from_above[:, 1:], numpy.array([upper + 1, numpy.where(of_beads, lower + 1, -1), T, N]).T)
assert len(rows) == 2 * of_beads.sum() + (~of_beads).sum()
rows = numpy.genfromtxt(f"{folder}/beads.txt", delimiter=",")
same("pegs, beads", rows[:, 1:4], numpy.array([number.ravel() + 1, x.ravel(), depth]).T)

readers = ["numpy"]
try:
    import networkx

    graph = networkx.read_graphml(f"{folder}/pile.graphml", node_type=int)
    assert graph.number_of_nodes() == number.size and graph.number_of_edges() == of_beads.sum()
    for up, low, n, t, v in zip(upper[of_beads], lower[of_beads], N[of_beads], T[of_beads], V[of_beads]):
        edge = graph.edges[int(up), int(low)]
        same("graphml", [edge["N"], edge["T"], edge["force_y"]], [n, t, -v])
    same("nodes of graphml", [graph.nodes[k]["weight"] for k in number.ravel()], weight)
    readers.append("networkx")
except ImportError:
    pass


def check_vtu(points, lines, of_lines, of_points):
    same("points of vtu", points[: number.size, :2], numpy.array([x.ravel(), -depth]).T)
    same("branches of vtu", (points[lines[:, 1]] - points[lines[:, 0]])[:, :2], numpy.array([branch_x, -branch_z]).T)
    same("upper ends of vtu", lines[:, 0], upper)
    inside = of_beads & (seam == 0)
    same("lower ends of vtu", lines[inside, 1], lower[inside])
    assert (lines[~inside, 1] >= number.size).all()
    for name, expected in (("N", N), ("T", T), ("upper", upper), ("lower", lower)):
        same("vtu, " + name, of_lines[name], expected)
    same("vtu, force", of_lines["force"][:, :2], numpy.array([H, -V]).T)
    same("vtu, weight", of_points["weight"][: number.size], weight)


try:
    import meshio

    mesh = meshio.read(f"{folder}/pile.vtu")
    at = next(k for k, block in enumerate(mesh.cells) if block.type == "line")
    check_vtu(mesh.points, mesh.cells[at].data, {name: data[at] for name, data in mesh.cell_data.items()}, mesh.point_data)
    readers.append("meshio")
except ImportError:
    pass

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(f"{folder}/pile.vtu")
    reader.Update()
    grid = reader.GetOutput()
    lines = numpy.array([[grid.GetCell(number.size + k).GetPointId(end) for end in (0, 1)] for k in range(len(N))])
    cells, of_points = grid.GetCellData(), grid.GetPointData()
    check_vtu(vtk_to_numpy(grid.GetPoints().GetData()), lines,
              {name: vtk_to_numpy(cells.GetArray(name))[number.size:] for name in ("N", "T", "upper", "lower", "force")},
              {"weight": vtk_to_numpy(of_points.GetArray("weight"))})
    readers.append("vtk")
except ImportError:
    pass
print(" ".join(readers))
