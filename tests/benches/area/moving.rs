//! A light that moves: what errs from frame to frame beside what errs in each.

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::Interleaving;
use lighting::airlight::EquiAngular;
use lighting::area::{GatherMany, LightVolumes, ManyLights};
use lighting::scene::Pattern;
use lighting::shadow_map::{Casters, RenderShadowMapAtlas};
use lighting::voxelized::Detail;
use reference::scenes::TestScene;

use super::{Embedded, SIDE, cube, eye};

const FRAMES: u32 = 5;

/// How far the light moves from frame to frame, m.
const STEP: Vec3 = Vec3::new(0.01, 0.0, 0.004);

/// Lit runs of exact maps of so many lights against those of 512 lights with twice the
/// texels and voxels along each axis, in five frames.
pub(super) fn moving() {
    let scene = TestScene::new(Embedded::Pergola, 192, 108);
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &scene.geometry).expect("memory");
    let eye = eye(&scene);
    let airlight = EquiAngular::new(4).expect("a legal number");
    let frames = |count: u32, side: u32| -> Vec<Vec<f64>> {
        let frame = |number: u32| {
            let mut light = scene.areas[0].light.clone();
            light.corner += number as f32 * STEP;
            let emitters = (light.virtual_lights(Pattern::Lattice, count)).expect("a sound light");
            let maps = (cpu.shadow_map_atlas(&casters, &emitters, side)).expect("memory");
            let mut all = LightVolumes::new(&cpu, cube(side), emitters.len()).expect("memory");
            (all.update(&cpu, &emitters, &eye, &maps)).expect("a legal view");
            let mut radiance = vec![[0.0; 4]; scene.rays.len()];
            let many = ManyLights {
                rays: &scene.rays,
                emitters: &emitters,
                medium: &scene.medium,
                detail: Detail::Runs,
                interleaving: Interleaving::NONE,
            };
            cpu.gather_many(&many, &all, &airlight, &mut radiance)
                .expect("as many rays");
            let colours = radiance.iter().flat_map(|light| light[..3].to_vec());
            colours.map(f64::from).collect()
        };
        (0..FRAMES).map(frame).collect()
    };
    let truth = frames(512, 2 * SIDE);
    let mean = truth[0].iter().sum::<f64>() / truth[0].len() as f64;
    for count in [8, 16, 64, 128] {
        let found = frames(count, SIDE);
        let errors: Vec<Vec<f64>> = (found.iter().zip(&truth))
            .map(|(found, truth)| difference(found, truth))
            .collect();
        let each = errors.iter().map(|error| rms(error) / mean);
        let between = errors
            .windows(2)
            .map(|pair| rms(&difference(&pair[1], &pair[0])) / mean);
        println!(
            "  {count} lights: error of a frame {:.4}, of the change between two {:.4}",
            each.sum::<f64>() / f64::from(FRAMES),
            between.sum::<f64>() / f64::from(FRAMES - 1)
        );
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / values.len() as f64).sqrt()
}
