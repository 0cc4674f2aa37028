//! Smoke and hair from files of their own, added to a scene.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::{Affine3A, DVec3, Vec3};
use lighting::scene::load::{
    LoadError, LoadOptions, Loaded, MAX_FILE_BYTES, SmokeColours, UpAxis, read_regular,
    smoke_from_path,
};
use lighting::scene::{Scene, Translucent};

use crate::failure::Failure;

/// Smoke and hair that are added to a scene.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Smoke and hair")]
pub(crate) struct AddedOptions {
    /// Add smoke from a VOL, NanoVDB or OpenVDB file to the scene; may be repeated. Its origin is
    /// placed at X,Y,Z, in metres with +Y up [default: where it is in the file], and its size is
    /// multiplied by SCALE; extinction and emission per metre stay the same. In NanoVDB and
    /// OpenVDB files a grid called emission, flames or flame emits its value as radiance per unit
    /// of length
    #[arg(long, value_name = "FILE[@X,Y,Z[,SCALE]]", value_parser = placed)]
    pub(crate) smoke: Vec<Placed>,

    /// Emission of smoke from a VOL file of its own, radiance per unit of length, or a factor (one
    /// number or R,G,B) on the emission, or both; the first of these options applies to the first
    /// --smoke, the second to the second. The file has as many samples as the densities; those of
    /// NanoVDB and OpenVDB are the box of voxels and one more on each side
    #[arg(long, value_name = "FILE|FACTOR|FILE@FACTOR", value_parser = emission)]
    pub(crate) smoke_emission: Vec<Emission>,

    /// Albedo of smoke from a VOL file of its own, with as many samples as the densities; those of
    /// NanoVDB and OpenVDB are the box of voxels and one more on each side. The first of these
    /// options applies to the first --smoke, the second to the second
    #[arg(long, value_name = "FILE")]
    pub(crate) smoke_albedo: Vec<PathBuf>,

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

/// A file of emission, and a factor on it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Emission {
    path: Option<PathBuf>,
    factor: Option<Vec3>,
}

/// `fire.vol`, `5,2,1` or `fire.vol@5,2,1`. Text behind an @ that is no list of numbers is part
/// of the name. "nan" and "inf" are numbers, so that they are not looked for as files.
fn emission(text: &str) -> Result<Emission, String> {
    let numbers = |text: &str| -> Option<Vec<f64>> {
        let numbers = text.split(',').map(|number| number.trim().parse().ok());
        numbers.collect()
    };
    let (path, factor) = match text.rsplit_once('@') {
        Some((path, factor)) if numbers(factor).is_some() => (Some(path), numbers(factor)),
        _ => match numbers(text) {
            Some(factor) => (None, Some(factor)),
            None => (Some(text), None),
        },
    };
    let factors = factor.iter().flatten();
    if let Some(factor) = factors.copied().find(|x| !(0.0..=1e15).contains(x)) {
        return Err(format!("the factor is {factor}, expected 0 to 1e15"));
    }
    let factor = match factor.as_deref() {
        None => None,
        Some(&[grey]) => Some(DVec3::splat(grey)),
        Some(&[r, g, b]) => Some(DVec3::new(r, g, b)),
        Some(_) => return Err("expected a factor of one number or R,G,B".into()),
    };
    if path == Some("") {
        return Err("expected a file before the @".into());
    }
    Ok(Emission {
        path: path.map(PathBuf::from),
        factor: factor.map(|factor| factor.as_vec3()),
    })
}

/// The kind of contents that an option adds.
#[derive(Debug, Clone, Copy)]
enum Kind<'a> {
    /// Smoke, in these colours.
    Smoke(SmokeColours<'a>),
    Hair,
}

