//! Marches between shadow volumes on both backends.

use std::sync::Arc;

use gpu_backend::{Cpu, Download, testing};
use reference::tolerances::Allowed;

use super::agreement::{allowed, gathered, joined, without_borders};
use super::scenes::{casters, lights, media, rays};
use crate::airlight::EquiAngular;
use crate::methods::hybrid::{BuildLitVolumes, FilteredHybrid, Hybrid, ShadowVolumes, Spread};
use crate::methods::prefiltered::{MomentPyramid, Moments};
use crate::shadow_map::{Casters, RenderShadowMap};
use crate::visibility::Unshadowed;

/// With volumes and without, and both spreads of steps; rays that differ are few, and by little.
#[test]
fn hybrids_agree_but_for_lookups_on_the_border_of_a_texel() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let geometry = casters();
    let triangles = Casters::upload(&cpu, &geometry).unwrap();
    let quadrature = EquiAngular::new(2).unwrap();
    let rays = rays(4000, 1e-3);
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let map = cpu.shadow_map(&triangles, &light, 256).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        let volumes = ShadowVolumes::new(&cpu, &geometry, &light, 256).unwrap();
        let there = Arc::new(volumes.upload(&gpu).unwrap());
        let here = Arc::new(volumes);
        let light_here = Arc::new(cpu.lit_volumes(&map).unwrap());
        let light_there = Arc::new(gpu.lit_volumes(&map_there).unwrap());
        for (_, medium) in media() {
            let everywhere = without_borders(&light);
            let pair = (&Unshadowed, &quadrature);
            let scale = gathered(&cpu, &rays, &everywhere, &medium, pair);
            let both = (Some(here.clone()), Some(there.clone()));
            for (here, there, spread, has_light) in [
                (None, None, Spread::Ray, false),
                (both.0.clone(), both.1.clone(), Spread::Ray, false),
                (both.0.clone(), both.1.clone(), Spread::Span, false),
                (None, None, Spread::Span, true),
                (both.0, both.1, Spread::Span, true),
            ] {
                let mut here = Hybrid::new(&map, here, 16).unwrap().spread_over(spread);
                let there = Hybrid::new(&map_there, there, 16).unwrap();
                let mut there = there.spread_over(spread);
                if has_light {
                    here = here.with_lit_volumes(light_here.clone()).unwrap();
                    there = there.with_lit_volumes(light_there.clone()).unwrap();
                }
                let expected = joined(&cpu, &rays, &light, &medium, (&here, &quadrature));
                let actual = joined(&gpu, &rays, &light, &medium, (&there, &quadrature));
                for (i, ray) in rays.iter().enumerate() {
                    let agrees = (0..3).all(|c| {
                        let (e, g) = (expected[i][c], actual[i][c]);
                        let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                        (e - g).abs() <= scale * allowed(ray, &light)
                    });
                    all += 1;
                    different += u32::from(!agrees);
                }
            }
        }
    }
    let share = f64::from(different) / f64::from(all);
    println!("{share:.6} of {all} rays differ");
    assert!(share <= Allowed::GpuHybridRays.error(), "{share}");
}

/// With volumes of shadow and of light, and without any, through moments of the same map.
#[test]
fn marches_of_shares_agree_but_for_steps_of_the_length_of_a_texel() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let geometry = casters();
    let triangles = Casters::upload(&cpu, &geometry).unwrap();
    let quadrature = EquiAngular::new(2).unwrap();
    let rays = rays(2000, 1e-3);
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let map = cpu.shadow_map(&triangles, &light, 256).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        let bounds = geometry.bounds();
        let moments = Moments::Variance;
        let here = MomentPyramid::new(&cpu, &map, moments, &bounds, 0).unwrap();
        let there = MomentPyramid::new(&gpu, &map_there, moments, &bounds, 0).unwrap();
        let volumes = ShadowVolumes::new(&cpu, &geometry, &light, 256).unwrap();
        let volumes_there = Arc::new(volumes.upload(&gpu).unwrap());
        let volumes = Arc::new(volumes);
        let lit = Arc::new(cpu.lit_volumes(&map).unwrap());
        let lit_there = Arc::new(gpu.lit_volumes(&map_there).unwrap());
        for (_, medium) in media() {
            let everywhere = without_borders(&light);
            let pair = (&Unshadowed, &quadrature);
            let scale = gathered(&cpu, &rays, &everywhere, &medium, pair);
            for (has_shadow, has_light) in [(false, false), (true, false), (true, true)] {
                let shadow = has_shadow.then(|| volumes.clone());
                let light_here = has_light.then(|| lit.clone());
                let here = FilteredHybrid::new(&here, shadow, light_here, 16);
                let shadow = has_shadow.then(|| volumes_there.clone());
                let light_there = has_light.then(|| lit_there.clone());
                let there = FilteredHybrid::new(&there, shadow, light_there, 16);
                let (here, there) = (here.unwrap(), there.unwrap());
                let expected = joined(&cpu, &rays, &light, &medium, (&here, &quadrature));
                let actual = joined(&gpu, &rays, &light, &medium, (&there, &quadrature));
                for (i, ray) in rays.iter().enumerate() {
                    let agrees = (0..3).all(|c| {
                        let (e, g) = (expected[i][c], actual[i][c]);
                        let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                        (e - g).abs() <= 8.0 * scale * allowed(ray, &light)
                    });
                    all += 1;
                    different += u32::from(!agrees);
                }
            }
        }
    }
    let share = f64::from(different) / f64::from(all);
    println!("{share:.6} of {all} rays differ");
    assert!(share <= Allowed::GpuHybridRays.error(), "{share}");
}

/// But for the rounding of a few operations, for which volumes are wider: those of cubes,
/// too, whose cells are as far as what borders on them in other pictures.
#[test]
fn volumes_of_light_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let triangles = Casters::upload(&cpu, &casters()).unwrap();
    for (name, light) in lights() {
        for resolution in [3, 100, 256, 2100] {
            let map = cpu.shadow_map(&triangles, &light, resolution).unwrap();
            let map_there = map.upload(&gpu).unwrap();
            let expected = cpu.lit_volumes(&map).unwrap();
            let actual = gpu.lit_volumes(&map_there).unwrap();
            let actual = gpu.download(actual.far()).unwrap();
            assert_eq!(actual.len(), expected.far().len());
            let pairs = actual.iter().zip(expected.far());
            let different = pairs
                .filter(|(a, e)| (*a - *e).abs() > 1e-6 * e.abs())
                .count();
            // The middles of texels of a cube are on borders of others' where these are
            // as fine: one of a cell's many may be rounded to the other side.
            assert!(
                200 * different <= actual.len(),
                "{name} {resolution}: {different}"
            );
        }
    }
}
