//! The `crepuscular` program as a library: everything but the list of methods,
//! which is a value. A program with a method of its own is
//!
//! ```no_run
//! use lighting::methods::Registry;
//!
//! fn main() -> std::process::ExitCode {
//!     // Registry::standard().with(MyMethod)
//!     crepuscular_cli::main(&Registry::standard())
//! }
//! ```
//!
//! and finds it in `compare`, `render` and `methods`.

mod args;
mod bake;
mod checkpoint;
mod compare;
mod devices;
mod failure;
mod format;
mod indirect;
mod input;
mod inspect;
mod interrupt;
mod list;
mod maps;
mod output;
mod parse;
mod picture;
mod print;
mod progress;
mod render;
mod report;
mod shadow_files;
mod surfaces;

use std::ffi::OsString;
use std::process::ExitCode;

use lighting::methods::Registry;

use args::{Arguments, Command};
use failure::USER_ERROR;

/// Runs the program with the arguments of the process.
pub fn main(methods: &Registry) -> ExitCode {
    run(methods, std::env::args_os())
}

/// Runs the program with these arguments, the first of which is its name.
pub fn run(methods: &Registry, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let command = match Arguments::read(methods, arguments.iter().cloned()) {
        Ok(arguments) => arguments.command,
        Err(error) => {
            // A closed pipe takes no message.
            let _ = error.print();
            return ExitCode::from(error.exit_code().try_into().unwrap_or(USER_ERROR));
        }
    };
    let done = match command {
        Command::Compare(args) => compare::run(methods, &args, &arguments),
        Command::Render(args) => render::run(methods, &args),
        Command::Bake(args) => bake::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Methods => list::methods(methods),
        Command::Scenes(args) => list::scenes(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            print::complain(&format!("error: {failure}"));
            ExitCode::from(failure.code())
        }
    }
}
