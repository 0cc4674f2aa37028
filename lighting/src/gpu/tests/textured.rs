//! Textured spotlights on both backends.

use std::sync::Arc;

use glam::Vec3;
use gpu_backend::gpu::GpuMemory;
use gpu_backend::{Cpu, Host, assert_same_layout, testing};
use reference::tolerances::Allowed;

use super::agreement::{allowed, gathered, without_borders};
use super::complete;
use super::scenes::{casters, lights, media, rays};
use crate::airlight::{Analytic, Daylight, EquiAngular, Midpoint, PerFrame, Quadrature};
use crate::methods::hybrid::ShadowVolumes;
use crate::methods::textured::gpu::{CONSTANTS, StepsRecord, TexturedRecord};
use crate::methods::textured::{MipCookie, Outside, Placement, ShadowSpans, Textured, bare};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use crate::visibility::Unshadowed;
use crate::{AirlightEvaluator, Emitter, Gather, Ray};

type OnGpu = Textured<ShadowSpans<Arc<ShadowMap<GpuMemory>>, GpuMemory>, GpuMemory>;

#[test]
fn textured_lights_compile_with_every_evaluator_and_see_their_data_as_it_is() {
    complete::<OnGpu, Midpoint>();
    complete::<OnGpu, Quadrature>();
    complete::<OnGpu, Analytic<airlight::Table>>();
    complete::<OnGpu, PerFrame>();
    complete::<OnGpu, Daylight>();
    complete::<Textured<Unshadowed, GpuMemory>, Midpoint>();
    complete::<ShadowSpans<Arc<ShadowMap<GpuMemory>>, GpuMemory>, Midpoint>();
    let shader = complete::<OnGpu, EquiAngular>();
    assert_same_layout!(
        shader,
        "light_Steps",
        StepsRecord {
            axis,
            placement,
            count,
            turn,
            length,
            stretch
        }
    );
    assert_same_layout!(
        shader,
        "light_Textured",
        TexturedRecord {
            axis,
            outer_versine,
            right,
            rim,
            up,
            tan_outer,
            range,
            fades,
            is_spot,
            is_open,
            finer,
            level_count,
            padding,
            steps,
            levels
        }
    );
    for (name, value) in CONSTANTS {
        let found = shader.values(name).unwrap();
        assert_eq!(found.len(), 1);
        let off = (found[0] - value).abs();
        assert!(off <= 1e-6 * value, "{name}: {found:?}");
    }
}

fn cookie(light: &Emitter) -> Option<MipCookie<Host>> {
    light.spot()?.texture().map(MipCookie::new)
}

/// Rays that differ are few: those of which a lookup is on the border of a texel.
fn share_of_rays_that_differ<A>(placement: Placement, outside: Outside, airlight: &A) -> f64
where
    A: AirlightEvaluator,
    gpu_backend::gpu::Gpu<gpu_backend::gpu::Queued>: Gather<OnGpu, A>,
{
    let Some(gpu) = testing::gpu() else {
        return 0.0;
    };
    let cpu = Cpu::new();
    let geometry = casters();
    let triangles = Casters::upload(&cpu, &geometry).unwrap();
    let rays = rays(3000, 1e-3);
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let map = Arc::new(cpu.shadow_map(&triangles, &light, 256).unwrap());
        let map_there = Arc::new(map.upload(&gpu).unwrap());
        let volumes = ShadowVolumes::new(&cpu, &geometry, &light, 256).unwrap();
        let volumes_there = Some(Arc::new(volumes.upload(&gpu).unwrap()));
        let volumes = Some(Arc::new(volumes));
        let cookie = cookie(&light).map(Arc::new);
        let cookie_there = cookie.as_ref().map(|c| Arc::new(c.upload(&gpu).unwrap()));
        // The brightest texel.
        let brightest = if cookie.is_some() { 34.0 } else { 1.0 };
        let spans = ShadowSpans::new(map, volumes, &light, 16, placement).unwrap();
        let here = Textured::new(spans, &light, cookie, 8, placement).with_outside(outside);
        let spans = ShadowSpans::new(map_there, volumes_there, &light, 16, placement).unwrap();
        let there = Textured::new(spans, &light, cookie_there, 8, placement);
        let there = there.with_outside(outside);
        let bare = bare(&light);
        for (_, medium) in media() {
            let everywhere = without_borders(&light);
            let scale = gathered(&cpu, &rays, &everywhere, &medium, (&Unshadowed, airlight));
            let expected = gathered(&cpu, &rays, &bare, &medium, (&here, airlight));
            let actual = gathered(&gpu, &rays, &bare, &medium, (&there, airlight));
            for (i, ray) in rays.iter().enumerate() {
                let agrees = (0..3).all(|c| {
                    let (e, g) = (expected[i][c], actual[i][c]);
                    let scale = (brightest * scale[i][c]).max(e).max(f32::MIN_POSITIVE);
                    (e - g).abs() <= scale * allowed(ray, &light)
                });
                all += 1;
                different += u32::from(!agrees);
            }
        }
    }
    f64::from(different) / f64::from(all)
}

