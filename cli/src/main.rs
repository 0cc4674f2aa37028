//! The `crepuscular` program: measures and renders light and shadow in fog.

mod args;
mod bake;
mod baked;
mod checkpoint;
mod compare;
mod engine;
mod failure;
mod format;
mod input;
mod inspect;
mod interrupt;
mod list;
mod methods;
mod output;
mod parse;
mod picture;
mod print;
mod progress;
mod render;
mod report;
mod veils;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

/// What the program returns for anything that the user can set right; clap
/// returns the same for a wrong command line.
const USER_ERROR: u8 = 2;

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Compare(args) => compare::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Bake(args) => bake::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Methods => list::methods(),
        Command::Scenes(args) => list::scenes(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            print::complain(&format!("error: {failure}"));
            ExitCode::from(USER_ERROR)
        }
    }
}
