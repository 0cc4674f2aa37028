//! The method of the list: lights of all kinds, and rays of any pixels.

use gpu_backend::{Cpu, Host};

use super::*;
use crate::methods::{Frame, FrameInputs, Registry, Selection, Store, Verdict};
use crate::scene::Camera;

fn lights() -> [Emitter; 4] {
    [
        spot(0.45, Some(window(32))),
        spot(0.7, None),
        Emitter::point([2.0, -3.0, 1.0], [0.3; 3], 20.0, Emission::Isotropic).unwrap(),
        Emitter::directional([0.3, -1.0, 0.2], [0.01; 3]).unwrap(),
    ]
}

/// Calls `told` with the inputs of a frame of some pixels.
fn with_inputs<R>(
    emitters: &[Emitter],
    pixels: Option<&[u32]>,
    told: impl FnOnce(FrameInputs<'_>) -> R,
) -> R {
    let size = [20, 12];
    let eye = Vec3::new(5.0, -2.0, 1.0);
    let camera = Camera::look_at(eye, Vec3::new(0.0, -2.5, 0.0), 0.9).unwrap();
    let numbers: Vec<u32> = pixels.map_or_else(|| (0..size[0] * size[1]).collect(), <[_]>::to_vec);
    let rays: Vec<Ray> = (numbers.iter())
        .map(|i| {
            let [x, y] = [i % size[0], i / size[0]].map(|at| at as f32 + 0.5);
            Ray::new(eye, camera.direction(x, y, size[0], size[1]), 12.0).unwrap()
        })
        .collect();
    let (geometry, medium, host) = (casters(0.45), fog(), Store::new());
    told(FrameInputs {
        emitters,
        areas: &[],
        medium: &medium,
        height_fog: None,
        geometry: &geometry,
        translucent: &[],
        camera: &camera,
        size,
        rays: &rays,
        hits: &vec![None; rays.len()],
        map: 256,
        host: &host,
        selection: Selection {
            pixels,
            ..Selection::default()
        },
        watch: &(),
    })
}

fn picture(name: &str, emitters: &[Emitter], pixels: Option<&[u32]>, cpu: &Cpu) -> Vec<[f32; 4]> {
    with_inputs(emitters, pixels, |inputs| {
        let store = Store::<Host>::new();
        let entry = Registry::standard().find(name).unwrap();
        let frame = Frame::new(cpu, inputs, &store).unwrap();
        let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
        let method = entry.on::<Cpu>().unwrap();
        method.prepare(&frame, 32).unwrap();
        method.add_radiance(&frame, 32, &mut radiance).unwrap();
        radiance
    })
}

/// Sums of a few terms, in the same order.
#[test]
fn the_light_of_several_lights_is_the_sum_of_theirs() {
    let cpu = Cpu::new();
    for name in [
        "textured x gauss-1",
        "textured x table-64",
        "textured-blurred x daylight-4",
    ] {
        let all = picture(name, &lights(), None, &cpu);
        let each = lights().map(|light| picture(name, &[light], None, &cpu));
        for (i, all) in all.iter().enumerate() {
            for channel in 0..3 {
                let sum: f32 = each.iter().map(|light| light[i][channel]).sum();
                assert!((sum - all[channel]).abs() <= 8.0 * f32::EPSILON * sum);
            }
        }
        assert!(
            each.iter()
                .all(|light| light.iter().any(|pixel| pixel[0] > 0.0))
        );
    }
}

/// To the last bit.
#[test]
fn rays_of_some_pixels_have_the_light_of_these_on_any_number_of_threads() {
    let name = "textured x table-64";
    let whole = picture(name, &lights(), None, &Cpu::single_threaded());
    assert_eq!(
        picture(name, &lights(), None, &Cpu::with_threads(3).unwrap()),
        whole
    );
    let pixels = [3, 200, 17, 18, 18, 239];
    let part = picture(name, &lights(), Some(&pixels), &Cpu::new());
    for (pixel, light) in pixels.iter().zip(part) {
        assert_eq!(light, whole[*pixel as usize]);
    }
}

/// Lights without a cookie have the light that a march of as many steps finds, to the error
/// of both.
#[test]
fn other_lights_are_what_they_are_to_other_methods() {
    let lights = &lights()[1..];
    let found = picture("textured x gauss-1", lights, None, &Cpu::new());
    let expected = picture("march-merged x gauss-8", lights, None, &Cpu::new());
    let error = rmse(&found, &expected);
    assert!(error < 0.1, "{error}");
}

#[test]
fn closed_forms_apply_to_cookies_and_what_has_none_is_pointless() {
    let registry = Registry::standard();
    for name in ["gauss", "table", "double", "published", "daylight"] {
        let entry = registry.pair("textured", name, None).unwrap();
        let mut isotropic = [spot(0.45, Some(window(8)))];
        let verdict = |lights: &[Emitter]| {
            with_inputs(lights, None, |inputs| {
                let medium = Medium::new([0.1; 3], [0.0; 3], PhaseFunction::Isotropic).unwrap();
                let inputs = FrameInputs {
                    medium: &medium,
                    ..inputs
                };
                assert_eq!(entry.method().notes(&inputs), Vec::<String>::new());
                entry.method().applies(&inputs)
            })
        };
        assert_eq!(verdict(&isotropic), Verdict::Applies, "{name}");
        isotropic[0] = isotropic[0].clone().with_falloff(Falloff::Smooth);
        assert_eq!(verdict(&isotropic), Verdict::Applies, "{name}");
        let without = verdict(&lights()[1..2]);
        assert!(without.reason().unwrap().contains("cookie"), "{without:?}");
    }
}
