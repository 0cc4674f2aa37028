//! The colours of smoke, from files beside that of its densities.

use glam::Vec3;

use super::{LoadError, LoadOptions, UpAxis};
use crate::DensityGrid;

/// What is said of smoke beside its densities: VOL files of its colours, as Mitsuba has
/// them, and a factor.
///
/// The files have as many samples as there are densities along each axis. Those of a
/// NanoVDB or OpenVDB file are the voxels in the box around all that are there and one more
/// on each side, where the density has fallen to 0: n + 2 along an axis of n voxels.
#[derive(Debug, Clone, Copy, Default)]
pub struct SmokeColours<'a> {
    /// A VOL file of albedos, with as many samples as there are densities: shares from 0 to
    /// 1, of which a single channel is grey.
    pub albedo: Option<&'a [u8]>,
    /// A VOL file of emissions, with as many samples as there are densities: radiance per
    /// unit of length of the file.
    pub emission: Option<&'a [u8]>,
    /// A factor on the emission of that file, or else on the emission that the grid has,
    /// linear RGB.
    pub emission_scale: Option<Vec3>,
}

impl SmokeColours<'_> {
    /// The same grid in these colours, of a file that was read with these options.
    /// `samples_up` is the axis that points up in the order of its samples, as
    /// [`smoke_from_path`](super::smoke_from_path) returns it. What was ignored is added to
    /// `notes`, a sentence each.
    ///
    /// # Errors
    /// Those of the files; [`LoadError::BadValue`] for a file of another number of samples,
    /// for a factor that is not from 0 to 1e15, and for one where nothing emits;
    /// [`LoadError::Scene`] for an albedo or an emission, times its factor, that
    /// [`DensityGrid`] refuses.
    pub fn apply(
        &self,
        mut grid: DensityGrid,
        samples_up: UpAxis,
        options: &LoadOptions,
        notes: &mut Vec<String>,
    ) -> Result<DensityGrid, LoadError> {
        let ordered = LoadOptions {
            up: samples_up,
            ..options.clone()
        };
        let is_factor = |scale: Vec3| {
            let factors = scale.to_array();
            factors.iter().all(|factor| (0.0..=1e15).contains(factor))
        };
        if let Some(scale) = self.emission_scale.filter(|scale| !is_factor(*scale)) {
            let (what, expected) = ("the factor on the emission", "0 to 1e15");
            return Err(LoadError::bad_value(what, scale, expected));
        }
        let mut colours = |file: Option<&[u8]>, what: &str| {
            let read = |file| colours_for(&grid, file, what, &ordered, notes);
            file.map(read).transpose()
        };
        let albedo = colours(self.albedo, "the albedo")?;
        let emission = colours(self.emission, "the emission")?;
        if let Some(albedo) = albedo {
            grid = grid.with_albedo_samples(albedo)?;
        }
        if let Some(mut emission) = emission {
            let scale = self.emission_scale.unwrap_or(Vec3::ONE);
            for colour in &mut emission {
                *colour = scale * (*colour / options.unit as f32);
            }
            grid = grid.with_emission(emission)?;
        } else if let Some(scale) = self.emission_scale {
            if grid.emission().is_empty() {
                let (what, expected) = ("the factor on the emission", "smoke that emits");
                return Err(LoadError::bad_value(what, scale, expected));
            }
            let scaled = grid.emission().iter().map(|&colour| scale * colour);
            let scaled = scaled.collect();
            grid = grid.with_emission(scaled)?;
        }
        Ok(grid)
    }
}

