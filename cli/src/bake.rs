//! Baking the shadows of lights into a file.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{
    self, Builder, LightGrids, Resolution, ShadowSet, Watertightness, light_grids,
};
use lighting::scene::load::printable;
use lighting::scene::{Geometry, Light};
use shadow_dag::{SetBake, Surfaces};

use crate::added::AddedOptions;
use crate::args::{Bake, MediumOptions, NodeForm, SceneOptions};
use crate::checkpoint;
use crate::failure::Failure;
use crate::format::{bytes, count, seconds, significant};
use crate::input::Input;
use crate::output::PendingFile;
use crate::print::note;
use crate::{interrupt, progress, suggest};

/// The shortest time between two checkpoints.
const PAUSE: Duration = Duration::from_secs(10);

/// Runs `crepuscular bake`.
pub(crate) fn run(args: &Bake) -> Result<(), Failure> {
    let most = Resolution::new(args.resolution)
        .map_err(|error| Failure::from(error).about("--resolution"))?;
    // Signals are requests from here on, where the file is begun.
    let stop = interrupt::flag()?;
    let file = PendingFile::beside(&args.output, &[Path::new(&args.scene)])?;
    let clock = Instant::now();
    let mut input = Input::load(&args.scene, &scene_options(args))?;
    let (emitters, notes) = emitters(&input.scene.lights, &args.light)?;
    input.notes.extend(notes);
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
            .push(format!("there is {missing} to continue from"));
    }

    if !input.scene.translucent.is_empty() {
        let note = "hair and smoke are left out: a grid can only hold lit or shadowed";
        input.notes.push(note.into());
    }

    if let Some(dynamic) = input.geometry.dynamic_part() {
        let left_out = count(dynamic.triangles().len(), "dynamic triangle");
        input.notes.push(format!("{left_out} left out"));
    }
    let casters = input.casters_that_stay()?;
    let spinner = progress::spinner("sorting triangles");
    let surfaces = precomputed::surfaces(casters)?;
    let grids = grids(casters, &surfaces, &emitters, (most, args.texel))?;
    let lights = (grids.into_iter())
        .map(|grids| LightGrids {
            bias: args.bias,
            ..grids
        })
        .collect();
    let form = args.form.stored();
    let share = args.part.unwrap_or_default();
    let mut bake = (SetBake::new(Builder::new(), surfaces, lights)?)
        .form(form)
        .share(share);
    if let (Some(saved), Some(part)) = (saved, &part) {
        let resumed = bake.resume(&saved);
        resumed.map_err(|error| Failure::from(error).about(&part.display().to_string()))?;
    }
    let watertightness = bake.watertightness();
    spinner.finish_and_clear();
    run_bake(&mut bake, &stop, part.as_deref())?;
    let sizes = describe_grids(bake.lights());
    let (written, result) = if args.part.is_some() {
        let tiles = bake.progress().tiles;
        let written = file.finish_with(|out| bake.save(out))?;
        let what = format!("part {share} of {sizes}, {}", count(tiles, "tile"));
        (written, what)
    } else {
        let spinner = progress::spinner("putting grids together");
        let set = bake.finish()?;
        let content = content(&set, args.form)?;
        let written = file.finish(&content)?;
        spinner.finish_and_clear();
        (
            written,
            format!("{sizes} in {}", describe_size(&set, &content)),
        )
    };
    if let Some(part) = &part {
        checkpoint::remove(part)?;
    }
    input.notes.extend(describe_watertightness(watertightness));
    note(&input.notes);
    written.summarise(&format!(
        "{}: {result}; {}",
        args.output.display(),
        seconds(clock.elapsed().as_secs_f64())
    ))
}

/// The file of a set whose grids are in the form that `form` asks for.
pub(crate) fn content(set: &ShadowSet, form: NodeForm) -> Result<Vec<u8>, Failure> {
    Ok(match form {
        NodeForm::Plain | NodeForm::Packed => set.to_bytes(),
        NodeForm::Compressed => set.compress(),
    })
}

/// The grids of each light, as finely as `texel` asks for, but at most `most`.
fn grids(
    geometry: &Geometry,
    surfaces: &Surfaces<'_>,
    emitters: &[Emitter],
    (most, texel): (Resolution, Option<f64>),
) -> Result<Vec<LightGrids>, Failure> {
    let cpu = Cpu::new();
    let grids = cpu.map(emitters.len(), |light| {
        let grids = light_grids(geometry, &emitters[light], most)?;
        let Some(texel) = texel else {
            return Ok(grids);
        };
        let resolution = surfaces.fineness(&cpu, &grids.spaces, texel, most)?;
        light_grids(geometry, &emitters[light], resolution)
    });
    let grids = grids
        .into_iter()
        .collect::<Result<Vec<_>, shadow_dag::Error>>();
    Ok(grids?)
}

