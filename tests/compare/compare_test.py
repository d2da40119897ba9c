"""compare_test.py ROOT BUILD: the comparison with MeshLab's own filters: what makes its clouds, what it reads from the host's
log, its page, and one run of it."""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT, BUILD = None, None
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "meshlabserver"))

import measures  # noqa: E402
import page  # noqa: E402
from host_runs import check, read_ply, torus, write_ply  # noqa: E402

# Of meshlabserver 2020.09; earlier filters' lines come again after each.
LOG = """Starting Script of 7 actionsfilter: Compute Topological Measures
V:      5 E:     10 F:     6
filter: Delete Selected Faces
V:  12321 E:  36394 F: 24191
Unreferenced Vertices 184
Boundary Edges 215
Mesh is composed by 2 connected component(s)

Mesh has 29 non two manifold vertices and 169 faces are incident on these vertices

Mesh has a undefined number of holes (non 2-manifold mesh)
Genus is undefined (non 2-manifold mesh)
Mesh Surface Area is 0.442312
Mesh: 12137 vertices, 36394 edges, 24191 faces, 2 components
2-manifold: 29 non-manifold vertices
Closed: 215 border edges, 15 openings
Self-intersections: 88 faces
Complete matching: 12137 of 12321 samples matched exactly; 184 samples are no vertex
Hausdorff Distance computed
     Sampled 12321 pts (rng: 0) on cloud.ply searched closest on mesh.ply
     min : 0.000000   max 0.008479   mean : 0.000039   RMS : 0.000347
Values w.r.t. BBox Diag (2.000000)
     min : 0.000000   max 0.008308   mean : 0.000038   RMS : 0.000340

Deleted 81 faces.
"""
CLOSED_LOG = """filter: Delete Selected Faces
V:     10 E:     24 F: 16
Boundary Edges 0
Mesh is composed by 1 connected component(s)

Mesh is two-manifold
Mesh has 0 holes
Genus is 0
Mesh Surface Area is 1.5
Mesh Volume  is -0.25
Mesh: 10 vertices, 24 edges, 16 faces, 1 component
2-manifold: yes, genus 0
Closed: yes, volume -0.25, 1 component inside out
Self-intersections: none
Complete matching: 0 of 7 samples matched exactly; 7 samples are no vertex, 10 vertices are no sample
Values w.r.t. BBox Diag (4.000000)
     min : 0.000000   max 0.100000   mean : 0.050000   RMS : 0.06
Values w.r.t. BBox Diag (4.000000)
     min : 0.000000   max 0.200000   mean : 0.100000   RMS : 0.06
Values w.r.t. BBox Diag (2.000000)
     min : 0.000000   max 0.300000   mean : 0.150000   RMS : 0.06

Nothing done: no faces selected
"""


class Measures(unittest.TestCase):
    def test_open_mesh(self):
        figures = measures.measures(LOG)
        self.assertEqual((figures["samples_kept"], figures["samples"], figures["extra_vertices"]), (12137, 12321, 0))
        self.assertEqual((figures["closed"], figures["manifold"], figures["holes"]), (False, False, 15))
        self.assertEqual((figures["genus"], figures["inside_out"], figures["bodies"]), (None, None, 2))
        self.assertEqual((figures["self_intersecting_faces"], figures["meshlab"]["self_intersecting_faces"]), (88, 81))
        self.assertAlmostEqual(figures["samples_to_mesh"]["greatest"], 0.8308)
        self.assertNotIn("mesh_to_truth", figures)
        self.assertEqual(measures.disagreements(figures), [])

    def test_closed_mesh_with_truth(self):
        figures = measures.measures(CLOSED_LOG)
        self.assertEqual((figures["closed"], figures["genus"], figures["inside_out"]), (True, 0, True))
        self.assertEqual((figures["extra_vertices"], figures["self_intersecting_faces"]), (10, 0))
        # In % of the diagonal of the true surface.
        self.assertAlmostEqual(figures["samples_to_mesh"]["mean"], 10.0)
        self.assertAlmostEqual(figures["mesh_to_truth"]["greatest"], 40.0)
        self.assertAlmostEqual(figures["truth_to_mesh"]["mean"], 15.0)

    def test_a_log_that_ends_early_gives_nothing(self):
        for end in ("Complete matching", "Hausdorff", "Mesh: 12137"):
            self.assertIsNone(measures.measures(LOG[:LOG.index(end)]))
        self.assertIsNone(measures.measures(""))

    def test_disagreement_is_told(self):
        figures = measures.measures(CLOSED_LOG.replace("Genus is 0", "Genus is 4"))
        self.assertEqual(len(measures.disagreements(figures)), 1)


