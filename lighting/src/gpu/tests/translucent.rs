//! Marches through hair and smoke on the GPU against the CPU.

use glam::Vec3;
use gpu_backend::{Cpu, testing};
use reference::tolerances::Allowed;
use transmittance::Stream;

use super::agreement::{allowed, error, gathered, without_borders};
use super::scenes::{casters, lights, media, rays};
use crate::airlight::{EquiAngular, Midpoint};
use crate::scene::{Geometry, Particle, Particles, Profile, StrandPoint, Strands, Translucent};
use crate::translucent::{Casters, TransmittanceMap};
use crate::visibility::{March, Spacing, Unshadowed};

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
    let (mut all, mut different) = (0, 0);
    for (_, light) in lights() {
        let clear = Stream::<8>::new();
        let map = TransmittanceMap::build(&cpu, &casters, &light, 128, &clear).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        for spacing in [Spacing::Distance, Spacing::EquiAngular] {
            let here = March::new(&map, 16, spacing);
            let there = March::new(&map_there, 16, spacing);
            for (_, medium) in media() {
                let everywhere = without_borders(&light);
                let pair = (&Unshadowed, &reference);
                let scale = gathered(&cpu, &rays, &everywhere, &medium, pair);
                let expected = gathered(&cpu, &rays, &light, &medium, (&here, &Midpoint));
                let actual = gathered(&gpu, &rays, &light, &medium, (&there, &Midpoint));
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
    // Where nothing is in the way, what differs is midpoints next to a light.
    compare(&[], None);
}
