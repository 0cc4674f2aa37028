//! The steps of a frame, for all lights at once and for one after the other.

use std::time::Instant;

use gpu_backend::{Cpu, Host};
use lighting::area::{GatherMany, ManyLights};
use lighting::shadow_map::{Casters, LevelOfDetail, RenderShadowMap};
use lighting::voxelized::{Detail, Resolution, VoxelVolume};
use lighting::{Emitter, Gather, Interleaving, LitRays};
use voxel_shadow::{
    AtlasGrid, AtlasMap, BuildAtlas, BuildGrid, Grid, IndexMap, Rectify, RectifyAtlas,
};

use super::frames::{Maps, Setting};
use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::compare::times::Times;
use crate::failure::Failure;

/// Lights of the paper's table.
const LIGHTS: &[u32] = &[1, 4, 16, 64, 256];
const QUICK_LIGHTS: &[u32] = &[1, 4];

/// Points that are splatted into a map; the paper has the number of none.
const POINTS: u32 = 4096;

/// Milliseconds of the paper's table 1: map, voxelise, scan, gather; for separate
/// volumes, and for all at once.
const PAPER: [(u32, [f64; 4], [f64; 4]); 5] = [
    (1, [0.44, 0.24, 0.47, 0.39], [1.66, 0.24, 0.47, 0.39]),
    (4, [1.22, 1.01, 1.99, 1.57], [1.23, 0.30, 0.48, 0.92]),
    (16, [4.31, 3.89, 7.73, 6.19], [1.12, 0.44, 0.62, 3.26]),
    (64, [16.73, 15.67, 30.94, 24.89], [2.00, 1.20, 1.55, 12.63]),
    (
        256,
        [66.25, 62.37, 123.73, 99.48],
        [3.58, 3.75, 4.79, 50.26],
    ),
];

const NAMES: [&str; 4] = ["shadow maps", "voxelise", "scan", "gather"];

/// The time of a frame, by step.
#[derive(Debug, Clone, Copy)]
struct Steps {
    lights: u32,
    /// A volume for each light, exact maps.
    separate: [f64; 4],
    /// All at once, imperfect maps.
    together: [f64; 4],
}

/// As many lights as the time allows.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    quick: bool,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    let mut found: Vec<Steps> = Vec::new();
    for &lights in if quick { QUICK_LIGHTS } else { LIGHTS } {
        let last = found.last().map_or(0.0, |steps| {
            let once: f64 = steps.separate.iter().chain(&steps.together).sum();
            // Four times as many lights, and voxels that are made twice.
            1.5 * once * f64::from(lights / steps.lights)
        });
        if let Some(why) = limit.reached_after(last) {
            study.leave_out(&format!("steps of {lights} lights and more"), why);
            break;
        }
        let setting = Setting {
            lights,
            maps: Maps::Imperfect(POINTS, LevelOfDetail::Near),
            detail: Detail::Average,
            ..Setting::default()
        };
        let rounds = if quick || lights > 16 { 1 } else { 3 };
        let emitters = setting.emitters(scene)?;
        found.push(Steps {
            lights,
            separate: median(rounds, || separate(cpu, scene, &setting, &emitters))?,
            together: median(rounds, || together(cpu, scene, &setting, &emitters))?,
        });
    }
    describe(study, &found, scene.rays.len());
    Ok(())
}

/// The median of each step over a few rounds.
fn median(rounds: usize, run: impl Fn() -> Result<[f64; 4], Failure>) -> Result<[f64; 4], Failure> {
    let all: Vec<[f64; 4]> = (0..rounds).map(|_| run()).collect::<Result<_, _>>()?;
    Ok(std::array::from_fn(|step| {
        let times: Vec<f64> = all.iter().map(|steps| steps[step]).collect();
        Times::of(&times).median
    }))
}

fn timed<R>(sum: &mut f64, step: impl FnOnce() -> Result<R, Failure>) -> Result<R, Failure> {
    let clock = Instant::now();
    let made = step()?;
    *sum += clock.elapsed().as_secs_f64();
    Ok(made)
}

/// A map, a volume and a gather for each light.
fn separate(
    cpu: &Cpu,
    scene: Scene<'_>,
    setting: &Setting,
    emitters: &[Emitter],
) -> Result<[f64; 4], Failure> {
    let [side, bits] = setting.voxels;
    let resolution = Resolution::new(side, side, bits)?;
    let casters = Casters::upload(cpu, scene.geometry)?;
    let mut volume: VoxelVolume<Host> = VoxelVolume::new(cpu, resolution)?;
    let mut indices = IndexMap::new(cpu, resolution)?;
    let mut grid = Grid::new(cpu, resolution)?;
    let rays = scene.rays.to_vec();
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let airlight = setting.airlight()?;
    let mut seconds = [0.0; 4];
    for emitter in emitters {
        let map = timed(&mut seconds[0], || {
            Ok(cpu.shadow_map(&casters, emitter, setting.map)?)
        })?;
        volume.update(cpu, emitter, &scene.eye, &map)?;
        if let Some(lattice) = volume.lattice_in_use() {
            timed(&mut seconds[1], || {
                cpu.rectify(lattice, &map, &mut indices)?;
                Ok(cpu.voxelise(&indices, &mut grid)?)
            })?;
            timed(&mut seconds[2], || Ok(cpu.extrude(&mut grid)?))?;
        }
        timed(&mut seconds[3], || {
            let lit = LitRays::new(&rays, emitter, scene.medium);
            let source = volume.source(setting.detail);
            Ok(cpu.gather(&lit, &source, &airlight, &mut radiance)?)
        })?;
    }
    Ok(seconds)
}

