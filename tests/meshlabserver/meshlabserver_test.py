"""meshlabserver_test.py SERVER CHECKER: every filter, and the whole chain, through the real meshlabserver: what it makes,
and how it fails. MeshLab hides much (it leaves with 0 when a file was not saved, prints no error message), so that each
test looks at the exit code, the log and the files."""

import math
import pathlib
import sys
import tempfile
import unittest

from host_runs import ONE_SHOT, SCRIPTS, Run, check, read_ply, script, sphere, torus, write_ply

SERVER, CHECKER = None, None
NAN, INFINITY = float("nan"), float("inf")


class HostTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.cloud = self.folder / "cloud.ply"
        self.mesh = self.folder / "mesh.ply"

    def run_script(self, base, *changes, inputs=None, outputs=None, options=(), **more):
        variant = script(self.folder / "script.mlx", base, *changes, **more)
        return Run(SERVER, self.folder, variant, [self.cloud] if inputs is None else inputs,
                   [("c", self.mesh)] if outputs is None else outputs, options)

    def succeeds(self, *arguments, **keywords):
        run = self.run_script(*arguments, **keywords)
        self.assertEqual(run.code, 0, run.text)
        self.assertIn("Shrink Wrap succeeded: ", run.log)
        self.assertNotIn("Shrink Wrap failed: ", run.log)
        return run

    def fails(self, word, *arguments, **keywords):
        """The script stops, says why, and writes nothing."""
        run = self.run_script(*arguments, **keywords)
        self.assertEqual(run.code, 255, run.text)
        self.assertIn("Shrink Wrap failed: ", run.log)
        reason = [line for line in run.log.splitlines() if line.startswith("Shrink Wrap failed: ")][-1]
        self.assertIn(word, reason)
        self.assertFalse(self.mesh.exists())
        return run

    def expect_complete(self, genus, components=1, cloud=None):
        figures = check(CHECKER, self.mesh, cloud or self.cloud)
        for key, value in dict(manifold=1, closed=1, coherent=1, outward=1, complete=1, unreferenced=0, genus=genus,
                               components=components).items():
            self.assertEqual(figures[key], value, f"{key}: {figures}")
        return figures


