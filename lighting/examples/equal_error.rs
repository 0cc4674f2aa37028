//! How much faster than the first method others reach the same error.
//!
//! ```console
//! $ cargo run --release --package crepuscular-lighting --example equal_error \
//!       --features area,methods,procedural -- \
//!       smoke 480x270 "map-runs x gauss" 16 "march x midpoint" "hybrid x gauss-8"
//! ```
//!
//! A scene (or `room`: a dark one with a window), a size, the method that is the truth
//! with its quality, and the methods.
//! Times are those of the fastest of three frames on the CPU; what a method makes before
//! its first frame, shadow maps aside, is in brackets, and counts in the first of two
//! ratios. Errors are RMSE relative to the mean.

use std::error::Error;
use std::time::Instant;

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use lighting::methods::{Frame, FrameInputs, Registry, Selection, Store};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{
    AreaEmitters, Camera, DirectionalLight, Geometry, Light, Medium, Mesh, PhaseFunction, Scene,
};

const QUALITIES: [u32; 12] = [2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096];
const ERRORS: [f64; 3] = [0.05, 0.02, 0.005];

/// A frame of a method.
struct Measured {
    quality: u32,
    error: f64,
    /// With what is made before the first frame, and without it, seconds.
    seconds: [f64; 2],
}

type Picture = Vec<[f32; 4]>;

/// The picture, and the seconds of what is made first and of the fastest frame.
fn frames(
    inputs: FrameInputs<'_>,
    method: &str,
    quality: u32,
    times: u32,
) -> Result<(Picture, [f64; 2]), Box<dyn Error>> {
    let (cpu, registry) = (Cpu::new(), Registry::standard());
    let run = |method: &str| registry.find(method).ok_or(format!("no method {method}"));
    let (maps, entry) = (run("march x midpoint")?, run(method)?);
    let (maps, runs) = (maps.on::<Cpu>(), entry.on::<Cpu>());
    let (maps, runs) = maps.zip(runs).ok_or("not on the CPU")?;
    let (host, store) = (Store::new(), Store::<Host>::new());
    let inputs = FrameInputs {
        host: &host,
        ..inputs
    };
    let frame = Frame::new(&cpu, inputs, &store)?;
    maps.prepare(&frame, 1)?;
    let clock = Instant::now();
    runs.prepare(&frame, quality)?;
    let mut seconds = [clock.elapsed().as_secs_f64(), f64::INFINITY];
    let mut radiance = Vec::new();
    for _ in 0..times {
        radiance = vec![[0.0; 4]; inputs.rays.len()];
        let clock = Instant::now();
        runs.add_radiance(&frame, quality, &mut radiance)?;
        seconds[1] = seconds[1].min(clock.elapsed().as_secs_f64());
    }
    Ok((radiance, seconds))
}

