//! Marches between shadow volumes on both backends.

use std::sync::Arc;

use gpu_backend::{Cpu, testing};
use reference::tolerances::Allowed;

use super::agreement::{allowed, gathered, joined, without_borders};
use super::scenes::{casters, lights, media, rays};
use crate::airlight::EquiAngular;
use crate::methods::hybrid::{Hybrid, ShadowVolumes};
use crate::shadow_map::{Casters, RenderShadowMap};
use crate::visibility::Unshadowed;

/// With volumes and without; rays that differ are few, and by little.
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
        for (_, medium) in media() {
            let everywhere = without_borders(&light);
            let pair = (&Unshadowed, &quadrature);
            let scale = gathered(&cpu, &rays, &everywhere, &medium, pair);
            for (here, there) in [(None, None), (Some(here.clone()), Some(there.clone()))] {
                let here = Hybrid::new(&map, here, 16).unwrap();
                let there = Hybrid::new(&map_there, there, 16).unwrap();
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
