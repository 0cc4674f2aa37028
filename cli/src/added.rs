//! Smoke and hair from files of their own, added to a scene.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::{Affine3A, DVec3};
use lighting::scene::load::{LoadOptions, Loaded, scene_from_path};
use lighting::scene::{Scene, Translucent};

use crate::failure::Failure;

/// What is added to a scene.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Smoke and hair")]
pub(crate) struct AddedOptions {
    /// Add smoke from a VOL, NanoVDB or OpenVDB file to the scene; may be repeated. Its origin is placed
    /// at X,Y,Z, in metres with +Y up [default: where it is in the file], and its size is
    /// multiplied by SCALE; the extinction per metre stays the same
    #[arg(long, value_name = "FILE[@X,Y,Z[,SCALE]]", value_parser = placed)]
    pub(crate) smoke: Vec<Placed>,

    /// Add hair from a HAIR file to the scene, placed in the same way as smoke; may be repeated
    #[arg(long, value_name = "FILE[@X,Y,Z[,SCALE]]", value_parser = placed)]
    pub(crate) hair: Vec<Placed>,
}

/// A file, and the place of its contents.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Placed {
    path: PathBuf,
    at: DVec3,
    scale: f64,
}

/// Reads `plume.nvdb@0,1.5,-2,0.5`. If the text after the last @ is not a list of numbers, it
/// belongs to the name.
fn placed(text: &str) -> Result<Placed, String> {
    let whole = |text: &str| Placed {
        path: text.into(),
        at: DVec3::ZERO,
        scale: 1.0,
    };
    let Some((path, place)) = text.rsplit_once('@') else {
        return Ok(whole(text));
    };
    let numbers = place.split(',').map(|number| number.trim().parse::<f64>());
    let Ok(numbers) = numbers.collect::<Result<Vec<_>, _>>() else {
        return Ok(whole(text));
    };
    // "nan" and "inf" are numbers to the parser.
    if !numbers.iter().all(|number| number.is_finite()) {
        return Err(format!("the place is {place}, expected finite numbers"));
    }
    let (at, scale) = match numbers[..] {
        [x, y, z] => (DVec3::new(x, y, z), 1.0),
        [x, y, z, scale] => (DVec3::new(x, y, z), scale),
        _ => return Err("expected a place as X,Y,Z or X,Y,Z,SCALE after the @".into()),
    };
    if !(1e-6..=1e6).contains(&scale) {
        return Err(format!("the scale is {scale}, expected 1e-6 to 1e6"));
    }
    if path.is_empty() {
        return Err("expected a file before the @".into());
    }
    Ok(Placed {
        path: path.into(),
        at,
        scale,
    })
}

/// The kind of contents that an option adds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Smoke,
    Hair,
}

impl AddedOptions {
    /// Whether nothing is added.
    pub(crate) fn is_empty(&self) -> bool {
        self.smoke.is_empty() && self.hair.is_empty()
    }

    /// Reads the files and adds their contents to a scene that was moved by `offset` when it
    /// was read.
    pub(crate) fn add(
        &self,
        scene: &mut Scene,
        offset: DVec3,
        options: &LoadOptions,
        notes: &mut Vec<String>,
    ) -> Result<(), Failure> {
        let smoke = self.smoke.iter().map(|placed| (Kind::Smoke, placed));
        let hair = self.hair.iter().map(|placed| (Kind::Hair, placed));
        for (kind, placed) in smoke.chain(hair) {
            let name = placed.path.display().to_string();
            let about = |failure: Failure| failure.about(&name);
            let loaded = load(&placed.path, options).map_err(about)?;
            notes.extend(loaded.notes.iter().map(|note| format!("{name}: {note}")));
            let found = placed.of(kind, loaded, offset).map_err(about)?;
            scene.translucent.extend(found);
        }
        Ok(())
    }
}

fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, Failure> {
    if !path.exists() {
        // A place that is no list of numbers was taken for a part of the name.
        let hint = match path.to_string_lossy().contains('@') {
            true => "; a place after an @ is X,Y,Z or X,Y,Z,SCALE",
            false => "",
        };
        return Err(Failure::new(format!("there is no such file{hint}")));
    }
    Ok(scene_from_path(path, options)?)
}

impl Placed {
    /// The contents of this kind, moved to their place.
    fn of(&self, kind: Kind, loaded: Loaded, offset: DVec3) -> Result<Vec<Translucent>, Failure> {
        let shift = (self.at + self.scale * loaded.offset - offset).as_vec3();
        let scale = self.scale as f32;
        let place =
            Affine3A::from_translation(shift) * Affine3A::from_scale(glam::Vec3::splat(scale));
        let mut found = Vec::new();
        for caster in loaded.scene.translucent {
            match (kind, caster) {
                (Kind::Smoke, Translucent::Grid(grid)) => {
                    let own = grid.transform();
                    found.push(grid.with_transform(place * own)?.into());
                }
                (Kind::Hair, Translucent::Strands(strands)) => {
                    found.push(strands.placed(shift, scale)?.into());
                }
                _ => {}
            }
        }
        match (found.is_empty(), kind) {
            (false, _) => Ok(found),
            (true, Kind::Smoke) => Err(Failure::new(
                "there is no smoke in it; --smoke takes VOL, NanoVDB and OpenVDB files",
            )),
            (true, Kind::Hair) => Err(Failure::new(
                "there is no hair in it; --hair takes HAIR files",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_behind_the_last_at_sign() {
        let read = |text: &str| placed(text).unwrap();
        let simple = read("plume.vol");
        assert_eq!((simple.at, simple.scale), (DVec3::ZERO, 1.0));
        let full = read("a@b/plume.vol@1,-2.5,3,0.5");
        assert_eq!(full.path, Path::new("a@b/plume.vol"));
        assert_eq!((full.at, full.scale), (DVec3::new(1.0, -2.5, 3.0), 0.5));
        assert_eq!(read("plume.vol@0,1,0").scale, 1.0);
        assert_eq!(read("me@home.vol").path, Path::new("me@home.vol"));
        for wrong in [
            "p.vol@1,2",
            "p.vol@1,2,3,4,5",
            "p.vol@1,2,3,0",
            "@1,2,3",
            "p@1,2,3,-1",
        ] {
            assert!(placed(wrong).is_err(), "{wrong}");
        }
        for wrong in ["p.vol@nan,0,0", "p.vol@0,-inf,0", "p.vol@0,0,0,nan"] {
            assert!(placed(wrong).unwrap_err().contains("finite"), "{wrong}");
        }
    }
}
