use glam::{DVec3, Vec3};
use gpu_backend::{Cpu, Error};
use reference::random::Random;

use super::*;
use crate::Ray;
use crate::culling::tests::{WIDTH, lights, rays};
use crate::scene::{Bounds, Emission, PhaseFunction};

pub(super) fn fog() -> Medium {
    let sigma = Vec3::new(0.05, 0.04, 0.03);
    Medium::new(sigma, 0.2 * sigma, PhaseFunction::Isotropic).unwrap()
}

/// Surfaces of any slope at the ends of rays, and nothing where a ray has no end.
pub(super) fn points(random: &mut Random, rays: &[Ray]) -> Vec<SurfacePoint> {
    let point = |ray: &Ray| {
        let slope = 0.7 * Vec3::from_array(random.vector(1.0)) - ray.direction();
        let response = Vec3::new(0.3, 0.2, 0.1) * random.unit();
        SurfacePoint::new(ray.at(ray.length()), slope, response).unwrap_or_default()
    };
    rays.iter().map(point).collect()
}

/// What was there before.
pub(super) fn before(points: usize) -> Vec<[f32; 4]> {
    (0..points)
        .map(|i| [0.1 * i as f32, 0.0, 0.5, 7.0])
        .collect()
}

pub(super) fn bits(sums: &[[f32; 4]]) -> Vec<[u32; 4]> {
    sums.iter().map(|sum| sum.map(f32::to_bits)).collect()
}

fn light<V: ShadowsOfMany>(
    cpu: &Cpu,
    points: &Vec<SurfacePoint>,
    lit: (&[Emitter], &PointLists, Option<&Medium>),
    shadows: &V,
) -> Vec<[f32; 4]> {
    let (emitters, lists, medium) = lit;
    let mut sums = before(points.len());
    let lit = LitPoints::new(points, emitters, lists, medium);
    cpu.add_direct_light(&lit, shadows, &mut sums).unwrap();
    sums
}

/// Half a shadow, or a light's own share.
struct Striped;

impl ShadowsOfMany for Striped {
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let share = 0.5 + 0.5 * (point.x + light as f32).sin();
        Vec3::new(share, 0.5 * share, 1.0) * normal.y.abs()
    }
}

#[test]
fn points_that_ask_their_lists_have_the_bits_of_those_that_ask_all_lights() {
    let mut random = Random::new(1);
    let cpu = Cpu::new();
    let (mut listed, mut all_pairs) = (0, 0);
    for set in 0..40 {
        let rays = rays(&mut random);
        let emitters = lights(&mut random, &rays, 9 + set);
        let points = points(&mut random, &rays);
        let all = PointLists::all(points.len(), emitters.len());
        let lists = PointLists::of_picture(&cpu, &rays, WIDTH, &emitters);
        assert_eq!(
            [lists.points(), lists.emitters()],
            [points.len(), emitters.len()]
        );
        for (i, ray) in rays.iter().enumerate() {
            assert!(lists.of(i).is_sorted_by(|a, b| a < b));
            assert!(ray.length().is_finite() || lists.of(i).is_empty());
            listed += lists.of(i).len();
            all_pairs += all.of(i).len();
        }
        let medium = fog();
        for medium in [None, Some(&medium)] {
            let expected = light(&cpu, &points, (&emitters, &all, medium), &Striped);
            let found = light(&cpu, &points, (&emitters, &lists, medium), &Striped);
            assert!(bits(&found) == bits(&expected));
            let one = Cpu::single_threaded();
            let alone = light(&one, &points, (&emitters, &lists, medium), &Striped);
            assert!(bits(&found) == bits(&alone));
        }
    }
    assert!(2 * listed < all_pairs, "{listed} of {all_pairs}");
    assert!(PointLists::all(3, 2).of(3).is_empty());
}