/// The colours in a VOL file, one for each sample of a grid.
fn colours_for(
    grid: &DensityGrid,
    file: &[u8],
    what: &str,
    options: &LoadOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<Vec3>, LoadError> {
    let (resolution, colours, own_notes) = read_vol(file, options)?;
    if resolution != grid.resolution() {
        let size = |[x, y, z]: [u32; 3]| format!("{x} x {y} x {z}");
        let (found, wanted) = (size(resolution), size(grid.resolution()));
        return Err(LoadError::bad_value(
            format!("the resolution of {what}"),
            format!("{found}, and that of the densities {wanted}"),
            "the same",
        ));
    }
    notes.extend(own_notes.into_iter().map(|note| format!("{what}: {note}")));
    Ok(colours)
}

/// Samples along each axis, their colours, and notes.
type Colours = ([u32; 3], Vec<Vec3>, Vec<String>);

#[cfg(feature = "vol")]
fn read_vol(bytes: &[u8], options: &LoadOptions) -> Result<Colours, LoadError> {
    let found = super::vol_colours_from_slice(bytes, options)?;
    Ok((found.resolution, found.colours, found.notes))
}

#[cfg(not(feature = "vol"))]
fn read_vol(_: &[u8], _: &LoadOptions) -> Result<Colours, LoadError> {
    let what = "VOL (feature `vol` is off in this build)";
    Err(LoadError::Unsupported(what.into()))
}

#[cfg(all(test, feature = "vol"))]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::load::vol_from_slice;
    use crate::{Media, Translucent};

    /// Samples at x = 0, 1 and 2 of a box of 2 × 1 × 1.
    fn vol(channels: u32, values: &[f32]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        for word in [1, 3, 1, 1, channels] {
            bytes.extend(word.to_le_bytes());
        }
        let bounds = [0.0_f32, 0.0, 0.0, 2.0, 1.0, 1.0];
        for number in bounds.iter().chain(values) {
            bytes.extend(number.to_le_bytes());
        }
        bytes
    }

    fn apply(colours: SmokeColours<'_>, density: f32, unit: f64) -> Result<DensityGrid, LoadError> {
        let options = LoadOptions {
            unit,
            ..LoadOptions::default()
        };
        let mut loaded = vol_from_slice(&vol(1, &[density; 3]), &options)?;
        let Translucent::Grid(grid) = loaded.scene.translucent.remove(0) else {
            panic!("a grid");
        };
        colours.apply(grid, options.up, &options, &mut loaded.notes)
    }

    #[test]
    fn colours_of_other_files_are_those_of_the_samples() {
        let albedo = vol(1, &[0.25, 0.5, 0.75]);
        let emission = vol(3, &[0.0, 0.0, 0.0, 4.0, 2.0, 1.0, 8.0, 4.0, 2.0]);
        let colours = SmokeColours {
            albedo: Some(&albedo),
            emission: Some(&emission),
            emission_scale: Some(Vec3::new(1.0, 0.5, 2.0)),
        };
        let grid = apply(colours, 1.0, 0.5).unwrap();
        let albedo = [0.25, 0.5, 0.75].map(Vec3::splat);
        assert_eq!(grid.albedo_samples(), albedo);
        // Per metre, of which half is a unit of length of the file.
        let emission = [
            Vec3::ZERO,
            Vec3::new(8.0, 2.0, 4.0),
            Vec3::new(16.0, 4.0, 8.0),
        ];
        assert_eq!(grid.emission(), emission);
    }

    #[test]
    #[cfg(feature = "vdb")]
    fn colours_of_voxels_are_turned_with_them() {
        // Flames in a box of 6³ samples.
        const FLAMES: &[u8] = include_bytes!("testdata/flames.vdb.zz");
        let flames = miniz_oxide::inflate::decompress_to_vec_zlib(FLAMES).unwrap();
        let mut albedo = b"VOL\x03".to_vec();
        for word in [1, 6, 6, 6, 1_u32] {
            albedo.extend(word.to_le_bytes());
        }
        let bounds = [0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0];
        let shares: Vec<f32> = (0..216_u16).map(|i| f32::from(i) / 256.0).collect();
        for number in bounds.iter().chain(&shares) {
            albedo.extend(number.to_le_bytes());
        }
        let colours = SmokeColours {
            albedo: Some(&albedo),
            ..SmokeColours::default()
        };
        let read = |up| {
            let options = LoadOptions {
                up,
                ..LoadOptions::default()
            };
            let mut loaded = crate::load::vdb_from_slice(&flames, &options).unwrap();
            let Translucent::Grid(grid) = loaded.scene.translucent.remove(0) else {
                panic!("a grid");
            };
            colours.apply(grid, UpAxis::Y, &options, &mut loaded.notes)
        };
        let plain = read(UpAxis::Y).unwrap();
        for up in [UpAxis::X, UpAxis::Z] {
            let turned = read(up).unwrap();
            let index = Vec3::new(1.0, 2.0, 4.0);
            let [was, is] = [&plain, &turned].map(|grid| grid.transform().transform_point3(index));
            assert!(is.abs_diff_eq((up.rotation() * was.as_dvec3()).as_vec3(), 1e-5));
            assert!(!is.abs_diff_eq(was, 0.1), "{is}");
            // What emits has the albedo that stands at its place in the files.
            assert_eq!(turned.emission(), plain.emission());
            let expected: Vec<Vec3> = shares.iter().copied().map(Vec3::splat).collect();
            assert_eq!(turned.albedo_samples(), expected);
        }
    }

    #[test]
    fn emission_alone_adds_up_along_a_line() {
        let emission = vol(3, &[0.0, 0.0, 0.0, 4.0, 2.0, 1.0, 8.0, 4.0, 2.0]);
        let colours = SmokeColours {
            emission: Some(&emission),
            ..SmokeColours::default()
        };
        for unit in [1.0, 0.25] {
            let casters = [apply(colours, 0.0, unit).unwrap().into()];
            let media = Media::new(None, None, &casters);
            let (mut pieces, mut sum) = (
                media.along(DVec3::new(-1.0, 0.1, 0.1), DVec3::X, 0.0, 9.0),
                DVec3::ZERO,
            );
            while let Some(piece) = pieces.advance() {
                assert_eq!(piece.optical_depth(), DVec3::ZERO);
                let middle = 0.5 * (piece.start() + piece.end());
                sum += (piece.end() - piece.start()) * piece.emission(middle);
            }
            // The radiance does not depend on the unit: 4 per unit on average, over 2 units.
            assert!(sum.abs_diff_eq(DVec3::new(8.0, 4.0, 2.0), 1e-9), "{sum}");
        }
    }

    #[test]
    fn colours_that_do_not_fit_are_refused_with_their_cause() {
        let [large, negative] = [vol(1, &[2.0; 3]), vol(1, &[-1.0; 3])];
        let mut other = vol(1, &[1.0; 3]);
        other[8] = 1;
        let none = SmokeColours::default();
        for (colours, cause) in [
            (
                SmokeColours {
                    albedo: Some(&large),
                    ..none
                },
                "albedo",
            ),
            (
                SmokeColours {
                    emission: Some(&negative),
                    ..none
                },
                "emission",
            ),
            (
                SmokeColours {
                    emission: Some(&other),
                    ..none
                },
                "the resolution of the emission is 1 x 1 x 1, and that of the densities 3 x 1 x 1",
            ),
            (
                SmokeColours {
                    albedo: Some(b"PNG"),
                    ..none
                },
                "VOL",
            ),
            (
                SmokeColours {
                    emission_scale: Some(Vec3::ONE),
                    ..none
                },
                "smoke that emits",
            ),
            (
                SmokeColours {
                    emission: Some(&large),
                    emission_scale: Some(Vec3::NEG_ONE),
                    ..none
                },
                "emission",
            ),
        ] {
            let error = apply(colours, 1.0, 1.0).unwrap_err().to_string();
            assert!(error.contains(cause), "{cause}: {error}");
        }
    }
}
