use glam::{DVec3, IVec3, UVec2, Vec3};
use gpu_backend::Cpu;
use proptest::prelude::*;

use super::maps::{self, Map};
use crate::{Builder, FilterSize, Form, Query, Ray, RayRecord, Rule, ShadowDag, Visibility};

fn build(map: &Map) -> [ShadowDag; 4] {
    let dag = Builder::new().build(&Cpu::new(), map).unwrap();
    let packed = dag.to_form(Form::Packed).unwrap();
    let bare = dag.clone().with_top_grid(0);
    let top = packed.clone().with_top_grid(5);
    [dag, packed, bare, top]
}

fn voxel(side: i32) -> impl Strategy<Value = IVec3> {
    let edge = prop_oneof![0..side, -20..side + 20, Just(i32::MIN), Just(i32::MAX)];
    (edge.clone(), edge.clone(), edge).prop_map(IVec3::from)
}

/// The window around a voxel, one voxel at a time.
fn window(dag: &ShadowDag, voxel: IVec3, width: u32) -> f64 {
    let half = width as i32 / 2;
    let mut lit = 0;
    for dy in -half..=half {
        for dx in -half..=half {
            let at = IVec3::new(
                voxel.x.saturating_add(dx),
                voxel.y.saturating_add(dy),
                voxel.z,
            );
            lit += i32::from(dag.is_lit(at));
        }
    }
    f64::from(lit) / f64::from(width * width)
}

