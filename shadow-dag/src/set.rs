//! The shadows of several lights as one file.
//!
//! One grid is a file by itself, see `layout`. Several are put one after the
//! other behind a directory; all numbers are little-endian.
//!
//! ```text
//!   0  magic "CPVSSET\0"
//!   8  version (u32), CRC-32 of the rest of the directory (u32)
//!  16  lights (u32), grids of all of them (u32)
//!  24  of each light (32 bytes): its first grid, how many it has, log2 of its
//!      resolution (u32 each), its bias (f32), where its grids begin and end (u64
//!      each, bytes from the beginning of the file)
//!   …  the length of each grid in bytes (u64 each)
//!   …  the grids, light by light
//! ```
//!
//! Two earlier forms of the same are still read. Version 1 has the number of grids
//! of each light (u32 each) in place of the second part of the directory, and a 0
//! in place of the number of all of them. What begins with "CPVSCUBE" is one light
//! of six grids, whose lengths follow the magic at once.

use std::borrow::Cow;
use std::io::{self, Write};
use std::ops::Range;

use gpu_backend::Cpu;

use crate::bytes::{load_u32, load_u64};
use crate::error::same_length;
use crate::file_error::FileError;
use crate::form::Form;
use crate::set_bake::LightGrids;
use crate::{Error, Resolution, ShadowDag, checkpoint, set_checkpoint};

const MAGIC: [u8; 8] = *b"CPVSSET\0";
const VERSION: u32 = 2;
/// The version without resolutions, biases and places of lights.
const COUNTED: u32 = 1;
/// Six grids of one light.
const CUBE: [u8; 8] = *b"CPVSCUBE";
/// Where the part of the head begins that its checksum covers.
const CHECKED: usize = 16;
/// Where the lights of the directory begin.
const LIGHTS: usize = 24;
/// Bytes that each of them takes.
const LIGHT: usize = 32;

/// Why bytes or grids are no set of shadows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetError {
    /// They begin like no file of shadows.
    #[error(
        "not a file of shadows: it begins with none of {MAGIC:?}, {CUBE:?} and those of one grid"
    )]
    Magic,
    /// They are what an unfinished bake left, or a part of one.
    #[error(
        "a checkpoint or a part of a bake, not its shadows; resume the bake or merge its parts first"
    )]
    Unfinished,
    /// There are no lights, or one of them has no grid.
    #[error(
        "light {0} has no grid; a set has at least one light, and each of them at least one grid"
    )]
    NoGrid(usize),
    /// The grids of a light differ in their resolution.
    #[error("the grids of light {0} are of different resolutions; those of a light are of one")]
    Resolutions(usize),
    /// The directory is not sound.
    #[error(transparent)]
    Head(FileError),
    /// The directory says something of a light that is not so.
    #[error("the directory is wrong about light {light}: {what}")]
    Directory {
        /// Which light, from 0.
        light: usize,
        /// What is wrong.
        what: &'static str,
    },
    /// A grid is not sound.
    #[error("grid {grid}: {error}")]
    Grid {
        /// Which one, from 0, counted through all lights.
        grid: usize,
        /// What is wrong with it.
        error: FileError,
    },
}

/// The shadows of several lights, each of one grid or more: a sun or a spotlight
/// has one, a lamp among what it lights six around it.
///
/// The bytes of the grids are whoever's they are, as those of a [`ShadowDag`].
///
/// ```
/// # use gpu_backend::Cpu;
/// # use shadow_dag::{Builder, DepthMap, Resolution, ShadowSet, Slices};
/// # let depths = vec![0.5; 64];
/// # let map = DepthMap::new(Resolution::new(8)?, Slices::Linear, &depths)?;
/// # let grid = Builder::new().build(&Cpu::new(), &map)?;
/// let set = ShadowSet::new(vec![vec![grid.clone()], vec![grid; 6]])?;
/// let file = set.to_bytes();
/// let read = ShadowSet::from_bytes(&file)?;
/// assert_eq!(read.lights().map(<[_]>::len).collect::<Vec<_>>(), [1, 6]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ShadowSet<B = Vec<u8>> {
    lights: Vec<Vec<ShadowDag<B>>>,
    /// Of each light.
    biases: Vec<f32>,
}

