//! Area lights as many shadow volumes beside what they replace, as ratios of times. Those
//! of grids and maps are taken in turn, so that a busy machine slows both down alike; the
//! others are taken one after the other and want a machine that does nothing else.
//!
//! `cargo bench --bench area` runs all of them, `cargo bench --bench area -- grids maps`
//! those whose ids, in [`BENCHES`], have one of these words in them.

mod grids;
mod moving;

use std::time::Instant;

use crepuscular_tests::frames::inputs;
use glam::{Affine3A, Vec3};
use gpu_backend::{Cpu, Host};
use lighting::airlight::EquiAngular;
use lighting::area::{GatherMany, LightVolumes, ManyLights};
use lighting::methods::reduced::{Choice, FillPicture, Filling, Reduction};
use lighting::methods::{Frame, FrameInputs, Registry, RunOn, Store};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Hit;
use lighting::scene::{Instance, Pattern};
use lighting::shadow_map::{
    CasterPoints, Casters, LevelOfDetail, RenderImperfectMaps, RenderShadowMap,
    RenderShadowMapAtlas,
};
use lighting::voxelized::{Detail, Eye, Resolution, VoxelVolume};
use lighting::{Emitter, Gather, Interleaving, LitRays, Ray};
use reference::metrics::{Reference, image_error};
use reference::oracle::area;
use reference::oracle::image::Options;
use reference::scenes::TestScene;

const BENCHES: [(&str, fn()); 8] = [
    ("64 grids of 128^3", grids::few),
    ("256 grids of 128^3", grids::many),
    ("maps", maps),
    ("lights", lights),
    ("hard", hard),
    ("baseline", baseline),
    ("froxels", froxels),
    ("moving", moving::moving),
];

/// Texels of a map and voxels along an axis.
const SIDE: u32 = 128;

/// Points that are splatted into a map.
const POINTS: u32 = 4096;

fn main() {
    let names: Vec<String> = std::env::args()
        .skip(1)
        .filter(|name| !name.starts_with("--"))
        .collect();
    for (name, bench) in BENCHES {
        if names.is_empty() || names.iter().any(|wanted| name.contains(wanted.as_str())) {
            println!("{name}");
            bench();
        }
    }
}

/// The fastest of a few rounds of each, in turn: what others do on the machine only
/// adds to a time.
fn fastest<const N: usize>(rounds: usize, mut runs: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut best = [f64::INFINITY; N];
    for _ in 0..rounds {
        for (run, best) in runs.iter_mut().zip(&mut best) {
            let clock = Instant::now();
            run();
            *best = best.min(clock.elapsed().as_secs_f64());
        }
    }
    best
}

fn emitters(scene: &TestScene, count: u32) -> Vec<Emitter> {
    let light = &scene.areas[0].light;
    (light.virtual_lights(Pattern::Lattice, count)).expect("a sound light")
}

fn eye(scene: &TestScene) -> Eye {
    Eye::of_camera(&scene.camera, scene.size, &scene.rays, &scene.medium)
}

fn cube(side: u32) -> Resolution {
    Resolution::new(side, side, side).expect("a legal size")
}

fn volumes(cpu: &Cpu, lights: usize) -> LightVolumes<Host> {
    LightVolumes::new(cpu, cube(SIDE), lights).expect("memory")
}

/// Imperfect maps of many lights over 588,000 triangles, and rasterised ones.
fn maps() {
    const LIGHTS: u32 = 64;
    let mut scene = Embedded::HairballPanel.build(1);
    let strands = scene.instances[0].clone();
    for place in [Vec3::X, Vec3::NEG_X, Vec3::NEG_Z] {
        scene.instances.push(Instance {
            transform: Affine3A::from_translation(1.5 * place) * strands.transform,
            ..strands.clone()
        });
    }
    let scene = TestScene::of("hairballs", scene, 8, 8);
    let emitters = emitters(&scene, LIGHTS);
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &scene.geometry).expect("memory");
    let sampled = Instant::now();
    let points = CasterPoints::sample(&cpu, &scene.geometry, 1 << 16).expect("memory");
    let sampled = sampled.elapsed().as_secs_f64();
    let [imperfect, atlas, each] = fastest(
        2,
        [
            &mut || {
                let level = LevelOfDetail::Near;
                cpu.imperfect_maps(&points, &emitters, SIDE, POINTS, level)
                    .expect("memory");
            },
            &mut || {
                cpu.shadow_map_atlas(&casters, &emitters, SIDE)
                    .expect("memory");
            },
            &mut || {
                for emitter in &emitters {
                    cpu.shadow_map(&casters, emitter, SIDE).expect("memory");
                }
            },
        ],
    );
    println!(
        "  {} triangles, {LIGHTS} lights: imperfect {:.1} ms (points once: {:.1} ms), all rasterised {:.1}×, a map for each light {:.1}×",
        scene.geometry.triangles().len(),
        1e3 * imperfect,
        1e3 * sampled,
        atlas / imperfect,
        each / imperfect
    );
}

