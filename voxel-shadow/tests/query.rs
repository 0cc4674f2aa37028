//! Queries against the bits they read, and against the truth.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

mod common;

use epipolar::{Lattice, Light, Space, Spacing, ViewVolume};
use glam::{Vec3, Vec3Swizzles};
use gpu_backend::{Cpu, Host};
use proptest::prelude::*;
use voxel_shadow::{Error, Grid, LitInterval, Query, Sampling, ShadowVolume, Weights};

use common::{EYE, balls, build, camera, is_lit, lattice, lights};

const SMOOTH: Sampling = Sampling {
    interpolate: true,
    ..Sampling::NEAREST
};

/// A grid of any bits, extruded or not.
fn noise(lattice: &Lattice, seed: u32) -> Grid<Host> {
    let words = (0..lattice.resolution().words() as u32)
        .map(|i| {
            let mixed = (i ^ seed).wrapping_mul(2_654_435_761);
            (mixed ^ (mixed >> 15)).wrapping_mul(0x9E37_79B9)
        })
        .collect();
    Grid::from_words(lattice.resolution(), words).unwrap()
}

fn directions() -> Vec<Vec3> {
    let mut directions = Vec::new();
    for i in -12..=12 {
        for j in -8..=8 {
            directions.push(Vec3::new(0.07 * i as f32, 0.07 * j as f32, -1.0));
        }
    }
    directions
}

#[test]
fn at_the_centre_of_a_voxel_visibility_is_its_bit() {
    for light in lights() {
        let lattice = lattice(light, &camera(0.1, 20.0), [16, 16, 32]);
        let grid = noise(&lattice, 7);
        let mut seen = 0;
        for sampling in [Sampling::NEAREST, SMOOTH] {
            let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
            for alpha in 0..16 {
                for theta in 0..16 {
                    for bit in 0..32 {
                        let centre = lattice.centre(alpha, theta, bit);
                        let Some(point) = lattice.space().point(&centre).map(Vec3::from) else {
                            continue;
                        };
                        // Where the two rays are nearly parallel the point is
                        // uncertain; its coordinates say which voxel it is in.
                        let again = lattice.space().coordinates(point);
                        let shift = (lattice.phi_position(again.phi) - bit as f32 - 0.5).abs()
                            + (lattice.theta_position(again.ray.theta) - theta as f32 - 0.5).abs();
                        if shift > 1e-3 {
                            continue;
                        }
                        seen += 1;
                        let expected = f32::from(u8::from(!grid.bits(alpha, theta)[bit as usize]));
                        let found = volume.visibility(point);
                        // Linear in two positions that are off by `shift`.
                        assert!(
                            (found - expected).abs() <= shift + 1e-6,
                            "{found} {expected}"
                        );
                        let eye_ray = point - EYE;
                        let found = volume
                            .ray_shadow(eye_ray, 20.0)
                            .visibility(eye_ray.length());
                        assert!((found - expected).abs() <= 0.01, "{found} {expected}");
                    }
                }
            }
        }
        assert!(seen > 2000, "{seen} {light:?}");
    }
}

