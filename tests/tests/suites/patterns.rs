//! Lights with a pattern: cookies, narrow cones and ranges, by the evaluator that
//! methods use unless another is asked for.

use crepuscular_tests::frames::{image, inputs};
use crepuscular_tests::suite::Subject;
use glam::{DVec3, Quat, Vec3};
use lighting::airlight::Quadrature;
use lighting::methods::{Registry, Store};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{
    Bounds, Cone, Emission, Falloff, MOST_COOKIE_LINES, Medium, PhaseFunction, Texture,
};
use lighting::visibility::Unshadowed;
use lighting::{Emitter, LitRays, Ray};
use reference::metrics::image_error;
use reference::oracle::airlight::{Airlight, Tolerance, reach};
use reference::oracle::{Fog, Lamp, Line};
use reference::random::noise;
use reference::scenes::TestScene;
use reference::shapes;
use reference::tolerances::Allowed;

crepuscular_tests::on_every_backend!(
    cookies_keep_every_tolerance,
    cookies_of_many_texels_keep_what_their_levels_promise,
    a_cookie_behind_deep_fog_is_dark_at_once,
    lights_behind_the_eye_on_the_axis_are_lights_like_others,
    lights_that_fade_keep_the_tolerance,
    narrow_cones_keep_the_tolerance,
);
crepuscular_tests::on_every_backend!(traced:
    the_default_picture_of_a_narrow_spot_is_right,
    the_default_picture_of_a_cookie_is_right,
);

fn truth(ray: &Ray, emitter: &Emitter, medium: &Medium) -> DVec3 {
    let (line, fog, lamp) = (Line::new(ray), Fog::new(medium), Lamp::new(emitter));
    let mut airlight = Airlight::new(&line, &fog);
    if let Some(reach) = reach(&line, &lamp, &fog) {
        airlight.add_off_the_light(&lamp, reach, &[reach]);
    }
    airlight.total(Tolerance::relative(1e-9)).value
}

/// The largest difference between the airlight of a ray and the truth in units of
/// what is allowed: a share of `scale`'s light on the same ray.
fn worst<B: Subject>(
    backend: &B,
    rays: &[Ray],
    [emitter, scale]: [&Emitter; 2],
    medium: &Medium,
    tolerance: f32,
) -> f64 {
    let found = radiance(backend, rays, emitter, medium, tolerance);
    let truths = rays.iter().map(|ray| truth(ray, emitter, medium));
    let scales: Vec<_> = rays.iter().map(|ray| truth(ray, scale, medium)).collect();
    let worst = |found: &[DVec3], truths: &[DVec3]| {
        let errors = found.iter().zip(truths).zip(&scales);
        let relative = errors.map(|((found, truth), scale)| {
            ((found - truth).abs() / scale.max(DVec3::splat(1e-30))).max_element()
        });
        relative.fold(0.0, f64::max)
    };
    let truths: Vec<_> = truths.collect();
    worst(&found, &truths) / (f64::from(tolerance) + rounding(backend, emitter))
}

/// What positions and directions in f32 add to a tolerance on a GPU; the CPU has them
/// in f64.
fn rounding<B: Subject>(backend: &B, emitter: &Emitter) -> f64 {
    if backend.name() == "cpu" {
        return 0.0;
    }
    // f32 knows directions to 1.2e-7, which counts by the angle of a cone; the square
    // of a ramp that has fallen to a half changes by some six times as much.
    let of_cone = match emitter {
        Emitter::Point(point) => match point.emission() {
            Emission::Spot(spot) => 8e-7 / f64::from(spot.tan_outer()),
            _ => 0.0,
        },
        Emitter::Directional(_) => 0.0,
    };
    Allowed::Evaluator.error() + of_cone
}

fn radiance<B: Subject>(
    backend: &B,
    rays: &[Ray],
    emitter: &Emitter,
    medium: &Medium,
    tolerance: f32,
) -> Vec<DVec3> {
    let quadrature = Quadrature::with_tolerance(medium.phase(), tolerance).unwrap();
    let there = backend.upload(rays).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(rays.len()).unwrap();
    let lit = LitRays::new(&there, emitter, medium);
    backend
        .gather(&lit, &Unshadowed, &quadrature, &mut radiance)
        .unwrap();
    let found = backend.download(&radiance).unwrap();
    found
        .iter()
        .map(|rgb| DVec3::new(rgb[0].into(), rgb[1].into(), rgb[2].into()))
        .collect()
}

