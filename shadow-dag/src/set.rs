//! The shadows of several lights as one file.
//!
//! One grid is a file by itself, see `layout`. Several are put one after the
//! other behind a head; all numbers are little-endian.
//!
//! ```text
//!   0  magic "CPVSSET\0"
//!   8  version (u32), CRC-32 of the rest of the head (u32)
//!  16  lights (u32), 0 (u32)
//!  24  the number of grids of each light (u32 each)
//!   …  the length of each grid in bytes (u64 each)
//!   …  the grids, light by light
//! ```
//!
//! What begins with "CPVSCUBE" is an earlier form of the same: one light of six
//! grids, whose lengths follow the magic at once. It is still read.

use std::borrow::Cow;
use std::io::{self, Write};

use crate::bytes::{load_u32, load_u64};
use crate::file_error::FileError;
use crate::form::Form;
use crate::{Error, ShadowDag, checkpoint};

const MAGIC: [u8; 8] = *b"CPVSSET\0";
const VERSION: u32 = 1;
/// Six grids of one light.
const CUBE: [u8; 8] = *b"CPVSCUBE";
/// Where the part of the head begins that its checksum covers.
const CHECKED: usize = 16;
/// Where the numbers of grids begin.
const COUNTS: usize = 24;

/// Why bytes or grids are no set of shadows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetError {
    /// They begin like no file of shadows.
    #[error(
        "not a file of shadows: it begins with none of {MAGIC:?}, {CUBE:?} and those of one grid"
    )]
    Magic,
    /// They are what an unfinished bake left.
    #[error("a checkpoint of a bake that is not finished, not its shadows; resume the bake first")]
    Unfinished,
    /// There are no lights, or one of them has no grid.
    #[error(
        "light {0} has no grid; a set has at least one light, and each of them at least one grid"
    )]
    NoGrid(usize),
    /// The head is not sound.
    #[error(transparent)]
    Head(FileError),
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
}

impl<B> ShadowSet<B> {
    /// The set of these grids, light by light.
    ///
    /// # Errors
    /// [`SetError::NoGrid`] if there is no light, or one without grids.
    pub fn new(lights: Vec<Vec<ShadowDag<B>>>) -> Result<Self, SetError> {
        let empty = lights.iter().position(Vec::is_empty);
        match empty.or(lights.is_empty().then_some(0)) {
            Some(light) => Err(SetError::NoGrid(light)),
            None => Ok(Self { lights }),
        }
    }

    /// The same of lights that are known to have grids.
    pub(crate) fn of_checked(lights: Vec<Vec<ShadowDag<B>>>) -> Self {
        Self { lights }
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
        let convert = |grids: &Vec<ShadowDag<B>>| {
            let converted = grids.iter().map(|grid| grid.to_form(form));
            converted.collect::<Result<Vec<_>, _>>()
        };
        let lights = self.lights.iter().map(convert);
        Ok(ShadowSet {
            lights: lights.collect::<Result<_, _>>()?,
        })
    }

