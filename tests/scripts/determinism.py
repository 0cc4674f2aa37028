#!/usr/bin/env python3
"""Do results depend on the number of threads, or differ from run to run?

    cargo build --release
    tests/scripts/determinism.py [--only NAME] [--program PATH] [SCENE ...]

Makes every artefact of the program with 1, 2 and 16 threads, and with 2 once more: the picture of
every method on the CPU, at the first of its qualities, in each scene that it applies to
(embedded ones that have between them all kinds of lights, casters and media); files of baked
shadows in every form; and the reference of a comparison with the errors of its methods. The same
bytes are asked for. Prints a row for each artefact, and returns 1 if one differs or can be made
with some numbers of threads alone.
"""

import argparse
import csv
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SCENES = ["fence", "textured-spot", "pergola", "stiff", "translucent", "smoke-columns"]
THREADS = [1, 2, 16, 2]
SIZE = "48x27"


def run(asked, arguments, folder, threads):
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    command = [asked.program, "-q", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def listed(asked, what):
    done = subprocess.run([asked.program, what, "--json"], capture_output=True, check=True)
    return json.loads(done.stdout)[what]


def judged(asked, name, arguments, digest):
    """Whether an artefact has one value; `None` if it cannot be made, with the reason."""
    found = []
    for threads in THREADS:
        with tempfile.TemporaryDirectory() as folder:
            done = run(asked, arguments, folder, threads)
            if done.returncode == 0:
                found.append(digest(pathlib.Path(folder)))
            else:
                found.append("not made")
                why = [f"exit code {done.returncode}", *done.stderr.strip().splitlines()][-1][:100]
    if len(set(found)) > 1:
        return False, " ".join(f[:8] for f in found)
    return (None, why) if found[0] == "not made" else (True, found[0][:12])


def of_file(name):
    return lambda folder: hashlib.sha256((folder / name).read_bytes()).hexdigest()


def of_report(folder):
    """Of all pictures and of the errors by method and quality."""
    sums = hashlib.sha256()
    for picture in sorted((folder / "report").rglob("*.exr")):
        sums.update(picture.name.encode() + picture.read_bytes())
    with open(folder / "report" / "results.csv", newline="") as file:
        for row in csv.DictReader(file):
            kept = ("visibility", "airlight", "backend", "quality", "error")
            sums.update(repr([row[key] for key in sorted(row) if key.startswith(kept)]).encode())
    return sums.hexdigest()


def artefacts(asked):
    """Names, arguments, and what is looked at."""
    scenes = {scene["name"] for scene in listed(asked, "scenes")}
    asked_scenes = asked.scenes or [scene for scene in SCENES if scene in scenes]
    for scene in asked_scenes:
        for method in listed(asked, "methods"):
            quality = str(method["qualities"][0])
            arguments = ["render", scene, "--size", SIZE, "--method", method["name"], "--quality", quality, "-o", "p.exr"]
            yield f"{scene}: {method['name']} {quality}", arguments, of_file("p.exr")
        yield f"{scene}: comparison", ["compare", scene, "--quick", "--fixed", "--size", SIZE, "--backend", "cpu", "--methods", "march x", "--methods", "none x", "--methods", "media-avsm", "--out", "report"], of_report
    for scene in ("city", "fence"):
        for form in ("plain", "packed", "compressed"):
            arguments = ["bake", scene, "--light", "0", "--resolution", "1024", "--form", form, "-o", "grid.cpvs"]
            yield f"{scene}: {form} grid", arguments, of_file("grid.cpvs")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--only", default="", metavar="NAME", help="artefacts whose name contains this")
    parser.add_argument("--program", default="target/release/crepuscular")
    asked = parser.parse_args()
    asked.program = str(pathlib.Path(asked.program).resolve())
    same = differ = unmade = 0
    for name, arguments, digest in artefacts(asked):
        if asked.only not in name:
            continue
        is_same, why = judged(asked, name, arguments, digest)
        same += is_same is True
        differ += is_same is False
        unmade += is_same is None
        print(f"{ {True: 'same', False: 'DIFFERS', None: 'not made'}[is_same]:9} {name:60} {why}", flush=True)
    print(f"{same} the same, {differ} differ, {unmade} not made")
    return differ > 0


if __name__ == "__main__":
    sys.exit(main())
