//! Optical depths against sums over hat functions, and what must not change them.

use glam::{Affine3A, DMat3, DVec3, Quat, Vec3};
use reference::random::Random;

use super::*;
use crate::{Bounds, Interpolation, PhaseFunction};

/// The density of a grid at a point, from its definition: hats around samples.
struct Hats<'a> {
    grid: &'a DensityGrid,
    to_local: (DMat3, DVec3),
}

impl<'a> Hats<'a> {
    fn new(grid: &'a DensityGrid) -> Self {
        let columns = [0, 1, 2].map(|axis| grid.transform().matrix3.col(axis).as_dvec3());
        let turn = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let shift = Vec3::from(grid.transform().translation).as_dvec3();
        Self {
            grid,
            to_local: (turn.inverse(), shift),
        }
    }

    /// A point in units of the box.
    fn share(&self, point: DVec3) -> DVec3 {
        let (inverse, shift) = self.to_local;
        let bounds = self.grid.local_bounds();
        let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
        (inverse * (point - shift) - min) / (max - min)
    }

    fn extinction(&self, point: DVec3) -> f64 {
        let share = self.share(point);
        let counts = self.grid.resolution();
        let mut sum = 0.0;
        for (index, &density) in self.grid.density().iter().enumerate() {
            let mut weight = f64::from(density);
            let mut rest = index;
            for axis in 0..3 {
                let count = counts[axis] as usize;
                let (at, of) = ((rest % count) as f64, count as f64);
                rest /= count;
                weight *= match self.grid.interpolation() {
                    Interpolation::Constant => {
                        let voxel = (share[axis] * of).floor().clamp(0.0, of - 1.0);
                        f64::from(u8::from(voxel == at))
                    }
                    Interpolation::Linear if count == 1 => 1.0,
                    Interpolation::Linear => (1.0 - (share[axis] * (of - 1.0) - at).abs()).max(0.0),
                };
            }
            sum += weight;
        }
        f64::from(self.grid.scale()) * sum
    }

