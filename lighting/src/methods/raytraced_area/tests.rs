//! The samplers against closed forms and against each other.

use glam::{DVec2, DVec3, Quat, Vec3};
use gpu_backend::Cpu;

use super::*;
use crate::airlight::EquiAngular;
use crate::scene::{AreaShape, Bounds, Geometry, Instance, Material, Mesh, PhaseFunction, Scene};

/// Nothing that is in the way of anything.
fn no_triangles() -> Tracer {
    let behind = Vec3::new(0.0, 0.0, 90.0);
    plate(behind, behind + Vec3::ONE, Material::default())
}

/// A rectangle of a material of its own.
fn plate(low: Vec3, high: Vec3, material: Material) -> Tracer {
    let corners = [
        low,
        Vec3::new(high.x, low.y, low.z),
        high,
        Vec3::new(low.x, high.y, high.z),
    ];
    let mesh = Mesh {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..Mesh::default()
    };
    let scene = Scene {
        meshes: vec![mesh],
        materials: vec![material],
        instances: vec![Instance::default()],
        ..Scene::default()
    };
    Tracer::new(&Geometry::new(&scene).unwrap())
}

fn panel(size: f32, turn: Quat) -> AreaLight {
    AreaLight {
        corner: Vec3::new(0.3, 1.7, -5.0) - turn * Vec3::new(size, 0.0, size) / 2.0,
        edges: [size * (turn * Vec3::X), size * (turn * Vec3::Z)],
        radiance: Vec3::new(3.0, 2.0, 1.0),
        ..AreaLight::default()
    }
}

fn fog(sigma: f32) -> Medium {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.3 };
    Medium::new(Vec3::splat(sigma), Vec3::splat(0.2 * sigma), phase).unwrap()
}

fn pixel(ray: &Ray, index: u32) -> PixelRay<'_> {
    PixelRay {
        ray,
        index,
        panes: None,
    }
}

