//! The history of froxels over a film.

use glam::Vec3;
use gpu_backend::{Cpu, Host};

use super::tests::{SIZE, camera, fog, rays_of};
use crate::Emitter;
use crate::methods::{
    Entry, Frame, FrameInputs, Registry, RunOn, Selection, Store, forget_lights, share_film_frame,
};
use crate::scene::{Camera, Emission, Geometry, Mesh, Scene};

const SLICES: u32 = 24;

/// A roof below the lamps.
fn geometry() -> Geometry {
    let scene = Scene::from(Mesh {
        positions: vec![
            Vec3::new(-1.0, 4.0, -6.0),
            Vec3::new(1.0, 4.0, -6.0),
            Vec3::new(0.0, 4.0, -3.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    Geometry::new(&scene).unwrap()
}

fn lamp(x: f32) -> Vec<Emitter> {
    let position = Vec3::new(x, 7.5, -5.0);
    let lamp = Emitter::point(
        position,
        Vec3::splat(30.0),
        f32::INFINITY,
        Emission::Isotropic,
    );
    vec![lamp.unwrap()]
}

/// A picture of a lamp; of a film, if it has a number there.
fn picture(
    store: &Store<Host>,
    method: &Entry,
    camera: &Camera,
    lamp: &[Emitter],
    film: Option<u32>,
) -> Vec<[f32; 4]> {
    let (rays, medium, geometry) = (rays_of(camera, SIZE), fog(), geometry());
    let hits = vec![None; rays.len()];
    if let Some(frame) = film {
        share_film_frame(store, frame);
    }
    let inputs = FrameInputs {
        emitters: lamp,
        areas: &[],
        medium: &medium,
        height_fog: None,
        geometry: &geometry,
        translucent: &[],
        camera,
        size: SIZE,
        rays: &rays,
        hits: &hits,
        map: 64,
        host: store,
        selection: Selection::default(),
        watch: &(),
    };
    assert_eq!(inputs.film_frame(), film);
    let cpu = Cpu::new();
    let frame = Frame::new(&cpu, inputs, store).unwrap();
    method.prepare(&frame, SLICES).unwrap();
    let mut radiance = vec![[0.0; 4]; rays.len()];
    method.add_radiance(&frame, SLICES, &mut radiance).unwrap();
    radiance
}

fn distance(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs
        .map(|(a, b)| f64::from(a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn method(name: &str) -> Entry {
    Registry::standard().find(name).unwrap()
}

#[test]
fn a_film_begins_with_the_picture_of_a_still_camera_and_goes_on_from_it() {
    let (history, lamp) = (method("froxels-history"), lamp(1.0));
    let still = picture(&Store::new(), &history, &camera(), &lamp, None);
    let film = Store::new();
    assert_eq!(still, picture(&film, &history, &camera(), &lamp, Some(0)));
    // Each frame is sampled at a place of its own.
    let next = picture(&film, &history, &camera(), &lamp, Some(1));
    assert!(distance(&still, &next) > 0.0);
}

#[test]
fn light_that_moves_leaves_a_trail_with_a_history_and_none_without() {
    for (name, trails) in [("froxels-history", true), ("froxels", false)] {
        let method = method(name);
        let film = Store::new();
        let [before, after] = [1.0, -1.5].map(lamp);
        let old = picture(&film, &method, &camera(), &before, Some(0));
        forget_lights(&film);
        let new = picture(&film, &method, &camera(), &after, Some(1));
        let truth = picture(&Store::new(), &method, &camera(), &after, Some(0));
        let (moved, late) = (distance(&old, &truth), distance(&new, &truth));
        match trails {
            true => assert!(late > 0.7 * moved, "{late} of {moved}"),
            false => assert_eq!(late, 0.0),
        }
    }
}
