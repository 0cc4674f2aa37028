//! Voxelized shadow volumes by themselves: what their steps take, which of
//! their resolutions an error comes from, and how far shadows start behind what
//! casts them.

use std::collections::HashMap;
use std::fmt::Write;
use std::time::Instant;

use crepuscular_tests::metrics::image_error;
use crepuscular_tests::oracle::image::{Options, Reference, reference};
use glam::Vec3;
use gpu_backend::{Backend, Cpu, Host};
use lighting::airlight::EquiAngular;
use lighting::scene::{Geometry, Medium};
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::trace::Tracer;
use lighting::voxels::{Detail, Eye, Resolution, Sampling, VoxelVolume};
use lighting::{Emitter, Gather, Ray};
use voxel_shadow::{Grid, IndexMap, ShadowVolume};

use super::results::{LeftOut, Times};
use crate::engine::Renderer;
use crate::failure::Failure;
use crate::progress;

/// Voxels along each coordinate whose steps are timed, as in the paper.
const SIDE: u32 = 512;

/// Resolutions that are compared, the finest last.
const SIZES: &[u32] = &[64, 128, 256, 512];
const QUICK_SIZES: &[u32] = &[64, 512];

/// Resolutions of α at which detachment is measured.
const ALPHAS: &[u32] = &[64, 128, 256, 512, 1024];

/// Rays on which errors are measured, and light rays for detachment.
const RAYS: usize = 2400;
const LIGHT_RAYS: usize = 2000;

/// One light of a scene, and the rays that see it.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) tracer: &'a Tracer,
    pub(crate) medium: &'a Medium,
    pub(crate) emitter: &'a Emitter,
    pub(crate) eye: Eye,
    pub(crate) rays: &'a [Ray],
    /// Texels per side of a shadow map.
    pub(crate) map: u32,
}

/// What the section says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Voxels {
    pub(crate) steps: Vec<Steps>,
    pub(crate) refinements: Vec<Refinement>,
    pub(crate) detachments: Vec<Detachment>,
    /// RMSE with the paper's biases and without, at the finest resolution.
    pub(crate) biased: f64,
    pub(crate) unbiased: f64,
    /// What the time did not suffice for.
    pub(crate) left_out: Vec<LeftOut>,
}

/// Times of a frame of 512³ voxels on one backend.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    pub(crate) backend: String,
    pub(crate) rectify: Times,
    pub(crate) voxelise: Times,
    pub(crate) extrude: Times,
    /// The paper's gather, and that of runs.
    pub(crate) average: Times,
    pub(crate) runs: Times,
    pub(crate) rays: usize,
}

impl Steps {
    /// Seconds of creation and use with the paper's gather.
    pub(crate) fn total(&self) -> f64 {
        [&self.rectify, &self.voxelise, &self.extrude, &self.average]
            .iter()
            .map(|times| times.median)
            .sum()
    }
}

/// Which resolution varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axis {
    Map,
    Phi,
    Theta,
    Alpha,
    All,
}

impl Axis {
    pub(crate) const ALL: [Self; 5] = [Self::Map, Self::Phi, Self::Theta, Self::Alpha, Self::All];

    /// Its name in a table.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Map => "shadow map",
            Self::Phi => "φ",
            Self::Theta => "θ",
            Self::Alpha => "α",
            Self::All => "all",
        }
    }
}

/// RMSE over the mean radiance, with one resolution other than the rest.
#[derive(Debug, Clone)]
pub(crate) struct Refinement {
    pub(crate) axis: Axis,
    pub(crate) size: u32,
    /// With all others at the coarsest size, and at the finest.
    pub(crate) rest_coarse: f64,
    pub(crate) rest_fine: f64,
}

/// How far behind a blocker its shadow begins, in metres along the light.
#[derive(Debug, Clone)]
pub(crate) struct Detachment {
    pub(crate) alpha: u32,
    /// Median and 90th percentile over light rays, with the paper's bias and
    /// with none.
    pub(crate) paper: [f64; 2],
    pub(crate) unbiased: [f64; 2],
}