    /// The integral between all planes of samples, by three nodes each.
    fn depth(&self, origin: DVec3, direction: DVec3, from: f64, to: f64) -> f64 {
        let start = self.share(origin);
        let step = self.share(origin + direction) - start;
        let mut cuts = vec![from, to];
        for axis in 0..3 {
            let planes =
                4 * self.grid.resolution()[axis] * (self.grid.resolution()[axis] - 1).max(1);
            for plane in 0..=planes {
                let t = (f64::from(plane) / f64::from(planes) - start[axis]) / step[axis];
                if from < t && t < to {
                    cuts.push(t);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        let parts = cuts.windows(2).map(|ends| {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            let place = self.share(origin + middle * direction);
            let slack = 1e-12;
            if place.min_element() < -slack || place.max_element() > 1.0 + slack {
                return 0.0;
            }
            let node = half * 0.6_f64.sqrt();
            let at = |t: f64| self.extinction(origin + t * direction);
            half * (5.0 * (at(middle - node) + at(middle + node)) + 8.0 * at(middle)) / 9.0
        });
        parts.sum()
    }
}

fn number(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit_f64()
}

fn vector(random: &mut Random, low: f64, high: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| number(random, low, high)))
}

fn any_grid(random: &mut Random, interpolation: Interpolation) -> DensityGrid {
    let resolution = [(); 3].map(|()| 1 + random.below(5));
    let count = resolution.iter().product::<u32>();
    let density = (0..count).map(|_| match random.below(3) {
        0 => 0.0,
        _ => random.unit(),
    });
    let density = density.collect();
    let min = vector(random, -3.0, 1.0).as_vec3();
    let bounds = Bounds::new(min, min + vector(random, 0.5, 4.0).as_vec3()).unwrap();
    // Optical depths of 1e-6 to 1e6 per voxel.
    let scale = 10.0_f64.powf(number(random, -6.0, 6.0)) as f32;
    DensityGrid::new(bounds, resolution, density, scale, interpolation).unwrap()
}

fn any_transform(random: &mut Random) -> Affine3A {
    let axis = vector(random, -1.0, 1.0).as_vec3().normalize_or(Vec3::Y);
    let turn = Quat::from_axis_angle(axis, number(random, 0.0, 6.0) as f32);
    let scale = vector(random, 0.3, 3.0).as_vec3();
    let shift = vector(random, -5.0, 5.0).as_vec3();
    Affine3A::from_scale_rotation_translation(scale, turn, shift)
}

fn alone(grid: DensityGrid) -> [Translucent; 1] {
    [grid.into()]
}

fn depth_of(casters: &[Translucent], line: (DVec3, DVec3), from: f64, to: f64) -> DVec3 {
    Media::new(None, None, casters).optical_depth(line.0, line.1, from, to)
}

fn assert_near(found: f64, expected: f64, relative: f64, what: &str) {
    let error = (found - expected).abs();
    assert!(
        error <= relative * expected.abs() + 1e-300,
        "{what}: {found} instead of {expected}"
    );
}

#[test]
fn depths_through_grids_are_the_integral_of_their_definition() {
    let mut random = Random::new(1);
    for round in 0..600 {
        let interpolation = [Interpolation::Constant, Interpolation::Linear][round % 2];
        let mut grid = any_grid(&mut random, interpolation);
        if round % 3 == 0 {
            grid = grid.with_transform(any_transform(&mut random)).unwrap();
        }
        let hats = Hats::new(&grid);
        let bounds = grid.bounds();
        let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
        // From inside of the box, next to it and from afar, towards a point in it.
        let target = min + (max - min) * vector(&mut random, 0.0, 1.0);
        let reach = [0.3, 1.5, 1e3][random.below(3) as usize];
        let origin = target + reach * vector(&mut random, -1.0, 1.0);
        let direction = (target - origin).normalize();
        let to = [1.0, 5.0, 1e4][random.below(3) as usize];
        let expected = hats.depth(origin, direction, 0.0, to);
        let found = depth_of(&alone(grid.clone()), (origin, direction), 0.0, to);
        // Seen from 1e3 m, planes are hit to 1e-13 m across them, which along a line
        // beside one may be 1e4 times as much.
        let allowed = if reach > 100.0 { 1e-7 } else { 1e-9 };
        assert_near(found.x, expected, allowed, &format!("round {round}"));
        assert_eq!(found.x, found.y);
    }
}

#[test]
fn rays_along_faces_edges_and_through_corners_are_no_exception() {
    let density = (0..27)
        .map(|i| 1.0 + (i * 7 % 11) as f32)
        .collect::<Vec<_>>();
    let bounds = Bounds::new(Vec3::ZERO, Vec3::splat(2.0)).unwrap();
    let grid = DensityGrid::new(bounds, [3, 3, 3], density, 1.0, Interpolation::Linear).unwrap();
    let hats = Hats::new(&grid);
    let casters = alone(grid.clone());
    let diagonal = DVec3::ONE.normalize();
    for (origin, direction) in [
        (DVec3::new(-1.0, 1.0, 0.3), DVec3::X), // in a face between cells
        (DVec3::new(3.0, 1.0, 1.0), DVec3::NEG_X), // along an edge
        (DVec3::new(0.0, 0.0, -1.0), DVec3::Z), // along an edge of the box
        (DVec3::new(0.5, 2.0, -1.0), DVec3::Z), // in the upper face
        (DVec3::splat(-1.0), diagonal),         // through all corners
        (DVec3::splat(3.0), -diagonal),
        (DVec3::new(1.0, 1.0, 1.0), DVec3::NEG_Y), // from a corner
    ] {
        let expected = hats.depth(origin, direction, 0.0, 9.0);
        let found = depth_of(&casters, (origin, direction), 0.0, 9.0).x;
        assert!(expected > 1.0);
        assert_near(found, expected, 1e-12, &format!("{origin} {direction}"));
        // Outside, along the box, there is nothing.
        let aside = origin + 2.5 * direction.any_orthonormal_vector();
        let aside = aside + 4.0 * DVec3::splat(aside.max_element());
        assert_eq!(depth_of(&casters, (aside, direction), 0.0, 0.5).x, 0.0);
    }
}

#[test]
fn single_voxels_and_flat_grids_are_boxes() {
    let bounds = Bounds::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0)).unwrap();
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for scale in [0.0, 1e-6, 1.0, 1e6] {
            let grid = DensityGrid::new(bounds, [1; 3], vec![0.5], scale, interpolation).unwrap();
            let found = depth_of(
                &alone(grid),
                (DVec3::new(0.5, 1.0, -3.0), DVec3::Z),
                0.0,
                99.0,
            );
            assert_near(found.x, 2.0 * f64::from(scale), 1e-15, "a voxel");
        }
    }
    let density = vec![1.0, 3.0];
    let grid = DensityGrid::new(bounds, [1, 2, 1], density, 1.0, Interpolation::Linear).unwrap();
    let casters = alone(grid);
    let along = |origin, direction| depth_of(&casters, (origin, direction), 0.0, 9.0).x;
    assert_near(
        along(DVec3::new(0.5, -1.0, 1.0), DVec3::Y),
        4.0,
        1e-15,
        "across",
    );
    assert_near(
        along(DVec3::new(-1.0, 1.5, 1.0), DVec3::X),
        2.5,
        1e-15,
        "beside",
    );
}

