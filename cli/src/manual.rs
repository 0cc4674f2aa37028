//! The program's own description for shells and for `man`.

use clap::Command;

use crate::args::{Completions, Man};
use crate::failure::Failure;
use crate::print::print;
use crate::suggest;

/// Runs `crepuscular completions`; `program` is the whole command line.
pub(crate) fn completions(mut program: Command, args: &Completions) -> Result<(), Failure> {
    let name = program.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, name, &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Runs `crepuscular man`; `program` is the whole command line.
pub(crate) fn man(mut program: Command, args: &Man) -> Result<(), Failure> {
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => {
            let found = program.find_subcommand(name).cloned();
            let page = found.ok_or_else(|| {
                let names = program.get_subcommands().map(Command::get_name);
                Failure::new(format!(
                    "there is no command {name}{}",
                    suggest::question(name, names)
                ))
            })?;
            // Pages of commands are called `crepuscular-compare`.
            let title = format!("{}-{name}", program.get_name());
            page.display_name(title)
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text)?;
    print(&String::from_utf8_lossy(&text))
}
