//! Baking the shadows of one light into a file.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gpu_backend::Cpu;
use indicatif::ProgressBar;
use lighting::Emitter;
use lighting::dag::{BakedShadow, Builder, Form, Resolution, Soundness, casters, light_spaces};
use lighting::scene::Light;
use shadow_dag::{LightSpace, ShadowDag};

use crate::args::{Bake, MediumOptions, NodeForm, SceneOptions};
use crate::checkpoint;
use crate::failure::Failure;
use crate::format::{bytes, count, seconds, significant};
use crate::input::Input;
use crate::output::PendingFile;
use crate::print::print;
use crate::{interrupt, progress};

/// Parts in which the tiles of a grid are made, with a look at the clock after
/// each.
const ROUNDS: usize = 64;

/// Time between two checkpoints, at least.
const PAUSE: Duration = Duration::from_secs(10);

/// Writing checkpoints may take this share of the time.
const SHARE: u32 = 20;

/// Runs `crepuscular bake`.
pub(crate) fn run(args: &Bake) -> Result<(), Failure> {
    let resolution = Resolution::new(args.resolution)
        .map_err(|error| Failure::from(error).about("--resolution"))?;
    let file = PendingFile::create(&args.output)?;
    let stop = interrupt::flag()?;
    let clock = Instant::now();
    let mut input = Input::load(&args.scene, &scene_options(args))?;
    let emitter = emitter(&input.scene.lights, args.light.as_deref())?;
    let spaces = light_spaces(&input.geometry, &emitter, resolution)?;
    let part = checkpoint::path(&args.output);
    let saved = match args.resume {
        true => checkpoint::read(&part)?,
        false => None,
    };
    if args.resume && saved.is_none() {
        let note = format!("there is no {} to go on from", part.display());
        input.notes.push(note);
    }

    if !input.scene.translucent.is_empty() {
        let note = "hair and smoke are left out: a grid knows lit and shadowed only";
        input.notes.push(note.into());
    }

    let mut work = Work {
        input: &input,
        spaces: &spaces,
        resolution,
        stop: &stop,
        part: &part,
        grids: Vec::new(),
        soundness: Soundness::default(),
    };
    let resumed = match &saved {
        Some(saved) => {
            let found = work.take_over(saved);
            Some(found.map_err(|failure| failure.about(&part.display().to_string()))?)
        }
        None => None,
    };
    work.bake(resumed)?;
    let Work {
        grids, soundness, ..
    } = work;
    let spinner = progress::spinner("writing");
    let form = match args.form {
        NodeForm::Plain => Form::Plain,
        NodeForm::Packed => Form::Packed,
    };
    let baked = BakedShadow::new(grids)?.to_form(form)?;
    let content = baked.to_bytes();
    file.finish(&content)?;
    checkpoint::remove(&part)?;
    spinner.finish_and_clear();
    let mut text = String::new();
    for note in &input.notes {
        text += &format!("note: {note}\n");
    }
    text += &describe_soundness(soundness);
    let maps = 2.0 * f64::from(args.resolution).powi(2) * spaces.len() as f64;
    text += &format!(
        "{}: {} of {}³ voxels in {}, 1/{} of 16-bit shadow maps; {}\n",
        args.output.display(),
        count(spaces.len(), "grid"),
        args.resolution,
        bytes(content.len() as u64),
        significant(maps / content.len() as f64),
        seconds(clock.elapsed().as_secs_f64())
    );
    print(&text)
}

/// The scene without anything that a bake does not ask for.
fn scene_options(args: &Bake) -> SceneOptions {
    SceneOptions {
        seed: args.seed,
        lights: 1,
        map: None,
        medium: MediumOptions::default(),
    }
}

