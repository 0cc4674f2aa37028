//! What maps must say of casters whose shadows are known.

use glam::{Affine3A, DVec3, Quat, Vec3};
use gpu_backend::{Cpu, Host};
use transmittance::baseline::{Captured, Uncompressed};
use transmittance::{BlockerSegment, Evaluate, Filter, Source, Stream, Tile};

use super::{Casters, TransmittanceMap};
use crate::Emitter;
use crate::scene::{
    Bounds, DensityGrid, Emission, Geometry, Interpolation, Media, Mesh, Particle, Particles,
    Profile, Scene, StrandPoint, Strands, Translucent,
};

type Exact = TransmittanceMap<Host, Uncompressed>;

fn sun(direction: Vec3) -> Emitter {
    Emitter::directional(direction, Vec3::ONE).unwrap()
}

fn lamp(position: Vec3) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
}

fn exact(casters: &Casters<'_>, emitter: &Emitter, resolution: u32) -> Exact {
    let cpu = Cpu::new();
    TransmittanceMap::build(&cpu, casters, emitter, resolution, &Captured::new()).unwrap()
}

fn strand(points: &[Vec3], thickness: f32, opacity: f32) -> Translucent {
    let point = |&position: &Vec3| StrandPoint {
        position,
        thickness,
        opacity,
    };
    let ends = vec![points.len() as u32];
    Strands::new(points.iter().map(point).collect(), ends)
        .unwrap()
        .into()
}

fn puffs(profile: Profile) -> Translucent {
    let puff = |x: f32, radius: f32, sigma_t: f32| Particle {
        centre: Vec3::new(x, 1.0, 0.1),
        radius,
        sigma_t,
    };
    let all = vec![puff(-0.4, 0.5, 2.0), puff(0.3, 0.7, 1.0)];
    Particles::new(all, profile).unwrap().into()
}

/// A grid that is linear in x, y and z, which trilinear interpolation meets.
fn slope() -> Translucent {
    let bounds = Bounds::new(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 1.5, 1.0)).unwrap();
    let mut density = Vec::new();
    for z in 0..3 {
        for y in 0..4 {
            for x in 0..5 {
                density.push(x as f32 + 2.0 * y as f32 + 0.5 * z as f32);
            }
        }
    }
    DensityGrid::new(bounds, [5, 4, 3], density, 0.2, Interpolation::Linear)
        .unwrap()
        .into()
}

#[test]
fn a_rotated_and_tinted_grid_takes_from_each_colour_what_rays_through_it_tell() {
    let Translucent::Grid(grid) = slope() else {
        panic!("a grid");
    };
    let turn = Affine3A::from_rotation_translation(Quat::from_rotation_z(0.4), Vec3::Y);
    let tint = Vec3::new(1.0, 0.5, 0.0);
    let grid = grid.with_transform(turn).unwrap().with_tint(tint).unwrap();
    let casters = [grid.into()];
    let blockers = Casters::new(&casters, None);
    assert_eq!(blockers.channels(), 3);
    let map = exact(&blockers, &sun(Vec3::NEG_Y), 256);
    let media = Media::new(None, None, &casters);
    for (x, z) in [(-0.5, 0.1), (0.0, 0.0), (0.4, -0.6)] {
        for y in [-1.0_f32, 1.2, 1.7, 4.0] {
            let point = Vec3::new(x, y, z);
            let depth = media.optical_depth(point.as_dvec3(), DVec3::Y, 0.0, 9.0);
            let expected = (-depth).exp().as_vec3();
            // Between the texels, over which it changes by some hundredths.
            let off = (map.transmittance(point) - expected).abs().max_element();
            assert!(off < 0.02, "{point}: {off}");
            assert_eq!(map.transmittance(point).z, 1.0);
        }
    }
}

