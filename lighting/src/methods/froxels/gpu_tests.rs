//! The shaders of froxels without a device, and against the CPU with one.

use gpu_backend::gpu::{Gpu, GpuMemory, InShader, Queued};
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, assert_same_layout};
use reference::tolerances::Allowed;

use super::gpu::{
    BLEND, Blend, GridRecord, INTEGRATE, Injection, Integration, LOOK_UP, LookUp, injection,
};
use super::tests::{SIZE, camera, fog, lights, maps, rays_of};
use super::*;
use crate::gpu::PointSlot;
use crate::methods::prefiltered::PrefilteredMap;
use crate::scene::{Bounds, Camera, Medium};
use crate::shadow_map::ShadowMap;
use crate::visibility::Unshadowed;
use crate::{Emitter, Interval, Ray};

/// The shader that asks `P`, which must be valid and keep to WebGPU's eight storage
/// buffers, of which froxels have two.
fn complete<P: InShader<PointSlot>>() -> Shader {
    let assembly = injection::<P>().unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = 2 + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    Shader::new(&assembly.finish(1)).unwrap()
}

#[test]
fn shaders_are_valid_and_see_froxels_as_they_are() {
    complete::<Unshadowed>();
    complete::<PrefilteredMap<GpuMemory>>();
    let shader = complete::<ShadowMap<GpuMemory>>();
    assert_same_layout!(
        shader,
        "light_Froxels",
        GridRecord {
            eye,
            near,
            right,
            far,
            up,
            tile,
            forward,
            slices,
            middle,
            columns,
            rows
        }
    );
    assert_same_layout!(
        shader,
        "Injection",
        Injection {
            grid,
            emitter,
            medium,
            jitter,
            adds,
            extinction,
            padding_a,
            padding_b,
            padding_c
        }
    );
    let shader = Shader::new(&BLEND).unwrap();
    assert_same_layout!(
        shader,
        "Blend",
        Blend {
            grid,
            before,
            share,
            is_same,
            padding_a,
            padding_b
        }
    );
    let shader = Shader::new(&INTEGRATE).unwrap();
    assert_same_layout!(shader, "Integration", Integration { grid, medium });
    let shader = Shader::new(&LOOK_UP).unwrap();
    assert_same_layout!(
        shader,
        "LookUp",
        LookUp {
            grid,
            rays,
            padding_a,
            padding_b,
            padding_c
        }
    );
}

/// A picture by two frames of a camera that moves, each with all lights.
fn moving<B, P>(
    backend: &B,
    medium: &Medium,
    lights: &[(&Emitter, P)],
    rays: &[Ray],
    grids: [FroxelGrid; 2],
) -> Vec<[f32; 4]>
where
    B: InjectFroxels<P> + FroxelSteps + Download,
{
    let mut history = FroxelHistory::new(0.9).unwrap();
    let mut airlight = FroxelAirlight::new(backend, grids[0]).unwrap();
    let rays = backend.upload(rays).unwrap();
    let start = vec![[1.0, 2.0, 3.0, 4.0]; gpu_backend::Buffer::len(&rays)];
    let mut radiance = backend.upload(&start).unwrap();
    for grid in grids {
        let mut volume = history.begin(backend, grid).unwrap();
        for (emitter, points) in lights {
            let light = FroxelLight {
                emitter,
                medium,
                extinction: true,
            };
            backend.inject(&light, points, &mut volume).unwrap();
        }
        let volume = history.finish(backend, volume).unwrap();
        backend.integrate(medium, volume, &mut airlight).unwrap();
    }
    backend.look_up(&airlight, &rays, &mut radiance).unwrap();
    backend.download(&radiance).unwrap()
}

/// Rays that differ by more than may be, and all that there are.
fn compare(expected: &[[f32; 4]], found: &[[f32; 4]]) -> [usize; 2] {
    let brightest = expected
        .iter()
        .flat_map(|p| &p[..3])
        .copied()
        .fold(0.0, f32::max);
    let mut different = 0;
    for (e, f) in expected.iter().zip(found) {
        assert_eq!(f[3], 4.0);
        let off = (0..3).any(|c| {
            f64::from((e[c] - f[c]).abs()) > Allowed::GpuFroxels.error() * f64::from(brightest)
        });
        different += usize::from(off);
    }
    [different, expected.len()]
}

fn grids(
    cameras: [&Camera; 2],
    rays: &[Ray],
    medium: &Medium,
    lights: &[Emitter],
) -> [FroxelGrid; 2] {
    cameras.map(|camera| {
        let depths = lit_depths(camera.eye(), rays, medium, lights);
        let depths = Interval::new(depths.start, depths.end.min(40.0));
        FroxelGrid::new(camera, SIZE, 2, 24, depths).unwrap()
    })
}

