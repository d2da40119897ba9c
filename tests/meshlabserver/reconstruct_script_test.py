"""reconstruct_script_test.py ROOT BUILD CHECKER: sample_clouds/reconstruct.sh as a user calls it: any name, several inputs,
and never a file or an exit code that says more than is true."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from host_runs import as_float, check, read_ply, read_ply_with_face_qualities, sphere, torus, write_ply

ROOT, BUILD, CHECKER = None, None, None


class ScriptTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "Meine Köpfe (größte) 'n more"
        self.folder.mkdir()

    def start(self, *arguments, **environment):
        return subprocess.Popen(["sh", str(ROOT / "sample_clouds" / "reconstruct.sh"), *map(str, arguments)],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=self.folder,
                                env={**os.environ, "SHRINKWRAP_BUILD_DIR": BUILD, **environment})

    def call(self, *arguments, **environment):
        process = self.start(*arguments, **environment)
        self.text = process.communicate(timeout=600)[0].decode(errors="replace")
        self.assertEqual([p.name for p in self.folder.rglob(".*")], [], "left behind")
        return process.returncode

    def cloud(self, name, points):
        path = self.folder / name
        write_ply(path, points)
        return path


class ReconstructScript(ScriptTest):
    def path_with(self, program, commands):
        """A PATH with another program in the place of one; `xvfb-run` runs the host."""
        programs = self.folder / "programs"
        programs.mkdir()
        (programs / program).write_text(f"#!/bin/sh\n{commands}\n")
        (programs / program).chmod(0o755)
        return f"{programs}:{os.environ['PATH']}"

    def test_one_input_to_a_named_output(self):
        cloud = self.cloud("größte Kugel 点群.ply", torus(2000))
        output = self.folder / "Ergebnis № 1.ply"
        self.assertEqual(self.call(cloud.name, "-o", output.name, LC_ALL="C"), 0, self.text)
        figures = check(CHECKER, output, cloud)
        self.assertEqual((figures["closed"], figures["complete"], figures["genus"]), (1, 1, 1), figures)
        for word in ("initial mesh", "control mesh", "parametric surface", "2000 of 2000 samples matched"):
            self.assertIn(word, self.text)

    def test_names_that_look_like_options_or_patterns(self):
        cloud = self.cloud("-i [a]*?.PLY", sphere(600))
        self.assertEqual(self.call("--", cloud.name), 0, self.text)
        self.assertEqual(check(CHECKER, self.folder / "-i [a]*?_shrink_wrap.ply", cloud)["complete"], 1)
        (self.folder / "-in_shrink_wrap.old").mkdir()
        cloud = self.cloud("-in_shrink_wrap.old/a.ply", sphere(600))
        for arguments, written in ((("--", "-in_shrink_wrap.old"), "-in_shrink_wrap.old/a_shrink_wrap.ply"),
                                   (("-o", "-out", "--", "-in_shrink_wrap.old"), "-out/a_shrink_wrap.ply"),
                                   (("a.ply", "-o", "-mesh.ply"), "-mesh.ply")):
            with self.subTest(arguments=arguments):
                self.cloud("a.ply", sphere(600))
                self.assertEqual(self.call(*arguments), 0, self.text)
                self.assertEqual(check(CHECKER, self.folder / written, cloud)["complete"], 1)

    def test_several_inputs_and_one_that_fails(self):
        first, second = self.cloud("a.ply", sphere(600)), self.cloud("b.ply", torus(1500))
        self.cloud("flat.ply", sphere(3))
        self.assertEqual(self.call("a.ply", "flat.ply", "b.ply", "-j", "2"), 1, self.text)
        self.assertIn("2 of 3 reconstructed", self.text)
        self.assertIn("FAILED: ", self.text)
        self.assertEqual(check(CHECKER, self.folder / "a_shrink_wrap.ply", first)["complete"], 1)
        self.assertEqual(check(CHECKER, self.folder / "b_shrink_wrap.ply", second)["complete"], 1)
        self.assertFalse((self.folder / "flat_shrink_wrap.ply").exists())

    def test_a_folder_of_inputs_to_a_folder(self):
        clouds = self.folder / "in"
        clouds.mkdir()
        self.cloud("in/a.ply", sphere(600))
        self.cloud("in/b.ply", sphere(700))
        (clouds / "notes.txt").write_text("no cloud")
        self.assertEqual(self.call("in", "-o", "out"), 0, self.text)
        self.assertEqual(sorted(p.name for p in (self.folder / "out").iterdir()),
                         ["a_shrink_wrap.ply", "b_shrink_wrap.ply"])

    def test_options_reach_the_filter(self):
        self.cloud("a.ply", sphere(1000))
        self.assertEqual(self.call("a.ply", "--surface", "--threads", "1", "-o", "surface.obj"), 0, self.text)
        self.assertTrue((self.folder / "surface.obj").stat().st_size > 0)
        self.assertNotIn("complete matching", self.text)
        self.assertEqual(self.call("a.ply", "--paper"), 0, self.text)
        self.assertEqual(check(CHECKER, self.folder / "a_shrink_wrap.ply", self.folder / "a.ply")["complete"], 1)
        self.assertIn("initial mesh                 98 vertices", self.text, "a box, subdivided")
        self.cloud("open.ply", sphere(2000, keep=lambda p: p[2] < 0.3))
        self.assertEqual(self.call("open.ply", "--leave-open"), 0, self.text)
        self.assertIn("open (1 border)", self.text)

    def test_a_limit_of_time(self):
        self.cloud("small.ply", sphere(600))
        self.cloud("large.ply", torus(400000))
        self.assertEqual(self.call("large.ply", "--time-limit", "1"), 1, self.text)
        self.assertIn("FAILED: not done after 1 s", self.text)
        self.assertFalse((self.folder / "large_shrink_wrap.ply").exists())
        self.assertEqual(self.call("small.ply", "--time-limit", "300"), 0, self.text)

    def test_a_killed_host_is_not_taken_for_a_late_one(self):
        self.cloud("a.ply", sphere(600))
        path = self.path_with("xvfb-run", "kill -9 $$")
        self.assertEqual(self.call("a.ply", "--time-limit", "300", PATH=path), 1, self.text)
        self.assertIn("FAILED: MeshLab was killed", self.text)

    def test_a_stale_output_does_not_survive_a_failure(self):
        self.cloud("a.ply", sphere(3))
        stale = self.folder / "mesh.ply"
        stale.write_text("of yesterday")
        self.assertEqual(self.call("a.ply", "-o", "mesh.ply"), 1, self.text)
        self.assertIn("at least 4", self.text)
        self.assertFalse(stale.exists())

    def test_a_stale_output_does_not_survive_its_input(self):
        """Nor does the mesh of a cloud that is gone, or empty now."""
        (self.folder / "empty.ply").touch()
        for name in ("empty", "missing"):
            stale = self.folder / f"{name}_shrink_wrap.ply"
            stale.write_text("of yesterday")
            self.assertEqual(self.call(f"{name}.ply"), 1, self.text)
            self.assertFalse(stale.exists(), name)

    def test_no_input_is_overwritten(self):
        first, second = self.cloud("a.ply", sphere(600)), self.cloud("a_shrink_wrap.ply", sphere(700))
        before = second.read_bytes()
        self.assertEqual(self.call("a.ply", "a_shrink_wrap.ply"), 1, self.text)
        self.assertIn("1 of 2 reconstructed", self.text)
        self.assertIn("would overwrite", self.text)
        self.assertEqual(second.read_bytes(), before)
        self.assertEqual(check(CHECKER, self.folder / "a_shrink_wrap_shrink_wrap.ply", second)["complete"], 1)
        self.assertTrue(first.exists())

    def test_all_sample_clouds_and_a_corrupt_one(self):
        """Exactly that one fails, and is named with the reason, at the end as well."""
        clouds = self.folder / "Scans vom März"
        clouds.mkdir()
        samples = sorted((ROOT / "sample_clouds").glob("*.ply"))
        self.assertGreaterEqual(len(samples), 6)
        for sample in samples:
            shutil.copy(sample, clouds)
        whole = samples[1].read_bytes()
        (clouds / "kaputt – übertragen.ply").write_bytes(whole[:len(whole) // 2])
        self.assertEqual(self.call(clouds.name, "-o", "Netze", "-j", "2"), 1, self.text)
        self.assertIn(f"{len(samples)} of {len(samples) + 1} reconstructed", self.text)
        table = [line for line in self.text.splitlines() if "  FAILED  " in line]
        self.assertEqual(len(table), 1, self.text)
        self.assertIn("kaputt – übertragen.ply (MeshLab cannot read it", table[0])
        self.assertIn("kaputt – übertragen.ply: MeshLab cannot read it", self.text[self.text.rindex("Failed:"):])
        self.assertEqual(sorted(p.name for p in (self.folder / "Netze").iterdir()),
                         [f"{sample.stem}_shrink_wrap.ply" for sample in samples])

    def test_stopping_leaves_whole_meshes_only(self):
        inputs = [self.cloud(f"{i} ö.ply", torus(1500, seed=i)) for i in range(1, 40)]
        process = self.start(*[path.name for path in inputs], "-o", "out", "-j", "2")
        output = self.folder / "out"
        while not list(output.glob("*.ply")) and process.poll() is None:
            time.sleep(0.02)
        process.send_signal(signal.SIGTERM)
        text = process.communicate(timeout=60)[0].decode(errors="replace")
        self.assertEqual(process.returncode, 130, text)
        # Everything that was started has ended: else it held the pipe open.
        meshes = list(output.iterdir())
        self.assertLess(len(meshes), len(inputs))
        for mesh in meshes:
            self.assertEqual(check(CHECKER, mesh, self.folder / mesh.name.replace("_shrink_wrap", ""))["complete"], 1)

    def test_colours_and_qualities_are_kept(self):
        """Under every name by which MeshLab reads them."""
        points = sphere(600)
        qualities = [as_float(0.5 + i) for i in range(600)]
        write_ply(self.folder / "grey.ply", points, intensities=[i % 256 / 255.0 for i in range(600)])
        write_ply(self.folder / "unread.ply", points, intensities=[i % 256 for i in range(600)], intensity_type="uchar")
        self.assertEqual(self.call("grey.ply", "unread.ply"), 0, self.text)
        vertices, _ = read_ply(self.folder / "grey_shrink_wrap.ply")
        self.assertEqual({v["red"] - v["blue"] for v in vertices}, {0})
        self.assertLess(max(abs(v["red"] - i % 256) for i, v in enumerate(vertices)), 2)
        self.assertNotIn("red", read_ply(self.folder / "unread_shrink_wrap.ply")[0][0])
        for colour_name, quality_name in (("", "quality"), ("diffuse_", "confidence")):
            with self.subTest(quality_name=quality_name):
                write_ply(self.folder / "a.ply", points, colours=[(i % 256, 3, 7) for i in range(600)],
                          qualities=qualities, colour_name=colour_name, quality_name=quality_name)
                self.assertEqual(self.call("a.ply"), 0, self.text)
                vertices, _ = read_ply(self.folder / "a_shrink_wrap.ply")
                self.assertEqual([(v["red"], v["quality"]) for v in vertices],
                                 [(i % 256, q) for i, q in enumerate(qualities)])

    def test_colours_and_qualities_of_other_formats(self):
        """As far as MeshLab reads them; a cloud without any gets none."""
        points = sphere(600)
        lines = [" ".join(map(repr, p)) for p in points]
        files = {
            "a.obj": ([f"v {line} 0.8 0.4 0.2" for line in lines], 204, None),
            "b.obj": ([f"v {line}" for line in lines], None, None),
            "c.off": (["# a comment", "COFF", "600 0 0"] + [f"{line} 200 100 50 255" for line in lines], 200, None),
            "d.off": (["OFF", "600 0 0"] + lines, None, None),
            "e.asc": ([f"{line} 7" for line in lines], None, 7.0),
            "f.asc": (lines, None, None),
            "g.xyz": (lines, None, None),
            "h.ptx": (["30", "20", "0 0 0", "1 0 0", "0 1 0", "0 0 1", "1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"] +
                      [f"{line} 0.5 200 100 50" for line in lines], 200, 0.5),
        }
        for name, (content, _, _) in files.items():
            (self.folder / name).write_text("\n".join(content) + "\n")
        self.assertEqual(self.call(*files), 0, self.text)
        for name, (_, red, quality) in files.items():
            with self.subTest(name=name):
                vertices, _ = read_ply(self.folder / f"{name[0]}_shrink_wrap.ply")
                self.assertEqual({(v.get("red"), v.get("quality")) for v in vertices}, {(red, quality)})

    def test_colours_of_faces_are_not_those_of_points(self):
        header = ["ply", "format ascii 1.0", "element vertex 600", *(f"property float {axis}" for axis in "xyz"),
                  "element face 0", "property list uchar int vertex_indices",
                  *(f"property uchar {channel}" for channel in ("red", "green", "blue")), "end_header"]
        lines = header + [" ".join(map(repr, p)) for p in sphere(600)]
        (self.folder / "a.ply").write_text("\n".join(lines) + "\n")
        self.assertEqual(self.call("a.ply"), 0, self.text)
        vertices, _ = read_ply(self.folder / "a_shrink_wrap.ply")
        self.assertEqual(set(vertices[0]), {"x", "y", "z"})

    def test_faces_that_span_openings_are_told_by_their_quality(self):
        self.cloud("a.ply", sphere(2000, keep=lambda p: p[2] < 0.3))
        self.assertEqual(self.call("a.ply"), 0, self.text)
        _, faces, qualities = read_ply_with_face_qualities(self.folder / "a_shrink_wrap.ply")
        self.assertEqual(len(qualities), len(faces))
        spanning = sum(quality > 0.0 for quality in qualities)
        self.assertGreater(spanning, 10)
        self.assertLess(spanning, len(faces) / 4)

    def test_any_parameter_can_be_set(self):
        """By name or number of a choice; the last of several settings counts."""
        self.cloud("a.ply", sphere(2000, keep=lambda p: p[2] < 0.3))
        for openings in ("Leave open", "1"):
            self.assertEqual(self.call("a.ply", "--set", "Openings=Automatic", "--set", f"Openings={openings}"), 0, self.text)
            self.assertIn("open (1 border)", self.text)
        self.assertEqual(self.call("a.ply", "--set", "Openings=Automatic", "--set", "WidestOpening=1e3"), 0, self.text)
        self.assertIn("closed 2-manifold", self.text)
        self.assertEqual(self.call("a.ply", "--set", "StopAtParametricSurface=true"), 0, self.text)
        self.assertNotIn("complete matching", self.text)
        self.assertEqual(self.call("a.ply", "--set", "Neighbours=5"), 1, self.text)
        self.assertIn("Neighbours", self.text[self.text.index("FAILED: "):])

    def test_parameters_are_listed(self):
        self.assertEqual(self.call("--set", "help"), 0, self.text)
        self.assertIn("Openings  Enum  0   0: Close  1: Leave open  2: Automatic\n", self.text)
        self.assertEqual(len(self.text.splitlines()), 14)

    def test_inputs_that_cannot_be_read(self):
        (self.folder / "empty.ply").touch()
        (self.folder / "garbage.ply").write_bytes(bytes(range(256)) * 10)
        (self.folder / "cloud.unknown").write_text("1 2 3\n")
        (self.folder / "nameless").write_text("1 2 3\n")
        for name in ("missing.ply", "empty.ply", "garbage.ply", "cloud.unknown", "nameless"):
            with self.subTest(name=name):
                self.assertEqual(self.call(name), 1, self.text)
                self.assertIn("FAILED: ", self.text)
        self.assertEqual(list(self.folder.glob("*_shrink_wrap*")), [])

    def test_text_files_that_are_not_read_as_they_are_meant(self):
        rows = [" ".join(map(str, p)) for p in sphere(600)]
        for name, lines, told in (("head.xyz", ["X Y Z", *rows], "line 1 (X Y Z) is no point"),
                                  ("tail.xyz", [*rows, "info by scanner"], "line 601 (info by scanner) is no point"),
                                  ("seven.pts", [f"{row} 5 1 2 3" for row in rows], "it takes lines of 3 numbers")):
            with self.subTest(name=name):
                (self.folder / name).write_text("\n".join(lines) + "\n")
                self.assertEqual(self.call(name), 1, self.text)
                self.assertIn(told, self.text)
        self.assertEqual(list(self.folder.glob("*_shrink_wrap*")), [])
        (self.folder / "good.xyz").write_text("\n".join(["# X Y Z", "600", *rows, "nan nan nan"]) + "\n")
        self.assertEqual(self.call("good.xyz"), 0, self.text)
        self.assertIn("600 of 600 samples matched", self.text)

    def test_what_a_folder_holds_besides_is_told(self):
        self.cloud("a.ply", sphere(600))
        (self.folder / "notes.txt").write_text("of no interest")
        self.assertEqual(self.call(".", "-o", "made for this/"), 0, self.text)
        self.assertIn(".: 1 left alone", self.text)
        self.assertTrue((self.folder / "made for this" / "a_shrink_wrap.ply").exists())
        self.assertEqual(self.call("a.ply", "-o", "other/"), 0, self.text)
        self.assertTrue((self.folder / "other" / "a_shrink_wrap.ply").exists())

    def test_a_reader_that_leaves_ends_it_all(self):
        """Nothing is left in the folder of temporary files."""
        temporary = self.folder / "temporary"
        temporary.mkdir()
        for name in ("a", "b", "c"):
            self.cloud(f"{name}.ply", sphere(600))
        process = self.start("a.ply", "b.ply", "c.ply", TMPDIR=str(temporary))
        process.stdout.readline()
        process.stdout.close()
        self.assertEqual(process.wait(timeout=120), 130)
        self.assertEqual(list(temporary.iterdir()), [])

    def test_outputs_that_cannot_be_written(self):
        cloud = self.cloud("a.ply", sphere(600))
        before = cloud.read_bytes()
        for output in ("no folder/mesh.ply", "mesh.unknown", "mesh.xyz", "mesh", "a.ply", "./a.ply"):
            with self.subTest(output=output):
                self.assertEqual(self.call("a.ply", "-o", output), 1, self.text)
                self.assertEqual(cloud.read_bytes(), before)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["a.ply"])

    def test_half_a_mesh_is_none(self):
        """A disk that is full is not taken for success, though the host ends as if nothing was wrong."""
        self.cloud("a.ply", sphere(6000))
        path = self.path_with("xvfb-run", f"""trap '' XFSZ\nulimit -f 128\nexec '{shutil.which("xvfb-run")}' "$@\"""")
        self.assertEqual(self.call("a.ply", PATH=path), 1, self.text)
        self.assertIn("FAILED: MeshLab could not write the whole mesh", self.text)
        self.assertFalse((self.folder / "a_shrink_wrap.ply").exists())

    def test_a_mesh_after_which_nothing_can_be_written_is_not_trusted(self):
        self.cloud("a.ply", sphere(600))
        path = self.path_with("head", "exit 1")  # what tries whether there is room
        self.assertEqual(self.call("a.ply", PATH=path), 1, self.text)
        self.assertIn("FAILED: MeshLab could not write the whole mesh", self.text)
        self.assertFalse((self.folder / "a_shrink_wrap.ply").exists())

    def test_two_inputs_of_one_name_to_one_folder(self):
        for name in ("one", "two"):
            (self.folder / name).mkdir()
            self.cloud(f"{name}/a.ply", sphere(600))
        self.assertEqual(self.call("one/a.ply", "two/a.ply", "-o", "out"), 1, self.text)
        self.assertIn("1 of 2 reconstructed", self.text)
        # Whatever way its folder is written.
        shutil.copy(self.folder / "one" / "a.ply", self.folder / "one" / "a.PLY")
        self.assertEqual(self.call("one/a.ply", "./one/../one/a.PLY"), 1, self.text)
        self.assertIn("1 of 2 reconstructed", self.text)
        self.assertIn("written to the same name", self.text)

    def test_wrong_calls(self):
        self.cloud("a.ply", sphere(600))
        for arguments, told in ((["--unknown"], "unknown option --unknown"), (["-o"], "-o needs a value"),
                                (["-o", ""], "-o needs a name"), (["-j", "0"], "-j needs 1 or more"),
                                (["-j", "many"], "-j needs a whole number"), (["--threads", "x"], "--threads needs a whole number"),
                                (["--threads", "99999999999"], "Threads needs a whole number"),
                                (["--time-limit", "-1"], "--time-limit needs a whole number")):
            with self.subTest(arguments=arguments):
                self.assertEqual(self.call("a.ply", *arguments), 1, self.text)
                self.assertIn(told, self.text)

    def test_wrong_settings(self):
        for setting, told in (("Opening=1", "no parameter 'Opening'"), ("openings=1", "no parameter 'openings'"),
                              (".*=1", "no parameter '.*'"), ("Openings", "NAME=VALUE"), ("=1", "NAME=VALUE"),
                              ("Openings=3", "one of its choices"), ("Openings=", "one of its choices"),
                              ("ExcludeOutliers=no", "true or false"), ("Neighbours=1.5", "a whole number"),
                              ("MaximumGenus=99999999999", "a whole number"), ("VoxelSize=1,5", "a number"),
                              ("VoxelSize=1\n2", "a number"), ("KeepStages=true", "MeshLab's window"),
                              ('VoxelSize=1"/>', "a number")):
            with self.subTest(setting=setting):
                self.assertEqual(self.call("--set", setting), 1, self.text)
                self.assertIn(told, self.text)


