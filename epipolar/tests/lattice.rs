//! Voxels: positions, centres, spacing, footprints.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use epipolar::{Error, Lattice, Light, Phi, Resolution, Space, Spacing, ViewVolume};
use glam::{DVec3, Vec2, Vec3};
use proptest::prelude::*;

fn lattice(light: Light, view: &ViewVolume, spacing: Spacing) -> Lattice {
    let space = Space::new(light, Vec3::new(0.2, 1.7, 0.4)).unwrap();
    Lattice::new(space, view, Resolution::new(96, 80, 64).unwrap(), spacing).unwrap()
}

fn camera(near: f32, far: f32) -> ViewVolume {
    ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], near, far).unwrap()
}

/// In view, off screen, behind, almost at the eye, parallel, a cone.
fn lights() -> Vec<Light> {
    vec![
        Light::point(Vec3::new(1.0, 2.0, -5.0)).unwrap(),
        Light::point(Vec3::new(9.0, 4.0, -2.0)).unwrap(),
        Light::point(Vec3::new(0.3, 1.6, 6.0)).unwrap(),
        Light::point(Vec3::new(0.2001, 1.7, 0.4)).unwrap(),
        Light::point(Vec3::new(0.0, 3e4, -2e4)).unwrap(),
        Light::directional(Vec3::new(0.1, -1.0, 0.3)).unwrap(),
        Light::directional(Vec3::new(0.02, -0.1, 1.0)).unwrap(),
        Light::spot(Vec3::new(1.0, 6.0, -5.0), Vec3::NEG_Y, 0.4).unwrap(),
    ]
}

const SPACINGS: [Spacing; 3] = [
    Spacing::Angle,
    Spacing::Distance,
    Spacing::Airlight { sigma_t: 0.2 },
];

#[test]
fn centres_are_half_way_through_their_voxels() {
    for light in lights() {
        for spacing in SPACINGS {
            let lattice = lattice(light, &camera(0.1, 30.0), spacing);
            let ranges = lattice.ranges();
            let [low, high] = ranges.alpha();
            let alpha_width = (high - low) / 96.0;
            let theta_width = ranges.theta_extent() / 80.0;
            for i in 0..64 {
                let centre = lattice.centre(i + 3, i + 7, i);
                let alpha = lattice.alpha_position(centre.ray.alpha) - (i as f32 + 3.5);
                let theta = lattice.theta_position(centre.ray.theta) - (i as f32 + 7.5);
                let phi = lattice.phi_position(centre.phi) - (i as f32 + 0.5);
                // A rounded unit vector and the angle function: 5e-7 rad,
                // and the rounding of a position.
                assert!(
                    f64::from(alpha.abs()) < 5e-7 / alpha_width + 1e-5,
                    "{alpha}"
                );
                assert!(
                    f64::from(theta.abs()) < 5e-7 / theta_width + 1e-5,
                    "{theta}"
                );
                // Rounded bounds: 1.5e-7 of φ, and the rounding of a position.
                let bounds = [0, 1].map(|k| Vec2::from(lattice.bounds()[i as usize + k]));
                let width = f64::from(bounds[0].perp_dot(bounds[1]));
                let size = f64::from(bounds[1].y).max(width);
                assert!(
                    f64::from(phi.abs()) < 4e-7 * size / width + 1e-5,
                    "{phi} {light:?} {spacing:?}"
                );
            }
        }
    }
}

#[test]
fn positions_along_phi_and_their_inverse_agree() {
    for light in lights() {
        for spacing in SPACINGS {
            let lattice = lattice(light, &camera(0.1, 30.0), spacing);
            let mut last = -1.0;
            for i in 0..=640 {
                let position = 0.1 * i as f32;
                let found = lattice.phi_position(lattice.phi_at(position));
                let bound = Vec2::from(lattice.bounds()[(position as usize).min(63)]);
                let next = Vec2::from(lattice.bounds()[(position as usize).min(63) + 1]);
                let width = bound.perp_dot(next);
                let tolerance = 1e-5 + 4e-7 * next.y.max(width) / width;
                assert!((found - position).abs() <= tolerance, "{found} {position}");
                assert!(found >= last - tolerance);
                last = found;
            }
            assert_eq!(lattice.phi_position(lattice.phi_at(-1.0)), 0.0);
            assert_eq!(lattice.phi_position(lattice.phi_at(1e9)), 64.0);
        }
    }
}

