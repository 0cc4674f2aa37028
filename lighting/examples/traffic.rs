//! Frames of a sun over casters some of which move: what shadows cost in a frame, and how
//! far the picture is off.
//!
//! ```console
//! $ cargo run --release --package crepuscular-lighting --example traffic \
//!       --features methods,procedural,shadow-dag -- 480x270 6
//! ```
//!
//! A size and a number of frames of the embedded scene `traffic`, on the CPU. Cars and
//! balloons go to and fro. Five ways
//! take turns in each frame:
//!
//! * `alone`: what stays is baked once, and what moves has no shadow;
//! * `beside`: what stays is baked once, and what moves has a map of its own;
//! * `method`: the same by the method `precomputed x gauss-8`, whose stores forget what has
//!   moved, with the whole scene expanded anew;
//! * `rebuild`: the grid of all casters is baked anew where they have moved;
//! * `map`: a map of all casters.
//!
//! Times are those of the median frame. The error is RMSE over the mean of the picture with
//! exact shadows, in the frame in which it is largest.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{Affine3A, Vec3};
use gpu_backend::Cpu;
use lighting::airlight::EquiAngular;
use lighting::methods::epipolar::MapRuns;
use lighting::methods::{
    FROM_FILE, Frame, FrameInputs, PRECOMPUTED, Registry, RunOn, Selection, Store, forget_dynamic,
    share_precomputed,
};
use lighting::precomputed::{self, BakedShadow, Builder, Resolution, light_spaces};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{Geometry, Medium, Scene};
use lighting::shadow_map::{Casters, RenderShadowMap};
use lighting::visibility::{Both, Exact};
use lighting::{Emitter, Gather, LitRays, Ray, VisibilitySource};
use shadow_dag::KeptGrid;

const VOXELS: u32 = 2048;
const TEXELS: u32 = 1024;
const ALL_TEXELS: u32 = 2048;

type Picture = Vec<[f32; 4]>;

/// Where a frame is made.
struct Stand {
    cpu: Cpu,
    sun: Emitter,
    fog: Medium,
    airlight: EquiAngular,
}

impl Stand {
    fn gather<V: VisibilitySource>(
        &self,
        rays: &Vec<Ray>,
        source: &V,
    ) -> Result<Picture, gpu_backend::Error> {
        let mut radiance = vec![[0.0; 4]; rays.len()];
        let lit = LitRays::new(rays, &self.sun, &self.fog).joined();
        self.cpu
            .gather(&lit, source, &self.airlight, &mut radiance)?;
        Ok(radiance)
    }

    fn with_map(
        &self,
        geometry: &Geometry,
        texels: u32,
        rays: &[Ray],
    ) -> Result<impl VisibilitySource<Share = f32> + use<>, Box<dyn Error>> {
        let casters = Casters::upload(&self.cpu, geometry)?;
        let map = Arc::new(self.cpu.shadow_map(&casters, &self.sun, texels)?);
        Ok(MapRuns::new(&self.cpu, map, rays, &self.sun, &self.fog)?)
    }
}

/// What a way took in each frame, and how far it was off.
struct Way {
    name: &'static str,
    shadows: Vec<f64>,
    gather: Vec<f64>,
    error: f64,
}

impl Way {
    fn new(name: &'static str) -> Self {
        Self {
            name,
            shadows: Vec::new(),
            gather: Vec::new(),
            error: 0.0,
        }
    }

    /// A frame that began at `clock` and whose shadows were ready at `ready`.
    fn add(&mut self, clock: Instant, ready: Instant, picture: &Picture, exact: &Picture) {
        self.gather.push(ready.elapsed().as_secs_f64());
        self.shadows.push((ready - clock).as_secs_f64());
        let mut square = 0.0;
        let mut mean = 0.0;
        for (a, b) in picture.iter().zip(exact) {
            square += f64::from(a[1] - b[1]).powi(2);
            mean += f64::from(b[1]);
        }
        let count = exact.len() as f64;
        self.error = self.error.max((square / count).sqrt() / (mean / count));
    }

    fn print(mut self) {
        let median = |list: &mut Vec<f64>| {
            list.sort_by(f64::total_cmp);
            1e3 * list[list.len() / 2]
        };
        let (shadows, gather) = (median(&mut self.shadows), median(&mut self.gather));
        println!(
            "{:8} shadows {shadows:8.1} ms, gather {gather:8.1} ms, error {:.2} %",
            self.name,
            100.0 * self.error
        );
    }
}