fn relative_rmse(truth: &Picture, picture: &Picture) -> f64 {
    let count = 3.0 * truth.len() as f64;
    let values = truth.iter().flat_map(|p| &p[..3]);
    let mean = values.map(|v| f64::from(*v)).sum::<f64>() / count;
    let squares = truth
        .iter()
        .zip(picture)
        .map(|(a, b)| -> f64 { (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum() });
    (squares.sum::<f64>() / count).sqrt() / mean
}

/// The seconds for an error, between those of the qualities around it.
fn seconds(measured: &[Measured], error: f64, which: usize) -> Option<f64> {
    let reached = measured.iter().position(|m| m.error <= error)?;
    let (after, before) = (&measured[reached], measured[..reached].last());
    let Some(before) = before else {
        return Some(after.seconds[which]);
    };
    let t = (before.error / error).ln() / (before.error / after.error).ln();
    let [a, b] = [before, after].map(|m| m.seconds[which].ln());
    Some((a + t * (b - a)).exp())
}

/// A room of 8 m, 4 m high, with a window and a sun that shines through it.
fn room() -> Result<Scene, Box<dyn Error>> {
    let mut mesh = Mesh::default();
    // A wall by its corner and its sides, with a hole where one is asked for.
    let mut wall = |corner: Vec3, sides: [Vec3; 2], hole: Option<[f32; 4]>| {
        let [left, right, low, high] = hole.unwrap_or([0.0; 4]);
        let (us, vs) = ([0.0, left, right, 1.0], [0.0, low, high, 1.0]);
        let parts = (0..9).map(|k| (k / 3, k % 3));
        for (i, j) in parts.filter(|part| *part != (1, 1)) {
            let first = mesh.positions.len() as u32;
            let at = |u: f32, v: f32| corner + u * sides[0] + v * sides[1];
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            mesh.positions
                .extend(corners.map(|(i, j)| at(us[i], vs[j])));
            mesh.triangles
                .extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
        }
    };
    let [x, y, z] = [8.0 * Vec3::X, 4.0 * Vec3::Y, 8.0 * Vec3::Z];
    wall(Vec3::ZERO, [z, y], None);
    wall(x, [z, y], Some([0.35, 0.55, 0.4, 0.8]));
    for (corner, sides) in [
        (Vec3::ZERO, [x, y]),
        (z, [x, y]),
        (Vec3::ZERO, [x, z]),
        (y, [x, z]),
    ] {
        wall(corner, sides, None);
    }
    let mut scene = Scene::from(mesh);
    let sun = DirectionalLight {
        direction: Vec3::new(-1.0, -0.6, 0.15).normalize(),
        irradiance: Vec3::splat(3.0),
        ..DirectionalLight::default()
    };
    scene.lights = vec![Light::Directional(sun)];
    scene.camera = Some(Camera::look_at(
        Vec3::new(1.0, 1.6, 7.4),
        Vec3::new(4.5, 1.8, 2.0),
        1.1,
    )?);
    let scatters = Vec3::splat(0.05);
    scene.medium = Some(Medium::new(scatters, Vec3::ZERO, PhaseFunction::Isotropic)?);
    Ok(scene)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, size, truth, quality, methods @ ..] = &arguments[..] else {
        return Err("expected SCENE WIDTHxHEIGHT TRUTH QUALITY METHOD…".into());
    };
    let (width, height) = size.split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let size: [u32; 2] = [width.parse()?, height.parse()?];

    let mut scene = match scene.as_str() {
        "room" => room()?,
        name => Embedded::from_name(name)
            .ok_or("no such embedded scene")?
            .build(1),
    };
    let geometry = Geometry::new(&scene)?;
    scene.complete(geometry.bounds())?;
    scene.fill_with_fog(geometry.bounds())?;
    let tracer = Tracer::new(&geometry);
    let camera = scene.camera.ok_or("no camera")?;
    let view = View::new(&Cpu::new(), &camera, &tracer, size[0], size[1])?;
    let (mut emitters, mut owners) = (Vec::new(), Vec::new());
    for (index, light) in scene.lights.iter().enumerate() {
        emitters.extend(light.emitters(4)?);
        owners.resize(emitters.len(), index);
    }
    let areas = AreaEmitters::find(&scene.lights, &owners);
    let host = Store::new();
    let inputs = FrameInputs {
        emitters: &emitters,
        areas: &areas,
        medium: &scene.medium.ok_or("no medium")?,
        height_fog: None,
        geometry: &geometry,
        translucent: &scene.translucent,
        camera: &camera,
        size,
        rays: view.rays(),
        hits: view.hits(),
        map: 1024,
        host: &host,
        selection: Selection::default(),
        watch: &(),
    };
    let sky = view.hits().iter().filter(|hit| hit.is_none()).count();
    println!(
        "{:.0} % of rays to the sky",
        100.0 * sky as f64 / inputs.rays.len() as f64
    );

    let (truth, _) = frames(inputs, truth, quality.parse()?, 1)?;
    let mut all: Vec<Vec<Measured>> = Vec::new();
    for method in methods {
        let mut measured: Vec<Measured> = Vec::new();
        for quality in QUALITIES {
            let (picture, [before, frame]) = frames(inputs, method, quality, 3)?;
            let error = relative_rmse(&truth, &picture);
            println!("{method} {quality:>5}: {error:.5} {frame:.4} s ({before:.4} s)");
            measured.push(Measured {
                quality,
                error,
                seconds: [before + frame, frame],
            });
            if error < ERRORS[ERRORS.len() - 1] {
                break;
            }
        }
        all.push(measured);
    }
    for (method, own) in methods.iter().zip(&all) {
        print!("{method:32}");
        for error in ERRORS {
            let ratio = |which: usize| {
                let pair = seconds(&all[0], error, which).zip(seconds(own, error, which));
                pair.map_or("   –".into(), |(first, own)| {
                    format!("{:4.2}", first / own)
                })
            };
            print!("  {error}: {} ({})", ratio(0), ratio(1));
        }
        // At equal steps.
        let slower = own.iter().filter_map(|m| {
            let first = all[0].iter().find(|first| first.quality == m.quality)?;
            Some((m.quality, m.seconds[0] / first.seconds[0]))
        });
        let slower: Vec<String> = slower.map(|(q, s)| format!("{q}: {s:.2}")).collect();
        println!("  time at equal steps {}", slower.join(" "));
    }
    Ok(())
}