/// What the directory of a file says of a light.
#[derive(Debug, Clone, PartialEq)]
pub struct LightEntry {
    /// Its grids.
    pub grids: usize,
    /// Voxels along each axis of each of them.
    pub resolution: Resolution,
    /// See [`ShadowSet::bias`].
    pub bias: f32,
    /// Where its grids are in the file, one after the other.
    pub bytes: Range<u64>,
}

impl<B> ShadowSet<B> {
    /// The set of these grids, light by light.
    ///
    /// # Errors
    /// [`SetError::NoGrid`] if there is no light, or one without grids;
    /// [`SetError::Resolutions`] if a light has grids of more than one resolution.
    pub fn new(lights: Vec<Vec<ShadowDag<B>>>) -> Result<Self, SetError> {
        let empty = lights.iter().position(Vec::is_empty);
        match empty.or(lights.is_empty().then_some(0)) {
            Some(light) => Err(SetError::NoGrid(light)),
            None => Self::of_one_resolution(lights),
        }
    }

    /// The set of lights with grids, if those of each are of one resolution.
    fn of_one_resolution(lights: Vec<Vec<ShadowDag<B>>>) -> Result<Self, SetError> {
        let differs = |grids: &Vec<ShadowDag<B>>| {
            let first = grids[0].resolution();
            grids.iter().any(|grid| grid.resolution() != first)
        };
        match lights.iter().position(differs) {
            Some(light) => Err(SetError::Resolutions(light)),
            None => Ok(Self {
                biases: vec![LightGrids::BIAS; lights.len()],
                lights,
            }),
        }
    }

    /// The grids of lights that have been [checked](LightGrids::check).
    pub(crate) fn of_lights(lights: &[LightGrids], grids: Vec<ShadowDag<B>>) -> Self {
        let mut grids = grids.into_iter();
        let own = |light: &LightGrids| grids.by_ref().take(light.spaces.len()).collect();
        Self {
            lights: lights.iter().map(own).collect(),
            biases: lights.iter().map(|light| light.bias).collect(),
        }
    }

    /// How far beyond half a filter's width a point on a surface is to be moved
    /// along its normal, in voxels, before it is asked about in the grids of a light.
    /// [`LightGrids::BIAS`] unless another was chosen, and of a light that is not there.
    pub fn bias(&self, light: usize) -> f32 {
        self.biases.get(light).copied().unwrap_or(LightGrids::BIAS)
    }

    /// The same with other biases, one for each light.
    ///
    /// # Errors
    /// [`Error::Length`] if there are more or fewer than lights; [`Error::BadValue`]
    /// for one that is negative or not finite.
    pub fn with_biases(self, biases: Vec<f32>) -> Result<Self, Error> {
        same_length("biases", self.lights.len(), biases.len())?;
        LightGrids::check_biases(biases.iter().copied())?;
        Ok(Self { biases, ..self })
    }

    /// The grids of each light.
    pub fn lights(&self) -> impl ExactSizeIterator<Item = &[ShadowDag<B>]> {
        self.lights.iter().map(Vec::as_slice)
    }

    /// The grids of all lights, one after the other.
    pub fn grids(&self) -> impl Iterator<Item = &ShadowDag<B>> {
        self.lights.iter().flatten()
    }

    /// The set taken apart.
    pub fn into_lights(self) -> Vec<Vec<ShadowDag<B>>> {
        self.lights
    }
}

impl<B: AsRef<[u8]>> ShadowSet<B> {
    /// The same shadows with their nodes in another form.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`] if the plain form of a level is too long for
    /// its references.
    pub fn to_form(&self, form: Form) -> Result<ShadowSet, Error> {
        let grids: Vec<_> = self.grids().map(ShadowDag::borrowed).collect();
        let converted = Cpu::new().map(grids.len(), |grid| grids[grid].to_form(form));
        let mut converted = converted.into_iter();
        let lights = (self.lights.iter())
            .map(|grids| converted.by_ref().take(grids.len()).collect())
            .collect::<Result<_, _>>()?;
        Ok(ShadowSet {
            lights,
            biases: self.biases.clone(),
        })
    }

