# Writes the contacts of a file that `granuscope export` made once more in each way in which VTK can.
# python3 write_vtk.py PILE.vtu FOLDER; prints the names of the files.
import sys

import vtkmodules.vtkCommonDataModel as data_model
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

folder = sys.argv[2]
reader = vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()

# The same as polygonal data: points as vertices, contacts as lines.
lines = data_model.vtkPolyData()
lines.SetPoints(grid.GetPoints())
verts, segments = data_model.vtkCellArray(), data_model.vtkCellArray()
for k in range(grid.GetNumberOfCells()):
    cell = grid.GetCell(k)
    (verts if cell.GetNumberOfPoints() == 1 else segments).InsertNextCell(cell)
lines.SetVerts(verts)
lines.SetLines(segments)
lines.GetPointData().ShallowCopy(grid.GetPointData())
lines.GetCellData().ShallowCopy(grid.GetCellData())


def write(writer, name, source):
    writer.SetFileName(f"{folder}/{name}")
    writer.SetInputData(source)
    assert writer.Write() == 1
    print(name)


for kind, suffix, source in ((vtkXMLUnstructuredGridWriter, "vtu", grid), (vtkXMLPolyDataWriter, "vtp", lines)):
    for mode in ("Ascii", "Binary", "Appended"):
        for compressed in (False, True):
            for raw in (False, True) if mode == "Appended" else (False,):
                for wide in (False, True):
                    writer = kind()
                    getattr(writer, f"SetDataModeTo{mode}")()
                    writer.SetEncodeAppendedData(not raw)
                    (writer.SetCompressorTypeToZLib if compressed else writer.SetCompressorTypeToNone)()
                    writer.SetBlockSize(1024)
                    (writer.SetHeaderTypeToUInt64 if wide else writer.SetHeaderTypeToUInt32)()
                    (writer.SetByteOrderToBigEndian if wide and raw else writer.SetByteOrderToLittleEndian)()
                    write(writer, f"{mode}-{compressed}-{raw}-{wide}.{suffix}", source)
for kind, suffix, source in ((vtkUnstructuredGridWriter, "grid.vtk", grid), (vtkPolyDataWriter, "lines.vtk", lines)):
    for binary in (False, True):
        for version in (42, 51):
            writer = kind()
            (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
            writer.SetFileVersion(version)
            write(writer, f"legacy-{binary}-{version}-{suffix}", source)
