//! Maps of transmittance against the truth: at points, and in images.

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use lighting::airlight::EquiAngular;
use lighting::scene::procedural::{Embedded, ponytail, smoke_grid, smoke_particles};
use lighting::scene::{Emission, Medium, Particle, Particles, PhaseFunction, Profile, Translucent};
use lighting::translucent::{Casters, TransmittanceMap};
use lighting::visibility::{March, Spacing};
use lighting::{Emitter, Gather, LightPath, LitRays, Ray, VisibilitySource};
use proptest::prelude::*;
use reference::metrics::image_error;
use reference::oracle::Lamp;
use reference::oracle::image::{Options, Reference, reference};
use reference::oracle::translucent::{self, Translucency};
use reference::property::holds_for;
use reference::scenes::TestScene;
use transmittance::baseline::{Captured, Uncompressed};
use transmittance::{Packed, Stream};

type Exact = TransmittanceMap<Host, Uncompressed>;

fn exact(casters: &Casters<'_>, emitter: &Emitter, resolution: u32) -> Exact {
    TransmittanceMap::build(&Cpu::new(), casters, emitter, resolution, &Captured::new()).unwrap()
}

fn lights() -> [Emitter; 2] {
    let position = Vec3::new(0.7, 6.0, 0.9);
    [
        Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap(),
        Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap(),
    ]
}

/// Points all over the box of a caster and below it.
fn points(caster: &Translucent, count: u32) -> Vec<Vec3> {
    let bounds = caster.bounds().unwrap();
    let (min, size) = (bounds.min(), bounds.max() - bounds.min());
    // Roberts's R₃ sequence.
    let share = |i: u32, step: f64| ((f64::from(i) + 0.5) * step).fract() as f32;
    (0..count)
        .map(|i| {
            let unit = Vec3::new(
                share(i, 0.819_172_513_396_164),
                share(i, 0.671_043_606_703_789),
                share(i, 0.549_700_477_901_970),
            );
            min + size * (unit * Vec3::new(1.0, 1.5, 1.0) - Vec3::new(0.0, 0.5, 0.0))
        })
        .collect()
}

/// Root mean square difference of map and truth.
fn difference(map: &Exact, translucency: &Translucency, emitter: &Emitter, points: &[Vec3]) -> f64 {
    let lamp = Lamp::new(emitter);
    let squares = points.iter().map(|&point| {
        let truth = translucency.transmittance(&lamp, point.as_dvec3());
        (f64::from(map.transmittance(point).x) - truth).powi(2)
    });
    (squares.sum::<f64>() / points.len() as f64).sqrt()
}

#[test]
fn in_smoke_maps_converge_to_the_truth_at_nearly_second_order() {
    let smokes: [Translucent; 2] = [
        smoke_particles(1).into(),
        smoke_grid(1, 6.0).unwrap().into(),
    ];
    for smoke in smokes {
        let translucency = Translucency::new(std::slice::from_ref(&smoke));
        let points = points(&smoke, 2000);
        for emitter in lights() {
            let casters = Casters::new(std::slice::from_ref(&smoke), None);
            let error = |side| {
                difference(
                    &exact(&casters, &emitter, side),
                    &translucency,
                    &emitter,
                    &points,
                )
            };
            let errors = [64, 128, 256].map(error);
            println!("{} {emitter:?}: {errors:?}", smoke.describe());
            // Kinks at the rims of balls and between cells: 3/2 at least.
            assert!(
                errors[1] < errors[0] / 2.2 && errors[2] < errors[1] / 1.8,
                "{errors:?}"
            );
            assert!(errors[2] < 5e-3, "{errors:?}");
        }
    }
}

