#!/usr/bin/env python3
"""Writes the tables of error and cost in the README of each crate from reports.

    tests/scripts/readme_tables.py REPORT ...

A report is a folder that `crepuscular compare` has written; together they need the
studies named below, for which these three are enough:

    crepuscular compare smoke -o smoke
    crepuscular compare translucent -o translucent
    crepuscular compare city -o city
    tests/scripts/readme_tables.py smoke translucent city

Where several reports have rows of a study the last one counts. Between the lines
`<!-- table: NAME.csv -->` and `<!-- end -->` everything is replaced. Times are ratios
within one report, so that they need no machine beside them.

Needs Python 3.8 or later; nothing else.
"""

import argparse
import csv
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def number(text):
    return float(text) if text else None


def figure(value, digits=2):
    """A number with so many digits that count."""
    if value == 0:
        return "0"
    if value < 1e-3:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text else text


def size(count):
    for unit in ("bytes", "KiB", "MiB", "GiB"):
        if count < 1024 or unit == "GiB":
            return f"{figure(count, 3)} {unit}"
        count /= 1024


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def airlight(rows):
    name = lambda row: (row["evaluator"], row["setting"])
    base = number(next(r for r in rows if name(r) == ("table of the scaled tail", "64 KiB"))["ordinary_seconds"])
    kept = [
        ("table of the scaled tail", "`Table`"),
        ("table of a frame", "`FrameTable`"),
        ("quadrature to a tolerance", "`Quadrature`, tolerance"),
        ("exact, in double precision", "`Exact`"),
    ]
    out = []
    for evaluator, title in kept:
        of_it = [row for row in rows if row["evaluator"] == evaluator]
        if len(of_it) > 3:
            of_it = [of_it[0], of_it[-1]] if evaluator.startswith("table") else [of_it[0], of_it[2], of_it[-1]]
        for row in of_it:
            setting = "" if evaluator.startswith("exact") else " " + row["setting"]
            ordinary, stiff = number(row["ordinary_worst"]), number(row["stiff_worst"])
            seconds = number(row["ordinary_seconds"])
            out.append([title + setting, figure(ordinary), figure(stiff), figure(seconds / base)])
    return (
        "Worst relative error of any of many rays, and the time per ray of a batch on the CPU,\n"
        "that of the table of 64 KiB being 1. Ordinary rays pass lamps in haze; stiff ones pass\n"
        "next to the light, through dense fog, or are very short. Results are f32, which rounds\n"
        "by 6e-8; `Exact` itself is right to 1e-12.\n\n"
        + table(["evaluator", "ordinary rays", "stiff rays", "time"], out)
    )


def voxels(rows):
    errors = [row for row in rows if row["what"] == "rmse rest fine" and row["of"] == "all"]
    steps = [row for row in rows if row["what"].startswith("seconds") and row["of"] == "cpu"]
    build = sum(number(row["value"]) for row in steps if "gather" not in row["what"])
    runs = next(number(row["value"]) for row in steps if row["what"] == "seconds gather runs")
    out = [[f"{row['size']}³", figure(100 * number(row["value"])) + " %"] for row in errors]
    return (
        "The embedded scene `city`, a sun over 327,000 triangles, shadow maps as fine as the\n"
        "voxels: RMSE of the light in the air over its mean. At 512³ the grid is made in\n"
        f"{figure(build / runs)} of the time in which lit runs of all rays are found and integrated.\n\n"
        + table(["voxels", "error"], out)
    )


def curves(rows):
    def mean_over(curve, setting, column):
        values = [number(r[column]) for r in rows if r["curve"] == curve and r["setting"] == setting]
        product = 1.0
        for value in values:
            product *= value
        return product ** (1 / len(values))

    base = "adaptive, the paper's rule", "8"
    kept = [
        ("adaptive, the paper's rule", "8", "`Curve<8, Linear>`"),
        ("adaptive, the paper's rule", "16", "`Curve<16, Linear>`"),
        ("adaptive, least area", "8", "`Stream<8>`"),
        ("adaptive, least area", "16", "`Stream<16>`"),
        ("adaptive, least maximum", "8", "`Stream<8, Maximum>`"),
        ("opacity map", "32", "opacity map, 32 slices"),
        ("Fourier opacity map", "16", "Fourier opacity map, 16 terms"),
        ("moments", "4", "4 moments"),
    ]
    out = []
    for curve, setting, title in kept:
        values = [mean_over(curve, setting, column) for column in ("mean", "max", "bytes")]
        times = [
            mean_over(curve, setting, column) / mean_over(*base, column)
            for column in ("seconds_segment", "seconds_lookup")
        ]
        out.append([title, figure(values[0]), figure(values[1]), f"{values[2]:.0f}"] + [figure(t) for t in times])
    count = len({row["subject"] for row in rows})
    return (
        f"Geometric means over {count} kinds of smoke and hair: mean and largest error of the\n"
        "transmittance, bytes of a curve, and the times to insert a segment and to look up a depth,\n"
        "those of the paper's rule with 8 nodes being 1.\n\n"
        + table(["curve", "mean error", "largest", "bytes", "insert", "look up"], out)
    )


