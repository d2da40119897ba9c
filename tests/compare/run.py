"""Reconstructs the same clouds with MeshLab's own filters and with ours, in the same meshlabserver, and measures every
result with MeshLab's own measuring filters and our report. Writes a page of tables and pictures."""

import argparse
import datetime
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests" / "meshlabserver"))

import measures  # noqa: E402
import page  # noqa: E402
from host_runs import ONE_SHOT, Run, script  # noqa: E402

BENCHMARK_SCRIPTS = ROOT / "tests" / "benchmark" / "scripts"
SHAPE_OF_CLOUD = {"ball_joint_34267": "ball_joint"}  # the sample clouds whose surface is known
NOISY_CLOUD, NOISES = "ball_joint_34267", (0.5, 1.0)  # x spacing
# Threads that spin while they wait make Screened Poisson several times slower on a busy machine.
ENVIRONMENT = {"OMP_WAIT_POLICY": "passive"}


def arguments():
    parser = argparse.ArgumentParser(prog="run.sh", description=__doc__)
    parser.add_argument("clouds", nargs="*", type=pathlib.Path, metavar="CLOUD",
                        help="point clouds in any format that MeshLab reads; none: the sample clouds, and one of them with noise")
    parser.add_argument("--truth", type=pathlib.Path, metavar="MESH", help="the true surface of the clouds given")
    parser.add_argument("--noise", type=float, metavar="D",
                        help="move every point at random: standard deviation of a coordinate, x median spacing (PLY clouds)")
    parser.add_argument("--seed", type=int, default=1, help="of the noise (1)")
    parser.add_argument("--output", type=pathlib.Path, default=HERE / "results", metavar="FOLDER", help="(tests/compare/results)")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help=argparse.SUPPRESS)
    parser.add_argument("--renderer", help=argparse.SUPPRESS)  # a Python that has VTK
    parser.add_argument("--time-limit", type=float, default=300.0, metavar="S", help="seconds for one run (300)")
    parser.add_argument("--runs", type=int, default=3, help="at most, of which the quickest counts (3; fewer where they are long)")
    parser.add_argument("--method", action="append", metavar="NAME", help="only this method; may be given several times")
    parser.add_argument("--no-pictures", action="store_true")
    options = parser.parse_args()
    if options.truth and not options.clouds:
        parser.error("--truth is the surface of clouds that are named")
    for path in [*options.clouds, *([options.truth] if options.truth else [])]:
        if not path.is_file():
            parser.error(f"there is no file {path}")
    names = [plain(path.stem) for path in options.clouds]
    for name in names:
        if names.count(name) > 1:
            parser.error(f"several clouds are named {name}, and so would be their meshes: rename all but one")
    return options


class Tools:
    """What makes clouds with noise and true surfaces; built with the tests."""

    def __init__(self, build, folder):
        self.programs, self.folder = build / "tests" / "compare", folder

    def noisy(self, cloud, deviation, seed):
        output = self.folder / f"{cloud.stem}_noise_{deviation:g}.ply"
        self.run("add_noise", cloud, f"{deviation:g}", seed, output)
        return output

    def truth(self, shape):
        output = self.folder / f"{shape}_truth.ply"
        if not output.exists():
            self.run("make_truth", shape, output)
        return output

    def run(self, program, *words):
        done = subprocess.run([str(self.programs / program), *map(str, words)], capture_output=True, check=False)
        if done.returncode != 0:
            sys.exit(f"run.py: {done.stderr.decode(errors='replace').strip()}")


def cases_of(options, tools):
    """What is compared: {name, cloud, truth, noise}."""
    cases = []

    def add(cloud, truth, noise):
        shape = SHAPE_OF_CLOUD.get(cloud.stem) if cloud.resolve().parent == ROOT / "sample_clouds" else None
        cases.append({"name": cloud.stem + (f" with noise of {noise:g} spacing" if noise else ""),
                      "cloud": tools.noisy(cloud, noise, options.seed) if noise else cloud,
                      "truth": truth or (tools.truth(shape) if shape else None), "noise": noise})

    for cloud in options.clouds:
        add(cloud, options.truth, options.noise)
    if not options.clouds:
        for cloud in sorted((ROOT / "sample_clouds").glob("*.ply")):
            add(cloud, None, options.noise)
        if not options.noise:
            for noise in NOISES:
                add(ROOT / "sample_clouds" / f"{NOISY_CLOUD}.ply", None, noise)
    return cases