    /// Writes the file of the set: that of the grid if there is only one.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        if self.grids().count() > 1 {
            out.write_all(&self.head(self.grids().map(|grid| grid.as_bytes().len())))?;
        }
        (self.grids()).try_for_each(|grid| out.write_all(grid.as_bytes()))
    }

    /// The file of the set, see [`ShadowSet::write`].
    pub fn to_bytes(&self) -> Vec<u8> {
        self.joined(self.grids().map(ShadowDag::as_bytes).collect())
    }

    /// The file of the set with compressed grids, see [`ShadowDag::compress`].
    /// [`ShadowSet::read`] reads it.
    pub fn compress(&self) -> Vec<u8> {
        let grids: Vec<Vec<u8>> = self.grids().map(ShadowDag::compress).collect();
        self.joined(grids.iter().map(Vec::as_slice).collect())
    }

    /// The file of the set with these as its grids.
    fn joined(&self, grids: Vec<&[u8]>) -> Vec<u8> {
        match grids.as_slice() {
            [grid] => grid.to_vec(),
            _ => {
                let mut file = self.head(grids.iter().map(|grid| grid.len()));
                file.extend(grids.into_iter().flatten());
                file
            }
        }
    }

    fn head(&self, lengths: impl Iterator<Item = usize>) -> Vec<u8> {
        let mut checked = Vec::new();
        checked.extend((self.lights.len() as u32).to_le_bytes());
        checked.extend([0; 4]);
        let counts = self.lights.iter().map(|grids| grids.len() as u32);
        checked.extend(counts.flat_map(u32::to_le_bytes));
        checked.extend(lengths.flat_map(|length| (length as u64).to_le_bytes()));
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
fn read_file<'a, B>(
    bytes: &'a [u8],
    read: impl Fn(&'a [u8]) -> Result<ShadowDag<B>, FileError>,
) -> Result<ShadowSet<B>, SetError> {
    if bytes.starts_with(&MAGIC) {
        return read_set(bytes, read);
    }
    if bytes.starts_with(&CUBE) {
        let lengths = read_lengths(bytes, CUBE.len(), 6)?;
        return read_grids(bytes, CUBE.len() + 6 * 8, &[6], &lengths, read);
    }
    if checkpoint::is_one(bytes) {
        return Err(SetError::Unfinished);
    }
    match read(bytes) {
        Ok(grid) => ShadowSet::new(vec![vec![grid]]),
        Err(FileError::Magic) => Err(SetError::Magic),
        Err(error) => Err(SetError::Grid { grid: 0, error }),
    }
}

fn truncated(bytes: &[u8], expected: u64) -> SetError {
    SetError::Head(FileError::Truncated {
        given: bytes.len() as u64,
        expected,
    })
}

fn read_set<'a, B>(
    bytes: &'a [u8],
    read: impl Fn(&'a [u8]) -> Result<ShadowDag<B>, FileError>,
) -> Result<ShadowSet<B>, SetError> {
    if bytes.len() < COUNTS {
        return Err(truncated(bytes, COUNTS as u64));
    }
    let version = load_u32(bytes, 8);
    if version != VERSION {
        return Err(SetError::Head(FileError::Version(version)));
    }
    let lights = u64::from(load_u32(bytes, CHECKED));
    let lengths = COUNTS as u64 + 4 * lights;
    if lengths > bytes.len() as u64 {
        return Err(truncated(bytes, lengths));
    }
    let lengths = lengths as usize;
    let counts: Vec<u32> = (COUNTS..lengths)
        .step_by(4)
        .map(|at| load_u32(bytes, at))
        .collect();
    let grids = counts.iter().map(|&count| u64::from(count)).sum();
    let found = read_lengths(bytes, lengths, grids)?;
    let first = lengths + 8 * found.len();
    let (checksum, expected) = (crc32fast::hash(&bytes[CHECKED..first]), load_u32(bytes, 12));
    if checksum != expected {
        return Err(SetError::Head(FileError::Checksum {
            found: checksum,
            expected,
        }));
    }
    read_grids(bytes, first, &counts, &found, read)
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

/// The grids of all lights, which stand from byte `first` on.
fn read_grids<'a, B>(
    bytes: &'a [u8],
    first: usize,
    counts: &[u32],
    lengths: &[u64],
    read: impl Fn(&'a [u8]) -> Result<ShadowDag<B>, FileError>,
) -> Result<ShadowSet<B>, SetError> {
    let end = (lengths.iter()).fold(first as u64, |at, length| at.saturating_add(*length));
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
    let mut rest = &bytes[first..];
    let mut grid = 0;
    let mut lights = Vec::with_capacity(counts.len());
    for &count in counts {
        let mut grids = Vec::with_capacity(count as usize);
        for _ in 0..count {
            // All of them together are as long as what is left.
            let (own, after) = rest.split_at(lengths[grid] as usize);
            grids.push(read(own).map_err(|error| SetError::Grid { grid, error })?);
            rest = after;
            grid += 1;
        }
        lights.push(grids);
    }
    ShadowSet::new(lights)
}
