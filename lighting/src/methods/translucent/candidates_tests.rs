//! Maps that shaders make of casters, against the truth and against the CPU.

use std::fmt;

use glam::Vec3;
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use gpu_backend::shader::Assembly;
use gpu_backend::testing::Shader;
use gpu_backend::{Cpu, Host, assert_same_layout, testing};
use reference::tolerances::Allowed;
use transmittance::baseline::{Captured, Uncompressed};
use transmittance::gpu::{CandidatesSlot, WgslRule, WgslStored, build_parts};
use transmittance::{Curve, Evaluate, Linear, Packed, Stream};

use super::candidates::{self, CandidateRecord, PictureRecord};
use super::grid_rays::GridRays;
use super::{Casters, TransmittanceMap, TransmittanceMapError};
use crate::Emitter;
use crate::scene::procedural::{ponytail, smoke_particles};
use crate::scene::raster::Face;
use crate::scene::{
    Bounds, DensityGrid, Emission, Geometry, Interpolation, Mesh, Particle, Particles, Profile,
    Scene, StrandPoint, Strands, Translucent,
};

type Adaptive<M> = TransmittanceMap<M, Curve<8>>;

#[test]
fn records_are_those_of_the_shader() {
    let stub = "
        fn avsm_word(index: u32) -> u32 { return 0u; }
        fn avsm_set_word(index: u32, word: u32) {}";
    let parts = [&build_parts::<Stream<8>, Packed<8>, 1>()[..], &[stub]].concat();
    let mut shader = Assembly::new(&parts);
    shader
        .fill::<CandidatesSlot>(&candidates::part())
        .expect("the part fits its slot");
    let shader = Shader::new(&shader.finish(1)).expect("the shader is valid");
    assert_same_layout!(
        shader,
        "light_Picture",
        PictureRecord {
            scale,
            half,
            resolution,
            parallel,
            empty,
            rows,
            padding
        }
    );
    assert_same_layout!(
        shader,
        "light_GridRays",
        GridRays {
            grid,
            start,
            reach,
            direction,
            tint,
            across,
            segments,
            down,
            padding
        }
    );
    assert_same_layout!(
        shader,
        "light_Candidate",
        CandidateRecord {
            kind,
            columns,
            first_row,
            end_row,
            a,
            radius,
            b,
            opacity,
            corners
        }
    );
    for (name, value) in [
        ("light_STRAND", candidates::STRAND),
        ("light_BALL", candidates::BALL),
        ("light_OPAQUE", candidates::OPAQUE),
        ("light_GRID", candidates::GRID),
        ("light_PARTS", super::particles::PARTS),
    ] {
        assert_eq!(
            shader.values(name).expect("the constant exists"),
            [f64::from(value)],
            "{name}"
        );
    }
}

pub(super) fn lamp(position: Vec3) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).expect("a light")
}

pub(super) fn lights() -> [Emitter; 3] {
    let sun = Vec3::new(0.3, -1.0, 0.2).normalize();
    [
        Emitter::directional(sun, Vec3::ONE).expect("a light"),
        lamp(Vec3::new(0.3, 1.1, 0.2)),
        lamp(Vec3::new(0.2, 3.0, 0.1)),
    ]
}

/// Mean errors of a map made there and of one made here, and how far the former is beyond its
/// bound anywhere. A depth may be off by 8 units of itself and by `shift`.
pub(super) fn errors(
    gpu: &Gpu<Queued>,
    casters: &Casters<'_>,
    emitter: &Emitter,
    resolution: u32,
    shift: f32,
) -> ([f64; 2], f32) {
    let (cpu, clear) = (Cpu::new(), Stream::<8>::new());
    let there = Adaptive::<GpuMemory>::build_in_shaders(gpu, casters, emitter, resolution, &clear)
        .expect("a map is built")
        .expect("all of it in shaders");
    // Shaders give all faces the same number of texels.
    let sides = (resolution, |_: &Face| resolution);
    let here = Adaptive::<Host>::with_sides(&cpu, casters, emitter, sides, &clear).expect("a map");
    let exact: TransmittanceMap<Host, Uncompressed> =
        TransmittanceMap::with_sides(&cpu, casters, emitter, sides, &Captured::new())
            .expect("a map");
    assert_eq!(there.faces(), here.faces());
    assert_eq!(there.channels(), here.channels());
    assert_eq!(there.bytes(), here.bytes());
    let map = there.curves().download(gpu).expect("what was made");
    let blockers = casters.faces(&cpu, emitter, resolution).expect("faces");
    let depths: Vec<[f32; 2]> = blockers.map(|(_, blockers)| blockers.depths()).collect();
    let side = resolution as usize;
    let (mut sums, mut count, mut beyond) = ([0.0; 2], 0.0, 0.0_f32);
    for picture in 0..here.curves().len() {
        let [near, far] = depths[picture % depths.len()];
        for texel in 0..side * side {
            let found = map.texel(texel % side, picture * side + texel / side);
            let truth = &exact.curves()[picture].texels()[texel];
            let own = &here.curves()[picture].texels()[texel];
            for step in 0..9 {
                let share = (step as f32 + (texel as f32 * 0.618).fract()) / 8.0;
                let depth = near + (far - near) * share;
                let around = 8.0 * 0.5 * f32::EPSILON * depth.abs() + shift;
                let ends = [depth - around, depth + around].map(|at| truth.evaluate(at)[0]);
                let (value, bound) = (found.transmittance(depth), found.error_bound(depth));
                beyond = beyond
                    .max(value - ends[0] - bound)
                    .max(ends[1] - value - bound);
                let value = truth.evaluate(depth)[0];
                sums[0] += f64::from((found.transmittance(depth) - value).abs());
                sums[1] += f64::from((own.transmittance(depth) - value).abs());
                count += 1.0;
            }
        }
    }
    (sums.map(|sum| sum / count), beyond)
}