/// How many grids there are, of how many lights, and how fine they are.
pub(crate) fn describe_grids(lights: &[LightGrids]) -> String {
    let sides = |side: fn(u32, u32) -> u32| {
        let sides = lights.iter().map(|light| light.resolution.side());
        sides.reduce(side).unwrap_or(0)
    };
    let (least, most) = (sides(u32::min), sides(u32::max));
    let voxels = if least == most {
        format!("{most}³ voxels")
    } else {
        format!("{least}³ to {most}³ voxels")
    };
    let grids = lights.iter().map(|light| light.spaces.len()).sum();
    let of_lights = match lights.len() {
        1 => String::new(),
        lights => format!(" of {}", count(lights, "light")),
    };
    format!("{}{of_lights} of {voxels}", count(grids, "grid"))
}

/// How large the file of a set is, by itself and beside shadow maps.
pub(crate) fn describe_size(set: &ShadowSet, content: &[u8]) -> String {
    let maps = set
        .grids()
        .map(|grid| 2.0 * f64::from(grid.resolution().side()).powi(2));
    format!(
        "{}, 1/{} of 16-bit shadow maps",
        bytes(content.len() as u64),
        significant(maps.sum::<f64>() / content.len() as f64)
    )
}

/// The scene without the parts that a bake does not need.
fn scene_options(args: &Bake) -> SceneOptions {
    SceneOptions {
        seed: args.seed,
        lights: 1,
        no_shadow: args.no_shadow.clone(),
        dynamic: args.dynamic.clone(),
        map: None,
        surroundings: args.surroundings,
        medium: MediumOptions::default(),
        added: AddedOptions::default(),
        file: args.file.clone(),
    }
}

/// The lights that are asked for, and notes about them.
fn emitters(lights: &[Light], names: &[String]) -> Result<(Vec<Emitter>, Vec<String>), Failure> {
    let is_area = |light: &Light| matches!(light, Light::Area(_));
    let mut notes = Vec::new();
    let wanted: Vec<usize> = if names.iter().any(|name| name == "all") {
        let (soft, hard): (Vec<_>, Vec<_>) =
            (0..lights.len()).partition(|&index| is_area(&lights[index]));
        if !soft.is_empty() {
            notes.push(format!(
                "{} left out: their shadows are soft, and a grid holds the shadows of a point",
                count(soft.len(), "area light")
            ));
        }
        if hard.is_empty() {
            return Err(Failure::new("--light all: there are no lights to bake"));
        }
        hard
    } else if names.is_empty() {
        vec![index(lights, None)?]
    } else {
        let found = names.iter().map(|name| index(lights, Some(name)));
        found.collect::<Result<_, _>>()?
    };
    let mut emitters = Vec::with_capacity(wanted.len());
    for (at, &index) in wanted.iter().enumerate() {
        if is_area(&lights[index]) {
            return Err(Failure::new(format!(
                "light {index} is an area light: its shadows are soft, and a grid holds the shadows of a point"
            )));
        }
        if wanted[..at].contains(&index) {
            return Err(Failure::new(format!(
                "--light: light {index} is given twice"
            )));
        }
        // All others are one emitter.
        emitters.extend(lights[index].emitters(1)?);
    }
    Ok((emitters, notes))
}

/// The number of the light that `name` stands for.
fn index(lights: &[Light], name: Option<&str>) -> Result<usize, Failure> {
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
    match (name, lights) {
        (None, [_]) => Ok(0),
        (None, _) => Err(Failure::new(format!(
            "there are {}, choose one or all (--light): {}",
            count(lights.len(), "light"),
            list()
        ))),
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
            })
        }
    }
}

/// The notes of the bake about the scene.
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
    let what = match bake.lights() {
        [light] if light.spaces.len() == 1 => "shadows",
        [_] => "shadows, of several grids",
        _ => "shadows, of several lights",
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
                Some(part) => format!("{begin}; --resume continues from {}", part.display()),
                None => format!("{begin}, which are lost because the output is not a regular file"),
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
            dynamic: Vec::new(),
            lights: 1,
            map: None,
            surroundings: Surroundings::default(),
            medium: MediumOptions::default(),
            added: AddedOptions::default(),
            file: FileOptions::default(),
        };
        let input = Input::load("city", &options).unwrap();
        let resolution = Resolution::new(64).unwrap();
        let (emitters, _) = emitters(&input.scene.lights, &[]).unwrap();
        let begin = || {
            let lights = vec![light_grids(&input.geometry, &emitters[0], resolution).unwrap()];
            precomputed::bake(&input.geometry, lights, Builder::new()).unwrap()
        };
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
