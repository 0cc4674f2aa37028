//! Epipolar coordinates there and back.

use epipolar::{FARTHEST, Lattice, Light, Locate, Resolution, Space, Spacing, ViewVolume};
use glam::{DVec2, DVec3, Vec2, Vec3};
use gpu_backend::Cpu;

use super::Bytes;

/// Eight roundings of half an ULP: subtraction, axis, scalar product.
const ANGLE: f64 = 8.0 / 16_777_216.0;

fn radians(vector: [f32; 2]) -> f64 {
    let vector: DVec2 = Vec2::from(vector).as_dvec2();
    vector.y.atan2(vector.x)
}

/// Any numbers: what comes out is a number too.
fn of_any_numbers(bytes: &mut Bytes<'_>) {
    let mut number = || match bytes.below(4) {
        0 => bytes.one_of(&[0.0, f32::MAX, FARTHEST, 1e-30, f32::INFINITY, f32::NAN]),
        1 => bytes.between(-4.0, 4.0),
        _ => bytes.any(),
    };
    let [eye, at, point] = [(); 3].map(|()| Vec3::from([(); 3].map(|()| number())));
    let light = match bytes.below(2) {
        0 => Light::point(at),
        _ => Light::directional(at),
    };
    let Ok(space) = light.and_then(|light| Space::new(light, eye)) else {
        return;
    };
    let ray = space.ray(point);
    assert!(ray.alpha.radians() >= 0.0 && ray.theta.radians().is_finite());
    let found = space.coordinates(point);
    assert!(found.ray.alpha.radians() >= 0.0 && !Vec2::from(found.phi.pair()).is_nan());
    let again = space.point(&found);
    assert!(again.is_none_or(|point| Vec3::from(point).is_finite()));
    for distance in [0.0, point.x.abs(), f32::INFINITY] {
        let phi = space.phi_along(&ray, distance);
        assert!(!Vec2::from(phi.pair()).is_nan(), "{distance}");
        assert!(space.distance_along(&ray, phi) >= 0.0, "{distance}");
    }
}

/// Angles against f64, and the point again.
fn of_points(bytes: &mut Bytes<'_>, space: &Space, axis: DVec3) {
    let eye = Vec3::from(space.eye());
    let light = space.light().position().map(Vec3::from);
    let far = bytes.magnitude(-14.0, 14.0);
    let beside = bytes.magnitude(-30.0, 0.0) * bytes.direction();
    let point = match bytes.below(4) {
        0 => eye + far * bytes.direction(),
        1 => light.unwrap_or(eye) + far * bytes.direction(),
        2 => eye + far * (axis.as_vec3() + beside),
        _ => eye - far * (axis.as_vec3() + beside),
    };
    if point == eye || Some(point) == light {
        return;
    }
    let v = point.as_dvec3() - eye.as_dvec3();
    let across = v.cross(axis).length();
    let alpha = across.atan2(v.dot(axis));
    let found = space.coordinates(point);
    let error = (radians(found.ray.alpha.vector()) - alpha).abs();
    assert!(error <= ANGLE, "α off by {error:e} at {point} of {space:?}");
    let (phi, from_light) = match light {
        None => (across, 0.0),
        Some(light) => {
            let back = light.as_dvec3() - point.as_dvec3();
            let phi = back.cross(axis).length().atan2(back.dot(axis));
            (phi, back.length())
        }
    };
    let pair = found.phi.pair();
    let (error, bound) = match light {
        None => {
            let found = f64::from(pair[1]) / f64::from(pair[0]);
            ((found - phi).abs(), ANGLE * v.length())
        }
        Some(_) => ((radians(pair) - phi).abs(), ANGLE),
    };
    assert!(error <= bound, "φ off by {error:e} at {point} of {space:?}");
    let sine = match light {
        None => alpha.sin(),
        Some(_) => (alpha + phi).sin(),
    };
    match space.point(&found).map(Vec3::from) {
        None => assert!(sine <= 4.0 * ANGLE, "{point} is lost of {space:?}"),
        // An error of α moves the point along the light ray, one of φ along the eye ray,
        // each by distance × error / sine; to first order, next to the axis only roughly.
        Some(again) if sine > 1e-3 => {
            let size = f64::from(eye.length() + point.length());
            let bound =
                2.0 * ANGLE * (v.length() + from_light) / sine + ANGLE * (v.length() + size);
            let error = (again.as_dvec3() - point.as_dvec3()).length();
            assert!(error <= bound, "{point} came back as {again} of {space:?}");
        }
        Some(_) => {}
    }
}

