//! Light that surfaces receive besides that of the lamps: by way of the fog, and from
//! the environment.

use crepuscular_tests::scenes;
use crepuscular_tests::suite;
use glam::{DVec3, Quat, Vec3};
use gpu_backend::{Buffer, Cpu, Download};
use lighting::environment::{Ambient, Environment, EnvironmentMap};
use lighting::indirect::LightSurfaces;
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{
    Bounds, Cone, Emission, Falloff, Geometry, Medium, Mesh, PhaseFunction, Scene,
};
use lighting::surface::with_openness;
use lighting::surface_scattering::{AddSurfaceScattering, ClosedForm, LitSurfaces, Quadrature};
use lighting::visibility::Unshadowed;
use lighting::{Emitter, Ray, SurfacePoint};
use reference::oracle::surface::{environment_in_fog, scattered_irradiance};
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

mod views;
mod windows;

fn fog(sigma: f32, phase: PhaseFunction) -> Medium {
    let sigma_s = sigma * Vec3::new(1.0, 0.7, 0.7);
    Medium::new(sigma_s, 0.2 * sigma_s, phase).unwrap()
}

fn boxed(medium: Medium) -> Medium {
    medium.within(Bounds::new(Vec3::new(-2.0, -0.5, -3.0), Vec3::new(4.0, 3.0, 2.5)).unwrap())
}

fn lamp(emission: Emission, range: f32) -> Emitter {
    let position = Vec3::new(0.6, 1.8, -0.4);
    Emitter::point(position, Vec3::new(5.0, 4.0, 3.0), range, emission).unwrap()
}

/// The same, which fades towards its range.
fn fading(emission: Emission, range: f32) -> Emitter {
    lamp(emission, range).with_falloff(Falloff::Smooth)
}

/// Looks down, a little to the side.
fn spot(inner: f32, outer: f32) -> Emission {
    let rotation = Quat::from_rotation_z(0.3) * Quat::from_rotation_x(-1.4);
    Emission::spot(rotation, Cone { inner, outer }, None).unwrap()
}

fn sun() -> Emitter {
    Emitter::directional(Vec3::new(0.4, -1.0, 0.2), Vec3::new(3.0, 2.0, 1.0)).unwrap()
}

/// Turned in all ways, near the lamp and far away from it.
fn points() -> Vec<SurfacePoint> {
    (0..12)
        .map(|i| {
            let (y, turn) = (1.0 - (i as f32 + 0.5) / 6.0, 2.4 * i as f32);
            let r = (1.0 - y * y).sqrt();
            let normal = Vec3::new(r * turn.cos(), y, r * turn.sin());
            let position = Vec3::new(0.3 * i as f32 - 1.5, 0.1 * i as f32 - 0.2, 0.2);
            SurfacePoint::new(position, normal, Vec3::ONE).unwrap()
        })
        .collect()
}

fn scattered<B, S>(
    backend: &B,
    points: &[SurfacePoint],
    (emitter, medium): (&Emitter, &Medium),
    scattering: &S,
) -> Vec<[f32; 4]>
where
    B: AddSurfaceScattering<S> + Download,
{
    let points = backend.upload(points).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(points.len()).unwrap();
    let lit = LitSurfaces {
        points: &points,
        emitter,
        medium,
    };
    backend
        .add_surface_scattering(&lit, scattering, &mut radiance)
        .unwrap();
    backend.download(&radiance).unwrap()
}

fn truths(points: &[SurfacePoint], emitter: &Emitter, medium: &Medium) -> Vec<DVec3> {
    points
        .iter()
        .map(|point| scattered_irradiance(point.position(), point.normal(), emitter, medium, 1e-6))
        .collect()
}

fn brightest(truth: &[DVec3]) -> f64 {
    truth
        .iter()
        .fold(0.0, |most, light| light.max_element().max(most))
}

fn rgb(radiance: [f32; 4]) -> DVec3 {
    Vec3::from_slice(&radiance).as_dvec3()
}