/// The light that `name` stands for.
fn emitter(lights: &[Light], name: Option<&str>) -> Result<Emitter, Failure> {
    let list = || {
        let names = lights.iter().enumerate();
        let names: Vec<String> = names
            .take(12)
            .map(|(index, light)| format!("{index} {}", light.kind()))
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
            let by_kind = |light: &Light| {
                light.kind() == name || (name == "sun" && light.kind() == "directional")
            };
            let matching = lights.iter().filter(|light| by_kind(light)).count();
            let found = match name.parse() {
                Ok(index) => Some(index).filter(|index| *index < lights.len()),
                Err(_) if matching == 1 => lights.iter().position(by_kind),
                Err(_) => None,
            };
            found.ok_or_else(|| {
                let why = match matching {
                    0 => "there is no such light".into(),
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
fn describe_soundness(soundness: Soundness) -> String {
    let mut text = String::new();
    let Soundness {
        parts,
        open_parts,
        inverted_parts,
        open_edges,
    } = soundness;
    if open_parts > 0 {
        text += &format!(
            "note: {open_parts} of {} have holes ({}): baked as surfaces, which takes more time and space\n",
            count(parts, "part"),
            count(open_edges, "open edge")
        );
    }
    if inverted_parts > 0 {
        text += &format!(
            "note: {inverted_parts} of {} are turned inside out, or cavities: baked as surfaces\n",
            count(parts, "part")
        );
    }
    text
}

/// A bake on its way.
struct Work<'a> {
    input: &'a Input,
    spaces: &'a [LightSpace],
    resolution: Resolution,
    stop: &'a AtomicBool,
    part: &'a Path,
    /// Those that are finished.
    grids: Vec<ShadowDag>,
    soundness: Soundness,
}

impl Work<'_> {
    /// Takes over the finished grids of a checkpoint; returns what there is of
    /// the next.
    fn take_over<'c>(&mut self, checkpoint: &'c [u8]) -> Result<&'c [u8], Failure> {
        let (grids, rest) = checkpoint::load(checkpoint)?;
        let mine = |(grid, space): (&ShadowDag, &LightSpace)| {
            grid.light() == Some(space) && grid.resolution() == self.resolution
        };
        if grids.len() >= self.spaces.len() || !grids.iter().zip(self.spaces).all(mine) {
            return Err(Failure::new("it is of another scene, light or resolution"));
        }
        self.grids = grids;
        Ok(rest)
    }

    /// Bakes the grids that are missing, the first of them from a checkpoint.
    fn bake(&mut self, mut resumed: Option<&[u8]>) -> Result<(), Failure> {
        let first = self.grids.len();
        let all = self.spaces.len();
        for (index, space) in self.spaces.iter().enumerate().skip(first) {
            let spinner = progress::spinner("sorting triangles");
            let mesh = casters(&self.input.geometry, *space, self.resolution)?;
            self.soundness = mesh.soundness();
            spinner.finish_and_clear();
            let mut bake = shadow_dag::Bake::of_mesh(Builder::new(), &mesh);
            if let Some(tiles) = resumed.take() {
                bake.resume(tiles).map_err(|error| {
                    Failure::from(error).about(&self.part.display().to_string())
                })?;
            }
            let what = if all == 1 {
                "shadows"
            } else {
                "shadows, of six grids"
            };
            let bar = progress::bar(what, (bake.progress().tiles * all) as u64);
            self.tiles(&mut bake, &bar, index)?;
            bar.finish_and_clear();
            let spinner = progress::spinner("putting tiles together");
            self.grids.push(bake.finish()?);
            spinner.finish_and_clear();
        }
        Ok(())
    }

    /// Makes all tiles of a grid, with checkpoints.
    fn tiles(
        &self,
        bake: &mut shadow_dag::Bake<'_>,
        bar: &ProgressBar,
        index: usize,
    ) -> Result<(), Failure> {
        let cpu = Cpu::new();
        let tiles = bake.progress().tiles;
        let before = tiles * index;
        let mut pause = PAUSE;
        let mut clock = Instant::now();
        while !bake.progress().is_complete() {
            let observe = |progress: shadow_dag::Progress| {
                bar.set_position((before + progress.finished) as u64);
            };
            match bake.advance(&cpu, tiles.div_ceil(ROUNDS), self.stop, observe) {
                Err(shadow_dag::Error::Cancelled { .. }) => break,
                result => result?,
            };
            if clock.elapsed() >= pause && !bake.progress().is_complete() {
                clock = Instant::now();
                checkpoint::save(self.part, &self.grids, bake)?;
                pause = PAUSE.max(clock.elapsed() * SHARE);
                clock = Instant::now();
            }
        }
        // Also when it was asked for after the last tile: what comes next takes
        // a while too.
        if self.stop.load(Ordering::Relaxed) {
            checkpoint::save(self.part, &self.grids, bake)?;
            bar.finish_and_clear();
            let shadow_dag::Progress { finished, tiles } = bake.progress();
            return Err(Failure::new(format!(
                "interrupted after {finished} of {tiles} tiles of grid {} of {}; --resume goes on from {}",
                index + 1,
                self.spaces.len(),
                self.part.display()
            )));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interruption_after_the_last_tile_leaves_a_checkpoint() {
        let place = tempfile::tempdir().unwrap();
        let part = place.path().join("a.cpvs.part");
        let options = SceneOptions {
            seed: 1,
            lights: 1,
            map: None,
            medium: MediumOptions::default(),
        };
        let input = Input::load("city", &options).unwrap();
        let resolution = Resolution::new(64).unwrap();
        let emitter = emitter(&input.scene.lights, None).unwrap();
        let spaces = light_spaces(&input.geometry, &emitter, resolution).unwrap();
        let work = |stop| Work {
            input: &input,
            spaces: &spaces,
            resolution,
            stop,
            part: &part,
            grids: Vec::new(),
            soundness: Soundness::default(),
        };
        let mesh = casters(&input.geometry, spaces[0], resolution).unwrap();
        let mut bake = shadow_dag::Bake::of_mesh(Builder::new(), &mesh);
        let (asked, never) = (AtomicBool::new(true), AtomicBool::new(false));
        bake.advance(&Cpu::new(), usize::MAX, &never, |_| {})
            .unwrap();
        assert!(bake.progress().is_complete());
        let error = work(&asked).tiles(&mut bake, &ProgressBar::hidden(), 0);
        let error = error.unwrap_err().to_string();
        assert!(error.contains("interrupted after"), "{error}");

        let saved = checkpoint::read(&part).unwrap().unwrap();
        let mut resumed = work(&never);
        let rest = resumed.take_over(&saved).unwrap();
        resumed.bake(Some(rest)).unwrap();
        let expected = bake.finish().unwrap();
        assert_eq!(resumed.grids[0].as_bytes(), expected.as_bytes());
    }
}