    /// Writes the file of the set: that of the grid if there is only one, with a
    /// bias of 1.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        let lengths: Vec<usize> = self.grids().map(|grid| grid.as_bytes().len()).collect();
        out.write_all(&self.head(&lengths))?;
        (self.grids()).try_for_each(|grid| out.write_all(grid.as_bytes()))
    }

    /// The file of the set, see [`ShadowSet::write`].
    pub fn to_bytes(&self) -> Vec<u8> {
        self.joined(self.grids().map(ShadowDag::as_bytes).collect())
    }

    /// The file of the set with compressed grids, see [`ShadowDag::compress`].
    /// [`ShadowSet::read`] reads it.
    pub fn compress(&self) -> Vec<u8> {
        let grids: Vec<_> = self.grids().map(ShadowDag::borrowed).collect();
        let grids = Cpu::new().map(grids.len(), |grid| grids[grid].compress());
        self.joined(grids.iter().map(Vec::as_slice).collect())
    }

    /// The file of the set with these as its grids.
    fn joined(&self, grids: Vec<&[u8]>) -> Vec<u8> {
        let lengths: Vec<usize> = grids.iter().map(|grid| grid.len()).collect();
        let mut file = self.head(&lengths);
        file.extend(grids.into_iter().flatten());
        file
    }

    /// The bytes in front of grids of these lengths. There are none if a single grid tells
    /// everything by itself.
    fn head(&self, lengths: &[usize]) -> Vec<u8> {
        if lengths.len() == 1 && self.biases == [LightGrids::BIAS] {
            return Vec::new();
        }
        let first = LIGHTS + LIGHT * self.lights.len() + 8 * lengths.len();
        let mut checked = Vec::new();
        checked.extend((self.lights.len() as u32).to_le_bytes());
        checked.extend((lengths.len() as u32).to_le_bytes());
        let (mut grid, mut begin) = (0, first as u64);
        for (grids, bias) in self.lights.iter().zip(&self.biases) {
            let own = &lengths[grid..grid + grids.len()];
            let end = begin + own.iter().map(|length| *length as u64).sum::<u64>();
            let log2 = grids[0].resolution().log2();
            let words = [grid as u32, grids.len() as u32, log2, bias.to_bits()];
            checked.extend(words.into_iter().flat_map(u32::to_le_bytes));
            checked.extend([begin, end].into_iter().flat_map(u64::to_le_bytes));
            (grid, begin) = (grid + grids.len(), end);
        }
        let lengths = lengths.iter().map(|length| *length as u64);
        checked.extend(lengths.flat_map(u64::to_le_bytes));
        let mut head = MAGIC.to_vec();
        head.extend(VERSION.to_le_bytes());
        head.extend(crc32fast::hash(&checked).to_le_bytes());
        head.extend(checked);
        head
    }
}

impl<'a> ShadowSet<&'a [u8]> {
    /// Takes the bytes of a file for shadows, where they are: of one grid, or
    /// of a set. Reads all of them once: afterwards no query can fail.
    ///
    /// # Errors
    /// [`SetError`] if they are not a whole and consistent file.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, SetError> {
        read_file(bytes, ShadowDag::from_bytes)
    }
}

impl<'a> ShadowSet<Cow<'a, [u8]>> {
    /// [`ShadowSet::from_bytes`] of a file whose grids may be compressed; see
    /// [`ShadowDag::read`].
    ///
    /// # Errors
    /// [`SetError`] if they are not a whole and consistent file.
    pub fn read(bytes: &'a [u8]) -> Result<Self, SetError> {
        read_file(bytes, ShadowDag::read)
    }
}

