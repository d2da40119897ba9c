"""script_parameters_test.py ROOT DECLARED_PARAMETERS PLUGIN [SERVER]: every script in the tree lists every parameter of every filter
of ours that it runs, in the order in which the plugin declares them (meshlabserver aborts on any other), with a value of
the declared type; and docs/pymeshlab.md lists the functions and parameters that Python sees. With a meshlabserver: what
the host's script dialog saves replays there."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

from host_runs import ONE_SHOT, Run, script, torus, write_ply

ROOT, PROGRAM, PLUGIN, SERVER = None, None, None, None


def declared():
    done = subprocess.run([PROGRAM, PLUGIN], capture_output=True, check=True)
    filters = {}
    for line in done.stdout.decode().splitlines():
        name, kind, parameter, _ = line.split("\t")
        filters.setdefault(name, []).append((kind, parameter))
    return filters


class ScriptParameters(unittest.TestCase):
    def test_scripts_match_the_plugin(self):
        filters = declared()
        self.assertEqual(len(filters), 8)
        folders = [folder for folder in ROOT.iterdir() if folder.is_dir() and "build" not in folder.name]
        scripts = [path for folder in folders for path in folder.rglob("*.mlx")]
        self.assertGreaterEqual(len(scripts), 2)
        used = set()
        for path in scripts:
            for step in ElementTree.parse(path).getroot():
                name = step.get("name")
                if "Shrink Wrap" not in name:
                    continue
                used.add(name)
                with self.subTest(script=str(path.relative_to(ROOT)), filter=name):
                    self.assertIn(name, filters)
                    self.assertEqual([(p.get("type"), p.get("name")) for p in step], filters[name])
        self.assertEqual(used, set(filters), "a filter of ours that no script runs")

    def test_table_of_python_names_is_the_generated_one(self):
        """Names, types and defaults of docs/pymeshlab.md; a newer host's own are compared by tests/newer_meshlab/run.sh."""
        document = (ROOT / "docs" / "pymeshlab.md").read_text(encoding="utf-8")
        documented = document.split("<!-- generated", 1)[1].split("\n", 1)[1]
        done = subprocess.run([PROGRAM, "--python"], capture_output=True, check=True)
        self.maxDiff = None
        self.assertEqual(documented.splitlines(), done.stdout.decode().splitlines())

    def test_functions_that_the_documents_call_exist(self):
        done = subprocess.run([PROGRAM, "--python"], capture_output=True, check=True)
        functions = set(re.findall(r"^`(\w+)`$", done.stdout.decode(), re.MULTILINE))
        self.assertEqual(len(functions), 8)
        for path in ("README.md", "docs/pymeshlab.md"):
            called = set(re.findall(r"\b\w*shrink_wrap\w*(?=\()", (ROOT / path).read_text(encoding="utf-8")))
            self.assertLessEqual(called, functions, path)

    def test_defaults_of_the_reconstruction_script(self):
        done = subprocess.run([PROGRAM, PLUGIN, "--script"], capture_output=True, check=True)
        expected = ElementTree.fromstring(done.stdout.decode()).find("filter")
        actual = ElementTree.parse(ROOT / "sample_clouds" / "reconstruct.mlx").getroot().find("filter")
        self.assertEqual([p.attrib for p in actual], [p.attrib for p in expected])


class SavedScripts(unittest.TestCase):
    """Saved by the host's own code, as its script dialog does, with labels and help texts in it."""

    def setUp(self):
        if not SERVER:
            self.skipTest("no meshlabserver")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.cloud, self.saved = self.folder / "cloud.ply", self.folder / "saved.mlx"
        write_ply(self.cloud, torus(2000))
        subprocess.run([PROGRAM, PLUGIN, "--save", self.saved], check=True)

    def run_script(self, path, *outputs):
        run = Run(SERVER, self.folder, path, [self.cloud], outputs)
        self.assertEqual(run.code, 0, run.text)
        self.assertNotIn("Shrink Wrap failed: ", run.log)
        return run

    def test_every_filter_replays(self):
        steps = ElementTree.parse(self.saved).getroot().findall("filter")
        self.assertEqual([step.get("name") for step in steps], list(declared()))
        self.assertIn("tooltip", steps[0][0].attrib)
        run = self.run_script(self.saved)
        for step in steps:
            self.assertIn("filter: " + step.get("name"), run.log)

    def test_changed_values_are_those_of_the_replay(self):
        changed, plain = self.folder / "changed.mlx", self.folder / "plain.mlx"
        tree = ElementTree.parse(self.saved)
        for step in tree.getroot().findall("filter")[1:]:
            tree.getroot().remove(step)
        tree.write(changed)
        script(changed, changed, ("StopAtParametricSurface", "true"), ("Neighbours", 12))
        script(plain, ONE_SHOT, ("StopAtParametricSurface", "true"), ("Neighbours", 12))
        results = [self.folder / "replayed.ply", self.folder / "plain.ply", self.folder / "defaults.ply"]
        for path, result in zip((changed, plain, ONE_SHOT), results):
            self.run_script(path, ("c", result))
        replayed, expected, defaults = (result.read_bytes() for result in results)
        self.assertEqual(replayed, expected)
        self.assertNotEqual(replayed, defaults)


if __name__ == "__main__":
    ROOT, PROGRAM, PLUGIN, SERVER = pathlib.Path(sys.argv[1]), *sys.argv[2:4], (sys.argv[4:] or [None])[0]
    unittest.main(argv=sys.argv[:1] + sys.argv[5:])
