//! Many lights in shaders: without a device, and against the CPU with one.

use airlight::{PhaseFunction, Table};
use glam::Vec3;
use gpu_backend::gpu::InShader;
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Cpu, Download, assert_same_layout};
use reference::random::Random;
use reference::tolerances::Allowed;

use super::gpu::{ManyLight, STORAGE, Scene, shader};
use super::tests::{before, bits};
use super::*;
use crate::airlight::{Analytic, Daylight, EquiAngular, Midpoint, PerFrame, Quadrature};
use crate::culling::RayTiles;
use crate::culling::tests::{WIDTH, lights, rays};
use crate::gpu::AirlightSlot;
use crate::{Gather, LitRays};

/// The shader of a pair, which must be valid and keep to WebGPU's eight storage buffers.
fn complete<V: InShader<ManyVisibilitySlot>, A: InShader<AirlightSlot>>() -> Shader {
    let assembly = shader::<V, A>().unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = STORAGE + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    Shader::new(&assembly.finish(1)).unwrap()
}

fn with_every_evaluator<V: InShader<ManyVisibilitySlot>>() -> Shader {
    complete::<V, EquiAngular>();
    complete::<V, Quadrature>();
    complete::<V, Analytic<Table>>();
    complete::<V, PerFrame>();
    complete::<V, Daylight>();
    complete::<V, Midpoint>()
}

#[test]
fn every_pair_compiles_and_sees_lights_as_they_are() {
    let shader = with_every_evaluator::<Unshadowed>();
    assert_same_layout!(
        shader,
        "Scene",
        Scene {
            medium,
            rays,
            tiles,
            joined,
            first,
            entry,
            most,
            cookies,
            padding
        }
    );
    assert_same_layout!(
        shader,
        "ManyLight",
        ManyLight {
            emitter,
            cookie,
            padding_a,
            padding_b,
            padding_c
        }
    );
    let entries = size_of::<ManyLight>() as f64 / 16.0;
    assert_eq!(shader.values("MANY_LIGHT").unwrap(), [entries]);
    #[cfg(feature = "shadow-dag")]
    with_every_evaluator::<crate::precomputed::BakedShadows<gpu_backend::gpu::GpuMemory>>();
}

fn fog() -> Medium {
    let sigma = Vec3::new(0.05, 0.04, 0.03);
    Medium::new(sigma, 0.2 * sigma, PhaseFunction::Isotropic).unwrap()
}

/// Pictures with lists and without, with all of each list at once and in parts, have the
/// same bits.
fn check_lists<V, A, B>(
    gpu: &B,
    rays: &[Ray],
    emitters: &[Emitter],
    touching: Touching,
    (sources, airlight): (&V, &A),
) -> Vec<[f32; 4]>
where
    B: GatherMany<V, A> + Download,
{
    let medium = fog();
    let tiles = RayTiles::new(&Cpu::new(), rays, WIDTH, None).unwrap();
    let culled = TileLights::new(&Cpu::new(), &tiles, emitters).unwrap();
    let all = TileLights::all(&tiles, emitters.len());
    let uploaded = gpu.upload(rays).unwrap();
    let picture = |lists: &TileLights<'_>, lights_per_dispatch| {
        let mut found = gpu.upload(&before(rays.len())).unwrap();
        let lit = LitByMany {
            touching,
            lights_per_dispatch,
            ..LitByMany::new(&uploaded, emitters, lists, &medium)
        };
        gpu.gather_many(&lit, sources, airlight, &mut found)
            .unwrap();
        gpu.download(&found).unwrap()
    };
    let expected = picture(&all, usize::MAX);
    for found in [
        picture(&culled, usize::MAX),
        picture(&culled, 3),
        picture(&all, 1),
    ] {
        assert!(bits(&found) == bits(&expected));
    }
    expected
}