def precomputed(rows):
    files = {row["voxels"]: number(row["value"]) for row in rows if row["what"] == "file packed"}
    bakes = {}
    for row in rows:
        if row["what"] == "bake" and row["unit"] == "seconds":
            bakes[row["voxels"]] = bakes.get(row["voxels"], 0.0) + number(row["value"])
    first = bakes[min(bakes, key=int)]
    out = [
        [f"{voxels}³", size(count), figure(2 * int(voxels) ** 2 / count), figure(bakes[voxels] / first)]
        for voxels, count in files.items()
    ]
    return (
        "The embedded scene `city`, a sun over 327,000 triangles of closed solids: the packed file,\n"
        "how many times as large a 16-bit shadow map is, and the time of the whole bake, that of\n"
        "the first row being 1.\n\n" + table(["voxels", "file", "16-bit map", "bake"], out)
    )


def results(rows):
    rows = [row for row in rows if row["backend"] == "cpu" and row["visibility"] != "none"]
    rows.sort(key=lambda row: number(row["seconds_frame"]))
    front = []
    for row in rows:
        error = number(row["error_rmse"])
        if not front or error < 0.7 * number(front[-1]["error_rmse"]):
            front.append(row)
    front = [row for row in front if number(row["error_rmse"]) < 0.2]
    first = number(front[0]["seconds_frame"])
    out = [
        [
            f"`{row['visibility']} x {row['airlight']}`" if row["airlight"] else f"`{row['visibility']}`",
            f"{row['quality']} {row['quality_unit']}",
            figure(100 * number(row["error_rmse"])) + " %",
            figure(number(row["seconds_frame"]) / first),
        ]
        for row in front
    ]
    names = {"width": front[0]["width"], "height": front[0]["height"], "scene": front[0]["scene"]}
    return (
        "The fastest methods for each error on the embedded scene `{scene}`, on the CPU, {width} × {height}\n"
        "pixels: RMSE of the light in the air over its mean, and the time of a frame without what\n"
        "is made once, that of the first row being 1. `crepuscular compare` makes this list for\n"
        "a scene of yours.\n\n".format(**names) + table(["method", "quality", "error", "frame"], out)
    )


WRITERS = {
    "airlight.csv": airlight,
    "voxels.csv": voxels,
    "curves.csv": curves,
    "precomputed-voxelized-shadows.csv": precomputed,
    "results.csv": results,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("report", type=pathlib.Path, nargs="+")
    reports = parser.parse_args().report
    place = re.compile(r"(<!-- table: (\S+) -->\n).*?(<!-- end -->)", re.DOTALL)
    missing = []
    for readme in sorted([*ROOT.glob("*/README.md"), *ROOT.glob("*/*/README.md")]):
        text = readme.read_text(encoding="utf-8")

        def fill(match):
            rows = []
            for report in reports:
                file = report / match.group(2)
                if file.is_file():
                    with open(file, newline="", encoding="utf-8") as lines:
                        rows = list(csv.DictReader(lines)) or rows
            if not rows:
                missing.append(match.group(2))
                return match.group(0)
            return f"{match.group(1)}\n{WRITERS[match.group(2)](rows)}\n\n{match.group(3)}"

        filled = place.sub(fill, text)
        if filled != text:
            readme.write_text(filled, encoding="utf-8")
            print(readme.relative_to(ROOT))
    if missing:
        sys.exit(f"no report has rows of {', '.join(missing)}")


if __name__ == "__main__":
    main()