impl AddedOptions {
    /// Whether nothing is added.
    pub(crate) fn is_empty(&self) -> bool {
        let no_colours = self.smoke_emission.is_empty() && self.smoke_albedo.is_empty();
        self.smoke.is_empty() && self.hair.is_empty() && no_colours
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
        for (option, count) in [
            ("--smoke-emission", self.smoke_emission.len()),
            ("--smoke-albedo", self.smoke_albedo.len()),
        ] {
            if count > self.smoke.len() {
                let why = format!("there are more {option} than --smoke whose colours they are");
                return Err(Failure::new(why));
            }
        }
        let mut add = |kind: Kind<'_>, placed: &Placed| {
            let name = placed.path.display().to_string();
            let about = |failure: Failure| failure.about(&name);
            let (mut loaded, samples_up) = load(&placed.path, options).map_err(about)?;
            let casters = std::mem::take(&mut loaded.scene.translucent);
            let found = placed.of(
                kind,
                casters,
                [loaded.offset, offset],
                samples_up,
                options,
                &mut loaded.notes,
            );
            scene.translucent.extend(found.map_err(about)?);
            notes.extend(loaded.notes.iter().map(|note| format!("{name}: {note}")));
            Ok::<(), Failure>(())
        };
        for (index, placed) in self.smoke.iter().enumerate() {
            let emission = self.smoke_emission.get(index);
            let emission_file = emission.and_then(|emission| emission.path.as_deref());
            let [albedo, emission_file] = [
                contents(self.smoke_albedo.get(index).map(PathBuf::as_path))?,
                contents(emission_file)?,
            ];
            let colours = SmokeColours {
                albedo: albedo.as_deref(),
                emission: emission_file.as_deref(),
                emission_scale: emission.and_then(|emission| emission.factor),
            };
            add(Kind::Smoke(colours), placed)?;
        }
        for placed in &self.hair {
            add(Kind::Hair, placed)?;
        }
        Ok(())
    }
}

/// The contents of a file, if one was given.
fn contents(path: Option<&Path>) -> Result<Option<Vec<u8>>, Failure> {
    let read = |path: &Path| {
        let bytes = read_regular(path, MAX_FILE_BYTES);
        bytes.map_err(|source| LoadError::Io {
            path: path.to_path_buf(),
            source,
        })
    };
    Ok(path.map(read).transpose()?)
}

fn load(path: &Path, options: &LoadOptions) -> Result<(Loaded, UpAxis), Failure> {
    if !path.exists() {
        // A place that is no list of numbers was taken for a part of the name.
        let hint = match path.to_string_lossy().contains('@') {
            true => "; a place after an @ is X,Y,Z or X,Y,Z,SCALE",
            false => "",
        };
        return Err(Failure::new(format!("there is no such file{hint}")));
    }
    Ok(smoke_from_path(path, options)?)
}

impl Placed {
    /// The casters of this kind, moved to their place. The offsets by which the file and the
    /// scene were moved when they were read are undone.
    fn of(
        &self,
        kind: Kind<'_>,
        casters: Vec<Translucent>,
        [of_file, of_scene]: [DVec3; 2],
        samples_up: UpAxis,
        options: &LoadOptions,
        notes: &mut Vec<String>,
    ) -> Result<Vec<Translucent>, Failure> {
        let shift = (self.at + self.scale * of_file - of_scene).as_vec3();
        let scale = self.scale as f32;
        let place =
            Affine3A::from_translation(shift) * Affine3A::from_scale(glam::Vec3::splat(scale));
        let mut found = Vec::new();
        for caster in casters {
            match (kind, caster) {
                (Kind::Smoke(colours), Translucent::Grid(grid)) => {
                    let own = grid.transform();
                    let grid = colours.apply(grid, samples_up, options, notes)?;
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
            (true, Kind::Smoke(_)) => Err(Failure::new(
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
    fn an_emission_is_a_file_a_factor_or_both() {
        let of = |path: Option<&str>, factor: Option<Vec3>| Emission {
            path: path.map(PathBuf::from),
            factor,
        };
        let colour = Some(Vec3::new(5.0, 2.0, 1.0));
        for (text, expected) in [
            ("fire.vol", of(Some("fire.vol"), None)),
            ("me@home.vol", of(Some("me@home.vol"), None)),
            ("2", of(None, Some(Vec3::splat(2.0)))),
            ("5,2,1", of(None, colour)),
            ("a@b.vol@5,2,1", of(Some("a@b.vol"), colour)),
        ] {
            assert_eq!(emission(text), Ok(expected), "{text}");
        }
        for wrong in ["1,2", "fire.vol@1,2", "fire.vol@-1", "@1"] {
            assert!(emission(wrong).is_err(), "{wrong}");
        }
        for wrong in [
            "nan",
            "inf",
            "-1",
            "1.1e15",
            "1,-inf,1",
            "fire.vol@NaN",
            "fire.vol@1,1e39,1",
        ] {
            let error = emission(wrong).unwrap_err();
            assert!(error.contains("expected 0 to 1e15"), "{wrong}: {error}");
        }
    }

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