#[test]
fn a_constant_grid_is_a_homogeneous_medium_in_a_box() {
    let bounds = Bounds::new(Vec3::new(-1.0, 0.0, 2.0), Vec3::new(2.0, 1.5, 3.0)).unwrap();
    let sigma_s = Vec3::new(0.5, 0.1, 0.0);
    let sigma_a = Vec3::new(0.5, 0.4, 0.25);
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.4 };
    let medium = Medium::new(sigma_s, sigma_a, phase).unwrap().within(bounds);
    let grid = |interpolation| {
        let tint = sigma_s + sigma_a;
        DensityGrid::new(bounds, [3, 4, 5], vec![2.0; 60], 0.5, interpolation)
            .unwrap()
            .with_tint(tint)
            .unwrap()
            .with_albedo(sigma_s / tint)
            .unwrap()
            .with_phase(phase)
            .unwrap()
    };
    let mut random = Random::new(2);
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        let casters = alone(grid(interpolation));
        let (as_grid, as_medium) = (
            Media::new(None, None, &casters),
            Media::new(Some(&medium), None, &[]),
        );
        for _ in 0..200 {
            let origin = vector(&mut random, -3.0, 4.0);
            let target = vector(&mut random, 0.0, 1.0) * DVec3::new(3.0, 1.5, 1.0);
            let direction = (target + bounds.min().as_dvec3() - origin).normalize();
            let to = number(&mut random, 0.0, 12.0);
            let one = as_grid.optical_depth(origin, direction, 0.0, to);
            let other = as_medium.optical_depth(origin, direction, 0.0, to);
            assert!((one - other).abs().max_element() < 1e-6 * other.max_element().max(1e-6));
            let point = origin + 0.5 * to * direction;
            let (mut here, mut there) = (Vec::new(), Vec::new());
            as_grid.scattering_at(point, |medium| here.push(medium));
            as_medium.scattering_at(point, |medium| there.push(medium));
            assert_eq!(here.len(), there.len());
            for (here, there) in here.iter().zip(&there) {
                assert!(here.extinction.abs_diff_eq(there.extinction, 1e-6));
                assert!(here.scattering.abs_diff_eq(there.scattering, 1e-6));
                assert_eq!(here.phase, there.phase);
            }
        }
    }
}

