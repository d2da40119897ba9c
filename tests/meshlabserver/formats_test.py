"""formats_test.py SERVER CHECKER: the mesh in the formats of the neighbours: written by meshlabserver, judged without it,
and opened by it again; and all that a layer has beside coordinates and faces."""

import math
import pathlib
import re
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

from host_runs import ONE_SHOT, Run, as_float, check, read_obj, read_ply, sphere, torus, write_ply

SERVER, CHECKER = None, None
NOTHING = ONE_SHOT.parents[1] / "tests" / "benchmark" / "scripts" / "nothing.mlx"
POINTS = 2500


class FormatsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.cloud = self.folder / "cloud.ply"

    def reconstruct(self, *names, options=()):
        """The mesh of the cloud, in files of these names, all of one run."""
        outputs = [self.folder / name for name in names]
        run = Run(SERVER, self.folder, ONE_SHOT, [self.cloud], [("c", output) for output in outputs], options)
        self.assertEqual(run.code, 0, run.text)
        self.assertNotIn("NOT been saved", run.text)
        return outputs

    def expect_torus(self, figures):
        for key, value in dict(vertices=POINTS, faces=2 * POINTS, edges=3 * POINTS, border_edges=0, manifold=1, closed=1,
                               coherent=1, unreferenced=0, components=1, genus=1, outward=1).items():
            self.assertEqual(figures[key], value, f"{key}: {figures}")


class Formats(FormatsTest):
    def test_ply_and_stl_keep_every_bit(self):
        write_ply(self.cloud, torus(POINTS))
        for output in self.reconstruct("mesh.ply", "mesh.stl"):
            with self.subTest(output=output.name):
                figures = check(CHECKER, output, self.cloud)
                self.expect_torus(figures)
                self.assertEqual(figures["complete"], 1, figures)

    def test_stl_is_binary_and_watertight(self):
        write_ply(self.cloud, torus(POINTS))
        (output,) = self.reconstruct("mesh.stl")
        self.assertEqual(output.stat().st_size, 84 + 50 * 2 * POINTS)
        self.expect_torus(check(CHECKER, output))

    def test_off_is_the_mesh_to_seven_digits(self):
        points = torus(POINTS)
        write_ply(self.cloud, points)
        (output,) = self.reconstruct("mesh.off")
        self.expect_torus(check(CHECKER, output))
        vertices = [tuple(map(float, line.split())) for line in output.read_text().splitlines()[2:2 + POINTS]]
        self.expect_close(vertices, points, 1e-6)

    def test_obj_is_the_mesh_to_six_decimals(self):
        points = torus(POINTS)
        write_ply(self.cloud, points)
        (output,) = self.reconstruct("mesh.obj")
        vertices, faces = read_obj(output)
        again = self.folder / "again.ply"
        write_ply(again, vertices, faces)
        self.expect_torus(check(CHECKER, again))
        self.expect_close(vertices, points, 1e-6)

    def expect_close(self, vertices, points, tolerance):
        self.assertEqual(len(vertices), len(points))
        for vertex, point in zip(vertices, points):  # without duplicates, vertex i is point i
            self.assertLess(math.dist(vertex, point), tolerance)

    def test_the_host_opens_what_it_wrote(self):
        write_ply(self.cloud, torus(POINTS))
        for output in self.reconstruct("mesh.ply", "mesh.stl", "mesh.off"):
            with self.subTest(output=output.name):
                again = self.folder / f"again_{output.suffix[1:]}.ply"
                run = Run(SERVER, self.folder, NOTHING, [output], [("c", again)])
                self.assertEqual(run.code, 0, run.text)
                self.assertRegex(run.log, rf"loaded has {POINTS} vn {2 * POINTS} fn")
                self.expect_torus(check(CHECKER, again))


class Attributes(FormatsTest):
    def test_colours_and_qualities_stay_with_their_points(self):
        points = sphere(POINTS)
        colours = [(i % 256, i // 256, 77) for i in range(POINTS)]
        qualities = [as_float(0.37 * i - 100) for i in range(POINTS)]
        write_ply(self.cloud, points, colours=colours, qualities=qualities)
        (output,) = self.reconstruct("mesh.ply", options=("-m", "vc", "vq", "vn"))
        of_point = {point: (colour, quality) for point, colour, quality in zip(points, colours, qualities)}
        vertices, _ = read_ply(output)
        self.assertEqual(len(vertices), POINTS)
        for v in vertices:
            position = (v["x"], v["y"], v["z"])
            self.assertEqual(of_point[position], ((v["red"], v["green"], v["blue"]), v["quality"]))
            outwards = sum(n * x for n, x in zip((v["nx"], v["ny"], v["nz"]), position))
            self.assertGreater(outwards, 0.8)

    def test_colours_in_off_and_obj(self):
        points = sphere(POINTS)
        write_ply(self.cloud, points, colours=[(255, 0, 0) if x > 0 else (0, 0, 255) for x, _, _ in points])
        off, obj = self.reconstruct("mesh.off", "mesh.obj", options=("-m", "vc"))
        lines = off.read_text().splitlines()[2:2 + POINTS]
        lines += [line[2:] for line in obj.read_text().splitlines() if line.startswith("v ")]
        self.assertEqual(len(lines), 2 * POINTS)
        for line in lines:
            x, _, _, red, _, blue = map(float, line.split()[:6])
            self.assertEqual(red > blue, x > 0, line)

    def test_matrix_and_name_in_a_project(self):
        """A placed cloud: the mesh is where the cloud is, and the cloud is as it was."""
        points = sphere(POINTS)
        write_ply(self.cloud, points)
        matrix = "1 0 0 5 \n0 0 -1 6 \n0 1 0 7 \n0 0 0 1 \n"
        project, result = self.folder / "placed.mlp", self.folder / "result.mlp"
        project.write_text(f"""<!DOCTYPE MeshLabDocument>
<MeshLabProject><MeshGroup><MLMesh label="my scan" filename="cloud.ply"><MLMatrix44>
{matrix}</MLMatrix44></MLMesh></MeshGroup><RasterGroup/></MeshLabProject>""")
        run = Run(SERVER, self.folder, ONE_SHOT, [], projects=(project, result))
        self.assertEqual(run.code, 0, run.text)
        layers = list(ElementTree.parse(result).getroot().iter("MLMesh"))
        self.assertEqual(len(layers), 2)
        for layer in layers:
            self.assertEqual(layer.findtext("MLMatrix44").split(), matrix.split())
        self.assertTrue(re.match("my ?scan ?shrink ?wrap", layers[1].get("label")), layers[1].get("label"))
        before, mesh = (self.folder / layer.get("filename") for layer in layers)
        vertices, faces = read_ply(before)
        self.assertEqual(([(v["x"], v["y"], v["z"]) for v in vertices], faces), (points, []))
        self.assertEqual(check(CHECKER, mesh, self.cloud)["complete"], 1)


if __name__ == "__main__":
    SERVER, CHECKER = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