def methods_of(samples, folder):
    """(name, script) of what is compared, all with the defaults of MeshLab's dialogs, save that Poisson's octree may have
    nodes as small as the spacing."""
    depth = max(8, (samples - 1).bit_length() // 2)
    poisson = BENCHMARK_SCRIPTS / "screened_poisson.mlx"
    return [
        ("Ball Pivoting", script(folder / "ball_pivoting.mlx", BENCHMARK_SCRIPTS / "ball_pivoting.mlx", ("DeleteFaces", "true"))),
        ("Screened Poisson", script(folder / "poisson.mlx", poisson, ("depth", depth))),
        ("Screened Poisson, for noise", script(folder / "poisson_for_noise.mlx", poisson, ("depth", depth), ("K", 30),
                                               ("samplesPerNode", 15))),
        ("Shrink Wrap", ONE_SHOT),
        ("Shrink Wrap, parametric surface", script(folder / "parametric_surface.mlx", ONE_SHOT,
                                                   ("StopAtParametricSurface", "true"))),
    ]


class Comparison:
    """Runs on one cloud, in a folder with plain names, which any host copes with."""

    def __init__(self, options, case, folder):
        self.options, self.folder = options, folder
        self.server = options.build / "stage" / "bin" / "meshlabserver"
        self.cloud = self.linked(case["cloud"], "cloud")
        self.truth = self.linked(case["truth"], "truth") if case["truth"] else None

    def linked(self, path, name):
        link = self.folder / (name + path.suffix.lower())
        link.symlink_to(path.resolve())
        return link

    def host(self, script_file, inputs, outputs=()):
        return Run(self.server, self.folder, script_file, inputs, outputs, time_limit=self.options.time_limit,
                   environment=ENVIRONMENT)

    def quickest(self, *arguments):
        """Of several runs: what else the machine does can only add to the time."""
        runs = [self.host(*arguments)]
        while len(runs) < self.options.runs and runs[-1].code == 0 and sum(run.seconds for run in runs) < 5.0:
            runs.append(self.host(*arguments))
        return min(runs, key=lambda run: run.seconds)

    def nothing(self):
        """A run that does nothing but read and write: (number of points, run); what every other run is told less of."""
        run = self.quickest(BENCHMARK_SCRIPTS / "nothing.mlx", [self.cloud], [("c", self.folder / "nothing.ply")])
        return measures.first_number(r"loaded has (\d+) vn", run.log) if run.code == 0 else None, run

    def compare(self, name, script_file, nothing, kept):
        mesh = self.folder / "mesh.ply"
        mesh.unlink(missing_ok=True)
        run = self.quickest(script_file, [self.cloud], [("c", mesh)])
        row = {"method": name, "seconds": max(run.seconds - nothing.seconds, 0.0),
               "processor_seconds": max(run.processor_seconds - nothing.processor_seconds, 0.0)}
        if run.code != 0 or not mesh.exists():
            return {**row, "error": self.what_went_wrong(run)}
        measure = HERE / "scripts" / ("measure_with_truth.mlx" if self.truth else "measure.mlx")
        told = self.host(measure, [self.cloud, *([self.truth] if self.truth else []), mesh])
        figures = measures.measures(told.log) if told.code == 0 else None
        shutil.copyfile(mesh, kept)
        row["mesh"] = kept
        return {**row, **figures} if figures else {**row, "error": "its mesh cannot be measured: " + self.what_went_wrong(told)}

    def what_went_wrong(self, run):
        if run.code is None:
            return f"more than {self.options.time_limit:g} s"
        reasons = [line for line in run.log.splitlines() if line.startswith("Shrink Wrap failed: ")]
        if reasons:
            return reasons[-1]
        if run.code < 0:
            return f"MeshLab crashed (signal {-run.code})"
        return f"MeshLab failed (exit {run.code})" if run.code else "nothing written"


def plain(name):
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name)


