#!/usr/bin/env python3
"""How far `crepuscular plan` is off, over embedded scenes.

    cargo build --release
    tests/scripts/prediction.py [--size WxH] [--methods NAMES] [--leave-out] [--keep FOLDER] [SCENE ...]

For each scene `plan --analyze --json` foresees every method at every quality and then runs
all of them. Prints q-errors (the larger of estimate / actual and its inverse) of the time of a
frame, of the time before the first one, and of the RMSE; what the choice for a few
targets costs beside the best choice (regret); and how often it misses its target by more than
half. Targets of a scene are errors and times between the least and the largest that came out.
What is chosen within a time is asked from `plan --time`, which measures settings that are in doubt.

With --leave-out each scene is foreseen with a profile of the machine that was learned from the
other scenes; without, with none. A method costs what `plan --calibrate` finds in the median
scene: it learns from each scene once, alone. Times are the minima of interleaved repetitions, RMSE below
1e-5 counts as 1e-5. Where copies of memory took more than 20 % longer than the fastest, the
machine was not quiet, and times are printed but not judged.
"""

import argparse
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

SCENES = ["city", "landscape", "fence", "coil", "smoke", "textured-spot", "stiff", "translucent"]
LEAST = 1e-5
# What is asked for: median and 95th percentile, or worst.
TIME, RMSE, REGRET, MISSED = (1.3, 2.0), (1.5, 3.0), (1.1, 2.0), 0.05


