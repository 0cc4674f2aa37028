#!/usr/bin/env python3
"""Writes the tables of error and cost in each README and in docs from reports.

    tests/scripts/readme_tables.py REPORT ...

A report is a folder that `crepuscular compare` has written; together they need the
studies named below, for which these four are enough:

    crepuscular compare smoke -o smoke
    crepuscular compare translucent -o translucent
    crepuscular compare area-light -o area-light
    crepuscular compare city -o city
    tests/scripts/readme_tables.py smoke translucent area-light city

docs/choosing.md was written from a quick comparison (`--quick --backend cpu`) of each scene
that `crepuscular scenes` lists; tables that these have no rows for are left as they are.

Where several reports have rows of a study the last one counts. Between the lines
`<!-- table: NAME.csv -->`, or `<!-- table: NAME.csv: which -->`, and `<!-- end -->`
everything is replaced. Times are ratios within one report, so that they need no machine
beside them.

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


def values(rows):
    """Rows of `what,of,size,value` by their first three columns."""
    return {(row["what"], row["of"], row["size"]): number(row["value"]) for row in rows}


# Wyman and Ramsey 2008, table 1: frames per second with light gathered at all pixels, of
# brute force, of the hybrid, and of the light with a cookie; and the mesh that stands in.
MESHES = [
    ("sphere", "ball", 12.9, 85.0),
    ("elephant", "cluster of balls", 12.6, 89.6),
    ("spring", "spring", 14.6, 76.8),
    ("bunny", "dented ball", 11.9, 47.5),
    ("fairy", "crowd of balls", 12.3, 38.5),
    ("Buddha", "stack of rings", 12.2, 50.2),
    ("YeahRight", "tangle of rings", 11.1, 26.3),
]


def hybrid_speed(rows):
    of = values(rows)
    out = []
    for paper, ours, brute, hybrid in MESHES:
        frame = lambda name: of[("seconds frame", f"{ours} {name}", "150" if name == "brute force" else "50")]
        made = lambda name: of[("seconds of map and volumes", f"{ours} {name}", "150" if name == "brute force" else "50")]
        whole = (frame("brute force") + made("brute force")) / (frame("hybrid") + made("hybrid"))
        errors = [of[("rmse", f"{ours} brute force", "150")], of[("rmse", f"{ours} hybrid", "50")]]
        out.append(
            [paper, ours, figure(hybrid / brute), figure(frame("brute force") / frame("hybrid")), figure(whole)]
            + [figure(100 * error) + " %" for error in errors]
        )
    return table(
        ["paper's mesh", "ours", "paper", "gather", "all made anew", "error, brute force", "error, hybrid"], out
    )


def hybrid_steps(rows):
    of = values(rows)
    sizes = sorted({int(size) for what, name, size in of if what == "rmse of steps" and name == "hybrid"})
    base = of[("seconds of steps", "brute force", str(sizes[0]))]
    out = []
    for size in map(str, sizes):
        row = [size]
        for name in ("brute force", "hybrid"):
            row.append(figure(100 * of[("rmse of steps", name, size)]) + " %")
            row.append(figure(of[("seconds of steps", name, size)] / base))
        out.append(row)
    return table(["steps", "error, brute force", "time", "error, hybrid", "time"], out)


# Wyman and Dai 2013, table 1: milliseconds of map, voxels and scan together, for a volume
# for each light and for all at once.
VOLUMES = {1: (1.15, 2.37), 4: (4.22, 2.01), 16: (15.93, 2.18), 64: (63.34, 4.75), 256: (252.35, 12.12)}


def area_steps(rows):
    of = values(rows)
    out = []
    for lights, (separate, at_once) in VOLUMES.items():
        steps = ["shadow maps", "voxelise", "scan"]
        try:
            ours = [sum(of[(f"seconds {step}", way, str(lights))] for step in steps) for way in ("separate", "at once")]
            gathers = [of[("seconds gather", way, str(lights))] for way in ("separate", "at once")]
        except KeyError:
            continue
        out.append(
            [str(lights), figure(separate / at_once), figure(ours[0] / ours[1]), figure(gathers[0] / gathers[1])]
        )
    return table(["lights", "paper, made", "ours, made", "ours, gathered"], out)


# Salvi and others 2010, table 1: milliseconds to compress, and to look up with a
# bilinear filter; none where the paper has none.
CURVES = [
    ("adaptive, the paper's rule", "4", "AVSM 4", 0.5, 3.0),
    ("adaptive, the paper's rule", "8", "AVSM 8", 0.7, 5.4),
    ("adaptive, the paper's rule", "16", "AVSM 16", 1.6, 9.5),
    ("opacity map", "32", "opacity map, 32 slices", 1.0, 1.4),
    ("Fourier opacity map", "16", "Fourier, 16 terms", 1.1, 8.9),
    ("deep shadow map", "0.01", "deep shadow map, 0.01", 193.0, 52.0),
    ("uncompressed", "all", "uncompressed", None, 278.0),
]


def curves_of_the_paper(rows):
    rows = [row for row in rows if row["subject"].startswith("smoke: three columns")]
    of = {(row["curve"], row["setting"]): row for row in rows}
    base = of[CURVES[1][:2]]
    ratio = lambda row, column: figure(number(row[column]) / number(base[column]))
    out = []
    for curve, setting, title, compress, look_up in CURVES:
        row = of[(curve, setting)]
        out.append(
            [
                title,
                figure(compress / CURVES[1][3]) if compress else "",
                ratio(row, "seconds_segment"),
                figure(look_up / CURVES[1][4]),
                ratio(row, "seconds_lookup"),
                f"{number(row['bytes']):.0f}",
                figure(100 * number(row["mean"])) + " %",
                figure(100 * number(row["max"])) + " %",
            ]
        )
    return table(
        ["curve", "paper: build", "ours", "paper: look up", "ours", "bytes", "mean error", "largest"], out
    )


# Kämpe and others 2015, tables 2 and 4: megabytes of the closed city, and seconds to
# make them.
BAKES = {
    4096: (0.44, 0.113),
    8192: (0.84, 0.185),
    16384: (1.60, 0.377),
    32768: (3.05, 1.1),
    65536: (5.76, 3.3),
    131072: (10.85, 10.9),
    262144: (20.35, 38.1),
}


def bakes_of_the_paper(rows):
    of = {(row["what"], row["setting"], row["voxels"], row["unit"]): number(row["value"]) for row in rows}
    steps = sorted({setting for what, setting, _, _ in of if what == "bake"})
    total = lambda voxels: sum(of[("bake", step, str(voxels), "seconds")] for step in steps)
    size = lambda voxels: of[("file packed", "", str(voxels), "bytes")] / 1e6
    first = next(iter(BAKES))
    out = []
    for voxels, (megabytes, seconds) in BAKES.items():
        if ("file packed", "", str(voxels), "bytes") not in of:
            continue
        out.append(
            [
                f"{voxels // 1024}K³",
                f"{figure(megabytes, 3)} MB",
                f"{figure(size(voxels), 3)} MB",
                figure(megabytes / BAKES[first][0]),
                figure(size(voxels) / size(first)),
                figure(seconds / BAKES[first][1]),
                figure(total(voxels) / total(first)),
            ]
        )
    return table(
        ["voxels", "paper: size", "ours", "paper: growth", "ours", "paper: time's growth", "ours"], out
    )


def fastest(rows, error, seconds):
    """The method that is fastest among those with at most this error."""
    good = [row for row in rows if number(row["error_rmse"]) <= error]
    if not good:
        return "none"
    row = min(good, key=seconds)
    name = f"{row['visibility']} x {row['airlight']}" if row["airlight"] else row["visibility"]
    return f"`{name}` {row['quality']}"


def choices(rows):
    still = lambda row: number(row["seconds_frame"])
    moving = lambda row: number(row["seconds_build"]) + number(row["seconds_frame"])
    scenes = {}
    for row in rows:
        if row["backend"] == "cpu":
            scenes.setdefault((row["scene"], row["light"]), []).append(row)
    errors = [0.05, 0.01, 0.002]
    out = []
    for (scene, light), of_it in scenes.items():
        if all(row["visibility"] == "none" for row in of_it):
            continue
        for title, seconds in (("stands still", still), ("moves", moving)):
            out.append([f"`{scene}`", light, title] + [fastest(of_it, error, seconds) for error in errors])
    return table(["scene", "light", "all"] + [f"error ≤ {figure(100 * error)} %" for error in errors], out)


WRITERS = {
    "airlight.csv": airlight,
    "voxels.csv": voxels,
    "curves.csv": curves,
    "precomputed-voxelized-shadows.csv": precomputed,
    "results.csv": results,
    "marching.csv: speed": hybrid_speed,
    "marching.csv: steps": hybrid_steps,
    "area-lights.csv: steps": area_steps,
    "curves.csv: paper": curves_of_the_paper,
    "precomputed-voxelized-shadows.csv: paper": bakes_of_the_paper,
    "results.csv: choices": choices,
}

# Those that take the rows of all reports, not of the last that has any.
OF_ALL = {"results.csv: choices"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("report", type=pathlib.Path, nargs="+")
    reports = parser.parse_args().report
    place = re.compile(r"(<!-- table: (.+?) -->\n).*?(<!-- end -->)", re.DOTALL)
    missing = []
    for readme in sorted([*ROOT.glob("*/README.md"), *ROOT.glob("*/*/README.md"), *ROOT.glob("docs/*.md")]):
        text = readme.read_text(encoding="utf-8")

        def fill(match):
            rows = []
            for report in reports:
                file = report / match.group(2).split(":")[0]
                if file.is_file():
                    with open(file, newline="", encoding="utf-8") as lines:
                        found = list(csv.DictReader(lines))
                    rows = rows + found if match.group(2) in OF_ALL else found or rows
            if not rows:
                missing.append(match.group(2))
                return match.group(0)
            try:
                written = WRITERS[match.group(2)](rows)
            except LookupError:
                # A quick comparison, or one whose time was short.
                missing.append(f"all of {match.group(2)}")
                return match.group(0)
            return f"{match.group(1)}\n{written}\n\n{match.group(3)}"

        filled = place.sub(fill, text)
        if filled != text:
            readme.write_text(filled, encoding="utf-8")
            print(readme.relative_to(ROOT))
    if missing:
        sys.exit(f"no report has rows of {', '.join(missing)}")


if __name__ == "__main__":
    main()
