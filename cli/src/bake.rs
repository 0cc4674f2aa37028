//! Baking the shadows of one light into a file.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{self, Builder, Form, Resolution, Watertightness};
use lighting::scene::Light;
use lighting::scene::load::printable;
use shadow_dag::SetBake;

use crate::args::{Bake, MediumOptions, NodeForm, SceneOptions};
use crate::checkpoint;
use crate::failure::Failure;
use crate::format::{bytes, count, seconds, significant};
use crate::input::Input;
use crate::output::PendingFile;
use crate::print::note;
use crate::{interrupt, progress, suggest};

/// Time between two checkpoints, at least.
const PAUSE: Duration = Duration::from_secs(10);

/// Runs `crepuscular bake`.
pub(crate) fn run(args: &Bake) -> Result<(), Failure> {
    let resolution = Resolution::new(args.resolution)
        .map_err(|error| Failure::from(error).about("--resolution"))?;
    // An interruption is heard from the time on at which the file is begun.
    let stop = interrupt::flag()?;
    let file = PendingFile::beside(&args.output, &[Path::new(&args.scene)])?;
    let clock = Instant::now();
    let mut input = Input::load(&args.scene, &scene_options(args))?;
    let emitter = emitter(&input.scene.lights, args.light.as_deref())?;
    let part = file.is_regular().then(|| checkpoint::path(&args.output));
    let saved = match &part {
        Some(part) if args.resume => checkpoint::read(part)?,
        _ => None,
    };
    if args.resume && saved.is_none() {
        let missing = part
            .as_ref()
            .map_or("nothing".into(), |part| format!("no {}", part.display()));
        input
            .notes
            .push(format!("there is {missing} to go on from"));
    }

    if !input.scene.translucent.is_empty() {
        let note = "hair and smoke are left out: a grid knows lit and shadowed only";
        input.notes.push(note.into());
    }

    let spinner = progress::spinner("sorting triangles");
    let emitters = std::slice::from_ref(&emitter);
    let mut bake = precomputed::bake(&input.geometry, emitters, resolution, Builder::new())?;
    if let (Some(saved), Some(part)) = (saved, &part) {
        let resumed = bake.resume(&saved);
        resumed.map_err(|error| Failure::from(error).about(&part.display().to_string()))?;
    }
    let watertightness = bake.watertightness();
    let (_, grids) = bake.grid();
    spinner.finish_and_clear();
    run_bake(&mut bake, &stop, part.as_deref())?;
    let spinner = progress::spinner("putting tiles together");
    let set = bake.finish()?;
    let content = match args.form {
        NodeForm::Plain => set.to_form(Form::Plain)?.to_bytes(),
        NodeForm::Packed => set.to_form(Form::Packed)?.to_bytes(),
        NodeForm::Compressed => set.compress(),
    };
    let written = file.finish(&content)?;
    if let Some(part) = &part {
        checkpoint::remove(part)?;
    }
    spinner.finish_and_clear();
    input.notes.extend(describe_watertightness(watertightness));
    note(&input.notes);
    let maps = 2.0 * f64::from(args.resolution).powi(2) * grids as f64;
    written.summarise(&format!(
        "{}: {} of {}³ voxels in {}, 1/{} of 16-bit shadow maps; {}",
        args.output.display(),
        count(grids, "grid"),
        args.resolution,
        bytes(content.len() as u64),
        significant(maps / content.len() as f64),
        seconds(clock.elapsed().as_secs_f64())
    ))
}

/// The scene without anything that a bake does not ask for.
fn scene_options(args: &Bake) -> SceneOptions {
    SceneOptions {
        seed: args.seed,
        lights: 1,
        no_shadow: args.no_shadow.clone(),
        map: None,
        surroundings: args.surroundings,
        medium: MediumOptions::default(),
        file: args.file.clone(),
    }
}