def compare(options, case):
    """Rows of one cloud."""
    print(case["name"], file=sys.stderr, flush=True)
    meshes = options.output / "meshes" / plain(case["name"])
    meshes.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        comparison = Comparison(options, case, folder)
        points, nothing = comparison.nothing()
        if not points:
            return {"error": "MeshLab cannot read it, or it has no points"}
        rows = []
        for name, script_file in methods_of(points, folder):
            if options.method and name not in options.method:
                continue
            rows.append({"points": points, **comparison.compare(name, script_file, nothing, meshes / f"{plain(name)}.ply")})
            print(f"  {name}: {page.verdict(rows[-1])}", file=sys.stderr, flush=True)
        shutil.copyfile(folder / "nothing.ply", meshes / "points.ply")
    return {"points": points, "rows": rows, "cloud_copy": meshes / "points.ply"}


def picture(options, case, result):
    """The cloud and all meshes in the same view; True if it was made."""
    output = options.output / "pictures" / f"{plain(case['name'])}.png"
    output.parent.mkdir(exist_ok=True)
    output.unlink(missing_ok=True)
    items = [f"{result['cloud_copy']}=samples"]
    items += [f"{row['mesh']}={row['method']}" for row in result["rows"] if "mesh" in row]
    done = subprocess.run(["xvfb-run", "-a", options.renderer or sys.executable, str(ROOT / "docs" / "render.py"), str(output),
                           "--view", "principal", "--outside", "--columns", "3", "--size", "400,400", *items],
                          capture_output=True, check=False, env=dict(os.environ, LIBGL_ALWAYS_SOFTWARE="1"))
    if done.returncode != 0 or not output.exists():
        print(f"run.py: no picture: {done.stderr.decode(errors='replace').strip()[-300:]}", file=sys.stderr)
        return False
    result["picture"] = output
    return True


def has_vtk(python):
    try:
        return subprocess.run([python, "-c", "import vtk"], capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def complaints(results):
    """What must hold of our own rows, whatever the cloud, and of the measuring."""
    found = []
    for result in results:
        if "error" in result:
            found.append(f"{result['name']}: {result['error']}")
        for row in result.get("rows", []):
            if "error" not in row:
                found += [f"{result['name']}, {row['method']}: {text}" for text in measures.disagreements(row)]
            if row["method"] == "Shrink Wrap" and page.broken_promise(row):
                found.append(f"{result['name']}: {page.broken_promise(row)}")
    return found


def main():
    options = arguments()
    options.output, options.build = options.output.resolve(), options.build.resolve()
    options.output.mkdir(parents=True, exist_ok=True)
    results = []
    with tempfile.TemporaryDirectory() as scratch:
        for case in cases_of(options, Tools(options.build, pathlib.Path(scratch))):
            results.append({"name": case["name"], "noise": case["noise"], "has_truth": bool(case["truth"]), **compare(options, case)})
            if not options.no_pictures and "rows" in results[-1]:
                renderer = options.renderer or sys.executable
                if not has_vtk(renderer):
                    options.no_pictures = True
                    print("run.py: no pictures: the package python3-vtk9 is missing (apt-get install python3-vtk9)",
                          file=sys.stderr)
                else:
                    picture(options, case, results[-1])
            # After every cloud, so that a run that is stopped has not been in vain.
            date = datetime.date.today().isoformat()
            (options.output / "comparison.json").write_text(json.dumps(results, indent=1, default=str) + "\n", encoding="utf-8")
            (options.output / "comparison.md").write_text(page.markdown(results, date, options.output), encoding="utf-8")
            (options.output / "comparison.html").write_text(page.html(results, date, options.output), encoding="utf-8")
    for complaint in complaints(results):
        print(f"run.py: {complaint}", file=sys.stderr)
    print(f"written: comparison.html, comparison.md, comparison.json in {options.output}", file=sys.stderr)
    return 1 if complaints(results) else 0


if __name__ == "__main__":
    sys.exit(main())