/// The set in a file of any kind; `read` reads a grid.
fn read_file<'a, B: Send>(
    bytes: &'a [u8],
    read: impl Fn(&'a [u8]) -> Result<ShadowDag<B>, FileError> + Sync + Send,
) -> Result<ShadowSet<B>, SetError> {
    if bytes.starts_with(&MAGIC) {
        let directory = Directory::read(bytes)?;
        return directory.grids(bytes, read);
    }
    if bytes.starts_with(&CUBE) {
        let directory = Directory {
            lengths: read_lengths(bytes, CUBE.len(), 6)?,
            first: CUBE.len() + 6 * 8,
            lights: vec![Listed {
                grids: 6,
                said: None,
            }],
        };
        return directory.grids(bytes, read);
    }
    match read(bytes) {
        Ok(grid) => ShadowSet::new(vec![vec![grid]]),
        Err(FileError::Unfinished) => Err(SetError::Unfinished),
        Err(FileError::Magic) => Err(SetError::Magic),
        Err(error) => Err(SetError::Grid { grid: 0, error }),
    }
}

/// The error for bytes of another kind of file than a single grid.
pub(crate) fn other_kind(bytes: &[u8]) -> Option<FileError> {
    if bytes.starts_with(&MAGIC) {
        let lights = bytes.get(CHECKED..CHECKED + 4);
        return Some(FileError::Set {
            lights: lights.map_or(0, |lights| load_u32(lights, 0)),
        });
    }
    if bytes.starts_with(&CUBE) {
        return Some(FileError::Set { lights: 1 });
    }
    let is_unfinished = checkpoint::is_one(bytes) || set_checkpoint::is_one(bytes);
    is_unfinished.then_some(FileError::Unfinished)
}

impl LightEntry {
    /// What the beginning of a file says of its lights, so that the grids of one
    /// can be read without those of the others. `None` of a file without a directory:
    /// of a single grid, or in an earlier form.
    ///
    /// The bytes must reach to the end of the directory; what is behind is not looked
    /// at, and may still turn out not to be sound.
    ///
    /// # Errors
    /// [`SetError`] if the directory is cut off or not sound.
    pub fn directory(bytes: &[u8]) -> Result<Option<Vec<Self>>, SetError> {
        if !bytes.starts_with(&MAGIC) {
            return Ok(None);
        }
        let lights = Directory::read(bytes)?.lights.into_iter();
        Ok(lights.map(|light| light.said).collect())
    }
}

fn truncated(bytes: &[u8], expected: u64) -> SetError {
    SetError::Head(FileError::Truncated {
        given: bytes.len() as u64,
        expected,
    })
}

/// The directory in front of the grids.
struct Directory {
    lights: Vec<Listed>,
    /// Of all grids.
    lengths: Vec<u64>,
    /// Where they begin.
    first: usize,
}

/// A light of the directory.
struct Listed {
    grids: usize,
    /// Its entry, with everything else about it.
    said: Option<LightEntry>,
}

