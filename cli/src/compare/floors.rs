//! The error of shadow maps by themselves, at which methods that sample them level out.

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

/// About how many rays of all lights are looked at for one resolution: in a larger picture the
/// error is that of some of its rays.
const MOST_RAYS: usize = 300_000;

/// About how long the trees of a map take for each texel of a side squared, on one of two
/// cores.
const SECONDS_PER_TEXEL: f64 = 2e-8;

/// Tolerance of the light of a lit run, far below the errors of maps of any size.
const TOLERANCE: f32 = 1e-5;

/// The errors of the exact lit runs of the shadow maps of each resolution, as long as
/// there is time.
///
/// The runs are all that a map shows, so the error comes from its resolution alone, and not
/// from steps or nodes. Where something lets a part of the light through, methods use maps of
/// another kind, which know more, and there is no such error.
pub(crate) fn floors(
    job: &Job<'_>,
    truth: &Reference,
    maps: &[u32],
    budget: Budget,
) -> Result<Vec<MapFloor>, MethodError> {
    let lets_through = job.input.geometry.coatings().any_see_through();
    if lets_through || job.sees_media || !job.input.scene.translucent.is_empty() {
        return Ok(Vec::new());
    }
    let bar = progress::bar("shadow maps by themselves", maps.len() as u64);
    let mut all: Vec<MapFloor> = Vec::new();
    let mut last = 0.0_f64;
    for &map in maps {
        let texels = job.emitters.len() as f64 * f64::from(map).powi(2);
        if budget.left() <= (2.0 * last).max(SECONDS_PER_TEXEL * texels) {
            break;
        }
        let clock = Instant::now();
        let rmse = floor(job, truth, map)?;
        all.push(MapFloor { map, rmse });
        last = clock.elapsed().as_secs_f64();
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

fn floor(job: &Job<'_>, truth: &Reference, map: u32) -> Result<f64, MethodError> {
    let rays = job.view.rays();
    let step = match (rays.len() * job.emitters.len()).div_ceil(MOST_RAYS) {
        0 | 1 => 1,
        // An odd step does not run along the columns of usual widths.
        step => step | 1,
    };
    let some: Vec<_> = rays.iter().step_by(step).copied().collect();
    let hits: Vec<_> = job.view.hits().iter().step_by(step).copied().collect();
    let inputs = FrameInputs {
        rays: &some,
        hits: &hits,
        map,
        ..job.inputs(&())
    };
    let cpu = Cpu::new();
    let frame = Frame::new(&cpu, inputs, &job.input.host)?;
    let evaluator = Quadrature::with_tolerance(job.medium.phase(), TOLERANCE)
        .map_err(MethodError::resource("a quadrature"))?;
    let mut radiance = vec![[0.0_f32; 4]; some.len()];
    for (light, emitter) in job.emitters.iter().enumerate() {
        let map = frame.shadow_map(light)?;
        let runs = MapRuns::new(&cpu, map, &some, emitter, job.medium)?;
        let lit = LitRays::new(&frame.rays, emitter, job.medium);
        cpu.gather(&lit, &runs, &evaluator, &mut radiance)?;
    }
    let part = Reference {
        radiance: truth.radiance.iter().step_by(step).copied().collect(),
        bound: truth.bound.iter().step_by(step).copied().collect(),
    };
    let error = image_error(&radiance, &part);
    // All errors are divided by the mean of the whole picture.
    let whole = truth.mean();
    Ok(match whole > 0.0 && !error.absolute {
        true => error.rmse * error.mean / whole,
        false => error.rmse,
    })
}
