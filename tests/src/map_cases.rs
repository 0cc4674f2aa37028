//! Casters, lights of every kind and rays past them, among them those at which runs of a
//! shadow map are hard to find.

use glam::{Quat, Vec3};
use lighting::scene::{Cone, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};
use lighting::{Emitter, Ray};
use reference::random::Random;

/// Rays of a view.
const RAYS: usize = 2000;

fn vector(random: &mut Random, size: f32) -> Vec3 {
    random.vector(size).into()
}

/// Two hundred triangles within about ±6 m.
///
/// # Panics
/// Never: random numbers are finite.
pub fn casters(random: &mut Random) -> Geometry {
    let positions = (0..200).flat_map(|_| {
        let corner = vector(random, 6.0);
        let size = random.between(0.1, 2.0);
        [
            corner,
            corner + vector(random, size),
            corner + vector(random, size),
        ]
    });
    let mesh = Mesh {
        positions: positions.collect(),
        triangles: (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).expect("sound triangles")
}

/// A light and an eye: eyes in front of and behind a light, in the plane through
/// it, on its axis and at it.
///
/// # Panics
/// Never: its lights are sound.
pub fn light_and_eye(random: &mut Random, number: u32) -> (Emitter, Vec3) {
    let at = |random: &mut Random| vector(random, 5.0);
    let point = |position, range, emission| Emitter::point(position, Vec3::ONE, range, emission);
    let position = at(random);
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, vector(random, 1.0).normalize_or(Vec3::X));
    let spot = |outer| {
        let cone = Cone { inner: 0.0, outer };
        Emission::spot(rotation, cone, None).expect("a sound cone")
    };
    let axis = rotation * Vec3::NEG_Z;
    let aside = axis.any_orthonormal_vector();
    let far = f32::INFINITY;
    let light = match number % 8 {
        0 | 1 => point(position, far, Emission::Isotropic),
        2 => point(position, far, spot(random.between(0.1, 1.3))),
        3 => point(position, random.between(2.0, 9.0), spot(1.0)),
        4 => point(position + 20.0 * aside, far, Emission::Isotropic),
        5 => point(position, far, Emission::Cosine { normal: axis }),
        6 => Emitter::directional(axis, Vec3::ONE),
        _ => Emitter::directional(Vec3::NEG_Y, Vec3::ONE),
    };
    let eye = match number / 8 % 6 {
        0 | 1 => at(random),
        // Before the light and behind it.
        2 => position + random.between(0.1, 9.0) * axis,
        3 => position - random.between(0.1, 9.0) * axis,
        4 => position + random.between(0.1, 9.0) * aside,
        _ => position,
    };
    (light.expect("a sound light"), eye)
}

/// Rays from an eye all around and in a narrow view, some of them to the light,
/// and a few from elsewhere.
///
/// # Panics
/// Never: directions are not zero.
pub fn rays(random: &mut Random, eye: Vec3, light: &Emitter) -> Vec<Ray> {
    let towards = match light {
        Emitter::Point(point) => point.position() - eye,
        Emitter::Directional(sun) => -sun.direction(),
    };
    let ahead = vector(random, 1.0);
    let new = |_| {
        let direction = match random.below(8) {
            0..3 => vector(random, 1.0),
            3..6 => ahead + vector(random, 0.3),
            6 => {
                let beside = random.log_uniform(1e-9, 1.0) as f32;
                towards + towards.length() * vector(random, beside)
            }
            _ => towards,
        };
        let length = match random.below(4) {
            0 => f32::INFINITY,
            _ => random.between(0.0, 30.0),
        };
        let origin = match random.below(50) {
            0 => eye + vector(random, 1.0),
            _ => eye,
        };
        let direction = if random.below(6) == 0 {
            -direction
        } else {
            direction
        };
        Ray::new(origin, direction.normalize_or(Vec3::X), length).expect("a sound ray")
    };
    (0..RAYS).map(new).collect()
}

/// Something in the air.
///
/// # Panics
/// Never.
pub fn fog() -> Medium {
    Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).expect("a sound medium")
}
