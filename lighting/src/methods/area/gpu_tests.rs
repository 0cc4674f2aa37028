//! The shader of many lights without a device, and against the CPU with one.

use ::airlight::Table;
use glam::{Quat, Vec3};
use gpu_backend::gpu::InShader;
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, assert_same_layout};
use reference::tolerances::Allowed;

use super::gpu::{BlockRecord, Light, TURNS, blocks, shader, turns};
use super::surfaces_tests::floor;
use super::tests::{eye, fog, lights, maps, rays, resolution};
use super::*;
use crate::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use crate::gpu::AirlightSlot;
use crate::scene::{Cone, Emission, PhaseFunction, Texture};
use crate::shadow_map::{Casters, RenderShadowMapAtlas};
use crate::voxelized::Detail;
use crate::{Emitter, Interleaving};

/// The shader of an evaluator, which must be valid and keep to WebGPU's eight
/// storage buffers, of which the frame has six.
fn complete<A: InShader<AirlightSlot>>() -> Shader {
    let assembly = shader::<A>().unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = 6 + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    Shader::new(&assembly.finish(1)).unwrap()
}

#[test]
fn every_evaluator_goes_with_many_lights() {
    complete::<Midpoint>();
    complete::<Quadrature>();
    complete::<Analytic<Table>>();
    let shader = complete::<EquiAngular>();
    assert_same_layout!(
        shader,
        "Block",
        BlockRecord {
            medium,
            count,
            lights,
            first,
            weight
        }
    );
    assert_same_layout!(
        shader,
        "Light",
        Light {
            emitter,
            voxels,
            first_texel,
            first_bound,
            first_word,
            padding
        }
    );
}

/// The settings of the methods, and the longest loops that a light may need.
#[test]
fn blocks_end_in_time_whatever_the_evaluator() {
    let lamp = &lights()[0];
    for (detail, nodes) in [
        (Detail::Average, 8),
        (Detail::Voxels, 1),
        (Detail::Runs, 4),
        (Detail::Runs, 64),
    ] {
        let airlight = EquiAngular::new(nodes).unwrap();
        let of = [32, 128].map(|bits| turns(bits, detail, &airlight, lamp));
        assert!(of[0] < of[1] && of[1] < TURNS, "{of:?}");
        let all = blocks((0..1000).map(|light| (light, of[1])));
        assert!(all.iter().flatten().copied().eq(0..1000));
        for block in &all {
            assert!(block.len() as u32 * of[1] <= TURNS);
        }
        assert_eq!(all.len(), 1000_usize.div_ceil((TURNS / of[1]) as usize));
    }
    let most = |nodes| turns(128, Detail::Runs, &EquiAngular::new(nodes).unwrap(), lamp);
    assert!(most(479) <= 65_535 && most(480) > 65_535);
    // One that needs more than a block is in one of its own.
    let own = blocks([(0, 10), (1, most(4096)), (2, 10), (3, 20)]);
    assert_eq!(own, [vec![0], vec![1], vec![2, 3]]);
    assert!(blocks([]).is_empty());
}

/// Cookies of any size, quadratures of any tolerance and tables.
#[test]
fn other_evaluators_need_less_than_drivers_allow_for_a_light() {
    let cookie = |side: u32| {
        let texels = vec![Vec3::ONE; side as usize];
        let cookie = Texture::new(side, 1, texels).unwrap();
        let cone = Cone {
            inner: 0.1,
            outer: 0.5,
        };
        let spot = Emission::spot(Quat::IDENTITY, cone, Some(cookie)).unwrap();
        Emitter::point(Vec3::ZERO, Vec3::ONE, f32::INFINITY, spot).unwrap()
    };
    let lights = [lights().swap_remove(0), cookie(64), cookie(1 << 16)];
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.9 };
    for tolerance in [1e-2, 1e-6] {
        let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
        let of = |light| turns(128, Detail::Runs, &quadrature, light);
        let found = lights.each_ref().map(of);
        assert!(found.iter().all(|turns| *turns < 65_535), "{found:?}");
        assert!(found[1] < found[2]);
    }
}

