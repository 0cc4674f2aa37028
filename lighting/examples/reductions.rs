//! What less work per picture saves and costs: the time and the error of methods,
//! relative to the first of them, which is the picture that the others should be.
//!
//! ```console
//! $ cargo run --release --package crepuscular-lighting --example reductions \
//!       --features area,methods,procedural -- \
//!       pergola 960x540 64 area-runs "area-runs 3x3" "area-runs quarter"
//! $ … -- city 960x540 32 "march x midpoint" "march quarter" "march 2x2" --pictures OUT
//! ```
//!
//! A scene, a size, a quality and methods. Times are those of the fastest of three frames
//! on the CPU, shadow maps aside, with the passes of that frame. With `--pictures` each
//! method leaves its picture and ten times its difference in a folder, as PPM.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use gpu_backend::{Cpu, Host};
use lighting::methods::{Frame, FrameInputs, Pass, Registry, Selection, Store};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{AreaEmitters, Geometry};

type Picture = Vec<[f32; 4]>;

/// The fastest of three frames.
fn measured(
    inputs: FrameInputs<'_>,
    method: &str,
    quality: u32,
) -> Result<(f64, Vec<Pass>, Picture), Box<dyn Error>> {
    let cpu = Cpu::new();
    let registry = Registry::standard();
    let entry = registry.find(method).ok_or("no such method")?;
    let runs = entry.on::<Cpu>().ok_or("not on the CPU")?;
    let store = Store::<Host>::new();
    let mut best: Option<(f64, Vec<Pass>, Picture)> = None;
    for _ in 0..3 {
        let frame = Frame::new(&cpu, inputs, &store)?.timed();
        runs.prepare(&frame, quality)?;
        let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
        let clock = Instant::now();
        runs.add_radiance(&frame, quality, &mut radiance)?;
        let seconds = clock.elapsed().as_secs_f64();
        if best.as_ref().is_none_or(|(least, ..)| seconds < *least) {
            best = Some((seconds, frame.passes(), radiance));
        }
    }
    best.ok_or_else(|| "no frame".into())
}

fn write(path: &Path, size: [u32; 2], value: impl Fn(usize) -> [f32; 3]) -> std::io::Result<()> {
    let [width, height] = size;
    let mut bytes = format!("P6 {width} {height} 255\n").into_bytes();
    for pixel in 0..width as usize * height as usize {
        bytes.extend(value(pixel).map(|v| (255.0 * v.clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8));
    }
    std::fs::write(path, bytes)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let pictures = match arguments.iter().position(|a| a == "--pictures") {
        Some(at) => {
            let folder = arguments.get(at + 1).cloned().ok_or("--pictures FOLDER")?;
            arguments.drain(at..at + 2);
            Some(folder)
        }
        None => None,
    };
    let [scene, size, quality, methods @ ..] = &arguments[..] else {
        return Err("expected SCENE WIDTHxHEIGHT QUALITY METHOD…".into());
    };
    let (width, height) = size.split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let size: [u32; 2] = [width.parse()?, height.parse()?];
    let quality: u32 = quality.parse()?;

    let mut scene = Embedded::from_name(scene)
        .ok_or("no such embedded scene")?
        .build(1);
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

    let mut first: Option<(f64, f64, Picture)> = None;
    for method in methods {
        let (seconds, passes, picture) = measured(inputs, method, quality)?;
        let gather = |passes: &[Pass]| {
            let own = passes.iter().filter(|pass| pass.what != "voxels");
            own.map(|pass| pass.seconds).sum::<f64>()
        };
        let (whole, alone, exact) =
            first.get_or_insert_with(|| (seconds, gather(&passes), picture.clone()));
        let pairs = || exact.iter().zip(&picture);
        let squares = |(a, b): (&[f32; 4], &[f32; 4])| -> f64 {
            (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum()
        };
        let count = 3.0 * exact.len() as f64;
        let mean = exact
            .iter()
            .flat_map(|p| &p[..3])
            .map(|v| f64::from(*v))
            .sum::<f64>()
            / count;
        let rmse = (pairs().map(squares).sum::<f64>() / count).sqrt() / mean;
        println!(
            "{method}: {seconds:.3} s, {:.2} x as fast; gather alone {:.2} x; RMSE {rmse:.5}",
            *whole / seconds,
            *alone / gather(&passes),
        );
        for pass in &passes {
            println!(
                "    {:20} {:.4} s, {} times",
                pass.what, pass.seconds, pass.times
            );
        }
        let registry = Registry::standard();
        let entry = registry.find(method).ok_or("no such method")?;
        for note in entry.method().notes(&inputs) {
            println!("    {note}");
        }
        if let Some(folder) = &pictures {
            let name = method.replace(' ', "-");
            let scale = 0.35 / mean as f32;
            let of = |p: &[f32; 4]| [p[0], p[1], p[2]].map(|v| scale * v);
            let folder = Path::new(folder);
            write(&folder.join(format!("{name}.ppm")), size, |i| {
                of(&picture[i])
            })?;
            write(&folder.join(format!("{name}-x10.ppm")), size, |i| {
                let (a, b) = (of(&exact[i]), of(&picture[i]));
                std::array::from_fn(|c| 10.0 * (a[c] - b[c]).abs())
            })?;
        }
    }
    Ok(())
}