fn the_closed_form_is_the_integral_over_the_hemisphere<B: LightSurfaces>(backend: &B) {
    let points = points();
    let even = PhaseFunction::Isotropic;
    let hazy = PhaseFunction::HenyeyGreenstein { g: 0.6 };
    let cases = [
        (lamp(Emission::Isotropic, f32::INFINITY), fog(0.01, even)),
        (lamp(Emission::Isotropic, f32::INFINITY), fog(0.5, even)),
        (lamp(Emission::Isotropic, f32::INFINITY), fog(4.0, even)),
        (sun(), fog(0.3, even)),
    ];
    for (emitter, medium) in &cases {
        let found = scattered(
            backend,
            &points,
            (emitter, medium),
            &ClosedForm::new(medium),
        );
        for (found, truth) in found.iter().zip(truths(&points, emitter, medium)) {
            let error = ((rgb(*found) - truth) / truth).abs().max_element();
            assert!(
                error < Allowed::SurfaceClosedForm.error(),
                "{truth}: {error:e}"
            );
        }
    }
    // The table of a sun in haze is linear between 257 cosines: 2e-5 / (1 − g)² of 1.
    let medium = fog(0.3, hazy);
    let found = scattered(
        backend,
        &points,
        (&sun(), &medium),
        &ClosedForm::new(&medium),
    );
    for (found, truth) in found.iter().zip(truths(&points, &sun(), &medium)) {
        let whole = 3.0 / 1.2;
        let error = (rgb(*found) - truth).abs().max_element() / whole;
        assert!(error < 2e-5 / (0.4 * 0.4) + 2e-6, "{truth}: {error:e}");
    }
}

/// Every kind of light and fog that has no closed form.
fn others() -> Vec<(Emitter, Medium)> {
    let even = PhaseFunction::Isotropic;
    let hazy = PhaseFunction::HenyeyGreenstein { g: 0.6 };
    let far = f32::INFINITY;
    vec![
        (lamp(Emission::Isotropic, far), fog(0.3, hazy)),
        (lamp(Emission::Isotropic, 2.5), fog(0.3, even)),
        (fading(Emission::Isotropic, 2.5), fog(0.3, even)),
        (fading(spot(0.5, 1.2), 3.0), boxed(fog(0.3, hazy))),
        (
            lamp(
                Emission::Cosine {
                    normal: Vec3::NEG_X,
                },
                far,
            ),
            fog(0.3, even),
        ),
        (lamp(spot(0.1, 0.2), far), fog(0.3, even)),
        (lamp(spot(0.5, 0.9), far), fog(1.0, PhaseFunction::Rayleigh)),
        (lamp(spot(0.5, 1.2), 3.0), boxed(fog(0.3, hazy))),
        (lamp(Emission::Isotropic, far), boxed(fog(0.3, even))),
        (sun(), boxed(fog(0.3, even))),
        (sun(), boxed(fog(0.3, hazy))),
    ]
}

fn quadrature_is_the_integral_over_the_hemisphere<B: LightSurfaces>(backend: &B) {
    let points = points();
    let quadrature = Quadrature::new(Unshadowed, 16).unwrap();
    for (case, (emitter, medium)) in others().iter().enumerate() {
        let found = scattered(backend, &points, (emitter, medium), &quadrature);
        let truth = truths(&points, emitter, medium);
        let scale = brightest(&truth);
        for (found, truth) in found.iter().zip(truth) {
            let error = (rgb(*found) - truth).abs().max_element() / scale;
            assert!(
                error < Allowed::SurfaceQuadrature.error(),
                "case {case}: {found:?} {truth}: {error:e}"
            );
        }
    }
}

/// Radiance of degree 1: brighter above and to the left.
fn gradient(direction: DVec3) -> f64 {
    1.0 + 0.6 * direction.y - 0.3 * direction.x
}

fn environment() -> Environment {
    let (width, height) = (128, 64);
    let texel = |index: usize| {
        let latitude = std::f64::consts::PI * ((index / width) as f64 + 0.5) / height as f64;
        let longitude =
            std::f64::consts::TAU * (((index % width) as f64 + 0.5) / width as f64 - 0.5);
        let flat = latitude.sin();
        let direction = DVec3::new(
            flat * longitude.sin(),
            latitude.cos(),
            -flat * longitude.cos(),
        );
        [gradient(direction) as f32; 3]
    };
    Environment::new(width, height, (0..width * height).map(texel).collect()).unwrap()
}

fn seen<B: LightSurfaces>(
    backend: &B,
    rays: &[Ray],
    map: &EnvironmentMap<B::Memory>,
) -> Vec<DVec3> {
    let rays = backend.upload(rays).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(rays.len()).unwrap();
    backend.add_sky(&rays, map, &mut radiance).unwrap();
    backend
        .download(&radiance)
        .unwrap()
        .into_iter()
        .map(rgb)
        .collect()
}