#[test]
fn the_gpu_agrees_with_the_cpu_but_for_rays_at_an_edge() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let (camera, lights) = (camera(), lights());
    let eye = camera.eye() - glam::Vec3::X * 0.5;
    let before = Camera::new(eye, camera.rotation(), camera.vertical_fov()).unwrap();
    let rays = rays_of(&camera, SIZE);
    let bank = Bounds::new([-4.0, -2.0, -9.0], [5.0, 6.0, -2.0]).unwrap();
    for medium in [fog(), fog().within(bank)] {
        for cameras in [[&before, &camera], [&camera, &camera]] {
            let grids = grids(cameras, &rays, &medium, &lights);
            // Without shadows every ray.
            let bare: Vec<_> = lights.iter().map(|light| (light, Unshadowed)).collect();
            let expected = moving(&cpu, &medium, &bare, &rays, grids);
            let found = moving(&gpu, &medium, &bare, &rays, grids);
            assert_eq!(compare(&expected, &found)[0], 0, "{:?}", medium.bounds());
            assert!(expected.iter().any(|p| p[0] > 1.001));
            // With the same maps all but a few.
            let maps = maps(&lights, 128);
            let there: Vec<_> = maps.iter().map(|map| map.upload(&gpu).unwrap()).collect();
            let here: Vec<_> = lights.iter().zip(&maps).collect();
            let expected = moving(&cpu, &medium, &here, &rays, grids);
            let there: Vec<_> = lights.iter().zip(&there).collect();
            let found = moving(&gpu, &medium, &there, &rays, grids);
            let [different, all] = compare(&expected, &found);
            println!("{different} of {all} rays differ");
            let allowed = Allowed::GpuFroxelRays.error() * lights.len() as f64;
            assert!(
                different as f64 <= allowed * all as f64,
                "{different} of {all}"
            );
        }
    }
}

#[test]
fn a_frame_without_lights_is_dark_there_too() {
    let Some(gpu) = testing::gpu() else { return };
    let camera = camera();
    let rays = rays_of(&camera, SIZE);
    let lights = lights();
    let [grid, _] = grids([&camera; 2], &rays, &fog(), &lights);
    let mut volume = FroxelVolume::new(&gpu, grid, Jitter::MIDDLE).unwrap();
    let light = FroxelLight {
        emitter: &lights[0],
        medium: &fog(),
        extinction: true,
    };
    gpu.inject(&light, &Unshadowed, &mut volume).unwrap();
    let mut dark = volume.again(&gpu, grid, Jitter::MIDDLE).unwrap();
    let mut airlight = FroxelAirlight::new(&gpu, grid).unwrap();
    gpu.integrate(&fog(), &mut dark, &mut airlight).unwrap();
    let all = gpu.download(airlight.radiance()).unwrap();
    assert!(all.iter().all(|froxel| froxel[..3] == [0.0; 3]));
}

/// Steps take what others left on the device, and read nothing back.
#[test]
fn frames_record_into_an_encoder_of_the_users() {
    let Some(queued) = testing::gpu() else { return };
    let queued: &Gpu<Queued> = &queued;
    let context = queued.context();
    let camera = camera();
    let rays = rays_of(&camera, SIZE);
    let (medium, lights) = (fog(), lights());
    let [grid, _] = grids([&camera; 2], &rays, &medium, &lights);
    let light = FroxelLight {
        emitter: &lights[0],
        medium: &medium,
        extinction: true,
    };
    let bare = [(&lights[0], Unshadowed)];
    let expected = moving(queued, &medium, &bare, &rays, [grid, grid]);
    let mut encoder = context.device().create_command_encoder(&Default::default());
    let radiance = {
        let recording = Gpu::record(context, &mut encoder);
        let mut history = FroxelHistory::new(0.9).unwrap();
        let mut airlight = FroxelAirlight::new(&recording, grid).unwrap();
        let there = recording.upload(&rays).unwrap();
        let mut radiance = recording
            .upload(&vec![[1.0, 2.0, 3.0, 4.0]; rays.len()])
            .unwrap();
        for _ in 0..2 {
            let mut volume = history.begin(&recording, grid).unwrap();
            recording.inject(&light, &Unshadowed, &mut volume).unwrap();
            let volume = history.finish(&recording, volume).unwrap();
            recording.integrate(&medium, volume, &mut airlight).unwrap();
        }
        recording.look_up(&airlight, &there, &mut radiance).unwrap();
        radiance
    };
    context.queue().submit([encoder.finish()]);
    assert_eq!(queued.download(&radiance).unwrap(), expected);
}
