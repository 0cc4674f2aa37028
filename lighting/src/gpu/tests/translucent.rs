//! Marches through hair and smoke on the GPU against the CPU.

use glam::Vec3;
use gpu_backend::{Cpu, testing};
use reference::tolerances::Allowed;
use transmittance::Stream;

use super::agreement::{allowed, error, gathered, gathered_behind, without_borders};
use super::scenes::{casters, glass_casters, lights, media, rays};
use crate::EyePanes;
use crate::airlight::{EquiAngular, Midpoint};
use crate::scene::trace::Tracer;
use crate::scene::{Geometry, Particle, Particles, Profile, StrandPoint, Strands, Translucent};
use crate::shadow_map::{self, RenderShadowMap};
use crate::translucent::{Casters, TransmittanceMap};
use crate::visibility::{Both, March, Spacing, Unshadowed};

fn puffs() -> Translucent {
    let puff = |i: u32| {
        let share = |step: f32| (i as f32 * step).fract() - 0.5;
        Particle {
            centre: Vec3::new(
                6.0 * share(0.618),
                3.0 * share(0.414),
                8.0 * share(0.732) - 3.0,
            ),
            radius: 0.4 + 0.4 * share(0.236),
            sigma_t: 1.5 + 3.0 * share(0.317),
        }
    };
    let all = (0..60).map(puff).collect();
    Particles::new(all, Profile::Soft).unwrap().into()
}

fn hair() -> Translucent {
    let mut points = Vec::new();
    for strand in 0..40 {
        for i in 0..6 {
            let (x, y) = (0.15 * strand as f32 - 3.0, 0.4 * i as f32 - 1.0);
            points.push(StrandPoint {
                position: Vec3::new(x, y, -3.0 + 0.2 * (x + y).sin()),
                thickness: 0.04,
                opacity: 0.7,
            });
        }
    }
    let ends = (1..=40).map(|strand| 6 * strand).collect();
    Strands::new(points, ends).unwrap().into()
}

fn compare(translucent: &[Translucent], geometry: Option<&Geometry>) {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let casters = Casters::new(translucent, geometry);
    let reference = EquiAngular::new(2).unwrap();
    let rays = rays(2000, 1e-3);
    let tracer = geometry.map(Tracer::new);
    let panes = tracer.and_then(|tracer| EyePanes::new(&cpu, &tracer, &rays));
    let seen = (&rays[..], panes.as_ref());
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let clear = Stream::<8>::new();
        let map: TransmittanceMap =
            TransmittanceMap::build(&cpu, &casters, &light, 128, &clear).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        for spacing in [Spacing::Distance, Spacing::EquiAngular] {
            let here = March::new(&map, 16, spacing);
            let there = March::new(&map_there, 16, spacing);
            for (_, medium) in media() {
                let everywhere = without_borders(&light);
                let pair = (&Unshadowed, &reference);
                let scale = gathered(&cpu, &rays, &everywhere, &medium, pair);
                let expected = gathered_behind(&cpu, seen, &light, &medium, (&here, &Midpoint));
                let actual = gathered_behind(&gpu, seen, &light, &medium, (&there, &Midpoint));
                let clear = gathered(&cpu, &rays, &everywhere, &medium, (&Unshadowed, &Midpoint));
                for (i, ray) in rays.iter().enumerate() {
                    let agrees = (0..3).all(|c| {
                        let (e, g) = (expected[i][c], actual[i][c]);
                        // A march by midpoints may give more than there is.
                        let scale = scale[i][c].max(clear[i][c]).max(e).max(f32::MIN_POSITIVE);
                        (e - g).abs() <= scale * (error(Allowed::GpuSmoke) + allowed(ray, &light))
                    });
                    all += 1;
                    different += u32::from(!agrees);
                }
            }
        }
    }
    println!("{different} of {all} rays differ");
    assert!(
        different as f32 <= error(Allowed::GpuSmokeRays) * all as f32,
        "{different} of {all}"
    );
}

#[test]
fn marches_through_the_same_smoke_agree() {
    compare(&[puffs()], None);
}

#[test]
fn marches_through_hair_and_triangles_agree_but_for_samples_on_a_step() {
    compare(&[puffs(), hair()], Some(&casters()));
    compare(&[puffs()], Some(&glass_casters()));
    // Where nothing is in the way, what differs is midpoints next to a light.
    compare(&[], None);
}

/// Shadow maps of what is opaque, maps of transmittance of what is not.
#[test]
fn marches_through_a_shadow_map_and_a_map_of_transmittance_at_once_agree() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let (geometry, rays) = (glass_casters(), rays(1000, 1e-2));
    let solid = shadow_map::Casters::upload(&cpu, &geometry).unwrap();
    let casters = Casters::see_through(&[], &geometry);
    let panes = EyePanes::new(&cpu, &Tracer::new(&geometry), &rays);
    let seen = (&rays[..], panes.as_ref());
    let nodes = EquiAngular::new(1).unwrap();
    let (_, medium) = media().swap_remove(0);
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let shadows = cpu.shadow_map(&solid, &light, 128).unwrap();
        let clear = Stream::<8>::new();
        let map: TransmittanceMap =
            TransmittanceMap::build(&cpu, &casters, &light, 64, &clear).unwrap();
        let shadows_there = shadows.upload(&gpu).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        let here = March::new(Both(&shadows, &map), 16, Spacing::EquiAngular);
        let there = March::new(Both(&shadows_there, &map_there), 16, Spacing::EquiAngular);
        let everywhere = without_borders(&light);
        let scale = gathered(&cpu, &rays, &everywhere, &medium, (&Unshadowed, &nodes));
        let expected = gathered_behind(&cpu, seen, &light, &medium, (&here, &nodes));
        let actual = gathered_behind(&gpu, seen, &light, &medium, (&there, &nodes));
        for (i, ray) in rays.iter().enumerate() {
            let agrees = (0..3).all(|c| {
                let (e, g) = (expected[i][c], actual[i][c]);
                let scale = scale[i][c].max(e).max(f32::MIN_POSITIVE);
                (e - g).abs() <= scale * (error(Allowed::GpuSmoke) + allowed(ray, &light))
            });
            all += 1;
            different += u32::from(!agrees);
        }
        // Colours differ somewhere.
        assert!(expected.iter().any(|light| light[0] > 1.05 * light[2]));
    }
    println!("{different} of {all} rays differ");
    assert!(different as f32 <= error(Allowed::GpuSmokeRays) * all as f32);
}
