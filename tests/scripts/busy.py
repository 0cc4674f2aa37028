#!/usr/bin/env python3
"""Is `compare` done in time on two cores that two other processes keep busy?

    cargo build --release
    tests/scripts/busy.py [--full] [--alone] [--only NAME] [--program PATH] [FOLDER ...]

Compares every embedded scene, every scene file below the folders, and a procedural
mesh of 900,000 triangles, one after the other: with --quick, which must be done
within 20 seconds, or with --full within --budget seconds (150). Two processes that do
nothing but count run beside each. Prints a table with the seconds on the clock and those
of the processor: with two threads beside two others, one comes to about the other. Where
more is going on (the load is printed first), only the latter mean something. Returns 1 if
a run took too long, failed or measured nothing.
"""

import argparse
import csv
import json
import math
import multiprocessing
import os
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import time

QUICK_LIMIT = 20.0
KINDS = {".glb", ".gltf", ".ply", ".obj", ".hair", ".vol"}
TRIANGLES = 900_000


def count():
    """Keeps a core busy."""
    number = 0
    while True:
        number += 1


def write_mesh(path):
    """A terrain with towers, as binary PLY."""
    side = round(math.sqrt(TRIANGLES / 2))
    vertices = bytearray()
    for row in range(side + 1):
        for column in range(side + 1):
            x, z = 40.0 * column / side - 20.0, 40.0 * row / side - 20.0
            y = 0.6 * math.sin(0.9 * x) * math.cos(0.7 * z)
            if math.sin(2.1 * x) * math.sin(1.9 * z) > 0.6:
                y += 3.0
            vertices += struct.pack("<3f", x, y, z)
    faces = bytearray()
    for row in range(side):
        for column in range(side):
            a = row * (side + 1) + column
            b, c, d = a + 1, a + side + 1, a + side + 2
            faces += struct.pack("<B3i", 3, a, c, b) + struct.pack("<B3i", 3, b, c, d)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {(side + 1) ** 2}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {2 * side * side}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + vertices + faces)


def embedded(program):
    """Names of the embedded scenes."""
    listed = subprocess.run([program, "scenes", "--json"], capture_output=True, check=True)
    return [scene["name"] for scene in json.loads(listed.stdout)["scenes"]]


def compare(program, scene, mode, out):
    """One comparison: seconds, those of the processor, the summary, what it said."""
    start, used = time.monotonic(), processor()
    run = subprocess.run(
        [program, "compare", scene, *mode, "--json", "--out", str(out)],
        capture_output=True,
        text=True,
    )
    seconds = time.monotonic() - start, processor() - used
    summary = json.loads(run.stdout) if run.stdout.startswith("{") else None
    return *seconds, summary, run


def processor():
    """Seconds that finished children have used."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", nargs="*", type=pathlib.Path)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--budget", type=float, default=150.0)
    parser.add_argument("--only", action="append", help="scenes whose name contains this")
    parser.add_argument("--alone", action="store_true", help="without the busy processes")
    parser.add_argument("--program", default="target/release/crepuscular")
    args = parser.parse_args()

    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
    mode = ["--time-budget", str(args.budget)] if args.full else ["--quick"]
    limit = args.budget if args.full else QUICK_LIMIT
    others = [multiprocessing.Process(target=count, daemon=True) for _ in range(2 * (not args.alone))]
    late = 0
    print(f"load before: {os.getloadavg()[0]:.1f}")
    table = csv.writer(sys.stdout, delimiter="\t", lineterminator="\n")
    table.writerow(
        ["scene", "triangles", "size", "seconds", "cpu", "limit", "reference", "rows", "repetitions", "verdict"]
    )
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        mesh = place / "terrain_900k.ply"
        write_mesh(mesh)
        scenes = embedded(args.program)
        for folder in args.folders:
            files = sorted(f for f in folder.rglob("*") if f.suffix.lower() in KINDS)
            scenes += [str(file) for file in files]
        scenes.append(str(mesh))
        if args.only:
            scenes = [s for s in scenes if any(o in pathlib.Path(s).name for o in args.only)]
        for other in others:
            other.start()
        for scene in scenes:
            seconds, cpu, summary, run = compare(args.program, scene, mode, place / "out")
            rows = summary["measurements"] if summary else []
            runs = [row["repetitions"] for row in rows if row["representative"]]
            verdict = "in time" if seconds <= limit else "TOO LATE"
            if run.returncode != 0 or not rows:
                verdict = f"FAILED ({run.returncode}): {run.stderr.strip().splitlines()[-1:]}"
            late += verdict != "in time"
            table.writerow(
                [
                    pathlib.Path(scene).name,
                    summary["scene"]["triangles"] if summary else "",
                    f"{summary['width']}x{summary['height']}" if summary else "",
                    f"{seconds:.1f}",
                    f"{cpu:.1f}",
                    f"{limit:g}",
                    f"{summary['reference']['seconds']:.1f}" if summary else "",
                    len(rows),
                    f"{min(runs)}-{max(runs)}" if runs else "",
                    verdict,
                ]
            )
            sys.stdout.flush()
        for other in others:
            other.terminate()
    print(f"{late} of {len(scenes)} not in time")
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
