//! Scenes that are in smoke, after figures of Salvi et al., Adaptive Volumetric Shadow
//! Maps, EGSR 2010: smoke in a furnished room (figure 3), three columns (figure 4), hair
//! (figures 1 and 5).

use glam::{Vec2, Vec3};

use super::primitives::{cuboid, icosphere};
use super::random::{Random, value_noise};
use super::stage::{Stage, aim, fog, look, paint, upright};
use super::translucent::{POINTS, ponytail, smoke_grid};
use crate::{
    Bounds, Cone, DensityGrid, DirectionalLight, HeightFog, Interpolation, Light, PhaseFunction,
    PointLight, Scene, SpotLight, StrandPoint, Strands,
};

const FORWARDS: PhaseFunction = PhaseFunction::HenyeyGreenstein { g: 0.45 };

/// A plume of [`smoke_grid`] that fills a box, of this albedo.
fn plume(seed: u64, sigma_t: f32, [min, max]: [Vec3; 2], albedo: Vec3) -> DensityGrid {
    let plume = smoke_grid(seed, sigma_t).expect("numbers of this program");
    let bounds = Bounds::new(min, max).expect("numbers of this program");
    DensityGrid::new(
        bounds,
        plume.resolution(),
        plume.density().to_vec(),
        plume.scale(),
        plume.interpolation(),
    )
    .and_then(|grid| grid.with_albedo(albedo))
    .and_then(|grid| grid.with_phase(FORWARDS))
    .expect("densities that were fine before")
}

/// Smoke that has spread: swaths of noise, denser below `ceiling` of the height, nothing
/// on the faces of the box.
fn swaths(seed: u64, sigma_t: f32, [min, max]: [Vec3; 2], ceiling: f32) -> DensityGrid {
    const RESOLUTION: [u32; 3] = [64, 32, 64];
    let share = |index: u32, axis: usize| index as f32 / (RESOLUTION[axis] - 1) as f32;
    let mut density = Vec::with_capacity(RESOLUTION.iter().product::<u32>() as usize);
    for z in 0..RESOLUTION[2] {
        for y in 0..RESOLUTION[1] {
            for x in 0..RESOLUTION[0] {
                let at = Vec3::new(share(x, 0), share(y, 1), share(z, 2));
                density.push(swath(seed, at, ceiling));
            }
        }
    }
    let bounds = Bounds::new(min, max).expect("numbers of this program");
    DensityGrid::new(bounds, RESOLUTION, density, sigma_t, Interpolation::Linear)
        .and_then(|grid| grid.with_albedo(Vec3::new(0.95, 0.94, 0.92)))
        .and_then(|grid| grid.with_phase(FORWARDS))
        .expect("numbers of this program")
}

/// From 0 to 1.
fn swath(seed: u64, at: Vec3, ceiling: f32) -> f32 {
    let (mut noise, mut frequency, mut weight) = (0.0, 3.0, 0.5);
    for octave in 0..4 {
        let seed = seed.wrapping_add(1000 * octave);
        // Flat swaths: height counts twice, and two sheared planes are mixed.
        let a = Vec2::new(at.x + 0.6 * at.z, 1.7 * at.y + 0.3 * at.x) * frequency;
        let b = Vec2::new(at.z - 0.4 * at.x, 1.9 * at.y - 0.5 * at.z) * frequency;
        noise += weight * 0.5 * (value_noise(seed, a) + value_noise(seed ^ 0x2f0b, b));
        (frequency, weight) = (2.1 * frequency, 0.5 * weight);
    }
    let wisps = (3.2 * (noise - 0.36)).clamp(0.0, 1.0);
    let below = ((ceiling - at.y) / 0.25).clamp(0.0, 1.0);
    let inside = at.min(Vec3::ONE - at).min_element();
    wisps * wisps * below * (12.0 * inside).min(1.0)
}