impl Directory {
    fn read(bytes: &[u8]) -> Result<Self, SetError> {
        if bytes.len() < LIGHTS {
            return Err(truncated(bytes, LIGHTS as u64));
        }
        let version = load_u32(bytes, 8);
        let size = match version {
            COUNTED => 4,
            VERSION => LIGHT,
            _ => return Err(SetError::Head(FileError::Version(version))),
        };
        let lights = u64::from(load_u32(bytes, CHECKED));
        let end = LIGHTS as u64 + size as u64 * lights;
        if end > bytes.len() as u64 {
            return Err(truncated(bytes, end));
        }
        let end = end as usize;
        let places = (LIGHTS..end).step_by(size);
        let counts: Vec<u32> = places
            .clone()
            .map(|at| load_u32(bytes, if version == COUNTED { at } else { at + 4 }))
            .collect();
        let grids: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        let lengths = read_lengths(bytes, end, grids)?;
        let first = end + 8 * lengths.len();
        let (checksum, expected) = (crc32fast::hash(&bytes[CHECKED..first]), load_u32(bytes, 12));
        if checksum != expected {
            return Err(SetError::Head(FileError::Checksum {
                found: checksum,
                expected,
            }));
        }
        let mut lights = Vec::with_capacity(counts.len());
        if version == COUNTED {
            lights.extend(counts.iter().map(|&count| Listed {
                grids: count as usize,
                said: None,
            }));
        } else {
            if u64::from(load_u32(bytes, CHECKED + 4)) != grids {
                return Err(SetError::Head(FileError::Header {
                    what: "the number of all grids",
                    value: load_u32(bytes, CHECKED + 4).into(),
                }));
            }
            let (mut grid, mut begin) = (0_usize, first as u64);
            for (light, (at, &count)) in places.zip(&counts).enumerate() {
                let wrong = |what| SetError::Directory { light, what };
                let own = &lengths[grid..grid + count as usize];
                let bias = f32::from_bits(load_u32(bytes, at + 12));
                let resolution = Resolution::from_log2(load_u32(bytes, at + 8));
                let end = (own.iter()).fold(begin, |at, length| at.saturating_add(*length));
                let range = load_u64(bytes, at + 16)..load_u64(bytes, at + 24);
                if load_u32(bytes, at) as usize != grid {
                    return Err(wrong("its grids do not follow those of the light before"));
                }
                if range != (begin..end) {
                    return Err(wrong("its grids are elsewhere"));
                }
                if !(0.0..f32::INFINITY).contains(&bias) {
                    return Err(wrong("its bias is no finite number from 0"));
                }
                let entry = LightEntry {
                    grids: count as usize,
                    resolution: resolution.ok_or(wrong("there is no such resolution"))?,
                    bias,
                    bytes: range,
                };
                lights.push(Listed {
                    grids: count as usize,
                    said: Some(entry),
                });
                (grid, begin) = (grid + count as usize, end);
            }
        }
        Ok(Self {
            lights,
            lengths,
            first,
        })
    }

    /// The grids themselves; `read` reads one.
    fn grids<'a, B: Send>(
        &self,
        bytes: &'a [u8],
        read: impl Fn(&'a [u8]) -> Result<ShadowDag<B>, FileError> + Sync + Send,
    ) -> Result<ShadowSet<B>, SetError> {
        let first = self.first as u64;
        let end = (self.lengths.iter()).fold(first, |at, length| at.saturating_add(*length));
        let given = bytes.len() as u64;
        if end > given {
            return Err(truncated(bytes, end));
        }
        if end < given {
            return Err(SetError::Head(FileError::TooLong {
                given,
                expected: end,
            }));
        }
        let mut rest = &bytes[self.first..];
        let own: Vec<&[u8]> = (self.lengths.iter())
            .map(|&length| {
                // All of them together are as long as what is left.
                let (own, after) = rest.split_at(length as usize);
                rest = after;
                own
            })
            .collect();
        let grids = Cpu::new().map(own.len(), |grid| {
            read(own[grid]).map_err(|error| SetError::Grid { grid, error })
        });
        let mut grids = grids.into_iter();
        let mut lights = Vec::with_capacity(self.lights.len());
        for (light, listed) in self.lights.iter().enumerate() {
            let own: Vec<ShadowDag<B>> =
                (grids.by_ref().take(listed.grids)).collect::<Result<_, _>>()?;
            if let Some(entry) = &listed.said
                && own.iter().any(|grid| grid.resolution() != entry.resolution)
            {
                let what = "a grid is of another resolution";
                return Err(SetError::Directory { light, what });
            }
            lights.push(own);
        }
        let mut set = ShadowSet::new(lights)?;
        for (bias, listed) in set.biases.iter_mut().zip(&self.lights) {
            *bias = listed
                .said
                .as_ref()
                .map_or(LightGrids::BIAS, |said| said.bias);
        }
        Ok(set)
    }
}

/// The lengths of `count` grids, which stand from byte `at` on.
fn read_lengths(bytes: &[u8], at: usize, count: u64) -> Result<Vec<u64>, SetError> {
    let end = (at as u64).saturating_add(count.saturating_mul(8));
    if end > bytes.len() as u64 {
        return Err(truncated(bytes, end));
    }
    let places = (at..end as usize).step_by(8);
    Ok(places.map(|at| load_u64(bytes, at)).collect())
}
