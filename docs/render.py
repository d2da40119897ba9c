#!/usr/bin/python3
"""Renders point clouds and meshes side by side: the pictures of the README.

usage: render.py OUTPUT.png [--columns N] [--size W,H] [--azimuth A] [--elevation E] [--edges]
                 [--view principal] [--outside] [--fine N] FILE[=CAPTION] ...

Every file is drawn in the same view: along an axis, or, with --view principal, along the direction in which the first
file is thinnest. PLY, OBJ and STL; files without faces are drawn as points. The inner side of a surface is orange;
--outside turns meshes that are inside out; --fine draws N times as large and scales down, for thin lines. Needs
python3-vtk9; run it under xvfb-run where there is no display.
"""
import argparse

import vtk

SURFACE = (0.80, 0.83, 0.88)
BACK = (0.85, 0.45, 0.35)
POINTS = (0.15, 0.35, 0.65)
LINES = (0.25, 0.28, 0.33)


def read(path):
    readers = {"ply": vtk.vtkPLYReader, "obj": vtk.vtkOBJReader, "stl": vtk.vtkSTLReader}
    reader = readers[path.rsplit(".", 1)[-1].lower()]()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def turned_outside(data):
    """The mesh with a positive volume, as seen from its middle: a few holes do not matter."""
    middle = data.GetCenter()
    cells, ids, volume = data.GetPolys(), vtk.vtkIdList(), 0.0
    cells.InitTraversal()
    while cells.GetNextCell(ids):
        a, b, c = ([x - m for x, m in zip(data.GetPoint(ids.GetId(i)), middle)] for i in range(3))
        volume += vtk.vtkMath.Determinant3x3(a, b, c)
    if volume >= 0.0:
        return data
    turn = vtk.vtkReverseSense()
    turn.SetInputData(data)
    turn.ReverseCellsOn()
    turn.Update()
    return turn.GetOutput()


def principal_view(data):
    """(direction to look from, direction that is up): the thinnest and the longest of the points' axes, each turned so
    that its greatest coordinate is positive."""
    longest, middle, thinnest, corner, size = ([0.0] * 3 for _ in range(5))
    vtk.vtkOBBTree.ComputeOBB(data.GetPoints(), corner, longest, middle, thinnest, size)

    def turned(axis):
        return axis if max(axis) >= -min(axis) else [-x for x in axis]

    return turned(thinnest), turned(longest)


def fit(camera, data):
    """Parallel projection, large enough for a square view of the points, with room for a caption."""
    camera.OrthogonalizeViewUp()
    up, along = camera.GetViewUp(), camera.GetDirectionOfProjection()
    right = [0.0] * 3
    vtk.vtkMath.Cross(along, up, right)
    step = max(1, data.GetNumberOfPoints() // 100000)
    points = [data.GetPoint(i) for i in range(0, data.GetNumberOfPoints(), step)]
    centre, half = [0.0] * 3, 0.0
    for axis in (right, up, along):
        extent = [vtk.vtkMath.Dot(p, axis) for p in points]
        middle = (min(extent) + max(extent)) / 2
        centre = [c + middle * a for c, a in zip(centre, axis)]
        if axis is not along:
            half = max(half, (max(extent) - min(extent)) / 2)
    distance = camera.GetDistance()
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*(c - distance * a for c, a in zip(centre, along)))
    camera.ParallelProjectionOn()
    camera.SetParallelScale(1.16 * half)


def add_points(renderer, data, size):
    vertices = vtk.vtkVertexGlyphFilter()
    vertices.SetInputData(data)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(vertices.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(POINTS)
    actor.GetProperty().SetPointSize(size)
    actor.GetProperty().LightingOff()
    renderer.AddActor(actor)


def add_mesh(renderer, data, edges):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(SURFACE)
    look.SetInterpolationToFlat()
    look.SetAmbient(0.15)
    look.SetDiffuse(0.85)
    look.SetSpecular(0.08)
    if edges:
        look.EdgeVisibilityOn()
        look.SetEdgeColor(LINES)
        look.SetLineWidth(0.6)
    back = vtk.vtkProperty()
    back.SetColor(BACK)
    actor.SetBackfaceProperty(back)
    renderer.AddActor(actor)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output")
    parser.add_argument("files", nargs="+")
    parser.add_argument("--columns", type=int, default=0)
    parser.add_argument("--size", default="360,360")
    parser.add_argument("--azimuth", type=float, default=30)
    parser.add_argument("--elevation", type=float, default=20)
    parser.add_argument("--roll", type=float, default=0)
    parser.add_argument("--zoom", type=float, default=1.35)
    parser.add_argument("--up", default="y", choices=["x", "y", "z"])
    parser.add_argument("--view", default="axis", choices=["axis", "principal"])
    parser.add_argument("--outside", action="store_true")
    parser.add_argument("--edges", action="store_true")
    parser.add_argument("--fine", type=int, default=1, choices=range(1, 5))
    options = parser.parse_args()

    columns = options.columns or len(options.files)
    rows = (len(options.files) + columns - 1) // columns
    fine = options.fine
    width, height = (fine * int(n) for n in options.size.split(","))
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(width * columns, height * rows)
    bounds = None
    from_direction = {"x": (0, 0, 1), "y": (0, 0, 1), "z": (0, -1, 0)}[options.up]
    up_direction = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[options.up]
    for index, item in enumerate(options.files):
        path, _, caption = item.rpartition("=") if "=" in item else (item, "", "")
        data = read(path)
        if bounds is None:
            first, bounds = data, data.GetBounds()
            if options.view == "principal":
                from_direction, up_direction = principal_view(data)
        if options.outside:
            data = turned_outside(data)
        renderer = vtk.vtkRenderer()
        column, row = index % columns, rows - 1 - index // columns
        renderer.SetViewport(column / columns, row / rows, (column + 1) / columns, (row + 1) / rows)
        renderer.SetBackground(1, 1, 1)
        if data.GetNumberOfPolys() == 0:
            add_points(renderer, data, 2 * fine)
        else:
            add_mesh(renderer, data, options.edges)
        if caption:
            text = vtk.vtkTextActor()
            text.SetInput(caption)
            text.GetTextProperty().SetColor(0.1, 0.1, 0.1)
            text.GetTextProperty().SetFontSize(15 * fine)
            text.SetPosition(8 * fine, 8 * fine)
            renderer.AddActor2D(text)
        camera = renderer.GetActiveCamera()
        camera.SetFocalPoint(0, 0, 0)
        camera.SetPosition(*from_direction)
        camera.SetViewUp(*up_direction)
        camera.Azimuth(options.azimuth)
        camera.Elevation(options.elevation)
        camera.Roll(options.roll)
        renderer.ResetCamera(bounds)
        if options.view == "principal":
            fit(camera, first)
            renderer.ResetCameraClippingRange()
        else:
            camera.Zoom(options.zoom)
        window.AddRenderer(renderer)
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    scaled = vtk.vtkImageShrink3D()
    scaled.SetInputData(grab.GetOutput())
    scaled.SetShrinkFactors(fine, fine, 1)
    scaled.MeanOn()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(options.output)
    writer.SetInputConnection(scaled.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    main()