fn media() -> [Medium; 4] {
    let fog = |s, a, phase| Medium::new(s, a, phase).unwrap();
    let forward = PhaseFunction::HenyeyGreenstein { g: 0.9 };
    let thin = fog(
        Vec3::splat(0.05),
        Vec3::splat(0.01),
        PhaseFunction::Isotropic,
    );
    let bounds = Bounds::new(Vec3::new(-3.0, -2.5, -3.0), Vec3::new(3.0, 1.0, 3.0)).unwrap();
    [
        thin,
        fog(
            Vec3::new(0.4, 0.8, 1.6),
            Vec3::ZERO,
            PhaseFunction::Rayleigh,
        ),
        fog(Vec3::splat(0.1), Vec3::ZERO, forward),
        thin.within(bounds),
    ]
}

/// Rays across, along and towards a beam from (0, 2, 0) downwards.
fn rays(count: u64, spread: f32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let unit = |k: u64| 2.0 * noise(8 * i + k) - 1.0;
            let depth = 0.1 + 2.9 * noise(8 * i);
            let across = spread * depth * Vec3::new(unit(1), 0.0, unit(2));
            let target = Vec3::new(0.0, 2.0 - depth, 0.0) + across;
            let from = match i % 3 {
                0 => Vec3::new(5.0 * unit(3), unit(4), 5.0 + unit(5)),
                1 => Vec3::new(0.4 * unit(3), 6.0 + unit(4), 0.3 + 0.4 * unit(5)),
                _ => Vec3::new(unit(3), -2.0 + 0.5 * unit(4), unit(5)),
            };
            let length = if i % 2 == 0 { 9.0 } else { f32::INFINITY };
            Ray::new(from, target - from, length).unwrap()
        })
        .collect()
}

fn down() -> Quat {
    Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2)
}

fn spot(cone: Cone, texture: Option<Texture>) -> Emitter {
    let emission = Emission::spot(down(), cone, texture).unwrap();
    let position = Vec3::new(0.0, 2.0, 0.0);
    Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).unwrap()
}

fn noisy(width: u32, height: u32) -> Texture {
    let texels = (0..u64::from(width * height)).map(|i| {
        let channel = |k: u64| noise(7919 + 3 * i + k);
        Vec3::new(channel(0), channel(1), channel(2))
    });
    Texture::new(width, height, texels.collect()).unwrap()
}

/// A cookie that a ray across it sees as so many lines of noise, or of waves.
fn long(columns: u32, wave: Option<f32>) -> Texture {
    let texels = (0..u64::from(2 * columns)).map(|i| {
        let channel = |k: u64| match wave {
            None => noise(104_729 + 3 * i + k),
            Some(texels) => {
                let phase = std::f32::consts::TAU * (i % u64::from(columns)) as f32 / texels;
                0.5 + 0.5 * (phase + k as f32).cos()
            }
        };
        Vec3::new(channel(0), channel(1), channel(2))
    });
    Texture::new(columns, 2, texels.collect()).unwrap()
}

