//! The backends that a comparison runs on.

use gpu_backend::Cpu;
use gpu_backend::gpu::{Gpu, Queued};
use lighting::methods::Entry;

use super::results::LeftOut;
use super::selection::Candidate;
use crate::args::Compare;
use crate::devices::{self, Device};
use crate::failure::Failure;
use crate::print::complain;

/// Why a method is left out on a GPU.
const NO_SHADER: &str = "it has no shader";

impl Device {
    /// True if the method runs on it.
    pub(crate) fn runs(&self, entry: &Entry) -> bool {
        match self.context {
            None => entry.on::<Cpu>().is_some(),
            Some(_) => entry.on::<Gpu<Queued>>().is_some(),
        }
    }

    /// What to say where it failed and others can go on without it.
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
    pub(crate) fn find(args: &Compare) -> Result<Self, Failure> {
        let (present, missing) = devices::find(&args.backend)?;
        Ok(Self {
            present,
            left_out: missing.iter().map(|why| skipped("gpu", why)).collect(),
        })
    }

    /// Labels of those that run a method.
    pub(crate) fn running(&self, entry: &Entry) -> Vec<&str> {
        let all = self.present.iter().filter(|device| device.runs(entry));
        all.map(|device| device.label.as_str()).collect()
    }

    /// What some of them cannot run of what is selected.
    pub(crate) fn gaps(&self, candidates: &[Candidate]) -> Vec<LeftOut> {
        let mut gaps: Vec<LeftOut> = Vec::new();
        for device in &self.present {
            for candidate in candidates.iter().filter(|c| !device.runs(&c.entry)) {
                let gap = LeftOut {
                    what: format!("{} on {}", candidate.entry.about().title, device.label),
                    why: NO_SHADER.into(),
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
