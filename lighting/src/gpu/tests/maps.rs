//! Shadow maps of the GPU against those of the CPU, and whole pictures.

use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Buffer, Cpu, Download, Memory, testing};
use reference::tolerances::Allowed;

use super::scenes::{casters, lights, masked_casters, media, rays};
use crate::airlight::EquiAngular;
use crate::scene::{Geometry, Medium};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap, ShadowMapError};
use crate::visibility::{March, Spacing};
use crate::{Emitter, Gather, LitRays, Ray};

/// How many texels of a map may hold another triangle than on the CPU, out of
/// its pairs of neighbours of different depth.
fn on_an_edge(depth: &[f32], resolution: u32) -> usize {
    let side = resolution as usize;
    let differ = |a: f32, b: f32| (a - b).abs() > 0.01 * a;
    let edges = (0..depth.len())
        .map(|i| {
            let right = i % side + 1 < side && differ(depth[i], depth[i + 1]);
            let below = i / side % side + 1 < side && differ(depth[i], depth[i + side]);
            usize::from(right) + usize::from(below)
        })
        .sum::<usize>();
    // Triangles smaller than a texel have edges that no pair shows.
    1 + (Allowed::GpuSoupEdgeTexels.error() * edges as f64) as usize
}

#[test]
fn shadow_maps_of_both_backends_agree_but_for_texels_on_an_edge() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    for geometry in [casters(), masked_casters()] {
        agree(&cpu, &gpu, &geometry);
    }
}

fn agree(cpu: &Cpu, gpu: &Gpu<Queued>, geometry: &Geometry) {
    let here = Casters::upload(cpu, geometry).unwrap();
    let there = Casters::upload(gpu, geometry).unwrap();
    for (name, light) in lights() {
        let mut resolutions = vec![1, 7, 64, 200];
        if let Emitter::Directional(_) = light {
            // Four tiles.
            resolutions.push(2050);
        }
        for resolution in resolutions {
            let expected = cpu.shadow_map(&here, &light, resolution).unwrap();
            let actual = gpu.shadow_map(&there, &light, resolution).unwrap();
            assert_eq!(actual.faces(), expected.faces());
            assert_eq!(actual.resolution(), resolution);
            let expected = expected.depth();
            let actual = gpu.download(actual.depth()).unwrap();
            let others = (expected.iter().zip(&actual))
                .filter(|(e, g)| !((*e - *g).abs() <= Allowed::GpuSoupTexel.error() as f32 * **e))
                .count();
            let allowed = on_an_edge(expected, resolution);
            assert!(
                others <= allowed,
                "{name} {resolution}: {others} texels differ, expected at most {allowed}"
            );
        }
    }
}

#[test]
fn senseless_maps_are_refused_on_the_gpu_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let casters = Casters::upload(&gpu, &casters()).unwrap();
    let (_, point) = lights().swap_remove(0);
    for resolution in [0, 65537, u32::MAX] {
        assert_eq!(
            gpu.shadow_map(&casters, &point, resolution).unwrap_err(),
            ShadowMapError::Resolution { resolution }
        );
    }
    let error = gpu.shadow_map(&casters, &point, 65536).unwrap_err();
    assert!(error.to_string().contains("limit"), "{error}");
}

/// Casters to picture, for any backend.
fn picture<B, M>(
    backend: &B,
    rays: &M::Buffer<Ray>,
    light: &Emitter,
    medium: &Medium,
) -> M::Buffer<[f32; 4]>
where
    M: Memory,
    B: RenderShadowMap<Memory = M> + for<'a> Gather<March<&'a ShadowMap<M>>, EquiAngular>,
{
    let casters = Casters::upload(backend, &casters()).unwrap();
    let map = backend.shadow_map(&casters, light, 128).unwrap();
    let mut radiance = backend.zeros(rays.len()).unwrap();
    let march = March::new(&map, 8, Spacing::EquiAngular);
    let quadrature = EquiAngular::new(2).unwrap();
    backend
        .gather(
            &LitRays::new(rays, light, medium),
            &march,
            &quadrature,
            &mut radiance,
        )
        .unwrap();
    radiance
}

#[test]
fn a_whole_picture_is_one_read_back_and_the_same_when_the_caller_records_it() {
    let Some(gpu) = testing::gpu() else { return };
    let rays = gpu.upload(&rays(300, 0.1)).unwrap();
    let (_, light) = lights().swap_remove(0);
    let (_, medium) = media().swap_remove(0);
    let queued = picture(&gpu, &rays, &light, &medium);
    assert_eq!(gpu.statistics().submits, 0);
    let queued = gpu.download(&queued).unwrap();
    assert_eq!(
        (gpu.statistics().submits, gpu.statistics().read_backs),
        (1, 1)
    );
    assert!(queued.iter().any(|radiance| radiance[0] > 0.0));

    let context = gpu.context();
    let mut encoder = context
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recorded = picture(&Gpu::record(context, &mut encoder), &rays, &light, &medium);
    context.queue().submit([encoder.finish()]);
    assert_eq!(gpu.download(&recorded).unwrap(), queued);
}
