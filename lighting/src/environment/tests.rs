use glam::Vec3;
use gpu_backend::Cpu;

use super::*;
use crate::scene::{Bounds, Medium, PhaseFunction};

fn fog() -> Medium {
    let sigma_s = Vec3::new(0.02, 0.02, 0.01);
    Medium::new(sigma_s, 0.1 * sigma_s, PhaseFunction::Isotropic).unwrap()
}

fn rays() -> Vec<Ray> {
    (0..200)
        .map(|i| {
            let (y, turn) = (1.0 - (i as f32 + 0.5) / 100.0, 2.4 * i as f32);
            let r = (1.0 - y * y).sqrt();
            let direction = Vec3::new(r * turn.cos(), y, r * turn.sin());
            Ray::new(Vec3::ZERO, direction, f32::INFINITY).unwrap()
        })
        .collect()
}

#[test]
fn an_even_environment_is_seen_evenly_as_bright_as_the_total_says() {
    let even = Environment::even([1.0; 3])
        .unwrap()
        .at_distance(40.0)
        .unwrap();
    let map = EnvironmentMap::new(&Cpu::new(), &even, Some(&fog())).unwrap();
    let expected = |sigma_t: f64| {
        let t = 40.0 * sigma_t;
        let halo = t / 1.1 * airlight::point_spread::exact::total(t);
        (-t).exp() * (1.0 + halo)
    };
    for ray in rays() {
        let seen = map.seen(&ray);
        for (seen, sigma_t) in [(seen.x, 0.022), (seen.z, 0.011)] {
            let error = f64::from(seen) / expected(sigma_t) - 1.0;
            // 1e-4 of the weights of the convolution.
            assert!(error.abs() < 2e-4, "{error}");
        }
    }
}

#[test]
fn without_fog_a_picture_is_seen_as_it_is() {
    let texels: Vec<[f32; 3]> = (0..32 * 16).map(|i| [i as f32, 1.0, 0.0]).collect();
    let environment = Environment::new(32, 16, texels).unwrap();
    let map = EnvironmentMap::new(&Cpu::new(), &environment, None).unwrap();
    let ahead = Ray::new(Vec3::ZERO, Vec3::new(1e-3, 0.1, -1.0), f32::INFINITY).unwrap();
    let seen = map.seen(&ahead);
    // Between columns 15 and 16, rows 6 and 7, at a latitude of 0.4 rows from the latter.
    assert!((seen.x - (15.5 + 32.0 * 7.0)).abs() < 14.0, "{seen}");
    assert!((seen.y - 1.0).abs() < 1e-6 && seen.z == 0.0);
}

#[test]
fn surfaces_receive_what_an_even_environment_sends_them() {
    let even = Environment::even([1.0, 2.0, 0.0]).unwrap();
    let map = EnvironmentMap::new(&Cpu::new(), &even, None).unwrap();
    for ray in rays() {
        let light = map.irradiance(Vec3::ZERO, ray.direction());
        let error = light.x / std::f32::consts::PI - 1.0;
        assert!(error.abs() < 0.005, "{error}");
        assert!((light.y - 2.0 * light.x).abs() < 1e-5 && light.z == 0.0);
    }
}

#[test]
fn light_comes_from_where_the_picture_is_bright() {
    let mut texels = vec![[0.0; 3]; 64 * 32];
    // To the right, on the horizon.
    texels[16 * 64 + 48] = [1000.0; 3];
    let environment = Environment::new(64, 32, texels).unwrap();
    let map = EnvironmentMap::new(&Cpu::new(), &environment, None).unwrap();
    let of = |normal| map.irradiance(Vec3::ZERO, normal).x;
    let solid_angle = std::f32::consts::PI.powi(2) / 1024.0;
    assert!((of(Vec3::X) / (1000.0 * solid_angle) - 1.0).abs() < 0.03);
    assert_eq!(of(Vec3::NEG_X), 0.0);
}

#[test]
fn fog_in_a_box_attenuates_by_what_lies_in_the_direction() {
    let bounds = Bounds::new(Vec3::new(-5.0, -5.0, -50.0), Vec3::splat(5.0)).unwrap();
    let even = Environment::even([1.0; 3]).unwrap();
    let absorbing = Medium::new(Vec3::ZERO, Vec3::splat(0.1), PhaseFunction::Isotropic).unwrap();
    let map = EnvironmentMap::new(&Cpu::new(), &even, Some(&absorbing.within(bounds))).unwrap();
    let seen = |direction| {
        map.seen(&Ray::new(Vec3::ZERO, direction, f32::INFINITY).unwrap())
            .x
    };
    assert!((seen(Vec3::NEG_Z) / (-5.0_f32).exp() - 1.0).abs() < 1e-5);
    assert!((seen(Vec3::Y) / (-0.5_f32).exp() - 1.0).abs() < 1e-5);

    // With the halo of as much fog all around.
    let sigma_s = Vec3::splat(0.1);
    let white = Medium::new(sigma_s, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let boxed = EnvironmentMap::new(&Cpu::new(), &even, Some(&white.within(bounds))).unwrap();
    for (direction, way) in [
        (Vec3::NEG_Z, 50.0),
        (Vec3::Y, 5.0),
        (Vec3::ONE.normalize(), 75_f32.sqrt()),
    ] {
        let ray = Ray::new(Vec3::ZERO, direction, f32::INFINITY).unwrap();
        let ball = even.clone().at_distance(way).unwrap();
        let ball = EnvironmentMap::new(&Cpu::new(), &ball, Some(&white)).unwrap();
        let ratio = boxed.seen(&ray).x / ball.seen(&ray).x;
        assert!((ratio - 1.0).abs() < 0.01, "{direction}: {ratio}");
    }
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    let even = Environment::even([1.0; 3]).unwrap();
    let far = even.clone().at_distance(100.0).unwrap();
    let cpu = Cpu::new();
    let error = |environment: &Environment, medium: Option<&Medium>| {
        EnvironmentMap::new(&cpu, environment, medium).unwrap_err()
    };
    assert_eq!(error(&even, Some(&fog())), EnvironmentError::NoDistance);
    assert_eq!(error(&far, None), EnvironmentError::UnusedDistance);
    let boxed = fog().within(Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap());
    assert_eq!(error(&far, Some(&boxed)), EnvironmentError::UnusedDistance);
    for value in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(Environment::even([0.0, value, 0.0]).is_err());
        assert!(even.clone().at_distance(value).is_err());
    }
    assert!(Environment::new(0, 0, Vec::new()).is_err());
    assert!(Environment::new(2, 2, vec![[0.0; 3]; 3]).is_err());
}

