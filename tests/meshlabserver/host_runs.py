"""What the tests on the real host share: clouds, scripts, runs of meshlabserver, and the independent checker."""

import atexit
import functools
import math
import os
import pathlib
import random
import resource
import signal
import struct
import subprocess
import time
import xml.etree.ElementTree as ElementTree

SCRIPTS = pathlib.Path(__file__).resolve().parent / "scripts"
ONE_SHOT = SCRIPTS.parents[2] / "sample_clouds" / "reconstruct.mlx"


def sphere(count, seed=1, keep=lambda p: True):
    """Random points of the unit sphere, in single precision."""
    generator = random.Random(seed)
    points = []
    while len(points) < count:
        p = [generator.gauss(0.0, 1.0) for _ in range(3)]
        length = math.sqrt(sum(x * x for x in p))
        p = tuple(as_float(x / length) for x in p)
        if keep(p):
            points.append(p)
    return points


def torus(count, seed=1):
    """Random points of a torus, uniform by area, in single precision."""
    generator = random.Random(seed)
    points = []
    while len(points) < count:
        u, v = (generator.uniform(0.0, 2.0 * math.pi) for _ in range(2))
        if generator.uniform(0.0, 1.0) > (0.75 + 0.25 * math.cos(v)):
            continue
        r = 0.75 + 0.25 * math.cos(v)
        points.append(tuple(as_float(x) for x in (r * math.cos(u), r * math.sin(u), 0.25 * math.sin(v))))
    return points


def as_float(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def write_ply(path, points, faces=(), colours=None, qualities=None, colour_name="", quality_name="quality",
              intensities=None, intensity_type="float"):
    """A binary PLY, bit for bit. `colour_name` is what stands before red, green and blue."""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    header += [f"property float {axis}" for axis in "xyz"]
    if colours:
        header += [f"property uchar {colour_name}{channel}" for channel in ("red", "green", "blue")]
    if intensities:
        header.append(f"property {intensity_type} intensity")
    if qualities:
        header.append(f"property float {quality_name}")
    if faces:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\nend_header\n").encode())
        for i, point in enumerate(points):
            file.write(struct.pack("<3f", *point))
            if colours:
                file.write(bytes(colours[i]))
            if intensities:
                file.write(struct.pack({"float": "<f", "uchar": "<B"}[intensity_type], intensities[i]))
            if qualities:
                file.write(struct.pack("<f", qualities[i]))
        for face in faces:
            file.write(struct.pack("<B3i", 3, *face))


def read_ply(path):
    """Vertices (a dict each) and faces of a binary PLY as MeshLab writes it."""
    vertices, faces, _ = read_ply_with_face_qualities(path)
    return vertices, faces


def read_ply_with_face_qualities(path):
    """As read_ply; and the face qualities, none if the file has none."""
    formats = {"float": "f", "uchar": "B", "int": "i", "double": "d", "uint": "I"}
    data = pathlib.Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts, names, layouts = {}, {}, {}
    element = None
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == "element":
            element = words[1]
            counts[element], names[element], layouts[element] = int(words[2]), [], "<"
        elif words[:2] == ["property", "list"]:
            layouts[element] += "B3i"  # triangles, of a uchar and ints
        elif words[0] == "property":
            names[element].append(words[2])
            layouts[element] += formats[words[1]]
    size = struct.calcsize(layouts["vertex"])
    vertices = [dict(zip(names["vertex"], struct.unpack_from(layouts["vertex"], data, end + i * size)))
                for i in range(counts["vertex"])]
    offset = end + counts["vertex"] * size
    if "face" not in counts:
        return vertices, [], []
    size = struct.calcsize(layouts["face"])
    rows = [struct.unpack_from(layouts["face"], data, offset + i * size) for i in range(counts["face"])]
    column = 4 + names["face"].index("quality") if "quality" in names["face"] else None
    return vertices, [row[1:4] for row in rows], [row[column] for row in rows] if column else []


def read_obj(path):
    """Vertices and faces of an OBJ. (The importer of this vcglib takes no face of the first vertex.)"""
    vertices, faces = [], []
    for line in pathlib.Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append(tuple(float(word) for word in words[1:4]))
        elif words[:1] == ["f"]:
            faces.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:]))
    return vertices, faces


def script(path, base, *changes, before=None, types=None):
    """Writes a variant of a script to `path`. A change is (parameter, value) or (filter name's end, parameter, value)."""
    tree = ElementTree.parse(base)
    for change in changes:
        name, parameter, value = ("", *change) if len(change) == 2 else change
        found = 0
        for step in tree.getroot():
            if not step.get("name").endswith(name):
                continue
            for element in step.findall(f"Param[@name='{parameter}']"):
                element.set("value", str(value))
                if types and parameter in types:
                    element.set("type", types[parameter])
                found += 1
        if not found:
            raise ValueError(f"no parameter {parameter} in {base}")
    if before is not None:
        tree.getroot().insert(0, ElementTree.fromstring(before))
    pathlib.Path(path).write_text("<!DOCTYPE FilterScript>\n" + ElementTree.tostring(tree.getroot(), encoding="unicode"))
    return path


class Screen:
    """An X server without a screen, for all runs of a process: the host needs one, and starting it takes longer than most
    runs. It must not reset when the last of its clients leaves: the next one would be turned away meanwhile, and abort."""

    def __init__(self):
        read_end, write_end = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write_end), "-nolisten", "tcp", "-noreset"],
                                       pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as numbers:
            self.name = ":" + numbers.readline().strip()  # written once the server takes connections
        if self.name == ":":
            raise RuntimeError("Xvfb does not start")
        atexit.register(self.close)

    def close(self):
        self.server.terminate()
        self.server.wait()


@functools.lru_cache(maxsize=1)
def screen():
    return Screen()


class Run:
    """One run of meshlabserver: exit code (None: stopped at the time limit), log, all of its output, and its seconds, on
    the clock and of processor time. `projects`: one to read, one to write."""

    def __init__(self, server, folder, script_file, inputs, outputs=(), options=(), time_limit=300, environment=(),
                 projects=None):
        log = folder / "host.log"
        log.unlink(missing_ok=True)
        command = [str(server), "-l", str(log)]
        if projects:
            command += ["-p", str(projects[0]), "-w", str(projects[1])]
        if inputs:
            command += ["-i", *map(str, inputs)]
        for layer, output in outputs:
            command += ["-o", str(output), "-l", str(layer), *options]
        command += ["-s", str(script_file)]
        # The host needs the X server, whatever else runs without a screen.
        environment = dict(os.environ, HOME=str(folder), DISPLAY=screen().name, **dict(environment))
        environment.pop("QT_QPA_PLATFORM", None)
        used, begin = children_seconds(), time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=folder,
                                   env=environment, start_new_session=True)
        try:
            said, _ = process.communicate(timeout=time_limit)
            self.code = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            said, _ = process.communicate()
            self.code = None
        self.seconds, self.processor_seconds = time.monotonic() - begin, children_seconds() - used
        self.log = log.read_text(errors="replace") if log.exists() else ""
        self.text = self.log + said.decode(errors="replace")


def children_seconds():
    """Processor time of all children that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def check(checker, mesh, cloud=None):
    """The figures of the independent checker as a dict of ints."""
    done = subprocess.run([str(checker), str(mesh), *([str(cloud)] if cloud else [])], capture_output=True, check=True)
    return {key: int(value) for key, value in (line.split() for line in done.stdout.decode().splitlines())}