/// A hundred positions in each voxel: the inverse is one expression within a voxel,
/// smooth in the position, so that only its rounding varies, and a hundred roundings
/// come within a few percent of the largest.
#[test]
fn phi_at_is_the_inverse_to_the_rounding_of_its_pair() {
    let eye = Vec3::new(0.2, 1.7, 0.4);
    let mut lights = lights();
    for distance in [1e-6, 1e-3, 2e-3, 0.1, 1e3] {
        for along in [
            Vec3::X,
            Vec3::new(0.3, 0.2, -0.7),
            Vec3::new(0.1, -0.5, 0.8),
        ] {
            lights.push(Light::point(eye + distance * along).unwrap());
            let spot = Light::spot(eye + distance * along, Vec3::NEG_Z, 0.2);
            lights.push(spot.unwrap());
        }
    }
    let mut worst = 0.0_f64;
    for light in lights {
        for spacing in SPACINGS {
            let space = Space::new(light, eye).unwrap();
            let view = camera(0.1, 30.0);
            let voxels = Resolution::new(96, 80, 64).unwrap();
            let Ok(lattice) = Lattice::new(space, &view, voxels, spacing) else {
                continue;
            };
            for i in 0..=6400 {
                let position = 0.01 * i as f32;
                let found = lattice.phi_position(lattice.phi_at(position));
                let ends = [0, 1].map(|k| {
                    Vec2::from(lattice.bounds()[(position as usize).min(63) + k]).as_dvec2()
                });
                let width = ends[0].perp_dot(ends[1]);
                // Components are within 2⁻²⁴ of themselves, and so is the angle or
                // the distance.
                let size = if space.is_directional() {
                    ends[1].y
                } else {
                    1.0
                };
                let tolerance =
                    6e-8 * size / width + f64::from(2.0 * (position.next_up() - position));
                let error = f64::from((found - position).abs());
                worst = worst.max(error / tolerance);
                assert!(
                    error <= tolerance,
                    "{found} for {position}: {light:?} {spacing:?}"
                );
            }
        }
    }
    println!("at most {worst:.2} of the bound");
}

#[test]
fn all_of_a_ray_lies_within_the_bits_in_order() {
    for light in lights() {
        let lattice = lattice(light, &camera(0.0, 30.0), Spacing::Angle);
        let space = lattice.space();
        for i in 0..50 {
            let x = 0.8 * (i as f32 / 25.0 - 1.0);
            let ray = space.ray(Vec3::new(x, 0.3 * x * x, -1.0));
            let mut last = 0.0;
            for step in 0..=1000 {
                let distance = 0.03 * step as f32;
                let position = lattice.phi_position(space.phi_along(&ray, distance));
                // Equal distances may round to neighbouring positions.
                assert!(position >= last - 1e-4, "{position} after {last}");
                last = position;
            }
            let end = lattice.phi_position(space.phi_along(&ray, f32::INFINITY));
            assert!(end >= last - 1e-4 && end <= 64.0);
        }
    }
}

/// The airlight of a ray between two distances, by brute force.
fn airlight(eye: DVec3, light: DVec3, ray: DVec3, from: f64, to: f64, sigma_t: f64) -> f64 {
    let steps = 20_000;
    let step = (to - from) / f64::from(steps);
    (0..steps)
        .map(|i| {
            let x = from + (f64::from(i) + 0.5) * step;
            let d = (eye + x * ray - light).length();
            (-sigma_t * (x + d)).exp() / (d * d) * step
        })
        .sum()
}

#[test]
fn bits_carry_equal_airlight_or_equal_distance_along_a_single_ray() {
    // A view so narrow that all of its rays are one, and a light that
    // passes close by.
    let ray = Vec3::new(0.3, 0.1, -1.0).normalize();
    let view = ViewVolume::perspective(ray, Vec3::Y, [2e-5, 2e-5], 0.0, 20.0).unwrap();
    let at = Vec3::new(3.0, 1.0, -6.0);
    let sigma_t = 0.3;
    for spacing in [Spacing::Distance, Spacing::Airlight { sigma_t }] {
        let lattice = lattice(Light::point(at).unwrap(), &view, spacing);
        let space = lattice.space();
        let eye_ray = space.ray(ray);
        let (low, high) = (lattice.ranges().phi()[0], lattice.ranges().phi()[1]);
        let (eye, light) = (Vec3::from(space.eye()).as_dvec3(), at.as_dvec3());
        let ray = ray.as_dvec3();
        let measure = |from, to| match spacing {
            Spacing::Distance => to - from,
            _ => airlight(eye, light, ray, from, to, f64::from(sigma_t)),
        };
        let total = measure(0.0, 20.0);
        for bit in 0..64 {
            let [a, b] = [bit, bit + 1].map(|i| {
                let bound = Phi::of(lattice.bounds()[i]);
                f64::from(space.distance_along(&eye_ray, bound).min(20.0))
            });
            let angles = [bit, bit + 1].map(|i| {
                let bound = Vec2::from(lattice.bounds()[i]);
                f64::from(bound.y).atan2(f64::from(bound.x))
            });
            // A sixteenth of every measure is uniform in φ.
            let uniform = (angles[1] - angles[0]) / (high - low);
            let share = 15.0 / 16.0 * measure(a, b) / total + uniform / 16.0;
            // The table is linear between 8 cells per bit, and the view has
            // a little width.
            assert!(
                (share * 64.0 - 1.0).abs() < 0.03,
                "{spacing:?} {bit}: {}",
                share * 64.0
            );
        }
    }
}

