//! A ball of strands.

use glam::Vec3;

use super::primitives::{append, cuboid, tube};
use super::random::Random;
use super::stage::{Stage, fog, look, paint};
use crate::{Light, Mesh, PhaseFunction, PointLight, Scene};

const STRANDS: u32 = 1500;
const SEGMENTS: u32 = 16;
/// Radius of a strand over that of the ball.
const THICKNESS: f32 = 0.006;

/// Each strand is a closed tube of three sides that starts near the centre
/// and wanders outwards; all are one mesh. The lamp sits between them, off the
/// centre, so that light leaves the ball in shafts.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    strands(&mut stage, seed);
    let lamp = PointLight {
        position: Vec3::new(0.45, 0.45, 0.30),
        intensity: Vec3::new(20.0, 16.0, 12.0),
        range: f32::INFINITY,
        ..PointLight::default()
    };
    seen(stage, Light::Point(lamp))
}

/// The same under a glowing rectangle above the picture.
pub(super) fn under_a_panel(mut stage: Stage, seed: u64) -> Scene {
    strands(&mut stage, seed);
    let radiance = Vec3::new(110.0, 95.0, 80.0);
    let panel = stage.panel(Vec3::new(-0.9, 2.6, -0.6), [1.8, 1.2], radiance);
    seen(stage, Light::Area(panel))
}

fn strands(stage: &mut Stage, seed: u64) {
    let mut random = Random::new(seed);
    let mut hair = Mesh::default();
    for _ in 0..STRANDS {
        append(&mut hair, &strand(&mut random));
    }
    stage.add("strands", hair, paint(0.75, 0.50, 0.30));
    let floor = cuboid(Vec3::new(-6.0, -1.75, -6.0), Vec3::new(6.0, -1.6, 6.0));
    stage.add("floor", floor, paint(0.5, 0.5, 0.5));
}

fn seen(stage: Stage, light: Light) -> Scene {
    stage.seen(
        look(Vec3::new(0.2, 0.6, 3.4), Vec3::new(0.1, 0.05, 0.0), 45.0),
        vec![light],
        fog(
            Vec3::splat(0.18),
            Vec3::splat(0.02),
            PhaseFunction::HenyeyGreenstein { g: 0.3 },
        ),
    )
}

fn strand(random: &mut Random) -> Mesh {
    let start = random.direction();
    let curl = 0.45 * random.direction();
    let reach = random.between(0.9, 1.3);
    let step = reach / SEGMENTS as f32;
    let mut heading = start;
    let mut position = 0.12 * start;
    let mut curve = vec![position];
    for _ in 0..SEGMENTS {
        heading = (heading + curl.cross(heading) + 0.25 * random.in_ball()).normalize_or(start);
        position += step * (heading + 0.9 * position.normalize_or(start)).normalize_or(start);
        curve.push(position);
    }
    tube(&curve, THICKNESS, 3)
}
