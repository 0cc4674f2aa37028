#!/usr/bin/env python3
"""What the program leaves behind when it is killed, or when the machine has no more to give.

    cargo build --release
    tests/scripts/faults.py [--kills N] [--seed S] [--limit S] [--only NAME] [--program PATH]

* kills: bakes and comparisons, N of each (100), are killed (SIGKILL) or told to end (SIGINT,
  SIGTERM) at random moments. A file or report that was there before must be as it was, or be
  the new one as a whole, or be where `--help` says that an earlier report can be; a bake that
  goes on from what is left must come to the same bytes; what is left besides must have the names
  that `--help` states.
* disk: a file may be no larger than a few kilobytes (RLIMIT_FSIZE), as on a disk that is full.
* folder: the output is in a folder that is none, or cannot be written to.
* memory: huge requests with little memory (RLIMIT_AS).
* sweep: ordinary requests with less and less memory, down to what the program itself needs. What
  they leave must be nothing or whole.

Everything but a kill must end with exit code 1 or 2 and an error in words, or succeed. Where not
even a little memory is left, the allocator may end the program. Prints a row for
each kind with how many runs were undone in which way, and each violation; returns 1 if there is
one.
"""

import argparse
import collections
import hashlib
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

# A backtrace takes more memory than there is.
ENVIRONMENT = {**os.environ, "RUST_BACKTRACE": "0"}
BAKE = ["bake", "city", "--seed", "1", "--light", "0", "--resolution", "32768"]
# Memory limits of the sweep, in MB.
MEGABYTES = (60, 70, 80, 90, 100, 120, 140, 160, 180, 200, 230, 260, 300, 350, 400, 500, 700, 1000, 1400, 2000)
COMPARE = ["compare", "city", "--quick", "--size", "48x27", "--backend", "cpu", "--time-budget", "4"]


class Case:
    """Counts outcomes and violations of one kind of fault."""

    def __init__(self, name):
        self.name, self.outcomes, self.violations = name, collections.Counter(), []

    def violated(self, what):
        self.violations.append(what)
        print(f"violation: {self.name}: {what}", flush=True)

    def row(self):
        outcomes = ", ".join(f"{count} {outcome}" for outcome, count in sorted(self.outcomes.items()))
        return f"{self.name:24} {len(self.violations):3} violations; {outcomes}"


def digest(path):
    """Of a file, or of the files of a folder by their names; nothing if there is none."""
    if path.is_file():
        return hashlib.sha256(path.read_bytes()).hexdigest()
    if path.is_dir():
        files = sorted(file for file in path.rglob("*") if file.is_file())
        return hashlib.sha256(repr([(str(f.relative_to(path)), digest(f)) for f in files]).encode()).hexdigest()
    return None


def run(asked, arguments, folder, limits=()):
    """Runs to the end, with limits of resources."""

    def before():
        # What is written beyond a limit is an error, not a signal.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        for what, value in limits:
            resource.setrlimit(what, (value, value))

    command = [asked.program, *arguments]
    try:
        return subprocess.run(
            command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=asked.limit, preexec_fn=before
        )
    except subprocess.TimeoutExpired:
        return None


def judge(case, arguments, done, may_succeed=True):
    """Counts how a run ended that was not killed, and whether it did so in words."""
    name = " ".join(arguments)
    if done is not None and done.returncode == -signal.SIGABRT and "memory allocation of" in done.stderr:
        case.outcomes["ended by the allocator"] += 1
        return
    if done is None:
        case.violated(f"{name}: not done in time")
        return
    case.outcomes["done" if done.returncode == 0 else f"exit code {done.returncode}"] += 1
    if done.returncode == 0 and not may_succeed:
        case.violated(f"{name}: succeeds")
    if done.returncode not in (0, 1, 2):
        case.violated(f"{name}: exit code {done.returncode}: {done.stderr.strip()[-300:]}")
    elif done.returncode and "error:" not in done.stderr:
        case.violated(f"{name}: no error in words: {done.stderr.strip()[-300:]}")
    if "panicked" in done.stderr:
        case.violated(f"{name}: {done.stderr.strip()[-300:]}")