/// Positions within the voxels of a view, and their inverse.
fn of_voxels(bytes: &mut Bytes<'_>, space: Space, is_cone: bool) {
    let forward = bytes.direction();
    let size = [(); 2].map(|()| bytes.magnitude(-12.0, 4.0));
    let near = bytes.one_of(&[0.0, 0.1, 1e-6]);
    let far = near + bytes.magnitude(-6.0, 16.0);
    let view = match bytes.below(4) {
        0 => ViewVolume::all_around(near, far),
        _ => ViewVolume::perspective(forward, forward.any_orthonormal_vector(), size, near, far),
    };
    let [alpha, theta] = [(); 2].map(|()| 1 + bytes.below(40) as u32);
    let resolution = Resolution::new(alpha, theta, 32 * (1 + bytes.below(3) as u32));
    let sigma_t = bytes.magnitude(-10.0, 4.0);
    let spacings = [
        Spacing::Angle,
        Spacing::Distance,
        Spacing::Airlight { sigma_t },
    ];
    let spacing = bytes.one_of(&spacings);
    let (Ok(view), Ok(resolution)) = (view, resolution) else {
        return;
    };
    let Ok(lattice) = Lattice::new(space, &view, resolution, spacing) else {
        return;
    };
    let [low, high] = lattice.ranges().alpha();
    let bits = resolution.bits();
    for i in 0..=64 {
        let position = i as f32 / 64.0 * bits as f32;
        let found = lattice.phi_position(lattice.phi_at(position));
        assert!((0.0..=bits as f32).contains(&found), "{found} {lattice:?}");
        let first = (position as usize).min(bits as usize - 1);
        let bounds = [0, 1].map(|k| Vec2::from(lattice.bounds()[first + k]).as_dvec2());
        let width = bounds[0].perp_dot(bounds[1]);
        let size = match lattice.space().is_directional() {
            true => bounds[1].y,
            false => 1.0,
        };
        // Voxels may be thinner than a rounding, so that only their angles or distances tell
        // whether two positions are the same. The components of both are within 2⁻²⁴ of
        // themselves.
        let at = |position| Vec2::from(lattice.phi_at(position).pair()).as_dvec2();
        let error = at(position).perp_dot(at(found)).abs();
        let rounding = f64::from(2.0 * (position.next_up() - position));
        let tolerance = 1.2e-7 * size + rounding * width;
        assert!(!(error > tolerance), "{found} for {position}: {lattice:?}");
    }
    // Where the view looks is in the voxels, to the rounding of an angle, unless a cone
    // leaves it out.
    let ray = lattice.space().ray(forward);
    let position = f64::from(lattice.alpha_position(ray.alpha));
    let slack = 1e-3 + ANGLE * f64::from(alpha) / (high - low);
    if !is_cone {
        let voxels = -slack..=f64::from(alpha) + slack;
        assert!(voxels.contains(&position), "{position} of {lattice:?}");
    }
    let cpu = Cpu::single_threaded();
    let points: Vec<[f32; 4]> = (1..4)
        .map(|i| near + (far - near) * i as f32 / 4.0)
        .map(|distance| Vec3::from(lattice.space().eye()) + distance * forward)
        .map(|point| point.extend(1.0).to_array())
        .collect();
    let mut places = vec![[f32::NAN; 4]; points.len()];
    cpu.locate(&lattice, &points, &mut places)
        .expect("as many places as points");
    for (point, place) in points.iter().zip(&places) {
        let [x, y, z, _] = *point;
        let found = lattice.space().coordinates([x, y, z]);
        let own = [
            lattice.alpha_position(found.ray.alpha),
            lattice.theta_position(found.ray.theta),
            lattice.phi_position(found.phi),
        ];
        assert_eq!(own, place[..3], "{point:?} of {lattice:?}");
    }
}

/// Coordinates are those of f64 to eight roundings, points come back from them, positions
/// in the voxels of a view come back from angles, and nothing is ever NaN.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    of_any_numbers(&mut bytes);
    let eye = bytes.magnitude(-14.0, 14.0) * bytes.direction();
    let axis = bytes.direction();
    let kind = bytes.below(3);
    let light = match kind {
        0 => Light::directional(-axis),
        1 => Light::point(eye + bytes.magnitude(-14.0, 14.0) * axis),
        _ => {
            let at = eye + bytes.magnitude(-14.0, 14.0) * axis;
            Light::spot(at, bytes.direction(), bytes.between(1e-3, 3.1))
        }
    };
    let Ok(space) = light.and_then(|light| Space::new(light, eye)) else {
        return;
    };
    let to_light = match space.light().position() {
        Some(at) => Vec3::from(at).as_dvec3() - eye.as_dvec3(),
        None => axis.as_dvec3(),
    };
    let axis = to_light.normalize();
    for _ in 0..4 {
        of_points(&mut bytes, &space, axis);
    }
    of_voxels(&mut bytes, space, kind == 2);
}

/// Lights and views of every kind.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..24_u8)
        .map(|seed| {
            let mix = |i: u8| i.wrapping_mul(109) ^ seed.wrapping_mul(43).rotate_left(2);
            (0..190_u8).map(mix).collect()
        })
        .collect()
}
