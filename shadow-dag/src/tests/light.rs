use glam::dcamera::rh::view::look_at_mat4;
use glam::{DMat4, DVec3, DVec4, Vec3};
use gpu_backend::Cpu;
use proptest::prelude::*;

use crate::{Builder, DepthMap, Error, LightSpace, Resolution, Slices};

fn resolution() -> Resolution {
    Resolution::new(64).unwrap()
}

fn lights() -> [LightSpace; 2] {
    let view = look_at_mat4(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y);
    [
        LightSpace::orthographic(view, 3.0, 2.0, 0.5, 8.0).unwrap(),
        LightSpace::perspective(view, 1.0, 0.5, 8.0).unwrap(),
    ]
}

fn near(a: DVec3, b: DVec3) {
    assert!((a - b).abs().max_element() < 1e-4, "{a} is not {b}");
}

#[test]
fn the_corners_of_the_map_are_where_they_should_be() {
    let light = LightSpace::orthographic(DMat4::IDENTITY, 4.0, 2.0, 1.0, 9.0).unwrap();
    let voxel = |x, y, z| light.voxel(resolution(), Vec3::new(x, y, z)).unwrap();
    // Row 0 is on top, slices run along −Z.
    near(voxel(-2.0, 1.0, -1.0), DVec3::ZERO);
    near(voxel(2.0, -1.0, -9.0), DVec3::splat(64.0));
    near(voxel(0.0, 0.0, -5.0), DVec3::splat(32.0));
    let angle = std::f64::consts::FRAC_PI_2;
    let light = LightSpace::perspective(DMat4::IDENTITY, angle, 1.0, 16.0).unwrap();
    let voxel = |x, y, z| light.voxel(resolution(), Vec3::new(x, y, z)).unwrap();
    near(voxel(-1.0, 1.0, -1.0), DVec3::ZERO);
    near(voxel(16.0, -16.0, -16.0), DVec3::splat(64.0));
    // The middle slice is at the geometric mean.
    near(voxel(0.0, 0.0, -4.0), DVec3::splat(32.0));
}

#[test]
fn points_that_a_light_cannot_see_have_no_voxel() {
    let [parallel, perspective] = lights();
    for light in [parallel, perspective] {
        assert_eq!(light.voxel(resolution(), Vec3::NAN), None);
    }
    assert_eq!(
        perspective.voxel(resolution(), Vec3::new(2.0, 4.0, 6.0)),
        None,
        "behind"
    );
    assert_eq!(
        perspective.voxel(resolution(), Vec3::new(1.0, 2.0, 3.0)),
        None,
        "at the light"
    );
    assert!(
        parallel
            .voxel(resolution(), Vec3::new(2.0, 4.0, 6.0))
            .is_some()
    );
}

#[test]
fn spaces_that_are_none_are_errors() {
    let view = DMat4::IDENTITY;
    for (width, height, near, far) in [
        (0.0, 1.0, 0.0, 1.0),
        (1.0, -1.0, 0.0, 1.0),
        (1.0, 1.0, 1.0, 1.0),
        (1.0, f64::NAN, 0.0, 1.0),
        (f64::INFINITY, 1.0, 0.0, 1.0),
    ] {
        let light = LightSpace::orthographic(view, width, height, near, far);
        assert!(matches!(light, Err(Error::BadValue { .. })), "{light:?}");
    }
    for (angle, near, far) in [
        (0.0, 1.0, 2.0),
        (3.2, 1.0, 2.0),
        (1.0, 0.0, 2.0),
        (1.0, 2.0, 2.0),
        (1.0, 1.0, f64::INFINITY),
        (f64::NAN, 1.0, 2.0),
    ] {
        let light = LightSpace::perspective(view, angle, near, far);
        assert!(matches!(light, Err(Error::BadValue { .. })), "{light:?}");
    }
    let flat = DMat4::from_diagonal(DVec4::new(1.0, 1.0, 0.0, 1.0));
    let infinite = DMat4::from_diagonal(DVec4::splat(f64::INFINITY));
    let projective = DMat4::from_diagonal(DVec4::new(1.0, 1.0, 1.0, 2.0));
    for matrix in [flat, infinite, projective, DMat4::ZERO] {
        assert!(LightSpace::new(matrix, Slices::Linear).is_err(), "{matrix}");
    }
}

proptest! {
    #![proptest_config(reference::property::cases(256))]

    #[test]
    fn normals_stay_perpendicular_to_their_surface(
        point in (-0.8_f64..0.8, -0.8_f64..0.8, -0.8_f64..0.8).prop_map(DVec3::from),
        normal in (-1.0_f64..1.0, -1.0_f64..1.0, -1.0_f64..1.0).prop_map(DVec3::from),
    ) {
        prop_assume!(normal.length() > 0.1);
        let normal = normal.normalize();
        for light in lights() {
            let turned = light.normal(point.as_vec3(), normal.as_vec3()).as_dvec3();
            prop_assert!((turned.length() - 1.0).abs() < 1e-5);
            // Steps large enough for points in f32 and small enough for a
            // derivative: errors of about 1e-3 of a step each.
            let step = |direction: DVec3| {
                let ends = [1.0, -1.0].map(|sign| {
                    let point = point + direction * (0.005 * sign);
                    light.voxel(resolution(), point.as_vec3()).unwrap()
                });
                (ends[0] - ends[1]).normalize()
            };
            let tangent = normal.any_orthonormal_vector();
            for along in [tangent, normal.cross(tangent)] {
                prop_assert!(turned.dot(step(along)).abs() < 5e-3, "{} {:?}", turned, light);
            }
            prop_assert!(turned.dot(step(normal)) > 0.0);
        }
    }

    #[test]
    fn slices_and_depths_undo_each_other(position in 0.0_f64..1.0) {
        for slices in [Slices::Linear, Slices::logarithmic(0.1, 500.0).unwrap()] {
            let back = slices.position(slices.depth(position));
            prop_assert!((back - position).abs() < 1e-14);
        }
    }
}

#[test]
fn logarithmic_slices_compare_centres_by_distance() {
    let slices = Slices::logarithmic(1.0, 100.0).unwrap();
    let depths: Vec<f32> = (0..64 * 64).map(|i| 0.5 + i as f32 * 0.03).collect();
    let map = DepthMap::new(resolution(), slices, &depths).unwrap();
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    for (i, &depth) in (0..).zip(&depths) {
        for z in 0..64 {
            let centre = slices.depth((f64::from(z) + 0.5) / 64.0);
            // Nearer than this the rounding of a logarithm decides.
            if (centre - f64::from(depth)).abs() > 1e-12 {
                let lit = dag.is_lit(glam::IVec3::new(i % 64, i / 64, z));
                assert_eq!(lit, centre < f64::from(depth), "{depth} at {z}");
            }
        }
    }
}