/// Noise is the hardest pattern there is: every texel is a kink.
///
/// What is wrong with a ray is the sum of what is wrong with its pieces, each relative
/// to its own light without the cookie: none can be more than the worst piece is. The
/// error of a piece depends on six numbers (how much the angle, the depth, the tilt, the
/// ramp and its curvature change over it, and how the four texels differ), of which the
/// rules take powers of four and more: within a factor of 1.3 in each it changes by no
/// more than three. 80 lights and fogs, 60 rays and up to 200 pieces of each, three
/// channels apart, are two million pieces, ten for each of the 8^6 cells in which the
/// numbers differ by that. On the CPU nothing is allowed beyond the tolerance.
fn cookies_keep_every_tolerance<B: Subject>(backend: &B) {
    let mut failures = Vec::new();
    for [width, height] in [[1, 1], [2, 3], [8, 5], [64, 64], [200, 30]] {
        for cone in [[0.0_f32, 0.035], [0.2, 0.5], [0.0, 0.7], [1.0, 1.5]] {
            let [inner, outer] = cone;
            let cone = Cone { inner, outer };
            let light = spot(cone, Some(noisy(width, height)));
            let plain = spot(cone, None);
            let rays = rays(60, outer.tan().min(2.0));
            for medium in media() {
                for tolerance in [1e-3, 1e-4, 1e-5] {
                    let worst = worst(backend, &rays, [&light, &plain], &medium, tolerance);
                    if !(worst <= 1.0) {
                        failures.push(format!(
                            "{width}x{height} {cone:?} {tolerance}: {worst} of what is allowed"
                        ));
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Rays that cross more lines than are walked one by one: exact up to
/// [`MOST_COOKIE_LINES`], and beyond within what levels promise of the light that there
/// is without a cookie.
///
/// A level changes a pattern along the ray by its own second differences over two
/// texels of it, of which a ray crosses 2048 or more: of noise, whose sum stays but for
/// how the light varies over such a texel, and of waves, of which a level that has not
/// two texels for each is even. Three channels of 60 rays are 180 of either.
fn cookies_of_many_texels_keep_what_their_levels_promise<B: Subject>(backend: &B) {
    let cone = Cone {
        inner: 0.5,
        outer: 0.6,
    };
    let [thin, _, _, _] = media();
    let plain = spot(cone, None);
    let rays = rays(60, 0.6);
    for (columns, noisy, wavy) in [
        (MOST_COOKIE_LINES - 2, 1e-5, 1e-5),
        (9000, 8e-3, 2e-5),
        (12_000, 8e-3, 2e-5),
        (70_000, 8e-3, 8e-5),
    ] {
        for (wave, allowed) in [(None, noisy), (Some(32.0), wavy)] {
            let light = spot(cone, Some(long(columns, wave)));
            let found = radiance(backend, &rays, &light, &thin, 1e-5);
            let errors = rays.iter().zip(found).map(|(ray, found)| {
                let scale = truth(ray, &plain, &thin).max(DVec3::splat(1e-30));
                ((found - truth(ray, &light, &thin)).abs() / scale).max_element()
            });
            let largest = errors.fold(0.0, f64::max);
            println!("{columns} {wave:?}: {largest:.1e}");
            assert!(
                largest <= allowed + rounding(backend, &light),
                "{columns} {wave:?}: {largest:e}"
            );
        }
    }
}

/// Rays on which the light lies exactly, behind the eye, and all but exactly.
fn lights_behind_the_eye_on_the_axis_are_lights_like_others<B: Subject>(backend: &B) {
    let cone = Cone {
        inner: 0.2,
        outer: 0.5,
    };
    let [thin, _, _, _] = media();
    for light in [spot(cone, None), spot(cone, Some(noisy(8, 5)))] {
        let rays = [0.0, 1e-30, 1e-12, 1e-6, 1e-3].map(|off| {
            let eye = Vec3::new(off, -1.0, 0.0);
            Ray::new(eye, Vec3::NEG_Y, 9.0).unwrap()
        });
        let found = radiance(backend, &rays, &light, &thin, 1e-5);
        for (found, ray) in found.iter().zip(&rays) {
            let expected = truth(ray, &light, &thin);
            let error = (found - expected).abs().max_element() / expected.max_element();
            assert!(
                error <= 1e-5 + rounding(backend, &light),
                "{ray:?}: {found} {expected}"
            );
        }
    }
}

/// Fog through which nothing gets is as quick as any, however far it reaches.
fn a_cookie_behind_deep_fog_is_dark_at_once<B: Subject>(backend: &B) {
    let cone = Cone {
        inner: 0.2,
        outer: 0.5,
    };
    let light = spot(cone, Some(noisy(64, 64)));
    let even = PhaseFunction::Isotropic;
    // From below, far away: the ray comes nearer to the light all the way.
    let eye = Vec3::new(0.0, -1e8, 10.0);
    let towards = Vec3::new(0.0, 2.0, 0.0) - eye;
    let ray = Ray::new(eye, towards, f32::INFINITY).unwrap();
    for (sigma, is_dark) in [
        (Vec3::splat(1e3), true),
        (Vec3::new(1e3, 1e3, 1e-12), false),
    ] {
        let medium = Medium::new(sigma, Vec3::ZERO, even).unwrap();
        let found = radiance(backend, &[ray], &light, &medium, 1e-5)[0];
        assert!(
            found.x == 0.0 && found.y == 0.0 && (found.z == 0.0) == is_dark,
            "{found}"
        );
    }
}

fn lights_that_fade_keep_the_tolerance<B: Subject>(backend: &B) {
    let cone = Cone {
        inner: 0.2,
        outer: 0.5,
    };
    let turned = Emission::spot(down(), cone, None).unwrap();
    let cookie = Emission::spot(down(), cone, Some(noisy(8, 5))).unwrap();
    let normal = Vec3::NEG_Y;
    for emission in [
        Emission::Isotropic,
        Emission::Cosine { normal },
        turned,
        cookie,
    ] {
        for range in [1.0, 3.0, 50.0] {
            let position = Vec3::new(0.0, 2.0, 0.0);
            let light = Emitter::point(position, Vec3::ONE, range, emission.clone()).unwrap();
            let (hard, light) = (light.clone(), light.with_falloff(Falloff::Smooth));
            let rays = rays(60, 0.55);
            for medium in media() {
                for tolerance in [1e-3, 1e-4, 1e-5] {
                    let worst = worst(backend, &rays, [&light, &hard], &medium, tolerance);
                    assert!(
                        worst <= 1.0,
                        "{emission:?} {range} {tolerance}: {worst} of what is allowed"
                    );
                }
            }
        }
    }
}

/// Relative to their own light, a small part of that of a point.
fn narrow_cones_keep_the_tolerance<B: Subject>(backend: &B) {
    let [thin, _, _, _] = media();
    for degrees in [0.5_f32, 1.0, 2.0, 5.0] {
        for share in [0.0, 0.5, 0.9] {
            let outer = degrees.to_radians();
            let inner = share * outer;
            let light = spot(Cone { inner, outer }, None);
            let rays = rays(60, 0.7 * outer);
            let worst = worst(backend, &rays, [&light, &light], &thin, 1e-4);
            assert!(
                worst <= 1.0,
                "{degrees} {share}: {worst} of what is allowed"
            );
        }
    }
}

/// A beam from the left, 1.7° to its edge, that crosses the picture in front of
/// nothing.
fn the_default_picture_of_a_narrow_spot_is_right<B: Subject>(backend: &B) {
    let mut test_scene = TestScene::new(Embedded::Coil, 17, 13);
    let eye = test_scene.camera.eye();
    let rotation = test_scene.camera.rotation();
    let [right, up, back] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| rotation * axis);
    let outer = 1.7_f32.to_radians();
    let cone = Cone {
        inner: 0.4 * outer,
        outer,
    };
    let turned = rotation * Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let emission = Emission::spot(turned, cone, None).unwrap();
    let position = eye - 8.0 * back - 5.0 * right + 0.03 * up;
    let light = Emitter::point(position, Vec3::splat(2000.0), f32::INFINITY, emission).unwrap();
    test_scene.emitters = vec![light];
    test_scene.geometry = shapes::nothing();
    test_scene.tracer = Tracer::new(&test_scene.geometry);
    let end = |ray: &Ray| Ray::new(ray.origin(), ray.direction(), 28.0).unwrap();
    test_scene.rays = test_scene.rays.iter().map(end).collect();
    test_scene.hits = vec![None; test_scene.rays.len()];
    let error = default_error(backend, &test_scene);
    assert!(error.mean > 0.0 && error.rel_p99 <= 1e-4, "{error:?}");
}

fn the_default_picture_of_a_cookie_is_right<B: Subject>(backend: &B) {
    let test_scene = TestScene::new(Embedded::TexturedSpot, 64, 36);
    let error = default_error(backend, &test_scene);
    println!("{error:?}");
    assert!(error.rmse <= 1e-4, "{error:?}");
}

/// Of `exact × quadrature`, which is what pictures are made with.
fn default_error<B: Subject>(
    backend: &B,
    test_scene: &TestScene,
) -> reference::metrics::ImageError {
    let host = Store::new();
    let inputs = inputs(test_scene, 64, &host);
    let registry = Registry::standard();
    let entry = registry.find("exact x quadrature").unwrap();
    let picture = image(backend, inputs, &entry, entry.about().usual).unwrap();
    image_error(&picture.unwrap(), &test_scene.truth())
}
