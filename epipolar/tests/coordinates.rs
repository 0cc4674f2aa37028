//! Coordinates against f64, near the axis and far from it, and the way back.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use epipolar::{Error, Light, Space};
use glam::{DVec2, DVec3, Vec2, Vec3};
use proptest::prelude::*;

/// 8 roundings of half an ULP: subtraction, axis, scalar product.
const ANGLE: f64 = 8.0 / 16_777_216.0;

fn unit() -> impl Strategy<Value = Vec3> {
    [-1.0_f32..1.0, -1.0..1.0, -1.0..1.0]
        .prop_map(Vec3::from_array)
        .prop_filter("a direction", |v| v.length() > 0.1)
        .prop_map(Vec3::normalize)
}

/// A distance of any order of magnitude.
fn distance() -> impl Strategy<Value = f32> {
    (-14.0_f32..14.0).prop_map(f32::exp2)
}

/// Points everywhere, close to the axis on either side of the eye and of the
/// light, close to the eye and close to the light.
fn point(eye: Vec3, axis: Vec3, far: f32) -> impl Strategy<Value = Vec3> {
    (unit(), distance(), 0..4, -30.0_f32..0.0).prop_map(move |(v, x, kind, closeness)| {
        let light = eye + far * axis;
        match kind {
            0 => eye + x * v,
            1 => light + x * v,
            2 => eye + x * (axis + closeness.exp2() * v),
            _ => eye - x * (axis + closeness.exp2() * v),
        }
    })
}

/// Eye, light and point; `None` for parallel light along the direction.
fn scene() -> impl Strategy<Value = (Vec3, Option<Vec3>, Vec3, Vec3)> {
    (unit(), distance(), unit(), distance(), any::<bool>()).prop_flat_map(
        |(e, size, axis, far, sun)| {
            let eye = size * e;
            let light = (!sun).then_some(eye + far * axis);
            (Just(eye), Just(light), Just(axis), point(eye, axis, far))
        },
    )
}

/// A scene and a point next to the line through eye and light: before the eye,
/// between them, behind the light.
fn beside_the_axis() -> impl Strategy<Value = (Vec3, Option<Vec3>, Vec3, Vec3)> {
    let scene = (unit(), distance(), unit(), distance(), any::<bool>());
    (scene, -1.0_f64..3.0, unit(), -24.0_f32..-4.0).prop_map(
        |((e, size, axis, far, sun), along, v, closeness)| {
            let eye = size * e;
            let light = (!sun).then_some(eye + far * axis);
            let to_light = match light {
                Some(light) => light.as_dvec3() - eye.as_dvec3(),
                None => f64::from(far) * axis.as_dvec3(),
            };
            let beside = f64::from(closeness.exp2()) * to_light.length() * v.as_dvec3();
            let point = (eye.as_dvec3() + along * to_light + beside).as_vec3();
            (eye, light, axis, point)
        },
    )
}

struct Exact {
    axis: DVec3,
    alpha: f64,
    phi: f64,
    from_eye: f64,
    from_light: f64,
}

fn exact(eye: Vec3, light: Option<Vec3>, axis: Vec3, point: Vec3) -> Exact {
    let v = point.as_dvec3() - eye.as_dvec3();
    let axis = match light {
        Some(light) => light.as_dvec3() - eye.as_dvec3(),
        None => axis.as_dvec3(),
    }
    .normalize();
    let across = v.cross(axis).length();
    let (phi, from_light) = match light {
        None => (across, 0.0),
        Some(light) => {
            let back = light.as_dvec3() - point.as_dvec3();
            (
                back.cross(axis).length().atan2(back.dot(axis)),
                back.length(),
            )
        }
    };
    Exact {
        axis,
        alpha: across.atan2(v.dot(axis)),
        phi,
        from_eye: v.length(),
        from_light,
    }
}

fn space(eye: Vec3, light: Option<Vec3>, axis: Vec3) -> Option<Space> {
    let light = match light {
        Some(position) => Light::point(position),
        None => Light::directional(-axis),
    };
    Space::new(light.unwrap(), eye).ok()
}