fn received<B: LightSurfaces>(
    backend: &B,
    points: &[SurfacePoint],
    map: &EnvironmentMap<B::Memory>,
) -> Vec<DVec3> {
    let points = backend.upload(points).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(points.len()).unwrap();
    backend
        .add_environment_light(&points, map, &mut radiance)
        .unwrap();
    backend
        .download(&radiance)
        .unwrap()
        .into_iter()
        .map(rgb)
        .collect()
}

fn skies() -> Vec<Ray> {
    let ray = |point: &SurfacePoint| Ray::new(Vec3::ZERO, point.normal(), f32::INFINITY).unwrap();
    points().iter().map(ray).collect()
}

fn fog_scatters_ambient_light_by_the_closed_form<B: LightSurfaces>(backend: &B) {
    let lengths = [1e-4, 0.3, 2.0, 30.0, 1e4, f32::INFINITY];
    let rays: Vec<Ray> = skies()
        .iter()
        .flat_map(|sky| lengths.map(|length| Ray::new(Vec3::ZERO, sky.direction(), length)))
        .flatten()
        .collect();
    let light = [0.5, 2.0, 30.0];
    for sigma in [0.0, 1e-6, 0.05, 3.0] {
        let open = fog(sigma, PhaseFunction::HenyeyGreenstein { g: 0.6 });
        for medium in [open, boxed(open)] {
            let ambient = Ambient::new(light, &medium).unwrap();
            for (ambient, before_sky) in [(ambient, true), (ambient.before_surfaces(), false)] {
                let on_backend = backend.upload(&rays).unwrap();
                let mut radiance = backend.zeros::<[f32; 4]>(rays.len()).unwrap();
                backend
                    .add_ambient(&on_backend, &ambient, &mut radiance)
                    .unwrap();
                let radiance = backend.download(&radiance).unwrap();
                for (ray, found) in rays.iter().zip(radiance) {
                    let end = ray.length();
                    let way = medium.length_inside(ray.origin(), ray.direction(), end);
                    let way = f64::from(way);
                    for channel in 0..3 {
                        let sigma_s = f64::from(medium.sigma_s()[channel]);
                        let sigma_t = f64::from(medium.sigma_t()[channel]);
                        let share = -(-sigma_t * way).exp_m1();
                        let is_dark = sigma_s == 0.0 || (!before_sky && end.is_infinite());
                        let truth = match is_dark {
                            true => 0.0,
                            false => sigma_s / sigma_t * share * f64::from(light[channel]),
                        };
                        let off = (f64::from(found[channel]) - truth).abs();
                        // Rounding, and that of the way through the box.
                        assert!(off <= 3e-6 * truth + 1e-12, "{ray:?}: {found:?} {truth}");
                    }
                    assert_eq!(found[3], 0.0);
                }
            }
        }
    }
}

fn an_environment_is_seen_through_fog_with_its_halo<B: LightSurfaces>(backend: &B) {
    for (sigma, distance) in [(0.01, 20.0), (0.05, 40.0)] {
        let medium = fog(sigma, PhaseFunction::Isotropic);
        let environment = environment().at_distance(distance).unwrap();
        let map = EnvironmentMap::new(backend, &environment, Some(&medium)).unwrap();
        let rays = skies();
        for (ray, found) in rays.iter().zip(seen(backend, &rays, &map)) {
            for channel in [0, 2] {
                let coefficient = |value: Vec3| f64::from(value[channel]);
                let truth = environment_in_fog(
                    (coefficient(medium.sigma_s()), coefficient(medium.sigma_t())),
                    f64::from(distance),
                    ray.direction().as_dvec3().normalize(),
                    1e-5,
                    gradient,
                );
                let error = found[channel] / truth - 1.0;
                assert!(
                    error.abs() < Allowed::Environment.error(),
                    "{truth}: {error:e}"
                );
            }
        }
    }
}