/// Moves what is dynamic on, and back after a few frames: the grid is that of its first
/// places.
fn drive(scene: &mut Scene, frame: usize) {
    let forth = if (frame / 4).is_multiple_of(2) {
        1.0
    } else {
        -1.0
    };
    let step = Affine3A::from_translation(forth * Vec3::new(1.5, 0.0, -1.0));
    for instance in scene.instances.iter_mut().filter(|i| i.dynamic) {
        instance.transform = step * instance.transform;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [size, frames] = &arguments[..] else {
        return Err("expected WIDTHxHEIGHT FRAMES".into());
    };
    let (width, height) = size.split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let frames: usize = frames.parse::<usize>()?.max(1);

    let mut scene = Embedded::Traffic.build(1);
    let stand = Stand {
        cpu: Cpu::new(),
        sun: scene.lights[0].emitters(1)?.swap_remove(0),
        fog: scene.medium.ok_or("no fog")?,
        airlight: EquiAngular::new(8)?,
    };
    let camera = scene.camera.ok_or("no camera")?;
    let geometry = Geometry::new(&scene)?;
    let fixed = geometry.static_part().ok_or("all of it moves")?;
    let (cpu, side) = (&stand.cpu, Resolution::new(VOXELS)?);

    let clock = Instant::now();
    let (baked, _) = BakedShadow::bake(cpu, fixed, &stand.sun, side, Builder::new())?;
    println!(
        "bake of what stays: {:.1} ms, once",
        1e3 * clock.elapsed().as_secs_f64()
    );
    let space = light_spaces(&geometry, &stand.sun, side)?.swap_remove(0);
    let mesh = |geometry: &Geometry| -> Result<_, shadow_dag::Error> {
        Ok(precomputed::surfaces(geometry)?.seen_from(space, side))
    };
    let mut kept = KeptGrid::new(cpu, Builder::new(), &mesh(&geometry)?)?;

    let host = Store::new();
    let baked = Arc::new(baked);
    share_precomputed(&host, 0, &baked);
    let pair = Registry::standard().pair(PRECOMPUTED, "gauss", Some(8));
    let pair = pair.ok_or("no such method")?;

    let ways = ["alone", "beside", "method", "rebuild", "map"].map(Way::new);
    let [mut alone, mut beside, mut method, mut rebuilt, mut mapped] = ways;
    for frame in 0..frames {
        drive(&mut scene, frame);
        let whole = Geometry::new(&scene)?;
        let tracer = Tracer::new(&whole);
        let view = View::new(cpu, &camera, &tracer, width, height)?;
        let rays = view.rays().to_vec();
        let exact = stand.gather(&rays, &Exact::new(&tracer))?;

        let clock = Instant::now();
        alone.add(clock, clock, &stand.gather(&rays, &*baked)?, &exact);

        let clock = Instant::now();
        let runs = stand.with_map(&Geometry::of_dynamic(&scene)?, TEXELS, &rays)?;
        let (source, ready) = (Both(&*baked, runs), Instant::now());
        beside.add(clock, ready, &stand.gather(&rays, &source)?, &exact);

        let clock = Instant::now();
        let geometry = Geometry::new(&scene)?;
        forget_dynamic(&host);
        let inputs = FrameInputs {
            emitters: std::slice::from_ref(&stand.sun),
            areas: &[],
            medium: &stand.fog,
            height_fog: None,
            geometry: &geometry,
            translucent: &[],
            camera: &camera,
            size: [width, height],
            rays: &rays,
            hits: view.hits(),
            map: TEXELS,
            host: &host,
            selection: Selection::default(),
            watch: &(),
        };
        // On the CPU one store is both.
        let frame = Frame::new(cpu, inputs, &host)?;
        pair.prepare(&frame, FROM_FILE)?;
        let ready = Instant::now();
        let mut radiance = vec![[0.0; 4]; rays.len()];
        pair.add_radiance(&frame, FROM_FILE, &mut radiance)?;
        method.add(clock, ready, &radiance, &exact);

        let clock = Instant::now();
        let mut rebuild = kept.rebuild(mesh(&Geometry::new(&scene)?)?);
        while !rebuild.progress().is_complete() {
            rebuild.advance(cpu, Duration::from_secs(1))?;
        }
        kept.replace(rebuild)?;
        let source = BakedShadow::new(std::slice::from_ref(kept.grid()))?;
        let ready = Instant::now();
        rebuilt.add(clock, ready, &stand.gather(&rays, &source)?, &exact);

        let clock = Instant::now();
        let source = stand.with_map(&Geometry::new(&scene)?, ALL_TEXELS, &rays)?;
        let ready = Instant::now();
        mapped.add(clock, ready, &stand.gather(&rays, &source)?, &exact);
    }
    for way in [alone, beside, method, rebuilt, mapped] {
        way.print();
    }
    Ok(())
}