def quantile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, max(0, -int(-share * len(values) // 1) - 1))] if values else float("nan")


def ratio(a, b):
    return max(a / b, b / a) if a > 0 and b > 0 else float("inf")


def analyzed(asked, scene, profile):
    command = [asked.program, "-q", "plan", scene, "--size", asked.size, "--backend", "cpu", "--analyze", "--json"]
    command += ["--profile", str(profile), *only(asked)]
    return json.loads(ran(command))


def chosen_within(asked, scene, profile, report):
    """What the program chooses within a few times."""
    found = rows(report)
    chosen = []
    for target in targets([row["time"][1] for row in found]) if found else []:
        command = [asked.program, "-q", "plan", scene, "--size", asked.size, "--backend", "cpu", "--json"]
        command += ["--profile", str(profile), "--time", f"{1e3 * target:.9g}ms", *only(asked)]
        choice = json.loads(ran(command, may_find_nothing=True))["choice"]
        chosen.append({"time": target, **{key: choice[key] for key in ("met", "method", "quality")}})
    return chosen


def learned(asked, scene, folder):
    """The profile of the machine that one scene gives."""
    file = folder / f"of-{scene}.json"
    if not file.exists():
        command = [asked.program, "-q", "plan", "--calibrate", scene, "--size", "80x45", "--backend", "cpu"]
        ran([*command, "--profile", str(file), *only(asked)])
    return json.loads(file.read_text())


def median_profile(profiles):
    """The profile with the lower median of each cost of each method."""
    costs = {}
    for method in (method for profile in profiles for method in profile["methods"]):
        for cost in ("seconds_once_per_unit", "seconds_frame_per_unit"):
            costs.setdefault((method["backend"], method["method"]), {}).setdefault(cost, []).append(method[cost])
    methods = [
        {"backend": backend, "method": method, **{cost: quantile(values, 0.5) for cost, values in own.items()}}
        for (backend, method), own in costs.items()
    ]
    return {"format": "crepuscular machine profile", "version": 1, "methods": methods}


def ran(command, may_find_nothing=False):
    """What a command prints; its errors end the script."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    except OSError as error:
        sys.exit(f"{command[0]}: {error.strerror}")
    if done.returncode != 0 and not (may_find_nothing and done.stdout):
        sys.exit(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def file_name(asked, scene):
    """The name of a report, by all that it depends on."""
    learned = sorted(set(asked.scenes) - {scene}) if asked.leave_out else []
    what = json.dumps([asked.methods or "", asked.leave_out, learned])
    return f"{scene}-{asked.size}-{hashlib.sha256(what.encode()).hexdigest()[:12]}.json"


def only(asked):
    return ["--methods", asked.methods] if asked.methods else []


def rows(report):
    """Rows with what came out; errors floored."""
    found = []
    for row in report["rows"]:
        actual = row["actual"]
        if actual is None or actual["error_rmse"] is None or row["error_rmse"] is None:
            continue
        found.append({
            "scene": report["scene"],
            "method": row["method"],
            "quality": row["quality"],
            "known": row["known"],
            "time": (row["seconds_frame"], actual["seconds_frame_min"]),
            "once": (row["seconds_build"], actual["seconds_build"]),
            "rmse": (max(row["error_rmse"], LEAST), max(actual["error_rmse"], LEAST)),
        })
    return found


def targets(values):
    low, high = min(values), max(values)
    return [low * (high / low) ** (k / 5) for k in range(1, 5)]


def choices(found, within):
    """(what, target, regret, how many times the target is exceeded) for a few targets; what is
    `within` times was chosen by the program."""
    out = []

    def add(what, other, target, chosen):
        best = [row[other][1] for row in found if row[what][1] <= target]
        if chosen and best:
            out.append((what, target, max(1.0, chosen[other][1] / min(best)), chosen[what][1] / target))

    for target in targets([row["rmse"][1] for row in found]) if found else []:
        meeting = [row for row in found if row["rmse"][0] <= target]
        add("rmse", "time", target, min(meeting, key=lambda row: row["time"][0], default=None))
    for choice in within:
        names = [row for row in found if (row["method"], row["quality"]) == (choice["method"], choice["quality"])]
        add("time", "rmse", choice["time"], names[0] if choice["met"] and names else None)
    return out


def verdict(value, limit):
    return "ok" if value <= limit else f"above {limit}"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--program", default="target/release/crepuscular")
    arguments.add_argument("--size", default="240x135")
    arguments.add_argument("--methods", help="only methods whose name contains one of these, by commas")
    arguments.add_argument("--leave-out", action="store_true")
    arguments.add_argument("--keep", type=pathlib.Path, help="folder for the reports; those there are read again")
    arguments.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    asked = arguments.parse_args()
    if asked.leave_out and len(set(asked.scenes)) < 2:
        arguments.error("--leave-out learns from the other scenes: name at least two")
    found, made, copies = [], [], {}
    with tempfile.TemporaryDirectory() as folder:
        keep = asked.keep or pathlib.Path(folder)
        keep.mkdir(parents=True, exist_ok=True)
        for scene in asked.scenes:
            file = keep / file_name(asked, scene)
            if not file.exists():
                profile = pathlib.Path(folder) / f"without-{scene}.json"
                others = [other for other in asked.scenes if other != scene] if asked.leave_out else []
                known = median_profile([learned(asked, other, pathlib.Path(folder)) for other in others])
                profile.write_text(json.dumps(known))
                report = analyzed(asked, scene, profile)
                report["within"] = chosen_within(asked, scene, profile, report)
                file.write_text(json.dumps(report))
            report = json.loads(file.read_text())
            own = rows(report)
            copies[scene] = (report["analysis"] or {}).get("copy_spread", 0.0)
            found += own
            made += [(scene, *choice) for choice in choices(own, report["within"])]
            time, rmse = ([ratio(*row[what]) for row in own] for what in ("time", "rmse"))
            print(
                f"{scene:14} {len(own):4} rows, {len(report['skipped']):3} skipped, copies ±{100 * copies[scene]:.0f} %: "
                f"time {quantile(time, 0.5):.2f} / {quantile(time, 0.95):.2f}, "
                f"RMSE {quantile(rmse, 0.5):.2f} / {quantile(rmse, 0.95):.2f}",
                flush=True,
            )
    if not found:
        sys.exit("no row has both a forecast and what came out")
    quiet = max(copies.values()) <= 0.2
    print()
    for what, limits in (("time", TIME), ("once", TIME), ("rmse", RMSE)):
        errors = [ratio(*row[what]) for row in found if min(row[what]) > 1e-4 or what != "once"]
        judged = quiet or what == "rmse"
        for name, share, limit in (("median", 0.5, limits[0]), ("95th percentile", 0.95, limits[1])):
            value = quantile(errors, share)
            print(f"q-error of {what:5} {name:16} {value:6.2f}  {verdict(value, limit) if judged else 'not judged'}")
    for method in sorted({row["method"] for row in found}):
        own = [row for row in found if row["method"] == method]
        signs = [row["time"][0] / row["time"][1] for row in own]
        worst = max(own, key=lambda row: ratio(*row["rmse"]))
        print(
            f"  {method:34} time q {quantile([ratio(*row['time']) for row in own], 0.5):5.2f}, estimate / actual "
            f"{quantile(signs, 0.5):5.2f}; RMSE q {quantile([ratio(*row['rmse']) for row in own], 0.5):5.2f}, worst "
            f"{ratio(*worst['rmse']):6.2f} ({worst['scene']}, {worst['quality']}, {worst['known']})"
        )
    regrets = [regret for _, _, _, regret, _ in made]
    missed = sum(over > 1.5 for *_, over in made) / max(1, len(made))
    for name, value, limit in (
        ("regret, median", quantile(regrets, 0.5), REGRET[0]),
        ("regret, worst", max(regrets, default=float("nan")), REGRET[1]),
        ("targets missed by more than half", missed, MISSED),
    ):
        print(f"{name:33} {value:6.2f}  {verdict(value, limit) if quiet else 'not judged'}")
    for scene, what, target, regret, over in sorted(made, key=lambda choice: -choice[3])[:5]:
        print(f"  {scene}: {what} ≤ {target:.2e}: regret {regret:.2f}, {over:.2f} of the target")
    if not quiet:
        worst = max(copies, key=copies.get)
        print(f"times are not judged: copies beside {worst} took {100 * copies[worst]:.0f} % longer than the fastest")


if __name__ == "__main__":
    main()