/// Everything but the times, on the CPU. Nothing more is begun once `seconds`
/// are over.
pub(crate) fn judge(scene: Scene<'_>, quick: bool, seconds: f64) -> Result<Voxels, Failure> {
    let clock = Instant::now();
    let is_over = || clock.elapsed().as_secs_f64() >= seconds;
    let mut voxels = Voxels::default();
    let no_time = |what: &str| LeftOut {
        what: format!("voxels alone: {what}"),
        why: "no time left (--time-budget)".into(),
    };
    if is_over() {
        voxels.left_out.push(no_time("all of it"));
        return Ok(voxels);
    }
    let cpu = Cpu::new();
    let sizes = if quick { QUICK_SIZES } else { SIZES };
    let last = sizes.len() - 1;
    let step = (scene.rays.len() / RAYS).max(1) | 1;
    let rays: Vec<Ray> = scene.rays.iter().step_by(step).copied().collect();
    let truth = reference(
        &rays,
        std::slice::from_ref(scene.emitter),
        scene.medium,
        scene.geometry,
        Options::default(),
    );
    let bar = progress::bar("voxels alone", (5 * sizes.len() + ALPHAS.len()) as u64);
    let casters = Casters::upload(&cpu, scene.geometry)?;
    let maps: Vec<ShadowMap<Host>> = sizes
        .iter()
        .map(|size| cpu.shadow_map(&casters, scene.emitter, 2 * size))
        .collect::<Result<_, _>>()?;
    let picture = Picture {
        scene,
        rays: &rays,
        truth: &truth,
    };
    // Axes share their ends.
    let mut known: HashMap<[usize; 4], f64> = HashMap::new();
    let mut error = |at: [usize; 4]| -> Result<f64, Failure> {
        if let Some(error) = known.get(&at) {
            return Ok(*error);
        }
        let [map, phi, theta, alpha] = at;
        let resolution = Resolution::new(sizes[alpha], sizes[theta], sizes[phi])?;
        let error = picture.error(&cpu, &maps[map], resolution, Sampling::UNBIASED)?;
        known.insert(at, error);
        Ok(error)
    };
    for axis in Axis::ALL {
        if is_over() {
            voxels
                .left_out
                .push(no_time(&format!("other resolutions of {}", axis.name())));
            continue;
        }
        for (index, &size) in sizes.iter().enumerate() {
            let with = |rest: usize| {
                [Axis::Map, Axis::Phi, Axis::Theta, Axis::Alpha].map(|other| {
                    if axis == other || axis == Axis::All {
                        index
                    } else {
                        rest
                    }
                })
            };
            voxels.refinements.push(Refinement {
                axis,
                size,
                rest_coarse: error(with(0))?,
                rest_fine: error(with(last))?,
            });
            bar.inc(1);
        }
    }
    voxels.unbiased = error([last; 4])?;
    let finest = Resolution::new(sizes[last], sizes[last], sizes[last])?;
    voxels.biased = picture.error(&cpu, &maps[last], finest, Sampling::default())?;
    for &alpha in ALPHAS {
        if is_over() {
            voxels.left_out.push(no_time("detachment at finer α"));
            break;
        }
        let resolution = Resolution::new(alpha, sizes[last], sizes[last])?;
        voxels
            .detachments
            .extend(detachment(&cpu, scene, &maps[last], resolution)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(voxels)
}

/// Rays and what they should show.
struct Picture<'a> {
    scene: Scene<'a>,
    rays: &'a Vec<Ray>,
    truth: &'a Reference,
}

impl Picture<'_> {
    /// The RMSE of a sum over bits, which any light takes.
    fn error(
        &self,
        cpu: &Cpu,
        map: &ShadowMap<Host>,
        resolution: Resolution,
        sampling: Sampling,
    ) -> Result<f64, Failure> {
        let Scene {
            emitter,
            eye,
            medium,
            ..
        } = self.scene;
        let mut volume = VoxelVolume::new(cpu, resolution)?.with_sampling(sampling);
        volume.update(cpu, emitter, &eye, map)?;
        let mut radiance = vec![[0.0; 4]; self.rays.len()];
        let (source, one) = (volume.source(Detail::Voxels), EquiAngular::new(1)?);
        cpu.gather(self.rays, emitter, medium, &source, &one, &mut radiance)?;
        Ok(image_error(&radiance, self.truth).rmse)
    }
}

