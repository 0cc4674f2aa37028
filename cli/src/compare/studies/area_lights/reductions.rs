//! The gather of many lights with fewer rays, and with rays that share the lights.

use std::time::Instant;

use gpu_backend::{Cpu, Host};
use lighting::Ray;
use lighting::area::{GatherMany, LightVolumes, ManyLights};
use lighting::methods::reduced::{Choice, FillPicture, Filling, Reduction};
use lighting::methods::{FrameInputs, Selection, Store};
use lighting::shadow_map::LevelOfDetail;
use lighting::voxelized::Detail;
use reference::metrics::{Reference, image_error};

use super::frames::{Maps, Setting};
use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// Lights of the paper's table.
const LIGHTS: u32 = 256;
const QUICK_LIGHTS: u32 = 16;

/// Points that are splatted into a map.
const POINTS: u32 = 4096;

/// The reductions, and milliseconds of the gather in the paper's table 2, of the scene
/// with the hairball, where it has them.
const ALL: [(&str, Reduction, f64); 6] = [
    ("full", Reduction::NONE, 77.7),
    ("2x2", Reduction::WINDOWS_OF_2, f64::NAN),
    ("3x3", Reduction::WINDOWS_OF_3, 12.4),
    ("quarter", Reduction::QUARTER, 19.0),
    ("sixteenth", Reduction::SIXTEENTH, f64::NAN),
    (
        "3x3 quarter",
        Reduction::WINDOWS_OF_3.and_a_quarter(),
        f64::NAN,
    ),
];

/// Time and error of a reduction.
#[derive(Debug, Clone, Copy)]
struct Gathered {
    name: &'static str,
    /// Time of the gather, with the choice of pixels and the filling.
    seconds: f64,
    /// The error against the full gather.
    rmse: f64,
    /// Share of the pixels that are gathered in full.
    in_full: f64,
    /// Milliseconds.
    paper: f64,
}

/// Measures as many as the time allows.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    size: [u32; 2],
    quick: bool,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    let lights = if quick { QUICK_LIGHTS } else { LIGHTS };
    // Measured: half a microsecond for a ray and a light, and the reductions half as much.
    let expected = 0.75e-6 * f64::from(lights) * scene.rays.len() as f64;
    if let Some(why) = limit.reached_after(expected) {
        study.leave_out("reductions of the gather", why);
        return Ok(());
    }
    let setting = Setting {
        lights,
        maps: Maps::Imperfect(POINTS, LevelOfDetail::Near),
        detail: Detail::Runs,
        ..Setting::default()
    };
    let emitters = setting.emitters(scene)?;
    let (maps, _) = setting.maps(cpu, scene, &emitters)?;
    let mut volumes = setting.volumes(cpu)?;
    volumes.update(cpu, &emitters, &scene.eye, &maps)?;
    let host = Store::new();
    let inputs = FrameInputs {
        emitters: &emitters,
        areas: &[],
        medium: scene.medium,
        height_fog: None,
        geometry: scene.geometry,
        translucent: &[],
        camera: scene.camera,
        size,
        rays: scene.rays,
        hits: scene.hits,
        map: setting.map,
        host: &host,
        selection: Selection::default(),
        watch: &(),
    };
    let mut found: Vec<Gathered> = Vec::new();
    let mut full: Option<Reference> = None;
    for (name, reduction, paper) in ALL {
        let next = found.first().map_or(0.0, |full| full.seconds);
        if let Some(why) = limit.reached_after(reduction.share() * next) {
            study.leave_out("further reductions of the gather", why);
            break;
        }
        let clock = Instant::now();
        let (radiance, in_full) = gathered(cpu, &setting, &volumes, (&inputs, reduction))?;
        let seconds = clock.elapsed().as_secs_f64();
        let truth = full.get_or_insert_with(|| Reference {
            radiance: radiance
                .iter()
                .map(|[r, g, b, _]| [*r, *g, *b].map(f64::from))
                .collect(),
            bound: vec![0.0; radiance.len()],
        });
        found.push(Gathered {
            name,
            seconds,
            rmse: image_error(&radiance, truth).rmse,
            in_full,
            paper: 1e-3 * paper,
        });
    }
    describe(study, &found, lights, scene.rays.len());
    Ok(())
}

