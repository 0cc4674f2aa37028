//! The part without a device, and positions against the CPU with one.

use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, assert_same_layout};

use super::locate::{LOCATE, Parameters};
use super::*;
use crate::numeric::{ATAN, TAN_EIGHTH};
use crate::{Light, Locate, Resolution, Space, Spacing, ViewVolume};

/// Stands for the bindings.
const CONTRACT: &str = "fn epi_bound(index: u32) -> vec2<f32> { return vec2(f32(index)); }";

#[test]
fn the_part_is_fit_for_other_shaders_and_has_the_constants_of_rust() {
    Shader::new(&[EPIPOLAR])
        .and_then(|alone| alone.require_part(&["epi_"]))
        .unwrap();
    let shader = Shader::new(&[EPIPOLAR, PHI, CONTRACT]).unwrap();
    shader.require_part(&["epi_"]).unwrap();
    let value = |name: &str| shader.values(name).unwrap();
    let wide = |v: f32| f64::from(v);
    assert_eq!(value("epi_ATAN"), ATAN.map(wide));
    assert_eq!(value("epi_TAN_EIGHTH"), [wide(TAN_EIGHTH)]);
    assert_eq!(value("epi_INFINITE"), [wide(f32::MAX)]);
    assert_eq!(value("epi_PI"), [wide(std::f32::consts::PI)]);
    assert_eq!(value("epi_FARTHEST"), [wide(crate::FARTHEST)]);
    assert_same_layout!(
        shader,
        "epi_Lattice",
        LatticeRecord {
            eye,
            distance,
            axis,
            directional,
            right,
            alpha_scale,
            up,
            theta_scale,
            light,
            wraps,
            slope_high,
            alpha,
            slope_low,
            theta,
            largest,
            bits,
            alpha_start,
            theta_centre,
            thinnest,
            starts_on_axis,
        }
    );
    let step = Shader::new(LOCATE).unwrap();
    assert_same_layout!(step, "Parameters", Parameters { lattice, count });
}

#[test]
fn positions_agree_with_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let eye = Vec3::new(0.2, 1.7, 0.4);
    let camera = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], 0.0, 30.0).unwrap();
    let around = ViewVolume::all_around(0.0, 30.0).unwrap();
    // Points on all orders of magnitude of distance from eye and light.
    let points: Vec<[f32; 4]> = (0..20_000_u32)
        .map(|i| {
            let random = |k: u32| {
                let bits = (i * 4 + k).wrapping_mul(2_654_435_761);
                (bits ^ (bits >> 15)).wrapping_mul(0x9E37_79B9) as f32 / 4_294_967_296.0
            };
            let v = Vec3::new(random(0), random(1), random(2)) - 0.5;
            (eye + v * (12.0 * random(3) - 7.0).exp2())
                .extend(0.0)
                .into()
        })
        .collect();
    for light in [
        Light::point(Vec3::new(1.0, 2.0, -5.0)).unwrap(),
        Light::point(Vec3::new(9.0, 4.0, -2.0)).unwrap(),
        Light::directional(Vec3::new(0.1, -1.0, 0.3)).unwrap(),
    ] {
        for view in [&camera, &around] {
            let space = Space::new(light, eye).unwrap();
            let resolution = Resolution::new(256, 256, 128).unwrap();
            let lattice = Lattice::new(space, view, resolution, Spacing::Angle).unwrap();
            let mut expected = vec![[0.0; 4]; points.len()];
            Cpu::new().locate(&lattice, &points, &mut expected).unwrap();
            let there = gpu.upload(&points).unwrap();
            let mut found = gpu.zeros(points.len()).unwrap();
            gpu.locate(&lattice, &there, &mut found).unwrap();
            let found = gpu.download(&found).unwrap();
            let ranges = lattice.ranges();
            let alpha_width = (ranges.alpha()[1] - ranges.alpha()[0]) as f32 / 256.0;
            let theta_width = ranges.theta_extent() as f32 / 256.0;
            for ((e, f), point) in expected.iter().zip(&found).zip(&points) {
                let place = space.coordinates(Vec3::new(point[0], point[1], point[2]));
                let error = |k: usize| (e[k] - f[k]).abs();
                // Twice 8e-7 rad, and the rounding of a position.
                assert!(error(0) <= 1.6e-6 / alpha_width + 3e-5);
                // At ±π the same plane has two positions.
                let apart = error(1).min((error(1) - 256.0).abs());
                let sine = place.ray.alpha.unit()[1];
                assert!(apart <= 1.6e-6 / theta_width / sine + 3e-5);
                let bit = (e[2] as usize).min(127);
                let width =
                    Vec2::from(lattice.bounds()[bit]).perp_dot(lattice.bounds()[bit + 1].into());
                let size = if space.is_directional() { 30.0 } else { 1.0 };
                assert!(error(2) <= 1.6e-6 * size / width + 3e-5, "{e:?} {f:?}");
            }
            let mut short = gpu.zeros(3).unwrap();
            assert!(gpu.locate(&lattice, &there, &mut short).is_err());
        }
    }
}

