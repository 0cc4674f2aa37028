//! The grids of a light, fitted to what casts shadows.

use glam::{DMat4, DVec3, DVec4, Vec3};
use shadow_dag::{Error, LightGrids, LightSpace, Resolution};

use crate::Emitter;
use crate::scene::raster::{Face, Rays};
use crate::scene::{Bounds, Geometry};
use crate::shadow_map::faces;

/// Slices begin no closer to a point light than this share of the distance at
/// which they end: `ln 1e5 = 11.5` spreads 4096 slices 0.3 % apart.
const NEAREST: f64 = 1e-5;

/// Of rounding of the corners that decide about the ends of the slices.
const ROUNDING: f64 = 1e-4;

/// The spaces of the grids that a light needs in a scene: the same pictures as
/// in its [shadow map](crate::shadow_map), with slices over the depths at which
/// there are casters, but for the last one: it lies behind all of them, because
/// it answers for all that is behind the grid. One, or six in the order
/// +X −X +Y −Y +Z −Z; together they see every caster that can hide the light
/// from a point it shines on. Slices end at the light's range: behind it nothing is lit
/// that could be shadowed.
///
/// Every triangle counts as a caster, also of what is dynamic: pass
/// [`Geometry::static_part`] where something moves.
///
/// Casters closer to a point light than 1e-5 of the distance of the farthest
/// may be cut off.
///
/// # Errors
/// [`Error::BadValue`] if the light is so far away, more than about 10⁷ times
/// the size of the scene, that all of its rays are the same to `f32`.
pub fn light_spaces(
    geometry: &Geometry,
    emitter: &Emitter,
    resolution: Resolution,
) -> Result<Vec<LightSpace>, Error> {
    let bounds = geometry.bounds();
    let (closest, range) = match emitter {
        Emitter::Point(point) => (
            closest(point.position().as_dvec3(), geometry),
            f64::from(point.range()),
        ),
        Emitter::Directional(_) => (0.0, f64::INFINITY),
    };
    faces(bounds, emitter)
        .iter()
        .map(|face| space(face, [closest, range], bounds, resolution))
        .collect()
}

/// The grids that a light needs in a scene, [`light_spaces`] with `resolution` voxels
/// along each axis.
///
/// # Errors
/// Those of [`light_spaces`].
pub fn light_grids(
    geometry: &Geometry,
    emitter: &Emitter,
    resolution: Resolution,
) -> Result<LightGrids, Error> {
    let spaces = light_spaces(geometry, emitter, resolution)?;
    Ok(LightGrids::new(spaces, resolution))
}

/// From the world to the axes of a face, with the light or the middle of its
/// picture at the origin.
fn view(face: &Face) -> DMat4 {
    let [right, up, back] = [face.right, face.up, -face.forward].map(|axis| axis.as_dvec3());
    let origin = face.origin.as_dvec3();
    let row = |axis: DVec3| axis.extend(-axis.dot(origin));
    DMat4::from_cols(row(right), row(up), row(back), DVec4::W).transpose()
}

fn space(
    face: &Face,
    [closest, range]: [f64; 2],
    bounds: Bounds,
    resolution: Resolution,
) -> Result<LightSpace, Error> {
    let [near, far] = depths(face, bounds);
    // All slices for each of those in front of the last.
    let slices = f64::from(resolution.side());
    let one_more = slices / (slices - 1.0);
    match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => {
            let [width, height] = [half_width, half_height].map(|half| 2.0 * f64::from(half));
            let far = near + (far - near) * one_more;
            LightSpace::orthographic(view(face), width, height, near, far)
        }
        Rays::Central { tan } => {
            let tan = f64::from(tan);
            // A point at a distance is nowhere in the picture closer along the
            // axis than this share of it.
            let steepest = (1.0 + 2.0 * tan * tan).sqrt().recip();
            let nearest = closest * steepest * (1.0 - ROUNDING);
            // A face that sees no caster needs some slices all the same.
            let far = if far > 0.0 { far.min(range) } else { 1.0 };
            let near = near.max(nearest).max(NEAREST * far);
            let far = far.max(near * (1.0 + ROUNDING));
            let far = near * (far / near).powf(one_more);
            LightSpace::perspective(view(face), 2.0 * tan.atan(), near, far)
        }
    }
}

/// The least and the largest depth of a corner of the box.
fn depths(face: &Face, bounds: Bounds) -> [f64; 2] {
    let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
    let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
    let forward = face.forward.as_dvec3();
    let middle = (centre - face.origin.as_dvec3()).dot(forward);
    let reach = forward.abs().dot(half) * (1.0 + ROUNDING);
    [middle - reach, middle + reach]
}

/// The distance of the closest triangle from a point.
fn closest(point: DVec3, geometry: &Geometry) -> f64 {
    let mut least = f64::INFINITY;
    for triangle in geometry.triangles() {
        // Most are told from their boxes; to rounding a box is no farther away.
        let [a, b, c] = triangle.map(Vec3::as_dvec3);
        let beside = a.min(b).min(c) - point;
        let beyond = point - a.max(b).max(c);
        let box_distance = beside.max(beyond).max(DVec3::ZERO).length();
        if box_distance * (1.0 - ROUNDING) < least {
            least = least.min(distance([a, b, c].map(|corner| corner - point)));
        }
    }
    least
}

/// The distance of a triangle from the origin.
fn distance([a, b, c]: [DVec3; 3]) -> f64 {
    let edges = [(a, b), (b, c), (c, a)];
    let normal = (b - a).cross(c - a);
    let above = edges.map(|(from, to)| normal.cross(to - from).dot(from) <= 0.0);
    if above == [true; 3] {
        return normal.normalize_or_zero().dot(a).abs();
    }
    let to_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let share = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (from + share * along).length()
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::scene::{Mesh, Scene};

    #[test]
    fn the_closest_triangle_is_as_far_as_the_closest_of_many_of_its_points() {
        let mut random = Random::new(1);
        let mut next = || random.unit() - 0.5;
        for _ in 0..200 {
            let corners = [0; 3].map(|_| Vec3::new(next(), next(), next()) * 4.0);
            let scene = Scene::from(Mesh {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            });
            let geometry = Geometry::new(&scene).unwrap();
            let found = closest(DVec3::ZERO, &geometry);
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            let steps = 200;
            let mut least = f64::INFINITY;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let (u, v) = (
                        f64::from(i) / f64::from(steps),
                        f64::from(j) / f64::from(steps),
                    );
                    least = least.min((a * (1.0 - u - v) + b * u + c * v).length());
                }
            }
            let step = (b - a).length().max((c - a).length()) / f64::from(steps);
            assert!(
                found <= least + 1e-9 && least <= found + 2.0 * step,
                "{found} {least}"
            );
        }
    }
}
