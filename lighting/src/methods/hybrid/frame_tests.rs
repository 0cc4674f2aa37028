//! The method of the list: lights, threads, and rays of any pixels.

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use reference::random::Random;

use crate::methods::{Frame, FrameInputs, Registry, Selection, Store};
use crate::scene::{Camera, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};
use crate::{Emitter, Ray};

const HYBRID: &str = "hybrid x gauss-8";

/// Balls of triangles above a floor.
fn geometry() -> Geometry {
    let mut random = Random::new(5);
    let mut positions = Vec::new();
    for _ in 0..12 {
        let centre = Vec3::from(random.vector(2.0)) - 6.0 * Vec3::Z;
        for _ in 0..12 {
            positions.extend([0; 3].map(|_| centre + Vec3::from(random.vector(0.4))));
        }
    }
    let floor = [(-9.0, -15.0), (9.0, -15.0), (0.0, 9.0)];
    positions.extend(floor.map(|(x, z)| Vec3::new(x, -2.5, z)));
    let count = positions.len() as u32 / 3;
    let mesh = Mesh {
        positions,
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).unwrap()
}

fn lights() -> [Emitter; 3] {
    let point =
        |position, range| Emitter::point(position, Vec3::ONE, range, Emission::Isotropic).unwrap();
    [
        point(Vec3::new(0.3, 0.2, -5.5), f32::INFINITY),
        point(Vec3::new(4.0, 5.0, -3.0), 12.0),
        Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap(),
    ]
}

fn camera() -> Camera {
    Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 0.9).unwrap()
}

fn rays([width, height]: [u32; 2]) -> Vec<Ray> {
    let pixels = (0..width * height).map(|i| [i % width, i / width].map(|at| at as f32 + 0.5));
    let ray = |[x, y]: [f32; 2]| {
        let direction = camera().direction(x, y, width, height);
        Ray::new(camera().eye(), direction, 12.0).unwrap()
    };
    pixels.map(ray).collect()
}

/// The light along rays, which are those of some pixels of a picture.
fn picture(
    name: &str,
    cpu: &Cpu,
    emitters: &[Emitter],
    size: [u32; 2],
    rays: &[Ray],
    pixels: Option<&[u32]>,
) -> Vec<[f32; 4]> {
    let medium = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let (geometry, host, store) = (geometry(), Store::new(), Store::<Host>::new());
    let inputs = FrameInputs {
        emitters,
        areas: &[],
        medium: &medium,
        height_fog: None,
        geometry: &geometry,
        translucent: &[],
        camera: &camera(),
        size,
        rays,
        hits: &vec![None; rays.len()],
        map: 256,
        host: &host,
        selection: Selection {
            pixels,
            ..Selection::default()
        },
        watch: &(),
    };
    let registry = Registry::standard();
    let hybrid = registry.find(name).unwrap();
    for note in hybrid.method().notes(&inputs) {
        let is_known = note.contains("is marched then") || note.contains("mostly in shadow");
        assert!(is_known && !note.contains("  "), "{note}");
    }
    let frame = Frame::new(cpu, inputs, &store).unwrap();
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let hybrid = hybrid.on::<Cpu>().unwrap();
    hybrid.add_radiance(&frame, 64, &mut radiance).unwrap();
    radiance
}

/// Sums of a few terms, in the same order.
#[test]
fn the_light_of_several_lights_is_the_sum_of_theirs() {
    let (size, cpu) = ([16, 9], Cpu::new());
    let rays = rays(size);
    let all = picture(HYBRID, &cpu, &lights(), size, &rays, None);
    let each = lights().map(|light| picture(HYBRID, &cpu, &[light], size, &rays, None));
    for (i, all) in all.iter().enumerate() {
        for channel in 0..3 {
            let sum: f32 = each.iter().map(|light| light[i][channel]).sum();
            assert!((sum - all[channel]).abs() <= 4.0 * f32::EPSILON * sum);
        }
    }
}

#[test]
fn pictures_of_any_size_do_not_depend_on_threads() {
    for size in [[1, 1], [1, 11], [7, 13], [40, 30]] {
        let rays = rays(size);
        let one = picture(
            HYBRID,
            &Cpu::single_threaded(),
            &lights(),
            size,
            &rays,
            None,
        );
        let cpu = Cpu::with_threads(3).unwrap();
        assert_eq!(picture(HYBRID, &cpu, &lights(), size, &rays, None), one);
        assert!(one.iter().flatten().all(|light| light.is_finite()));
        assert!(one.iter().all(|light| light[0] > 0.0));
    }
}

/// To the last bit, whatever was decided for so few rays.
#[test]
fn rays_of_some_pixels_have_the_light_of_these() {
    // Steps of spans depend on what was decided.
    let name = "hybrid-rays x gauss-8";
    let (size, cpu) = ([20, 12], Cpu::new());
    let all = rays(size);
    let whole = picture(name, &cpu, &lights(), size, &all, None);
    let pixels = [3, 200, 17, 18, 18, 239];
    let some: Vec<Ray> = pixels.iter().map(|i| all[*i as usize]).collect();
    let part = picture(name, &cpu, &lights(), size, &some, Some(&pixels));
    for (pixel, light) in pixels.iter().zip(part) {
        assert_eq!(light, whole[*pixel as usize]);
    }
}
