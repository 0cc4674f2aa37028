//! Cem Yuksel's HAIR files, version 1.

use glam::Vec3;

use super::limits::{Budget, Notes};
use super::words::{Words, vec3};
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES};
use crate::{Scene, StrandPoint, Strands};

/// Bits of the header: which arrays follow it, in this order.
const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLOURS: u32 = 16;

/// Bytes for whatever the author wanted to say.
const INFO: u64 = 88;

/// Reads a HAIR file as a scene of strands; see the [module](super) for what
/// is understood.
///
/// # Errors
/// [`LoadError::Truncated`], [`LoadError::BadValue`],
/// [`LoadError::Unsupported`], [`LoadError::TooLarge`]; [`LoadError::Scene`] for
/// a point that [`Strands::new`] refuses, or a colour that [`Strands::with_colours`] does.
pub fn hair_from_slice(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, LoadError> {
    options.check()?;
    let mut words = Words::new(bytes);
    let magic: [u8; 4] = words.item("the header of a HAIR file")?;
    if magic != *b"HAIR" {
        return Err(LoadError::not_understood(
            "the start of the file",
            &magic,
            "\"HAIR\"",
        ));
    }
    let mut notes = Notes::default();
    let header = Header::read(&mut words)?;
    let ends = header.ends(&mut words)?;
    Budget::new(MAX_DECODED_BYTES).take(
        "points",
        header.points.into(),
        size_of::<StrandPoint>(),
    )?;
    let count = u64::from(header.points);
    let positions = words.items::<12>("the HAIR points", count)?.map(vec3);
    let thickness = header.array(&mut words, THICKNESS, header.thickness, "thickness")?;
    let transparency = header.array(
        &mut words,
        TRANSPARENCY,
        header.transparency,
        "transparency",
    )?;
    let colours = if header.arrays & COLOURS != 0 {
        let colours = words.items::<12>("the HAIR colours", count)?;
        colours.map(vec3).collect()
    } else {
        vec![header.colour]
    };
    if words.available() > 0 {
        notes.add(format!(
            "{} bytes after the last array ignored",
            words.available()
        ));
    }
    let placement = (options.unit * options.up.rotation()).as_mat3();
    let unit = options.unit as f32;
    let points = positions
        .zip(thickness.zip(transparency))
        .map(|(position, (thickness, transparency))| StrandPoint {
            position: placement * position,
            thickness: unit * thickness,
            opacity: 1.0 - transparency,
        })
        .collect();
    let scene = Scene {
        translucent: vec![Strands::new(points, ends)?.with_colours(colours)?.into()],
        ..Scene::default()
    };
    Ok(Loaded {
        scene,
        notes: notes.into_vec(),
        ..Loaded::default()
    })
}

#[derive(Debug)]
struct Header {
    strands: u32,
    points: u32,
    arrays: u32,
    /// What holds where there is no array.
    segments: u32,
    thickness: f32,
    transparency: f32,
    colour: Vec3,
}

impl Header {
    fn read(words: &mut Words<'_>) -> Result<Self, LoadError> {
        let what = "the header of a HAIR file";
        let header = Self {
            strands: words.u32(what)?,
            points: words.u32(what)?,
            arrays: words.u32(what)?,
            segments: words.u32(what)?,
            thickness: f32::from_le_bytes(words.item(what)?),
            transparency: f32::from_le_bytes(words.item(what)?),
            colour: vec3(words.item(what)?),
        };
        words.skip(what, INFO)?;
        if header.arrays & POINTS == 0 {
            return Err(LoadError::Unsupported("a HAIR file without points".into()));
        }
        let known = SEGMENTS | POINTS | THICKNESS | TRANSPARENCY | COLOURS;
        if header.arrays & !known != 0 {
            return Err(LoadError::Unsupported(format!(
                "an array of HAIR bits {:#x}",
                header.arrays & !known
            )));
        }
        Ok(header)
    }

    /// One after the last point of each strand.
    fn ends(&self, words: &mut Words<'_>) -> Result<Vec<u32>, LoadError> {
        // A strand has a point at least, and a point has 12 bytes: no list is
        // longer than the file.
        let available = words.available() as u64;
        let least = 12 * u64::from(self.points.max(self.strands));
        if least > available {
            return Err(LoadError::truncated(
                format!("{} HAIR strands of {} points", self.strands, self.points),
                least,
                words.available(),
            ));
        }
        let mut ends = Vec::with_capacity(self.strands as usize);
        let mut end = 0_u64;
        let mut add = |segments: u64| {
            end += segments + 1;
            // Beyond 2^32 the sum cannot be that of the header either.
            ends.push(u32::try_from(end).unwrap_or(u32::MAX));
        };
        if self.arrays & SEGMENTS != 0 {
            let segments = words.items::<2>("the HAIR segments", self.strands.into())?;
            segments.for_each(|bytes| add(u16::from_le_bytes(bytes).into()));
        } else {
            (0..self.strands).for_each(|_| add(self.segments.into()));
        }
        if end != u64::from(self.points) {
            return Err(LoadError::bad_value(
                "the number of HAIR points",
                self.points,
                "one more per strand than it has segments",
            ));
        }
        Ok(ends)
    }

    /// One number per point: from the array of this bit, or the same for all.
    fn array(
        &self,
        words: &mut Words<'_>,
        bit: u32,
        default: f32,
        name: &str,
    ) -> Result<impl Iterator<Item = f32> + use<>, LoadError> {
        let what = format!("the HAIR {name}");
        let there = self.arrays & bit != 0;
        let count = if there { self.points } else { 0 };
        let values: Vec<f32> = words
            .items::<4>(&what, count.into())?
            .map(f32::from_le_bytes)
            .collect();
        let rest = if there { 0 } else { self.points as usize };
        Ok(values.into_iter().chain(std::iter::repeat_n(default, rest)))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::Translucent;

    /// Strands of 2 and 3 points, or of 5 times 1 if there are no segments;
    /// with the arrays of these bits.
    fn file(arrays: u32) -> Vec<u8> {
        let strands: u32 = if arrays & SEGMENTS != 0 { 2 } else { 5 };
        let mut bytes = b"HAIR".to_vec();
        for word in [strands, 5, arrays, 0] {
            bytes.extend(word.to_le_bytes());
        }
        for number in [0.5_f32, 0.25, 1.0, 0.5, 0.0] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([b'x'; INFO as usize]);
        if arrays & SEGMENTS != 0 {
            bytes.extend([1, 0, 2, 0]);
        }
        let mut numbers = |each: usize, from: f32| {
            for i in 0..5 * each {
                bytes.extend((from + 0.01 * i as f32).to_le_bytes());
            }
        };
        numbers(3, 7.0);
        for (bit, each, from) in [
            (THICKNESS, 1, 0.1),
            (TRANSPARENCY, 1, 0.6),
            (COLOURS, 3, 0.0),
        ] {
            if arrays & bit != 0 {
                numbers(each, from);
            }
        }
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Loaded, LoadError> {
        hair_from_slice(bytes, &LoadOptions::default())
    }

    #[test]
    fn unit_and_up_axis_apply_to_positions_and_thickness() {
        let options = LoadOptions {
            unit: 0.01,
            up: crate::load::UpAxis::Z,
            ..LoadOptions::default()
        };
        let loaded = hair_from_slice(&file(POINTS), &options).unwrap();
        let point = strands(&loaded).points()[0];
        assert!(
            point
                .position
                .abs_diff_eq(Vec3::new(0.07, 0.0702, -0.0701), 1e-6)
        );
        assert!((point.thickness - 0.005).abs() < 1e-7);
        let bad = LoadOptions {
            unit: 0.0,
            ..options
        };
        assert!(hair_from_slice(&file(POINTS), &bad).is_err());
    }

    fn strands(loaded: &Loaded) -> &Strands {
        match &loaded.scene.translucent[..] {
            [Translucent::Strands(strands)] => strands,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_combination_of_arrays_is_read() {
        for arrays in (0..32).filter(|arrays| arrays & POINTS != 0) {
            let loaded = read(&file(arrays)).unwrap();
            let strands = strands(&loaded);
            let (count, pieces) = if arrays & SEGMENTS != 0 {
                (2, 3)
            } else {
                (5, 0)
            };
            assert_eq!((strands.len(), strands.piece_count()), (count, pieces));
            let last = strands.points()[4];
            let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
            assert!(last.position.abs_diff_eq(Vec3::new(7.12, 7.13, 7.14), 1e-5));
            let thickness = if arrays & THICKNESS != 0 { 0.14 } else { 0.5 };
            let opacity = if arrays & TRANSPARENCY != 0 {
                0.36
            } else {
                0.75
            };
            assert!(near(last.thickness, thickness) && near(last.opacity, opacity));
            if pieces > 0 {
                let colour = strands.colour(pieces - 1, 1.0);
                let expected = match arrays & COLOURS != 0 {
                    true => Vec3::new(0.12, 0.13, 0.14),
                    false => Vec3::new(1.0, 0.5, 0.0),
                };
                assert!(colour.abs_diff_eq(expected, 1e-6), "{colour}");
            }
            assert!(loaded.notes.is_empty());
        }
    }

    #[test]
    fn bad_files_are_refused_with_their_cause() {
        let with = |place: usize, bytes: &[u8]| {
            let mut file = file(SEGMENTS | POINTS);
            file[place..place + bytes.len()].copy_from_slice(bytes);
            file
        };
        for (file, cause) in [
            (b"HAI".to_vec(), "needs 4 bytes"),
            (b"HARE 1".to_vec(), "\"HAIR\""),
            (with(4, &[3, 0, 0, 0]), "is 5, expected one more"),
            (with(4, &[255; 4]), "4294967295 HAIR strands"),
            (with(8, &[255; 4]), "4294967295 points"),
            (with(12, &[1, 0, 0, 0]), "without points"),
            (with(12, &[67, 0, 0, 0]), "0x40"),
            (with(12, &[31, 0, 0, 0]), "thickness needs 20 bytes"),
            (with(20, &(-1.0_f32).to_le_bytes()), "thickness is -1"),
            (with(24, &f32::NAN.to_le_bytes()), "opacity is NaN"),
            (with(28, &2.0_f32.to_le_bytes()), "colour is"),
            (with(128, &[9, 0]), "is 5, expected"),
            (with(132, &f32::INFINITY.to_le_bytes()), "strand point 0"),
        ] {
            let error = read(&file).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }

    #[test]
    fn every_truncation_is_an_error_and_more_bytes_are_a_note() {
        for arrays in [3, 31, 2] {
            let mut file = file(arrays);
            for length in 0..file.len() {
                assert!(read(&file[..length]).is_err(), "{length}");
            }
            file.push(0);
            let notes = read(&file).unwrap().notes;
            assert!(notes.iter().any(|note| note.starts_with("1 bytes")));
        }
    }

    #[test]
    fn damage_never_panics() {
        for arrays in [3, 31] {
            crate::load::damage::survives(&file(arrays), |damaged| drop(read(damaged)));
        }
    }
}