/// A table and chairs, a shelf with books and a lamp in a room with a window, through
/// which the sun shines into smoke.
pub(super) fn room(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let plaster = || paint(0.62, 0.58, 0.52);
    let wood = || paint(0.36, 0.22, 0.12);
    let mut block = |name: &str, min: [f32; 3], max: [f32; 3], material| {
        stage.add(name, cuboid(min.into(), max.into()), material);
    };
    block(
        "floor",
        [-3.4, -0.2, -3.4],
        [3.4, 0.0, 4.6],
        paint(0.42, 0.30, 0.20),
    );
    block("ceiling", [-3.4, 3.0, -3.4], [3.4, 3.2, 4.6], plaster());
    block("back wall", [-3.4, 0.0, -3.4], [3.4, 3.0, -3.2], plaster());
    block("right wall", [3.2, 0.0, -3.2], [3.4, 3.0, 4.6], plaster());
    // The left wall has a window of four panes without glass.
    block("sill", [-3.4, 0.0, -3.2], [-3.2, 0.9, 4.6], plaster());
    block("lintel", [-3.4, 2.5, -3.2], [-3.2, 3.0, 4.6], plaster());
    block("jamb", [-3.4, 0.9, -3.2], [-3.2, 2.5, -1.7], plaster());
    block("jamb", [-3.4, 0.9, 0.9], [-3.2, 2.5, 4.6], plaster());
    block("mullion", [-3.34, 0.9, -0.46], [-3.26, 2.5, -0.34], wood());
    block("transom", [-3.35, 1.66, -1.7], [-3.25, 1.74, 0.9], wood());
    // The table and what is on it.
    block("table", [-0.9, 0.72, -1.1], [1.1, 0.78, 0.1], wood());
    for (x, z) in [(-0.8, -1.0), (0.95, -1.0), (-0.8, -0.05), (0.95, -0.05)] {
        block("leg", [x, 0.0, z], [x + 0.07, 0.72, z + 0.07], wood());
    }
    block(
        "book",
        [-0.55, 0.78, -0.55],
        [-0.25, 0.83, -0.33],
        paint(0.55, 0.12, 0.10),
    );
    block(
        "book",
        [-0.52, 0.83, -0.56],
        [-0.24, 0.87, -0.36],
        paint(0.12, 0.22, 0.45),
    );
    // Chairs.
    for (x, z, back) in [(-0.35, 0.25, 0.62), (0.45, -1.75, -1.79)] {
        block("seat", [x, 0.42, z], [x + 0.42, 0.46, z + 0.42], wood());
        let z = z.min(back);
        for (dx, dz) in [(0.0, 0.02), (0.37, 0.02), (0.0, 0.38), (0.37, 0.38)] {
            let [x, z] = [x + dx, z + dz];
            block("leg", [x, 0.0, z], [x + 0.05, 0.42, z + 0.05], wood());
        }
        block(
            "rest",
            [x, 0.46, back],
            [x + 0.42, 0.98, back + 0.04],
            wood(),
        );
    }
    // A shelf at the back wall, full of books.
    for board in 0..4 {
        let y = 0.1 + 0.55 * board as f32;
        block("board", [1.3, y, -3.2], [2.9, y + 0.04, -2.85], wood());
        if board == 3 {
            continue;
        }
        let mut x = 1.34;
        while x < 2.78 {
            let [thick, tall] = [random.between(0.03, 0.07), random.between(0.26, 0.42)];
            let [red, green, blue] = [0; 3].map(|_| random.between(0.08, 0.5));
            let colour = paint(red, green, blue);
            block(
                "book",
                [x, y + 0.04, -3.18],
                [x + thick, y + 0.04 + tall, -2.93],
                colour,
            );
            x += thick + 0.006;
        }
    }
    block(
        "picture",
        [-1.9, 1.3, -3.2],
        [-0.5, 2.3, -3.16],
        paint(0.20, 0.32, 0.34),
    );
    let ball = stage.shape("vase", icosphere(3), paint(0.20, 0.45, 0.50));
    stage.place(
        ball,
        upright(
            Vec3::new(0.13, 0.17, 0.13),
            0.0,
            Vec3::new(0.55, 0.95, -0.45),
        ),
    );

    let sun = DirectionalLight {
        direction: Vec3::new(0.86, -0.46, -0.1),
        irradiance: Vec3::new(9.5, 8.3, 6.6),
        ..DirectionalLight::default()
    };
    let lamp = Vec3::new(0.2, 2.75, -0.5);
    let hanging = SpotLight {
        position: lamp,
        rotation: aim(lamp, Vec3::new(0.1, 0.0, -0.49)),
        intensity: Vec3::new(9.0, 7.0, 4.6),
        cone: Cone {
            inner: 0.5,
            outer: 0.75,
        },
        range: f32::INFINITY,
        texture: None,
        ..SpotLight::default()
    };
    // Behind the camera, for what neither of them reaches.
    let fill = PointLight {
        position: Vec3::new(2.2, 2.6, 3.6),
        intensity: Vec3::new(4.2, 4.6, 5.4),
        ..PointLight::default()
    };
    // Outside there is as little of it before the window.
    let yard = Bounds::new(Vec3::new(-8.0, -0.2, -3.4), Vec3::new(3.4, 5.0, 4.6));
    let yard = yard.expect("numbers of this program");
    let mut scene = stage.seen(
        look(
            Vec3::new(0.9, 1.65, 4.2),
            Vec3::new(-0.15, 1.15, -0.8),
            52.0,
        ),
        vec![
            Light::Directional(sun),
            Light::Spot(hanging),
            Light::Point(fill),
        ],
        fog(
            Vec3::splat(0.02),
            Vec3::splat(0.001),
            PhaseFunction::Isotropic,
        )
        .within(yard),
    );
    let air = [Vec3::new(-3.1, 0.02, -3.1), Vec3::new(3.1, 2.9, 3.2)];
    let cigar = [Vec3::new(-0.75, 0.8, -1.15), Vec3::new(0.45, 2.6, 0.05)];
    scene.translucent = vec![
        swaths(seed, 0.9, air, 0.9).into(),
        plume(seed, 6.0, cigar, Vec3::new(0.93, 0.93, 0.95)).into(),
    ];
    scene
}