#[test]
fn next_to_the_axis_shaders_keep_the_digits_of_f32() {
    let Some(gpu) = testing::gpu() else { return };
    let eye = Vec3::new(0.21, 1.73, 0.42);
    for light in [
        Vec3::new(1.03, 2.07, -5.11),
        Vec3::new(-3.3, 1.9, 0.2),
        Vec3::new(0.1, 9.7, 2.3),
    ] {
        let to_light = light.as_dvec3() - eye.as_dvec3();
        let points: Vec<[f32; 4]> = (0..3000_u32)
            .map(|i| {
                // From 6e-8 to 1e-5 rad off, before and behind the light.
                let angle = f64::from(i).sqrt() * 2.4;
                let size = to_light.length() * (-24.0 + 7.0 * f64::from(i) / 3000.0).exp2();
                let [right, up] = [1, 2].map(|k| {
                    Space::new(Light::point(light).unwrap(), eye)
                        .unwrap()
                        .frame64()[k]
                });
                let beside = size * (angle.cos() * right + angle.sin() * up);
                let along = 0.2 + 2.5 * (0.618 * f64::from(i)).fract();
                let point = eye.as_dvec3() + along * to_light + beside;
                point.as_vec3().extend(0.0).into()
            })
            .collect();
        let space = Space::new(Light::point(light).unwrap(), eye).unwrap();
        let view =
            ViewVolume::perspective(to_light.as_vec3(), Vec3::ONE, [1e-5; 2], 0.1, 30.0).unwrap();
        let resolution = Resolution::new(256, 256, 128).unwrap();
        let lattice = Lattice::new(space, &view, resolution, Spacing::Angle).unwrap();
        let mut expected = vec![[0.0; 4]; points.len()];
        Cpu::new().locate(&lattice, &points, &mut expected).unwrap();
        let there = gpu.upload(&points).unwrap();
        let mut found = gpu.zeros(points.len()).unwrap();
        gpu.locate(&lattice, &there, &mut found).unwrap();
        let found = gpu.download(&found).unwrap();
        let [low, high] = lattice.ranges().alpha();
        let alpha_width = (high - low) / 256.0;
        let theta_width = lattice.ranges().theta_extent() / 256.0;
        for ((e, f), point) in expected.iter().zip(&found).zip(&points) {
            let place = space.coordinates(Vec3::new(point[0], point[1], point[2]));
            let alpha = f64::from(place.ray.alpha.radians());
            // 2⁻³³ of coordinates of up to twice the distance, 6 roundings, and
            // the angle function.
            let error = 2.4e-10 + 1e-6 * alpha;
            let apart = |k: usize| f64::from((e[k] - f[k]).abs());
            assert!(apart(0) <= error / alpha_width + 3e-5, "{e:?} {f:?}");
            let around = apart(1).min((apart(1) - 256.0).abs());
            let tolerance = (error / alpha + 1e-6) / theta_width + 3e-5;
            assert!(around <= tolerance, "{e:?} {f:?} {alpha:e}");
        }
    }
}
