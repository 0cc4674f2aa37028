//! The error over the resolution of maps and voxels.

use gpu_backend::Cpu;
use lighting::voxelized::Detail;
use reference::metrics::Reference;

use super::frames::Setting;
use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// All together, and α, θ and the maps with φ at the paper's 128; the paper's frame in
/// ms where it has one.
const ALL: &[u32] = &[32, 64, 128, 256];
/// Numbers of lights, for the resolution that they need.
const LIGHTS: &[u32] = &[16, 64, 256];
const SWEEP: &[(u32, f64)] = &[(32, 19.5), (64, 19.7), (128, 26.8), (256, 43.8)];

/// As far as the time allows.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    truth: &Reference,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    let mut table = Table::new(vec![
        Column::plain("varied"),
        Column::plain("voxels"),
        Column::new("error: average", Unit::Share),
        Column::new("error: runs", Unit::Share),
        Column::new("maps", Unit::Seconds),
        Column::new("voxels made", Unit::Seconds),
        Column::new("paper: frame", Unit::Seconds),
    ])
    .titled(
        "Errors over the resolution",
        "The sweep of figure 6 and section 4 of Wyman and Dai 2013, which varies α and θ but not φ, and the same for fewer and for more lights. Shadow maps are exact and have as many texels per side as α and θ have voxels.",
    );
    table.grouped = true;
    let all = |lights: u32| {
        let sides = ALL.iter();
        sides.map(move |side| ("all", lights, *side, *side, f64::NAN))
    };
    let sweep = SWEEP.iter();
    let sweep = sweep.map(|(side, ms)| ("α, θ", 128, *side, 128, 1e-3 * ms));
    let others = LIGHTS.iter().flat_map(|lights| all(*lights));
    for (varied, lights, side, bits, paper) in all(128).chain(sweep).chain(others) {
        if let Some(why) = limit.reached() {
            study.leave_out("finer resolutions", why);
            break;
        }
        let run = |detail| {
            let setting = Setting {
                lights,
                map: side,
                voxels: [side, bits],
                detail,
                ..Setting::default()
            };
            setting.error(cpu, scene, truth)
        };
        let (average, runs) = (run(Detail::Average)?, run(Detail::Runs)?);
        let name = format!("{varied} of {lights} lights");
        record(study, "rmse average", &name, side, average.rmse);
        record(study, "rmse runs", &name, side, runs.rmse);
        record(study, "seconds maps", &name, side, runs.seconds[0]);
        record(study, "seconds voxels", &name, side, runs.seconds[1]);
        let paper = match paper.is_nan() {
            true => Cell::from(""),
            false => paper.into(),
        };
        table.push(vec![
            name.into(),
            format!("{side}² × {bits}").into(),
            average.rmse.into(),
            runs.rmse.into(),
            runs.seconds[0].into(),
            runs.seconds[1].into(),
            paper,
        ]);
    }
    if !table.rows().is_empty() {
        study.parts.push(Part::Table(table));
    }
    Ok(())
}