#[test]
fn in_hair_maps_have_the_right_mean_and_in_the_limit_the_right_shadows() {
    // Wisps that a fine map resolves.
    let hair: Translucent = ponytail(1, 60, 0.02, 0.6).unwrap().into();
    let translucency = Translucency::new(std::slice::from_ref(&hair));
    let points = points(&hair, 4000);
    for emitter in lights() {
        let casters = Casters::new(std::slice::from_ref(&hair), None);
        let lamp = Lamp::new(&emitter);
        let errors = [64, 256, 1024].map(|side| {
            let map = exact(&casters, &emitter, side);
            let mean = |value: &dyn Fn(Vec3) -> f64| {
                points.iter().map(|&point| value(point)).sum::<f64>() / points.len() as f64
            };
            let found = mean(&|point| map.transmittance(point).x.into());
            let truth = mean(&|point| translucency.transmittance(&lamp, point.as_dvec3()));
            println!("{side}: mean {found:.4}, truth {truth:.4}");
            // 4,000 samples of what is 0.4 or 1 where there is hair: 3 standard
            // errors of 0.4 / √4000; and pieces overlap at their ends.
            assert!((found - truth).abs() < 0.02, "{found} {truth}");
            difference(&map, &translucency, &emitter, &points)
        });
        println!("{emitter:?}: {errors:?}");
        // A share of texels that falls with their size is on an outline.
        assert!(errors[1] < 0.75 * errors[0] && errors[2] < 0.65 * errors[1]);
    }
}

fn march(test_scene: &TestScene, map: &impl VisibilitySource, emitter: &Emitter) -> Vec<[f32; 4]> {
    let mut radiance = vec![[0.0; 4]; test_scene.rays.len()];
    let one = EquiAngular::new(1).unwrap();
    Cpu::new()
        .gather(
            &LitRays::new(&test_scene.rays, emitter, &test_scene.medium),
            map,
            &one,
            &mut radiance,
        )
        .unwrap();
    radiance
}

/// The scene with smoke and hair, its casters and the truth.
fn scene() -> (TestScene, Vec<Translucent>, Reference) {
    let test_scene = TestScene::new(Embedded::Translucent, 40, 22);
    let casters = Embedded::Translucent.build(1).translucent;
    let truth = translucent::reference(
        &test_scene.rays,
        &test_scene.emitters,
        &test_scene.medium,
        &test_scene.geometry,
        &casters,
        256,
        &|_| {},
    );
    (test_scene, casters, truth)
}

#[test]
fn images_converge_to_the_truth_with_steps_and_texels() {
    let (test_scene, translucent, truth) = scene();
    let emitter = &test_scene.emitters[0];
    let casters = Casters::new(&translucent, Some(&test_scene.geometry));
    let uncertain = truth.bound.iter().sum::<f64>() / truth.bound.len() as f64 / truth.mean();
    let errors = [(64, 128), (128, 256), (256, 512)].map(|(samples, side)| {
        let map = exact(&casters, emitter, side);
        let march_ = March::new(&map, samples, Spacing::EquiAngular);
        let error = image_error(&march(&test_scene, &march_, emitter), &truth).rmse;
        let adaptive = TransmittanceMap::<Host, Packed<8>>::build(
            &Cpu::new(),
            &casters,
            emitter,
            side,
            &Stream::<8>::new(),
        )
        .unwrap();
        let march_ = March::new(&adaptive, samples, Spacing::EquiAngular);
        let of_curves = image_error(&march(&test_scene, &march_, emitter), &truth).rmse;
        println!("{samples} steps, {side} texels: {error:.5}, with 8 nodes {of_curves:.5}");
        // What curves of 8 nodes add is small against the rest.
        assert!(of_curves < 1.1 * error + 2e-3);
        error
    });
    println!("uncertain {uncertain:.5}");
    // The opaque head and floor make it first order in steps and texels.
    assert!(
        errors[1] < 0.75 * errors[0] && errors[2] < 0.75 * errors[1],
        "{errors:?}"
    );
    assert!(errors[2] < 0.01, "{errors:?}");
}

