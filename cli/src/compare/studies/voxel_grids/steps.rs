//! The steps of a frame of 512³ voxels on one backend.

use std::time::Instant;

use gpu_backend::gpu::Gpu;
use gpu_backend::{Backend, Cpu, Download};
use lighting::airlight::EquiAngular;
use lighting::shadow_map::{Casters, RenderShadowMap};
use lighting::voxelized::{BuildVoxels, Detail, Resolution, VoxelShadow, VoxelVolume};
use lighting::{Gather, LitRays};
use voxel_shadow::{Grid, IndexMap};

use super::{Scene, record};
use crate::compare::studies::Device;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::compare::times::Times;
use crate::failure::Failure;

/// Voxels along each coordinate, as in the paper.
const SIDE: u32 = 512;

/// Times of a frame on one backend.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    pub(super) backend: String,
    /// Its short name.
    pub(super) short: String,
    pub(super) rectify: Times,
    pub(super) voxelise: Times,
    pub(super) extrude: Times,
    /// The paper's gather, and that of runs.
    pub(super) average: Times,
    pub(super) runs: Times,
    pub(super) rays: usize,
}

impl Steps {
    /// Seconds of creation and use with the paper's gather.
    fn total(&self) -> f64 {
        [&self.rectify, &self.voxelise, &self.extrude, &self.average]
            .iter()
            .map(|times| times.median)
            .sum()
    }
}

/// Records the steps, and shows them in a table.
pub(super) fn describe(study: &mut Study, all: &[Steps]) {
    if all.is_empty() {
        return;
    }
    let mut columns = vec![Column::plain("backend")];
    let names = [
        "rectify",
        "voxelise",
        "scan",
        "gather: average",
        "creation and use",
        "gather: runs instead",
    ];
    columns.extend(names.map(|name| Column::new(name, Unit::Seconds)));
    columns.push(Column::plain("rays"));
    let mut table = Table::new(columns).titled(
        "A frame of 512³ voxels, step by step",
        "In Wyman and Dai 2013, creation and use take 7.2 ms on a GPU of that year, without the runs, and with other rays and another scene.",
    );
    for steps in all {
        for (what, times) in [
            ("seconds rectify", &steps.rectify),
            ("seconds voxelise", &steps.voxelise),
            ("seconds extrude", &steps.extrude),
            ("seconds gather average", &steps.average),
            ("seconds gather runs", &steps.runs),
        ] {
            record(study, what, &steps.backend, SIDE, times.median);
        }
        let mut cells: Vec<Cell> = vec![steps.short.as_str().into()];
        let seconds = [
            steps.rectify.median,
            steps.voxelise.median,
            steps.extrude.median,
            steps.average.median,
            steps.total(),
            steps.runs.median,
        ];
        cells.extend(seconds.map(Cell::from));
        cells.push(steps.rays.into());
        table.push(cells);
    }
    study.parts.push(Part::Table(table));
}

/// Times of a frame on a backend: medians over a few rounds. `None` if the
/// light needs no voxels.
pub(super) fn measure_on(
    device: &Device<'_>,
    scene: Scene<'_>,
    quick: bool,
) -> Result<Option<Steps>, Failure> {
    let rounds = if quick { 3 } else { 9 };
    match device.context {
        None => measure(&Cpu::new(), device, scene, rounds),
        Some(context) => measure(&Gpu::new(context.clone()), device, scene, rounds),
    }
}

type MemoryOf<B> = <B as Backend>::Memory;

fn measure<B>(
    backend: &B,
    device: &Device<'_>,
    scene: Scene<'_>,
    rounds: usize,
) -> Result<Option<Steps>, Failure>
where
    B: BuildVoxels + Download + RenderShadowMap,
    B: for<'a> Gather<VoxelShadow<&'a VoxelVolume<MemoryOf<B>>, MemoryOf<B>>, EquiAngular>,
{
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
            let lit = LitRays::new(&rays, scene.emitter, scene.medium);
            backend.gather(&lit, &source, &eight, &mut radiance)
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
        backend: device.label.clone(),
        short: device.short.clone(),
        rectify,
        voxelise,
        extrude,
        average,
        runs,
        rays: scene.rays.len(),
    }))
}

fn timed<B: Download>(
    backend: &B,
    step: impl FnOnce() -> Result<(), Failure>,
) -> Result<f64, Failure> {
    backend.wait()?;
    let clock = Instant::now();
    step()?;
    backend.wait()?;
    Ok(clock.elapsed().as_secs_f64())
}