#[test]
fn the_light_that_a_strand_takes_is_its_area_times_its_opacity() {
    let points = [
        Vec3::new(-1.0, 0.2, -0.5),
        Vec3::new(0.3, 0.9, 0.4),
        Vec3::new(1.1, 0.1, 0.8),
    ];
    for (thickness, opacity) in [(0.002, 0.7), (0.04, 0.3), (0.3, 1.0)] {
        // One piece at a time: pieces overlap where they meet.
        for piece in points.windows(2) {
            let hair = [strand(piece, thickness, opacity)];
            let casters = Casters::new(&hair, None);
            for resolution in [3, 32, 200] {
                let direction = Vec3::new(0.3, -1.0, 0.2).normalize();
                let map = exact(&casters, &sun(direction), resolution);
                let curves = &map.curves()[0];
                let taken = curves
                    .texels()
                    .iter()
                    .map(|curve| 1.0 - f64::from(curve.evaluate(f32::MAX)[0]));
                let crate::scene::raster::Rays::Parallel {
                    half_width,
                    half_height,
                } = map.faces()[0].rays
                else {
                    panic!("a sun has parallel rays");
                };
                let texel = 4.0 * f64::from(half_width) * f64::from(half_height)
                    / f64::from(resolution * resolution);
                let across = (piece[1] - piece[0]).reject_from(direction).length();
                let expected = f64::from(opacity * thickness * across);
                let taken = texel * taken.sum::<f64>();
                assert!(
                    (taken / expected - 1.0).abs() < 1e-3,
                    "{taken} of {expected} at {resolution}"
                );
            }
        }
    }
}

#[test]
fn behind_a_strand_a_lamp_is_dimmed_and_before_it_not() {
    let hair = [strand(
        &[Vec3::new(-1.0, 0.0, 0.1), Vec3::new(1.0, 0.0, 0.1)],
        0.2,
        0.6,
    )];
    let map = exact(
        &Casters::new(&hair, None),
        &lamp(Vec3::new(0.0, 2.0, 0.1)),
        512,
    );
    let map = map.with_filter(Filter::Nearest);
    for (point, passed) in [
        (Vec3::new(0.3, -0.5, 0.1), 0.4),
        (Vec3::new(0.3, 0.5, 0.1), 1.0),
        // The edge of the shadow is where the rays graze the cylinder.
        (Vec3::new(0.1, -2.0, 0.1 + 0.19), 0.4),
        (Vec3::new(0.1, -2.0, 0.1 + 0.21), 1.0),
        // Beyond the end of it, and behind the lamp.
        (Vec3::new(2.2, -2.0, 0.1), 1.0),
        (Vec3::new(0.0, 3.0, 0.1), 1.0),
    ] {
        let found = map.transmittance(point).x;
        assert!((found - passed).abs() < 0.02, "{point}: {found}");
    }
}

/// −ln T between two points by many midpoints.
fn optical_depth(from: Vec3, to: Vec3, sigma_t: impl Fn(Vec3) -> f64) -> f64 {
    const STEPS: u32 = 20_000;
    let length = f64::from(from.distance(to));
    let at = |i: u32| from.lerp(to, (i as f32 + 0.5) / STEPS as f32);
    length / f64::from(STEPS) * (0..STEPS).map(|i| sigma_t(at(i))).sum::<f64>()
}

fn sigma_t(caster: &Translucent, point: Vec3) -> f64 {
    match caster {
        Translucent::Grid(grid) => grid.extinction_at(point).into(),
        Translucent::Particles(particles) => {
            let of = |puff: &Particle| {
                let share = f64::from(point.distance(puff.centre) / puff.radius);
                let sigma_t = f64::from(puff.sigma_t);
                match particles.profile() {
                    _ if share > 1.0 => 0.0,
                    Profile::Constant => sigma_t,
                    Profile::Soft => sigma_t * (1.0 - share * share),
                }
            };
            particles.all().iter().map(of).sum()
        }
        Translucent::Strands(_) => unreachable!("strands have no extinction"),
    }
}