class SetUp(ScriptTest):
    """What the script asks of CMake and of the system, without a build."""

    def setUp(self):
        super().setUp()
        self.programs = self.folder / "programs"
        self.programs.mkdir()
        for folder in ("/usr/bin", "/bin"):
            for program in pathlib.Path(folder).iterdir():
                link = self.programs / program.name
                if program.name not in ("meshlabserver", "cmake") and not link.is_symlink():
                    link.symlink_to(program)
        self.build = self.folder / "build"
        self.calls = self.folder / "calls"

    def program(self, name, text):
        path = self.programs / name
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)

    def cmake_calls(self, on_build):
        """The calls of CMake, whose builds do as they are told."""
        self.program("meshlabserver", "")
        self.program("cmake", f'echo "$@" >>"{self.calls}"\ncase $1 in --build) {on_build} ;; esac\n')
        self.calls.unlink(missing_ok=True)
        self.assertEqual(self.call("a.ply", PATH=str(self.programs), SHRINKWRAP_BUILD_DIR=str(self.build)), 1, self.text)
        return self.calls.read_text().splitlines()

    def test_a_host_without_meshlabserver_is_told_at_once(self):
        self.program("cmake", f'echo "$@" >>"{self.calls}"\n')
        self.assertEqual(self.call("a.ply", PATH=str(self.programs), SHRINKWRAP_BUILD_DIR=str(self.build)), 1, self.text)
        self.assertIn("has no meshlabserver", self.text)
        self.assertEqual(len(self.text.splitlines()), 1, self.text)
        self.assertFalse(self.calls.exists() or self.build.exists())

    def test_warnings_do_not_stop_a_first_build(self):
        calls = self.cmake_calls("exit 0")
        self.assertIn("-DSHRINKWRAP_WARNINGS_AS_ERRORS=OFF", calls[0])
        self.assertIn("-DSHRINKWRAP_BUILD_TESTS=OFF", calls[0])
        self.assertEqual(len(calls), 2)

    def test_a_build_folder_keeps_its_choices(self):
        """Unless a warning stopped the compiler; nothing else makes it compile again."""
        self.build.mkdir()
        (self.build / "CMakeCache.txt").touch()
        calls = self.cmake_calls("exit 0")
        self.assertEqual(len(calls), 2)
        self.assertNotIn("SHRINKWRAP_WARNINGS_AS_ERRORS", calls[0])
        self.assertNotIn("SHRINKWRAP_BUILD_TESTS", calls[0])
        calls = self.cmake_calls("echo 'a.cpp:1: error: unused [-Werror=unused]'; exit 1")
        self.assertEqual(["-DSHRINKWRAP_WARNINGS_AS_ERRORS=OFF" in call for call in calls], [False, False, True, False])
        calls = self.cmake_calls("echo 'a.cpp:1: error: wrong'; exit 1")
        self.assertEqual(len(calls), 2)
        self.assertIn("a.cpp:1: error: wrong", self.text)


if __name__ == "__main__":
    ROOT, BUILD, CHECKER = pathlib.Path(sys.argv[1]), *sys.argv[2:4]
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
