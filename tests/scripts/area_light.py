"""The airlight of a rectangle above three boxes, by Mitsuba 3.

    pip install mitsuba numpy
    python tests/scripts/area_light.py

prints a mean and its standard error for each ray. The numbers are in
tests/reference/tests/area.rs, whose scene this is.
"""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

SIGMA_S, SIGMA_A = 0.10, 0.01
RADIANCE = 300.0
# Opposite corners.
BOXES = [
    ([-2.2, 3.1, -2.6], [-1.3, 3.2, 2.6]),
    ([-0.5, 3.3, -2.6], [0.4, 3.4, 2.6]),
    ([1.2, 3.0, -2.6], [2.0, 3.1, 2.6]),
]
# Origin and direction.
RAYS = [
    ([0.6, 2.2, 8.2], [0.0, 0.0, -1.0]),
    ([0.6, 2.2, 8.2], [-0.1, 0.07, -1.0]),
    ([0.6, 2.2, 8.2], [0.12, 0.02, -1.0]),
    ([-6.0, 1.0, 0.3], [1.0, 0.05, 0.02]),
    ([-6.0, 2.6, 0.3], [1.0, 0.0, -0.1]),
    ([0.1, 0.5, 0.2], [0.05, 1.0, 0.3]),
]
RUNS, SAMPLES = 24, 1 << 19


def scene(origin, direction):
    to_world = mi.ScalarTransform4f
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
    fog = {
        "type": "homogeneous",
        "albedo": {"type": "rgb", "value": SIGMA_S / (SIGMA_S + SIGMA_A)},
        "sigma_t": {"type": "rgb", "value": SIGMA_S + SIGMA_A},
        "phase": {"type": "isotropic"},
    }
    origin, direction = np.array(origin), np.array(direction)
    description = {
        "type": "scene",
        # Eye, air, light.
        "integrator": {"type": "volpathmis", "max_depth": 2, "hide_emitters": True},
        "fog": fog,
        "air": {
            "type": "sphere",
            "radius": 150.0,
            "bsdf": {"type": "null"},
            "interior": {"type": "ref", "id": "fog"},
        },
        # Down: the rectangle of Mitsuba is [-1, 1]² and faces +Z.
        "panel": {
            "type": "rectangle",
            "to_world": to_world()
            .translate([0.0, 5.2 - 1e-3, 0.0])
            .rotate([1, 0, 0], 90)
            .scale([0.7, 0.5, 1.0]),
            "bsdf": black,
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": RADIANCE}},
        },
        "sensor": {
            "type": "radiancemeter",
            "origin": origin.tolist(),
            "direction": (direction / np.linalg.norm(direction)).tolist(),
            "medium": {"type": "ref", "id": "fog"},
            "film": {
                "type": "hdrfilm",
                "width": 1,
                "height": 1,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
            },
            "sampler": {"type": "independent"},
        },
    }
    for i, (low, high) in enumerate(BOXES):
        low, high = np.array(low), np.array(high)
        description[f"box{i}"] = {
            "type": "cube",
            "to_world": to_world()
            .translate((0.5 * (low + high)).tolist())
            .scale((0.5 * (high - low)).tolist()),
            "bsdf": black,
        }
    return mi.load_dict(description)


for index, (origin, direction) in enumerate(RAYS):
    world = scene(origin, direction)
    runs = [
        float(np.array(mi.render(world, spp=SAMPLES, seed=seed)).mean())
        for seed in range(RUNS)
    ]
    error = np.std(runs, ddof=1) / np.sqrt(RUNS)
    print(f"({np.mean(runs):.6f}, {error:.6f}),  # ray {index}", flush=True)
