#!/usr/bin/python3
"""Renders point clouds and meshes side by side: the pictures of the README.

usage: render.py OUTPUT.png [--columns N] [--size W,H] [--azimuth A] [--elevation E] [--edges]
                 [--scalars NAME] FILE[=CAPTION] ...

Every file is drawn in the same view. PLY, OBJ and STL; files without faces are drawn as points. Face or vertex
scalars named by --scalars colour the mesh. Needs python3-vtk9; run it under xvfb-run where there is no display.
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


def add_points(renderer, data, diagonal):
    vertices = vtk.vtkVertexGlyphFilter()
    vertices.SetInputData(data)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(vertices.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(POINTS)
    actor.GetProperty().SetPointSize(2)
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
    parser.add_argument("--edges", action="store_true")
    options = parser.parse_args()

    columns = options.columns or len(options.files)
    rows = (len(options.files) + columns - 1) // columns
    width, height = (int(n) for n in options.size.split(","))
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(width * columns, height * rows)
    bounds = None
    for index, item in enumerate(options.files):
        path, _, caption = item.partition("=")
        data = read(path)
        bounds = bounds or data.GetBounds()
        renderer = vtk.vtkRenderer()
        column, row = index % columns, rows - 1 - index // columns
        renderer.SetViewport(column / columns, row / rows, (column + 1) / columns, (row + 1) / rows)
        renderer.SetBackground(1, 1, 1)
        if data.GetNumberOfPolys() == 0:
            add_points(renderer, data, 1)
        else:
            add_mesh(renderer, data, options.edges)
        if caption:
            text = vtk.vtkTextActor()
            text.SetInput(caption)
            text.GetTextProperty().SetColor(0.1, 0.1, 0.1)
            text.GetTextProperty().SetFontSize(15)
            text.SetPosition(8, 8)
            renderer.AddActor2D(text)
        camera = renderer.GetActiveCamera()
        camera.SetFocalPoint(0, 0, 0)
        camera.SetPosition(*{"x": (0, 0, 1), "y": (0, 0, 1), "z": (0, -1, 0)}[options.up])
        camera.SetViewUp(*{"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[options.up])
        camera.Azimuth(options.azimuth)
        camera.Elevation(options.elevation)
        camera.Roll(options.roll)
        renderer.ResetCamera(bounds)
        camera.Zoom(options.zoom)
        window.AddRenderer(renderer)
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(options.output)
    writer.SetInputData(grab.GetOutput())
    writer.Write()


if __name__ == "__main__":
    main()