#[test]
fn smoke_takes_what_beer_and_lambert_say() {
    let voxels = match slope() {
        Translucent::Grid(grid) => DensityGrid::new(
            grid.bounds(),
            grid.resolution(),
            grid.density().to_vec(),
            grid.scale(),
            Interpolation::Constant,
        ),
        _ => unreachable!(),
    };
    for caster in [
        puffs(Profile::Constant),
        puffs(Profile::Soft),
        slope(),
        voxels.unwrap().into(),
    ] {
        let casters = std::slice::from_ref(&caster);
        for emitter in [
            sun(Vec3::new(0.2, -1.0, 0.1)),
            lamp(Vec3::new(0.2, 3.0, 0.5)),
        ] {
            // Rays of the middles of texels are met exactly, to within the
            // constant extinction of a segment: probe behind everything.
            let map = exact(&Casters::new(casters, None), &emitter, 64);
            let view = super::view::View::new(&map.faces()[0], 64);
            for (x, y) in [(20, 30), (32, 32), (40, 25), (5, 60)] {
                let (start, direction) = view.world_ray(x, y);
                let (start, direction) = (start.as_vec3(), direction.as_vec3());
                let back = start - 10.0 * direction;
                let from = match emitter {
                    Emitter::Point(_) => start,
                    Emitter::Directional(_) => back,
                };
                let to = start + 9.0 * direction;
                let truth = (-optical_depth(from, to, |p| sigma_t(&caster, p))).exp();
                let curve = &map.curves()[0].texels()[(64 * y + x) as usize];
                let found = f64::from(curve.evaluate(f32::MAX)[0]);
                assert!((found - truth).abs() < 1e-3, "{found} {truth}");
            }
        }
    }
}

#[test]
fn in_the_middle_of_smoke_the_light_is_what_came_through_half_of_it() {
    for profile in [Profile::Constant, Profile::Soft] {
        let puff = Particle {
            centre: Vec3::ZERO,
            radius: 1.0,
            sigma_t: 1.5,
        };
        let puffs = [Particles::new(vec![puff], profile).unwrap().into()];
        let map = exact(&Casters::new(&puffs, None), &sun(Vec3::NEG_Z), 128);
        let whole = match profile {
            Profile::Constant => 1.5 * 2.0,
            Profile::Soft => 1.5 * 4.0 / 3.0,
        };
        let inside = map.transmittance(Vec3::ZERO).x;
        assert!(
            (inside - (-0.5 * whole as f32).exp()).abs() < 2e-3,
            "{inside}"
        );
        let behind = map.transmittance(-2.0 * Vec3::Z).x;
        assert!((behind - (-whole as f32).exp()).abs() < 2e-3, "{behind}");
    }
}