/// All maps, all volumes, one gather.
fn together(
    cpu: &Cpu,
    scene: Scene<'_>,
    setting: &Setting,
    emitters: &[Emitter],
) -> Result<[f64; 4], Failure> {
    let mut seconds = [0.0; 4];
    let (maps, map_seconds) = setting.maps(cpu, scene, emitters)?;
    seconds[0] = map_seconds;
    let mut volumes = setting.volumes(cpu)?;
    volumes.update(cpu, emitters, &scene.eye, &maps)?;
    let (mut lattices, mut of_tiles) = (Vec::new(), Vec::new());
    for (light, lattice) in volumes.with_voxels() {
        lattices.push(lattice.clone());
        // As many as `Setting::lights`, a u32.
        of_tiles.push(light as u32);
    }
    if let (Some(source), false) = (maps.of_tiles(&of_tiles), lattices.is_empty()) {
        let mut indices = AtlasMap::new(cpu, volumes.resolution(), lattices.len())?;
        let mut grid = AtlasGrid::new(cpu, volumes.resolution(), lattices.len())?;
        timed(&mut seconds[1], || {
            Ok(cpu.rectify_atlas(&lattices, &source, &mut indices)?)
        })?;
        timed(&mut seconds[2], || {
            Ok(cpu.build_atlas(&indices, lattices.len(), &mut grid)?)
        })?;
    }
    let rays = scene.rays.to_vec();
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let airlight = setting.airlight()?;
    let many = ManyLights {
        rays: &rays,
        emitters,
        medium: scene.medium,
        detail: setting.detail,
        interleaving: Interleaving::NONE,
    };
    timed(&mut seconds[3], || {
        Ok(cpu.gather_many(&many, &volumes, &airlight, &mut radiance)?)
    })?;
    Ok(seconds)
}

fn describe(study: &mut Study, all: &[Steps], rays: usize) {
    if all.is_empty() {
        return;
    }
    let mut columns = vec![Column::plain("lights"), Column::plain("how")];
    columns.extend(NAMES.map(|name| Column::new(name, Unit::Seconds)));
    columns.push(Column::new("frame", Unit::Seconds));
    let mut table = Table::new(columns).titled(
        "All lights at once, and a volume for each",
        format!(
            "As in tables 1 and 2 of Wyman and Dai 2013: shadow maps of 128² texels, volumes of 128³ voxels, and the average of their bits, here for {rays} rays. Separate volumes have rasterised maps; volumes that are built all at once have imperfect maps of {POINTS} points, which are sampled once for all frames and not counted. Voxelising includes the rectification. If all volumes are built at once, the scan includes setting the bits, which fills the words that it reads."
        ),
    );
    table.grouped = true;
    for steps in all {
        let Steps {
            lights,
            separate,
            together,
        } = steps;
        let mut put = |how: &str, seconds: [f64; 4]| {
            let mut cells: Vec<Cell> = vec![(*lights).into(), how.into()];
            cells.extend(seconds.map(Cell::from));
            cells.push(seconds.iter().sum::<f64>().into());
            table.push(cells);
        };
        put("separate", *separate);
        put("at once", *together);
        for (how, seconds) in [("separate", separate), ("at once", together)] {
            for (name, seconds) in NAMES.iter().zip(seconds) {
                record(study, &format!("seconds {name}"), how, *lights, *seconds);
            }
        }
        let paper = PAPER.iter().find(|row| row.0 == *lights);
        if let Some((_, separate, together)) = paper {
            put("paper, separate", separate.map(|ms| 1e-3 * ms));
            put("paper, at once", together.map(|ms| 1e-3 * ms));
        }
    }
    study.parts.push(Part::Table(table));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_for_each_way_and_the_papers_beside_it() {
        let mut study = super::super::KIND.blank();
        let steps = |lights| Steps {
            lights,
            separate: [0.5, 0.25, 0.125, 0.125],
            together: [1e-3; 4],
        };
        describe(&mut study, &[steps(4), steps(5)], 100);
        let Part::Table(table) = &study.parts[0] else {
            panic!("a table: {:?}", study.parts);
        };
        // There is no paper's row for five lights.
        assert_eq!(table.rows().len(), 4 + 2);
        assert_eq!(table.rows()[0].cells[6], 1.0.into());
        assert_eq!(study.records.rows().len(), 2 * 2 * 4);
        describe(&mut study, &[], 100);
        assert_eq!(study.parts.len(), 1);
    }
}