/// `None` if no light ray meets anything in view.
fn detachment(
    cpu: &Cpu,
    scene: Scene<'_>,
    map: &ShadowMap<Host>,
    resolution: Resolution,
) -> Result<Option<Detachment>, Failure> {
    let mut volume = VoxelVolume::new(cpu, resolution)?;
    volume.update(cpu, scene.emitter, &scene.eye, map)?;
    let Some(lattice) = volume.lattice_in_use() else {
        return Ok(None);
    };
    let shadows = [Sampling::default(), Sampling::UNBIASED]
        .map(|sampling| ShadowVolume::new(lattice, volume.grid(), sampling));
    let [paper, unbiased] = shadows;
    let shadows = [paper?, unbiased?];
    let bounds = scene.geometry.bounds();
    let size = bounds.min().distance(bounds.max());
    let (theta, bits) = (resolution.theta() as usize, resolution.bits() as usize);
    let stride = (theta * bits / LIGHT_RAYS).max(1) | 1;
    let mut lengths = [Vec::new(), Vec::new()];
    for index in (0..theta * bits).step_by(stride) {
        let bit = index % bits;
        let light = lattice.light_ray(index / bits, bit);
        let [start, direction] = [light.origin, light.direction].map(Vec3::from);
        // Parallel light comes from before all casters.
        let back = if matches!(scene.emitter, Emitter::Directional(_)) {
            size + start.distance(bounds.min())
        } else {
            0.0
        };
        let origin = start - back * direction;
        let Some(ray) = Ray::new(origin, direction, f32::INFINITY) else {
            continue;
        };
        let Some(hit) = scene.tracer.closest_hit(&ray) else {
            continue;
        };
        let first = hit.distance - back;
        let row = lattice.blocked_from(bit, first);
        if row == 0 || row >= resolution.alpha() {
            continue;
        }
        for (shadow, lengths) in shadows.iter().zip(&mut lengths) {
            let lit = |behind: f32| shadow.visibility(start + (first + behind) * direction) > 0.5;
            lengths.push(f64::from(last_lit(lit, size)));
        }
    }
    let [Some(paper), Some(unbiased)] = lengths.map(percentiles) else {
        return Ok(None);
    };
    Ok(Some(Detachment {
        alpha: resolution.alpha(),
        paper,
        unbiased,
    }))
}

/// Where a light ray turns dark, at most `most`, by halving: light does not
/// come back along a light ray.
fn last_lit(lit: impl Fn(f32) -> bool, most: f32) -> f32 {
    let (mut low, mut high) = (0.0, most);
    if !lit(low) {
        return 0.0;
    }
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if lit(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Median and 90th percentile.
fn percentiles(mut values: Vec<f64>) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * (values.len().max(1) - 1) as f64).round();
        values.get(index as usize).copied()
    };
    Some([at(0.5)?, at(0.9)?])
}

