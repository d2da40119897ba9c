"""script_parameters_test.py ROOT DECLARED_PARAMETERS PLUGIN: every script in the tree lists every parameter of every filter
of ours that it runs, in the order in which the plugin declares them (meshlabserver aborts on any other), with a value of
the declared type."""

import pathlib
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ElementTree

ROOT, PROGRAM, PLUGIN = None, None, None


def declared():
    done = subprocess.run([PROGRAM, PLUGIN], capture_output=True, check=True)
    filters = {}
    for line in done.stdout.decode().splitlines():
        name, kind, parameter, _ = line.split("\t")
        filters.setdefault(name, []).append((kind, parameter))
    return filters


def declared_defaults():
    done = subprocess.run([PROGRAM, PLUGIN], capture_output=True, check=True)
    filters = {}
    for line in done.stdout.decode().splitlines():
        name, kind, parameter, value = line.split("\t")
        if kind == "RichBool":
            value = value.capitalize()
        elif kind == "RichMesh":
            value = "the current layer"
        else:
            value = float(value)
        filters.setdefault(name, []).append((parameter.lower(), value))
    return filters


def documented_defaults():
    """What docs/pymeshlab.md says: for every filter its parameters, by Python name, and their defaults."""
    filters = {}
    for line in (ROOT / "docs" / "pymeshlab.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            rows = filters.setdefault(line[3:], [])
        elif line.startswith("| `"):
            name, _, value = (cell.strip() for cell in line.strip("|").split("|"))
            try:
                value = float(value)
            except ValueError:
                pass
            rows.append((name.strip("`"), value))
    return filters


class ScriptParameters(unittest.TestCase):
    def test_scripts_match_the_plugin(self):
        filters = declared()
        self.assertEqual(len(filters), 8)
        scripts = [path for path in ROOT.rglob("*.mlx") if "build" not in path.relative_to(ROOT).parts[0]]
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

    def test_table_of_python_names_matches_the_plugin(self):
        self.assertEqual(documented_defaults(), declared_defaults())

    def test_defaults_of_the_reconstruction_script(self):
        done = subprocess.run([PROGRAM, PLUGIN, "--script"], capture_output=True, check=True)
        expected = ElementTree.fromstring(done.stdout.decode()).find("filter")
        actual = ElementTree.parse(ROOT / "sample_clouds" / "reconstruct.mlx").getroot().find("filter")
        self.assertEqual([p.attrib for p in actual], [p.attrib for p in expected])


if __name__ == "__main__":
    ROOT, PROGRAM, PLUGIN = pathlib.Path(sys.argv[1]), *sys.argv[2:4]
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
