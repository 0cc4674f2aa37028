//! The lamps themselves: how far and how much they light surfaces.

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{
    Camera, Emission, Falloff, Geometry, Instance, Material, Mesh, PhaseFunction, Scene,
};
use lighting::surface;
use reference::oracle::Lamp;

use super::{fog, lamp, rgb, spot};

/// `ρ/π I w(d) cos θ e^{−σ_t (d + D)} / d²` from the definition, in f64, of lights with
/// every window and pattern, on a floor that they reach in part.
#[test]
fn surfaces_are_lit_as_far_and_as_much_as_the_windows_of_lights_say() {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let albedo = Vec3::new(0.9, 0.5, 0.3);
    let floor = Scene {
        meshes: vec![Mesh {
            positions: vec![
                corner(-9.0, -9.0),
                corner(-9.0, 9.0),
                corner(9.0, 9.0),
                corner(9.0, -9.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(0),
            ..Mesh::default()
        }],
        materials: vec![Material {
            base_color: albedo,
            ..Material::default()
        }],
        instances: vec![Instance::default()],
        ..Scene::default()
    };
    let geometry = Geometry::new(&floor).unwrap();
    let tracer = Tracer::new(&geometry);
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let camera = Camera::new(Vec3::new(0.4, 4.0, -0.3), down, 1.2).unwrap();
    let cpu = Cpu::new();
    let view = View::new(&cpu, &camera, &tracer, 33, 33).unwrap();
    let medium = fog(0.1, PhaseFunction::Isotropic);
    let normal = Vec3::new(0.1, -1.0, 0.2).normalize();
    for emission in [
        Emission::Isotropic,
        Emission::Cosine { normal },
        spot(0.5, 0.9),
    ] {
        for range in [2.0, 2.5, 40.0] {
            for falloff in [Falloff::Hard, Falloff::Smooth] {
                let emitter = lamp(emission.clone(), range).with_falloff(falloff);
                let lights = std::slice::from_ref(&emitter);
                let found = surface::radiance(
                    &cpu,
                    &view,
                    &floor,
                    &geometry,
                    &tracer,
                    lights,
                    Some(&medium),
                );
                let Lamp::Point(light) = Lamp::new(&emitter) else {
                    panic!("a point was made");
                };
                let mut lit = 0;
                for (ray, found) in view.rays().iter().zip(&found) {
                    let point = ray.at(ray.length()).as_dvec3();
                    let offset = light.position - point;
                    let d = offset.length();
                    let near_edge = (d / f64::from(range) - 1.0).abs() < 1e-5;
                    if near_edge {
                        continue;
                    }
                    let reaches = if d < f64::from(range) { 1.0 } else { 0.0 };
                    let depth = medium.sigma_t().as_dvec3() * (d + f64::from(ray.length()));
                    let arrives = light.emission(-offset / d) * light.fading(d) * reaches;
                    let expected = albedo.as_dvec3() / std::f64::consts::PI
                        * light.intensity
                        * arrives
                        * (offset.y / (d * d * d))
                        * (-depth).exp();
                    // Next to a range or a rim there is less light than rounding of what
                    // there would be without.
                    let whole = light.intensity.max_element() / (d * d);
                    let error = (rgb(*found) - expected).abs().max_element();
                    assert!(
                        error <= 1e-6 * whole,
                        "{emission:?} {range} {falloff:?} {point}: {found:?} {expected}"
                    );
                    lit += usize::from(expected.x > 0.0);
                }
                assert!(lit > 20, "{lit}");
            }
        }
    }
}
