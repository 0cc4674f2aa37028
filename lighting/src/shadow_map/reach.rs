//! Which casters a light can reach.

use glam::{DVec3, Vec3};

use crate::Emitter;
use crate::scene::{Bounds, Emission, PointEmitter};

/// A bound on what rounding f32 coordinates adds, relative to the distances in a test.
const ROUNDING: f64 = 1e-5;

/// The part of a box of casters that can matter for the shadows of a light. Every caster that
/// can block its light is in it. `None` if the light shines on none of the casters, so that
/// they block none of its light.
///
/// For a light with a range this is the intersection of the box with the cube around the range.
/// A [map](super::RenderShadowMap::shadow_map_within) of this part has smaller texels than one
/// of the whole box.
///
/// The test is conservative: a light that narrowly misses the casters may count as one that
/// reaches them.
pub fn reached(casters: Bounds, emitter: &Emitter) -> Option<Bounds> {
    let Emitter::Point(point) = emitter else {
        return Some(casters);
    };
    let (min, max) = (casters.min(), casters.max());
    let position = point.position();
    let centre = 0.5 * (min + max).as_dvec3();
    let radius = 0.5 * (max - min).as_dvec3().length();
    let to_centre = centre - position.as_dvec3();
    let slack = ROUNDING * (centre.length() + to_centre.length() + radius);
    if !shines_towards(point, to_centre, radius + slack) {
        return None;
    }
    let range = f64::from(point.range());
    if range == f64::INFINITY {
        return Some(casters);
    }
    let nearest = position.clamp(min, max);
    let distance = (nearest - position).as_dvec3().length();
    if distance > range + slack {
        return None;
    }
    let reach = Vec3::splat((range + slack) as f32);
    let (from, to) = (min.max(position - reach), max.min(position + reach));
    // A box that the light only touches has no volume.
    Some(Bounds::new(from, to).unwrap_or(casters))
}

/// Whether some of a sphere may be in the cone of a light.
fn shines_towards(point: &PointEmitter, to_centre: DVec3, radius: f64) -> bool {
    let (axis, cos) = match point.emission() {
        Emission::Isotropic => return true,
        Emission::Cosine { normal } => (normal.as_dvec3(), 0.0),
        Emission::Spot(spot) => (
            spot.axis().as_dvec3(),
            1.0 - f64::from(spot.outer_versine()),
        ),
    };
    let distance = to_centre.length();
    if distance <= radius {
        return true;
    }
    let half_angle = cos.clamp(-1.0, 1.0).acos();
    let spread = (radius / distance).asin();
    let off_axis = (to_centre / distance).dot(axis.normalize());
    off_axis.clamp(-1.0, 1.0).acos() <= half_angle + spread + ROUNDING
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use reference::random::Random;

    use super::*;
    use crate::scene::Cone;
    use crate::surface_point::Arriving;

    fn light(random: &mut Random) -> Emitter {
        let at = Vec3::from_array(random.vector(6.0));
        let range = [f32::INFINITY, 0.5 + 4.0 * random.unit()][usize::from(random.unit() < 0.7)];
        let turn = Vec3::from_array(random.vector(3.0));
        let outer = 0.05 + 1.4 * random.unit();
        let cone = Cone {
            inner: 0.5 * outer,
            outer,
        };
        let emission = match (3.0 * random.unit()) as u32 {
            0 => Emission::Isotropic,
            1 => Emission::Cosine {
                normal: turn.normalize_or(Vec3::X),
            },
            _ => Emission::spot(Quat::from_scaled_axis(turn), cone, None).unwrap(),
        };
        Emitter::point(at, Vec3::ONE, range, emission).unwrap()
    }

    #[test]
    fn every_point_of_the_casters_that_a_light_shines_on_is_within_what_it_reaches() {
        let mut random = Random::new(1);
        let (mut shone_on, mut not_reached) = (0, 0);
        for _ in 0..400 {
            let corner = Vec3::from_array(random.vector(4.0));
            let size = Vec3::from_array([0; 3].map(|_| 0.1 + 2.0 * random.unit()));
            let casters = Bounds::new(corner, corner + size).unwrap();
            let light = light(&mut random);
            let found = reached(casters, &light);
            not_reached += u32::from(found.is_none());
            for _ in 0..100 {
                let place = Vec3::from_array([0; 3].map(|_| random.unit()));
                let point = corner + place * size;
                let arrives = Arriving::at(point, &light);
                if arrives.is_none_or(|light| light.irradiance == Vec3::ZERO) {
                    continue;
                }
                shone_on += 1;
                let bounds = found.expect("the light shines on a point of the casters");
                let inside = point.cmpge(bounds.min()) & point.cmple(bounds.max());
                assert!(inside.all(), "{point} {bounds:?} {light:?}");
            }
        }
        assert!(
            shone_on > 1000 && not_reached > 50,
            "{shone_on} {not_reached}"
        );
    }
}
