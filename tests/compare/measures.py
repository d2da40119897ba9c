"""What MeshLab's measuring filters and our report write to the log, as figures."""

import re

NUMBER = r"([-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|inf|nan))"


def last_block(log):
    """The lines since the last filter began. MeshLab prints all earlier lines of the log again after every filter, so
    that the last block has each line of the script once."""
    return log[log.rfind("filter: "):]


def first_number(pattern, text, kind=int):
    found = re.search(pattern, text)
    return kind(found.group(1)) if found else None


def topology(text):
    """By "Compute Topological Measures", of the mesh and all of its vertices. None: MeshLab does not tell."""
    return {"vertices": first_number(r"V: *(\d+)", text), "faces": first_number(r"F: *(\d+)", text),
            "border_edges": first_number(r"Boundary Edges (\d+)", text),
            "bodies": first_number(r"composed by (\d+) connected", text),
            "manifold": "Mesh is two-manifold" in text,
            "holes": first_number(r"Mesh has (\d+) holes", text), "genus": first_number(r"Genus is (-?\d+)", text)}


def geometry(text):
    """By "Compute Geometric Measures"."""
    return {"area": first_number(rf"Surface Area is {NUMBER}", text, float),
            "volume": first_number(rf"Mesh Volume +is {NUMBER}", text, float)}


def report(text):
    """By "Shrink Wrap: Matching Report", of what the faces use. None: not told, or not defined for such a mesh."""
    manifold = re.search(r"^2-manifold: (.*)$", text, re.MULTILINE)
    closed = re.search(r"^Closed: (.*)$", text, re.MULTILINE)
    matching = re.search(r"^Complete matching: (\d+) of (\d+) samples?", text, re.MULTILINE)
    if not (manifold and closed and matching):
        return None
    is_closed = closed.group(1).startswith("yes")
    intersecting = re.search(r"^Self-intersections: (?:none|(\d+))", text, re.MULTILINE)
    return {"samples_kept": int(matching.group(1)), "samples": int(matching.group(2)),
            "extra_vertices": first_number(r"(\d+) vert(?:ex is|ices are) no sample", text) or 0,
            "manifold": manifold.group(1).startswith("yes"), "closed": is_closed,
            "genus": first_number(r"genus (\d+)", manifold.group(1)),
            "holes": 0 if is_closed else first_number(r"(\d+) opening", closed.group(1)),
            "bodies": first_number(r"\nMesh: \d+ vert.*, (\d+) component", text),
            "inside_out": "volume -" in closed.group(1) if is_closed else None,
            "self_intersecting_faces": int(intersecting.group(1) or 0) if intersecting else None}


def distances(text):
    """By "Hausdorff Distance", in the order of the script: {mean, greatest} in the units of the layers, {diagonal} of the
    layer that was sampled."""
    found = re.findall(rf"Values w\.r\.t\. BBox Diag \({NUMBER}\)\s+min : {NUMBER} +max {NUMBER} +mean : {NUMBER}", text)
    # Relative values have more digits than absolute ones where a cloud is small.
    return [{"diagonal": float(diagonal), "greatest": float(greatest) * float(diagonal), "mean": float(mean) * float(diagonal)}
            for diagonal, _, greatest, mean in found]


def selected_self_intersections(text):
    """By "Select Self Intersecting Faces", which tells nothing itself: by what was then deleted."""
    if "Nothing done: no faces selected" in text:
        return 0
    return first_number(r"Deleted (\d+) faces", text)


def measures(log):
    """All of the above from the log of measure.mlx or measure_with_truth.mlx; None if the log is not whole."""
    text = last_block(log)
    ours, apart = report(text), distances(text)
    if ours is None or len(apart) not in (1, 3):
        return None
    figures = {"meshlab": {**topology(text), "self_intersecting_faces": selected_self_intersections(text)},
               **geometry(text), **ours}
    names = ["samples_to_mesh", "mesh_to_truth", "truth_to_mesh"]
    diagonal = apart[-1 if len(apart) == 3 else 0]["diagonal"]
    for name, values in zip(names, apart):
        figures[name] = {key: 100.0 * values[key] / diagonal for key in ("mean", "greatest")}
    return figures


def disagreements(figures):
    """Where MeshLab and our report both tell and do not tell the same. Both are exact, so there should be none."""
    of_meshlab = figures["meshlab"]
    return [f"{key}: {of_meshlab[key]} by MeshLab, {figures[key]} by the report" for key in ("manifold", "holes", "genus", "bodies")
            if of_meshlab[key] is not None and figures[key] is not None and of_meshlab[key] != figures[key]]