fn surfaces_receive_the_light_of_an_environment<B: LightSurfaces>(backend: &B) {
    let points = points();
    let clear = EnvironmentMap::new(backend, &environment(), None).unwrap();
    let pi = std::f64::consts::PI;
    // ∫ max(0, n·ω) (1 + a·ω) dω = π + 2π/3 n·a.
    let of = |normal: DVec3| pi + 2.0 * pi / 3.0 * (gradient(normal) - 1.0);
    for (point, found) in points.iter().zip(received(backend, &points, &clear)) {
        let error = (found.x - of(point.normal().as_dvec3())) / pi;
        assert!(error.abs() < Allowed::EnvironmentLight.error(), "{error:e}");
    }
    // Behind fog an environment of degree 1 is one of degree 1 again: its mean and its
    // slope come from what is seen above and below.
    let medium = fog(0.03, PhaseFunction::Isotropic);
    let environment = environment().at_distance(30.0).unwrap();
    let map = EnvironmentMap::new(backend, &environment, Some(&medium)).unwrap();
    let sigma = (f64::from(medium.sigma_s().x), f64::from(medium.sigma_t().x));
    let through = |direction| environment_in_fog(sigma, 30.0, direction, 1e-5, gradient);
    let mean = 0.5 * (through(DVec3::Y) + through(DVec3::NEG_Y));
    let share = (through(DVec3::Y) - mean) / 0.6;
    for (point, found) in points.iter().zip(received(backend, &points, &map)) {
        let slope = share * (gradient(point.normal().as_dvec3()) - 1.0);
        let error = (found.x - (pi * mean + 2.0 * pi / 3.0 * slope)) / (pi * mean);
        assert!(error.abs() < Allowed::EnvironmentLight.error(), "{error:e}");
    }
    let covered: Vec<SurfacePoint> = points.iter().map(|p| p.with_openness(0.0)).collect();
    assert!(
        received(backend, &covered, &clear)
            .iter()
            .all(|light| *light == DVec3::ZERO)
    );
}

fn the_fourth_component_and_pixels_without_a_surface_are_left_alone<B: LightSurfaces>(backend: &B) {
    let medium = fog(0.1, PhaseFunction::Isotropic);
    let emitter = lamp(Emission::Isotropic, f32::INFINITY);
    let points = backend
        .upload(&[SurfacePoint::default(), points()[0]])
        .unwrap();
    let before = [[1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 0.0, 5.0]];
    let mut radiance = backend.upload(&before).unwrap();
    let lit = LitSurfaces {
        points: &points,
        emitter: &emitter,
        medium: &medium,
    };
    let closed = ClosedForm::new(&medium);
    backend
        .add_surface_scattering(&lit, &closed, &mut radiance)
        .unwrap();
    let map = EnvironmentMap::new(backend, &Environment::even([1.0; 3]).unwrap(), None).unwrap();
    backend
        .add_environment_light(&points, &map, &mut radiance)
        .unwrap();
    let after = backend.download(&radiance).unwrap();
    assert_eq!(after[0], before[0]);
    assert!(after[1][0] > 0.0 && after[1][3] == 5.0);

    let mut short = backend.zeros::<[f32; 4]>(1).unwrap();
    let error = backend
        .add_surface_scattering(&lit, &closed, &mut short)
        .unwrap_err();
    assert!(error.to_string().contains('2'), "{error}");
    let ranged = lamp(Emission::Isotropic, 3.0);
    let lit = LitSurfaces {
        emitter: &ranged,
        ..lit
    };
    let error = backend
        .add_surface_scattering(&lit, &closed, &mut radiance)
        .unwrap_err();
    assert!(error.to_string().contains("range"), "{error}");
}

crepuscular_tests::on_every_backend!(
    the_closed_form_is_the_integral_over_the_hemisphere,
    an_environment_is_seen_through_fog_with_its_halo,
    fog_scatters_ambient_light_by_the_closed_form,
    surfaces_receive_the_light_of_an_environment,
    the_fourth_component_and_pixels_without_a_surface_are_left_alone,
);

crepuscular_tests::on_every_backend!(heavy: quadrature_is_the_integral_over_the_hemisphere);