def stopped(asked, arguments, folder, after, by):
    """Starts a run and ends it; its exit code, and what it said."""
    process = subprocess.Popen(
        [asked.program, *arguments], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    try:
        process.wait(after)
    except subprocess.TimeoutExpired:
        process.send_signal(by)
    try:
        _, said = process.communicate(timeout=asked.limit)
    except subprocess.TimeoutExpired:
        process.kill()
        return None, process.communicate()[1]
    return process.returncode, said


def kills(asked, folder, name, arguments, output, left):
    """Runs that are ended at random moments. `left` are patterns of what may be left besides."""
    case = Case(name)
    chance = random.Random(asked.seed)
    whole, other = folder / output, folder / "other"
    start = time.monotonic()
    done = run(asked, arguments, folder)
    judge(case, arguments, done)
    if done is None or done.returncode:
        return case
    seconds = time.monotonic() - start
    fresh = digest(whole)
    # A report has times; of it only that it is whole can be told.
    is_same_each_time = whole.is_file()
    whole.rename(other)
    for _ in range(asked.kills):
        for old in (whole, *(path for pattern in left for path in folder.glob(pattern))):
            shutil.rmtree(old) if old.is_dir() else old.unlink(missing_ok=True)
        # One that was there before, for half of the runs.
        before = None
        if chance.random() < 0.5:
            (shutil.copytree if other.is_dir() else shutil.copy)(other, whole)
            if whole.is_file():
                whole.write_bytes(whole.read_bytes()[:-1] + b"?")
            before = digest(whole)
        by = chance.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
        code, said = stopped(asked, arguments, folder, chance.uniform(0, 1.1 * seconds), by)
        case.outcomes["done" if code == 0 else signal.Signals(-code).name if code and code < 0 else f"exit code {code}"] += 1
        if code is None:
            case.violated(f"not ended by {by.name}")
        if "panicked" in said:
            case.violated(said.strip()[-300:])
        after = digest(whole)
        if after is None:
            # Killed between the two renames that replace a report.
            after = next((digest(earlier) for earlier in folder.glob(".crepuscular-old-*/report")), None)
        if after not in (before, fresh) and (is_same_each_time or not is_report(whole)):
            case.violated(f"{output} is neither the old one nor whole after {by.name}")
        if code == 0 and after == before:
            case.violated(f"{output} is the old one after success")
        known = {whole, other, *(path for pattern in left for path in folder.glob(pattern))}
        for path in set(folder.iterdir()) - known:
            case.violated(f"leaves {path.name} behind after {by.name}")
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        if is_same_each_time and (folder / f"{output}.part").exists():
            case.outcomes["resumed"] += 1
            done = run(asked, [*arguments, "--resume"], folder)
            judge(case, [*arguments, "--resume"], done, True)
            if digest(whole) != fresh:
                case.violated("a bake that was resumed has other bytes")
    return case


def is_report(folder):
    page = folder / "index.html"
    return page.is_file() and page.read_text().rstrip().endswith("</html>") and (folder / "results.csv").is_file()


def disk(asked, folder):
    case = Case("disk")
    for arguments in (
        [*BAKE[:-1], "1024", "--output", "grid.cpvs"],
        ["render", "city", "--size", "160x90", "--output", "picture.png"],
        ["render", "city", "--size", "160x90", "--output", "picture.exr"],
        [*COMPARE, "--out", "report"],
    ):
        for size in (0, 1, 1000, 10_000):
            done = run(asked, arguments, folder, [(resource.RLIMIT_FSIZE, size)])
            judge(case, arguments, done)
            if done is not None and done.returncode and (left := [path.name for path in folder.iterdir()]):
                case.violated(f"{' '.join(arguments)}: leaves {', '.join(left)}")
            for path in folder.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    return case


def output_folder(asked, folder):
    case = Case("folder")
    (folder / "file").write_text("not ours")
    (folder / "mine").mkdir()
    (folder / "mine" / "notes.txt").write_text("not ours")
    before = digest(folder)
    for arguments in (
        [*BAKE[:-1], "64", "--output", "file/grid.cpvs"],
        [*BAKE[:-1], "64", "--output", "/proc/grid.cpvs"],
        [*BAKE[:-1], "64", "--output", "mine"],
        ["render", "city", "--size", "16x9", "--output", "none/picture.png"],
        ["render", "city", "--size", "16x9", "--output", "mine"],
        [*COMPARE, "--out", "file"],
        [*COMPARE, "--out", "mine"],
        [*COMPARE, "--out", "/proc/report"],
    ):
        judge(case, arguments, run(asked, arguments, folder), may_succeed=False)
        if digest(folder) != before:
            case.violated(f"{' '.join(arguments)}: changes what is not ours")
    return case


def memory(asked, folder):
    case = Case("memory")
    for arguments in (
        ["render", "city", "--size", "65535x65535", "--output", "picture.png"],
        ["render", "city", "--size", "20000x20000", "--output", "picture.exr"],
        ["render", "city", "--size", "16x9", "--map", "16384", "--method", "march x midpoint", "--output", "picture.png"],
        [*COMPARE[:3], "--size", "30000x30000", "--fixed", "--backend", "cpu"],
        [*BAKE, "--output", "grid.cpvs"],
        ["plan", "city", "--size", "30000x30000", "--backend", "cpu"],
    ):
        for megabytes in (400, 1000, 2000):
            limits = [(resource.RLIMIT_AS, megabytes << 20)]
            judge(case, arguments, run(asked, arguments, folder, limits))
    return case


def is_picture(file):
    return file.read_bytes().endswith(b"IEND\xae\x42\x60\x82")


def sweep(asked, folder):
    case = Case("sweep")
    bake = [*BAKE[:-1], "1024", "--output", "grid.cpvs"]
    judge(case, bake, run(asked, bake, folder), may_succeed=True)
    fresh = digest(folder / "grid.cpvs")
    requests = (
        (["render", "city", "--size", "64x36", "--output", "picture.png"], "picture.png", is_picture),
        (bake, "grid.cpvs", lambda file: digest(file) == fresh),
        ([*COMPARE, "--out", "report"], "report", is_report),
        (["plan", "city", "--size", "64x36", "--backend", "cpu"], "none", None),
        (["stress", "--backend", "cpu", "--cases", "sliver", "--methods", "march"], "none", None),
    )
    for arguments, output, is_whole in requests:
        for megabytes in MEGABYTES:
            for path in folder.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
            done = run(asked, arguments, folder, [(resource.RLIMIT_AS, megabytes << 20)])
            name = [f"{megabytes} MB:", *arguments]
            judge(case, name, done)
            if (folder / output).exists() and not is_whole(folder / output):
                case.violated(f"{' '.join(name)}: {output} is not whole")
            is_in_words = done is not None and done.returncode >= 0
            left = [path.name for path in folder.iterdir() if path.name != output]
            if is_in_words and left:
                case.violated(f"{' '.join(name)}: leaves {', '.join(left)}")
    return case


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=120, metavar="S", help="seconds that no run exceeds, more on a busy machine")
    parser.add_argument("--only", default="", metavar="NAME", help="kinds whose name contains this")
    parser.add_argument("--program", default="target/release/crepuscular")
    asked = parser.parse_args()
    asked.program = str(pathlib.Path(asked.program).resolve())
    kinds = {
        "killed bakes": lambda folder: kills(
            asked, folder, "killed bakes", [*BAKE, "--output", "grid.cpvs"], "grid.cpvs", ["grid.cpvs.part", ".crepuscular-*"]
        ),
        "killed comparisons": lambda folder: kills(
            asked, folder, "killed comparisons", [*COMPARE, "--out", "report"], "report", ["report.tmp-*", ".crepuscular-*"]
        ),
        "disk": lambda folder: disk(asked, folder),
        "folder": lambda folder: output_folder(asked, folder),
        "memory": lambda folder: memory(asked, folder),
        "sweep": lambda folder: sweep(asked, folder),
    }
    cases = []
    for name, kind in kinds.items():
        if asked.only in name:
            with tempfile.TemporaryDirectory() as folder:
                cases.append(kind(pathlib.Path(folder)))
    for case in cases:
        print(case.row())
    return any(case.violations for case in cases)


if __name__ == "__main__":
    sys.exit(main())