#[test]
fn finer_grids_of_the_same_density_change_nothing() {
    let mut random = Random::new(3);
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for _ in 0..40 {
            let coarse = any_grid(&mut random, interpolation);
            let counts = coarse.resolution();
            let finer = counts.map(|count| match interpolation {
                Interpolation::Constant => 2 * count,
                Interpolation::Linear => 2 * count - 1,
            });
            let mut density = Vec::new();
            for index in 0..finer.iter().product::<u32>() {
                let at = [
                    index % finer[0],
                    index / finer[0] % finer[1],
                    index / finer[0] / finer[1],
                ];
                // In f64 the means of two, four and eight samples are exact enough.
                let [x, y, z] = [0, 1, 2].map(|axis| match interpolation {
                    Interpolation::Constant => vec![at[axis] / 2],
                    Interpolation::Linear => vec![at[axis] / 2, at[axis].div_ceil(2)],
                });
                let (mut sum, mut count) = (0.0, 0.0);
                for z in &z {
                    for y in &y {
                        for x in &x {
                            let sample = (z * counts[1] + y) * counts[0] + x;
                            sum += f64::from(coarse.density()[sample as usize]);
                            count += 1.0;
                        }
                    }
                }
                density.push((sum / count) as f32);
            }
            let bounds = coarse.local_bounds();
            let fine =
                DensityGrid::new(bounds, finer, density, coarse.scale(), interpolation).unwrap();
            let line = (vector(&mut random, -5.0, 5.0), DVec3::new(0.6, -0.48, 0.64));
            let found = depth_of(&alone(fine), line, 0.0, 20.0).x;
            let expected = depth_of(&alone(coarse), line, 0.0, 20.0).x;
            assert_near(found, expected, 2e-7, "the samples are rounded to f32");
        }
    }
}

/// Fog, height fog, two grids of which one is rotated and coloured, particles.
fn everything() -> (Medium, HeightFog, Vec<Translucent>) {
    let mut random = Random::new(4);
    let medium = Medium::new(
        Vec3::splat(0.02),
        Vec3::splat(0.01),
        PhaseFunction::Isotropic,
    )
    .unwrap()
    .within(Bounds::new(Vec3::splat(-4.0), Vec3::splat(5.0)).unwrap());
    let fog = HeightFog::new(
        Vec3::new(0.03, 0.02, 0.01),
        Vec3::ZERO,
        0.0,
        2.0,
        PhaseFunction::Rayleigh,
    )
    .unwrap();
    let first = any_grid(&mut random, Interpolation::Constant)
        .with_scale(0.7)
        .unwrap();
    let bounds = Bounds::new(Vec3::NEG_ONE, Vec3::ONE).unwrap();
    let density = (0..60).map(|i| (i % 7) as f32).collect::<Vec<_>>();
    let second = DensityGrid::new(bounds, [3, 4, 5], density, 0.2, Interpolation::Linear)
        .unwrap()
        .with_transform(any_transform(&mut random))
        .unwrap()
        .with_tint(Vec3::new(1.0, 0.5, 0.25))
        .unwrap()
        .with_albedo_samples((0..60).map(|i| Vec3::splat(i as f32 / 60.0)).collect())
        .unwrap()
        .with_emission((0..60).map(|i| Vec3::new(0.0, i as f32, 1.0)).collect())
        .unwrap();
    let ball = |x: f32, radius: f32, sigma_t: f32| Particle {
        centre: Vec3::new(x, 0.2 * x, 0.3),
        radius,
        sigma_t,
    };
    let balls = vec![
        ball(-1.0, 1.5, 0.4),
        ball(0.2, 0.8, 2.0),
        ball(1.0, 0.0, 9.0),
    ];
    let soft = Particles::new(balls.clone(), Profile::Soft).unwrap();
    let hard = Particles::new(balls, Profile::Constant).unwrap();
    let hard = hard.with_albedo(Vec3::splat(0.5)).unwrap();
    let all = vec![first.into(), second.into(), soft.into(), hard.into()];
    (medium, fog, all)
}