#[test]
fn sums_and_intervals_are_those_of_the_bits() {
    for light in lights() {
        for words in [1, 4, 7] {
            let lattice = lattice(light, &camera(0.1, 20.0), [16, 16, 32 * words]);
            let grid = noise(&lattice, words);
            let bits = 32 * words as usize;
            let weights: Vec<f32> = (0..bits).map(|i| 1.0 + (i % 5) as f32).collect();
            let total: f32 = weights.iter().sum();
            let table = Weights::new(&weights).unwrap();
            let uniform = Weights::new(&vec![1.0; bits]).unwrap();
            for sampling in [Sampling::NEAREST, SMOOTH] {
                let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
                for direction in directions() {
                    for surface in [0.0, 0.3, 7.0, f32::INFINITY] {
                        let ray = volume.ray_shadow(direction, surface);
                        let end = ray.end();
                        // Bit by bit, through the visibility at voxel centres.
                        let mut expected = [0.0_f32; 2];
                        for run in ray.runs() {
                            for (bit, weight) in weights.iter().enumerate() {
                                let from = run.start.max(bit as f32);
                                let to = run.end.min((bit + 1) as f32);
                                let part = run.visibility * (to - from).max(0.0);
                                expected[0] += part;
                                expected[1] += part * weight;
                            }
                        }
                        let sum = ray.weighted_sum(&table);
                        // Running sums in f32: an ULP of the total per run.
                        let rounding = 1e-7 * total * (2.0 + bits as f32);
                        assert!((sum - expected[1]).abs() <= rounding);
                        let count = ray.weighted_sum(&uniform);
                        assert!((count - expected[0]).abs() <= 1e-7 * (bits * bits) as f32);
                        let fraction = ray.lit_fraction();
                        assert!((0.0..=1.0).contains(&fraction));
                        if end > 0.0 {
                            assert!((fraction * end - expected[0]).abs() <= 1e-5 * end);
                        }
                        let mut lit = Vec::new();
                        ray.lit_intervals(&mut lit);
                        check_order(&lit, surface);
                        // The same length voxel by voxel, as many as it may have.
                        let voxels: Vec<_> = ray.lit_voxels().collect();
                        check_order(&voxels, surface);
                        assert!(voxels.len() <= bits + 1);
                        let length = |parts: &[LitInterval]| -> f32 {
                            parts.iter().map(|p| p.visibility * (p.end - p.start)).sum()
                        };
                        let (whole, pieces) = (length(&lit), length(&voxels));
                        assert!(
                            whole == pieces || (whole - pieces).abs() <= 1e-5 * whole,
                            "{whole} {pieces}"
                        );
                        // The shares of two halves make up that of the whole.
                        let all = ray.lit_fraction_between(0.0, surface);
                        assert!((all - fraction).abs() <= 1e-5, "{all} {fraction}");
                        let middle = ray.position(3.0);
                        let halves = middle * ray.lit_fraction_between(0.0, 3.0)
                            + (end - middle) * ray.lit_fraction_between(3.0, f32::MAX);
                        assert!((halves - all * end).abs() <= 1e-4 * end, "{halves}");
                        // In the middle of a run the visibility is that of
                        // the run, where distances tell voxels apart.
                        let space = lattice.space();
                        for run in ray.runs().filter(|_| !sampling.interpolate) {
                            let position = 0.5 * (run.start + run.end);
                            let phi = lattice.phi_at(position);
                            let distance = space.distance_along(&ray.ray(), phi);
                            let again = lattice.phi_position(space.phi_along(&ray.ray(), distance));
                            if (again - position).abs() < 0.2 * (run.end - run.start) {
                                assert_eq!(ray.visibility(distance), run.visibility);
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn no_part_of_any_ray_begins_at_infinity() {
    let mut endless = 0;
    for light in lights() {
        let lattice = lattice(light, &camera(0.0, 20.0), [16, 16, 64]);
        let grid = noise(&lattice, 7);
        for sampling in [Sampling::NEAREST, SMOOTH] {
            let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
            for direction in directions().into_iter().chain([Vec3::ZERO]) {
                // Behind the eye, to all sides, and none, which counts as the axis.
                for direction in [direction, -direction, direction.zxy(), -direction.zxy()] {
                    let ray = volume.ray_shadow(direction, f32::INFINITY);
                    for part in ray.lit_runs().chain(ray.lit_voxels()) {
                        assert!(part.start.is_finite() && part.start <= part.end);
                        endless += u32::from(part.end == f32::INFINITY);
                    }
                }
            }
        }
    }
    assert!(endless > 1000, "{endless}");
}

fn check_order(lit: &[LitInterval], surface: f32) {
    let mut last = 0.0;
    for interval in lit {
        assert!(last <= interval.start && interval.start <= interval.end);
        assert!(interval.end <= surface);
        assert!(interval.visibility > 0.0 && interval.visibility <= 1.0);
        last = interval.end;
    }
}

/// Mean error of the visibility along rays that end at a surface.
fn error_against_truth(light: Light, sun: Vec3, voxels: u32, sampling: Sampling) -> f64 {
    let balls = balls();
    let far = 20.0_f32;
    let lattice = lattice(light, &camera(0.0, far), [voxels, voxels, voxels]);
    let (_, grid) = build(&lattice, &balls);
    let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
    let (mut wrong, mut all) = (0.0, 0.0);
    for direction in directions() {
        let direction = direction.normalize();
        let eye_ray = epipolar::LightRay {
            origin: EYE.into(),
            direction: direction.into(),
        };
        let surface = common::first(&balls, false)(&eye_ray).min(far);
        let mut lit = Vec::new();
        volume
            .ray_shadow(direction, surface)
            .lit_intervals(&mut lit);
        check_order(&lit, surface);
        let steps = 400;
        for step in 0..steps {
            let distance = (step as f32 + 0.5) / steps as f32 * surface;
            let truth = is_lit(light, &balls, sun, EYE + distance * direction);
            let found = lit
                .iter()
                .find(|i| i.start <= distance && distance < i.end)
                .map_or(0.0, |i| i.visibility);
            // What the spotlight does not reach needs no answer.
            let point = EYE + distance * direction;
            let in_cone = light != common::spot()
                || (point - Vec3::new(0.0, 6.0, 0.0))
                    .normalize()
                    .dot(Vec3::NEG_Y)
                    > 0.6_f32.cos();
            if in_cone {
                wrong += f64::from((found - f32::from(u8::from(truth))).abs());
                all += 1.0;
            }
        }
    }
    wrong / all
}

/// The directional lights of [`lights`], in order.
fn suns() -> impl Iterator<Item = Vec3> {
    [
        Vec3::new(1.0, -0.6, 0.1),
        Vec3::new(0.05, -0.1, 1.0),
        Vec3::new(0.05, -0.1, -1.0),
    ]
    .into_iter()
    .map(Vec3::normalize)
}

#[test]
fn shadows_converge_to_the_truth_for_every_light() {
    let mut suns = suns();
    for light in lights() {
        let sun = match light.position() {
            None => suns.next().unwrap(),
            Some(_) => Vec3::ZERO,
        };
        for sampling in [Sampling::NEAREST, SMOOTH, Sampling::PAPER] {
            let coarse = error_against_truth(light, sun, 64, sampling);
            let fine = error_against_truth(light, sun, 512, sampling);
            println!("{light:?}: {coarse:.4} {fine:.4}");
            let beside = light
                .position()
                .is_some_and(|at| (Vec3::from(at) - EYE).length() < 0.1);
            if beside {
                // Shadows begin a few millimetres, seen from the light, behind
                // the blockers that hide them: no voxel resolves that, and
                // surfaces are dark or lit by halves.
                assert!(fine <= coarse && fine < 0.05, "{coarse} {fine}");
                continue;
            }
            // Only borders of shadows are wrong, by a few voxels. Eight times
            // as many voxels leave an eighth of it; a third allows for rays on which
            // several borders fall into one voxel, and for the axis.
            assert!(
                fine <= coarse / 3.0 || fine < 1e-3,
                "{light:?} {sampling:?}: {coarse} {fine}"
            );
            assert!(fine < 0.02, "{light:?} {sampling:?}: {fine}");
        }
    }
}

#[test]
fn towards_the_light_distances_decide() {
    let balls = balls();
    for (light, distance) in [
        (Light::point(Vec3::new(0.0, 1.7, -4.0)).unwrap(), 12.0),
        (Light::directional(Vec3::Z).unwrap(), f32::INFINITY),
    ] {
        let eye = Vec3::new(0.0, 1.7, 8.0);
        let space = Space::new(light, eye).unwrap();
        let resolution = epipolar::Resolution::new(64, 64, 64).unwrap();
        let view = ViewVolume::all_around(0.0, 30.0).unwrap();
        let lattice = Lattice::new(space, &view, resolution, Spacing::Angle).unwrap();
        let (_, grid) = build(&lattice, &balls);
        let volume = ShadowVolume::new(&lattice, &grid, Sampling::PAPER).unwrap();
        let intervals = |surface| {
            let mut lit = Vec::new();
            volume
                .ray_shadow(Vec3::NEG_Z, surface)
                .lit_intervals(&mut lit);
            lit
        };
        // The first surface in front of the light is between it and the eye.
        assert_eq!(intervals(5.0), []);
        assert_eq!(volume.ray_shadow(Vec3::NEG_Z, 5.0).lit_fraction(), 0.0);
        assert_eq!(volume.visibility(eye - 5.0 * Vec3::Z), 0.0);
        // Behind the light: nothing is.
        for surface in [15.0, f32::INFINITY] {
            if surface >= distance {
                let lit = intervals(surface);
                assert_eq!(lit.len(), 1);
                assert_eq!((lit[0].start, lit[0].end), (0.0, surface));
                assert_eq!(volume.ray_shadow(Vec3::NEG_Z, surface).lit_fraction(), 1.0);
            }
        }
        // f32::MAX is the sky as well.
        assert_eq!(volume.ray_shadow(Vec3::NEG_Z, f32::MAX).lit_fraction(), 1.0);
        // Away from the light all of the ray is as lit as the eye: not,
        // because of the ball in between.
        let away = volume.ray_shadow(Vec3::Z, 4.0);
        assert_eq!(away.lit_fraction(), 0.0);
        assert_eq!(away.runs().count(), 0);
        let (_, empty) = build(&lattice, &[]);
        let volume = ShadowVolume::new(&lattice, &empty, Sampling::PAPER).unwrap();
        let away = volume.ray_shadow(Vec3::Z, 4.0);
        assert_eq!(away.lit_fraction(), 1.0);
        let mut lit = Vec::new();
        away.lit_intervals(&mut lit);
        assert_eq!((lit.len(), lit[0].start, lit[0].end), (1, 0.0, 4.0));
    }
}

#[test]
fn a_bias_towards_the_light_only_ever_removes_shadow() {
    for light in lights() {
        let lattice = lattice(light, &camera(0.1, 20.0), [64, 64, 64]);
        let (_, grid) = build(&lattice, &balls());
        let biased_by = |alpha_bias| {
            let sampling = Sampling {
                alpha_bias,
                ..SMOOTH
            };
            ShadowVolume::new(&lattice, &grid, sampling).unwrap()
        };
        let (plain, biased) = (biased_by(0.0), biased_by(-2.25));
        for direction in directions() {
            let (a, b) = (
                plain.ray_shadow(direction, 9.0),
                biased.ray_shadow(direction, 9.0),
            );
            assert!(b.lit_fraction() >= a.lit_fraction() - 1e-6);
        }
    }
}

#[test]
fn numbers_that_cannot_be_are_turned_away() {
    let light = lights()[0];
    let lattice = lattice(light, &camera(0.1, 20.0), [8, 8, 32]);
    let (_, grid) = build(&lattice, &balls());
    for bad in [
        Sampling {
            alpha_bias: f32::NAN,
            ..SMOOTH
        },
        Sampling {
            phi_bias: -2000.0,
            ..SMOOTH
        },
        Sampling {
            axis: -1.0,
            ..SMOOTH
        },
    ] {
        let error = ShadowVolume::new(&lattice, &grid, bad).unwrap_err();
        assert!(matches!(error, Error::BadValue { .. }), "{error}");
    }
    let other = common::lattice(light, &camera(0.1, 20.0), [8, 8, 64]);
    assert!(matches!(
        ShadowVolume::new(&other, &grid, SMOOTH),
        Err(Error::Resolution { .. })
    ));
    for bad in [
        &[][..],
        &[1.0, -1.0],
        &[f32::NAN],
        &[f32::INFINITY],
        &[3e38, 3e38],
    ] {
        assert!(Weights::new(bad).is_err());
    }
    let volume = ShadowVolume::new(&lattice, &grid, SMOOTH).unwrap();
    let cpu = Cpu::new();
    let rays = vec![[0.0, 0.0, -1.0, 5.0]; 5];
    let mut short = vec![0.0; 4];
    assert!(cpu.lit_fraction(&volume, &rays, &mut short).is_err());
    assert!(cpu.visibility(&volume, &rays, &mut short).is_err());
    let weights = Weights::new(&[1.0; 16]).unwrap();
    let mut sums = vec![0.0; 5];
    assert!(
        cpu.weighted_sum(&volume, &weights, &rays, &mut sums)
            .is_err()
    );
    let mut intervals = vec![LitInterval::default(); 7];
    let mut counts = vec![0; 5];
    assert!(
        cpu.lit_intervals(&volume, &rays, &mut intervals, &mut counts)
            .is_err()
    );
}

#[test]
fn batches_are_their_rays_one_by_one() {
    let lattice = lattice(lights()[0], &camera(0.1, 20.0), [64, 64, 64]);
    let (_, grid) = build(&lattice, &balls());
    let rays: Vec<[f32; 4]> = directions()
        .iter()
        .flat_map(|d| [1.0, 5.0, 9.0, f32::MAX].map(|surface| d.extend(surface).to_array()))
        .collect();
    check_batches(&lattice, &grid, Sampling::PAPER, &rays);
}

#[test]
fn batches_along_the_axis_of_a_sun_are_their_rays_one_by_one() {
    let mut beyond = 0;
    for towards in [0.0, 1.0, -1.0] {
        let sun = Light::directional(Vec3::new(1.0, -0.6, towards)).unwrap();
        let lattice = lattice(sun, &camera(0.1, 20.0), [64, 64, 64]);
        let grid = noise(&lattice, 7);
        let [axis, ..] = lattice.space().frame().map(Vec3::from);
        let surfaces = [0.0, 5.0, f32::MAX, f32::INFINITY];
        let mut rays: Vec<[f32; 4]> = [axis, -axis, 3.0 * axis, Vec3::ZERO]
            .iter()
            .flat_map(|d| surfaces.map(|surface| d.extend(surface).to_array()))
            .collect();
        let volume = ShadowVolume::new(&lattice, &grid, Sampling::NEAREST).unwrap();
        beyond += rays
            .iter()
            .map(|ray| volume.ray_shadow(Vec3::from_slice(ray), ray[3]))
            .filter(|ray| ray.runs().count() > ray.lit_runs().count())
            .count();
        // Others, with more than two intervals.
        rays.extend(directions().iter().map(|d| d.extend(9.0).to_array()));
        check_batches(&lattice, &grid, Sampling::NEAREST, &rays);
    }
    assert!(beyond > 0, "runs at infinity, which are no intervals");
}

fn check_batches(lattice: &Lattice, grid: &Grid<Host>, sampling: Sampling, rays: &[[f32; 4]]) {
    let volume = ShadowVolume::new(lattice, grid, sampling).unwrap();
    let rays = rays.to_vec();
    let weights = Weights::new(&[0.5; 64]).unwrap();
    let mut previous = None;
    for cpu in [Cpu::new(), Cpu::single_threaded()] {
        let mut fractions = vec![0.0; rays.len()];
        cpu.lit_fraction(&volume, &rays, &mut fractions).unwrap();
        let mut sums = vec![0.0; rays.len()];
        cpu.weighted_sum(&volume, &weights, &rays, &mut sums)
            .unwrap();
        let mut seen = vec![0.0; rays.len()];
        cpu.visibility(&volume, &rays, &mut seen).unwrap();
        let places = 2;
        let mut intervals = vec![LitInterval::default(); places * rays.len()];
        let mut counts = vec![0; rays.len()];
        cpu.lit_intervals(&volume, &rays, &mut intervals, &mut counts)
            .unwrap();
        let mut without_places = vec![0; rays.len()];
        cpu.lit_intervals(&volume, &rays, &mut Vec::new(), &mut without_places)
            .unwrap();
        assert_eq!(without_places, counts);
        assert!(counts.iter().any(|count| *count > 2));
        for (i, ray) in rays.iter().enumerate() {
            let one = volume.ray_shadow(Vec3::new(ray[0], ray[1], ray[2]), ray[3]);
            assert_eq!(fractions[i], one.lit_fraction());
            assert_eq!(sums[i], one.weighted_sum(&weights));
            let mut lit = Vec::new();
            one.lit_intervals(&mut lit);
            assert_eq!(counts[i] as usize, lit.len());
            let kept = lit.len().min(places);
            assert_eq!(intervals[places * i..][..kept], lit[..kept]);
        }
        let all = (fractions, sums, seen, intervals);
        if let Some(previous) = previous.replace(all.clone()) {
            assert_eq!(previous, all, "threads must not matter");
        }
    }
    // No ray at all is legal.
    let cpu = Cpu::new();
    cpu.lit_intervals(&volume, &Vec::new(), &mut Vec::new(), &mut Vec::new())
        .unwrap();
}

proptest! {
    #![proptest_config(reference::property::cases(500))]
    #[test]
    fn visibility_lies_between_0_and_1_whatever_the_input(
        point: [f32; 3], surface: f32, seed: u32, which in 0..9_usize,
        alpha_bias in -100.0_f32..100.0, phi_bias in -100.0_f32..100.0, interpolate: bool,
    ) {
        let lattice = lattice(lights()[which], &camera(0.1, 20.0), [8, 8, 64]);
        let grid = noise(&lattice, seed);
        let sampling = Sampling { alpha_bias, phi_bias, axis: 0.5, interpolate };
        let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
        let point = Vec3::from_array(point);
        for seen in [
            volume.visibility(point),
            volume.ray_shadow(point, surface).lit_fraction(),
            volume.ray_shadow(point, 3.0).visibility(surface),
        ] {
            prop_assert!((0.0..=1.0).contains(&seen), "{seen}");
        }
        let mut lit = Vec::new();
        volume.ray_shadow(point, surface).lit_intervals(&mut lit);
        check_order(&lit, surface.max(0.0));
    }
}

/// Mean errors of the visibility of what the eye sees of the air, of the voxels
/// and of "everything is lit".
fn errors_next_to_the_eye(light: Light, sampling: Sampling) -> [f64; 2] {
    let balls = balls();
    let lattice = lattice(light, &camera(0.1, 20.0), [128, 128, 64]);
    let (_, grid) = build(&lattice, &balls);
    let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
    let at_eye = Light::point(EYE).unwrap();
    let (mut voxels, mut lit, mut count) = (0.0, 0.0, 0.0);
    for direction in directions() {
        for step in 0..40 {
            let point = EYE + 0.25 * (step as f32 + 0.5) * direction.normalize();
            if !is_lit(at_eye, &balls, Vec3::ZERO, point) {
                // Behind what the eye sees.
                break;
            }
            let truth = f64::from(u8::from(is_lit(light, &balls, Vec3::ZERO, point)));
            voxels += (f64::from(volume.visibility(point)) - truth).abs();
            lit += 1.0 - truth;
            count += 1.0;
        }
    }
    [voxels / count, lit / count]
}

#[test]
fn a_light_next_to_the_eye_is_answered_no_worse_than_by_light_everywhere() {
    // Voxels of 10 and 19 mrad: balls from 4 m on have no shadow of their width.
    for distance in [1e-6, 1e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02] {
        for along in [
            Vec3::X,
            Vec3::new(0.4, 0.8, -0.4),
            Vec3::new(0.0, 0.6, 0.8),
            Vec3::new(0.1, 0.1, -1.0),
        ] {
            let light = Light::point(EYE + distance * along).unwrap();
            for sampling in [Sampling::NEAREST, SMOOTH] {
                let [voxels, lit] = errors_next_to_the_eye(light, sampling);
                assert!(
                    voxels <= lit + 1e-3,
                    "{distance} m {along}: {voxels}, not {lit}"
                );
            }
        }
    }
}
