//! The backends that a comparison runs on.

use gpu_backend::Cpu;
use gpu_backend::gpu::{Gpu, Queued};

use super::results::LeftOut;
use super::selection::Candidate;
use crate::devices::{self, BackendName, Device};
use crate::failure::Failure;
use crate::print::complain;

impl Device {
    /// Why a candidate does not run on it, if it does not.
    pub(crate) fn why_not(&self, candidate: &Candidate) -> Option<&'static str> {
        let entry = &candidate.entry;
        let has_it = match self.context {
            None => entry.on::<Cpu>().is_some(),
            Some(_) => entry.on::<Gpu<Queued>>().is_some(),
        };
        if !has_it {
            return Some("it has no shader");
        }
        let is_known = candidate.refines_map && !self.representative;
        is_known.then_some("its errors are those of the CPU, and its times do not represent a GPU")
    }

    /// The message if it failed and others can go on without it.
    pub(crate) fn excuse(&self, failure: Failure) -> Result<LeftOut, Failure> {
        if self.required {
            return Err(failure.about(&self.label));
        }
        complain(&format!("{}: skipped, {failure}", self.label));
        Ok(skipped(&self.label, &failure.to_string()))
    }
}

/// All backends that are asked for and present, the CPU first.
#[derive(Debug)]
pub(crate) struct Backends {
    pub(crate) present: Vec<Device>,
    pub(crate) left_out: Vec<LeftOut>,
}

impl Backends {
    /// Finds those asked for, or all there are.
    pub(crate) fn find(asked: &[BackendName]) -> Result<Self, Failure> {
        let (present, missing) = devices::find(asked)?;
        Ok(Self {
            present,
            left_out: missing.iter().map(|why| skipped("gpu", why)).collect(),
        })
    }

    /// Labels of those that run a candidate.
    pub(crate) fn running(&self, candidate: &Candidate) -> Vec<&str> {
        let all = self.present.iter();
        let all = all.filter(|device| device.why_not(candidate).is_none());
        all.map(|device| device.label.as_str()).collect()
    }

    /// The reason why no candidate runs on any backend, if so.
    pub(crate) fn run_nothing(&self, candidates: &[Candidate]) -> Option<LeftOut> {
        let runs = |candidate: &Candidate| !self.running(candidate).is_empty();
        match candidates.iter().any(runs) {
            true => None,
            false => self.gaps(candidates).into_iter().next(),
        }
    }

    /// The candidates that some of the backends cannot run.
    pub(crate) fn gaps(&self, candidates: &[Candidate]) -> Vec<LeftOut> {
        let mut gaps: Vec<LeftOut> = Vec::new();
        for device in &self.present {
            for candidate in candidates {
                let Some(why) = device.why_not(candidate) else {
                    continue;
                };
                let gap = LeftOut {
                    what: format!("{} on {}", candidate.title, device.label),
                    why: why.into(),
                };
                if !gaps.contains(&gap) {
                    gaps.push(gap);
                }
            }
        }
        gaps
    }
}

fn skipped(label: &str, reason: &str) -> LeftOut {
    LeftOut {
        what: label.into(),
        why: format!("skipped, {reason}"),
    }
}