/// The picture of lights one by one.
fn one_by_one<V, A, B>(
    gpu: &B,
    rays: &[Ray],
    emitters: &[Emitter],
    touching: Touching,
    (sources, airlight): (&[V], &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let medium = fog();
    let uploaded = gpu.upload(rays).unwrap();
    let mut found = gpu.upload(&before(rays.len())).unwrap();
    for (source, emitter) in sources.iter().zip(emitters) {
        let lit = LitRays {
            touching,
            ..LitRays::new(&uploaded, emitter, &medium)
        };
        gpu.gather(&lit, source, airlight, &mut found).unwrap();
    }
    gpu.download(&found).unwrap()
}

/// Two shaders of the same computation: they differ by how a driver contracts operations.
fn check_close(found: &[[f32; 4]], expected: &[[f32; 4]]) {
    let close = |(a, b): (&[f32; 4], &[f32; 4])| {
        let close = |(a, b): (&f32, &f32)| (a - b).abs() <= error(Allowed::GpuIntervals) * b.abs();
        a.iter().zip(b).all(close)
    };
    let far = found.iter().zip(expected).filter(|both| !close(*both));
    let far = far.count();
    assert!(100 * far <= expected.len(), "{far} of {}", expected.len());
}

fn error(allowed: Allowed) -> f32 {
    allowed.error() as f32
}

#[test]
fn pictures_do_not_depend_on_lists_and_are_those_of_lights_one_by_one() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(1);
    let quadrature = Quadrature::with_tolerance(PhaseFunction::Isotropic, 1e-3).unwrap();
    let table = Table::new(&PhaseFunction::Isotropic, 64).unwrap();
    let table = Analytic::new(table, quadrature.clone());
    let gauss = EquiAngular::new(4).unwrap();
    for set in 0..4 {
        let rays = rays(&mut random);
        let lights = lights(&mut random, &rays, 9 + set);
        let apart = Touching::Apart;
        check_lists(&gpu, &rays, &lights, apart, (&Unshadowed, &Midpoint));
        check_lists(&gpu, &rays, &lights, apart, (&Unshadowed, &table));
        if set == 0 {
            check_lists(&gpu, &rays, &lights, apart, (&Unshadowed, &quadrature));
        }
        let found = check_lists(&gpu, &rays, &lights, apart, (&Unshadowed, &gauss));
        let sources = vec![Unshadowed; lights.len()];
        let expected = one_by_one(&gpu, &rays, &lights, apart, (&sources, &gauss));
        check_close(&found, &expected);
    }
}

#[cfg(feature = "shadow-dag")]
#[test]
fn shadowed_pictures_do_not_depend_on_lists_and_are_those_of_lights_one_by_one() {
    use crate::precomputed::{BakedShadow, BakedShadows};

    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(2);
    let gauss = EquiAngular::new(3).unwrap();
    for _ in 0..3 {
        let rays = rays(&mut random);
        let lights = lights(&mut random, &rays, 9);
        let shadows = super::tests::shadowed::plates(&mut random, &rays, &lights);
        let owned: Vec<BakedShadow> = shadows.iter().map(|shadow| (**shadow).clone()).collect();
        let there = BakedShadows::upload(&owned, &gpu).unwrap();
        assert!(there.lights().len() == lights.len() && there.bytes() > 0);
        let joined = Touching::Joined;
        let found = check_lists(&gpu, &rays, &lights, joined, (&there, &gauss));
        let upload = |shadow: &BakedShadow| shadow.upload(&gpu).unwrap();
        let sources: Vec<_> = owned.iter().map(upload).collect();
        let expected = one_by_one(&gpu, &rays, &lights, joined, (&sources, &gauss));
        check_close(&found, &expected);
        let open = vec![Unshadowed; lights.len()];
        let open = one_by_one(&gpu, &rays, &lights, joined, (&open, &gauss));
        assert!(bits(&expected) != bits(&open), "nothing is in shadow");
    }
}
