use glam::{Affine3A, Quat, Vec3};
use scene::{
    Bounds, DensityGrid, Instance, Interpolation, Medium, Mesh, Particle, Particles, PhaseFunction,
    Profile, Scene, StrandPoint, Strands,
};

use super::*;
use crate::metrics::DARKEST;
use crate::oracle::media::MediaWorld;
use crate::random::Random;

/// Triangles that need not cast a shadow here.
fn geometry(random: &mut Random, is_lit: bool) -> Geometry {
    let place = if is_lit {
        -1e4
    } else {
        random.between(1.2, 2.0)
    };
    let corner = |x: f32, z: f32| Vec3::new(x, place, z);
    let shift = random.between(-0.5, 0.5);
    let mut scene = Scene::default();
    scene.meshes.push(Mesh {
        positions: vec![
            corner(shift - 0.6, -1.0),
            corner(shift + 0.8, -1.0),
            corner(shift, 2.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    scene.instances.push(Instance::default());
    Geometry::new(&scene).expect("a triangle")
}

fn emitters(random: &mut Random) -> Vec<Emitter> {
    let colour = Vec3::new(3.0, 2.0, 1.0);
    let position = Vec3::new(random.between(-2.0, 2.0), 3.0, random.between(-2.0, 2.0));
    let cone = scene::Cone {
        inner: 0.3,
        outer: 0.7,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let spot = scene::Emission::spot(down, cone, None).expect("a cone");
    let even = scene::Emission::Isotropic;
    let slant = Vec3::new(random.between(-1.0, 1.0), -1.0, random.between(-1.0, 1.0));
    let all = [
        Emitter::point(position, colour, f32::INFINITY, even),
        Emitter::point(position, colour, 9.0, spot),
        Emitter::directional(slant, colour),
    ];
    let first = random.below(3) as usize;
    let all = all.map(|emitter| emitter.expect("a light"));
    all[first..].to_vec()
}

fn grid(random: &mut Random) -> DensityGrid {
    let resolution = [0; 3].map(|_| 1 + random.below(6));
    let count = resolution.iter().product::<u32>();
    // A third of the samples are empty.
    let sample = |_| (random.unit() * 1.5 - 0.5).max(0.0);
    let density = (0..count).map(sample).collect();
    let interpolation = match random.below(2) {
        0 => Interpolation::Constant,
        _ => Interpolation::Linear,
    };
    let bounds = Bounds::new(Vec3::new(-1.0, -0.7, -0.8), Vec3::new(1.2, 0.9, 0.7));
    let scale = random.log_uniform(1e-2, 30.0) as f32;
    let turn = Quat::from_rotation_y(random.between(-1.0, 1.0));
    let shift = 0.3 * Vec3::from_array(random.vector(1.0));
    let albedo = Vec3::new(0.9, 0.6, random.unit());
    let g = random.between(-0.7, 0.7);
    DensityGrid::new(
        bounds.expect("a box"),
        resolution,
        density,
        scale,
        interpolation,
    )
    .and_then(|grid| grid.with_tint(Vec3::new(1.0, 0.7, 0.5)))
    .and_then(|grid| grid.with_albedo(albedo))
    .and_then(|grid| grid.with_phase(PhaseFunction::HenyeyGreenstein { g }))
    .and_then(|grid| grid.with_transform(Affine3A::from_rotation_translation(turn, shift)))
    .expect("smoke")
}

fn puffs(random: &mut Random) -> Particles {
    let puff = |_| Particle {
        centre: Vec3::from_array(random.vector(1.0)),
        radius: random.between(0.1, 0.6),
        sigma_t: random.log_uniform(0.1, 5.0) as f32,
    };
    let all = (0..5).map(puff).collect();
    let profile = match random.below(2) {
        0 => Profile::Constant,
        _ => Profile::Soft,
    };
    Particles::new(all, profile).expect("puffs")
}

fn hair(random: &mut Random) -> Strands {
    let mut point = |x: f32| StrandPoint {
        position: Vec3::new(x, random.between(1.0, 1.4), random.between(-0.3, 0.3)),
        thickness: 0.1,
        opacity: 0.6,
    };
    let points = vec![point(-0.8), point(0.0), point(0.9)];
    Strands::new(points, vec![3]).expect("a strand")
}

fn rays(random: &mut Random) -> Vec<Ray> {
    let mut ray = |length: f32| {
        let origin = Vec3::new(-4.0, random.between(-0.5, 1.0), random.between(-1.0, 1.0));
        let target = 0.5 * Vec3::from_array(random.vector(1.0));
        Ray::new(origin, target - origin, length).expect("a ray")
    };
    // The last ends in the smoke.
    vec![ray(9.0), ray(f32::INFINITY), ray(4.0)]
}

#[test]
fn random_scenes_are_those_of_the_bounded_oracle() {
    for (tolerance, least) in [(1e-3, 1.0), (1e-5, 0.9)] {
        random_scenes(tolerance, least);
    }
}

/// That at least this share of rays is within its bound, and no ray off by more than a
/// thousandth.
fn random_scenes(tolerance: f64, least: f64) {
    let mut random = Random::new(20);
    let (mut lit, mut worst, mut within_bound) = (0, 0.0_f64, 0);
    for case in 0..60 {
        let mut translucent: Vec<Translucent> = Vec::new();
        if case % 4 != 3 {
            translucent.push(grid(&mut random).into());
        }
        if case % 5 == 0 {
            translucent.push(grid(&mut random).into());
        }
        if case % 3 == 1 {
            translucent.push(puffs(&mut random).into());
        }
        let has_hair = case % 10 == 7;
        if has_hair {
            translucent.push(hair(&mut random).into());
        }
        let phase = PhaseFunction::HenyeyGreenstein { g: 0.4 };
        let sigma_s = Vec3::new(0.08, 0.05, 0.03);
        let fog = Medium::new(sigma_s, Vec3::splat(0.02), phase).expect("fog");
        let within = Bounds::new(Vec3::new(-3.0, -1.5, -2.0), Vec3::new(2.0, 4.0, 2.5));
        let fog = match case % 2 {
            0 => fog,
            _ => fog.within(within.expect("a box")),
        };
        let height = HeightFog::new(sigma_s, Vec3::splat(0.05), 0.0, 0.8, phase);
        let height = height.expect("fog");
        let air = Air {
            medium: (case % 3 != 0).then_some(&fog),
            height_fog: (case % 4 == 3).then_some(&height),
            translucent: &translucent,
        };
        let emitters = emitters(&mut random);
        let geometry = geometry(&mut random, case % 3 == 2);
        let rays = rays(&mut random);
        let options = Options {
            tolerance,
            ..Options::default()
        };
        let found = reference(&rays, air, &emitters, &geometry, options);
        let world = MediaWorld::new(air, &emitters, &geometry);
        let mean = found.mean();
        for (index, ray) in rays.iter().enumerate() {
            let expected = world.radiance(ray, Tolerance::relative(0.1 * tolerance));
            let value = DVec3::from_array(found.radiance[index]);
            let off = (value - expected.value).abs().max_element();
            // The samples of the other are rounded as those of the grid are.
            let rounding = 1e-6 * expected.value.max_element();
            let bound = found.bound[index];
            within_bound += u32::from(off <= bound + expected.bound + rounding);
            let asked = tolerance * expected.value.max_element().max(DARKEST * mean);
            let enough = 1.1 * SAFETY * asked;
            assert!(bound <= enough, "{case}: {bound:e} {asked:e}");
            let allowed = (4.0 * asked).max(1e-3 * expected.value.max_element());
            assert!(
                off <= allowed,
                "{case}, ray {index}: {value} {expected:?}, {bound:e}"
            );
            lit += u32::from(expected.value.min_element() > 0.0);
            worst = worst.max(off / asked);
        }
    }
    let share = f64::from(within_bound) / 180.0;
    println!("{lit} of 180 rays are lit; {worst:.2} of {tolerance:e} at worst, {share}");
    assert!(lit > 120 && share >= least, "{lit}, {share}");
}

#[test]
fn vacuum_and_darkness_are_black() {
    let mut random = Random::new(1);
    let (rays, geometry) = (rays(&mut random), geometry(&mut random, true));
    let lights = emitters(&mut random);
    let nothing = reference(
        &rays,
        Air::default(),
        &lights,
        &geometry,
        Options::default(),
    );
    let casters = [grid(&mut random).into()];
    let air = Air {
        translucent: &casters,
        ..Air::default()
    };
    let dark = reference(&rays, air, &[], &geometry, Options::default());
    for picture in [nothing, dark] {
        assert_eq!(picture.mean(), 0.0);
        assert_eq!(picture.max_bound(), 0.0);
    }
}

#[test]
fn opaque_smoke_is_lit_on_its_skin() {
    // One cell of any density: E σ_s/σ_t × 1/(1 + 1/cos) × p from a sun behind the eye.
    let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE).expect("a box");
    let sun = [Emitter::directional(Vec3::X, Vec3::ONE).expect("a sun")];
    let ray = Ray::new(Vec3::new(-1.0, 0.5, 0.5), Vec3::X, f32::INFINITY).expect("a ray");
    let mut random = Random::new(3);
    let geometry = geometry(&mut random, true);
    for scale in [1e-4, 1.0, 1e3, 1e6] {
        let density = vec![1.0];
        let grid = DensityGrid::new(bounds, [1; 3], density, scale, Interpolation::Constant);
        let casters = [grid.expect("smoke").into()];
        let air = Air {
            translucent: &casters,
            ..Air::default()
        };
        let found = reference(&[ray], air, &sun, &geometry, Options::default());
        let depth = f64::from(scale);
        let expected = -0.5 * (-2.0 * depth).exp_m1() / (4.0 * std::f64::consts::PI);
        let ratio = found.radiance[0][0] / expected;
        assert!((ratio - 1.0).abs() < 2e-6, "{scale}: {ratio}");
    }
}

#[test]
fn steps_are_products_of_the_factors_that_hold() {
    let mut random = Random::new(5);
    // With many that begin and end at one place, and some without length.
    for count in [0, 1, 2, 3, 17, 100, 100_000] {
        let factor = |_| {
            let start = f64::from(random.between(0.0, 9.0).floor());
            let end = start + f64::from(random.between(0.0, 4.0).floor());
            let least = 1.0 - 1.0 / (1.0 + count as f32);
            (Span::new(start, end), f64::from(random.between(least, 1.0)))
        };
        let factors: Vec<(Span, f64)> = (0..count).map(factor).collect();
        let steps = Steps::new(&factors);
        assert!(steps.0.len() <= 13);
        for x in (-1..30).map(|k| 0.5 * f64::from(k)) {
            let holds = |(span, _): &&(Span, f64)| span.start <= x && x < span.end;
            let expected: f64 = factors.iter().filter(holds).map(|(_, by)| by).product();
            assert!((steps.at(x) - expected).abs() <= 1e-10 * expected);
        }
    }
}
