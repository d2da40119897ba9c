"""The figures of run.py as one page, in Markdown and in HTML."""

import html as escaping

INTRODUCTION = (
    "Ball Pivoting and Screened Poisson are MeshLab's own, with the defaults of their dialogs; Poisson's normals are "
    "computed by MeshLab (10 neighbours), its octree is as deep as the spacing asks for, at least 8. *For noise*: normals "
    "of 30 neighbours and 15 samples a node, as its help proposes. All ran in the same meshlabserver, and every mesh was "
    "measured by MeshLab's filters (Topological and Geometric Measures, Hausdorff Distance, Select Self Intersecting "
    "Faces) and by Shrink Wrap: Matching Report.")
LEGEND = (
    "*Samples kept*: exactly one vertex, at the input's bits (*outliers*: left out, see ExcludeOutliers). *Holes*: border loops. *Intersecting*: self-intersecting "
    "faces, exact, and what MeshLab's filter finds of them (it takes no pairs that share a vertex). *Samples to "
    "mesh*, *mesh to truth*, *truth to mesh*: Hausdorff distances, mean and greatest, in % of the diagonal of the bounding box. "
    "*Seconds*: on the clock, less a run that does nothing, and (in brackets) of processor time.")


def percent(distance):
    if distance is None:
        return "-"
    return f"{distance['mean']:.3f} / {distance['greatest']:.2f}"


def share(row):
    kept, samples = row["samples_kept"], row["samples"]
    more = f", and {row['extra_vertices']:,} vertices more" if kept and row["extra_vertices"] else ""
    if kept == samples and row["samples_to_mesh"]["greatest"] > 0.0:
        return f"all but {max(row.get('points', kept) - kept, 1):,} outliers" + more
    if kept == samples:
        return "all" + more
    return "none" if kept == 0 else f"{100.0 * kept / samples:.1f} %"


def intersecting(row):
    exact, of_meshlab = row["self_intersecting_faces"], row["meshlab"]["self_intersecting_faces"]
    if exact == of_meshlab:
        return f"{exact:,}"
    return f"{exact:,} ({'-' if of_meshlab is None else of_meshlab})"


def optional(value):
    return "-" if value is None else f"{value:,}" if isinstance(value, int) else str(value)


def seconds(row):
    return f"{row['seconds']:.1f} ({row['processor_seconds']:.1f})"


COLUMNS = [
    ("samples kept", share),
    ("holes", lambda row: optional(row["holes"])),
    ("2-manifold", lambda row: "yes" if row["manifold"] else "no"),
    ("bodies", lambda row: optional(row["bodies"])),
    ("genus", lambda row: optional(row["genus"])),
    ("outside is out", lambda row: {None: "-", True: "no", False: "yes"}[row["inside_out"]]),
    ("intersecting", intersecting),
    ("area", lambda row: optional(row["area"] and f"{row['area']:.4g}")),
    ("samples to mesh", lambda row: percent(row["samples_to_mesh"])),
]
TRUTH_COLUMNS = [
    ("mesh to truth", lambda row: percent(row.get("mesh_to_truth"))),
    ("truth to mesh", lambda row: percent(row.get("truth_to_mesh"))),
]


def table_of(result):
    """(header, rows of cells) of one cloud."""
    columns = COLUMNS + (TRUTH_COLUMNS if result["has_truth"] else [])
    header = ["", *[name for name, _ in columns], "seconds"]
    rows = []
    for row in result["rows"]:
        if "error" in row:
            rows.append([row["method"], row["error"], *[""] * (len(columns) - 1), seconds(row)])
        else:
            rows.append([row["method"], *[cell(row) for _, cell in columns], seconds(row)])
    return header, rows


def shape(row):
    """Closed or not, in a few words."""
    if "error" in row:
        return row["error"]
    if row["closed"] and row["manifold"]:
        words = [f"genus {row['genus']}"]
    else:
        holes = row["holes"]
        words = [f"{optional(holes)} hole" + ("" if holes == 1 else "s")]
        words += [] if row["manifold"] else ["not a 2-manifold"]
    return ", ".join(words + (["inside out"] if row["inside_out"] else []))


def verdict(row):
    """The mesh in a few words."""
    if "error" in row:
        return row["error"]
    return f"samples kept: {share(row)}; {shape(row)}; self-intersecting faces: {row['self_intersecting_faces']:,}"


def of_mesh(cell):
    """What a cell says of a row that has a mesh; a row without says why where its shape is told."""
    return lambda row: "-" if "error" in row else cell(row)


def mean_off(row):
    return f"{row['mesh_to_truth']['mean']:.2f}" if "mesh_to_truth" in row else "-"