fn radians(vector: [f32; 2]) -> f64 {
    let vector: DVec2 = Vec2::from(vector).as_dvec2();
    vector.y.atan2(vector.x)
}

proptest! {
    #![proptest_config(reference::property::cases(20_000))]

    #[test]
    fn angles_are_right_to_eight_roundings((eye, light, axis, point) in scene()) {
        if point == eye || Some(point) == light {
            return Ok(());
        }
        let Some(space) = space(eye, light, axis) else { return Ok(()) };
        let exact = exact(eye, light, axis, point);
        let found = space.coordinates(point);
        prop_assert!((radians(found.ray.alpha.vector()) - exact.alpha).abs() <= ANGLE);
        let pair = found.phi.pair();
        if space.is_directional() {
            let across = f64::from(pair[1]) / f64::from(pair[0]);
            prop_assert!((across - exact.phi).abs() <= ANGLE * exact.from_eye);
        } else {
            prop_assert!((radians(pair) - exact.phi).abs() <= ANGLE);
        }
        // θ: the displacement around the axis.
        let v = point.as_dvec3() - eye.as_dvec3();
        let [_, right, up] = space.frame().map(|v| Vec3::from(v).as_dvec3());
        let theta = v.dot(up).atan2(v.dot(right));
        let error = (radians(found.ray.theta.vector()) - theta).sin().abs();
        let across = v.cross(exact.axis).length();
        prop_assert!(error * across <= ANGLE * exact.from_eye);
    }

    #[test]
    fn points_come_back_from_their_coordinates((eye, light, axis, point) in scene()) {
        if point == eye || Some(point) == light {
            return Ok(());
        }
        let Some(space) = space(eye, light, axis) else { return Ok(()) };
        let exact = exact(eye, light, axis, point);
        let found = space.coordinates(point);
        let Some(again) = space.point(&found).map(Vec3::from) else {
            // Only on the axis, or as good as parallel to it.
            let sine = if light.is_some() { (exact.alpha + exact.phi).sin() } else { exact.alpha.sin() };
            prop_assert!(sine <= 4.0 * ANGLE);
            return Ok(());
        };
        // An error of α moves the point along the light ray, one of φ along
        // the eye ray, each by distance × error / sin(α + φ); one of θ
        // around. Every product on the way back adds a rounding. To first
        // order: neighbours of the axis, where that is no bound, are left to
        // the next test.
        let sine = if light.is_some() { (exact.alpha + exact.phi).sin() } else { exact.alpha.sin() };
        if sine < 1e-3 {
            return Ok(());
        }
        let tolerance = 2.0 * ANGLE * (exact.from_eye + exact.from_light) / sine
            + ANGLE * (exact.from_eye + f64::from(eye.length()) + f64::from(point.length()));
        let error = (again.as_dvec3() - point.as_dvec3()).length();
        prop_assert!(error <= tolerance, "{error} of {tolerance}");
    }

    #[test]
    fn next_to_any_axis_angles_keep_their_relative_accuracy(
        (eye, light, axis, point) in beside_the_axis(),
    ) {
        if point == eye || Some(point) == light {
            return Ok(());
        }
        let Some(space) = space(eye, light, axis) else { return Ok(()) };
        let exact = exact(eye, light, axis, point);
        let found = space.coordinates(point);
        // Three roundings of each component, and what f64 loses of the way there.
        let right = |found: [f32; 2], exact: f64| {
            let error = (radians(found) - exact).abs();
            let small = exact.min(std::f64::consts::PI - exact);
            error <= 4e-7 * small + 4e-16
        };
        prop_assert!(right(found.ray.alpha.vector(), exact.alpha), "{:?} {}", found, exact.alpha);
        if space.is_directional() {
            let across = f64::from(found.phi.pair()[1] / found.phi.pair()[0]);
            prop_assert!((across - exact.phi).abs() <= 4e-7 * exact.phi + 4e-16 * exact.from_eye);
        } else {
            prop_assert!(right(found.phi.pair(), exact.phi), "{:?} {}", found, exact.phi);
        }
        let ray = space.ray((point.as_dvec3() - eye.as_dvec3()).as_vec3());
        let direction = (point.as_dvec3() - eye.as_dvec3()).as_vec3().as_dvec3();
        let across = direction.cross(exact.axis).length();
        prop_assert!(right(ray.alpha.vector(), across.atan2(direction.dot(exact.axis))));
    }

    #[test]
    fn no_point_beside_the_axis_is_lost((eye, light, axis, point) in scene()) {
        if point == eye || Some(point) == light {
            return Ok(());
        }
        let Some(space) = space(eye, light, axis) else { return Ok(()) };
        let exact = exact(eye, light, axis, point);
        if exact.alpha.sin() < 1e-7 || (light.is_some() && exact.phi.sin() < 1e-7) {
            return Ok(());
        }
        let again = space.point(&space.coordinates(point)).map(Vec3::from);
        prop_assert!(again.is_some(), "{:?} {} {}", point, exact.alpha, exact.phi);
        // Always in the right direction.
        let (a, b) = (point.as_dvec3() - eye.as_dvec3(), again.unwrap().as_dvec3() - eye.as_dvec3());
        let sine = a.normalize().cross(b.normalize()).length();
        let size = f64::from(eye.length() + again.unwrap().length());
        prop_assert!(sine <= 2.0 * ANGLE + ANGLE * size / b.length(), "{sine}");
    }

    #[test]
    fn nothing_is_nan_whatever_the_input(
        eye: [f32; 3], light: [f32; 3], point: [f32; 3], sun: bool,
    ) {
        let [eye, light, point] = [eye, light, point].map(Vec3::from_array);
        let light = if sun { Light::directional(light) } else { Light::point(light) };
        let Ok(light) = light else { return Ok(()) };
        let Ok(space) = Space::new(light, eye) else { return Ok(()) };
        let ray = space.ray(point);
        prop_assert!(ray.alpha.radians() >= 0.0 && ray.theta.radians().is_finite());
        let found = space.coordinates(point);
        prop_assert!(found.ray.alpha.radians() >= 0.0 && !Vec2::from(found.phi.pair()).is_nan());
        prop_assert!(space.point(&found).is_none_or(|p| Vec3::from(p).is_finite()));
        prop_assert!(!Vec2::from(space.phi_along(&ray, light_of(point)).pair()).is_nan());
    }
}