/// In thin fog that scatters evenly, nothing but the cosine and the distance is left,
/// and both are in the density: one ray is all it takes.
#[test]
fn one_ray_to_a_small_light_is_exact_in_thin_fog() {
    let tracer = no_triangles();
    let medium = Medium::new(Vec3::splat(1e-7), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let quadrature = EquiAngular::new(256).unwrap();
    let mut checked = 0;
    for turn in 0..24 {
        let turn = Quat::from_rotation_x(0.27 * turn as f32) * Quat::from_rotation_z(0.1);
        let light = panel(1e-4, turn);
        let traced = TracedArea::new(&light, &tracer, &medium).unwrap();
        for index in 0..40 {
            let tilt = index as f32 / 40.0 - 0.5;
            let direction = Vec3::new(tilt, 0.4 - tilt * tilt, -1.0).normalize();
            let length = if index % 3 == 0 { f32::INFINITY } else { 7.0 };
            let ray = Ray::new(Vec3::ZERO, direction, length).unwrap();
            let found = traced.by_points(pixel(&ray, index), 1);
            let expected = traced.by_runs(pixel(&ray, index), 1, &quadrature, &mut Vec::new());
            // What the phase function and the attenuation leave: an f32's rounding.
            // The quadrature has a kink where the light ends, which 256 nodes see.
            let allowed = 1e-4 * expected + 2e-7 * light.radiance * 1e-8 * 1e-7;
            assert!(
                (found - expected).abs().cmple(allowed).all(),
                "{turn} {index}: {found} {expected}"
            );
            checked += usize::from(expected != Vec3::ZERO);
        }
    }
    assert!(checked > 400, "{checked}");
}

/// The mean over many pixels of one sample each is that of many samples.
#[test]
fn both_samplers_have_the_same_mean_whatever_is_in_the_way() {
    let medium = fog(0.1);
    let bounds = Bounds::new(Vec3::new(-4.0, -2.0, -9.0), Vec3::new(4.0, 1.2, 1.0)).unwrap();
    let glass = Material {
        transmission: 0.7,
        base_color: Vec3::new(0.9, 0.5, 0.2),
        ..Material::default()
    };
    let airlight = EquiAngular::new(8).unwrap();
    for material in [Material::default(), glass] {
        let low = Vec3::new(-0.1, 0.9, -6.0);
        let tracer = plate(low, Vec3::new(2.0, 0.8, -4.0), material);
        for medium in [medium, medium.within(bounds)] {
            for shape in [AreaShape::Rectangle, AreaShape::Disk] {
                let light = AreaLight {
                    shape,
                    ..panel(0.8, Quat::IDENTITY)
                };
                let traced = TracedArea::new(&light, &tracer, &medium).unwrap();
                let direction = Vec3::new(0.03, 0.1, -1.0).normalize();
                let ray = Ray::new(Vec3::ZERO, direction, 9.0).unwrap();
                let rays = vec![ray; 512];
                let panes = EyePanes::new(&Cpu::new(), &tracer, &rays);
                let mean = |count: u32, runs: bool| {
                    let all = (0..512).map(|index| {
                        let pixel = PixelRay {
                            ray: &ray,
                            index,
                            panes: panes.as_ref(),
                        };
                        match runs {
                            true => traced.by_runs(pixel, count, &airlight, &mut Vec::new()),
                            false => traced.by_points(pixel, count),
                        }
                    });
                    all.map(|light| light.as_dvec3()).sum::<DVec3>() / 512.0
                };
                let truth = mean(16, true);
                let [few, more] = [mean(1, false), mean(64, false)];
                // A standard deviation of less than the value, over 512 rays: 5 σ.
                let error = (few / truth - 1.0).abs().max_element();
                assert!(error < 0.22, "{few} {truth}");
                let error = (more / truth - 1.0).abs().max_element();
                assert!(error < 0.02, "{more} {truth}");
                assert!((mean(1, true) / truth - 1.0).abs().max_element() < 0.1);
                assert!(truth.min_element() > 0.0);
            }
        }
    }
}

#[test]
fn rays_that_see_no_front_and_lights_that_are_dark_give_nothing() {
    let (tracer, medium) = (no_triangles(), fog(0.1));
    let up = panel(1.0, Quat::from_rotation_x(std::f32::consts::PI));
    let below = Ray::new(Vec3::ZERO, Vec3::NEG_Z, 20.0).unwrap();
    let airlight = EquiAngular::new(2).unwrap();
    let dark = AreaLight {
        radiance: Vec3::ZERO,
        ..panel(1.0, Quat::IDENTITY)
    };
    let vacuum = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let lit = panel(1.0, Quat::IDENTITY);
    for (light, medium, count) in [
        (&up, &medium, 9),
        (&dark, &medium, 9),
        (&lit, &vacuum, 9),
        (&lit, &medium, 0),
    ] {
        let traced = TracedArea::new(light, &tracer, medium).unwrap();
        assert_eq!(traced.by_points(pixel(&below, 3), count), Vec3::ZERO);
        let runs = traced.by_runs(pixel(&below, 3), count, &airlight, &mut Vec::new());
        assert_eq!(runs, Vec3::ZERO);
    }
    let traced = TracedArea::new(&lit, &tracer, &medium).unwrap();
    assert!(traced.by_points(pixel(&below, 3), 9).min_element() > 0.0);
}

/// Right at a point of the light, away from it, through it, and next to the ray.
#[test]
fn rays_along_the_light_are_finite() {
    let (tracer, medium) = (no_triangles(), fog(0.1));
    let light = panel(1.0, Quat::from_rotation_x(0.4));
    let traced = TracedArea::new(&light, &tracer, &medium).unwrap();
    let airlight = EquiAngular::new(4).unwrap();
    for index in 0..64 {
        let [x, y, _] = point_3d(0, rotation(index));
        let (target, _) = traced.surface.point(DVec2::new(x, y));
        for distance in [0.0, 1e-6, 2.0] {
            for along in [Vec3::NEG_Z, Vec3::Y, light.edges[0], Vec3::ONE] {
                let along = along.normalize();
                for length in [0.5, 5.0, f32::INFINITY] {
                    let ray = Ray::new(target - distance * along, along, length).unwrap();
                    let values = [
                        traced.by_points(pixel(&ray, index), 3),
                        traced.by_runs(pixel(&ray, index), 3, &airlight, &mut Vec::new()),
                    ];
                    for value in values {
                        assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
                    }
                }
            }
        }
    }
}

#[test]
fn points_are_even_and_rotations_differ() {
    let n = 512;
    for index in [0, 1, 77] {
        let shift = rotation(index);
        let points: Vec<[f64; 3]> = (0..n).map(|i| point_3d(i, shift)).collect();
        for axis in 0..3 {
            for half in [0.25, 0.5, 0.75] {
                let below = points.iter().filter(|p| p[axis] < half).count();
                let expected = half * f64::from(n);
                assert!(
                    (below as f64 - expected).abs() < 8.0,
                    "{axis} {half}: {below}"
                );
            }
        }
        let flat = (0..n).map(|i| point_2d(i, [shift[0], shift[1]]));
        let corner = flat.filter(|p| p.max_element() < 0.5).count();
        assert!(corner.abs_diff(128) < 6, "{corner}");
    }
    let mean: Vec<f64> = (0..3)
        .map(|axis| (0..4096).map(|i| rotation(i)[axis]).sum::<f64>() / 4096.0)
        .collect();
    assert!(
        mean.iter().all(|mean| (mean - 0.5).abs() < 0.02),
        "{mean:?}"
    );
}
