//! The backends that a comparison runs on.

use gpu_backend::Cpu;
use gpu_backend::gpu::{Context, Gpu, Queued};

use super::results::LeftOut;
use super::selection::Candidate;
use crate::args::{BackendName, Compare};
use crate::engine::{EXACT_IS_TRACED, Tracing};
use crate::failure::Failure;
use crate::methods::Method;
use crate::print::complain;

/// Turns a missing GPU into a failure if it is `1`.
const REQUIRE_VARIABLE: &str = "REQUIRE_GPU";

/// A backend that is there.
#[derive(Debug)]
pub(crate) struct Present {
    /// Its name in reports.
    pub(crate) label: String,
    /// False on a software adapter: its times say nothing about a GPU.
    pub(crate) representative: bool,
    /// True if its failure must not go unnoticed.
    required: bool,
    /// `None` is the CPU.
    context: Option<Context>,
}

impl Present {
    fn cpu() -> Self {
        Self {
            label: "cpu".into(),
            representative: true,
            required: true,
            context: None,
        }
    }

    fn gpu(context: Context, required: bool) -> Self {
        let software = context.is_software();
        let kind = if software { ", software" } else { "" };
        Self {
            label: format!("gpu ({}{kind})", context.adapter().name),
            representative: !software,
            required,
            context: Some(context),
        }
    }

    /// True if it has what `method` needs.
    pub(crate) fn runs(&self, method: &Method) -> bool {
        let traces = match self.context {
            None => Cpu::TRACES,
            Some(_) => Gpu::<Queued>::TRACES,
        };
        traces || !method.visibility.is_traced()
    }

    /// What a GPU is reached by; `None` is the CPU.
    pub(crate) fn context(&self) -> Option<&Context> {
        self.context.as_ref()
    }

    /// What to say where it failed and others can go on without it.
    pub(crate) fn excuse(&self, failure: Failure) -> Result<LeftOut, Failure> {
        if self.required {
            return Err(failure.about(&self.label));
        }
        Ok(skipped(&self.label, &failure.to_string()))
    }
}

/// All backends that are asked for and present, the CPU first.
#[derive(Debug)]
pub(crate) struct Backends {
    pub(crate) present: Vec<Present>,
    pub(crate) left_out: Vec<LeftOut>,
}

impl Backends {
    /// Finds those asked for, or all there are.
    pub(crate) fn find(args: &Compare) -> Result<Self, Failure> {
        let asked = |name| args.backend.contains(&name);
        let any = args.backend.is_empty();
        let mut backends = Self {
            present: Vec::new(),
            left_out: Vec::new(),
        };
        if any || asked(BackendName::Cpu) {
            backends.present.push(Present::cpu());
        }
        if any || asked(BackendName::Gpu) {
            let required = !any || std::env::var(REQUIRE_VARIABLE).is_ok_and(|value| value == "1");
            match Context::request() {
                Ok(context) => backends.present.push(Present::gpu(context, required)),
                Err(error) if required => return Err(error.into()),
                Err(error) => backends.left_out.push(skipped("gpu", &error.to_string())),
            }
        }
        Ok(backends)
    }

    /// Labels of those that run `method`.
    pub(crate) fn running(&self, method: &Method) -> Vec<&str> {
        let all = self.present.iter().filter(|backend| backend.runs(method));
        all.map(|backend| backend.label.as_str()).collect()
    }

    /// What some of them cannot run of what is selected.
    pub(crate) fn gaps(&self, candidates: &[Candidate]) -> Vec<LeftOut> {
        let mut gaps = Vec::new();
        for backend in &self.present {
            let gap = candidates.iter().find(|c| !backend.runs(c.method));
            gaps.extend(gap.map(|candidate| LeftOut {
                what: format!("{} on {}", candidate.method.title, backend.label),
                why: EXACT_IS_TRACED.into(),
            }));
        }
        gaps
    }
}

/// Says on standard error, too, that a backend is missing from the report.
fn skipped(label: &str, reason: &str) -> LeftOut {
    complain(&format!("{label}: skipped, {reason}"));
    LeftOut {
        what: label.into(),
        why: format!("skipped, {reason}"),
    }
}