#[test]
fn triangles_are_opaque_in_the_same_map() {
    let plate = Scene::from(Mesh {
        positions: vec![
            Vec3::new(-1.0, 0.5, -1.0),
            Vec3::new(3.0, 0.5, -1.0),
            Vec3::new(-1.0, 0.5, 3.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    let geometry = Geometry::new(&plate).unwrap();
    let puffs = [puffs(Profile::Constant)];
    let map = exact(
        &Casters::new(&puffs, Some(&geometry)),
        &sun(Vec3::NEG_Y),
        256,
    );
    assert_eq!(map.transmittance(Vec3::new(-0.4, 0.2, 0.1)).x, 0.0);
    assert!(map.transmittance(Vec3::new(-0.4, 0.7, 0.1)).x > 0.0);
    assert_eq!(map.transmittance(Vec3::new(2.5, 0.2, 2.5)).x, 1.0);
    let nothing = exact(&Casters::new(&[], None), &sun(Vec3::NEG_Y), 16);
    assert_eq!(nothing.transmittance(Vec3::ZERO).x, 1.0);
}

#[test]
fn adaptive_curves_stay_within_their_bounds_of_the_exact_map() {
    let all = [
        puffs(Profile::Soft),
        slope(),
        strand(&[Vec3::ZERO, Vec3::ONE], 0.05, 0.8),
    ];
    let casters = Casters::new(&all, None);
    for emitter in [
        sun(Vec3::new(0.5, -1.0, 0.1)),
        lamp(Vec3::new(0.0, 0.7, 0.0)),
    ] {
        let truth = exact(&casters, &emitter, 48);
        let map = TransmittanceMap::<Host, transmittance::Curve<8>>::build(
            &Cpu::with_threads(3).unwrap(),
            &casters,
            &emitter,
            48,
            &Stream::<8>::new(),
        )
        .unwrap();
        assert_eq!(map.faces(), truth.faces());
        let texels = map.curves().iter().flat_map(|face| face.texels());
        let truths = truth.curves().iter().flat_map(|face| face.texels());
        for (curve, truth) in texels.zip(truths) {
            for step in 0..50 {
                let depth = 0.07 * step as f32;
                let error = (curve.transmittance(depth) - truth.transmittance(depth)).abs();
                assert!(error <= curve.error_bound(depth) + 1e-6, "{depth} {error}");
            }
        }
    }
}

#[test]
fn threads_and_the_division_into_tiles_change_nothing() {
    let all = [
        puffs(Profile::Soft),
        slope(),
        strand(&[Vec3::ZERO, Vec3::ONE], 0.05, 0.8),
    ];
    let casters = Casters::new(&all, None);
    let emitter = lamp(Vec3::new(0.1, 6.0, 0.0));
    let with = |cpu: Cpu| {
        TransmittanceMap::<Host, transmittance::Curve<4>>::build(
            &cpu,
            &casters,
            &emitter,
            70,
            &Stream::<4>::new(),
        )
        .unwrap()
    };
    assert_eq!(
        with(Cpu::single_threaded()),
        with(Cpu::with_threads(3).unwrap())
    );
    let cpu = Cpu::new();
    let (_, blockers) = casters.faces(&cpu, &emitter, 70).unwrap().next().unwrap();
    let whole = Tile { x: 0..70, y: 0..70 };
    let mut at_once = Vec::new();
    blockers.segments(&whole, &mut |texel, segment| at_once.push((texel, segment)));
    for tile in [
        Tile {
            x: 23..39,
            y: 20..41,
        },
        Tile {
            x: 32..48,
            y: 32..48,
        },
    ] {
        let mut part = Vec::new();
        blockers.segments(&tile, &mut |texel, segment| part.push((texel, segment)));
        let inside = |texel: [usize; 2]| tile.x.contains(&texel[0]) && tile.y.contains(&texel[1]);
        let key =
            |(texel, segment): &([usize; 2], BlockerSegment)| (*texel, segment.entry().to_bits());
        let mut expected: Vec<_> = at_once
            .iter()
            .filter(|(t, _)| inside(*t))
            .copied()
            .collect();
        let mut found: Vec<_> = part.into_iter().filter(|(t, _)| inside(*t)).collect();
        expected.sort_by_key(key);
        found.sort_by_key(key);
        assert_eq!(found, expected);
        assert!(!found.is_empty());
    }
}

#[test]
fn extreme_casters_break_nothing() {
    let far = 4.9e8;
    let point = |x: f32, y: f32, thickness: f32| StrandPoint {
        position: Vec3::new(x, y, 0.0),
        thickness,
        opacity: 1.0,
    };
    let strands = Strands::new(
        vec![
            point(0.0, 0.0, 0.0),
            point(0.0, 0.0, 1.0),
            point(-far, far, 1e8),
            point(far, 1e-30, 1e-30),
            point(0.0, 3.0, 1.0),
            point(0.0, -3.0, 1.0),
        ],
        vec![6],
    );
    let ball = |x: f32, radius: f32, sigma_t: f32| Particle {
        centre: Vec3::new(x, 0.0, 0.0),
        radius,
        sigma_t,
    };
    let balls = vec![
        ball(0.0, 0.0, 1.0),
        ball(0.0, 1e8, 1e15),
        ball(far, 1e-30, 1e-30),
        ball(0.0, 1.0, 1e-12),
    ];
    let bounds = Bounds::new(Vec3::splat(-9.9e8), Vec3::splat(9.9e8)).unwrap();
    let grid = |interpolation| {
        DensityGrid::new(
            bounds,
            [1, 2, 3],
            vec![1e15, 0.0, 1e-20, 1.0, 0.0, 0.0],
            1e15,
            interpolation,
        )
    };
    let all: Vec<Translucent> = vec![
        strands.unwrap().into(),
        Particles::new(balls.clone(), Profile::Soft).unwrap().into(),
        Particles::new(balls, Profile::Constant).unwrap().into(),
        grid(Interpolation::Linear).unwrap().into(),
        grid(Interpolation::Constant).unwrap().into(),
    ];
    let cpu = Cpu::new();
    for caster in &all {
        let casters = Casters::new(std::slice::from_ref(caster), None);
        for emitter in [
            sun(Vec3::NEG_Y),
            sun(Vec3::new(1.0, 1e-20, 0.0)),
            lamp(Vec3::ZERO),
            lamp(Vec3::new(0.0, 1.0, 0.0)),
            lamp(Vec3::splat(9e8)),
        ] {
            let map = TransmittanceMap::<Host, transmittance::Curve<4>>::build(
                &cpu,
                &casters,
                &emitter,
                17,
                &Stream::<4>::new(),
            );
            let map = map.unwrap();
            for probe in [
                Vec3::ZERO,
                Vec3::splat(1e9),
                Vec3::new(0.0, -5.0, 1e-3),
                Vec3::NAN,
            ] {
                let value = map.transmittance(probe).x;
                assert!((0.0..=1.0).contains(&value), "{value}");
            }
        }
    }
    let casters = Casters::new(&all, None);
    for resolution in [0, 16385] {
        assert!(casters.faces(&cpu, &sun(Vec3::X), resolution).is_err());
    }
}

#[test]
fn all_blockers_lie_between_the_depths_that_are_told() {
    let all = [
        puffs(Profile::Soft),
        slope(),
        strand(&[Vec3::ZERO, Vec3::ONE], 0.05, 0.8),
    ];
    // Its thin end is as thick as the piece, and sticks out of all the rest.
    let point = |position: Vec3, thickness: f32| StrandPoint {
        position,
        thickness,
        opacity: 0.8,
    };
    let ends = vec![
        point(Vec3::new(0.0, 3.4, 0.0), 0.0),
        point(Vec3::new(1.5, 2.5, 1.5), 1.0),
    ];
    let tapered = [Strands::new(ends, vec![2]).unwrap().into()];
    for casters in [Casters::new(&all, None), Casters::new(&tapered, None)] {
        depths_hold(&casters);
    }
    // In its shadow, beside the thin end.
    let map = exact(&Casters::new(&tapered, None), &sun(Vec3::NEG_Y), 256);
    let shaded = map.transmittance(Vec3::new(-0.1, 0.0, 0.12)).x;
    assert!((shaded - 0.2).abs() < 0.02, "{shaded}");
}

fn depths_hold(casters: &Casters<'_>) {
    for emitter in [
        sun(DVec3::new(0.5, -1.0, 0.1).as_vec3()),
        lamp(Vec3::new(0.0, 0.7, 0.0)),
        lamp(Vec3::new(5.0, 0.7, 0.0)),
    ] {
        let cpu = Cpu::new();
        for (_, blockers) in casters.faces(&cpu, &emitter, 32).unwrap() {
            let [near, far] = blockers.depths();
            blockers.segments(&Tile { x: 0..32, y: 0..32 }, &mut |_, segment| {
                assert!(near <= segment.entry() && segment.exit() <= far);
            });
        }
    }
}