fn any_line(random: &mut Random) -> (DVec3, DVec3) {
    let origin = vector(random, -6.0, 6.0);
    let target = vector(random, -1.5, 1.5);
    (origin, (target - origin).normalize())
}

#[test]
fn media_that_overlap_add_up_and_parts_of_a_line_do() {
    let (medium, fog, casters) = everything();
    let all = Media::new(Some(&medium), Some(&fog), &casters);
    let mut random = Random::new(5);
    for _ in 0..300 {
        let (origin, direction) = any_line(&mut random);
        let to = number(&mut random, 1.0, 20.0);
        let whole = all.optical_depth(origin, direction, 0.0, to);
        let each = casters
            .iter()
            .map(|caster| depth_of(std::slice::from_ref(caster), (origin, direction), 0.0, to));
        let sum: DVec3 = each.sum::<DVec3>()
            + Media::new(Some(&medium), None, &[]).optical_depth(origin, direction, 0.0, to)
            + Media::new(None, Some(&fog), &[]).optical_depth(origin, direction, 0.0, to);
        assert!(
            whole.abs_diff_eq(sum, 1e-12 * sum.max_element()),
            "{whole} {sum}"
        );
        let cut = number(&mut random, 0.0, to);
        let parts = all.optical_depth(origin, direction, 0.0, cut)
            + all.optical_depth(origin, direction, cut, to);
        assert!(whole.abs_diff_eq(parts, 1e-12 * whole.max_element()));
        let back = all.optical_depth(origin + to * direction, -direction, 0.0, to);
        assert!(whole.abs_diff_eq(back, 1e-10 * whole.max_element()));
    }
}

#[test]
fn pieces_tell_what_is_at_their_points() {
    let (medium, fog, casters) = everything();
    let all = Media::new(Some(&medium), Some(&fog), &casters);
    let mut random = Random::new(6);
    for _ in 0..100 {
        let (origin, direction) = any_line(&mut random);
        let mut pieces = all.along(origin, direction, 0.5, 18.0);
        let (mut end, mut sum) = (0.5, DVec3::ZERO);
        while let Some(piece) = pieces.advance() {
            assert!(piece.start() == end && piece.end() > end);
            assert!(piece.depth_before().abs_diff_eq(sum, 1e-12));
            end = piece.end();
            if end - piece.start() > 1e-6 {
                let t = number(&mut random, piece.start(), end);
                let point = origin + t * direction;
                let mut expected = Vec::new();
                all.scattering_at(point, |medium| {
                    if medium.extinction != DVec3::ZERO || medium.emission != DVec3::ZERO {
                        expected.push(medium);
                    }
                });
                let found = piece.parts().iter().map(|part| piece.scattering(part, t));
                let found: Vec<_> = found
                    .filter(|it| it.extinction != DVec3::ZERO || it.emission != DVec3::ZERO)
                    .collect();
                let of = |list: &[Scattering], f: fn(&Scattering) -> DVec3| {
                    list.iter().map(f).sum::<DVec3>()
                };
                for f in [
                    |it: &Scattering| it.extinction,
                    |it: &Scattering| it.scattering,
                    |it: &Scattering| it.emission,
                ] {
                    let (found, expected) = (of(&found, f), of(&expected, f));
                    let slack = 1e-9 * (1.0 + expected.max_element());
                    assert!(found.abs_diff_eq(expected, slack), "{found} {expected}");
                }
                // The depth grows by the extinction, here by the trapezoidal rule.
                let (a, b) = (t, t + 1e-7 * (end - t));
                let growth = piece.depth_to(b) - piece.depth_to(a);
                let slope = 0.5 * (piece.extinction(a) + piece.extinction(b)) * (b - a);
                assert!(growth.abs_diff_eq(slope, 1e-14 + 1e-6 * slope.max_element()));
            }
            sum = piece.depth_to(end);
        }
        assert_eq!(end, 18.0);
        let whole = all.optical_depth(origin, direction, 0.5, 18.0);
        assert!(whole.abs_diff_eq(sum, 1e-12 * whole.max_element()));
    }
}

