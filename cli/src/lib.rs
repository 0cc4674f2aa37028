//! Internal: not published. The `crepuscular` program as a library: everything but the
//! list of methods, which is a value. A program with a method of its own is
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

mod added;
mod args;
mod bake;
mod checkpoint;
mod compare;
mod devices;
mod failure;
mod file;
mod format;
mod hair;
mod indirect;
mod input;
mod inspect;
mod interrupt;
mod list;
mod manual;
mod maps;
mod merge;
mod output;
mod parse;
mod picture;
mod plan;
mod print;
mod progress;
mod render;
mod report;
mod scene_options;
mod shadow_files;
mod stress;
mod suggest;
mod surfaces;

use std::error::Error;
use std::ffi::OsString;
use std::process::ExitCode;

use lighting::methods::Registry;

use args::{Arguments, Command};
use failure::{Failure, USER_ERROR};

/// Runs the program with the arguments of the process.
pub fn main(methods: &Registry) -> ExitCode {
    run(methods, std::env::args_os())
}

/// Runs the program with these arguments, the first of which is its name.
pub fn run(methods: &Registry, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = arguments.into_iter().collect();
    let arguments = match Arguments::read(methods, words.iter().cloned()) {
        Ok(arguments) => arguments,
        Err(error) => {
            let code = error.exit_code().try_into().unwrap_or(USER_ERROR);
            let printed = print::written(error.print());
            return match (code, printed) {
                (0, Err(failure)) => complain(&failure),
                _ => ExitCode::from(code),
            };
        }
    };
    print::set_quiet(arguments.quiet);
    let reports_what_there_is =
        matches!(arguments.command, Command::Compare(_) | Command::Stress(_));
    let ready = interrupt::listen().and_then(|()| start_threads());
    let done = ready.and_then(|()| match arguments.command {
        Command::Plan(args) => plan::run(methods, &args),
        Command::Compare(args) => compare::run(methods, &args, &words),
        Command::Render(args) => render::run(methods, &args),
        Command::Bake(args) => bake::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Methods(args) => list::methods(methods, &args),
        Command::Scenes(args) => list::scenes(&args),
        Command::Stress(args) => stress::run(methods, &args),
        Command::Completions(args) => manual::completions(Arguments::command(methods), &args),
        Command::Man(args) => manual::man(Arguments::command(methods), &args),
    });
    match (done, interrupt::exit_code()) {
        (Err(failure), code) => {
            let complained = complain(&failure);
            code.map_or(complained, ExitCode::from)
        }
        // The finished part of an interrupted comparison, or of the hard cases, is reported.
        (Ok(()), Some(code)) if reports_what_there_is => ExitCode::from(code),
        (Ok(()), _) => ExitCode::SUCCESS,
    }
}

/// Starts the threads that share the work. Started by the first of it they would panic where
/// there is no memory for them.
fn start_threads() -> Result<(), Failure> {
    match rayon::ThreadPoolBuilder::new().build_global() {
        // Without a cause it says that they run already.
        Err(error) if error.source().is_some() => Err(Failure::new(format!(
            "the threads that share the work do not start: {error}"
        ))),
        _ => Ok(()),
    }
}

fn complain(failure: &Failure) -> ExitCode {
    print::complain(&format!("error: {failure}"));
    ExitCode::from(failure.code())
}
