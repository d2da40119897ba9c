"""Measures the reconstruction against its yardsticks, over the number of samples.

Every run is one process that times itself (ours and CGAL's advancing front, without input and output) or a run of
meshlabserver (its time less that of an empty script). Ours and the advancing front alternate, and what is compared is
the median of the ratios of neighbouring runs, so that a machine that slows down or speeds up meanwhile does not count.
What is told of one program alone is the minimum of its runs: other load only ever adds to it.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time

import tables

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SIZES = [10_000, 34_000, 100_000, 300_000, 1_000_000]
FULL_SIZES = [*SIZES, 3_000_000, 10_000_000]
QUICK_SIZES = [1_000, 3_000]
CLOUDS = ["blob", "torus", "golf_club_head_12321"]
LARGEST_IN_MESHLAB = 1_000_000
LEAST_IN_MESHLAB = 0.05  # seconds: less cannot be told from an empty run
CANCEL_FRACTIONS = [0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.97]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="folder of the build")
    parser.add_argument("--output", type=pathlib.Path, default=HERE / "results", help="folder of the results")
    extent = parser.add_mutually_exclusive_group()
    extent.add_argument("--full", action="store_true", help="go on to 3 and 10 million samples")
    extent.add_argument("--quick", action="store_true",
                        help="a few seconds, to see that it works: small clouds, once, not in MeshLab")
    parser.add_argument("--sizes", type=int, nargs="+", help="numbers of samples")
    parser.add_argument("--clouds", nargs="+", default=CLOUDS, help="shapes, or names of sample clouds to resample")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--pairs", type=int, help="runs of each program, at most; usually 5, from 300,000 samples 3, from 3,000,000 1")
    parser.add_argument("--time-limit", type=float, default=900.0, help="seconds for one run")
    parser.add_argument("--no-meshlab", action="store_true", help="leave out what runs in MeshLab")
    parser.add_argument("--no-cancel", action="store_true", help="leave out how soon a run ends when it is cancelled")
    options = parser.parse_args()
    if options.quick:
        options.sizes = options.sizes or QUICK_SIZES
        options.pairs = options.pairs or 1
        options.no_meshlab = True
    return options


class Clouds:
    """PLY files of the clouds, made once and kept."""

    def __init__(self, programs, folder, time_limit):
        self.program, self.folder, self.time_limit = programs / "make_cloud", folder, time_limit
        folder.mkdir(parents=True, exist_ok=True)

    def file(self, name, samples):
        path = self.folder / f"{name}_{samples}.ply"
        if not path.exists():
            source = ROOT / "sample_clouds" / f"{name}.ply"
            origin = ["--cloud", str(source)] if source.exists() else ["--shape", name]
            partial = path.with_suffix(".partial")
            subprocess.run([self.program, *origin, "--samples", str(samples), partial], check=True, timeout=self.time_limit)
            partial.rename(path)
        return path


def run_program(command, time_limit):
    """The line of JSON that a measuring program prints, or None if it took too long or broke."""
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, timeout=time_limit, check=False, text=True)
    except subprocess.TimeoutExpired:
        return {"error": f"more than {time_limit:.0f} s"}
    try:
        return json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        return {"error": f"exit code {done.returncode} {done.stderr.strip()[-200:]}"}


class MeshLab:
    """Runs of the same meshlabserver that has our plugin."""

    def __init__(self, build, time_limit):
        staged = build / "stage" / "bin" / "meshlabserver"
        self.server = staged if staged.exists() else pathlib.Path("/usr/bin/meshlabserver")
        self.time_limit = time_limit
        self.slow = set()  # (script, cloud) that hit the limit, or that would: larger clouds are not tried

    def available(self):
        return self.server.exists()

    def seconds(self, script, cloud):
        """(seconds, bytes) of one run without output, or None if it failed or took too long."""
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as home:
            process = subprocess.Popen(
                ["xvfb-run", "-a", str(self.server), "-i", str(cloud), "-s", str(script)],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=home,
                # OpenMP threads that spin while they wait make Screened Poisson several times slower on a busy machine.
                env=dict(os.environ, HOME=home, OMP_WAIT_POLICY="passive"), start_new_session=True)
            while True:
                waited, status, usage = os.wait4(process.pid, os.WNOHANG)
                if waited:
                    process.returncode = os.waitstatus_to_exitcode(status)
                    break
                if time.monotonic() - begin > self.time_limit:
                    os.killpg(process.pid, signal.SIGKILL)
                    _, status, usage = os.wait4(process.pid, 0)
                    process.returncode = -signal.SIGKILL
                    break
                time.sleep(0.005)
        if process.returncode != 0:
            return None
        return time.monotonic() - begin, usage.ru_maxrss * 1024

    def measure(self, name, script, cloud_name, cloud, repeats):
        if (name, cloud_name) in self.slow:
            return None
        runs = []
        for _ in range(repeats):
            nothing, run = self.seconds(HERE / "scripts" / "nothing.mlx", cloud), self.seconds(script, cloud)
            if run is None or nothing is None:
                self.slow.add((name, cloud_name))
                return None
            runs.append((run[0] - nothing[0], run[1] - nothing[1]))
        if 2.0 * max(run[0] for run in runs) > self.time_limit:
            self.slow.add((name, cloud_name))
        seconds = min(run[0] for run in runs)
        return {"program": name, "seconds": seconds if seconds >= LEAST_IN_MESHLAB else None, "peak_bytes": max(0, min(run[1] for run in runs))}


def poisson_script(samples, folder):
    """Screened Poisson with nodes about as large as the spacing of the samples."""
    depth = max(8, (samples - 1).bit_length() // 2)
    text = (HERE / "scripts" / "screened_poisson.mlx").read_text()
    path = folder / f"screened_poisson_{depth}.mlx"
    path.write_text(re.sub(r'name="depth" value="\d+"', f'name="depth" value="{depth}"', text))
    return path


def repeats_for(samples, options):
    usual = 1 if samples >= 3_000_000 else 3 if samples >= 300_000 else 5
    return min(usual, options.pairs) if options.pairs else usual


def would_take_too_long(row, samples, options):
    """Whether the advancing front, which took what `row` says, is sure to pass the time limit with more samples."""
    if row is None or not row["advancing_front"]:
        return False
    if any("error" in front for front in row["advancing_front"]):
        return True
    fastest = min(front["seconds"] for front in row["advancing_front"])
    return fastest * samples / row["samples"] > options.time_limit


def measure_pairs(programs, cloud, samples, options, smaller):
    """Ours for each number of threads, with the advancing front between them: the runs, and the ratios of neighbours."""
    ours = {threads: [] for threads in options.threads}
    fronts, ratios = [], {threads: [] for threads in options.threads}
    front_program = programs / "advancing_front"
    with_front = front_program.exists() and not would_take_too_long(smaller, samples, options)
    for _ in range(repeats_for(samples, options)):
        front = {"error": "not run"}
        for place, threads in enumerate(options.threads):
            run = run_program([programs / "stage_benchmark", "--cloud", cloud, "--threads", threads, "--progress"],
                              options.time_limit)
            ours[threads].append(run)
            if with_front and place == 0:
                front = run_program([front_program, "--cloud", cloud], options.time_limit)
                fronts.append(front)
            if "error" not in run and "error" not in front:
                ratios[threads].append(run["seconds"] / front["seconds"])
    return ours, fronts, ratios


def measure_cancel(programs, cloud, options):
    """Seconds from the callback's `false` to the end of the run, per fraction at which it came; None if it came too late,
    what went wrong if something did."""
    seconds = {}
    for fraction in CANCEL_FRACTIONS:
        run = run_program([programs / "stage_benchmark", "--cloud", cloud, "--cancel-at", fraction], options.time_limit)
        seconds[fraction] = run.get("cancelled_after_seconds", run.get("error"))
    return seconds


def machine():
    """The machine in general terms."""
    cpu = "unknown processor"
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            cpu = re.sub(r"\s+", " ", line.split(":", 1)[1]).strip()
            break
    memory = 0
    for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemTotal:"):
            memory = round(int(line.split()[1]) / 2**20)
    return f"{os.cpu_count()} cores ({cpu}), {memory} GiB"


def main():
    options = arguments()
    programs = options.build / "tests" / "benchmark"
    if not (programs / "stage_benchmark").exists():
        sys.exit("run.py: the programs are not built; sh tests/benchmark/run.sh builds them")
    options.output.mkdir(parents=True, exist_ok=True)
    clouds = Clouds(programs, options.build / "benchmark_clouds", 10 * options.time_limit)
    meshlab = MeshLab(options.build, options.time_limit)
    with_meshlab = meshlab.available() and not options.no_meshlab

    results = {"machine": machine(), "date": datetime.date.today().isoformat(), "load": [os.getloadavg()[0]],
               "threads": options.threads, "rows": []}
    with tempfile.TemporaryDirectory() as scratch:
        for cloud_name in options.clouds:
            row = None
            for samples in options.sizes or (FULL_SIZES if options.full else SIZES):
                print(f"{cloud_name}, {samples:,} samples", file=sys.stderr, flush=True)
                cloud = clouds.file(cloud_name, samples)
                ours, fronts, ratios = measure_pairs(programs, cloud, samples, options, row)
                row = {"cloud": cloud_name, "samples": samples, "ours": ours, "advancing_front": fronts,
                       "ratios": ratios, "meshlab": {}, "cancel": {}}
                if with_meshlab and samples <= LARGEST_IN_MESHLAB:
                    repeats = min(3, repeats_for(samples, options))
                    scripts = {"Shrink Wrap": ROOT / "sample_clouds" / "reconstruct.mlx",
                               "Ball Pivoting": HERE / "scripts" / "ball_pivoting.mlx",
                               "Screened Poisson": poisson_script(samples, pathlib.Path(scratch))}
                    for name, script in scripts.items():
                        row["meshlab"][name] = meshlab.measure(name, script, cloud_name, cloud, repeats)
                if not options.no_cancel and (300_000 <= samples <= 1_000_000 or options.quick):
                    row["cancel"] = measure_cancel(programs, cloud, options)
                results["rows"].append(row)
                results["load"].append(os.getloadavg()[0])
                # After every size, so that a run that is stopped has not been in vain.
                (options.output / "benchmark.json").write_text(json.dumps(results, indent=1) + "\n")
                (options.output / "benchmark.md").write_text(tables.markdown(results))
    results = json.loads((options.output / "benchmark.json").read_text())
    complaints = tables.complaints(results)
    for complaint in complaints:
        print(f"run.py: {complaint}", file=sys.stderr)
    if tables.plot(results, options.output / "benchmark.svg"):
        print(f"written: benchmark.md, benchmark.json, benchmark.svg in {options.output}", file=sys.stderr)
    else:
        print(f"written: benchmark.md, benchmark.json in {options.output} (no plot: python3-matplotlib is missing)",
              file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