/// The integral of the definition, over directions by the phase function's own
/// normalisation and along the ray by a midpoint rule in f64.
#[test]
fn ambient_light_is_the_integral_along_the_ray() {
    let sigma_s = Vec3::new(0.02, 0.3, 0.0);
    let open = Medium::new(sigma_s, Vec3::new(0.01, 0.0, 0.2), PhaseFunction::Rayleigh).unwrap();
    let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -6.0), Vec3::new(3.0, 1.0, -1.0)).unwrap();
    let light = Vec3::new(2.0, 0.5, 7.0);
    for (medium, ways) in [(open, [3.0, 40.0]), (open.within(bounds), [2.0, 5.0])] {
        let ambient = Ambient::new(light.to_array(), &medium).unwrap();
        for (length, way) in [3.0, 40.0].into_iter().zip(ways) {
            let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, length).unwrap();
            let seen = ambient.seen(&ray);
            let steps = 4000;
            let step = way / f64::from(steps);
            for channel in 0..3 {
                let (s, t) = (medium.sigma_s()[channel], medium.sigma_t()[channel]);
                let sum: f64 = (0..steps)
                    .map(|i| (-f64::from(t) * step * (f64::from(i) + 0.5)).exp() * step)
                    .sum();
                let truth = f64::from(s * light[channel]) * sum;
                let error = (f64::from(seen[channel]) - truth).abs();
                assert!(error <= 1e-5 * truth, "{channel}: {seen} {truth}");
            }
        }
    }
}

/// A white furnace: fog that absorbs nothing before a wall as bright as what lights the
/// fog is not to be seen.
#[test]
fn ambient_light_replaces_what_white_fog_hides() {
    let white = Medium::new(
        Vec3::new(0.001, 0.1, 5.0),
        Vec3::ZERO,
        PhaseFunction::HenyeyGreenstein { g: 0.8 },
    )
    .unwrap();
    let ambient = Ambient::new([1.0; 3], &white).unwrap();
    for length in [0.0, 1e-6, 0.1, 7.0, 1e4, f32::INFINITY] {
        let Some(ray) = Ray::new(Vec3::ZERO, Vec3::X, length) else {
            continue;
        };
        let wall = (-white.sigma_t() * length).exp();
        let sum = ambient.seen(&ray) + wall;
        assert!((sum - 1.0).abs().max_element() < 1e-6, "{length}: {sum}");
    }
}

#[test]
fn ambient_light_needs_fog_that_scatters() {
    let ray = |length| Ray::new(Vec3::ZERO, Vec3::NEG_Z, length).unwrap();
    let black = Medium::new(Vec3::ZERO, Vec3::splat(0.1), PhaseFunction::Isotropic).unwrap();
    let vacuum = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let beside = Bounds::new(Vec3::splat(1.0), Vec3::splat(2.0)).unwrap();
    for medium in [black, vacuum, fog().within(beside)] {
        let ambient = Ambient::new([1.0; 3], &medium).unwrap();
        for length in [1.0, f32::INFINITY] {
            assert_eq!(ambient.seen(&ray(length)), Vec3::ZERO);
        }
    }
    let surfaces = Ambient::new([1.0; 3], &fog()).unwrap().before_surfaces();
    assert_eq!(surfaces.seen(&ray(f32::INFINITY)), Vec3::ZERO);
    assert!(surfaces.seen(&ray(1e6)).min_element() > 0.5);
    for value in [-1.0, f32::NAN, f32::INFINITY] {
        let error = Ambient::new([0.0, value, 0.0], &fog()).unwrap_err();
        assert!(matches!(error, EnvironmentError::Ambient { .. }));
    }
}

#[cfg(feature = "wgpu")]
#[test]
fn shaders_compile_and_see_the_scene_as_it_is() {
    use super::gpu::{AMBIENT, AmbientRecord, LIGHT, SKY, Scene};
    use gpu_backend::assert_same_layout;
    use gpu_backend::testing::Shader;

    for parts in [&SKY[..], &LIGHT[..]] {
        let shader = Shader::new(parts).unwrap();
        assert_same_layout!(
            shader,
            "Scene",
            Scene {
                medium,
                sky_width,
                sky_height,
                halo_width,
                halo_height,
                levels,
                count,
                longest,
                distance
            }
        );
    }

    let shader = Shader::new(&AMBIENT).unwrap();
    assert_same_layout!(
        shader,
        "Ambient",
        AmbientRecord {
            medium,
            radiance,
            count,
            before_sky,
            padding_a,
            padding_b,
            padding_c
        }
    );
}