pub(super) fn agree(translucent: &[Translucent], geometry: Option<&Geometry>, resolution: u32) {
    let Some(gpu) = testing::gpu() else { return };
    let casters = Casters::new(translucent, geometry);
    for emitter in lights() {
        agree_under(&gpu, &casters, &emitter, resolution);
    }
}

pub(super) fn agree_under(
    gpu: &Gpu<Queued>,
    casters: &Casters<'_>,
    emitter: &Emitter,
    resolution: u32,
) {
    let ([there, here], beyond) = errors(gpu, casters, emitter, resolution, 0.0);
    println!("mean errors: {there:.2e} there, {here:.2e} here; {beyond:.1e} beyond the bounds");
    let allowed = Allowed::GpuMet.error();
    assert!(f64::from(beyond) <= allowed, "{beyond}");
    assert!(there <= 1.1 * here + 0.1 * allowed, "{there} {here}");
}

pub(super) fn puffs(profile: Profile) -> Translucent {
    let puff = |x: f32, y: f32, radius: f32, sigma_t: f32| Particle {
        centre: Vec3::new(x, y, 0.1),
        radius,
        sigma_t,
    };
    let all = vec![
        puff(-0.4, 1.0, 0.5, 2.0),
        puff(0.3, 1.0, 0.7, 1.0),
        // Around the lamp, small and far, without size, without smoke.
        puff(0.3, 1.1, 0.3, 0.7),
        puff(0.9, -0.8, 0.004, 90.0),
        puff(0.0, 0.0, 0.0, 3.0),
        puff(0.0, 0.0, 0.5, 0.0),
    ];
    Particles::new(all, profile).expect("particles").into()
}

pub(super) fn strand(points: &[Vec3], thickness: f32, opacity: f32) -> Translucent {
    let point = |&position: &Vec3| StrandPoint {
        position,
        thickness,
        opacity,
    };
    let ends = vec![points.len() as u32];
    let points = points.iter().map(point).collect();
    Strands::new(points, ends).expect("strands").into()
}