#[test]
fn what_is_empty_changes_nothing() {
    let (medium, fog, mut casters) = everything();
    let mut random = Random::new(7);
    let lines: Vec<_> = (0..50).map(|_| any_line(&mut random)).collect();
    let depths = |casters: &[Translucent]| -> Vec<DVec3> {
        let all = Media::new(Some(&medium), Some(&fog), casters);
        let of = |line: &(DVec3, DVec3)| all.optical_depth(line.0, line.1, 0.0, 15.0);
        lines.iter().map(of).collect()
    };
    let before = depths(&casters);
    let bounds = Bounds::new(Vec3::splat(-3.0), Vec3::splat(3.0)).unwrap();
    let empty =
        DensityGrid::new(bounds, [7; 3], vec![0.0; 343], 5.0, Interpolation::Linear).unwrap();
    casters.insert(0, empty.into());
    casters.push(Particles::new(Vec::new(), Profile::Soft).unwrap().into());
    for (before, after) in before.into_iter().zip(depths(&casters)) {
        assert!(after.abs_diff_eq(before, 1e-13 * before.max_element()));
    }
}

#[test]
fn endless_rays_end_in_what_is_endless() {
    let (origin, up) = (DVec3::new(0.0, 1.0, 0.0), DVec3::Y);
    let medium = Medium::new(Vec3::X, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let even = Media::new(Some(&medium), None, &[]);
    let expected = DVec3::new(f64::INFINITY, 0.0, 0.0);
    assert_eq!(even.optical_depth(origin, up, 0.0, f64::INFINITY), expected);
    let (_, fog, casters) = everything();
    let thin = Media::new(None, Some(&fog), &[]);
    let found = thin.optical_depth(origin, up, 0.0, f64::INFINITY);
    let expected = fog.sigma_t().as_dvec3() * 2.0 * (-0.5_f64).exp();
    assert!(found.abs_diff_eq(expected, 1e-15));
    let smoke = Media::new(None, None, &casters);
    assert!(
        smoke
            .optical_depth(origin, up, 0.0, f64::INFINITY)
            .is_finite()
    );
    let all = Media::new(Some(&medium), Some(&fog), &casters);
    for (from, to) in [(1.0, 1.0), (2.0, 1.0), (0.0, f64::NAN)] {
        assert_eq!(all.optical_depth(origin, up, from, to), DVec3::ZERO);
    }
}

#[test]
fn bad_media_name_their_cause() {
    let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap();
    let grid = || DensityGrid::new(bounds, [1; 3], vec![1.0], 1.0, Interpolation::Linear).unwrap();
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let particles = || Particles::new(Vec::new(), Profile::Soft).unwrap();
    let bad_phase = PhaseFunction::Schlick { k: 2.0 };
    for (result, cause) in [
        (grid().with_transform(flat), "flatten"),
        (
            grid().with_transform(Affine3A::from_translation(Vec3::NAN)),
            "transform",
        ),
        (
            grid().with_transform(Affine3A::from_translation(Vec3::splat(2e9))),
            "1e9 m",
        ),
        (grid().with_tint(Vec3::NEG_ONE), "tint"),
        (grid().with_albedo(Vec3::splat(1.5)), "albedo is [1.5"),
        (grid().with_albedo_samples(vec![Vec3::ONE; 2]), "2 entries"),
        (
            grid().with_albedo_samples(vec![Vec3::NAN]),
            "sample 0: albedo",
        ),
        (
            grid().with_emission(vec![Vec3::NEG_X]),
            "sample 0: emission",
        ),
        (grid().with_phase(bad_phase), "k of the Schlick"),
    ] {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
    assert!(particles().with_albedo(Vec3::NAN).is_err());
    assert!(particles().with_phase(bad_phase).is_err());
}
