//! Precomputed voxelized shadows for a picture: from files, or baked for it.

use std::path::PathBuf;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{BakedShadow, Builder, Form, Resolution, ShadowSet, light_spaces};

use crate::engine::Held;
use crate::failure::Failure;
use crate::input::Input;
use crate::progress;

/// The shadows of each emitter, where a file has them, as plain nodes.
pub(crate) fn read(files: &[PathBuf], input: &Input) -> Result<Vec<Option<BakedShadow>>, Failure> {
    let mut shadows = vec![None; input.emitters.len()];
    for path in files {
        let name = path.display().to_string();
        let about = |failure: Failure| failure.about(&name);
        let file = std::fs::read(path).map_err(|error| about(error.into()))?;
        let set = ShadowSet::from_bytes(&file).map_err(|error| about(error.into()))?;
        let lights = BakedShadow::of_set(&set).map_err(|error| about(error.into()))?;
        let mut found = false;
        for baked in &lights {
            let resolution = baked.grids()[0].resolution();
            for (emitter, shadow) in input.emitters.iter().zip(&mut shadows) {
                let spaces = light_spaces(&input.geometry, emitter, resolution);
                if spaces.is_ok_and(|spaces| baked.fits(&spaces)) {
                    *shadow = Some(baked.to_form(Form::Plain)?);
                    found = true;
                }
            }
        }
        if !found {
            return Err(Failure::new(format!(
                "{name} was baked for another scene or light: none of the scene's sees it that way"
            )));
        }
    }
    Ok(shadows)
}

/// The shadows of lights without a file.
pub(crate) fn bake(
    input: &Input,
    emitters: &[Emitter],
    side: u32,
) -> Result<Vec<Held<Cpu>>, Failure> {
    let resolution =
        Resolution::new(side).map_err(|error| Failure::from(error).about("--samples"))?;
    let cpu = Cpu::new();
    let bar = progress::bar("baking", emitters.len() as u64);
    let mut shadows = Vec::with_capacity(emitters.len());
    for emitter in emitters {
        let builder = Builder::new();
        let (shadow, _) = BakedShadow::bake(&cpu, &input.geometry, emitter, resolution, builder)?;
        shadows.push(shadow);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(vec![Held {
        resolution: side,
        shadows,
    }])
}