pub(super) fn floor() -> Geometry {
    let corner = |x: f32, z: f32| Vec3::new(x, -0.9, z);
    let plate = Scene::from(Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    Geometry::new(&plate).expect("a mesh")
}

#[test]
fn balls_are_met_as_on_the_cpu() {
    agree(&[puffs(Profile::Constant)], None, 40);
    agree(&[puffs(Profile::Soft)], Some(&floor()), 33);
}

#[test]
fn strands_of_every_size_are_met_as_on_the_cpu() {
    let hair = [
        strand(
            &[Vec3::new(-1.0, 0.2, -0.5), Vec3::new(0.3, 0.9, 0.4)],
            0.002,
            0.7,
        ),
        strand(
            &[Vec3::new(-0.8, 0.2, 0.5), Vec3::new(0.6, -0.4, 0.4)],
            0.2,
            0.4,
        ),
        // Along the rays of the sun nearly, past the lamp, wider than the picture, without
        // length, without thickness, opaque.
        strand(&[Vec3::ZERO, Vec3::new(0.3001, -1.0, 0.2)], 0.05, 0.5),
        strand(
            &[Vec3::new(0.31, -1.0, 0.2), Vec3::new(0.31, 2.0, 0.21)],
            0.01,
            0.5,
        ),
        strand(
            &[Vec3::new(-0.1, -0.5, 0.0), Vec3::new(0.1, -0.5, 0.0)],
            9.0,
            0.3,
        ),
        strand(&[Vec3::ONE, Vec3::ONE], 0.2, 0.5),
        strand(&[Vec3::ZERO, Vec3::ONE], 0.0, 0.5),
        strand(
            &[Vec3::new(0.5, 0.5, 0.5), Vec3::new(0.9, 0.4, 0.5)],
            0.05,
            1.0,
        ),
    ];
    agree(&hair, Some(&floor()), 48);
    agree(&hair[..4], None, 61);
    agree(&hair, None, 1);
}

#[test]
fn many_strands_in_smoke_are_within_the_bounds_of_their_curves() {
    let hair = ponytail(7, 2000, 0.004, 0.6).unwrap().into();
    agree(&[hair, smoke_particles(3).into()], None, 32);
}

/// The mean difference of maps of stored curves that were made there and here.
fn difference<A, T>(gpu: &Gpu<Queued>, casters: &Casters<'_>, clear: &A) -> f64
where
    A: WgslRule + Clone + Sync,
    A::Curve: Into<T>,
    T: Evaluate + WgslStored + fmt::Debug + Clone + Sync,
{
    const SIDE: u32 = 24;
    let light = &lights()[2];
    let there = TransmittanceMap::<_, T>::build_in_shaders(gpu, casters, light, SIDE, clear)
        .expect("a map is built")
        .expect("all of it in shaders");
    let there = there.curves().download(gpu).expect("what was made");
    let sides = (SIDE, |_: &Face| SIDE);
    let here = TransmittanceMap::<_, T>::with_sides(&Cpu::new(), casters, light, sides, clear)
        .expect("a map");
    let here = here.curves().iter().flat_map(|map| map.texels());
    let mut off = Vec::new();
    for (index, here) in here.enumerate() {
        let there = there.texel(index % SIDE as usize, index / SIDE as usize);
        let at = |i: u16| 0.05 * f32::from(i);
        let differences = (0..100).map(|i| there.evaluate(at(i))[0] - here.evaluate(at(i))[0]);
        off.extend(differences.map(|it| f64::from(it.abs())));
    }
    off.iter().sum::<f64>() / off.len() as f64
}

#[test]
fn every_rule_makes_the_curves_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let smoke = [puffs(Profile::Soft)];
    let casters = Casters::new(&smoke, None);
    let rule = Curve::<4, Linear>::default();
    let by_rule = difference::<_, Packed<4, Linear>>(&gpu, &casters, &rule);
    let by_area = difference::<_, Packed<16>>(&gpu, &casters, &Stream::<16>::default());
    for mean in [by_rule, by_area] {
        assert!(
            mean < Allowed::GpuMet.error(),
            "{by_rule:.1e} {by_area:.1e}"
        );
    }
}

#[test]
fn the_order_of_casters_changes_no_more_than_curves_may_be_off() {
    let Some(gpu) = testing::gpu() else { return };
    let Translucent::Particles(smoke) = Translucent::from(smoke_particles(3)) else {
        panic!("particles");
    };
    let mut turned = smoke.all().to_vec();
    turned.reverse();
    let turned = Particles::new(turned, smoke.profile()).unwrap();
    let map = |particles: Particles| {
        let casters = [particles.into()];
        let (casters, clear) = (Casters::new(&casters, None), Stream::<8>::new());
        let map = Adaptive::<GpuMemory>::build_in_shaders(&gpu, &casters, &lights()[0], 48, &clear);
        map.unwrap().unwrap().curves().download(&gpu).unwrap()
    };
    let [one, other] = [smoke, turned].map(map);
    for (x, y) in (0..48).flat_map(|y| (0..48).map(move |x| (x, y))) {
        let [a, b] = [one.texel(x, y), other.texel(x, y)];
        for depth in (0..20).map(|i| 0.5 * i as f32) {
            let off = (a.transmittance(depth) - b.transmittance(depth)).abs();
            assert!(
                off <= a.error_bound(depth) + b.error_bound(depth),
                "{x} {y}: {off}"
            );
        }
    }
}

#[test]
fn what_shaders_do_not_know_is_left_to_the_cpu_and_bad_sizes_are_named() {
    let Some(gpu) = testing::gpu() else { return };
    let (sun, clear) = (&lights()[0], Stream::<8>::new());
    let built = |casters: &Casters<'_>, resolution| {
        TransmittanceMap::<GpuMemory>::build_in_shaders(&gpu, casters, sun, resolution, &clear)
    };
    let grid = |cells| {
        let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap();
        let density = vec![1.0; cells as usize];
        DensityGrid::new(bounds, [1, cells, 1], density, 1.0, Interpolation::Constant).unwrap()
    };
    let [short, long] = [2048, 2049].map(|cells| [grid(cells).into()]);
    assert!(built(&Casters::new(&short, None), 8).unwrap().is_some());
    assert!(built(&Casters::new(&long, None), 8).unwrap().is_none());
    // More segments on a ray than there may be dispatches for.
    let many = vec![grid(2048).into(); 2000];
    assert!(built(&Casters::new(&many, None), 8).unwrap().is_none());
    let wire = [strand(&[Vec3::ZERO, Vec3::ONE], 0.002, 0.7)];
    let wire = Casters::new(&wire, None);
    assert!(built(&wire, 1024).unwrap().is_none());
    assert!(built(&wire, 64).unwrap().is_some());
    let nothing = Casters::new(&[], None);
    let map = built(&nothing, 8).unwrap().unwrap();
    assert!(map.faces().is_empty() && map.bytes() == 0);
    let resolution = built(&nothing, 0).unwrap_err();
    assert_eq!(
        resolution,
        TransmittanceMapError::Resolution { resolution: 0 }
    );
    let puffs = [puffs(Profile::Soft)];
    let error = built(&Casters::new(&puffs, None), 16384).unwrap_err();
    assert!(
        error.to_string().contains("a map of 16384 by 16384 texels"),
        "{error}"
    );
}
