//! The methods of the list: their lights, groups and shared work.

use std::sync::Arc;

use glam::Vec3;
use gpu_backend::{Cpu, Host};

use super::*;
use crate::Interleaving;
use crate::methods::area::groups::{MOST, OfAreas, virtual_lights};
use crate::methods::area::tests::{SIZE, camera, fog, geometry, panel, rays};
use crate::methods::{Selection, Store};
use crate::scene::{AreaEmitters, Emission, Medium, Pattern};

/// A frame with a lamp, the panel and another lamp.
fn with_frame(test: impl FnOnce(&Frame<'_, Cpu>)) {
    let lamp = |x: f32| {
        let position = Vec3::new(x, 3.0, -4.0);
        Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
    };
    let mut emitters = vec![lamp(-2.0)];
    emitters.extend(panel().virtual_lights(Pattern::Lattice, 4).unwrap());
    emitters.push(lamp(2.0));
    let areas = [AreaEmitters {
        light: panel(),
        emitters: 1..5,
    }];
    let (cpu, host, store) = (Cpu::new(), Store::<Host>::new(), Store::<Host>::new());
    let (geometry, medium, rays): (_, Medium, _) = (geometry(), fog(), rays());
    let hits = vec![None; rays.len()];
    let inputs = FrameInputs {
        emitters: &emitters,
        areas: &areas,
        medium: &medium,
        height_fog: None,
        geometry: &geometry,
        translucent: &[],
        camera: &camera(),
        size: SIZE,
        rays: &rays,
        hits: &hits,
        map: 32,
        host: &host,
        selection: Selection::default(),
        watch: &(),
    };
    test(&Frame::new(&cpu, inputs, &store).unwrap());
}

#[test]
fn area_lights_are_points_in_the_place_of_their_emitters() {
    with_frame(|frame| {
        let lights = virtual_lights(&frame.inputs, 9).unwrap();
        assert_eq!(lights.len(), 11);
        assert_eq!(lights[0], frame.inputs.emitters[0]);
        assert_eq!(lights[10], frame.inputs.emitters[5]);
        let sum = |all: &[Emitter]| all.iter().map(Emitter::intensity).sum::<Vec3>();
        let [few, more] = [sum(frame.inputs.emitters), sum(&lights)];
        assert!((few / more - 1.0).length() < 1e-5);
        for points in [0, MOST + 1] {
            let error = virtual_lights(&frame.inputs, points).unwrap_err();
            assert!(error.to_string().contains("1 to 4096"), "{error}");
        }
        let without = FrameInputs {
            areas: &[],
            ..frame.inputs
        };
        assert_eq!(virtual_lights(&without, 9).unwrap(), frame.inputs.emitters);
    });
}

/// One ray ten times, of which nine share the lights.
#[test]
fn rays_that_share_the_lights_have_all_of_them_together() {
    with_frame(|frame| {
        let inputs = FrameInputs {
            rays: &[frame.inputs.rays[100]; 10],
            hits: &[None; 10],
            selection: Selection {
                pixels: Some(&[100; 10]),
                interleaving: Interleaving::new(9, 1),
            },
            ..frame.inputs
        };
        let store = Store::<Host>::new();
        let frame = Frame::new(frame.backend, inputs, &store).unwrap();
        for entry in methods() {
            let mut radiance = vec![[0.0; 4]; 10];
            let method = entry.on::<Cpu>().unwrap();
            method.add_radiance(&frame, 9, &mut radiance).unwrap();
            let mean = radiance[..9].iter().map(|pixel| pixel[0]).sum::<f32>() / 9.0;
            let all = radiance[9][0];
            assert!(all > 0.0 && (mean / all - 1.0).abs() < 1e-5, "{mean} {all}");
            assert!(radiance[..9].iter().any(|pixel| pixel[0] != all));
        }
    });
}

#[test]
fn groups_of_any_size_are_the_same_lights_and_the_same_image() {
    with_frame(|frame| {
        let key = |maps| OfAreas { points: 9, maps };
        for maps in [Maps::Exact, Maps::Imperfect { levels: 2 }] {
            let image = |most: usize| {
                let groups = Groups::make(frame, key(maps), most).unwrap();
                assert_eq!(groups.0.len(), 11_usize.div_ceil(most));
                let store = Store::<Host>::new();
                let frame = Frame::new(frame.backend, frame.inputs, &store).unwrap();
                let own = key(maps);
                store.insert("groups", own, Arc::new(groups), 0);
                let method = AreaLights {
                    name: "test",
                    title: "test",
                    purpose: "",
                    paper: "",
                    role: Role::Variant,
                    maps,
                    detail: Detail::Runs,
                    nodes: 2,
                    is_compared: false,
                };
                let mut radiance = vec![[0.0; 4]; frame.inputs.rays.len()];
                method.add_radiance(&frame, 9, &mut radiance).unwrap();
                radiance
            };
            let whole = image(100);
            assert!(whole.iter().any(|pixel| pixel[0] > 0.0));
            assert_eq!(image(4), whole);
            assert_eq!(image(1), whole);
        }
    });
}
