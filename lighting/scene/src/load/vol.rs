//! Mitsuba's VOL files, version 3.

use glam::{DVec3, Vec3};
use half::f16;

use super::limits::{Budget, Notes};
use super::words::{Words, vec3};
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES, UpAxis};
use crate::{Bounds, DensityGrid, Interpolation, MAX_SAMPLES, Scene};

/// Reads a VOL file as a scene of one density grid; see the [module](super)
/// for what is understood.
///
/// # Errors
/// [`LoadError::Truncated`], [`LoadError::BadValue`],
/// [`LoadError::Unsupported`], [`LoadError::TooLarge`]; [`LoadError::Scene`]
/// for a box or a density that [`Bounds::new`] or [`DensityGrid::new`] refuses.
pub fn vol_from_slice(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, LoadError> {
    let mut samples = Samples::read(bytes, options)?;
    let mut tint = Vec3::ONE;
    if samples.channels == 3 {
        let (colours, _) = samples.values.as_chunks::<3>();
        let mut sums = DVec3::ZERO;
        for colour in colours {
            sums += Vec3::from(*colour).as_dvec3();
        }
        let mean = sums.element_sum() / 3.0;
        if mean > 0.0 && mean.is_finite() {
            tint = (sums / mean).as_vec3();
        }
        let of_colour = |[r, g, b]: &[f32; 3]| (r + g + b) / 3.0;
        samples.values = colours.iter().map(of_colour).collect();
        samples.notes.add(
            "the density is the mean of the three channels, and their ratio is that of all of the grid",
        );
    }
    let Samples {
        bounds,
        resolution,
        values,
        notes,
        ..
    } = samples;
    // Optical depths stay what they are in the file.
    let scale = (1.0 / options.unit) as f32;
    let grid = DensityGrid::new(bounds, resolution, values, scale, Interpolation::Linear)?;
    let scene = Scene {
        translucent: vec![grid.with_tint(tint)?.into()],
        ..Scene::default()
    };
    Ok(Loaded {
        scene,
        notes: notes.into_vec(),
        ..Loaded::default()
    })
}

/// The colours in a VOL file that goes with one of densities: its albedo, or its
/// emission.
#[derive(Debug, Clone, PartialEq)]
pub struct VolColours {
    /// Samples along x, y and z.
    pub resolution: [u32; 3],
    /// Linear RGB, x fastest: what
    /// [`DensityGrid::with_albedo_samples`] and [`DensityGrid::with_emission`] take of a
    /// grid of the same resolution.
    pub colours: Vec<Vec3>,
    /// Where they are; that of the densities counts.
    pub bounds: Bounds,
    /// What was ignored, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a VOL file of colours, one of a single channel as greys, turned like the
/// densities that [`vol_from_slice`] reads with the same options. Their unit stays: an
/// emission per unit of length of the file has to be divided by
/// [`LoadOptions::unit`].
///
/// # Errors
/// Those of [`vol_from_slice`], but for negative numbers, which
/// [`DensityGrid`] refuses.
pub fn vol_colours_from_slice(
    bytes: &[u8],
    options: &LoadOptions,
) -> Result<VolColours, LoadError> {
    let samples = Samples::read(bytes, options)?;
    let colours = match samples.channels {
        3 => {
            let (colours, _) = samples.values.as_chunks::<3>();
            colours.iter().map(|colour| Vec3::from(*colour)).collect()
        }
        _ => samples.values.into_iter().map(Vec3::splat).collect(),
    };
    Ok(VolColours {
        resolution: samples.resolution,
        colours,
        bounds: samples.bounds,
        notes: samples.notes.into_vec(),
    })
}

/// A VOL file in the axes and the unit of the scene.
#[derive(Debug)]
struct Samples {
    bounds: Bounds,
    resolution: [u32; 3],
    /// 1 or 3, next to each other.
    channels: usize,
    values: Vec<f32>,
    notes: Notes,
}

impl Samples {
    fn read(bytes: &[u8], options: &LoadOptions) -> Result<Self, LoadError> {
        options.check()?;
        let what = "the header of a VOL file";
        let mut words = Words::new(bytes);
        let [magic @ .., version] = words.item::<4>(what)?;
        if magic != *b"VOL" {
            return Err(LoadError::not_understood(
                "the start of the file",
                &magic,
                "\"VOL\"",
            ));
        }
        if version != 3 {
            return Err(LoadError::Unsupported(format!("VOL version {version}")));
        }
        let encoding = Encoding::of(words.u32(what)?)?;
        let resolution = [words.u32(what)?, words.u32(what)?, words.u32(what)?];
        let channels = words.u32(what)?;
        if channels != 1 && channels != 3 {
            return Err(LoadError::bad_value(
                "the number of VOL channels",
                channels,
                "1 or 3",
            ));
        }
        let bounds = Bounds::new(vec3(words.item(what)?), vec3(words.item(what)?))?;
        let samples = resolution
            .into_iter()
            .fold(1_u64, |product, count| product.saturating_mul(count.into()));
        if samples == 0 {
            let [x, y, z] = resolution;
            return Err(LoadError::bad_value(
                "the resolution of a VOL grid",
                format!("{x} x {y} x {z}"),
                "at least one sample along each axis",
            ));
        }
        if samples > MAX_SAMPLES {
            let [x, y, z] = resolution;
            return Err(LoadError::TooLarge {
                what: format!("a VOL grid of {x} x {y} x {z}"),
                bytes: samples.saturating_mul(4),
                limit: 4 * MAX_SAMPLES,
            });
        }
        let values = encoding.values(&mut words, samples * u64::from(channels))?;
        let mut notes = Notes::default();
        if words.available() > 0 {
            notes.add(format!(
                "{} bytes after the last sample ignored",
                words.available()
            ));
        }
        let placement = options.unit * options.up.rotation();
        let [a, b] = [bounds.min(), bounds.max()].map(|p| (placement * p.as_dvec3()).as_vec3());
        let channels = channels as usize;
        let (resolution, values) = turned(options.up, resolution, channels, values);
        Ok(Self {
            bounds: Bounds::new(a.min(b), a.max(b))?,
            resolution,
            channels,
            values,
            notes,
        })
    }
}

/// The samples in the order of the scene's axes, x fastest.
fn turned(
    up: UpAxis,
    resolution: [u32; 3],
    channels: usize,
    values: Vec<f32>,
) -> ([u32; 3], Vec<f32>) {
    let [x, y, z] = resolution.map(|count| count as usize);
    // For each axis of the scene its length and the samples that a step along it
    // is in the file, with the sample at the origin of the scene's box.
    let (lengths, steps, start) = match up {
        UpAxis::Y => return (resolution, values),
        UpAxis::X => ([y, x, z], [-(x as isize), 1, (x * y) as isize], x * (y - 1)),
        UpAxis::Z => ([x, z, y], [1, (x * y) as isize, -(x as isize)], x * (y - 1)),
    };
    let mut ordered = Vec::with_capacity(values.len());
    for k in 0..lengths[2] as isize {
        for j in 0..lengths[1] as isize {
            for i in 0..lengths[0] as isize {
                let at = start as isize + i * steps[0] + j * steps[1] + k * steps[2];
                let first = channels * at as usize;
                ordered.extend_from_slice(&values[first..first + channels]);
            }
        }
    }
    (lengths.map(|length| length as u32), ordered)
}

/// How numbers are stored.
#[derive(Debug, Clone, Copy)]
enum Encoding {
    F32,
    F16,
    U8,
}

impl Encoding {
    fn of(number: u32) -> Result<Self, LoadError> {
        match number {
            1 => Ok(Self::F32),
            2 => Ok(Self::F16),
            3 => Ok(Self::U8),
            4 => Err(LoadError::Unsupported("a VOL file of directions".into())),
            _ => Err(LoadError::bad_value("the VOL encoding", number, "1 to 4")),
        }
    }

    fn values(self, words: &mut Words<'_>, count: u64) -> Result<Vec<f32>, LoadError> {
        let what = "the VOL densities";
        Budget::new(MAX_DECODED_BYTES).take(what, count, size_of::<f32>())?;
        Ok(match self {
            Self::F32 => words.items(what, count)?.map(f32::from_le_bytes).collect(),
            Self::F16 => {
                let half = |bytes| f16::from_le_bytes(bytes).to_f32();
                words.items(what, count)?.map(half).collect()
            }
            Self::U8 => {
                let byte = |[byte]: [u8; 1]| f32::from(byte) / 255.0;
                words.items(what, count)?.map(byte).collect()
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Translucent;

    /// 2 × 1 × 3 samples of these bytes.
    fn file(encoding: u32, channels: u32, values: &[u8]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        for word in [encoding, 2, 1, 3, channels] {
            bytes.extend(word.to_le_bytes());
        }
        for number in [-1.0_f32, 0.0, 2.0, 1.0, 4.0, 3.0] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(values);
        bytes
    }

    fn f32s(count: u32) -> Vec<u8> {
        let number = |i: u32| (0.5 * i as f32).to_le_bytes();
        (0..count).flat_map(number).collect()
    }

    fn read(bytes: &[u8]) -> Result<Loaded, LoadError> {
        vol_from_slice(bytes, &LoadOptions::default())
    }

    #[test]
    fn unit_and_up_axis_turn_the_grid_and_keep_optical_depths() {
        let plain = grid(&file(1, 1, &f32s(6)));
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let options = LoadOptions {
                unit: 0.5,
                up,
                ..LoadOptions::default()
            };
            let loaded = vol_from_slice(&file(1, 1, &f32s(6)), &options).unwrap();
            let Translucent::Grid(turned) = &loaded.scene.translucent[0] else {
                panic!("a grid");
            };
            let placement = options.unit * up.rotation();
            for place in [
                Vec3::new(-0.9, 0.3, 2.1),
                Vec3::new(0.5, 3.9, 2.7),
                Vec3::new(0.0, 2.0, 2.5),
            ] {
                let there = (placement * place.as_dvec3()).as_vec3();
                let (was, is) = (plain.extinction_at(place), turned.extinction_at(there));
                assert!((is - 2.0 * was).abs() < 1e-4, "{up:?} {place}: {was} {is}");
            }
        }
    }

    fn grid(file: &[u8]) -> DensityGrid {
        match read(file).unwrap().scene.translucent.remove(0) {
            Translucent::Grid(grid) => grid,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_encoding_is_read() {
        let halves: Vec<u8> = (0..6_u8)
            .flat_map(|i| f16::from_f32(0.5 * f32::from(i)).to_le_bytes())
            .collect();
        let expected = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5];
        for file in [file(1, 1, &f32s(6)), file(2, 1, &halves)] {
            let grid = grid(&file);
            assert_eq!(
                (grid.resolution(), grid.density()),
                ([2, 1, 3], &expected[..])
            );
            assert_eq!(grid.bounds().min(), Vec3::new(-1.0, 0.0, 2.0));
            assert_eq!(grid.bounds().max(), Vec3::new(1.0, 4.0, 3.0));
        }
        let bytes = grid(&file(3, 1, &[0, 51, 102, 153, 204, 255]));
        assert!((bytes.density()[4] - 0.8).abs() < 1e-6 && bytes.density()[5] == 1.0);
        let coloured = file(1, 3, &f32s(18));
        assert_eq!(grid(&coloured).density()[..2], [0.5, 2.0]);
        assert!(read(&coloured).unwrap().notes[0].contains("mean"));
        // The sums of the channels are 22.5, 25.5 and 28.5.
        let ratio = Vec3::new(22.5, 25.5, 28.5) / 25.5;
        assert!(grid(&coloured).tint().abs_diff_eq(ratio, 1e-6));
    }

    #[test]
    fn colours_of_another_file_belong_to_the_samples_of_the_grid() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let options = LoadOptions {
                up,
                ..LoadOptions::default()
            };
            let read = |file: &[u8]| vol_colours_from_slice(file, &options).unwrap();
            let [colours, greys] = [read(&file(1, 3, &f32s(18))), read(&file(1, 1, &f32s(6)))];
            let mut densities = vol_from_slice(&file(1, 1, &f32s(6)), &options).unwrap();
            let Translucent::Grid(grid) = densities.scene.translucent.remove(0) else {
                panic!("a grid");
            };
            assert_eq!(colours.resolution, grid.resolution());
            assert_eq!(colours.bounds, grid.bounds());
            for ((colour, grey), &density) in colours
                .colours
                .iter()
                .zip(&greys.colours)
                .zip(grid.density())
            {
                // Sample i has the density i/2 in one file and 3 i/2 as red in the other.
                assert_eq!((colour.x, grey.x), (3.0 * density, density));
                assert_eq!((colour.y, grey.y), (3.0 * density + 0.5, density));
            }
            assert!(grid.clone().with_emission(colours.colours).is_ok());
            assert!(grid.with_albedo_samples(greys.colours).is_err());
        }
    }

    #[test]
    fn damaged_colours_never_panic() {
        crate::load::damage::survives(&file(2, 3, &[60; 36]), |damaged| {
            drop(vol_colours_from_slice(damaged, &LoadOptions::default()));
        });
    }

    #[test]
    fn bad_files_are_refused_with_their_cause() {
        let with = |place: usize, bytes: &[u8]| {
            let mut file = file(1, 1, &f32s(6));
            file[place..place + bytes.len()].copy_from_slice(bytes);
            file
        };
        let number = f32::to_le_bytes;
        for (file, cause) in [
            (b"VOX\x03".to_vec(), "\"VOL\""),
            (with(3, &[2]), "version 2"),
            (with(4, &[4]), "directions"),
            (with(4, &[9]), "encoding is 9"),
            (with(8, &[0]), "0 x 1 x 3"),
            (with(8, &[255; 12]), "4294967295 x 4294967295"),
            (with(8, &[255, 255, 0, 0]), "786420 bytes"),
            (with(20, &[2]), "channels is 2"),
            (with(24, &number(1.0)), "corners"),
            (with(24, &number(f32::NAN)), "NaN"),
            (with(48, &number(-1.0)), "sample 0: density is -1"),
            (with(52, &number(f32::INFINITY)), "sample 1"),
        ] {
            let error = read(&file).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }

    #[test]
    fn every_truncation_is_an_error_and_more_bytes_are_a_note() {
        let mut file = file(1, 1, &f32s(6));
        for length in 0..file.len() {
            assert!(read(&file[..length]).is_err(), "{length}");
        }
        file.push(0);
        assert!(read(&file).unwrap().notes[0].starts_with("1 bytes"));
    }

    #[test]
    fn damage_never_panics() {
        crate::load::damage::survives(&file(1, 3, &f32s(18)), |damaged| {
            drop(read(damaged));
        });
    }
}