/// Three columns of smoke over a yard at a low sun, in fog that thins out with altitude.
pub(super) fn columns(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let yard = cuboid(Vec3::new(-40.0, -0.5, -40.0), Vec3::new(40.0, 0.0, 20.0));
    stage.add("yard", yard, paint(0.30, 0.28, 0.24));
    for (x, depth) in [(-9.0, -12.0), (-2.5, -15.0), (4.5, -13.0), (10.0, -11.0)] {
        let [wide, tall] = [random.between(2.2, 3.4), random.between(2.0, 4.5)];
        let shed = cuboid(
            Vec3::new(x - wide, 0.0, depth - 2.0),
            Vec3::new(x + wide, tall, depth + 2.0),
        );
        stage.add("shed", shed, paint(0.36, 0.32, 0.30));
    }
    let mut columns = Vec::new();
    for (index, (x, z)) in [(-3.6, -0.6), (0.2, 0.9), (3.9, -0.9)]
        .into_iter()
        .enumerate()
    {
        let foot = Vec3::new(x, 0.0, z);
        let stack = cuboid(
            foot - Vec3::new(0.35, 0.0, 0.35),
            foot + Vec3::new(0.35, 0.7, 0.35),
        );
        stage.add("stack", stack, paint(0.28, 0.16, 0.12));
        let half = Vec3::new(1.75, 0.0, 1.75);
        let top = foot + half + Vec3::new(0.0, 6.6, 0.0);
        let bounds = [foot - half + Vec3::new(0.0, 0.45, 0.0), top];
        let albedo = [0.96, 0.9, 0.8][index] * Vec3::new(1.0, 0.985, 0.96);
        let seed = seed.wrapping_add(index as u64);
        columns.push(plume(seed, 2.6 - 0.4 * index as f32, bounds, albedo).into());
    }
    let sun = DirectionalLight {
        direction: Vec3::new(0.82, -0.42, 0.38),
        irradiance: Vec3::new(7.5, 6.4, 4.8),
        ..DirectionalLight::default()
    };
    let haze = fog(Vec3::splat(0.002), Vec3::ZERO, PhaseFunction::Isotropic);
    let mut scene = stage.seen(
        look(Vec3::new(0.4, 2.4, 11.5), Vec3::new(0.2, 2.9, 0.0), 46.0),
        vec![Light::Directional(sun)],
        haze,
    );
    let sigma_s = Vec3::new(0.035, 0.038, 0.045);
    let ground = HeightFog::new(sigma_s, Vec3::splat(0.002), 0.0, 0.9, FORWARDS);
    scene.height_fog = Some(ground.expect("numbers of this program"));
    scene.translucent = columns;
    scene
}