OVERVIEWS = [
    # caption, cell, whether it is only of clouds whose true surface is known
    ("Samples kept", of_mesh(share), False),
    ("Closed 2-manifolds by their genus, others by their holes", shape, False),
    ("Self-intersecting faces", of_mesh(lambda row: f"{row['self_intersecting_faces']:,}"), False),
    ("Mesh to truth, mean, in % of the diagonal", of_mesh(mean_off), True),
]


def broken_promise(row):
    """What Shrink Wrap promises for every cloud, and does not hold for this mesh; empty if all holds."""
    if "error" in row:
        return row["error"]
    broken = [text for holds, text in ((row["closed"], "not closed"), (row["manifold"], "not 2-manifold"),
                                       (row["samples_kept"] == row["samples"], "samples lost"),
                                       (not row["inside_out"], "inside out")) if not holds]
    return ", ".join(broken)


def overviews(results):
    """(caption, header, rows of cells) of small tables: a row a cloud, a column a method."""
    methods = []
    for result in results:
        methods += [row["method"] for row in result.get("rows", []) if row["method"] not in methods]
    tables = []
    for caption, cell, needs_truth in OVERVIEWS:
        rows = []
        for result in results:
            if needs_truth and not result.get("has_truth"):
                continue
            by_method = {row["method"]: cell(row) for row in result.get("rows", [])}
            rows.append([name_of(result), *[by_method.get(method, result.get("error", "")) for method in methods]])
        if rows:
            tables.append((caption, ["", *methods], rows))
    return tables


def name_of(result):
    return result["name"].replace("_", " ")


def title(result):
    return name_of(result) + (f", {result['points']:,} points" if "points" in result else "")


def relative(path, folder):
    return path.relative_to(folder).as_posix()


def markdown_table(header, rows):
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def markdown(results, date, folder):
    parts = ["# MeshLab's reconstruction filters and Shrink Wrap on the same clouds\n",
             f"Written by `sh tests/compare/run.sh` on {date}. {INTRODUCTION}\n", LEGEND + "\n"]
    for caption, header, rows in overviews(results):
        parts.append(f"**{caption}**\n\n" + markdown_table(header, rows))
    for result in results:
        parts.append(f"## {title(result)}\n")
        if "error" in result:
            parts.append(result["error"] + "\n")
            continue
        parts.append(markdown_table(*table_of(result)))
        if "picture" in result:
            parts.append(f"![{title(result)}]({relative(result['picture'], folder)})\n")
    return "\n".join(parts)


STYLE = """
body { font: 15px/1.45 sans-serif; color: #222; max-width: 1280px; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; font-size: 13px; }
th, td { border-bottom: 1px solid #ddd; padding: .35em .7em; text-align: right; vertical-align: top; }
th { background: #f4f5f7; } th:first-child, td:first-child { text-align: left; font-weight: 600; }
table.overview td, table.overview th { text-align: left; }
img { max-width: 100%; border: 1px solid #ddd; }
"""


def html_text(text):
    """Escaped; *emphasis* as in Markdown."""
    parts = escaping.escape(text).split("*")
    return "".join(part if i % 2 == 0 else f"<em>{part}</em>" for i, part in enumerate(parts))


def html_table(header, rows, kind):
    head = "".join(f"<th>{escaping.escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{escaping.escape(cell)}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f'<table class="{kind}">\n<tr>{head}</tr>\n{body}</table>\n'


def html(results, date, folder):
    heading = "MeshLab's reconstruction filters and Shrink Wrap on the same clouds"
    parts = [f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{escaping.escape(heading)}</title>',
             f"<style>{STYLE}</style></head>\n<body>\n<h1>{escaping.escape(heading)}</h1>",
             f"<p>Written by <code>sh tests/compare/run.sh</code> on {date}. {html_text(INTRODUCTION)}</p>",
             f"<p>{html_text(LEGEND)}</p>"]
    for caption, header, rows in overviews(results):
        parts.append(f"<h2>{escaping.escape(caption)}</h2>\n" + html_table(header, rows, "overview"))
    for result in results:
        parts.append(f"<h2>{escaping.escape(title(result))}</h2>")
        if "error" in result:
            parts.append(f"<p>{escaping.escape(result['error'])}</p>")
            continue
        parts.append(html_table(*table_of(result), "figures"))
        if "picture" in result:
            source = escaping.escape(relative(result["picture"], folder), quote=True)
            parts.append(f'<p><a href="{source}"><img src="{source}" alt="{escaping.escape(title(result), quote=True)}"></a></p>')
    return "\n".join(parts) + "\n</body>\n</html>\n"