/// What a light costs among 64, 256 and 1024: voxels and gather, with the paper's
/// average and with lit runs.
fn lights() {
    let scene = TestScene::new(Embedded::Pergola, 160, 90);
    let cpu = Cpu::new();
    let eye = eye(&scene);
    let points = CasterPoints::sample(&cpu, &scene.geometry, 1 << 16).expect("memory");
    for (name, detail, nodes) in [("average", Detail::Average, 8), ("runs", Detail::Runs, 4)] {
        let airlight = EquiAngular::new(nodes).expect("a legal number");
        let cost = [64, 256, 1024].map(|count| {
            let emitters = emitters(&scene, count);
            let level = LevelOfDetail::Near;
            let maps = cpu
                .imperfect_maps(&points, &emitters, SIDE, POINTS, level)
                .expect("memory");
            let mut all = volumes(&cpu, emitters.len());
            let mut radiance = vec![[0.0; 4]; scene.rays.len()];
            let [seconds] = fastest(
                3,
                [&mut || {
                    all.update(&cpu, &emitters, &eye, &maps)
                        .expect("a legal view");
                    let many = ManyLights {
                        rays: &scene.rays,
                        emitters: &emitters,
                        medium: &scene.medium,
                        detail,
                        interleaving: Interleaving::NONE,
                    };
                    cpu.gather_many(&many, &all, &airlight, &mut radiance)
                        .expect("as many rays");
                }],
            );
            seconds / f64::from(count)
        });
        let [few, more, most] = cost.map(|seconds| 1e3 * seconds);
        println!(
            "  {name}: {few:.3}, {more:.3}, {most:.3} ms a light among 64, 256, 1024: {:+.1} % from 64 to 1024",
            100.0 * (most / few - 1.0)
        );
    }
}

/// The frame of 256 lights at 1024², maps apart, and that of a hard 512³ volume.
fn hard() {
    let scene = TestScene::new(Embedded::Pergola, 1024, 1024);
    let cpu = Cpu::new();
    let eye = eye(&scene);
    let emitters = emitters(&scene, 256);
    let points = CasterPoints::sample(&cpu, &scene.geometry, 1 << 16).expect("memory");
    let maps = cpu
        .imperfect_maps(&points, &emitters, SIDE, POINTS, LevelOfDetail::Near)
        .expect("memory");
    let casters = Casters::upload(&cpu, &scene.geometry).expect("memory");
    let map = (cpu.shadow_map(&casters, &emitters[0], 1024)).expect("memory");
    let mut one = VoxelVolume::new(&cpu, cube(512)).expect("memory");
    let mut all = volumes(&cpu, emitters.len());
    let airlight = EquiAngular::new(8).expect("a legal number");
    let mut radiance = vec![[0.0; 4]; scene.rays.len()];
    let mut of_one = radiance.clone();
    let [frame] = fastest(
        3,
        [&mut || {
            one.update(&cpu, &emitters[0], &eye, &map)
                .expect("a legal view");
            let lit = LitRays::new(&scene.rays, &emitters[0], &scene.medium);
            cpu.gather(&lit, &one.source(Detail::Average), &airlight, &mut of_one)
                .expect("as many rays");
        }],
    );
    let [made] = fastest(
        3,
        [&mut || {
            all.update(&cpu, &emitters, &eye, &maps)
                .expect("a legal view");
        }],
    );
    println!(
        "  one 512³ frame {:.0} ms; voxels of 256 lights {:.2}×",
        1e3 * frame,
        made / frame
    );
    let host = Store::new();
    let whole = FrameInputs {
        emitters: &emitters,
        ..inputs(&scene, SIDE, &host)
    };
    for (name, reduction) in [
        ("in full", Reduction::NONE),
        ("3x3", Reduction::WINDOWS_OF_3),
        ("3x3 quarter", Reduction::WINDOWS_OF_3.and_a_quarter()),
    ] {
        let [gathered] = fastest(
            1,
            [&mut || {
                let choice = Choice::new(&cpu, &whole, reduction).expect("rays of a picture");
                let rays = choice.rays().to_vec();
                let mut some = vec![[0.0; 4]; rays.len()];
                let many = ManyLights {
                    rays: &rays,
                    emitters: &emitters,
                    medium: &scene.medium,
                    detail: Detail::Average,
                    interleaving: choice.inputs(&whole).selection.interleaving,
                };
                cpu.gather_many(&many, &all, &airlight, &mut some)
                    .expect("as many rays");
                let filling = Filling::upload(&cpu, &choice, &scene.rays).expect("memory");
                cpu.fill_picture(&filling, &some, &mut radiance)
                    .expect("as many pixels");
            }],
        );
        println!(
            "  gather of 256 lights {name}: {:.1}×, with voxels {:.1}×",
            gathered / frame,
            (made + gathered) / frame
        );
    }
}

