//! The device on which the tests of a process run.

use std::env;
use std::io::Write;
use std::sync::OnceLock;

use crate::Error;
use crate::gpu::{ADAPTER_VARIABLE, Context, Gpu, Queued};

static CONTEXT: OnceLock<Result<Context, Error>> = OnceLock::new();

/// Opens the device, with the limits that the environment asks for.
fn request() -> Result<Context, Error> {
    let Some(limits) = env::var_os("GPU_LIMITS") else {
        return Context::request();
    };
    assert_eq!(limits, "webgpu", "GPU_LIMITS may be webgpu");
    let name = env::var(ADAPTER_VARIABLE).unwrap_or_default();
    Context::request_named(&name, Some(wgpu::Limits::defaults()))
}

/// A handle of its own on the one device that all tests of a process share.
///
/// It has all that the adapter offers. If the environment variable `GPU_LIMITS` is `webgpu`, it
/// has WebGPU's default limits instead, which every browser guarantees.
///
/// Without an adapter this prints `SKIPPED` with the name of the test and the
/// reason, past the capture of the test runner, and returns `None`.
///
/// # Panics
/// If there is no adapter and the environment variable `REQUIRE_GPU` is `1`: a
/// machine that is meant to run the tests must not skip them. If `GPU_LIMITS` is anything but
/// `webgpu`.
pub fn gpu() -> Option<Gpu<Queued>> {
    match CONTEXT.get_or_init(request) {
        Ok(context) => Some(Gpu::new(context.clone())),
        Err(error) => {
            let required = env::var("REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "REQUIRE_GPU is 1, but {error}");
            let thread = std::thread::current();
            let test = thread.name().unwrap_or("a test");
            // A closed stderr is no reason to fail.
            writeln!(std::io::stderr(), "SKIPPED {test}: {error}").ok();
            None
        }
    }
}
