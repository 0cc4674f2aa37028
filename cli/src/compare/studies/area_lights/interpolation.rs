//! Few lights, with voxels interpolated and as they are.

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::voxelized::Sampling;
use reference::oracle::image::{Options, reference};

use super::frames::Setting;
use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Column, Part, Study, Table, Unit};
use crate::failure::Failure;

const LIGHTS: u32 = 8;

/// In the air, against the same lights with exact shadows; on surfaces, against shadow
/// rays.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    if let Some(why) = limit.reached() {
        study.leave_out("interpolation", why);
        return Ok(());
    }
    let setting = Setting {
        lights: LIGHTS,
        ..Setting::default()
    };
    let lights = setting.emitters(scene)?;
    let options = Options {
        tolerance: 1e-4,
        ..Options::default()
    };
    let truth = reference(scene.rays, &lights, scene.medium, scene.geometry, options);
    let mut table = Table::new(vec![
        Column::plain("voxels"),
        Column::new("error in the air", Unit::Share),
        Column::new("error on surfaces", Unit::Number),
    ])
    .titled(
        "Eight lights, with and without interpolation",
        "The quantities of figure 13 of Wyman and Dai 2013: the error against the same eight lights with exact shadows. In the air it is the error that is used everywhere here; on surfaces it is the RMSE of the mean visibility of the lights.",
    );
    for (name, interpolate) in [("as they are", false), ("interpolated", true)] {
        let setting = Setting {
            interpolate,
            ..setting
        };
        let air = setting.error(cpu, scene, &truth)?.rmse;
        let surfaces = on_surfaces(cpu, scene, &setting, &lights)?;
        record(study, "rmse air", name, LIGHTS, air);
        record(study, "rmse surfaces", name, LIGHTS, surfaces);
        table.push(vec![name.into(), air.into(), surfaces.into()]);
    }
    study.parts.push(Part::Table(table));
    Ok(())
}

/// The error of visibility, the mean of all lights, where rays end; with the biases
/// that surfaces need.
fn on_surfaces(
    cpu: &Cpu,
    scene: Scene<'_>,
    setting: &Setting,
    lights: &[Emitter],
) -> Result<f64, Failure> {
    let (maps, _) = setting.maps(cpu, scene, lights)?;
    let mut volumes = setting.volumes(cpu)?;
    volumes.update(cpu, lights, &scene.eye, &maps)?;
    let sampling = Sampling {
        interpolate: setting.interpolate,
        ..Sampling::PAPER
    };
    let mut shadows: Vec<_> = lights.iter().map(|_| None).collect();
    for (tile, (light, lattice)) in volumes.with_voxels().enumerate() {
        shadows[light] = Some(volumes.grid().volume(tile, lattice, sampling)?);
    }
    let (mut squares, mut places) = (0.0, 0_u32);
    for (ray, hit) in scene.rays.iter().zip(scene.hits) {
        let Some(hit) = hit else { continue };
        let place = ray.at(hit.distance);
        let mut difference = 0.0;
        for (emitter, shadow) in lights.iter().zip(&shadows) {
            let Emitter::Point(lamp) = emitter else {
                continue;
            };
            let way = place - lamp.position();
            let distance = way.length();
            let is_dark = (scene.tracer).occluded(
                lamp.position(),
                way / distance,
                0.0,
                distance * (1.0 - 1e-4),
            );
            let found = shadow.as_ref().map_or(1.0, |s| s.visibility(place));
            difference += f64::from(found) - f64::from(u8::from(!is_dark));
        }
        squares += (difference / lights.len() as f64).powi(2);
        places += 1;
    }
    Ok((squares / f64::from(places.max(1))).sqrt())
}
