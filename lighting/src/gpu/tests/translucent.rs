//! Marches through hair and smoke on the GPU against the CPU.

use glam::Vec3;
use gpu_backend::{Cpu, testing};
use transmittance::Stream;

use super::agreement::{allowed, gathered, without_borders};
use super::scenes::{casters, lights, media, rays};
use crate::airlight::{EquiAngular, Midpoint};
use crate::scene::{Geometry, Particle, Particles, Profile, StrandPoint, Strands, Translucent};
use crate::translucent::{Casters, TransmittanceMap};
use crate::visibility::{March, Spacing, Unshadowed};

/// What the transmittance of a sample may differ by in smoke.
///
/// With ε = 2^-24. A texel coordinate of a map of 128 is off by about 4 ε × 128 =
/// 3e-5, across which the transmittance of a bilinear map changes by at most as
/// much. A depth of up to 16 m is off by 4 ε of itself, 4e-6 m, times at most
/// 3 / m of extinction here: 1.2e-5. A lookup adds 2e-6.
const SMOKE: f32 = 5e-5;

/// Share of the rays that may differ by more because a sample is within rounding
/// of a step of transmittance.
///
/// A depth that is off by 4e-6 m falls to the other side of a surface for one in
/// 1e5 of the samples where surfaces are a metre apart, and a ray has 16 samples:
/// 2e-4. At the corner of a cube of maps it falls onto another face, whose border
/// is filtered by itself: as much again.
const STEPS: f32 = 4e-4;

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

fn compare(translucent: &[Translucent], geometry: Option<&Geometry>, share_of_rays: f32) {
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
                        (e - g).abs() <= scale * (SMOKE + allowed(ray, &light))
                    });
                    all += 1;
                    different += u32::from(!agrees);
                }
            }
        }
    }
    println!("{different} of {all} rays differ");
    assert!(
        different as f32 <= share_of_rays * all as f32,
        "{different} of {all}"
    );
}

#[test]
fn marches_through_the_same_smoke_agree() {
    compare(&[puffs()], None, STEPS);
}

#[test]
fn marches_through_hair_and_triangles_agree_but_for_samples_on_a_step() {
    compare(&[puffs(), hair()], Some(&casters()), STEPS);
    // Where nothing is in the way, what differs is midpoints next to a light.
    compare(&[], None, STEPS);
}