/// A large picture whose error is known at every 397th pixel.
struct Large {
    scene: TestScene,
    pixels: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    truth: Reference,
}

/// What a method makes of it: its error, the time of all passes but that of making the
/// voxels, and that.
struct Made {
    error: f64,
    seconds: f64,
    voxels: f64,
}

impl Large {
    fn new() -> Self {
        const STEP: usize = 397;
        let scene = TestScene::new(Embedded::Pergola, 960, 540);
        let pixels: Vec<u32> = (0..scene.rays.len() as u32)
            .filter(|pixel| *pixel as usize % STEP == STEP / 2)
            .collect();
        let rays: Vec<_> = pixels.iter().map(|i| scene.rays[*i as usize]).collect();
        let hits = pixels.iter().map(|i| scene.hits[*i as usize]).collect();
        let panel = [scene.areas[0].light.clone()];
        let options = Options {
            tolerance: 2e-3,
            ..Options::default()
        };
        let truth = area::reference(&rays, &[], &panel, &scene.medium, &scene.geometry, options);
        Self {
            scene,
            pixels,
            rays,
            hits,
            truth,
        }
    }

    /// A frame of a method, of all pixels or of those whose error is known; maps are
    /// made before.
    fn frame(&self, name: &str, quality: u32, all: bool) -> Made {
        let host = Store::new();
        let mut inputs = inputs(&self.scene, SIDE, &host);
        if !all {
            inputs.rays = &self.rays;
            inputs.hits = &self.hits;
            inputs.selection.pixels = Some(&self.pixels);
        }
        let registry = Registry::standard();
        let (cpu, store) = (Cpu::new(), Store::new());
        let frame = Frame::new(&cpu, inputs, &store).expect("memory").timed();
        let method = registry.find(name).expect("a method");
        method.prepare(&frame, quality).expect("a legal quality");
        let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
        method
            .add_radiance(&frame, quality, &mut radiance)
            .expect("a legal quality");
        let mut made = Made {
            error: 0.0,
            seconds: 0.0,
            voxels: 0.0,
        };
        for pass in frame.passes() {
            let sum = match pass.what {
                "voxels" => &mut made.voxels,
                _ => &mut made.seconds,
            };
            *sum += pass.seconds;
        }
        if all {
            radiance = (self.pixels.iter().map(|i| radiance[*i as usize])).collect();
        }
        made.error = image_error(&radiance, &self.truth).rmse;
        made
    }
}

/// Time to an equal error: the gathers of 256 lights beside the careful ray tracer.
fn baseline() {
    let large = Large::new();
    let counts = [8, 16, 32, 64, 128, 256, 512, 1024];
    let traced = counts.map(|count| large.frame("area-rays", count, false));
    let of_rays: Vec<f64> = traced.iter().map(|made| made.error).collect();
    println!("  error of rays {counts:?}: {of_rays:.5?}");
    let of_runs = [4, 16, 64, 256].map(|count| large.frame("area-traced-runs", count, false).error);
    println!("  error of traced runs [4, 16, 64, 256]: {of_runs:.5?}");
    // Of one ray to the light in every pixel.
    let pixels = large.scene.rays.len() as f64 / large.rays.len() as f64;
    let per_ray = traced[5].seconds / 256.0 * pixels;
    for name in [
        "area-imperfect",
        "area-average",
        "area-runs",
        "area-runs 3x3",
        "area-runs 3x3 quarter",
    ] {
        let made = large.frame(name, 256, true);
        // Between two counts errors follow a power of the count.
        let next = of_rays.iter().position(|error| *error < made.error);
        let (needed, more) = match next {
            Some(next @ 1..) => {
                let [a, b] = [of_rays[next - 1], of_rays[next]];
                let share = (a / made.error).ln() / (a / b).ln();
                (f64::from(counts[next - 1]) * 2_f64.powf(share), "")
            }
            Some(0) => (f64::from(counts[0]), "less than "),
            _ => (f64::from(counts[counts.len() - 1]), "more than "),
        };
        println!(
            "  {name} 256: error {:.5}, {more}{needed:.0} rays; gather of {:.2} s {:.2}×, with voxels {:.2}× faster than these",
            made.error,
            made.seconds,
            needed * per_ray / made.seconds,
            needed * per_ray / (made.seconds + made.voxels)
        );
    }
}

/// Error and time of froxels, and of gathers that take as long.
fn froxels() {
    let large = Large::new();
    for (name, qualities) in [
        ("froxels", &[32, 64, 128, 256][..]),
        ("froxels-engine", &[64]),
        ("area-runs 3x3 quarter", &[4, 16, 64, 256]),
        ("area-runs 3x3", &[16, 64, 256]),
    ] {
        for quality in qualities {
            let made = large.frame(name, *quality, true);
            println!(
                "  {name} {quality}: error {:.4}, {:.0} ms",
                made.error,
                1e3 * (made.seconds + made.voxels)
            );
        }
    }
}