proptest! {
    #![proptest_config(reference::property::cases(48))]

    #[test]
    fn a_filter_is_the_mean_of_its_voxels(
        map in prop_oneof![maps::arbitrary(64), maps::noise(16), maps::arbitrary(128)],
        voxels in proptest::collection::vec(voxel(128), 60),
        width in prop_oneof![Just(1_u32), Just(3), Just(9), (0..20_u32).prop_map(|i| 2 * i + 1)],
    ) {
        let size = FilterSize::new(width).unwrap();
        let dags = build(&map);
        for voxel in voxels {
            let expected = window(&dags[0], voxel, width) as f32;
            for dag in &dags {
                prop_assert_eq!(dag.filter(voxel, size), expected, "{} {}", voxel, width);
            }
        }
    }

    #[test]
    fn a_bilinear_filter_weighs_four_filters(
        map in maps::arbitrary(64),
        places in proptest::collection::vec(
            (-12.0_f32..76.0, -12.0_f32..76.0, -2.0_f32..70.0).prop_map(Vec3::from), 60),
        width in (0..8_u32).prop_map(|i| 2 * i + 1),
    ) {
        let size = FilterSize::new(width).unwrap();
        let dags = build(&map);
        for place in places {
            let corner = (place - Vec3::new(0.5, 0.5, 0.0)).floor().as_ivec3();
            let fraction = place.as_dvec3() - DVec3::new(0.5, 0.5, 0.0) - corner.as_dvec3();
            let mut expected = 0.0;
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let weight = (if dx == 1 { fraction.x } else { 1.0 - fraction.x })
                    * (if dy == 1 { fraction.y } else { 1.0 - fraction.y });
                expected += weight * window(&dags[0], corner + IVec3::new(dx, dy, 0), width);
            }
            let results = dags.each_ref().map(|dag| dag.filter_bilinear(place, size));
            prop_assert!(results.iter().all(|result| *result == results[0]));
            // Four weights and shares, rounded a few times each, of values up
            // to 1; and a fraction rounded in f32 at coordinates below 128.
            let tolerance = 8.0 * f64::from(f32::EPSILON) + 128.0 * f64::from(f32::EPSILON);
            prop_assert!((f64::from(results[0]) - expected).abs() < tolerance, "{}", place);
        }
    }

    #[test]
    fn the_depth_of_a_texel_is_the_slice_at_which_it_turns(
        map in prop_oneof![maps::arbitrary(64), maps::noise(16)],
    ) {
        let side = map.side();
        for dag in build(&map) {
            for texel in 0..side * side {
                let (x, y) = (texel % side, texel / side);
                let depth = dag.depth(UVec2::new(x, y));
                let [enter, exit] = map.texel(x, y);
                prop_assert!((enter..=exit).contains(&depth), "({}, {}): {}", x, y, depth);
                let lit = |z: u32| dag.is_lit(IVec3::new(x as i32, y as i32, z as i32));
                prop_assert!(depth == 0 || lit(depth - 1));
                prop_assert!(depth == side || !lit(depth));
            }
        }
    }

    #[test]
    fn depths_of_the_rules_of_the_papers_lie_between_enter_and_exit(map in maps::arbitrary(64)) {
        for rule in [Rule::Sintorn2014, Rule::Kampe2015] {
            let dag = Builder::new().rule(rule).build(&Cpu::new(), &map).unwrap();
            for texel in 0..64 * 64 {
                let (x, y) = (texel % 64, texel / 64);
                let [enter, exit] = map.texel(x, y);
                prop_assert!((enter..=exit).contains(&dag.depth(UVec2::new(x, y))));
            }
        }
    }

    #[test]
    fn the_visibility_of_a_box_is_that_of_its_voxels(
        map in prop_oneof![maps::arbitrary(32), maps::noise(16)],
        corners in proptest::collection::vec(
            ((-4..36_i32, -4..36_i32, -4..36_i32), (0..20_i32, 0..20_i32, 0..20_i32)), 40),
    ) {
        let dags = build(&map);
        for ((x, y, z), (dx, dy, dz)) in corners {
            let (first, last) = (IVec3::new(x, y, z), IVec3::new(x + dx, y + dy, z + dz));
            let mut seen = [false; 2];
            for z in first.z..=last.z {
                for y in first.y..=last.y {
                    for x in first.x..=last.x {
                        seen[usize::from(dags[0].is_lit(IVec3::new(x, y, z)))] = true;
                    }
                }
            }
            let expected = match seen {
                [true, true] => Visibility::Mixed,
                [true, false] => Visibility::Shadowed,
                _ => Visibility::Lit,
            };
            for dag in &dags {
                prop_assert_eq!(dag.visibility(first, last), expected, "{} {}", first, last);
            }
        }
    }

    #[test]
    fn batches_are_single_questions(
        map in maps::arbitrary(64),
        voxels in proptest::collection::vec(voxel(64), 0..700),
    ) {
        let dag = &build(&map)[1];
        let size = FilterSize::new(5).unwrap();
        let places: Vec<Vec3> = voxels.iter().map(|voxel| voxel.as_vec3() + 0.25).collect();
        for cpu in [Cpu::new(), Cpu::single_threaded()] {
            let mut lit = vec![false; voxels.len()];
            let (mut hard, mut soft) = (vec![0.0; voxels.len()], vec![0.0; voxels.len()]);
            dag.is_lit_batch(&cpu, &voxels, &mut lit).unwrap();
            dag.filter_batch(&cpu, &voxels, size, &mut hard).unwrap();
            dag.filter_bilinear_batch(&cpu, &places, size, &mut soft).unwrap();
            for i in 0..voxels.len() {
                prop_assert_eq!(lit[i], dag.is_lit(voxels[i]));
                prop_assert_eq!(hard[i], dag.filter(voxels[i], size));
                prop_assert_eq!(soft[i], dag.filter_bilinear(places[i], size));
            }
            prop_assert!(dag.is_lit_batch(&cpu, &voxels, &mut vec![false; voxels.len() + 1]).is_err());
        }
    }
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    #[test]
    fn steps_are_single_questions(
        map in maps::arbitrary(64),
        voxels in proptest::collection::vec(voxel(64), 0..300),
    ) {
        let dag = &build(&map)[1];
        let size = FilterSize::new(5).unwrap();
        let count = voxels.len();
        let fours: Vec<[i32; 4]> = voxels.iter().map(|voxel| voxel.extend(7).to_array()).collect();
        let boxes: Vec<_> = fours.iter().map(|&first| [first, first.map(|x| x.saturating_add(5))]).collect();
        let places: Vec<_> = voxels.iter().map(|voxel| (voxel.as_vec3() + 0.25).extend(7.0).to_array()).collect();
        let texels: Vec<_> = voxels.iter().map(|voxel| voxel.truncate().as_uvec2().to_array()).collect();
        let rays: Vec<_> = voxels
            .iter()
            .map(|voxel| {
                let origin = voxel.clamp(IVec3::splat(-99), IVec3::splat(99)).as_vec3();
                RayRecord::new(origin, Vec3::new(0.5, -0.3, 1.0), f32::MAX)
            })
            .collect();
        for cpu in [Cpu::new(), Cpu::single_threaded()] {
            let resident = dag.upload(&cpu).unwrap();
            prop_assert!(resident.as_bytes() == dag.as_bytes());
            let (mut lit, mut counts, mut depths, mut seen, mut parts) =
                (vec![0; count], vec![0; count], vec![0; count], vec![0; count], vec![0; count]);
            let (mut hard, mut soft, mut lengths) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
            let mut intervals = vec![[0.0; 2]; 2 * count];
            cpu.is_lit(&resident, &fours, &mut lit).unwrap();
            cpu.count_lit(&resident, size, &fours, &mut counts).unwrap();
            cpu.filter(&resident, size, &fours, &mut hard).unwrap();
            cpu.filter_bilinear(&resident, size, &places, &mut soft).unwrap();
            cpu.depth(&resident, &texels, &mut depths).unwrap();
            cpu.visibility(&resident, &boxes, &mut seen).unwrap();
            cpu.lit_length(&resident, &rays, &mut lengths).unwrap();
            cpu.lit_intervals(&resident, &rays, &mut intervals, &mut parts).unwrap();
            for (i, &voxel) in voxels.iter().enumerate() {
                prop_assert_eq!(lit[i] == 1, dag.is_lit(voxel));
                prop_assert_eq!(counts[i], dag.count_lit(voxel, size));
                prop_assert_eq!(hard[i], dag.filter(voxel, size));
                prop_assert_eq!(soft[i], dag.filter_bilinear(voxel.as_vec3() + 0.25, size));
                prop_assert_eq!(depths[i], dag.depth(voxel.truncate().as_uvec2()));
                let last = IVec3::from_slice(&boxes[i][1]);
                prop_assert_eq!(seen[i], dag.visibility(voxel, last) as u32);
                let ray = Ray::new(rays[i].origin, rays[i].direction, rays[i].length).unwrap();
                prop_assert_eq!(lengths[i], dag.lit_length(&ray) as f32);
                let expected = dag.lit_intervals(&ray);
                prop_assert_eq!(parts[i] as usize, expected.len());
                for (found, expected) in intervals[2 * i..][..2].iter().zip(expected) {
                    prop_assert_eq!(*found, expected.map(|s| s as f32));
                }
            }
            prop_assert!(cpu.depth(&resident, &texels, &mut vec![0; count + 1]).is_err());
            let mut none = Vec::new();
            cpu.lit_intervals(&resident, &rays, &mut none, &mut parts).unwrap();
            if count > 1 {
                let mut uneven = vec![[0.0; 2]; count + 1];
                prop_assert!(cpu.lit_intervals(&resident, &rays, &mut uneven, &mut parts).is_err());
            }
        }
    }
}