#[test]
fn the_gpu_agrees_with_the_cpu() {
    let Some(gpu) = suite::gpu() else { return };
    let cpu = Cpu::new();
    let points = points();
    let largest = |of: &[[f32; 4]]| of.iter().flatten().fold(0.0_f32, |a, b| a.max(*b));
    let check = |what: &str, ours: Vec<[f32; 4]>, theirs: Vec<[f32; 4]>| {
        let scale = largest(&ours);
        assert!(scale > 0.0, "{what}");
        for (ours, theirs) in ours.iter().flatten().zip(theirs.iter().flatten()) {
            let error = f64::from((ours - theirs).abs() / scale);
            assert!(
                error < Allowed::GpuSurface.error(),
                "{what}: {ours} {theirs} {error:e}"
            );
        }
    };
    let quadrature = Quadrature::new(Unshadowed, 8).unwrap();
    for (case, (emitter, medium)) in others().iter().enumerate() {
        let lit = (emitter, medium);
        check(
            &format!("case {case}"),
            scattered(&cpu, &points, lit, &quadrature),
            scattered(&gpu, &points, lit, &quadrature),
        );
        let open = Medium::new(medium.sigma_s(), Vec3::ZERO, medium.phase()).unwrap();
        let closed = ClosedForm::new(&open);
        if closed.covers(emitter, &open).is_ok() {
            check(
                &format!("closed form of case {case}"),
                scattered(&cpu, &points, (emitter, &open), &closed),
                scattered(&gpu, &points, (emitter, &open), &closed),
            );
        }
    }
    for medium in [None, Some(boxed(fog(0.3, PhaseFunction::Isotropic)))] {
        let sky = environment();
        let (ours, theirs) = (
            EnvironmentMap::new(&cpu, &sky, medium.as_ref()).unwrap(),
            EnvironmentMap::new(&gpu, &sky, medium.as_ref()).unwrap(),
        );
        let narrow = |light: Vec<DVec3>| -> Vec<[f32; 4]> {
            light
                .iter()
                .map(|light| light.as_vec3().extend(0.0).to_array())
                .collect()
        };
        let rays = skies();
        check(
            "sky",
            narrow(seen(&cpu, &rays, &ours)),
            narrow(seen(&gpu, &rays, &theirs)),
        );
        check(
            "light of the sky",
            narrow(received(&cpu, &points, &ours)),
            narrow(received(&gpu, &points, &theirs)),
        );
    }
}

#[test]
fn the_foot_of_a_wall_sees_half_of_the_sky() {
    let corner = |z: f32, y: f32| Vec3::new(-0.01, y, z);
    let wall = Mesh {
        positions: vec![
            corner(-1e4, -1.0),
            corner(1e4, -1.0),
            corner(1e4, 1e4),
            corner(-1e4, 1e4),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let tracer = Tracer::new(&Geometry::new(&Scene::from(wall)).unwrap());
    let foot = SurfacePoint::new(Vec3::ZERO, Vec3::Y, Vec3::ONE).unwrap();
    let back = SurfacePoint::new(Vec3::ZERO, Vec3::X, Vec3::ONE).unwrap();
    let sky = SurfacePoint::default();
    let found = with_openness(&Cpu::new(), &[foot, back, sky], &tracer, 256);
    assert!(
        (found[0].openness() - 0.5).abs() < 0.5 / 16.0,
        "{:?}",
        found[0]
    );
    assert_eq!(found[1].openness(), 1.0);
    assert_eq!(found[2], sky);
}

/// Shadows in the fog are the same on both backends, given the same map.
#[test]
fn shadowed_fog_lights_surfaces_alike_on_both_backends() {
    let Some(gpu) = suite::gpu() else { return };
    let cpu = Cpu::new();
    let scene = TestScene::new(Embedded::City, 8, 6);
    let points: Vec<SurfacePoint> = scene
        .rays
        .iter()
        .filter(|ray| ray.length().is_finite())
        .map(|ray| {
            let point = ray.at(0.999 * ray.length());
            SurfacePoint::new(point, -ray.direction(), Vec3::ONE).unwrap()
        })
        .collect();
    let emitter = &scene.emitters[0];
    let map = &scenes::maps(&cpu, &scene, 128)[0];
    let lit = (emitter, &scene.medium);
    let open = scattered(&cpu, &points, lit, &Quadrature::new(Unshadowed, 6).unwrap());
    let ours = scattered(&cpu, &points, lit, &Quadrature::new(map, 6).unwrap());
    let resident = map.upload(&gpu).unwrap();
    let theirs = scattered(&gpu, &points, lit, &Quadrature::new(&resident, 6).unwrap());
    let total = |light: &[[f32; 4]]| light.iter().map(|light| f64::from(light[0])).sum::<f64>();
    assert!(total(&ours) < total(&open) && total(&ours) > 0.0);
    // One of the 432 samples of a surface may fall to the other side of the border of a
    // texel: see `GpuRays`.
    let error = (total(&ours) / total(&theirs) - 1.0).abs();
    assert!(error < Allowed::GpuRays.error(), "{error}");
}
