//! Random inputs that lean towards the hard ones: all magnitudes alike, exact
//! coincidences, neighbours of them by a few units in the last place.

#[cfg(feature = "scene")]
mod scenes;

#[cfg(feature = "scene")]
pub use scenes::{beam, bulb, emitter, fog, medium, phase, ray, ray_near, solids, soup, sun};

use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Positive numbers, every magnitude between `low` and `high` alike.
pub fn log_uniform(low: f32, high: f32) -> impl Strategy<Value = f32> {
    (low.ln()..=high.ln()).prop_map(move |log| log.exp().clamp(low, high))
}

/// A number and its neighbours up to three units in the last place away.
pub fn neighbour(of: f32) -> impl Strategy<Value = f32> {
    (-3_i32..=3).prop_map(move |steps| {
        (0..steps.abs()).fold(of, |x, _| {
            if steps < 0 {
                x.next_down()
            } else {
                x.next_up()
            }
        })
    })
}

/// A coordinate within ±`size`: anywhere, on a grid of whole sixteenths of
/// `size` (so that things coincide), or next to 0.
pub fn coordinate(size: f32) -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -size..size,
        2 => (-16_i32..=16).prop_map(move |i| size * i as f32 / 16.0),
        1 => (log_uniform(1e-6, 1.0), any::<bool>())
            .prop_map(move |(x, negative)| if negative { -x * size } else { x * size }),
    ]
}

/// A point within the cube ±`size`.
pub fn point(size: f32) -> impl Strategy<Value = Vec3> {
    [coordinate(size), coordinate(size), coordinate(size)].prop_map(Vec3::from_array)
}

/// A unit vector: any, an axis, or a neighbour of one.
pub fn direction() -> impl Strategy<Value = Vec3> {
    let anywhere = (-1.0_f32..1.0, 0.0..std::f32::consts::TAU).prop_map(|(z, angle)| {
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * angle.cos(), r * angle.sin(), z)
    });
    let axis = (0_usize..3, any::<bool>()).prop_map(|(axis, negative)| {
        if negative {
            -Vec3::AXES[axis]
        } else {
            Vec3::AXES[axis]
        }
    });
    let nearly = (
        axis.clone(),
        log_uniform(1e-7, 1e-1),
        0.0..std::f32::consts::TAU,
    )
        .prop_map(|(axis, tilt, angle)| {
            let (a, b) = axis.any_orthonormal_pair();
            (axis + tilt * (angle.cos() * a + angle.sin() * b)).normalize()
        });
    prop_oneof![4 => anywhere, 1 => axis, 1 => nearly]
}

/// A rotation.
pub fn rotation() -> impl Strategy<Value = Quat> {
    (direction(), 0.0..std::f32::consts::TAU)
        .prop_map(|(axis, angle)| Quat::from_axis_angle(axis, angle))
}

/// A length of a ray: of a scene of size `size`, tiny, 0, or infinite.
pub fn length(size: f32) -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => log_uniform(0.1 * size, 4.0 * size),
        1 => log_uniform(1e-6 * size, size),
        1 => Just(0.0),
        2 => Just(f32::INFINITY),
    ]
}