/// Lamps and a sun over points of a slope, in f64.
#[test]
fn points_reflect_what_the_equation_says() {
    let mut random = Random::new(2);
    let bounds = Bounds::new(Vec3::new(-2.0, 0.5, -3.0), Vec3::new(3.0, 2.0, 1.0)).unwrap();
    let (open, boxed) = (fog(), fog().within(bounds));
    let sigma = open.sigma_t().as_dvec3();
    for _ in 0..100 {
        let mut vector = |size: f32| Vec3::from_array(random.vector(size));
        let point = SurfacePoint::new(vector(2.0), vector(1.0) + 1e-3, vector(1.0).abs()).unwrap();
        let direction = vector(1.0) + Vec3::new(0.0, 1e-3, 0.0);
        let emitters = [
            Emitter::point(
                vector(5.0),
                vector(9.0).abs(),
                f32::INFINITY,
                Emission::Isotropic,
            ),
            Emitter::directional(direction, vector(3.0).abs()),
        ]
        .map(Result::unwrap);
        let lists = PointLists::all(1, 2);
        for medium in [None, Some(&open), Some(&boxed)] {
            let mut expected = DVec3::ZERO;
            for (light, emitter) in emitters.iter().enumerate() {
                let (to_light, distance, power) = match emitter {
                    Emitter::Point(lamp) => {
                        let to = (lamp.position() - point.position()).as_dvec3();
                        let d = to.length();
                        (to / d, d, lamp.intensity().as_dvec3() / (d * d))
                    }
                    Emitter::Directional(sun) => (
                        -sun.direction().as_dvec3(),
                        f64::INFINITY,
                        sun.irradiance().as_dvec3(),
                    ),
                };
                let way = match medium.map(|medium| medium.bounds()) {
                    None => 0.0,
                    Some(None) if distance.is_infinite() => 0.0,
                    Some(None) => distance,
                    Some(Some(bounds)) => {
                        // By small steps.
                        let steps = 200_000;
                        let length = distance.min(20.0);
                        let inside = (0..steps).filter(|step| {
                            let s = (f64::from(*step) + 0.5) / f64::from(steps) * length;
                            let at = point.position().as_dvec3() + s * to_light;
                            at.cmpge(bounds.min().as_dvec3()).all()
                                && at.cmple(bounds.max().as_dvec3()).all()
                        });
                        inside.count() as f64 / f64::from(steps) * length
                    }
                };
                let cos = point.normal().as_dvec3().dot(to_light).max(0.0);
                let share = Striped.visibility(light, point.position(), point.normal());
                expected += point.response().as_dvec3()
                    * power
                    * cos
                    * (-sigma * way).exp()
                    * share.as_dvec3();
            }
            let cpu = Cpu::new();
            let found = light(&cpu, &vec![point], (&emitters, &lists, medium), &Striped)[0];
            let expected = expected + DVec3::new(0.0, 0.0, 0.5);
            for channel in 0..3 {
                let error = (f64::from(found[channel]) - expected[channel]).abs();
                assert!(
                    error < 2e-5 * (1.0 + expected[channel]),
                    "{found:?} {expected}"
                );
            }
            assert_eq!(found[3], 7.0);
        }
    }
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let mut random = Random::new(3);
    let rays = rays(&mut random);
    let emitters = lights(&mut random, &rays, 9);
    let all = points(&mut random, &rays);
    let lists = PointLists::all(all.len(), emitters.len());
    let refused = |points: &Vec<SurfacePoint>, emitters: &[Emitter], sums: usize| {
        let mut sums = before(sums);
        let lit = LitPoints::new(points, emitters, &lists, None);
        let result = Cpu::new().add_direct_light(&lit, &Unshadowed, &mut sums);
        assert_eq!(sums, before(sums.len()));
        result.unwrap_err()
    };
    for error in [
        refused(&all, &emitters, 3),
        refused(&all[1..].to_vec(), &emitters, all.len() - 1),
        refused(&all, &emitters[1..], all.len()),
    ] {
        assert!(matches!(error, Error::LengthMismatch { .. }), "{error}");
    }
    // Nothing is known of the second light, which then lights nothing.
    let lights = vec![Unshadowed];
    let found = light(&Cpu::new(), &all, (&emitters, &lists, None), &lights);
    let first = PointLists::all(all.len(), 1);
    let expected = light(
        &Cpu::new(),
        &all,
        (&emitters[..1], &first, None),
        &Unshadowed,
    );
    assert!(bits(&found) == bits(&expected));
}
