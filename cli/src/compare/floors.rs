//! What no method can pass on shadow maps of a resolution.

use std::time::Instant;

use gpu_backend::Cpu;
use lighting::methods::epipolar::MapRuns;
use lighting::methods::{Frame, FrameInputs, MethodError};
use lighting::{Gather, LitRays, airlight::Quadrature};
use reference::metrics::{Reference, image_error};

use super::budget::Budget;
use super::measure::Job;
use super::results::MapFloor;
use crate::progress;

/// Tolerance of the light of a lit run, far below what maps of any size reach.
const TOLERANCE: f32 = 1e-5;

/// The errors of the exact lit runs of the shadow maps of each resolution, as long as
/// there is time.
///
/// The runs are those that the map's texels show and their light is known to a
/// tolerance, so nothing but the map's resolution is in the error: no steps and no
/// nodes.
pub(crate) fn floors(
    job: &Job<'_>,
    truth: &Reference,
    maps: &[u32],
    budget: Budget,
) -> Result<Vec<MapFloor>, MethodError> {
    let bar = progress::bar("shadow maps by themselves", maps.len() as u64);
    let mut all: Vec<MapFloor> = Vec::new();
    for &map in maps {
        let last = all.last().map_or(0.0, |floor| floor.seconds);
        if budget.left() <= 2.0 * last {
            break;
        }
        let clock = Instant::now();
        let rmse = floor(job, truth, map)?;
        all.push(MapFloor {
            map,
            rmse,
            seconds: clock.elapsed().as_secs_f64(),
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

fn floor(job: &Job<'_>, truth: &Reference, map: u32) -> Result<f64, MethodError> {
    let inputs = FrameInputs {
        map,
        ..job.inputs(&())
    };
    let cpu = Cpu::new();
    let frame = Frame::new(&cpu, inputs, &job.input.host)?;
    let evaluator = Quadrature::with_tolerance(job.medium.phase(), TOLERANCE)
        .map_err(MethodError::resource("a quadrature"))?;
    let rays = job.view.rays();
    let mut radiance = vec![[0.0_f32; 4]; rays.len()];
    for (light, emitter) in job.emitters.iter().enumerate() {
        let map = frame.shadow_map(light)?;
        let runs = MapRuns::new(&cpu, map, rays, emitter, job.medium)?;
        let lit = LitRays::new(&frame.rays, emitter, job.medium);
        cpu.gather(&lit, &runs, &evaluator, &mut radiance)?;
    }
    Ok(image_error(&radiance, truth).rmse)
}
