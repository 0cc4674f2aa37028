//! Joining the parts of a bake.

use std::path::Path;
use std::time::Instant;

use gpu_backend::Cpu;
use lighting::precomputed::ShadowSet;
use shadow_dag::MergeError;

use crate::args::Merge;
use crate::bake::{content, describe_size};
use crate::failure::Failure;
use crate::file;
use crate::format::{count, seconds};
use crate::output::PendingFile;

/// Runs `crepuscular merge`.
pub(crate) fn run(args: &Merge) -> Result<(), Failure> {
    let inputs: Vec<&Path> = args.parts.iter().map(AsRef::as_ref).collect();
    let file = PendingFile::beside(&args.output, &inputs)?;
    let clock = Instant::now();
    let name = |part: usize| args.parts[part].display().to_string();
    let read = (inputs.iter().enumerate()).map(|(part, path)| {
        file::read(path).map_err(|error| Failure::from(error).about(&name(part)))
    });
    let parts = read.collect::<Result<Vec<_>, _>>()?;
    let form = args.form.stored();
    let set = ShadowSet::merge(&Cpu::new(), &parts, form).map_err(|error| match error {
        MergeError::Part { given, error } => Failure::from(error).about(&name(given)),
        MergeError::Doubled {
            first,
            second,
            share,
        } => Failure::new(format!(
            "{} and {} are both part {share}",
            name(first),
            name(second)
        )),
        MergeError::Foreign { given, .. } => Failure::from(error).about(&name(given)),
        error => error.into(),
    })?;
    let content = content(&set, args.form)?;
    let written = file.finish(&content)?;
    written.summarise(&format!(
        "{}: {} of {} in {}; {}",
        args.output.display(),
        count(set.grids().count(), "grid"),
        count(set.lights().len(), "light"),
        describe_size(&set, &content),
        seconds(clock.elapsed().as_secs_f64())
    ))
}
