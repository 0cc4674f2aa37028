use glam::{Quat, Vec3};
use gpu_backend::{Cpu, Host};
use reference::random::noise;

use crate::airlight::EquiAngular;
use crate::methods::epipolar::MapRuns;
use crate::scene::{Bounds, Cone, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use crate::visibility::{March, Spacing, Unshadowed};
use crate::{Emitter, Gather, LightPath, LitRays, Ray, VisibilitySource};

/// Half the angle of the beam, which shines down from the origin.
const OUTER: f32 = 0.45;

fn spot() -> Emitter {
    let cone = Cone {
        inner: 0.0,
        outer: OUTER,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let emission = Emission::spot(down, cone, None).unwrap();
    Emitter::point(Vec3::ZERO, Vec3::ONE, 8.0, emission).unwrap()
}

fn fog() -> Medium {
    Medium::new(Vec3::splat(0.2), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

/// A leaded window half a metre below the light.
fn window() -> Geometry {
    let mut mesh = Mesh::default();
    for i in 0..7 {
        let middle = 0.08 * (i as f32 - 3.0) + 0.013;
        for turned in [false, true] {
            let corner = |along: f32, across: f32| {
                let (x, z) = if turned {
                    (across, along)
                } else {
                    (along, across)
                };
                Vec3::new(x, -0.5, z)
            };
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([
                corner(-0.4, middle - 0.012),
                corner(0.4, middle - 0.012),
                corner(0.4, middle + 0.012),
                corner(-0.4, middle + 0.012),
            ]);
            let square = [[0, 1, 2], [0, 2, 3]];
            mesh.triangles.extend(square.map(|t| t.map(|i| first + i)));
        }
    }
    Geometry::new(&Scene::from(mesh)).unwrap()
}

/// Rays across the beam, towards the light and away from it.
fn rays(kind: &str) -> Vec<Ray> {
    let random = |i: u64| noise(i) - 0.5;
    (0..400)
        .map(|i| {
            let offset = |k: u64| random(7 * i + k);
            let wander = Vec3::new(offset(0), offset(1), offset(2));
            let (from, to) = match kind {
                "across" => (
                    Vec3::new(3.0, -2.0, 0.3),
                    Vec3::new(0.0, -2.0, 0.0) + wander,
                ),
                "towards" => (Vec3::new(0.3, -6.0, 0.4), 0.15 * wander),
                _ => (
                    Vec3::new(0.05, 0.05, 0.02),
                    Vec3::new(0.0, -4.0, 0.0) + 2.0 * wander,
                ),
            };
            Ray::new(from, to - from, 6.5).unwrap()
        })
        .collect()
}

fn gathered(rays: &Vec<Ray>, source: &impl VisibilitySource, nodes: u32) -> Vec<f64> {
    let (light, fog) = (spot(), fog());
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let airlight = EquiAngular::new(nodes).unwrap();
    Cpu::new()
        .gather(
            &LitRays::new(rays, &light, &fog),
            source,
            &airlight,
            &mut radiance,
        )
        .unwrap();
    radiance.iter().map(|[red, ..]| f64::from(*red)).collect()
}

/// Relative to the mean.
fn rmse(found: &[f64], truth: &[f64]) -> f64 {
    let mean: f64 = truth.iter().sum::<f64>() / truth.len() as f64;
    let pairs = found.iter().zip(truth);
    let square: f64 = pairs.map(|(f, t)| (f - t).powi(2)).sum();
    (square / truth.len() as f64).sqrt() / mean
}

fn map() -> ShadowMap<Host> {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &window()).unwrap();
    cpu.shadow_map(&casters, &spot(), 256).unwrap()
}

/// How many times as many equal steps err as much, for rays across the beam, towards the
/// light and from beside it, in the mean over numbers of steps. What is left at a number of
/// steps is chance.
#[test]
fn fewer_steps_are_as_good_and_many_end_at_the_runs_of_the_map() {
    let map = map();
    let counts: Vec<u32> = (2..14).map(|i| 1 << i).collect();
    for (kind, least) in [("across", 0.9), ("towards", 6.0), ("along", 4.0)] {
        let rays = rays(kind);
        let truth = gathered(&rays, &MapRuns::walked(&map), 16);
        let errors = |spacing| -> Vec<f64> {
            let march = |steps| gathered(&rays, &March::new(&map, steps, spacing), 1);
            let errors = counts.iter().map(|steps| rmse(&march(*steps), &truth));
            errors.collect()
        };
        let equal = errors(Spacing::Distance);
        let found = errors(Spacing::Picture);
        let mut gain = 0.0;
        for (steps, error) in counts.iter().zip(&found).skip(2).take(4) {
            // Between two counts errors follow a power of the count.
            let more = equal.iter().position(|equal| equal < error).unwrap();
            let share = (equal[more - 1] / error).ln() / (equal[more - 1] / equal[more]).ln();
            let needed = f64::from(counts[more - 1]) * 2_f64.powf(share);
            gain += 0.25 * (needed / f64::from(*steps)).ln();
        }
        let gain = gain.exp();
        println!("{kind}: {gain:.1}x; {found:.4?} equal {equal:.4?}");
        println!("{kind}: {gain:.1} x, errors {found:.4?} of {counts:?} steps");
        assert!(gain > least, "{kind}: {gain}");
        assert!(found[11] < 1e-3, "{kind}: {found:?}");
    }
}

/// In the plane one metre before the light.
#[test]
fn steps_are_equal_in_the_picture() {
    let (light, fog) = (spot(), fog());
    let mut compared = 0;
    for ray in ["across", "towards", "along"]
        .iter()
        .flat_map(|kind| rays(kind))
    {
        let Some(path) = LightPath::new(&ray, &light, &fog) else {
            continue;
        };
        let mut steps = Vec::new();
        March::new(Unshadowed, 20, Spacing::Picture).lit_intervals(&path, &mut steps);
        assert_eq!(steps.len(), 20);
        let picture = |x: f32| {
            let point = ray.origin().as_dvec3() + f64::from(x) * ray.direction().as_dvec3();
            point / -point.y
        };
        let length = |from: f32, to: f32| picture(from).distance(picture(to));
        let span = path.span();
        assert_eq!(
            (steps[0].interval.start, steps[19].interval.end),
            (span.start, span.end)
        );
        let whole = length(span.start, span.end);
        for step in steps {
            let part = length(step.interval.start, step.interval.end);
            assert!(
                (20.0 * part / whole - 1.0).abs() < 1e-3,
                "{part} of {whole}"
            );
            compared += 1;
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// Rays through the light, in the plane of the light, and away from it.
#[test]
fn degenerate_pictures_are_marched_to_the_end() {
    let fog = fog();
    let bounded = fog.within(Bounds::new(Vec3::splat(-9.0), Vec3::splat(9.0)).unwrap());
    let flat = Cone {
        inner: 0.0,
        outer: std::f32::consts::FRAC_PI_2,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let flat = Emission::spot(down, flat, None).unwrap();
    let flat = Emitter::point(Vec3::ZERO, Vec3::ONE, f32::INFINITY, flat).unwrap();
    for light in [spot(), flat] {
        for medium in [fog, bounded] {
            for (from, towards) in [
                (Vec3::new(0.0, -5.0, 0.0), Vec3::Y),
                (Vec3::ZERO, Vec3::NEG_Y),
                (Vec3::new(-1.0, 0.0, 0.0), Vec3::X),
                (Vec3::new(-1.0, -1e-7, 0.0), Vec3::X),
                (Vec3::new(0.0, -1e-6, 0.0), Vec3::new(1.0, -1e-6, 0.0)),
            ] {
                let ray = Ray::new(from, towards, f32::INFINITY).unwrap();
                let Some(path) = LightPath::new(&ray, &light, &medium) else {
                    continue;
                };
                let path = path.off_the_light();
                let mut steps = Vec::new();
                March::new(Unshadowed, 100, Spacing::Picture).lit_intervals(&path, &mut steps);
                let ends = steps.windows(2);
                assert!(
                    ends.into_iter()
                        .all(|w| w[0].interval.end <= w[1].interval.start)
                );
                let (first, last) = (steps[0].interval, steps[steps.len() - 1].interval);
                assert_eq!(first.start, path.span().start);
                assert!(last.end == path.span().end || path.span().end == f32::INFINITY);
            }
        }
    }
}

#[cfg(feature = "translucent")]
mod through_curves {
    use transmittance::{Filter, Stream};

    use super::*;
    use crate::scene::{Particle, Particles, Profile, Translucent};
    use crate::translucent::{Casters as Blockers, TransmittanceMap};

    /// Of the leaded window, with smoke below it or without.
    fn curves(smoke: &[Translucent]) -> TransmittanceMap {
        let window = window();
        let blockers = Blockers::new(smoke, Some(&window));
        let clear = Stream::<8>::new();
        TransmittanceMap::build(&Cpu::new(), &blockers, &spot(), 256, &clear).unwrap()
    }

    fn smoke() -> Vec<Translucent> {
        let puff = |x: f32, y: f32, radius: f32, sigma_t: f32| Particle {
            centre: Vec3::new(x, y, 0.05),
            radius,
            sigma_t,
        };
        let puffs = vec![
            puff(-0.2, -1.2, 0.3, 2.0),
            puff(0.25, -1.7, 0.4, 1.0),
            puff(0.0, -2.6, 0.5, 1.5),
        ];
        vec![Particles::new(puffs, Profile::Soft).unwrap().into()]
    }

    /// Where nothing is translucent, a curve is a step at the depth of the shadow map.
    #[test]
    fn a_map_of_what_is_opaque_is_the_depth_map() {
        let depths = map();
        let curves = curves(&[]).with_filter(Filter::Nearest);
        for kind in ["across", "towards", "along"] {
            let rays = rays(kind);
            for spacing in [Spacing::Picture, Spacing::Distance] {
                let of_depths = gathered(&rays, &March::new(&depths, 100, spacing), 1);
                let of_curves = gathered(&rays, &March::new(&curves, 100, spacing), 1);
                let pairs = of_depths.iter().zip(&of_curves);
                let differ = pairs.filter(|(d, c)| (*d - *c).abs() > 1e-6 * d.abs());
                // A sample on the edge of a triangle, as the two rasterise it.
                let differ = differ.count();
                println!("{kind} {spacing:?}: {differ} of {} differ", rays.len());
                assert!(100 * differ <= rays.len(), "{kind}: {differ}");
            }
        }
    }

    /// Steps in the picture and steps of equal length end at the same picture. Those in
    /// the picture come near it with fewer, in the mean over numbers of steps: what is
    /// left at one of them is chance.
    #[test]
    fn light_space_and_world_space_have_one_limit() {
        let curves = curves(&smoke());
        let counts = [4_u32, 16, 64, 256];
        for (kind, least) in [("across", 0.9), ("towards", 2.0), ("along", 2.0)] {
            let rays = rays(kind);
            let marched = |steps, spacing| gathered(&rays, &March::new(&curves, steps, spacing), 1);
            let truth = marched(8192, Spacing::Picture);
            let world = rmse(&marched(16384, Spacing::Distance), &truth);
            let errors = |spacing| counts.map(|steps| rmse(&marched(steps, spacing), &truth));
            let (picture, equal) = (errors(Spacing::Picture), errors(Spacing::Distance));
            let ratios = equal.iter().zip(&picture);
            let gain: f64 = ratios.map(|(equal, picture)| (equal / picture).ln()).sum();
            let gain = (0.25 * gain).exp();
            println!("{kind}: {picture:.4?} in the picture, {equal:.4?} equal, {gain:.1} x");
            assert!(world < 1e-3, "{kind}: {world}");
            assert!(picture[3] < 0.05 * picture[0], "{kind}: {picture:?}");
            assert!(gain > least, "{kind}: {gain}");
        }
    }
}
