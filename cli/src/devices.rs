//! The backends that are present.

use std::time::Instant;

use clap::ValueEnum;
use gpu_backend::gpu::Context;

use crate::failure::Failure;
use crate::print::complain;

/// Turns a missing GPU into a failure if it is `1`.
const REQUIRE_VARIABLE: &str = "REQUIRE_GPU";

/// Backends by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackendName {
    /// The CPU, with all threads
    Cpu,
    /// The GPU, through Vulkan, Metal or Direct3D 12
    Gpu,
}

/// Where one picture is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PictureBackend {
    /// The CPU, with all threads
    Cpu,
    /// The GPU, through Vulkan, Metal or Direct3D 12
    Gpu,
    /// Whichever is expected to have the picture first. The time that a GPU takes to start
    /// counts, and one that would take too long is not started; `plan --calibrate` measures it
    Auto,
}

impl PictureBackend {
    /// The backend, if it is named.
    pub(crate) fn name(self) -> Option<BackendName> {
        match self {
            Self::Cpu => Some(BackendName::Cpu),
            Self::Gpu => Some(BackendName::Gpu),
            Self::Auto => None,
        }
    }
}

/// The only backend of that name.
pub(crate) fn find_one(name: BackendName) -> Result<Device, Failure> {
    let (mut found, _) = find(&[name])?;
    // One that was asked for is present, or an error.
    Ok(found.remove(0))
}

/// A backend that is present.
#[derive(Debug)]
pub(crate) struct Device {
    /// Its name in reports.
    pub(crate) label: String,
    /// False on a software adapter: its times say nothing about a GPU.
    pub(crate) representative: bool,
    /// True if its failure must not go unnoticed.
    pub(crate) required: bool,
    /// Seconds until it was ready, if it had to be started.
    pub(crate) start: Option<f64>,
    /// `None` is the CPU.
    pub(crate) context: Option<Context>,
}

impl Device {
    fn cpu() -> Self {
        Self {
            label: "cpu".into(),
            representative: true,
            required: true,
            start: None,
            context: None,
        }
    }

    fn gpu(context: Context, required: bool, start: f64) -> Self {
        let software = context.is_software();
        let kind = if software { ", software" } else { "" };
        Self {
            label: format!("gpu ({}{kind})", context.adapter().name),
            representative: !software,
            required,
            start: Some(start),
            context: Some(context),
        }
    }
}

/// The backends that are present among those in `asked`, or among all if it is empty, the CPU
/// first. If the GPU is missing and was not asked for, also the reason.
pub(crate) fn find(asked: &[BackendName]) -> Result<(Vec<Device>, Option<String>), Failure> {
    let any = asked.is_empty();
    let mut present = Vec::new();
    let mut missing = None;
    if any || asked.contains(&BackendName::Cpu) {
        present.push(Device::cpu());
    }
    if any || asked.contains(&BackendName::Gpu) {
        let required = !any || std::env::var(REQUIRE_VARIABLE).is_ok_and(|value| value == "1");
        let clock = Instant::now();
        let requested = without_chatter(Context::request);
        let start = clock.elapsed().as_secs_f64();
        match requested {
            Ok(context) => present.push(Device::gpu(context, required, start)),
            Err(error) if required => return Err(error.into()),
            Err(error) => {
                complain(&format!("gpu: skipped, {error}"));
                missing = Some(error.to_string());
            }
        }
    }
    Ok((present, missing))
}

/// Does something while drivers cannot write to standard error, where some complain about
/// their environment.
#[cfg(unix)]
fn without_chatter<T>(work: impl FnOnce() -> T) -> T {
    use rustix::stdio::{dup2_stderr, stderr};

    let silent = std::fs::File::options().write(true).open("/dev/null");
    let saved = rustix::io::fcntl_dupfd_cloexec(stderr(), 3);
    let (Ok(silent), Ok(saved)) = (silent, saved) else {
        return work();
    };
    let is_silent = dup2_stderr(silent).is_ok();
    let result = work();
    if is_silent {
        // If this fails nothing more can be said anyway.
        let _ = dup2_stderr(saved);
    }
    result
}

#[cfg(not(unix))]
fn without_chatter<T>(work: impl FnOnce() -> T) -> T {
    work()
}