class OneShot(HostTest):
    def test_torus_is_complete(self):
        write_ply(self.cloud, torus(3000))
        run = self.succeeds(ONE_SHOT)
        self.assertEqual(self.expect_complete(genus=1)["vertices"], 3000)
        for stage in ("initial mesh", "control mesh", "parametric surface", "complete matching", "edge optimisation"):
            self.assertIn(stage, run.log)

    def test_several_bodies(self):
        write_ply(self.cloud, sphere(1200) + [(x + 4.0, y, z) for x, y, z in sphere(1200, seed=2)])
        self.succeeds(ONE_SHOT)
        self.expect_complete(genus=0, components=2)

    def test_paper_method(self):
        write_ply(self.cloud, sphere(1500))
        self.succeeds(ONE_SHOT, ("Method", 1))
        self.expect_complete(genus=0)

    def test_parametric_surface(self):
        write_ply(self.cloud, torus(3000))
        self.succeeds(ONE_SHOT, ("StopAtParametricSurface", "true"))
        figures = check(CHECKER, self.mesh)
        self.assertEqual((figures["closed"], figures["genus"], figures["outward"]), (1, 1, 1), figures)

    def test_openings_closed_and_left(self):
        write_ply(self.cloud, sphere(3000, keep=lambda p: p[2] > -0.3))
        self.succeeds(ONE_SHOT)
        figures = check(CHECKER, self.mesh, self.cloud)
        self.assertEqual((figures["closed"], figures["genus"], figures["matched"]), (1, 0, 3000), figures)
        self.mesh.unlink()
        self.succeeds(ONE_SHOT, ("Openings", 1))
        figures = check(CHECKER, self.mesh, self.cloud)
        self.assertEqual((figures["manifold"], figures["closed"], figures["matched"]), (1, 0, 3000), figures)

    def test_kept_stages_are_layers(self):
        write_ply(self.cloud, sphere(1500))
        outputs = [(layer, self.folder / f"layer{layer}.ply") for layer in range(1, 6)]
        self.succeeds(ONE_SHOT, ("KeepStages", "true"), outputs=outputs)
        for _, output in outputs:
            self.assertEqual(check(CHECKER, output)["closed"], 1)
        self.assertEqual(check(CHECKER, outputs[-1][1], self.cloud)["complete"], 1)

    def test_duplicates_and_bad_points_are_left_out(self):
        points = sphere(1000)
        write_ply(self.cloud, points[:500] + [(NAN, 0, 0), (0, INFINITY, 0)] + points + [(0.0, 0.0, -NAN)])
        run = self.succeeds(ONE_SHOT)
        self.assertIn("3 not finite and 500 duplicates", run.log)
        self.assertEqual(self.expect_complete(genus=0)["vertices"], 1000)

    def test_far_from_the_origin(self):
        points = [(4096.0 + 64 * x, -20000.0 + 64 * y, 300.0 + 64 * z) for x, y, z in sphere(2000)]
        write_ply(self.cloud, points)
        self.succeeds(ONE_SHOT)
        self.expect_complete(genus=0)

    def test_same_bytes_for_any_number_of_threads(self):
        write_ply(self.cloud, torus(4000))
        self.succeeds(ONE_SHOT, ("Threads", 1))
        one = self.mesh.read_bytes()
        self.succeeds(ONE_SHOT, ("Threads", 2))
        self.assertEqual(one, self.mesh.read_bytes())

    def test_selected_points_only(self):
        points = sphere(1200) + [(x + 4.0, y, z) for x, y, z in sphere(1200, seed=2)]
        write_ply(self.cloud, points)
        select = """<filter name="Conditional Vertex Selection">
                    <Param type="RichString" name="condSelect" value="(x &lt; 2)"/></filter>"""
        self.succeeds(ONE_SHOT, ("SelectedOnly", "true"), before=select)
        selected = self.folder / "selected.ply"
        write_ply(selected, points[:1200])
        self.expect_complete(genus=0, cloud=selected)

    def test_colours_stay_with_their_points(self):
        points = sphere(800)
        colours = [(i % 256, i // 256, 77) for i in range(800)]
        write_ply(self.cloud, points, colours=colours)
        self.succeeds(ONE_SHOT, options=("-m", "vc"))
        vertices, _ = read_ply(self.mesh)
        of_point = {point: colour for point, colour in zip(points, colours)}
        for vertex in vertices:
            colour = (vertex["red"], vertex["green"], vertex["blue"])
            self.assertEqual(of_point[vertex["x"], vertex["y"], vertex["z"]], colour)

    def test_last_input_is_the_current_layer(self):
        other = self.folder / "other.ply"
        write_ply(self.cloud, sphere(1000))
        write_ply(other, torus(2000))
        self.succeeds(ONE_SHOT, inputs=[self.cloud, other])
        self.expect_complete(genus=1, cloud=other)


class OneShotFailures(HostTest):
    def test_too_few_points(self):
        for points in ([], [(0, 0, 0)], [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1, 2, 3)] * 50):
            with self.subTest(count=len(points)):
                write_ply(self.cloud, points)
                self.fails("point" if not points else "4", ONE_SHOT)

    def test_flat_and_straight_clouds(self):
        flat = [(x / 20, y / 20, 0.0) for x in range(20) for y in range(20)]
        for points in (flat, [(i / 7, i / 3, i / 5) for i in range(100)]):
            write_ply(self.cloud, points)
            self.fails("plan" if points is flat else "lin", ONE_SHOT)

    def test_no_finite_point(self):
        write_ply(self.cloud, [(NAN, INFINITY, 0.0)] * 20)
        self.fails("4", ONE_SHOT)

    def test_no_layer(self):
        self.fails("no layer", ONE_SHOT, inputs=[], outputs=[])

    def test_unreadable_input(self):
        for content in (b"", b"ply\nthis is no point cloud", None):
            if content is None:
                self.cloud.unlink()
            else:
                self.cloud.write_bytes(content)
            run = self.run_script(ONE_SHOT)
            self.assertEqual(run.code, 255, run.text)
            self.assertFalse(self.mesh.exists())

    def test_values_out_of_range(self):
        write_ply(self.cloud, sphere(500))
        for name, value in (("VoxelSize", -1), ("VoxelSize", "nan"), ("Level", 5), ("Neighbours", 2), ("Method", 7),
                            ("Threads", -3), ("MaximumGenus", -2), ("WidestOpening", 0), ("Openings", -1)):
            with self.subTest(name=name, value=value):
                self.fails(name, ONE_SHOT, (name, value))

    def test_wrong_type(self):
        write_ply(self.cloud, sphere(500))
        self.fails("VoxelSize", ONE_SHOT, ("VoxelSize", 2), types={"VoxelSize": "RichInt"})
        self.fails("Method", ONE_SHOT, ("Method", 1), types={"Method": "RichInt"})

    def test_nothing_selected(self):
        write_ply(self.cloud, sphere(500))
        self.fails("selected", ONE_SHOT, ("SelectedOnly", "true"))

    def test_a_failing_filter_stops_the_script(self):
        write_ply(self.cloud, sphere(500))
        self.fails("Level", SCRIPTS / "checked_reconstruction.mlx", ("Level", 9))


class Stages(HostTest):
    def one_shot_bytes(self, *changes):
        self.succeeds(ONE_SHOT, *changes)
        content = self.mesh.read_bytes()
        self.mesh.unlink()
        return content

    def test_chain_is_the_one_shot(self):
        write_ply(self.cloud, torus(3000))
        expected = self.one_shot_bytes()
        self.succeeds(SCRIPTS / "stage_by_stage.mlx")
        self.assertEqual(self.mesh.read_bytes(), expected)
        self.expect_complete(genus=1)

    def test_chain_is_the_one_shot_with_openings(self):
        write_ply(self.cloud, sphere(3000, keep=lambda p: p[2] > -0.3))
        for openings in (0, 1):
            expected = self.one_shot_bytes(("Openings", openings))
            self.succeeds(SCRIPTS / "stage_by_stage.mlx", ("Openings", openings))
            self.assertEqual(self.mesh.read_bytes(), expected)

    def test_chain_is_the_one_shot_as_in_the_paper(self):
        write_ply(self.cloud, sphere(1500))
        expected = self.one_shot_bytes(("Method", 1))
        self.succeeds(SCRIPTS / "stage_by_stage.mlx", ("Method", 1))
        self.assertEqual(self.mesh.read_bytes(), expected)

    def test_every_stage_makes_a_closed_mesh(self):
        write_ply(self.cloud, torus(3000))
        outputs = [(layer, self.folder / f"layer{layer}.ply") for layer in range(1, 6)]
        self.succeeds(SCRIPTS / "stage_by_stage.mlx", outputs=outputs)
        figures = [check(CHECKER, output) for _, output in outputs]
        for figure in figures:
            self.assertEqual((figure["closed"], figure["genus"]), (1, 1), figures)
        self.assertLess(figures[1]["vertices"], figures[0]["vertices"])
        self.assertEqual(figures[3]["vertices"], 3000)

    def test_a_stage_needs_a_closed_mesh(self):
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        write_ply(self.cloud, sphere(500))
        for faces, word in (([(0, 1, 2)], "border"), ([], "no faces")):
            broken = self.folder / "broken.ply"
            write_ply(broken, points, faces)
            for name in ("Control Mesh", "Parametric Surface", "Complete Matching", "Edge Optimisation"):
                with self.subTest(name=name, word=word):
                    single = self.single_filter(name)
                    # The last stage looks for the samples before it looks for borders.
                    told = "every sample" if faces and name == "Edge Optimisation" else word
                    self.fails(told, single, ("Samples", 0), ("Mesh", 1), inputs=[self.cloud, broken])

    def test_failures_name_the_layers_and_the_remedy(self):
        write_ply(self.cloud, sphere(500))
        broken, bare = self.folder / "broken.ply", self.folder / "bare.ply"
        write_ply(broken, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2)])
        write_ply(bare, sphere(10))
        for mesh, words in ((broken, ("border", "repair")), (bare, ("no faces", "choose"))):
            run = self.fails('layers "cloud.ply" and "' + mesh.name + '": ', self.single_filter("Control Mesh"), ("Mesh", 1),
                             inputs=[self.cloud, mesh])
            for word in words:
                self.assertIn(word, run.log)
        write_ply(self.cloud, [])
        self.fails('layer "cloud.ply": the layer has no points: open', ONE_SHOT)

    def single_filter(self, name):
        text = (SCRIPTS / "stage_by_stage.mlx").read_text()
        begin = text.index(f' <filter name="Shrink Wrap: {name}"')
        end = text.index("</filter>", begin) + len("</filter>")
        path = self.folder / "single.mlx"
        path.write_text(f"<!DOCTYPE FilterScript>\n<FilterScript>\n{text[begin:end]}\n</FilterScript>\n")
        return path

    def test_a_layer_that_does_not_exist(self):
        write_ply(self.cloud, sphere(500))
        run = self.run_script(self.single_filter("Control Mesh"), ("Mesh", 9))
        self.assertEqual(run.code, 255, run.text)
        self.assertFalse(self.mesh.exists())

    def test_edge_optimisation_needs_the_samples_as_vertices(self):
        write_ply(self.cloud, sphere(1000))
        self.succeeds(ONE_SHOT)
        other = self.folder / "other.ply"
        write_ply(other, sphere(900, seed=5))
        first = self.mesh.rename(self.folder / "first.ply")
        self.fails("sample", self.single_filter("Edge Optimisation"), ("Mesh", 1), inputs=[other, first])


