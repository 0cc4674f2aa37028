//! Precomputed shadows of a picture's lights, from files.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use gpu_backend::Cpu;
use lighting::methods::{Entry, Registry};
use lighting::precomputed::{BakedShadow, Form, ShadowSet, light_spaces};

use crate::failure::Failure;
use crate::file;
use crate::input::Input;

/// The shadows of one light.
pub(crate) type Shadow = Arc<BakedShadow>;

/// The shadows of each emitter, where a file has them.
pub(crate) type Shadows = Vec<Option<Shadow>>;

/// The shadows of each emitter, where a file has them, as plain nodes.
pub(crate) fn read(files: &[PathBuf], input: &Input) -> Result<Shadows, Failure> {
    let mut shadows = vec![None; input.emitters.len()];
    let mut spaces = BTreeMap::new();
    // Dynamic casters are in no file.
    let casters = match files {
        [] => &input.geometry,
        _ => input.casters_that_stay()?,
    };
    for path in files {
        let name = path.display().to_string();
        let about = |failure: Failure| failure.about(&name);
        let file = file::read(path).map_err(|error| about(error.into()))?;
        let set = ShadowSet::read(&file).map_err(|error| about(error.into()))?;
        let lights = BakedShadow::of_set(&set).map_err(|error| about(error.into()))?;
        let mut found = false;
        for baked in &lights {
            let resolution = baked.grids()[0].resolution();
            // The shadows of all emitters at a resolution are asked for again and again.
            let spaces = spaces.entry(resolution).or_insert_with(|| {
                Cpu::new().map(input.emitters.len(), |light| {
                    light_spaces(casters, &input.emitters[light], resolution).ok()
                })
            });
            for (spaces, shadow) in spaces.iter().zip(&mut shadows) {
                if spaces.as_ref().is_some_and(|spaces| baked.fits(spaces)) {
                    *shadow = Some(Arc::new(baked.to_form(Form::Plain)?));
                    found = true;
                }
            }
        }
        if !found {
            return Err(Failure::new(format!(
                "{name} was baked for another scene or light: it fits none of the lights of this scene"
            )));
        }
    }
    Ok(shadows)
}

/// The method of lights whose shadows are in files, with the evaluator `airlight`.
pub(crate) fn method(methods: &Registry, airlight: &str) -> Result<Entry, Failure> {
    methods
        .pair(lighting::methods::PRECOMPUTED, airlight, None)
        .filter(|entry| entry.halves().is_some())
        .ok_or_else(|| {
            Failure::new(format!(
                "{airlight} cannot be combined with precomputed shadows"
            ))
        })
}