/// A head with a ponytail in rising smoke, against a spotlight.
pub(super) fn hair(mut stage: Stage, seed: u64) -> Scene {
    let floor = cuboid(Vec3::new(-14.0, -0.3, -12.0), Vec3::new(14.0, 0.0, 8.0));
    stage.add("floor", floor, paint(0.35, 0.35, 0.37));
    let wall = cuboid(Vec3::new(-14.0, 0.0, -12.0), Vec3::new(14.0, 8.0, -11.5));
    stage.add("wall", wall, paint(0.25, 0.26, 0.30));
    let ball = stage.shape("head", icosphere(4), paint(0.72, 0.52, 0.42));
    let head = Vec3::new(-0.5, 1.95, 0.0);
    stage.place(ball, upright(Vec3::new(0.5, 0.6, 0.52), 0.0, head));
    let bust = stage.shape("bust", icosphere(3), paint(0.30, 0.32, 0.40));
    stage.place(
        bust,
        upright(
            Vec3::new(1.0, 1.0, 0.55),
            0.0,
            head - Vec3::new(0.0, 1.55, 0.0),
        ),
    );

    let strands = ponytail(seed, 2500, 0.005, 0.6).expect("numbers of this program");
    // Hanging to the right, as the camera sees it.
    let turned = |at: Vec3| Vec3::new(at.z, at.y, -at.x);
    let points = strands.points().iter().map(|point| StrandPoint {
        position: head + Vec3::new(0.36, 0.38, 0.0) + 1.35 * turned(point.position),
        ..*point
    });
    let ends = (1..=strands.len() as u32).map(|strand| strand * POINTS);
    let strands = Strands::new(points.collect(), ends.collect()).expect("numbers of this program");

    let rising = [Vec3::new(0.1, 0.02, -1.1), Vec3::new(2.7, 4.4, 1.3)];
    let behind = [Vec3::new(-3.2, 0.02, -2.6), Vec3::new(-0.9, 4.0, -0.4)];
    let position = Vec3::new(3.4, 4.6, -3.6);
    let spot = SpotLight {
        position,
        rotation: aim(position, Vec3::new(0.2, 1.5, 0.2)),
        intensity: Vec3::new(170.0, 155.0, 135.0),
        range: f32::INFINITY,
        cone: Cone {
            inner: 0.45,
            outer: 0.65,
        },
        texture: None,
        ..SpotLight::default()
    };
    let fill = Vec3::new(-4.0, 4.0, 5.0);
    let soft = SpotLight {
        position: fill,
        rotation: aim(fill, head),
        intensity: Vec3::new(16.0, 20.0, 30.0),
        ..spot.clone()
    };
    let mut scene = stage.seen(
        look(Vec3::new(0.7, 1.9, 6.2), Vec3::new(0.35, 1.75, 0.0), 42.0),
        vec![Light::Spot(spot), Light::Spot(soft)],
        fog(Vec3::splat(0.012), Vec3::splat(0.001), FORWARDS),
    );
    scene.translucent = vec![
        plume(seed, 3.2, rising, Vec3::new(0.95, 0.95, 0.97)).into(),
        plume(
            seed.wrapping_add(3),
            2.2,
            behind,
            Vec3::new(0.95, 0.9, 0.85),
        )
        .into(),
        strands.into(),
    ];
    scene
}
