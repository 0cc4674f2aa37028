#!/usr/bin/env python3
"""Says which kernels got slower than they were when their ratios were recorded.

    tests/scripts/kernel_ratios.py --run            # measures first, some minutes
    tests/scripts/kernel_ratios.py                  # reads what benches have left
    tests/scripts/kernel_ratios.py --run --record   # the ratios from now on
    tests/scripts/kernel_ratios.py --run --bench lookups
                                                    # the groups of a bench alone
    tests/scripts/kernel_ratios.py --run --group voxels
                                                    # or some groups

Times differ between machines and hours; ratios of one run differ less. Each kernel is
divided by its peer, a simpler way to the same answer, and by a copy of the list that it
works on. The ratios in tests/kernel_ratios.json are compared with those of this run: a
kernel that is slower by more than a factor (--factor, 1.3), beside both, is listed, and the
script returns 1. What is slower beside one of them alone is only said: it may be that one that
changed. A kernel without a time, or without a record, is an error.

Record anew when a kernel or a peer has changed, and say the ratio in the commit. Ratios of
processors with other vector instructions are others: the file says what they were recorded on.

Needs Python 3.8 or later; nothing else.
"""

import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECORD = ROOT / "tests" / "kernel_ratios.json"

# The benches with their packages and groups, and for each group its kernels with the peer of
# each.
BENCHES = {
    "exact": ("crepuscular-tests", ["exact/city", "exact/hairball"]),
    "media": (
        "crepuscular-tests",
        ["media/smoke-room", "media/smoke-columns", "media/translucent"],
    ),
    "evaluators": ("crepuscular-airlight", ["easy", "stiff", "steps", "march"]),
    "lookups": ("crepuscular-shadow-dag", ["voxels", "windows"]),
    "steps": ("crepuscular-voxel-shadow", ["query of 128 bits", "build 512^3"]),
}
# Gathers through smoke, beside a march with as many steps.
GATHERS = dict.fromkeys(
    ["media-exact-area-8", "media-exact-area-16", "media-area-8", "media-avsm-8"],
    "media-double-march",
)
KERNELS = {
    "media/smoke-room": GATHERS,
    "media/smoke-columns": GATHERS,
    "media/translucent": GATHERS,
    "exact/city": {"together": "ray by ray"},
    "exact/hairball": {"together": "ray by ray"},
    "easy": {
        "table/isotropic, 64 KiB": "sun/512",
        "table/Henyey-Greenstein 0.6, 64 KiB": "sun/512",
        "quadrature/isotropic, 1e-4": "march/64 steps",
        "quadrature/Henyey-Greenstein 0.6, 1e-4": "march/64 steps",
        "quadrature/Rayleigh, 1e-4": "march/64 steps",
        "exact/isotropic": "march/64 steps",
        "exact/Henyey-Greenstein 0.6": "march/64 steps",
    },
    "stiff": {
        "table/isotropic, 64 KiB": "sun/512",
        "quadrature/isotropic, 1e-4": "march/64 steps",
        "exact/Henyey-Greenstein 0.6": "march/64 steps",
    },
    "steps": {
        "table/isotropic, 64 KiB": "sun/512",
        "quadrature/isotropic, 1e-4": "march/64 steps",
    },
    "march": {
        "table/isotropic, 64 KiB": "sun/512",
        "march/isotropic, 64 KiB": "sun/512",
    },
    "voxels": {
        "plain/rows": "dense/rows",
        "packed/rows": "dense/rows",
        "plain/anywhere": "dense/anywhere",
        "packed/anywhere": "dense/anywhere",
    },
    "windows": {
        "plain/rows": "dense/rows",
        "packed/rows": "dense/rows",
        "plain/anywhere": "dense/anywhere",
        "packed/anywhere": "dense/anywhere",
    },
    "query of 128 bits": {
        "many lit intervals/nearest": "128 lookups",
        "many lit intervals/interpolated": "128 lookups",
        "lit fraction/interpolated": "128 lookups",
    },
    "build 512^3": {
        "rectify/one thread": "first blockers",
    },
}


def chosen_groups(benches, groups):
    """The groups that are named, of the benches that are named; of all where none is. Raises
    ValueError if a group that is named is in none of these benches."""
    found = [group for bench in benches or BENCHES for group in BENCHES[bench][1]]
    others = sorted(set(groups or []) - set(found))
    if others:
        raise ValueError(f"not in {', '.join(benches)}: {', '.join(others)}")
    return [group for group in found if not groups or group in groups]


def run_benches(groups):
    """Runs what is compared, in small measurements."""
    for bench, (package, its_groups) in BENCHES.items():
        names = wanted_names([group for group in its_groups if group in groups])
        if not names:
            continue
        command = ["cargo", "bench", "--package", package, "--bench", bench, "--"]
        command += ["--warm-up-time", "0.2", "--measurement-time", "0.5", "--sample-size", "20"]
        wanted = "|".join(escaped(name) for name in sorted(names))
        subprocess.run(command + ["--noplot", f"^({wanted})$"], cwd=ROOT, check=True)


