//! Pickets and wires in front of a lamp.

use glam::Vec3;

use super::primitives::{append, cuboid, frustum, tube};
use super::random::Random;
use super::stage::{Stage, fog, look, paint, upright};
use crate::{Light, Mesh, PhaseFunction, PointLight, Scene};

const PICKETS: u32 = 41;
/// Distance between two pickets, m.
const SPACING: f32 = 0.22;
const WIRES: u32 = 26;

/// Pickets of varying height with pointed tips, two rails, and crossed wires
/// below the lower rail.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let half = 0.5 * SPACING * (PICKETS - 1) as f32;
    let iron = || paint(0.25, 0.24, 0.22);
    let bar = stage.shape("picket", frustum(6, 0.035, 0.035, 1.0), iron());
    let tip = stage.shape("tip", frustum(6, 0.06, 0.004, 0.22), iron());
    for i in 0..PICKETS {
        let jitter = random.between(-0.015, 0.015);
        let foot = Vec3::new(SPACING * i as f32 - half + jitter, -0.05, 0.0);
        let height = random.between(1.85, 2.05);
        let turns = random.unit();
        stage.place(bar, upright(Vec3::new(1.0, height, 1.0), turns, foot));
        let top = foot + (height - 0.04) * Vec3::Y;
        stage.place(tip, upright(Vec3::ONE, turns, top));
    }
    let rail = |y: f32| {
        let corner = Vec3::new(half + 0.1, 0.03, 0.02);
        cuboid(y * Vec3::Y - corner, y * Vec3::Y + corner)
    };
    stage.add("upper rail", rail(1.65), iron());
    stage.add("lower rail", rail(0.80), iron());
    stage.add("wires", lattice(half), iron());
    let floor = cuboid(Vec3::new(-14.0, -0.3, -14.0), Vec3::new(14.0, 0.0, 14.0));
    stage.add("floor", floor, paint(0.5, 0.5, 0.5));

    let lamp = PointLight {
        position: Vec3::new(0.44, 1.35, -1.8),
        intensity: Vec3::new(42.0, 34.0, 25.0),
        range: f32::INFINITY,
        ..PointLight::default()
    };
    stage.seen(
        look(Vec3::new(-1.3, 1.45, 3.9), Vec3::new(0.15, 1.2, 0.0), 50.0),
        vec![Light::Point(lamp)],
        fog(
            Vec3::splat(0.12),
            Vec3::splat(0.01),
            PhaseFunction::HenyeyGreenstein { g: 0.35 },
        ),
    )
}

/// Two sets of parallel wires between the floor and the lower rail.
fn lattice(half: f32) -> Mesh {
    let mut wires = Mesh::default();
    let reach = 2.0 * half / WIRES as f32;
    for i in 0..WIRES {
        let x = -half + reach * i as f32;
        for (from, to, z) in [(x, x + reach, -0.012), (x + reach, x, 0.012)] {
            let ends = [Vec3::new(from, 0.0, z), Vec3::new(to, 0.8, z)];
            append(&mut wires, &tube(&ends, 0.008, 4));
        }
    }
    wires
}