#[test]
fn the_gpu_agrees_with_the_cpu_but_for_rays_at_an_edge() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let (lights, medium, rays) = (lights(), fog(), rays());
    let maps = maps(&lights);
    let mut here = LightVolumes::new(&cpu, resolution(), lights.len()).unwrap();
    here.update(&cpu, &lights, &eye(&medium), &maps).unwrap();
    let maps = maps.upload(&gpu).unwrap();
    let mut there = LightVolumes::new(&gpu, resolution(), lights.len()).unwrap();
    there.update(&gpu, &lights, &eye(&medium), &maps).unwrap();
    // With so many nodes there are two blocks of lights.
    let airlight = EquiAngular::new(64).unwrap();
    let rays_there = gpu.upload(&rays).unwrap();
    let all = (Detail::Runs, Interleaving::NONE);
    // Most rays by runs of 90 that share the lights, the others in full.
    let shared = (Detail::Runs, Interleaving::new(4, 90));
    let others = [Detail::Average, Detail::Voxels].map(|detail| (detail, Interleaving::NONE));
    for (detail, interleaving) in [all, shared].into_iter().chain(others) {
        let many = ManyLights {
            rays: &rays,
            emitters: &lights,
            medium: &medium,
            detail,
            interleaving,
        };
        let start = vec![[1.0, 2.0, 3.0, 4.0]; rays.len()];
        let mut expected = start.clone();
        cpu.gather_many(&many, &here, &airlight, &mut expected)
            .unwrap();
        let many = ManyLights {
            rays: &rays_there,
            emitters: &lights,
            medium: &medium,
            detail,
            interleaving,
        };
        let mut found = gpu.upload(&start).unwrap();
        gpu.gather_many(&many, &there, &airlight, &mut found)
            .unwrap();
        let found = gpu.download(&found).unwrap();
        let mut different = 0;
        for (e, f) in expected.iter().zip(&found) {
            assert_eq!(f[3], 4.0);
            let off = (0..3).any(|c| {
                // A light that is 30 times as far as it passes the ray is the worst.
                let allowed = Allowed::GpuRadiance.error()
                    + 30.0 * Allowed::GpuRadianceNearTheAxis.error()
                    + Allowed::GpuQuery.error();
                f64::from((e[c] - f[c]).abs()) > allowed * f64::from(e[c])
            });
            different += usize::from(off);
        }
        let share = different as f64 / rays.len() as f64;
        println!("{detail:?}: {different} of {} rays differ", rays.len());
        let allowed = Allowed::GpuRays.error() * lights.len() as f64;
        assert!(share <= allowed, "{detail:?}: {share}");
    }
}

#[test]
fn maps_rendered_there_give_nearly_the_same_indices() {
    let Some(gpu) = testing::gpu() else { return };
    let lights = lights();
    let casters = Casters::upload(&gpu, &super::tests::geometry()).unwrap();
    let found = gpu.shadow_map_atlas(&casters, &lights, 64).unwrap();
    let found = gpu.download(found.depth()).unwrap();
    let expected = maps(&lights);
    assert_eq!(found.len(), expected.depth().len());
    let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * a.min(b) || a == b;
    let pairs = expected.depth().iter().zip(&found);
    let different = pairs.filter(|(a, b)| !near(**a, **b)).count();
    // Texels on an edge, which are about 64 × 4 edges × 3 plates of each picture.
    assert!(
        different * 50 < found.len(),
        "{different} of {}",
        found.len()
    );
}

#[test]
fn surfaces_are_lit_as_on_the_cpu_but_for_points_at_an_edge() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let (lights, medium, points) = (lights(), fog(), floor());
    let maps = maps(&lights);
    let mut here = LightVolumes::new(&cpu, resolution(), lights.len()).unwrap();
    here.update(&cpu, &lights, &eye(&medium), &maps).unwrap();
    let maps = maps.upload(&gpu).unwrap();
    let mut there = LightVolumes::new(&gpu, resolution(), lights.len()).unwrap();
    there.update(&gpu, &lights, &eye(&medium), &maps).unwrap();
    let points_there = gpu.upload(&points).unwrap();
    let start = vec![[1.0, 2.0, 3.0, 4.0]; points.len()];
    for lookup in [SurfaceLookup::Nearest, SurfaceLookup::Interpolated] {
        let mut expected = start.clone();
        let lit = ManyOnSurfaces {
            points: &points,
            emitters: &lights,
            medium: &medium,
            lookup,
        };
        cpu.light_many_surfaces(&lit, &here, &mut expected).unwrap();
        let lit = ManyOnSurfaces {
            points: &points_there,
            emitters: &lights,
            medium: &medium,
            lookup,
        };
        let mut found = gpu.upload(&start).unwrap();
        gpu.light_many_surfaces(&lit, &there, &mut found).unwrap();
        let found = gpu.download(&found).unwrap();
        let mut different = 0;
        for (e, f) in expected.iter().zip(&found) {
            assert_eq!(f[3], 4.0);
            let allowed = Allowed::GpuRadiance.error() + Allowed::GpuQuery.error();
            let off = |c: usize| f64::from((e[c] - f[c]).abs()) > allowed * f64::from(e[c]);
            different += usize::from((0..3).any(off));
        }
        let share = different as f64 / points.len() as f64;
        println!("{lookup:?}: {different} of {} points differ", points.len());
        let allowed = Allowed::GpuRays.error() * lights.len() as f64;
        assert!(share <= allowed, "{lookup:?}: {share}");
    }
}

#[test]
fn the_shader_of_surfaces_is_valid_and_sees_points_as_they_are() {
    use crate::SurfacePoint;

    let shader = Shader::new(&super::gpu_surfaces::shader().unwrap().finish(1)).unwrap();
    assert_same_layout!(
        shader,
        "light_SurfacePoint",
        SurfacePoint {
            position,
            openness,
            normal,
            padding_a,
            response,
            padding_b
        }
    );
    // A search among bits, at most 1024.
    assert!(u32::ilog2(1024) < super::gpu_surfaces::TURNS_PER_LIGHT);
}
