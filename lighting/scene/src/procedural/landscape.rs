//! Fractal mountains.

use glam::{Vec2, Vec3};

use super::primitives::terrain_block;
use super::random::value_noise;
use super::stage::{Stage, fog, look, paint};
use crate::{Bounds, DirectionalLight, Light, PhaseFunction, Scene};

/// Length of a side, m.
const SIZE: f32 = 6000.0;
/// Height of the highest possible summit, m.
const RELIEF: f32 = 1100.0;

/// 256 × 256 cells of ridged noise: six octaves, each half as large and half
/// as high as the last, folded at the middle so that summits become ridges.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let ground = |p: Vec2| height(seed, p);
    stage.add(
        "terrain",
        terrain_block(256, SIZE, -200.0, ground),
        paint(0.42, 0.40, 0.36),
    );

    let eye = Vec2::new(150.0, 2300.0);
    let eye = Vec3::new(eye.x, ground(eye) + 260.0, eye.y);
    let sun = DirectionalLight {
        direction: Vec3::new(0.35, -0.30, 1.0),
        irradiance: Vec3::new(7.5, 5.9, 4.4),
        ..DirectionalLight::default()
    };
    let half = 0.5 * SIZE;
    let air = Bounds::new(
        Vec3::new(-half, -200.0, -half),
        Vec3::new(half, 1.4 * RELIEF, half),
    )
    .expect("numbers of this program");
    let haze = fog(
        Vec3::new(1.6e-4, 2.0e-4, 2.8e-4),
        Vec3::splat(1e-5),
        PhaseFunction::HenyeyGreenstein { g: 0.5 },
    );
    stage.seen(
        look(eye, eye + Vec3::new(-200.0, -120.0, -1000.0), 50.0),
        vec![Light::Directional(sun)],
        haze.within(air),
    )
}

fn height(seed: u64, position: Vec2) -> f32 {
    let mut p = position / 2100.0 + 17.3;
    let (mut sum, mut amplitude, mut weight) = (0.0, 0.5, 1.0);
    for octave in 0..6 {
        let fold = 1.0 - (2.0 * value_noise(seed.wrapping_add(octave), p) - 1.0).abs();
        // Detail gathers on the ridges; valleys stay smooth.
        let ridge = fold * fold * weight;
        sum += amplitude * ridge;
        weight = (2.0 * ridge).min(1.0);
        amplitude *= 0.5;
        // Turned by a Pythagorean angle, so that lattices do not line up.
        p = 2.0 * Vec2::new(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y);
    }
    RELIEF * sum
}