/// The light that `name` stands for.
fn emitter(lights: &[Light], name: Option<&str>) -> Result<Emitter, Failure> {
    let list = || {
        let names = lights.iter().enumerate();
        let names: Vec<String> = names
            .take(12)
            .map(|(index, light)| match light.name() {
                "" => format!("{index} {}", light.kind()),
                name => format!("{index} {} \"{}\"", light.kind(), printable(name)),
            })
            .collect();
        let more = if lights.len() > names.len() {
            ", …"
        } else {
            ""
        };
        format!("the lights are {}{more}", names.join(", "))
    };
    let index = match (name, lights) {
        (None, [_]) => 0,
        (None, _) => {
            return Err(Failure::new(format!(
                "there are {}, choose one (--light): {}",
                count(lights.len(), "light"),
                list()
            )));
        }
        (Some(name), _) => {
            let is_meant = |light: &Light| {
                let is_sun = name == "sun" && light.kind() == "directional";
                is_sun || light.kind() == name || (!name.is_empty() && light.name() == name)
            };
            let matching = lights.iter().filter(|light| is_meant(light)).count();
            let found = match name.parse() {
                Ok(index) => Some(index).filter(|index| *index < lights.len()),
                Err(_) if matching == 1 => lights.iter().position(is_meant),
                Err(_) => None,
            };
            found.ok_or_else(|| {
                let why = match matching {
                    0 => {
                        let names = lights.iter().flat_map(|light| [light.kind(), light.name()]);
                        format!("there is no such light{}", suggest::question(name, names))
                    }
                    _ => format!("there are {matching} of them"),
                };
                Failure::new(format!("--light {name}: {why}; {}", list()))
            })?
        }
    };
    if matches!(lights[index], Light::Area(_)) {
        return Err(Failure::new(format!(
            "light {index} is an area light, whose shadows are soft; a grid holds those of a point"
        )));
    }
    // All others are one emitter.
    let mut emitters = lights[index].emitters(1)?;
    Ok(emitters.swap_remove(0))
}

/// What the bake says about the scene.
fn describe_watertightness(watertightness: Watertightness) -> Vec<String> {
    let mut notes = Vec::new();
    let Watertightness {
        parts,
        open_parts,
        inverted_parts,
        open_edges,
    } = watertightness;
    if open_parts > 0 {
        notes.push(format!(
            "{open_parts} of {} have holes ({}): baked as surfaces, which takes more time and space",
            count(parts, "part"),
            count(open_edges, "open edge")
        ));
    }
    if inverted_parts > 0 {
        notes.push(format!(
            "{inverted_parts} of {} are turned inside out, or cavities: baked as surfaces",
            count(parts, "part")
        ));
    }
    notes
}

/// Why a bake ended early.
enum Ended {
    Bake(shadow_dag::Error),
    Save(Failure),
}

impl From<shadow_dag::Error> for Ended {
    fn from(error: shadow_dag::Error) -> Self {
        Self::Bake(error)
    }
}

/// Makes all tiles of all grids, with checkpoints at `part`, if there is a place for
/// them.
fn run_bake(bake: &mut SetBake<'_>, stop: &AtomicBool, part: Option<&Path>) -> Result<(), Failure> {
    let what = match bake.grid() {
        (_, 1) => "shadows",
        _ => "shadows, of several grids",
    };
    let bar = progress::bar(what, bake.progress().tiles as u64);
    let ended = bake.run(
        &Cpu::new(),
        stop,
        PAUSE,
        |progress| bar.set_position(progress.finished as u64),
        |bake| match part {
            Some(part) => checkpoint::save(part, bake).map_err(Ended::Save),
            None => Ok(()),
        },
    );
    bar.finish_and_clear();
    ended.map_err(|ended| match ended {
        Ended::Bake(shadow_dag::Error::Cancelled { finished, tiles }) => {
            let begin = format!("interrupted after {finished} of {tiles} tiles");
            Failure::new(match part {
                Some(part) => format!("{begin}; --resume goes on from {}", part.display()),
                None => format!("{begin}, which are lost: the output is no regular file"),
            })
        }
        Ended::Bake(error) => error.into(),
        Ended::Save(failure) => failure,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_options::{FileOptions, Surroundings};

    #[test]
    fn an_interruption_after_the_last_tile_leaves_a_checkpoint() {
        let place = tempfile::tempdir().unwrap();
        let part = place.path().join("a.cpvs.part");
        let options = SceneOptions {
            seed: None,
            no_shadow: Vec::new(),
            lights: 1,
            map: None,
            surroundings: Surroundings::default(),
            medium: MediumOptions::default(),
            file: FileOptions::default(),
        };
        let input = Input::load("city", &options).unwrap();
        let resolution = Resolution::new(64).unwrap();
        let emitters = [emitter(&input.scene.lights, None).unwrap()];
        let begin =
            || precomputed::bake(&input.geometry, &emitters, resolution, Builder::new()).unwrap();
        let mut bake = begin();
        let (asked, never) = (AtomicBool::new(true), AtomicBool::new(false));
        bake.advance(&Cpu::new(), usize::MAX, &never, |_| {})
            .unwrap();
        assert!(bake.progress().is_complete());
        let error = run_bake(&mut bake, &asked, Some(&part))
            .unwrap_err()
            .to_string();
        assert!(error.contains("interrupted after"), "{error}");

        let saved = checkpoint::read(&part).unwrap().unwrap();
        let mut resumed = begin();
        resumed.resume(&saved).unwrap();
        run_bake(&mut resumed, &never, Some(&part)).unwrap();
        let expected = bake.finish().unwrap();
        assert!(resumed.finish().unwrap().to_bytes() == expected.to_bytes());
    }
}