/// Times of a frame on a backend: the medians of `rounds`.
pub(crate) fn time_steps<B: Renderer>(
    backend: &B,
    label: &str,
    scene: Scene<'_>,
    rounds: usize,
) -> Result<Option<Steps>, Failure> {
    let casters = Casters::upload(backend, scene.geometry)?;
    let map = backend.shadow_map(&casters, scene.emitter, scene.map)?;
    let resolution = Resolution::new(SIDE, SIDE, SIDE)?;
    let mut volume = VoxelVolume::new(backend, resolution)?;
    volume.update(backend, scene.emitter, &scene.eye, &map)?;
    let Some(lattice) = volume.lattice_in_use() else {
        return Ok(None);
    };
    let mut indices = IndexMap::new(backend, resolution)?;
    let mut grid = Grid::new(backend, resolution)?;
    let rays = backend.upload(scene.rays)?;
    let eight = EquiAngular::new(8)?;
    let mut times: [Vec<f64>; 5] = Default::default();
    // The first round builds pipelines.
    for round in 0..=rounds {
        let mut radiance = backend.zeros::<[f32; 4]>(scene.rays.len())?;
        let mut gather = |detail| {
            let source = volume.source(detail);
            backend.gather(
                &rays,
                scene.emitter,
                scene.medium,
                &source,
                &eight,
                &mut radiance,
            )
        };
        let seconds = [
            timed(backend, || {
                Ok(backend.rectify(lattice, &map, &mut indices)?)
            })?,
            timed(backend, || Ok(backend.voxelise(&indices, &mut grid)?))?,
            timed(backend, || Ok(backend.extrude(&mut grid)?))?,
            timed(backend, || Ok(gather(Detail::Average)?))?,
            timed(backend, || Ok(gather(Detail::Runs)?))?,
        ];
        if round > 0 {
            for (times, seconds) in times.iter_mut().zip(seconds) {
                times.push(seconds);
            }
        }
    }
    let [rectify, voxelise, extrude, average, runs] = times.map(|times| Times::of(&times));
    Ok(Some(Steps {
        backend: label.to_owned(),
        rectify,
        voxelise,
        extrude,
        average,
        runs,
        rays: scene.rays.len(),
    }))
}

fn timed<B: Backend + gpu_backend::Download>(
    backend: &B,
    step: impl FnOnce() -> Result<(), Failure>,
) -> Result<f64, Failure> {
    backend.wait()?;
    let clock = Instant::now();
    step()?;
    backend.wait()?;
    Ok(clock.elapsed().as_secs_f64())
}

/// `voxels.csv`: one line per figure.
pub(crate) fn csv(voxels: &Voxels) -> String {
    let mut out = "what,of,size,value\n".to_owned();
    // Writing to a string cannot fail.
    let mut line = |what: &str, of: &str, size: u32, value: f64| {
        let _ = writeln!(out, "{what},\"{}\",{size},{value:e}", of.replace('"', "'"));
    };
    for steps in &voxels.steps {
        for (what, times) in [
            ("seconds rectify", &steps.rectify),
            ("seconds voxelise", &steps.voxelise),
            ("seconds extrude", &steps.extrude),
            ("seconds gather average", &steps.average),
            ("seconds gather runs", &steps.runs),
        ] {
            line(what, &steps.backend, SIDE, times.median);
        }
    }
    for row in &voxels.refinements {
        line(
            "rmse rest coarse",
            row.axis.name(),
            row.size,
            row.rest_coarse,
        );
        line("rmse rest fine", row.axis.name(), row.size, row.rest_fine);
    }
    for row in &voxels.detachments {
        line(
            "metres detached median",
            "the paper's biases",
            row.alpha,
            row.paper[0],
        );
        line(
            "metres detached 90 %",
            "the paper's biases",
            row.alpha,
            row.paper[1],
        );
        line(
            "metres detached median",
            "no bias",
            row.alpha,
            row.unbiased[0],
        );
        line(
            "metres detached 90 %",
            "no bias",
            row.alpha,
            row.unbiased[1],
        );
    }
    if !voxels.refinements.is_empty() {
        line("rmse", "the paper's biases", SIDE, voxels.biased);
        line("rmse", "no bias", SIDE, voxels.unbiased);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_light_is_found_and_limited() {
        assert_eq!(last_lit(|_| false, 8.0), 0.0);
        assert_eq!(last_lit(|_| true, 8.0), 8.0);
        assert!((last_lit(|x| x < 0.3, 8.0) - 0.3).abs() < 1e-5);
    }

    #[test]
    fn percentiles_are_of_what_there_is() {
        assert_eq!(percentiles(Vec::new()), None);
        assert_eq!(percentiles(vec![2.0]), Some([2.0, 2.0]));
        let values = (0..=10).rev().map(f64::from).collect();
        assert_eq!(percentiles(values), Some([5.0, 9.0]));
    }
}