/// Questions of a picture: texel by texel and row by row, with steps in the grid.
fn picture() -> impl Strategy<Value = Vec<IVec3>> {
    let step = || (-2..3_i32, -2..3_i32, -1..2_i32).prop_map(IVec3::from);
    let size = prop_oneof![
        Just([1, 1]),
        Just([7, 13]),
        (1..90_i32).prop_map(|n| [1, n]),
        (1..40_i32, 1..40_i32).prop_map(<[i32; 2]>::from),
    ];
    (voxel(64), step(), step(), size).prop_map(|(first, along, down, [width, height])| {
        let first = first.clamp(IVec3::splat(-9), IVec3::splat(73));
        let at = |i: i32| first + along * (i % width) + down * (i / width);
        (0..width * height).map(at).collect()
    })
}

proptest! {
    #![proptest_config(reference::property::cases(48))]

    #[test]
    fn batches_of_pictures_in_any_order_are_single_questions(
        map in prop_oneof![maps::arbitrary(64), maps::noise(16), maps::noise(8)],
        rows in picture(),
        others in picture(),
        width in prop_oneof![Just(9_u32), (0..40_u32).prop_map(|i| 2 * i + 1)],
    ) {
        let size = FilterSize::new(width).unwrap();
        let backwards = rows.iter().rev().copied().collect();
        // Two pictures that take turns want the same places.
        let turns = rows.iter().zip(&others).flat_map(|(a, b)| [*a, *b]).collect();
        for dag in &build(&map) {
            for voxels in [&rows, &backwards, &turns] {
                let places: Vec<Vec3> = voxels.iter().map(|voxel| voxel.as_vec3() + 0.25).collect();
                for cpu in [Cpu::new(), Cpu::single_threaded()] {
                    let mut lit = vec![false; voxels.len()];
                    let (mut hard, mut soft) = (vec![0.0; voxels.len()], vec![0.0; voxels.len()]);
                    dag.is_lit_batch(&cpu, voxels, &mut lit).unwrap();
                    dag.filter_batch(&cpu, voxels, size, &mut hard).unwrap();
                    dag.filter_bilinear_batch(&cpu, &places, size, &mut soft).unwrap();
                    for i in 0..voxels.len() {
                        prop_assert_eq!(lit[i], dag.is_lit(voxels[i]));
                        prop_assert_eq!(hard[i], dag.filter(voxels[i], size));
                        prop_assert_eq!(soft[i], dag.filter_bilinear(places[i], size));
                    }
                }
            }
        }
    }
}

