//! The gather on a GPU against the CPU, which defines the result.

use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Cpu, Download, Error, testing};
use reference::tolerances::Allowed;

use super::scenes::{casters, lights, media, rays};
use crate::airlight::{EquiAngular, Midpoint};
use crate::scene::{Emission, Medium};
use crate::shadow_map::{Casters, RenderShadowMap};
use crate::visibility::{March, Spacing, Unshadowed};
use crate::{AirlightEvaluator, Emitter, Gather, Interleaving, LitRays, Ray, VisibilitySource};

pub(super) fn gathered<B, V, A>(
    backend: &B,
    rays: &[Ray],
    light: &Emitter,
    medium: &Medium,
    (visibility, airlight): (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let there = backend.upload(rays).unwrap();
    let lit = LitRays::new(&there, light, medium);
    gathered_of(backend, rays.len(), &lit, (visibility, airlight))
}

/// [`gathered`] behind what covers parts of the rays.
#[cfg(feature = "translucent")]
pub(super) fn gathered_behind<B, V, A>(
    backend: &B,
    (rays, panes): (&[Ray], Option<&crate::EyePanes>),
    light: &Emitter,
    medium: &Medium,
    pair: (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let there = backend.upload(rays).unwrap();
    let lit = LitRays {
        panes,
        ..LitRays::new(&there, light, medium)
    };
    gathered_of(backend, rays.len(), &lit, pair)
}

/// [`gathered`] with parts that touch joined.
pub(super) fn joined<B, V, A>(
    backend: &B,
    rays: &[Ray],
    light: &Emitter,
    medium: &Medium,
    pair: (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let there = backend.upload(rays).unwrap();
    let lit = LitRays::new(&there, light, medium).joined();
    gathered_of(backend, rays.len(), &lit, pair)
}

fn gathered_of<B, V, A>(
    backend: &B,
    count: usize,
    lit: &LitRays<'_, B::Memory>,
    (visibility, airlight): (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let before = vec![[0.0, 0.0, 0.0, 9.0]; count];
    let mut radiance = backend.upload(&before).unwrap();
    backend
        .gather(lit, visibility, airlight, &mut radiance)
        .unwrap();
    backend.download(&radiance).unwrap()
}

/// What a light that shines everywhere would give, which is what errors at the
/// border of a cone are measured by.
pub(super) fn without_borders(light: &Emitter) -> Emitter {
    match light {
        Emitter::Point(point) => Emitter::point(
            point.position(),
            point.intensity(),
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap(),
        sun => sun.clone(),
    }
}

/// The relative error that is allowed for a ray.
pub(super) fn allowed(ray: &Ray, light: &Emitter) -> f32 {
    let Emitter::Point(point) = light else {
        return error(Allowed::GpuRadiance);
    };
    let to_light = (point.position() - ray.origin()).as_dvec3();
    let h = to_light.cross(ray.direction().as_dvec3()).length();
    let ratio = (to_light.length() / h).min(1e4) as f32;
    error(Allowed::GpuRadiance) + ratio * error(Allowed::GpuRadianceNearTheAxis)
}

pub(super) fn error(allowed: Allowed) -> f32 {
    allowed.error() as f32
}

fn compare<V, A>(gpu: &Gpu<Queued>, name: &str, pair: (&V, &A), closest: f32)
where
    V: VisibilitySource,
    A: AirlightEvaluator,
    Gpu<Queued>: Gather<V, A>,
{
    let cpu = Cpu::new();
    let rays = rays(3000, closest);
    let reference = EquiAngular::new(8).unwrap();
    let mut worst = 0.0_f32;
    for (light_name, light) in lights() {
        for (medium_name, medium) in media() {
            let expected = gathered(&cpu, &rays, &light, &medium, pair);
            let actual = gathered(gpu, &rays, &light, &medium, pair);
            let everywhere = without_borders(&light);
            let scale = gathered(&cpu, &rays, &everywhere, &medium, (&Unshadowed, &reference));
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(actual[i][3], 9.0, "the fourth component is left alone");
                for c in 0..3 {
                    let (e, g) = (expected[i][c], actual[i][c]);
                    let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                    let ratio = (e - g).abs() / scale / allowed(ray, &light);
                    worst = worst.max(ratio);
                    assert!(
                        ratio <= 1.0,
                        "{name} {light_name} {medium_name}: {e} on the CPU, {g} on the GPU, \
                         {ratio} of the allowed error for {ray:?}"
                    );
                }
            }
        }
    }
    println!("{name}: {worst} of the allowed error");
}

#[test]
fn the_gpu_agrees_with_the_cpu_for_all_lights_media_and_pairs() {
    let Some(gpu) = testing::gpu() else { return };
    let quadrature = EquiAngular::new(8).unwrap();
    compare(&gpu, "quadrature", (&Unshadowed, &quadrature), 1e-4);
    compare(&gpu, "midpoint", (&Unshadowed, &Midpoint), 1e-4);
}

#[test]
fn marches_through_the_same_map_agree_but_for_samples_on_the_border_of_a_texel() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let quadrature = EquiAngular::new(2).unwrap();
    let rays = rays(4000, 1e-3);
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let map = cpu.shadow_map(&casters, &light, 256).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        for spacing in [Spacing::Distance, Spacing::EquiAngular, Spacing::Picture] {
            for (_, medium) in media() {
                let here = March::new(&map, 16, spacing);
                let there = March::new(&map_there, 16, spacing);
                let scale = {
                    let everywhere = without_borders(&light);
                    let pair = (&Unshadowed, &quadrature);
                    gathered(&cpu, &rays, &everywhere, &medium, pair)
                };
                let mut count = |weight: f32, [expected, actual]: [Vec<[f32; 4]>; 2]| {
                    for (i, ray) in rays.iter().enumerate() {
                        let agrees = (0..3).all(|c| {
                            let (e, g) = (expected[i][c], actual[i][c]);
                            let scale = (weight * scale[i][c]).max(e).max(f32::MIN_POSITIVE);
                            (e - g).abs() <= scale * allowed(ray, &light)
                        });
                        all += 1;
                        different += u32::from(!agrees);
                    }
                };
                let both = [
                    gathered(&cpu, &rays, &light, &medium, (&here, &Midpoint)),
                    gathered(&gpu, &rays, &light, &medium, (&there, &Midpoint)),
                ];
                count(1.0, both);
                let both = [
                    joined(&cpu, &rays, &light, &medium, (&here, &quadrature)),
                    joined(&gpu, &rays, &light, &medium, (&there, &quadrature)),
                ];
                count(1.0, both);
                // Most rays share the steps, by runs of 900.
                let shared = Interleaving::new(4, 900);
                let (here, there) = (here.interleaved(shared), there.interleaved(shared));
                let both = [
                    gathered(&cpu, &rays, &light, &medium, (&here, &Midpoint)),
                    gathered(&gpu, &rays, &light, &medium, (&there, &Midpoint)),
                ];
                count(4.0, both);
            }
        }
    }
    let share = different as f32 / all as f32;
    println!("{different} of {all} rays differ");
    assert!(
        share <= error(Allowed::GpuMarchRays),
        "{different} of {all} rays differ"
    );
}

#[cfg(feature = "voxel-shadow")]
#[test]
fn voxels_of_the_same_map_agree_but_for_those_on_the_border_of_another() {
    use crate::voxelized::{Detail, Eye, Resolution, Spacing, VoxelVolume, depth_range};
    use glam::Vec3;

    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let quadrature = EquiAngular::new(2).unwrap();
    // All from one eye.
    let position = Vec3::new(0.3, -0.2, 0.4);
    let rays: Vec<Ray> = rays(3000, 1e-3)
        .iter()
        .map(|ray| Ray::new(position, ray.direction(), ray.length()).unwrap())
        .collect();
    let resolution = Resolution::new(128, 128, 128).unwrap();
    let mut here = VoxelVolume::new(&cpu, resolution).unwrap();
    let mut there = VoxelVolume::new(&gpu, resolution).unwrap();
    let (mut all, mut different, mut shadowed) = (0, 0, 0);
    for (_, light) in lights() {
        let map = cpu.shadow_map(&casters, &light, 256).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        for (_, medium) in media() {
            let eye = Eye {
                position,
                corners: None,
                depths: depth_range(&rays, &medium),
                lamp_spacing: Spacing::Angle,
                sun_spacing: Spacing::Angle,
            };
            here.update(&cpu, &light, &eye, &map).unwrap();
            there.update(&gpu, &light, &eye, &map_there).unwrap();
            let scale = {
                let everywhere = without_borders(&light);
                let pair = (&Unshadowed, &quadrature);
                gathered(&cpu, &rays, &everywhere, &medium, pair)
            };
            let lit = gathered(&cpu, &rays, &light, &medium, (&Unshadowed, &quadrature));
            for detail in [Detail::Average, Detail::Voxels, Detail::Runs] {
                let (from, to) = (here.source(detail), there.source(detail));
                let expected = gathered(&cpu, &rays, &light, &medium, (&from, &quadrature));
                let actual = gathered(&gpu, &rays, &light, &medium, (&to, &quadrature));
                for i in 0..rays.len() {
                    let agrees = (0..3).all(|c| {
                        let (e, g) = (expected[i][c], actual[i][c]);
                        let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                        (e - g).abs() <= error(Allowed::GpuIntervals) * scale
                    });
                    all += 1;
                    different += u32::from(!agrees);
                    // By more than the evaluation of parts.
                    let darker = expected[i][0] < 0.99 * lit[i][0];
                    shadowed += u32::from(darker);
                }
            }
        }
    }
    assert!(50 * shadowed > all, "{shadowed} of {all} are in shadow");
    let share = different as f32 / all as f32;
    println!("{different} of {all} rays differ");
    assert!(
        share <= error(Allowed::GpuVoxelRays),
        "{different} of {all} rays differ"
    );
}

#[cfg(feature = "voxel-shadow")]
#[test]
fn volumes_that_need_no_voxels_are_all_lit_or_all_dark_on_the_gpu_too() {
    use crate::scene::{Cone, Emission};
    use crate::voxelized::{Detail, Eye, Resolution, Spacing, VoxelVolume};
    use crate::{Emitter, Interval};
    use glam::{Quat, Vec3};

    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let quadrature = EquiAngular::new(2).unwrap();
    let (_, medium) = media().swap_remove(0);
    let position = Vec3::new(0.3, -0.2, 0.4);
    let bulb = Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    let cone = Cone {
        inner: 0.2,
        outer: 0.3,
    };
    let away = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::X);
    let spot = Emission::spot(away, cone, None).unwrap();
    let aside = position + Vec3::new(3.0, 2.0, 0.0);
    let spot = Emitter::point(aside, Vec3::ONE, f32::INFINITY, spot).unwrap();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let eye = Eye {
        position,
        corners: Some(corners.map(|(y, z)| Vec3::new(-5.0, y, z))),
        depths: Interval::new(0.0, 9.0),
        lamp_spacing: Spacing::Angle,
        sun_spacing: Spacing::Angle,
    };
    // One that meets the cone, to see that the volume alone keeps it dark.
    let rays = [Vec3::new(-1.0, 0.1, 0.1), Vec3::new(1.0, 0.6, 0.0)]
        .map(|direction| Ray::new(position, direction, 9.0).unwrap());
    let resolution = Resolution::new(32, 32, 32).unwrap();
    for (light, is_lit) in [(bulb, true), (spot, false)] {
        let map = cpu.shadow_map(&casters, &light, 64).unwrap();
        let mut volume = VoxelVolume::new(&gpu, resolution).unwrap();
        let map = map.upload(&gpu).unwrap();
        volume.update(&gpu, &light, &eye, &map).unwrap();
        assert!(volume.lattice_in_use().is_none());
        for detail in [Detail::Average, Detail::Voxels, Detail::Runs] {
            let found = {
                let source = volume.source(detail);
                gathered(&gpu, &rays, &light, &medium, (&source, &quadrature))
            };
            if is_lit {
                let pair = (&Unshadowed, &quadrature);
                assert_eq!(found, gathered(&gpu, &rays, &light, &medium, pair));
            } else {
                assert!(found.iter().all(|sum| sum[..3] == [0.0; 3]), "{detail:?}");
            }
        }
    }
}

#[cfg(feature = "shadow-dag")]
#[test]
fn baked_shadows_agree_but_for_rays_on_the_border_of_voxels() {
    use crate::precomputed::{BakedShadow, Builder, Resolution};

    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let quadrature = EquiAngular::new(2).unwrap();
    let rays = rays(3000, 1e-3);
    let resolution = Resolution::new(256).unwrap();
    for (light_name, light) in lights() {
        let (baked, _) =
            BakedShadow::bake(&cpu, &casters(), &light, resolution, Builder::new()).unwrap();
        let (here, there) = (baked.upload(&cpu).unwrap(), baked.upload(&gpu).unwrap());
        assert!(there.bytes() > 0);
        let (mut all, mut different, mut shadowed) = (0, 0, 0);
        for (_, medium) in media() {
            let scale = {
                let everywhere = without_borders(&light);
                let pair = (&Unshadowed, &quadrature);
                gathered(&cpu, &rays, &everywhere, &medium, pair)
            };
            let lit = gathered(&cpu, &rays, &light, &medium, (&Unshadowed, &quadrature));
            // Shaders end a part where a grid ends.
            let expected = joined(&cpu, &rays, &light, &medium, (&here, &quadrature));
            let actual = joined(&gpu, &rays, &light, &medium, (&there, &quadrature));
            for i in 0..rays.len() {
                let agrees = (0..3).all(|c| {
                    let (e, g) = (expected[i][c], actual[i][c]);
                    let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                    (e - g).abs() <= error(Allowed::GpuIntervals) * scale
                });
                all += 1;
                different += u32::from(!agrees);
                shadowed += u32::from(expected[i] != lit[i]);
            }
        }
        let grids = baked.grids().len();
        println!("{light_name}, {grids} grids: {different} of {all} differ, {shadowed} in shadow");
        assert!(
            different as f32 <= error(Allowed::GpuBakedRays) * all as f32,
            "{light_name}: {different} of {all}"
        );
        assert!(
            shadowed > 100,
            "{light_name}: {shadowed} of {all} in shadow"
        );
    }
}

/// Precomputed shadows and a march through a map of the same casters: two sources of
/// different kinds in one shader.
#[cfg(feature = "shadow-dag")]
#[test]
fn two_sources_in_one_shader_are_the_product_of_both() {
    use crate::precomputed::{BakedShadow, Builder, Resolution};
    use crate::visibility::Both;

    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let quadrature = EquiAngular::new(2).unwrap();
    let rays = rays(1500, 1e-3);
    let resolution = Resolution::new(256).unwrap();
    let geometry = casters();
    let here = Casters::upload(&cpu, &geometry).unwrap();
    let (_, medium) = media().swap_remove(0);
    for (light_name, light) in lights() {
        let (baked, _) =
            BakedShadow::bake(&cpu, &geometry, &light, resolution, Builder::new()).unwrap();
        let map = cpu.shadow_map(&here, &light, 256).unwrap();
        let (baked_there, map_there) = (baked.upload(&gpu).unwrap(), map.upload(&gpu).unwrap());
        let march = March::new(&map, 16, Spacing::Distance);
        let march_there = March::new(&map_there, 16, Spacing::Distance);
        let everywhere = without_borders(&light);
        let pair = (&Unshadowed, &quadrature);
        let scale = gathered(&cpu, &rays, &everywhere, &medium, pair);
        let pair = (&Both(&baked, march), &quadrature);
        let expected = joined(&cpu, &rays, &light, &medium, pair);
        let pair = (&Both(&baked_there, march_there), &quadrature);
        let actual = joined(&gpu, &rays, &light, &medium, pair);
        let differs = |i: &usize| {
            (0..3).any(|c| {
                let (e, g) = (expected[*i][c], actual[*i][c]);
                let scale = scale[*i][c].max(e).max(f32::MIN_POSITIVE);
                (e - g).abs() > error(Allowed::GpuIntervals) * scale
            })
        };
        let different = (0..rays.len()).filter(differs).count();
        println!("{light_name}: {different} of {} differ", rays.len());
        let allowed = error(Allowed::GpuBakedRays) + error(Allowed::GpuMarchRays);
        assert!(
            different as f32 <= allowed * rays.len() as f32,
            "{light_name}: {different} of {}",
            rays.len()
        );
    }
}

#[test]
fn empty_bundles_and_wrong_lengths_are_handled_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let (_, light) = lights().swap_remove(0);
    let (_, medium) = media().swap_remove(0);
    let pair = (&Unshadowed, &Midpoint);
    assert!(gathered(&gpu, &[], &light, &medium, pair).is_empty());
    let buffer = gpu.upload(&rays(3, 1.0)).unwrap();
    let mut short = gpu.zeros::<[f32; 4]>(2).unwrap();
    let error = gpu
        .gather(
            &LitRays::new(&buffer, &light, &medium),
            pair.0,
            pair.1,
            &mut short,
        )
        .unwrap_err();
    assert!(matches!(
        error,
        Error::LengthMismatch {
            expected: 3,
            actual: 2,
            ..
        }
    ));
}
