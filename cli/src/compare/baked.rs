//! The shadows that the candidates need, baked before anything is measured.

use std::time::Instant;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{BakedShadow, Builder, Resolution};
use lighting::scene::Geometry;

use super::budget::Budget;
use super::selection::Candidate;
use crate::failure::Failure;
use crate::methods::Visibility;
use crate::progress;

/// Share of the time left that baking may take, at all resolutions together.
const SHARE: f64 = 0.1;

/// What a doubling of the resolution makes of the time, where it is not known
/// yet.
const GROWTH: f64 = 3.0;

/// The shadows of all lights at one resolution.
#[derive(Debug)]
pub(crate) struct Baked {
    pub(crate) resolution: u32,
    /// One per emitter.
    pub(crate) shadows: Vec<BakedShadow>,
    pub(crate) seconds: f64,
}

impl Baked {
    pub(crate) fn bytes(&self) -> u64 {
        self.shadows.iter().map(BakedShadow::bytes).sum()
    }
}

/// Bakes at the resolutions of the candidates, from the lowest up to the one
/// for which there is no time.
pub(crate) fn bake_all(
    candidates: &[Candidate],
    geometry: &Geometry,
    emitters: &[Emitter],
    budget: Budget,
) -> Result<Vec<Baked>, Failure> {
    let settings = candidates.iter().map(Candidate::setting);
    let baked = settings.filter(|setting| setting.visibility == Visibility::Dag);
    let mut resolutions: Vec<u32> = baked.map(|setting| setting.samples).collect();
    resolutions.sort_unstable();
    resolutions.dedup();
    let cpu = Cpu::new();
    let bar = progress::bar("baking", (resolutions.len() * emitters.len()) as u64);
    let allowed = SHARE * budget.left();
    let clock = Instant::now();
    let mut all: Vec<Baked> = Vec::new();
    for resolution in resolutions {
        let left = allowed - clock.elapsed().as_secs_f64();
        let doublings = |last: &Baked| f64::from(resolution / last.resolution).log2();
        let expected = all
            .last()
            .map_or(0.0, |last| last.seconds * GROWTH.powf(doublings(last)));
        if expected > left {
            break;
        }
        let start = Instant::now();
        let mut shadows = Vec::with_capacity(emitters.len());
        for emitter in emitters {
            // The first of many lights tells when all will be done.
            let so_far = start.elapsed().as_secs_f64();
            let each = so_far / shadows.len().max(1) as f64;
            if each * emitters.len() as f64 > left {
                break;
            }
            let side = Resolution::new(resolution)?;
            let (shadow, _) = BakedShadow::bake(&cpu, geometry, emitter, side, Builder::new())?;
            shadows.push(shadow);
            bar.inc(1);
        }
        if shadows.len() < emitters.len() {
            break;
        }
        all.push(Baked {
            resolution,
            shadows,
            seconds: start.elapsed().as_secs_f64(),
        });
    }
    bar.finish_and_clear();
    Ok(all)
}
