//! A scene for the numbers rather than for the eye.

use glam::{Affine3A, Vec3};

use super::primitives::cuboid;
use super::random::Random;
use super::stage::{Stage, fog, look, paint};
use crate::{Bounds, Light, PhaseFunction, PointLight, Scene};

/// Where the eye is.
const EYE: Vec3 = Vec3::new(0.0, 0.0, 0.0);
/// Slabs along the wall, and how far apart they are, m.
const SLABS: u32 = 30;
const PITCH: f32 = 0.4;

/// A gallery along −Z. One lamp hangs 5 mm from the eye. The other is 10 km
/// away, outside of the medium, bright enough that its irradiance is that of a
/// sun, and shines through the gaps of the wall on the right. The wall on the
/// left is tilted by 1 mrad to the gallery, whose vanishing point is in view,
/// and the shelf below by 0.1 mrad to the light.
pub(super) fn build(mut stage: Stage, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let slab = stage.shape(
        "slab",
        cuboid(Vec3::new(0.0, -1.0, -0.11), Vec3::new(0.04, 1.0, 0.11)),
        paint(0.5, 0.5, 0.5),
    );
    for i in 0..SLABS {
        let z = -0.35 - PITCH * i as f32 + random.between(-0.05, 0.05);
        let position = Vec3::new(0.55, 0.0, z);
        stage.place(slab, Affine3A::from_translation(position));
    }
    let far = -(PITCH * SLABS as f32) - 2.0;
    let mut wall = cuboid(Vec3::new(-0.6, -1.0, far), Vec3::new(-0.5, 1.0, 1.0));
    let mut shelf = cuboid(Vec3::new(-0.5, -0.4, far), Vec3::new(0.54, -0.35, 1.0));
    let towards = Vec3::new(0.8, 0.36, -0.48);
    for position in &mut wall.positions {
        position.x += 1e-3 * position.z;
    }
    for position in &mut shelf.positions {
        position.y += (towards.y / towards.x - 1e-4) * position.x;
    }
    stage.add("tilted wall", wall, paint(0.6, 0.6, 0.6));
    stage.add("shelf", shelf, paint(0.6, 0.6, 0.6));

    let near = PointLight {
        position: EYE + Vec3::new(-0.004, 0.002, -0.002),
        intensity: Vec3::splat(1.5e-4),
        range: f32::INFINITY,
        ..PointLight::default()
    };
    let distant = PointLight {
        position: 1e4 * towards,
        intensity: 1e8 * Vec3::new(75.0, 60.0, 42.0),
        range: f32::INFINITY,
        ..PointLight::default()
    };
    let air = Bounds::new(Vec3::new(-0.8, -1.2, -20.0), Vec3::new(0.8, 1.2, 1.2))
        .expect("numbers of this program");
    let murk = fog(
        Vec3::new(2.4, 3.0, 3.8),
        Vec3::splat(0.1),
        PhaseFunction::HenyeyGreenstein { g: 0.2 },
    );
    stage.seen(
        look(EYE, Vec3::new(0.25, -0.08, -1.0), 60.0),
        vec![Light::Point(near), Light::Point(distant)],
        murk.within(air),
    )
}