def escaped(name):
    """A name as a regular expression."""
    return "".join("\\" + c if c in ".+*?()|[]{}^$\\" else c for c in name)


def wanted_names(groups=KERNELS):
    names = set()
    for group in groups:
        kernels = KERNELS[group]
        names.add(f"{group}/copy")
        for kernel, peer in kernels.items():
            names.update((f"{group}/{kernel}", f"{group}/{peer}"))
    return names


def read_times(folder):
    """The shortest time of an iteration of each benchmark below a folder, ns."""
    times = {}
    for file in sorted(pathlib.Path(folder).glob("**/new/benchmark.json")):
        name = json.loads(file.read_text())["full_id"]
        sample = json.loads((file.parent / "sample.json").read_text())
        pairs = zip(sample["times"], sample["iters"])
        times[name] = min(time / count for time, count in pairs)
    return times


def ratios(times, groups=KERNELS):
    """The ratios of each kernel to its peer and to the copy; the names without a time."""
    found, missing = {}, sorted(wanted_names(groups) - set(times))
    for group in groups:
        for kernel, peer in KERNELS[group].items():
            name, others = f"{group}/{kernel}", (f"{group}/{peer}", f"{group}/copy")
            if not {name, *others} & set(missing):
                to_peer, to_copy = (times[name] / times[other] for other in others)
                found[name] = {"peer": to_peer, "copy": to_copy}
    return found, missing


def compare(now, before, factor):
    """Lines about each kernel, the names of those that got slower, and of those that have
    no record."""
    lines, slower = [], []
    for name, ratio in now.items():
        if name not in before:
            continue
        change = {key: ratio[key] / before[name][key] for key in ("peer", "copy")}
        beyond = [key for key, value in change.items() if value > factor]
        says = f"slower beside the {beyond[0]} alone" if len(beyond) == 1 else ""
        if len(beyond) == 2:
            slower.append(name)
            says = "SLOWER"
        lines.append(
            f"{name:45} {ratio['peer']:9.3g} of its peer ({change['peer']:.2f}x), "
            f"{ratio['copy']:8.3g} copies ({change['copy']:.2f}x) {says}".rstrip()
        )
    return lines, slower, sorted(set(now) - set(before))


def processor():
    try:
        flags = set(pathlib.Path("/proc/cpuinfo").read_text().split())
    except OSError:
        flags = set()
    level = next((name for name in ("avx512f", "avx2") if name in flags), "baseline")
    return f"{platform.machine()}, {level}"


def main():
    parser = argparse.ArgumentParser(description="Says which kernels got slower.")
    parser.add_argument("--run", action="store_true", help="measure first")
    parser.add_argument("--record", action="store_true", help="record these ratios")
    parser.add_argument("--factor", type=float, default=1.3, help="what counts as slower")
    parser.add_argument("--criterion", type=pathlib.Path, help="folder that benches have left")
    parser.add_argument(
        "--bench",
        action="append",
        choices=sorted(BENCHES),
        help="run, compare or record the groups of this one; may be repeated",
    )
    parser.add_argument(
        "--group",
        action="append",
        choices=sorted(KERNELS),
        help="run, compare or record the kernels of this group; may be repeated",
    )
    arguments = parser.parse_args()
    try:
        groups = chosen_groups(arguments.bench, arguments.group)
    except ValueError as error:
        parser.error(str(error))
    keeps_others = set(groups) != set(KERNELS)
    # Before the benches run, which would be in vain.
    if arguments.record and keeps_others:
        recorded_on = json.loads(RECORD.read_text())["processor"]
        if recorded_on != processor():
            sys.exit(f"the other groups were recorded on {recorded_on}")
    if arguments.run:
        run_benches(groups)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    times = read_times(arguments.criterion or target / "criterion")
    now, missing = ratios(times, groups)
    if missing:
        sys.exit("no times of " + "; ".join(missing) + "\n(--run measures them)")
    if arguments.record:
        rounded = {
            name: {key: float(f"{value:.4g}") for key, value in ratio.items()}
            for name, ratio in now.items()
        }
        if keeps_others:
            rounded = {**json.loads(RECORD.read_text())["ratios"], **rounded}
        text = json.dumps({"processor": processor(), "ratios": rounded}, indent=2)
        RECORD.write_text(text + "\n")
        return
    record = json.loads(RECORD.read_text())
    if record["processor"] != processor():
        print(f"recorded on {record['processor']}; this is {processor()}")
    lines, slower, unknown = compare(now, record["ratios"], arguments.factor)
    print("\n".join(lines))
    if unknown:
        sys.exit("no record of " + "; ".join(unknown) + "\n(--record makes one)")
    if slower:
        sys.exit(f"slower by more than {arguments.factor}: " + "; ".join(slower))


if __name__ == "__main__":
    main()