#[test]
fn textured_lights_agree_but_for_few_rays() {
    let share = share_of_rays_that_differ(
        Placement::Angle,
        Outside::Dark,
        &EquiAngular::new(2).unwrap(),
    );
    println!("{share:.6} of rays differ");
    assert!(share <= Allowed::GpuHybridRays.error(), "{share}");
}

#[test]
fn other_steps_and_light_outside_of_the_cone_agree_too() {
    let airlight = EquiAngular::new(2).unwrap();
    for placement in [Placement::Length { reach: 12.0 }, Placement::Span] {
        let share = share_of_rays_that_differ(placement, Outside::Lit, &airlight);
        println!("{placement:?}: {share:.6} of rays differ");
        assert!(share <= Allowed::GpuHybridRays.error(), "{share}");
    }
}

/// A step before the light and one behind it. A ray through the light but for roundings is
/// moved off it to a side that the roundings decide, which differ between the backends. In a
/// plain cone no side differs from another; the colours of a cookie do, at the rim, where
/// the moved ray meets the light.
#[test]
fn rays_through_the_light_agree() {
    let Some(gpu) = testing::gpu() else {
        return;
    };
    let cpu = Cpu::new();
    let airlight = EquiAngular::new(2).unwrap();
    for (name, light) in lights() {
        let Emitter::Point(point) = &light else {
            continue;
        };
        let axis = light.spot().map_or(Vec3::NEG_Y, |spot| spot.axis());
        let rays: Vec<Ray> = [-3.0, -0.5, 0.0, 0.5, 2.0]
            .into_iter()
            .flat_map(|eye| [1.0, -1.0].map(|towards| (eye, towards * axis)))
            .map(|(eye, aim)| Ray::new(point.position() + eye * axis, aim, 5.0).unwrap())
            .collect();
        let cookie = cookie(&light).map(Arc::new);
        let allowed = if cookie.is_some() { 0.1 } else { 0.03 };
        let cookie_there = cookie.as_ref().map(|c| Arc::new(c.upload(&gpu).unwrap()));
        let here = Textured::new(Unshadowed, &light, cookie, 50, Placement::Angle);
        let there = Textured::new(Unshadowed, &light, cookie_there, 50, Placement::Angle);
        let bare = bare(&light);
        for (_, medium) in media() {
            let scale = gathered(&cpu, &rays, &bare, &medium, (&Unshadowed, &airlight));
            let expected = gathered(&cpu, &rays, &bare, &medium, (&here, &airlight));
            let actual = gathered(&gpu, &rays, &bare, &medium, (&there, &airlight));
            for i in 0..rays.len() {
                for c in 0..3 {
                    let (e, g) = (expected[i][c], actual[i][c]);
                    let scale = scale[i][c].max(e);
                    assert!((e - g).abs() <= allowed * scale, "{name} {i}: {e} {g}");
                }
            }
        }
    }
}

#[test]
fn daylight_agrees() {
    let airlight = Daylight::new(4.0).unwrap();
    let share = share_of_rays_that_differ(Placement::Angle, Outside::Dark, &airlight);
    println!("{share:.6} of rays differ");
    assert!(share <= Allowed::GpuHybridRays.error(), "{share}");
}