#[test]
fn casters_darken_the_air_and_without_them_the_oracle_is_the_reference() {
    let (test_scene, _, truth) = scene();
    let (rays, emitters) = (&test_scene.rays, &test_scene.emitters);
    let opaque = reference(
        rays,
        emitters,
        &test_scene.medium,
        &test_scene.geometry,
        Options::default(),
    );
    let clear = translucent::reference(
        rays,
        emitters,
        &test_scene.medium,
        &test_scene.geometry,
        &[],
        16,
        &|_| {},
    );
    for ((with, without), clear) in truth
        .radiance
        .iter()
        .zip(&opaque.radiance)
        .zip(&clear.radiance)
    {
        for channel in 0..3 {
            assert!((clear[channel] - without[channel]).abs() <= 1e-5 * without[channel] + 1e-12);
            assert!(with[channel] <= clear[channel] * (1.0 + 1e-5));
        }
    }
    assert!(
        truth.mean() < 0.95 * opaque.mean(),
        "{} {}",
        truth.mean(),
        opaque.mean()
    );
}

#[test]
fn every_march_yields_ordered_parts_of_visibility_between_0_and_1() {
    let medium = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let (emitters, cpu) = (lights(), Cpu::new());
    let particle = (
        prop::array::uniform3(-2.0_f32..2.0),
        0.0_f32..2.0,
        -3.0_f32..4.0,
    );
    let ray = (
        prop::array::uniform3(-4.0_f32..4.0),
        prop::array::uniform3(-1.0_f32..1.0),
    );
    let scene = (prop::collection::vec(particle, 0..12), ray, 0_u32..20);
    holds_for(150, scene, |(particles, (origin, direction), samples)| {
        let ball = |&(centre, radius, power): &([f32; 3], f32, f32)| Particle {
            centre: centre.into(),
            radius,
            sigma_t: 10.0_f32.powf(power),
        };
        let all: Vec<Particle> = particles.iter().map(ball).collect();
        let casters = [Particles::new(all, Profile::Soft).unwrap().into()];
        let casters = Casters::new(&casters, None);
        let Some(ray) = Ray::new(origin, direction, 9.0) else {
            return Ok(());
        };
        for emitter in &emitters {
            let map = TransmittanceMap::<Host, Packed<4>>::build(
                &cpu,
                &casters,
                emitter,
                24,
                &Stream::<4>::new(),
            );
            let map = map.unwrap();
            for spacing in [Spacing::Distance, Spacing::EquiAngular] {
                let Some(path) = LightPath::new(&ray, emitter, &medium) else {
                    continue;
                };
                let mut lit = Vec::new();
                March::new(&map, samples, spacing).lit_intervals(&path, &mut lit);
                prop_assert!(lit.len() <= samples.max(1) as usize);
                let mut from = path.span().start;
                for part in lit {
                    prop_assert!(
                        part.visibility.min_element() > 0.0 && part.visibility.max_element() <= 1.0
                    );
                    prop_assert!(
                        part.interval.start >= from && part.interval.end > part.interval.start
                    );
                    from = part.interval.end;
                }
                prop_assert!(from <= path.span().end);
            }
        }
        Ok(())
    });
}

#[test]
fn light_never_grows_on_its_way() {
    let casters = Embedded::Translucent.build(1).translucent;
    let casters = Casters::new(&casters, None);
    for emitter in lights() {
        let map = TransmittanceMap::<Host, Packed<8>>::build(
            &Cpu::new(),
            &casters,
            &emitter,
            200,
            &Stream::<8>::new(),
        );
        let map = map.unwrap();
        for i in 0..200 {
            let target = Vec3::new(
                -5.0 + 0.05 * i as f32,
                0.0,
                ((i * 37 % 100) as f32 - 50.0) * 0.02,
            );
            let start = match &emitter {
                Emitter::Point(point) => point.position(),
                Emitter::Directional(sun) => target - 8.0 * sun.direction(),
            };
            let mut before = 1.0;
            for step in 1..100 {
                let here = map.transmittance(start.lerp(target, 0.01 * step as f32)).x;
                // Positions and depths of the same ray differ by roundings.
                assert!(here <= before + 1e-3, "{here} {before}");
                before = here;
            }
        }
    }
}
