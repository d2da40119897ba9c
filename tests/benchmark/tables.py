"""The figures of run.py as tables and as a plot."""

import math
import statistics

PLAIN_FIT_FROM = 100_000  # smaller clouds fit the caches


def good(runs):
    return [run for run in runs if "error" not in run]


def least(runs, key):
    """The minimum of the runs: what else the machine does can only add to it."""
    return min((run[key] for run in good(runs) if run.get(key) is not None), default=None)


def by_threads(figures, threads):
    """Keys of a dict are numbers before, and strings after, a trip through JSON."""
    return figures.get(threads, figures.get(str(threads), []))


def exponent(points):
    """Slope of log(seconds) over log(samples), by least squares, from PLAIN_FIT_FROM samples on."""
    logs = [(math.log(n), math.log(t)) for n, t in points if t and t > 0 and n >= PLAIN_FIT_FROM]
    if len({x for x, _ in logs}) < 2:
        return None
    mean_x, mean_y = (statistics.mean(values) for values in zip(*logs))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)


def number(value, digits=3):
    """Three significant digits, without an exponent."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(places, 4)}f}"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "|".join(["---"] + ["---:"] * (len(header) - 1)) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def rows_by_cloud(results):
    clouds = {}
    for row in results["rows"]:
        clouds.setdefault(row["cloud"], []).append(row)
    return clouds


def verdict(run):
    if run is None:
        return "-"
    if "error" in run:
        return run["error"]
    faults = [text for key, text in (("closed", "not closed"), ("manifold", "not manifold"), ("matched", "not 1 to 1"))
              if not run.get(key)]
    return ", ".join(faults) or f"genus {run['genus']}, SI {run['self_intersecting_faces']}"


def totals_table(rows, threads):
    header = ["samples", *[f"ours, {t} thread{'s' if t > 1 else ''}" for t in threads], "advancing front",
              *[f"ratio, {t}" for t in threads], "Ball Pivoting", "Screened Poisson", "Shrink Wrap in MeshLab",
              "B/sample", "B/sample, advancing front", "same bytes", "result"]
    body = []
    for row in rows:
        ours = {t: by_threads(row["ours"], t) for t in threads}
        ratios = [by_threads(row["ratios"], t) for t in threads]
        peers = [row["meshlab"].get(name) for name in ("Ball Pivoting", "Screened Poisson", "Shrink Wrap")]
        runs = [run for t in threads for run in ours[t]]
        checksums = {run.get("checksum") for run in good(runs)}
        worst_memory = max((run["bytes_per_sample"] for run in good(runs)), default=None)
        body.append([f"{row['samples']:,}", *[number(least(ours[t], "seconds")) for t in threads],
                     number(least(row["advancing_front"], "seconds")),
                     *[number(statistics.median(r)) if r else "-" for r in ratios],
                     *[number(peer["seconds"]) if peer else "-" for peer in peers], number(worst_memory),
                     number(least(row["advancing_front"], "bytes_per_sample")),
                     "-" if not checksums else "yes" if len(checksums) == 1 else "NO", verdict(runs[0] if runs else None)])
    fits = [exponent([(row["samples"], least(by_threads(row["ours"], t), "seconds")) for row in rows]) for t in threads]
    front = exponent([(row["samples"], least(row["advancing_front"], "seconds")) for row in rows])
    peers = [exponent([(row["samples"], (row["meshlab"].get(name) or {}).get("seconds")) for row in rows])
             for name in ("Ball Pivoting", "Screened Poisson", "Shrink Wrap")]
    body.append(["exponent", *map(number, fits), number(front), *["" for _ in threads], *map(number, peers), "", "", "", ""])
    return table(header, body)


def stage_figures(rows, threads, key):
    """Stage name -> [least of the figure for each row]."""
    stages = {}
    for column, row in enumerate(rows):
        runs = good(by_threads(row["ours"], threads))
        for run in runs[:1]:
            for position, stage in enumerate(run["stages"]):
                values = [other["stages"][position][key] for other in runs]
                stages.setdefault(stage["name"], [None] * len(rows))[column] = min(values)
    return stages


def stages_table(rows, threads):
    sizes = [row["samples"] for row in rows]
    body = []
    for name, seconds in stage_figures(rows, threads, "seconds").items():
        body.append([name, *map(number, seconds), number(exponent(zip(sizes, seconds)))])
    totals = [least(by_threads(row["ours"], threads), "seconds") for row in rows]
    processor = [least(by_threads(row["ours"], threads), "processor_seconds") for row in rows]
    body.append(["**all**", *map(number, totals), number(exponent(zip(sizes, totals)))])
    body.append(["processor time", *map(number, processor), number(exponent(zip(sizes, processor)))])
    return table(["stage", *[f"{n:,}" for n in sizes], "exponent"], body)


def memory_table(rows, threads):
    body = []
    for name, peaks in stage_figures(rows, threads, "peak_bytes").items():
        body.append([name, *[number(p / row["samples"]) if p else "-" for p, row in zip(peaks, rows)]])
    return table(["stage", *[f"{row['samples']:,}" for row in rows]], body)


def response_table(rows, threads):
    body = []
    for row in rows:
        runs = [run for t in threads for run in good(by_threads(row["ours"], t)) if "progress" in run]
        if not runs:
            continue
        # Of the runs the one of the shortest silence: other load only adds. Of its stages the worst.
        silences = [max(run["stages"], key=lambda stage: stage["largest_gap_seconds"]) for run in runs]
        silence = min(silences, key=lambda stage: stage["largest_gap_seconds"])
        cancel = [seconds for seconds in row["cancel"].values() if isinstance(seconds, float)]
        body.append([f"{row['samples']:,}", "yes" if all(run["progress"]["monotone"] for run in runs) else "NO",
                     number(statistics.median(run["progress"]["calls_per_second"] for run in runs)),
                     number(silence["largest_gap_seconds"]), silence["name"],
                     number(max(cancel)) if cancel else "-"])
    return table(["samples", "never falls", "calls/s", "longest silence, s", "in stage", "slowest end after cancel, s"], body)


def markdown(results):
    threads = results["threads"]
    text = ["# Benchmark\n",
            f"Written by `sh tests/benchmark/run.sh` on {results['date']}: {results['machine']}. Load average while "
            f"measuring {min(results['load']):.1f} to {max(results['load']):.1f}.\n",
            "Seconds without input and output, the least of the runs. *Ratio*: our time over that of CGAL's advancing front, the "
            "median over neighbouring runs; below 1 ours is faster. Ours includes the matching report with its exact count of "
            "self-intersections. *Exponent*: slope of the time over the samples, both logarithmic, by least squares from "
            f"{PLAIN_FIT_FROM:,} samples on. *B/sample*: peak memory less what the process held before. MeshLab's filters "
            "run in meshlabserver, less an empty run; Screened Poisson is given normals by MeshLab, and octree nodes "
            "about as large as the spacing. *SI*: self-intersecting faces. \"-\": not run, failed, over the time limit, or too short to tell from an empty run.\n"]
    for cloud, rows in rows_by_cloud(results).items():
        text += [f"## {cloud}\n", totals_table(rows, threads)]
        for t in threads:
            text += [f"Seconds per stage, {t} thread{'s' if t > 1 else ''}:\n", stages_table(rows, t)]
        text += ["Peak memory within each stage, bytes per sample:\n", memory_table(rows, threads[-1]),
                 "Progress and cancel:\n", response_table(rows, threads)]
    return "\n".join(text)


def plot(results, path):
    """Time and memory over the number of samples; False if there is nothing to plot with."""
    try:
        import matplotlib
    except ImportError:
        return False
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "benchmark"
    import matplotlib.pyplot as pyplot

    clouds = rows_by_cloud(results)
    figure, axes = pyplot.subplots(2, len(clouds), figsize=(5 * len(clouds), 8), squeeze=False, sharex=True)
    for column, (cloud, rows) in enumerate(clouds.items()):
        times, memory = axes[0][column], axes[1][column]
        sizes = [row["samples"] for row in rows]
        lines = {f"ours, {t} thread{'s' if t > 1 else ''}": [by_threads(row["ours"], t) for row in rows]
                 for t in results["threads"]}
        lines["advancing front"] = [row["advancing_front"] for row in rows]
        for label, runs in lines.items():
            draw(times, sizes, [least(r, "seconds") for r in runs], label, "o-")
            draw(memory, sizes, [least(r, "bytes_per_sample") for r in runs], label, "o-")
        for name in ("Ball Pivoting", "Screened Poisson", "Shrink Wrap"):
            peers = [row["meshlab"].get(name) for row in rows]
            draw(times, sizes, [peer and peer["seconds"] for peer in peers], name + " in MeshLab", "s--")
        times.set(title=cloud, xscale="log", yscale="log", ylabel="seconds")
        memory.set(xscale="log", ylim=(0, None), xlabel="samples", ylabel="peak bytes per sample")
        for axis in (times, memory):
            axis.grid(True, which="major", alpha=0.4)
        times.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    return True


def complaints(results):
    """What must hold on any machine, however loaded: runs that ended, sound meshes, the same bytes for all threads."""
    found = []
    for row in results["rows"]:
        name = f"{row['cloud']}, {row['samples']:,} samples"
        runs = [run for t in results["threads"] for run in by_threads(row["ours"], t)]
        found += [f"{name}: {run['error']}" for run in runs if "error" in run]
        for run in good(runs):
            found += [f"{name}: the mesh is not {key}" for key in ("closed", "manifold", "outward", "matched") if not run[key]]
            progress = run["progress"]
            if not progress["monotone"] or not progress["within_bounds"]:
                found.append(f"{name}: progress falls or leaves [0, 1]")
        if row["cancel"] and all(seconds is None for seconds in row["cancel"].values()):
            found.append(f"{name}: no run could be cancelled")
        found += [f"{name}: cancelled at {fraction}: {error}"
                  for fraction, error in row["cancel"].items() if isinstance(error, str)]
        if len({run["checksum"] for run in good(runs)}) > 1:
            found.append(f"{name}: the runs do not give the same bytes")
    return found


def draw(axis, sizes, values, label, style):
    points = [(n, value) for n, value in zip(sizes, values) if value]
    if points:
        axis.plot(*zip(*points), style, label=label, markersize=4)