/// Any number as a distance.
fn light_of(point: Vec3) -> f32 {
    point.x.abs()
}

#[test]
fn next_to_the_axis_angles_keep_their_relative_accuracy_on_either_side() {
    let light = Light::point(Vec3::new(0.0, 0.0, -8.0)).unwrap();
    let space = Space::new(light, Vec3::ZERO).unwrap();
    for offset in [1e-3_f32, 1e-7, 1e-12, 1e-20, 1e-30] {
        for z in [-3.0_f32, -7.99, -20.0, 5.0] {
            let point = Vec3::new(offset, 0.0, z);
            let found = space.coordinates(point);
            let alpha = Vec2::from(found.ray.alpha.vector());
            // π − α behind the eye.
            assert_eq!(alpha.x < 0.0, z > 0.0);
            let tangent = f64::from(alpha.y) / f64::from(alpha.x.abs());
            let expected = f64::from(offset) / f64::from(z.abs());
            assert!((tangent / expected - 1.0).abs() < ANGLE, "{offset} {z}");
            // π − φ behind the light.
            let pair = Vec2::from(found.phi.pair());
            assert_eq!(pair.x < 0.0, z < -8.0);
            let tangent = f64::from(pair.y) / f64::from(pair.x.abs());
            let expected = f64::from(offset) / (f64::from(z) + 8.0).abs();
            assert!((tangent / expected - 1.0).abs() < ANGLE, "{offset} {z}");
            let again = Vec3::from(space.point(&found).unwrap());
            assert!(
                (again - point).abs().max_element() <= 1e-5 * z.abs(),
                "{again}, expected {point}"
            );
            assert!((again.x / offset - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn distances_along_a_ray_and_angles_at_the_light_are_inverse() {
    let eye = Vec3::new(1.0, 2.0, 3.0);
    for light in [
        Light::point(Vec3::new(4.0, 2.5, -1.0)).unwrap(),
        Light::point(eye + Vec3::new(1e-6, 0.0, 0.0)).unwrap(),
        Light::directional(Vec3::new(0.3, -1.0, 0.2)).unwrap(),
    ] {
        let space = Space::new(light, eye).unwrap();
        for direction in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(1.0, -1.0, 0.5)] {
            let ray = space.ray(direction);
            // Behind the light the pair is x (sin, cos) plus the constant D,
            // where the rest of a short distance may be lost to rounding.
            for distance in [1e-3_f32, 0.5, 7.0, 1e3] {
                let phi = space.phi_along(&ray, distance);
                let again = space.distance_along(&ray, phi);
                let sine = f64::from(ray.alpha.vector()[1]);
                let size = f64::from(distance) + f64::from(space.distance().min(1e6));
                let slack = if space.is_directional() {
                    f64::from(distance)
                } else {
                    let d = f64::from(space.distance());
                    size * size / (d * sine)
                };
                // A light at the eye: φ no longer tells distances apart.
                if ANGLE * slack > 0.1 * f64::from(distance) {
                    continue;
                }
                assert!(
                    (f64::from(again) - f64::from(distance)).abs() <= ANGLE * slack,
                    "{again}, expected {distance}, {slack}"
                );
            }
            assert_eq!(space.distance_along(&ray, space.phi_along(&ray, 0.0)), 0.0);
            let end = space.phi_along(&ray, f32::INFINITY);
            let reached = space.distance_along(&ray, end);
            // On the axis no distance has its own φ.
            assert!(reached > 1e5 || ray.alpha.vector()[1] == 0.0, "{reached}");
        }
    }
}

#[test]
fn an_eye_at_the_light_is_told() {
    let at = Vec3::new(0.3, 4.0, -2.0);
    let light = Light::point(at).unwrap();
    assert_eq!(
        Space::new(light, at),
        Err(Error::EyeAtLight { distance: 0.0 })
    );
    // One ULP beside it is enough.
    let beside = Vec3::new(at.x.next_up(), at.y, at.z);
    let space = Space::new(light, beside).unwrap();
    assert_eq!(space.frame()[0], [-1.0, 0.0, 0.0]);
    let error = Space::new(Light::point(Vec3::ZERO).unwrap(), Vec3::splat(1e-30));
    assert!(matches!(error, Err(Error::EyeAtLight { .. })));
}

#[test]
fn lights_and_eyes_that_are_no_numbers_are_turned_away() {
    for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, 1e19, 0.0)] {
        assert!(matches!(Light::point(bad), Err(Error::BadVector { .. })));
        let light = Light::directional(Vec3::X).unwrap();
        assert!(Space::new(light, bad).is_err());
    }
    for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::ZERO] {
        assert!(Light::directional(bad).is_err());
        assert!(Light::spot(Vec3::ZERO, bad, 0.5).is_err());
    }
    for bad in [0.0, -1.0, 3.2, f32::NAN] {
        assert!(Light::spot(Vec3::ZERO, Vec3::X, bad).is_err());
    }
}

#[test]
fn a_rotation_moves_planes_and_nothing_else() {
    let light = Light::point(Vec3::new(1.0, 5.0, 2.0)).unwrap();
    let space = Space::new(light, Vec3::ONE).unwrap();
    let turned = space.rotated(0.5);
    let point = Vec3::new(-3.0, 2.0, 1.0);
    let (a, b) = (space.coordinates(point), turned.coordinates(point));
    assert_eq!(a.ray.alpha.radians(), b.ray.alpha.radians());
    let shift = a.ray.theta.relative_to(b.ray.theta);
    assert!((f64::from(shift) - 0.5).abs() < 4.0 * ANGLE);
    assert!((Vec3::from(turned.point(&b).unwrap()) - point).length() < 1e-5);
}
