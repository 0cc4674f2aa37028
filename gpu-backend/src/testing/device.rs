//! The device on which the tests of a process run.

use std::io::Write;
use std::sync::OnceLock;

use crate::Error;
use crate::gpu::{Context, Gpu, Queued};

static CONTEXT: OnceLock<Result<Context, Error>> = OnceLock::new();

/// A handle of its own on the one device that all tests of a process share.
///
/// Without an adapter this prints `SKIPPED` with the name of the test and the
/// reason, past the capture of the test runner, and returns `None`.
///
/// # Panics
/// If there is no adapter and the environment variable `REQUIRE_GPU` is `1`: a
/// machine that is meant to run the tests must not skip them.
pub fn gpu() -> Option<Gpu<Queued>> {
    match CONTEXT.get_or_init(Context::request) {
        Ok(context) => Some(Gpu::new(context.clone())),
        Err(error) => {
            let required = std::env::var("REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "REQUIRE_GPU is 1, but {error}");
            let thread = std::thread::current();
            let test = thread.name().unwrap_or("a test");
            // A closed stderr is no reason to fail.
            writeln!(std::io::stderr(), "SKIPPED {test}: {error}").ok();
            None
        }
    }
}