/// The picture, and the share of its pixels that were gathered in full.
fn gathered(
    cpu: &Cpu,
    setting: &Setting,
    volumes: &LightVolumes<Host>,
    (inputs, reduction): (&FrameInputs<'_>, Reduction),
) -> Result<(Vec<[f32; 4]>, f64), Failure> {
    let gather = |inputs: &FrameInputs<'_>| -> Result<Vec<[f32; 4]>, Failure> {
        let rays: Vec<Ray> = inputs.rays.to_vec();
        let mut radiance = vec![[0.0; 4]; rays.len()];
        let many = ManyLights {
            rays: &rays,
            emitters: inputs.emitters,
            medium: inputs.medium,
            detail: setting.detail,
            interleaving: inputs.selection.interleaving,
        };
        cpu.gather_many(&many, volumes, &setting.airlight()?, &mut radiance)?;
        Ok(radiance)
    };
    if reduction.is_none() {
        return Ok((gather(inputs)?, 1.0));
    }
    let choice = Choice::new(cpu, inputs, reduction)?;
    let some = gather(&choice.inputs(inputs))?;
    let rays: Vec<Ray> = inputs.rays.to_vec();
    let filling = Filling::upload(cpu, &choice, &rays)?;
    let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
    cpu.fill_picture(&filling, &some, &mut radiance)?;
    Ok((radiance, choice.in_full()))
}

fn describe(study: &mut Study, all: &[Gathered], lights: u32, rays: usize) {
    let Some(full) = all.first() else { return };
    let mut table = Table::new(vec![
        Column::plain("gather"),
        Column::new("time", Unit::Seconds),
        Column::new("faster", Unit::With("×")),
        Column::new("error", Unit::Share),
        Column::new("in full", Unit::Share),
        Column::new("paper", Unit::Seconds),
    ])
    .titled(
        "The gather with less work",
        format!(
            "As in table 2 of Wyman and Dai 2013: {lights} lights, imperfect maps of {POINTS} points, lit runs, {rays} rays. Times include the choice of pixels and the filling. Errors are against the full gather. Pixels that no sample resembles are gathered in full. The paper's times are for 256 lights."
        ),
    );
    for gathered in all {
        let paper = match gathered.paper.is_nan() {
            true => Cell::from(""),
            false => gathered.paper.into(),
        };
        let cells: [Cell; 6] = [
            gathered.name.into(),
            gathered.seconds.into(),
            (full.seconds / gathered.seconds).into(),
            gathered.rmse.into(),
            gathered.in_full.into(),
            paper,
        ];
        table.push(cells.into());
        for (what, value) in [
            ("seconds gather reduced", gathered.seconds),
            ("rmse reduced", gathered.rmse),
            ("share gathered in full", gathered.in_full),
        ] {
            record(study, what, gathered.name, lights, value);
        }
    }
    study.parts.push(Part::Table(table));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_for_each_reduction_beside_the_full_gather() {
        let mut study = super::super::KIND.blank();
        let gathered = |name, seconds| Gathered {
            name,
            seconds,
            rmse: 0.01,
            in_full: 0.25,
            paper: f64::NAN,
        };
        let all = [gathered("full", 2.0), gathered("quarter", 0.5)];
        describe(&mut study, &all, 256, 100);
        let Part::Table(table) = &study.parts[0] else {
            panic!("a table: {:?}", study.parts);
        };
        assert_eq!(table.rows()[1].cells[2], 4.0.into());
        assert_eq!(study.records.rows().len(), 2 * 3);
        describe(&mut study, &[], 256, 100);
        assert_eq!(study.parts.len(), 1);
    }
}
