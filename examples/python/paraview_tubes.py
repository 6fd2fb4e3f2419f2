"""Force chains of a pile as tubes coloured by N: a state of ParaView, or the tubes by VTK alone.

usage: paraview --script=paraview_tubes.py            File > Load State takes it, too
       pvpython paraview_tubes.py PILE.vtu [IMAGE.png]
       python3 paraview_tubes.py PILE.vtu TUBES.vtp   without ParaView (Debian: python3-vtk9), or IMAGE.png with a screen

PILE.vtu is what `granuscope export pile.h5 -o pile.vtu` writes; without a name it is pile.vtu in this folder.
"""
import sys

arguments = sys.argv[1:]
pile = arguments[0] if arguments else "pile.vtu"


def by_paraview():
    from paraview import simple

    reader = simple.XMLUnstructuredGridReader(FileName=[pile])
    # Contacts between beads: those on the floor have no lower bead, beads themselves neither.
    contacts = simple.Threshold(Input=reader, Scalars=["CELLS", "lower"])
    if hasattr(contacts, "LowerThreshold"):  # 5.10 and later
        contacts.LowerThreshold, contacts.UpperThreshold = 0, 1e15
    else:
        contacts.ThresholdRange = [0, 1e15]
    # Each contact gets ends of its own, so that its tube has one width.
    with_N = simple.CellDatatoPointData(Input=simple.Shrink(Input=contacts, ShrinkFactor=1), PassCellData=True)
    lines = simple.ExtractSurface(Input=with_N)
    tubes = simple.Tube(Input=lines, Scalars=["POINTS", "N"], VaryRadius="By Scalar", Radius=0.02, RadiusFactor=12)
    view = simple.GetActiveViewOrCreate("RenderView")
    view.InteractionMode = "2D"
    shown = simple.Show(tubes, view)
    simple.ColorBy(shown, ("CELLS", "N"))
    shown.RescaleTransferFunctionToDataRange(True)
    shown.SetScalarBarVisibility(view, True)
    simple.ResetCamera(view)
    simple.Render(view)
    if len(arguments) > 1:
        simple.SaveScreenshot(arguments[1], view, ImageResolution=[1600, 1200])


def by_vtk():
    from vtkmodules.vtkCommonDataModel import vtkDataObject
    from vtkmodules.vtkFiltersCore import vtkCellDataToPointData, vtkThreshold, vtkTubeFilter
    from vtkmodules.vtkFiltersGeneral import vtkShrinkFilter
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(pile)
    contacts = vtkThreshold()
    contacts.SetInputConnection(reader.GetOutputPort())
    contacts.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_CELLS, "lower")
    contacts.SetLowerThreshold(0)
    contacts.SetUpperThreshold(1e15)
    apart = vtkShrinkFilter()  # ends of its own for each contact
    apart.SetShrinkFactor(1)
    apart.SetInputConnection(contacts.GetOutputPort())
    with_N = vtkCellDataToPointData()
    with_N.PassCellDataOn()
    with_N.SetInputConnection(apart.GetOutputPort())
    lines = vtkGeometryFilter()
    lines.SetInputConnection(with_N.GetOutputPort())
    tubes = vtkTubeFilter()
    tubes.SetInputConnection(lines.GetOutputPort())
    tubes.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "N")
    tubes.SetVaryRadiusToVaryRadiusByScalar()
    tubes.SetRadius(0.02)
    tubes.SetRadiusFactor(12)
    tubes.SetNumberOfSides(8)
    tubes.Update()
    if tubes.GetOutput().GetNumberOfPolys() + tubes.GetOutput().GetNumberOfStrips() == 0:
        sys.exit(f"{pile}: there is no contact in it")
    if arguments[1].endswith(".png"):
        return draw(tubes, lines.GetOutput().GetCellData().GetArray("N").GetRange())
    writer = vtkXMLPolyDataWriter()
    writer.SetInputConnection(tubes.GetOutputPort())
    writer.SetFileName(arguments[1])
    writer.Write()


def draw(tubes, forces):
    import vtkmodules.vtkInteractionStyle
    import vtkmodules.vtkRenderingFreeType
    import vtkmodules.vtkRenderingOpenGL2
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(tubes.GetOutputPort())
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectColorArray("N")
    mapper.SetScalarRange(forces)
    mapper.GetLookupTable().SetHueRange(0.66, 0)  # from blue to red
    actor = vtkActor()
    actor.SetMapper(mapper)
    bar = vtkScalarBarActor()
    bar.SetLookupTable(mapper.GetLookupTable())
    bar.SetTitle("N")
    bar.UnconstrainedFontSizeOn()
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(0, 0, 0)
        text.SetFontSize(32)
        text.ShadowOff()
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    renderer.AddActor2D(bar)
    renderer.GetActiveCamera().ParallelProjectionOn()
    renderer.ResetCamera()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(1600, 1200)
    window.AddRenderer(renderer)
    window.Render()
    pixels = vtkWindowToImageFilter()
    pixels.SetInput(window)
    writer = vtkPNGWriter()
    writer.SetFileName(arguments[1])
    writer.SetInputConnection(pixels.GetOutputPort())
    writer.Write()


try:
    import paraview
except ImportError:
    paraview = None
if paraview:
    by_paraview()
elif len(arguments) == 2:
    by_vtk()
else:
    sys.exit(__doc__)