class Page(unittest.TestCase):
    def results(self):
        rows = [{"method": "Ball <Pivoting>", "seconds": 1.0, "processor_seconds": 2.0, **measures.measures(LOG)},
                {"method": "Shrink Wrap", "seconds": 1.0, "processor_seconds": 2.0, "error": "more than 3 s"}]
        return [{"name": "a | b", "noise": None, "has_truth": False, "points": 12321, "rows": rows},
                {"name": "c", "noise": None, "has_truth": False, "error": "MeshLab cannot read it"}]

    def test_markdown(self):
        text = page.markdown(self.results(), "today", ROOT)
        self.assertIn("| Ball <Pivoting> | 98.5 % | 15 | no | 2 | - | - | 88 (81) |", text)
        self.assertIn("more than 3 s", text)
        self.assertIn("MeshLab cannot read it", text)
        widths = {line.replace("\\|", "").count("|") for line in text.splitlines() if line.startswith("| ") and "98.5 %" in line}
        self.assertEqual(widths, {4, 12})
        self.assertIn("| a \\| b | 15 holes, not a 2-manifold | more than 3 s |", text)
        self.assertNotIn("Mesh to truth, mean", text)

    def test_figures_of_the_overview(self):
        row = {**measures.measures(CLOSED_LOG)}
        self.assertEqual(page.shape(row), "genus 0, inside out")
        self.assertEqual(page.shape({**row, "closed": False, "holes": 1, "inside_out": False}), "1 hole")
        results = [{"name": "a", "noise": None, "has_truth": True, "points": 7,
                    "rows": [{"method": "Poisson", "seconds": 1.0, "processor_seconds": 2.0, **row}]}]
        captions = [caption for caption, _, _ in page.overviews(results)]
        self.assertEqual(len(captions), 4)
        self.assertIn("Mesh to truth", captions[3])

    def test_html_is_escaped(self):
        text = page.html(self.results(), "today", ROOT)
        self.assertIn("Ball &lt;Pivoting&gt;", text)
        self.assertNotIn("<Pivoting>", text)

    def test_broken_promises(self):
        row = {**measures.measures(CLOSED_LOG)}
        self.assertEqual(page.broken_promise(row), "samples lost, inside out")
        self.assertEqual(page.broken_promise({**row, "samples_kept": 7, "inside_out": False}), "")


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_program(self, name, *words):
        return subprocess.run([BUILD / "tests" / "compare" / name, *map(str, words)], capture_output=True, check=False).returncode

    def test_ball_joint_is_the_sample_cloud(self):
        output = self.folder / "ball_joint.ply"
        self.assertEqual(self.run_program("make_ball_joint", output), 0)
        self.assertEqual(output.read_bytes(), (ROOT / "sample_clouds" / "ball_joint_34267.ply").read_bytes())

    def test_noise_is_that_of_its_seed(self):
        cloud = self.folder / "cloud.ply"
        write_ply(cloud, torus(500))
        outputs = [self.folder / f"{i}.ply" for i in range(4)]
        for output, (noise, seed) in zip(outputs, [(0.5, 1), (0.5, 1), (0.5, 2), (0, 1)]):
            self.assertEqual(self.run_program("add_noise", cloud, noise, seed, output), 0)
        first, again, other, none = (output.read_bytes() for output in outputs)
        self.assertEqual(first, again)
        self.assertNotEqual(first, other)
        points = [tuple(v[axis] for axis in "xyz") for v in read_ply(outputs[3])[0]]
        self.assertEqual(points, torus(500))
        self.assertNotEqual(none, first)

    def test_truth_is_closed_and_exact(self):
        truth = self.folder / "truth.ply"
        self.assertEqual(self.run_program("make_truth", "torus", truth), 0)
        figures = check(BUILD / "tests" / "meshlabserver" / "mesh_checker", truth)
        self.assertEqual([figures[key] for key in ("closed", "manifold", "coherent", "outward", "genus", "components")],
                         [1, 1, 1, 1, 1, 1])
        for x, y, z in self.positions(truth)[::50]:
            across = (x * x + y * y) ** 0.5 - 0.75
            self.assertAlmostEqual((across * across + z * z) ** 0.5, 0.25, places=5)
        self.assertEqual(self.run_program("make_truth", "no_such_shape", truth), 1)

    def positions(self, path):
        data = path.read_bytes()
        begin = data.index(b"end_header\n") + len(b"end_header\n")
        header = data[:begin].decode()
        self.assertIn("property float z\n", header)
        count = int(header.split("element vertex ")[1].split()[0])
        stride = 12 + 4 * header.split("element face")[0].count("property int flags")
        return [struct.unpack_from("<3f", data, begin + stride * i) for i in range(count)]

    def test_a_run_of_the_comparison(self):
        cloud, truth, output = self.folder / "größe 1.ply", self.folder / "truth.ply", self.folder / "out"
        write_ply(cloud, torus(2000))
        self.run_program("make_truth", "torus", truth)
        done = subprocess.run([sys.executable, HERE / "run.py", "--build", BUILD, "--output", output, "--renderer", "false",
                               "--runs", "1", "--method", "Ball Pivoting", "--method", "Shrink Wrap", "--truth", truth, cloud],
                              capture_output=True, check=False)
        said = done.stderr.decode()
        self.assertEqual(done.returncode, 0, said)
        self.assertIn("python3-vtk9 is missing", said)
        (result,) = json.loads((output / "comparison.json").read_text(encoding="utf-8"))
        theirs, ours = result["rows"]
        self.assertEqual((result["points"], theirs["method"], ours["method"]), (2000, "Ball Pivoting", "Shrink Wrap"))
        self.assertEqual((ours["samples_kept"], ours["closed"], ours["genus"]), (2000, True, 1), said)
        self.assertLess(ours["mesh_to_truth"]["mean"], 0.2)
        self.assertFalse(theirs["closed"] and theirs["samples_kept"] == 2000)
        for name in ("comparison.md", "comparison.html"):
            self.assertIn("größe 1, 2,000 points", (output / name).read_text(encoding="utf-8"))


if __name__ == "__main__":
    ROOT, BUILD = (pathlib.Path(word) for word in sys.argv[1:3])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