#[test]
fn a_blocker_shadows_from_the_voxel_that_holds_it() {
    for light in lights() {
        let lattice = lattice(light, &camera(0.1, 30.0), Spacing::Angle);
        for theta in [0, 17, 79] {
            for bit in [0, 5, 31, 63] {
                let ray = lattice.light_ray(theta, bit);
                let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
                for distance in [0.01_f32, 0.7, 3.0, 10.0, 25.0] {
                    let point = origin + distance * direction;
                    let place = lattice.space().coordinates(point);
                    let position = lattice.alpha_position(place.ray.alpha);
                    let from = lattice.blocked_from(bit, distance) as f32;
                    let expected = position.clamp(0.0, 96.0);
                    // Rounding of the point: an ULP of its coordinates seen from
                    // the eye.
                    let size = origin.length() + distance + 5.0;
                    let away = (point - Vec3::from(lattice.space().eye())).length();
                    let width = (lattice.ranges().alpha()[1] - lattice.ranges().alpha()[0]) / 96.0;
                    let slack = (5e-7 * (1.0 + size / away)) / width as f32;
                    let step = (lattice.ranges().phi()[1] - lattice.ranges().phi()[0]) / 64.0;
                    let thinnest = 2.0 * width.max(step) as f32;
                    if lattice.space().distance() < thinnest * away {
                        // Two voxels are more than any shadow between such rays.
                        assert_eq!(from, 96.0);
                        continue;
                    }
                    assert!(
                        from <= expected + slack
                            && (from >= 96.0 || from + 1.0 >= expected - slack),
                        "{from}, expected {expected}: {light:?} {theta} {bit} {distance}"
                    );
                }
                assert_eq!(lattice.blocked_from(bit, f32::INFINITY), 96);
                assert_eq!(lattice.blocked_from(bit, f32::MAX), 96);
                assert_eq!(lattice.blocked_from(bit, f32::NAN), 96);
                if light.position().is_some() {
                    assert_eq!(
                        lattice.blocked_from(bit, -1.0),
                        lattice.blocked_from(bit, 0.0)
                    );
                }
            }
        }
    }
}

#[test]
fn spacings_that_cannot_be_are_errors() {
    let space = Space::new(Light::point(Vec3::X).unwrap(), Vec3::ZERO).unwrap();
    let resolution = Resolution::new(8, 8, 32).unwrap();
    let endless = camera(0.1, f32::INFINITY);
    let make = |spacing| Lattice::new(space, &endless, resolution, spacing);
    assert!(matches!(
        make(Spacing::Distance),
        Err(Error::BadValue { .. })
    ));
    for sigma_t in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(make(Spacing::Airlight { sigma_t }).is_err());
    }
    for sigma_t in [0.0, 1e-30, 1e30] {
        let lattice = make(Spacing::Airlight { sigma_t }).unwrap();
        assert!(
            lattice
                .bounds()
                .iter()
                .all(|bound| bound.iter().all(|x| x.is_finite()))
        );
    }
}

#[test]
fn views_that_cannot_be_are_errors() {
    let corners = [
        Vec3::new(-1.0, -1.0, -1.0),
        Vec3::new(1.0, -1.0, -1.0),
        Vec3::new(1.0, 1.0, -1.0),
        Vec3::new(-1.0, 1.0, -1.0),
    ];
    ViewVolume::new(corners, 0.0, 1.0).unwrap();
    ViewVolume::new([corners[3], corners[2], corners[1], corners[0]], 0.0, 1.0).unwrap();
    let crossed = [corners[0], corners[2], corners[1], corners[3]];
    assert!(ViewVolume::new(crossed, 0.0, 1.0).is_err());
    let inwards = [
        corners[0],
        corners[1],
        Vec3::new(-0.5, -0.5, -1.0),
        corners[3],
    ];
    assert!(ViewVolume::new(inwards, 0.0, 1.0).is_err());
    for bad in [Vec3::ZERO, Vec3::NAN, corners[1], Vec3::new(1.0, 1.0, 1.0)] {
        assert!(ViewVolume::new([bad, corners[1], corners[2], corners[3]], 0.0, 1.0).is_err());
    }
    for (near, far) in [
        (-1.0, 1.0),
        (1.0, 1.0),
        (2.0, 1.0),
        (f32::NAN, 1.0),
        (0.0, f32::NAN),
    ] {
        assert!(ViewVolume::new(corners, near, far).is_err(), "{near} {far}");
    }
    for tan in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(ViewVolume::perspective(Vec3::X, Vec3::Y, [tan, 1.0], 0.0, 1.0).is_err());
    }
    assert!(ViewVolume::perspective(Vec3::X, Vec3::NEG_X, [1.0, 1.0], 0.0, 1.0).is_err());
    assert!(ViewVolume::all_around(0.0, f32::INFINITY).is_ok());
}