#[test]
fn a_batch_of_the_widest_filter_is_answered() {
    let size = FilterSize::new(65535).unwrap();
    for dag in build(&Map::new(64, |x, _| [x / 2; 2])) {
        let voxels = [IVec3::splat(4), IVec3::MAX, IVec3::MIN, IVec3::splat(4)];
        let mut lit = [0.0; 4];
        dag.filter_batch(&Cpu::new(), &voxels, size, &mut lit)
            .unwrap();
        assert_eq!(lit, voxels.map(|voxel| dag.filter(voxel, size)));
    }
}

#[test]
fn beside_and_in_front_of_the_map_is_lit_and_behind_it_as_at_its_end() {
    let [dag, ..] = build(&Map::new(8, |x, _| if x < 4 { [0; 2] } else { [8; 2] }));
    for lit in [
        IVec3::new(-1, 0, 4),
        IVec3::new(0, 8, 4),
        IVec3::new(0, 0, -1),
        IVec3::MIN,
    ] {
        assert!(dag.is_lit(lit), "{lit}");
    }
    assert!(!dag.is_lit(IVec3::new(0, 0, i32::MAX)));
    assert!(dag.is_lit(IVec3::new(7, 0, i32::MAX)));
}

#[test]
fn a_filter_of_even_width_is_an_error() {
    for width in [0, 2, 8, 65536, u32::MAX] {
        assert!(FilterSize::new(width).is_err(), "{width}");
    }
}

#[test]
fn the_widest_filter_at_the_ends_of_the_numbers_is_answered() {
    let dags = build(&Map::new(8, |_, _| [0; 2]));
    let size = FilterSize::new(65535).unwrap();
    for dag in dags {
        let expected = 1.0 - 64.0 / (65535.0 * 65535.0);
        assert_eq!(
            f64::from(dag.filter(IVec3::splat(4), size)),
            f64::from(expected as f32)
        );
        assert_eq!(dag.filter(IVec3::MAX, size), 1.0);
        for place in [Vec3::MAX, Vec3::MIN, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(dag.filter_bilinear(place, size), 1.0);
        }
    }
}

#[test]
fn a_bias_is_half_a_width_along_the_normal() {
    let size = FilterSize::new(9).unwrap();
    let at = DVec3::new(10.7, 20.2, 30.9);
    assert_eq!(size.bias(at, Vec3::ZERO), IVec3::new(10, 20, 30));
    assert_eq!(size.bias(at, -7.0 * Vec3::Z), IVec3::new(10, 20, 25));
    assert_eq!(
        size.bias(at, Vec3::new(3.0, 0.0, -4.0)),
        IVec3::new(13, 20, 26)
    );
    assert_eq!(size.bias(DVec3::MAX, Vec3::X), IVec3::MAX);
    assert_eq!(size.bias(at, Vec3::NAN), IVec3::new(10, 20, 30));
}

#[test]
fn a_slanted_surface_does_not_shadow_itself_once_biased() {
    // z = x/2: shadowed behind; its normal points to the light and to +x.
    let map = Map::new(64, |x, _| [x / 2; 2]);
    let [dag, ..] = build(&map);
    let normal = Vec3::new(0.5, 0.0, -1.0);
    let size = FilterSize::new(9).unwrap();
    for x in 8..56 {
        let at = DVec3::new(f64::from(x) + 0.5, 30.0, f64::from(x / 2) - 0.5);
        assert_eq!(dag.filter(size.bias(at, normal), size), 1.0, "{x}");
    }
}

proptest! {
    #![proptest_config(reference::property::cases(64))]

    #[test]
    fn no_plane_shadows_itself_once_it_is_cleared(
        slopes in [-3.0_f32..3.0, -3.0_f32..3.0],
        width in 0_u32..6,
        at in [20.0_f32..44.0, 20.0_f32..44.0],
    ) {
        let [a, b] = slopes;
        let plane = |x: f32, y: f32| 32.0 + a * (x - 32.0) + b * (y - 32.0);
        let map = Map::new(64, |x, y| {
            let slice = plane(x as f32 + 0.5, y as f32 + 0.5).floor().clamp(0.0, 64.0);
            [slice as u32; 2]
        });
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        let size = FilterSize::new(2 * width + 1).unwrap();
        let normal = Vec3::new(a, b, -1.0);
        let [x, y] = at;
        let point = DVec3::new(x.into(), y.into(), plane(x, y).into());
        let voxel = size.bias_beyond(size.clearance(normal), point, normal);
        prop_assert_eq!(dag.filter(voxel, size), 1.0);
    }
}
