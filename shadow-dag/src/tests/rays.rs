use glam::dcamera::rh::view::look_at_mat4;
use glam::{DMat4, DVec3, IVec3, Vec3};
use gpu_backend::Cpu;
use proptest::prelude::*;

use super::maps;
use crate::query::stepping;
use crate::{Builder, Form, LightSpace, Ray, ShadowDag, Slices};

fn coordinate(side: f32) -> impl Strategy<Value = f32> {
    prop_oneof![
        -0.5 * side..1.5 * side,
        // On planes between voxels and at their middles.
        (0..=2 * side as i32).prop_map(|i| i as f32 / 2.0),
    ]
}

fn slope() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0_f32),
        Just(1.0),
        Just(-1.0),
        -1.0_f32..1.0,
        -1e-6_f32..1e-6
    ]
}

pub(crate) fn ray(side: f32) -> impl Strategy<Value = Ray> {
    let origin = (coordinate(side), coordinate(side), coordinate(side));
    let length = prop_oneof![Just(0.0_f32), 0.0_f32..4.0 * side, Just(f32::INFINITY)];
    (origin, (slope(), slope(), slope()), length).prop_filter_map(
        "no direction",
        |(origin, direction, length)| {
            Ray::new(Vec3::from(origin), Vec3::from(direction), length).ok()
        },
    )
}

pub(crate) fn spaces(side: f64) -> [LightSpace; 3] {
    // A light above the middle of the cube of the rays.
    let eye = DVec3::new(0.5, 0.5, -1.0) * side;
    let view = look_at_mat4(eye, DVec3::splat(0.5 * side), DVec3::Y);
    let sun = look_at_mat4(DVec3::ZERO, DVec3::new(0.3, 0.2, 1.0), DVec3::Y);
    [
        LightSpace::new(DMat4::from_scale(DVec3::splat(1.0 / side)), Slices::Linear).unwrap(),
        LightSpace::orthographic(sun, 2.0 * side, 1.5 * side, -side, 2.0 * side).unwrap(),
        LightSpace::perspective(view, 1.1, 0.3 * side, 2.5 * side).unwrap(),
    ]
}

proptest! {
    #![proptest_config(reference::property::cases(96))]

    #[test]
    fn lit_intervals_are_those_of_voxel_by_voxel_steps(
        map in prop_oneof![maps::arbitrary(32), maps::noise(16), maps::arbitrary(64)],
        rays in proptest::collection::vec(ray(1.0), 20),
        scale in prop_oneof![Just(1.0_f32), Just(32.0), Just(1000.0)],
    ) {
        let graph = Builder::new().build(&Cpu::new(), &map).unwrap().graph();
        for space in spaces(1.0) {
            let plain = ShadowDag::from_graph(&graph, Some(&space), Form::Plain).unwrap();
            let packed = plain.to_form(Form::Packed).unwrap();
            for ray in &rays {
                let length = ray.length();
                let ray = Ray::new(
                    ray.at(0.0).as_vec3(),
                    (ray.at(1.0) - ray.at(0.0)).as_vec3() * scale,
                    length / scale,
                )
                .unwrap();
                let expected = stepping(&plain, &ray);
                prop_assert_eq!(&plain.lit_intervals(&ray), &expected, "{:?}", ray);
                prop_assert_eq!(&packed.lit_intervals(&ray), &expected, "{:?}", ray);
                let in_order = expected.iter().flatten().is_sorted();
                prop_assert!(in_order && expected.iter().all(|[start, end]| start < end));
            }
        }
    }

    #[test]
    fn the_middle_of_an_interval_is_what_the_voxel_there_is(
        map in maps::arbitrary(32),
        rays in proptest::collection::vec(ray(1.0), 20),
    ) {
        let graph = Builder::new().build(&Cpu::new(), &map).unwrap().graph();
        for space in spaces(1.0) {
            let dag = ShadowDag::from_graph(&graph, Some(&space), Form::Plain).unwrap();
            for ray in &rays {
                let mut edges = vec![0.0];
                edges.extend(dag.lit_intervals(ray).iter().flatten());
                edges.push(ray.length().into());
                for pair in edges.windows(2) {
                    let middle = 0.5 * (pair[0] + pair[1]);
                    // Shorter pieces do not leave room for the rounding of a
                    // point to f32.
                    if !(pair[1] - pair[0] > 1e-4 && middle < 8.0) {
                        continue;
                    }
                    let point = ray.at(middle).as_vec3();
                    let voxel = space.voxel(dag.resolution(), point);
                    let near_plane = voxel.is_some_and(|voxel| {
                        (voxel - voxel.round()).abs().min_element() < 1e-3
                    });
                    if near_plane {
                        continue;
                    }
                    let lit = voxel.is_none_or(|voxel| dag.is_lit(voxel.floor().as_ivec3()));
                    let expected = dag.lit_intervals(ray).iter()
                        .any(|[start, end]| (*start..*end).contains(&middle));
                    prop_assert_eq!(lit, expected, "{} of {:?} in {:?}", middle, ray, space);
                }
            }
        }
    }
}

#[test]
fn without_a_light_rays_are_in_voxels() {
    let map = maps::Map::new(16, |x, _| if x < 8 { [4; 2] } else { [16; 2] });
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let lit = |origin: [f32; 3], direction: [f32; 3], length: f32| {
        let ray = Ray::new(origin, direction, length).unwrap();
        (dag.lit_intervals(&ray), dag.lit_length(&ray))
    };
    assert_eq!(
        lit([2.5, 2.5, -1.0], [0.0, 0.0, 1.0], 100.0),
        (vec![[0.0, 5.0]], 5.0)
    );
    assert_eq!(
        lit([-2.0, 2.5, 10.5], [1.0, 0.0, 0.0], 100.0),
        (vec![[0.0, 2.0], [10.0, 100.0]], 92.0)
    );
    assert_eq!(lit([-2.0, -2.5, 10.5], [1.0, 0.0, 0.0], 100.0).1, 100.0);
    assert_eq!(
        lit([2.5, 2.5, 20.0], [0.0, 0.0, 1.0], 10.0).1,
        0.0,
        "behind the last slice"
    );
    assert_eq!(
        lit([2.5, 2.5, 20.0], [0.0, 0.0, -1.0], f32::INFINITY).1,
        f64::INFINITY
    );
    assert_eq!(
        lit([2.5, 2.5, 3.0], [0.0, 0.0, 1.0], 0.0),
        (vec![], 0.0),
        "no length"
    );
    assert!(!dag.is_lit(IVec3::new(2, 2, 20)));
}

#[test]
fn rays_that_are_none_are_errors() {
    let good = (Vec3::ZERO, Vec3::X, 1.0);
    assert!(Ray::new(good.0, good.1, good.2).is_ok());
    assert!(Ray::new(Vec3::NAN, good.1, good.2).is_err());
    assert!(Ray::new(good.0, Vec3::ZERO, good.2).is_err());
    assert!(Ray::new(good.0, Vec3::INFINITY, good.2).is_err());
    assert!(Ray::new(good.0, good.1, -1.0).is_err());
    assert!(Ray::new(good.0, good.1, f32::NAN).is_err());
}
