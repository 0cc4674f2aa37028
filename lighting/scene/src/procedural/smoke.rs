//! Three columns of puffs.

use glam::Vec3;

use super::primitives::{cuboid, icosphere};
use super::random::{Random, circle};
use super::stage::{Stage, aim, fog, look, paint, upright};
use crate::{Cone, Light, PhaseFunction, Scene, SpotLight};

const COLUMNS: u32 = 3;
const PUFFS_PER_COLUMN: u32 = 200;
/// Radius of the opaque ball that stands for a puff, over the puff's radius.
const OPAQUE_CORE: f32 = 0.5;

/// A ball of denser air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Puff {
    /// World position, m.
    pub centre: Vec3,
    /// Radius, m.
    pub radius: f32,
    /// Extinction coefficient inside, 1/m.
    pub sigma_t: f32,
}

/// The puffs of [`Embedded::Smoke`](super::Embedded::Smoke): three columns of
/// 200 that start narrow and dense on the floor, widen and thin out as they
/// rise, and lean with the wind. Neighbours overlap.
pub fn smoke_puffs(seed: u64) -> Vec<Puff> {
    let mut random = Random::new(seed);
    let mut puffs = Vec::with_capacity((COLUMNS * PUFFS_PER_COLUMN) as usize);
    for column in 0..COLUMNS {
        let foot = Vec3::new(-2.6 + 2.2 * column as f32, 0.1, random.between(-0.6, 0.6));
        let sway = random.unit();
        for i in 0..PUFFS_PER_COLUMN {
            let t = (i as f32 + random.unit()) / PUFFS_PER_COLUMN as f32;
            let width = 0.12 + 0.75 * t;
            let wind = 0.9 * t * t + 0.18 * circle(sway + 1.4 * t).y;
            let axis = foot + Vec3::new(wind, 4.6 * t, 0.12 * circle(sway + 1.1 * t).x);
            puffs.push(Puff {
                centre: axis + width * random.in_ball() * Vec3::new(1.0, 0.6, 1.0),
                radius: random.between(0.10, 0.16) + 0.16 * t,
                sigma_t: random.between(0.7, 1.3) * (6.0 - 4.5 * t),
            });
        }
    }
    puffs
}

/// The spotlight stands behind the columns and shines past them at the eye.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let ball = stage.shape("puff", icosphere(2), paint(0.55, 0.55, 0.58));
    for puff in smoke_puffs(seed) {
        let radius = Vec3::splat(OPAQUE_CORE * puff.radius);
        stage.place(ball, upright(radius, 0.0, puff.centre));
    }
    let floor = cuboid(Vec3::new(-14.0, -0.3, -12.0), Vec3::new(14.0, 0.0, 12.0));
    stage.add("floor", floor, paint(0.45, 0.45, 0.45));

    let position = Vec3::new(-1.0, 5.2, -6.0);
    let spot = SpotLight {
        position,
        rotation: aim(position, Vec3::new(0.3, 2.0, 0.0)),
        intensity: Vec3::new(420.0, 370.0, 300.0),
        range: f32::INFINITY,
        cone: Cone {
            inner: 0.55,
            outer: 0.75,
        },
        texture: None,
        ..SpotLight::default()
    };
    stage.seen(
        look(Vec3::new(1.2, 2.0, 9.0), Vec3::new(0.2, 2.4, 0.0), 48.0),
        vec![Light::Spot(spot)],
        fog(
            Vec3::splat(0.045),
            Vec3::splat(0.005),
            PhaseFunction::HenyeyGreenstein { g: 0.4 },
        ),
    )
}