class Measures(HostTest):
    def test_reconstruction_passes_its_own_report(self):
        write_ply(self.cloud, torus(3000))
        run = self.succeeds(SCRIPTS / "checked_reconstruction.mlx")
        self.assertIn("complete: closed 2-manifold of genus 1", run.log)

    def test_stray_points_do_not_move_the_result_to_another_layer(self):
        write_ply(self.cloud, [*torus(3000), (50, 50, 50)])
        run = self.succeeds(SCRIPTS / "checked_reconstruction.mlx")
        self.assertIn("1 outlier left out", run.log)
        self.assertIn("complete: closed 2-manifold of genus 1", run.log)
        self.assertEqual(check(CHECKER, self.mesh, self.cloud)["faces"], 6000)

    def test_report_of_an_incomplete_mesh(self):
        write_ply(self.cloud, sphere(100))
        tetrahedron = self.folder / "tetrahedron.ply"
        write_ply(tetrahedron, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
        both = [self.cloud, tetrahedron]
        run = self.succeeds(SCRIPTS / "matching_report.mlx", inputs=both)
        self.assertIn("NOT complete", run.log)
        self.assertIn("0 of 100 samples matched", run.log)
        self.mesh.unlink(missing_ok=True)
        self.fails("NOT complete", SCRIPTS / "matching_report.mlx", ("FailIfIncomplete", "true"), inputs=both)

    def test_distance_is_that_of_the_nearest_sample(self):
        points, queries = sphere(300), [(2 * x, 3 * y, 0.5 * z) for x, y, z in sphere(200, seed=9)]
        other = self.folder / "other.ply"
        write_ply(self.cloud, points)
        write_ply(other, queries)
        self.succeeds(SCRIPTS / "distance_to_samples.mlx", inputs=[self.cloud, other],
                      outputs=[(1, self.mesh)], options=("-m", "vq"))
        vertices, _ = read_ply(self.mesh)
        for vertex in vertices:
            p = (vertex["x"], vertex["y"], vertex["z"])
            nearest = min(math.dist(p, q) for q in points)
            self.assertAlmostEqual(vertex["quality"], nearest, places=6)

    def test_measures_need_layers(self):
        for name in ("matching_report", "distance_to_samples"):
            with self.subTest(name=name):
                run = self.run_script(SCRIPTS / f"{name}.mlx", inputs=[], outputs=[])
                self.assertEqual(run.code, 255, run.text)


if __name__ == "__main__":
    SERVER, CHECKER = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
