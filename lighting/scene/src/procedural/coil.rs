//! A spring around a lamp.

use glam::Vec3;

use super::primitives::{cuboid, tube};
use super::random::{Random, circle};
use super::stage::{Stage, fog, look, paint};
use crate::{Light, PhaseFunction, PointLight, Scene};

const TURNS: f32 = 7.0;
const SEGMENTS_PER_TURN: u32 = 72;

/// Seven turns of a tube of twenty sides. Light leaves between the windings as
/// sheets.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let phase = random.unit();
    let segments = TURNS as u32 * SEGMENTS_PER_TURN;
    let curve: Vec<Vec3> = (0..=segments)
        .map(|i| {
            let t = i as f32 / segments as f32;
            let p = (0.85 - 0.15 * t) * circle(TURNS * t + phase);
            Vec3::new(p.x, 0.15 + 3.0 * t, -p.y)
        })
        .collect();
    stage.add("coil", tube(&curve, 0.10, 20), paint(0.70, 0.45, 0.25));
    let floor = cuboid(Vec3::new(-12.0, -0.3, -12.0), Vec3::new(12.0, 0.0, 12.0));
    stage.add("floor", floor, paint(0.5, 0.5, 0.52));

    let lamp = PointLight {
        position: Vec3::new(0.0, 1.75, 0.0) + 0.05 * random.in_ball(),
        intensity: Vec3::new(32.0, 26.0, 18.0),
        range: f32::INFINITY,
        ..PointLight::default()
    };
    stage.seen(
        look(Vec3::new(0.0, 2.7, 5.4), Vec3::new(0.0, 1.55, 0.0), 46.0),
        vec![Light::Point(lamp)],
        fog(
            Vec3::splat(0.14),
            Vec3::splat(0.01),
            PhaseFunction::Isotropic,
        ),
    )
}