/// Whether a ray from `origin` meets a triangle, with a little room around.
fn meets(origin: DVec3, direction: DVec3, triangle: &[DVec3; 3], parallel: bool) -> bool {
    let [a, b, c] = triangle.map(|v| v - origin);
    let volume = |u: DVec3, v: DVec3| direction.dot(u.cross(v));
    let [u, v, w] = [volume(b, c), volume(c, a), volume(a, b)];
    let same = (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
    let distance = (u * a + v * b + w * c).dot(direction) / (u + v + w);
    same && (parallel || distance > 0.0)
}

fn coordinate() -> impl Strategy<Value = Vec3> {
    [-6.0_f32..6.0, -6.0..6.0, -6.0..6.0].prop_map(Vec3::from_array)
}

proptest! {
    #![proptest_config(reference::property::cases(400))]
    #[test]
    fn a_footprint_holds_every_light_ray_that_meets_its_triangle(
        corner in coordinate(), light in coordinate(),
        sides in [coordinate(), coordinate()], log_size in -10.0_f32..1.0,
        kind in 0..3, on_axis: bool, along in -1.0_f32..2.0,
    ) {
        let eye = Vec3::new(0.0, 0.5, 2.0);
        let size = log_size.exp2();
        // Anywhere, or next to the axis.
        let corner = if on_axis {
            let axis = if kind == 1 { -light } else { light - eye };
            eye + along * axis + 0.1 * size * corner
        } else {
            corner
        };
        let triangle = [corner, corner + size * sides[0], corner + size * sides[1]];
        let light = match kind {
            0 => Light::point(light),
            1 => Light::directional(light),
            _ => Light::spot(light, Vec3::NEG_Y, 0.7),
        };
        let Ok(light) = light else { return Ok(()) };
        let view = camera(0.1, 12.0);
        let Ok(space) = Space::new(light, eye) else { return Ok(()) };
        let resolution = Resolution::new(8, 512, 32).unwrap();
        let Ok(lattice) = Lattice::new(space, &view, resolution, Spacing::Angle) else {
            return Ok(());
        };
        let footprint = lattice.footprint(&triangle).unwrap();
        let exact = triangle.map(|v| v.as_dvec3());
        for theta in 0..512_usize {
            for bit in 0..32_usize {
                let ray = lattice.light_ray(theta, bit);
                let hit = meets(
                    Vec3::from(ray.origin).as_dvec3(),
                    Vec3::from(ray.direction).as_dvec3(),
                    &exact,
                    light.position().is_none(),
                );
                let planes = &footprint.planes;
                let inside = footprint.bits.contains(&(bit as u32))
                    && [theta, theta + 512].iter().any(|plane| planes.contains(&(*plane as u32)));
                prop_assert!(inside || !hit, "({theta}, {bit}) is not in {footprint:?}");
            }
        }
    }
}

#[test]
fn a_triangle_around_the_axis_or_at_the_light_has_every_plane() {
    let light = Vec3::new(0.2, 1.7, -8.0);
    let lattice = lattice(
        Light::point(light).unwrap(),
        &camera(0.0, 30.0),
        Spacing::Angle,
    );
    let around = [
        Vec3::new(-1.0, 1.0, -4.0),
        Vec3::new(1.0, 1.0, -4.0),
        Vec3::new(0.0, 3.0, -4.0),
    ];
    let footprint = lattice.footprint(&around).unwrap();
    assert_eq!(footprint.planes, 0..80);
    assert_eq!(footprint.bits.start, 0);
    let at_light = [light, light + Vec3::X, light + Vec3::Y];
    assert_eq!(lattice.footprint(&at_light).unwrap().planes, 0..80);
    assert_eq!(lattice.footprint(&[Vec3::NAN; 3]), None);
}
