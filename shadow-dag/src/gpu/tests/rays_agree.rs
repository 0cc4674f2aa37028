//! Rays: every point is answered as on the CPU, or as close by.

use glam::{DVec3, IVec3, Vec3};
use gpu_backend::{Backend, Cpu, Download, testing};
use proptest::prelude::*;
use reference::tolerances::Allowed;

use crate::tests::{light_spaces, maps, ray};
use crate::{Builder, Error, Form, LightSpace, Query, Ray, RayRecord, ShadowDag, Slices};

/// How far beside a point its answer may come from, in voxels; see the
/// documentation of the module.
pub(super) fn delta(space: &LightSpace, side: f64, ray: &Ray, s: f64) -> DVec3 {
    let (origin, point) = (ray.at(0.0), ray.at(s));
    let w = space.homogeneous(point.extend(1.0)).w;
    let sum = (0..4)
        .map(|row| {
            let row = space.matrix().row(row).abs();
            row.dot(origin.abs().extend(1.0)) + row.truncate().dot((point - origin).abs())
        })
        .fold(1.0, f64::max)
        / w.min(1.0);
    let unit = side / f64::from(1 << 20);
    let along = match space.slices() {
        Slices::Linear => 0.0,
        Slices::Logarithmic(ends) => 1.0 + 1.0 / (ends.far() / ends.near()).ln(),
    };
    DVec3::new(sum, sum, sum + along) * unit
}

/// Whether all voxels within `delta` of a point are lit, or all shadowed;
/// none if neither.
fn answer(dag: &ShadowDag, space: &LightSpace, point: Vec3, delta: DVec3) -> Option<bool> {
    let Some(position) = space.voxel(dag.resolution(), point) else {
        return Some(true);
    };
    let lit = |corner: i32| {
        let sign = |bit: i32| f64::from(2 * (corner >> bit & 1) - 1);
        let at = position + delta * DVec3::new(sign(0), sign(1), sign(2));
        dag.is_lit(at.floor().as_ivec3())
    };
    (1..8).all(|corner| lit(corner) == lit(0)).then(|| lit(0))
}

fn check(dag: &ShadowDag, rays: &[Ray]) -> Result<(), Error> {
    let Some(gpu) = testing::gpu() else {
        return Ok(());
    };
    let voxels = LightSpace::of_voxels(dag.resolution());
    let space = dag.light().unwrap_or(&voxels);
    let side = f64::from(dag.resolution().side());
    let records: Vec<RayRecord> = rays
        .iter()
        .map(|ray| {
            let direction = (ray.at(1.0) - ray.at(0.0)).as_vec3();
            RayRecord::new(ray.at(0.0).as_vec3(), direction, ray.length().min(f32::MAX))
        })
        .collect();
    let there = gpu.upload(&records)?;
    let places = 200;
    for form in [Form::Plain, Form::Packed] {
        let resident = dag.to_form(form)?.upload(&gpu)?;
        let mut intervals = gpu.zeros(places * rays.len())?;
        let (mut counts, mut lengths) = (gpu.zeros(rays.len())?, gpu.zeros(rays.len())?);
        gpu.lit_intervals(&resident, &there, &mut intervals, &mut counts)?;
        gpu.lit_length(&resident, &there, &mut lengths)?;
        let intervals: Vec<[f32; 2]> = gpu.download(&intervals)?;
        let counts: Vec<u32> = gpu.download(&counts)?;
        let lengths: Vec<f32> = gpu.download(&lengths)?;
        for (i, ray) in rays.iter().enumerate() {
            let count = counts[i] as usize;
            assert!(count <= places, "{count} intervals");
            let found = &intervals[i * places..][..count];
            assert!(found.iter().all(|[start, end]| start < end), "{found:?}");
            assert!(found.as_flattened().is_sorted(), "{found:?}");
            let sum: f32 = found.iter().map(|[start, end]| end - start).sum();
            assert!(
                (sum - lengths[i]).abs() <= Allowed::GpuLitLength.error() as f32 * sum,
                "{sum} {}",
                lengths[i]
            );
            // Middles of the parts of either backend, and points between.
            let mut ends: Vec<f64> = dag.lit_intervals(ray).into_flattened();
            ends.extend(found.as_flattened().iter().map(|&s| f64::from(s)));
            ends.extend(
                (0..20).map(|k| f64::from(k) * f64::from(ray.length()).min(4.0 * side) / 20.0),
            );
            ends.sort_by(f64::total_cmp);
            for pair in ends.windows(2) {
                let s = 0.5 * (pair[0] + pair[1]);
                if !(s < f64::from(ray.length()).min(8.0 * side)) {
                    continue;
                }
                let expected = answer(dag, space, ray.at(s).as_vec3(), delta(space, side, ray, s));
                let lit = found
                    .iter()
                    .any(|&[a, b]| (f64::from(a)..f64::from(b)).contains(&s));
                if let Some(expected) = expected {
                    assert_eq!(lit, expected, "{s} of {ray:?} in {space:?}: {found:?}");
                }
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    #[test]
    fn points_of_rays_are_answered_from_no_further_than_stated(
        map in prop_oneof![maps::arbitrary(32), maps::noise(16), maps::arbitrary(64)],
        rays in proptest::collection::vec(ray(1.0), 40),
    ) {
        let graph = Builder::new().build(&Cpu::new(), &map).unwrap().graph();
        for space in light_spaces(1.0) {
            let dag = ShadowDag::from_graph(&graph, Some(&space), Form::Plain).unwrap();
            check(&dag, &rays).unwrap();
        }
    }
}

#[test]
fn rays_that_are_none_have_no_lit_parts_and_others_in_voxels_the_known_ones() {
    let map = maps::Map::new(16, |x, _| if x < 8 { [4; 2] } else { [16; 2] });
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let known = |x: f32, z: f32, length: f32| {
        RayRecord::new(
            Vec3::new(x, 2.5, z),
            if x < 0.0 { Vec3::X } else { Vec3::Z },
            length,
        )
    };
    let records = [
        known(2.5, -1.0, 100.0),
        known(-2.0, 10.5, 100.0),
        known(2.5, 20.0, f32::MAX),
        known(9.5, 20.0, f32::MAX),
        RayRecord::new(Vec3::NAN, Vec3::X, 1.0),
        RayRecord::new(Vec3::ZERO, Vec3::ZERO, 1.0),
        RayRecord::new(Vec3::ZERO, Vec3::INFINITY, 1.0),
        RayRecord::new(Vec3::ZERO, Vec3::X, -1.0),
        RayRecord::new(Vec3::ZERO, Vec3::X, 0.0),
    ];
    let expected = [5.0, 92.0, 0.0, f32::MAX, 0.0, 0.0, 0.0, 0.0, 0.0];
    fn lengths<B: Query + Download>(backend: &B, dag: &ShadowDag, rays: &[RayRecord]) -> Vec<f32> {
        let dag = dag.upload(backend).unwrap();
        let rays_there = backend.upload(rays).unwrap();
        let mut lengths = backend.zeros(rays.len()).unwrap();
        backend.lit_length(&dag, &rays_there, &mut lengths).unwrap();
        backend.download(&lengths).unwrap()
    }
    assert_eq!(lengths(&Cpu::new(), &dag, &records), expected);
    if let Some(gpu) = testing::gpu() {
        for (found, expected) in lengths(&gpu, &dag, &records).into_iter().zip(expected) {
            assert!(
                (found - expected).abs() <= Allowed::GpuLitLength.error() as f32 * expected,
                "{found} {expected}"
            );
        }
    }
    assert!(!dag.is_lit(IVec3::new(2, 2, 20)));
}
