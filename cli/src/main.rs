//! The `crepuscular` program: measures and renders light and shadow in fog.

use std::process::ExitCode;

use lighting::methods::Registry;

fn main() -> ExitCode {
    crepuscular_cli::main(&Registry::standard())
}
