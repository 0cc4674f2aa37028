//! Where things are in a file, and whether they can be.
//!
//! All numbers are little-endian.
//!
//! ```text
//!   0  magic "CPVSDAG\0"
//!   8  version (u32), CRC-32 of all that follows (u32)
//!  16  form (u32: 0 plain, 1 packed, 2 compressed), log₂ of the resolution,
//!      root, masks
//!  32  light (u32: 0 unknown, 1 parallel, 2 perspective), 0 (u32)
//!  40  16 f64: from the world to the space of the light, by columns
//! 168  2 f64: near and far, 0 but for a perspective light
//! 184  plain: per level, from the finest: nodes, words
//!      packed: shapes of slice nodes, shapes of other nodes, then per level
//!      the nodes with 0, 1, … 8 references, the bits of a shape number and
//!      of a reference
//!   …  the masks, 8 bytes each
//!   …  plain: the words of the levels
//!      packed: the shapes, 4 bytes each; the bits of each level, filled up
//!      to bytes; 8 bytes 0
//! ```
//!
//! Compressed nodes and masks are what `compressed` makes of them, from byte 184
//! to the end.

use crate::bytes::BIT_PADDING;
use crate::bytes::{load_u32, load_u64};
use crate::file_error::{FileError, MAGIC};
use crate::form::Form;
use crate::pool::{LIT, Reference, SHADOWED};
use crate::resolution::Resolution;
use crate::{LightSpace, Slices, set};

pub(crate) const VERSION: u32 = 1;
/// Where the part begins that the checksum covers.
pub(crate) const CHECKED: usize = 16;
/// Where what depends on the form begins.
pub(crate) const FORM: usize = 184;

/// A level of plain nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PlainLevel {
    /// Byte at which it begins.
    pub(crate) start: usize,
    pub(crate) nodes: u32,
    pub(crate) words: u32,
}

/// A level of packed nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PackedLevel {
    /// Nodes with 0, 1, … 8 references.
    pub(crate) counts: [u32; 9],
    /// Bits of the number of a shape.
    pub(crate) shape_width: u32,
    /// Bits of a reference.
    pub(crate) width: u32,
    /// The first node with so many references or more.
    pub(crate) firsts: [u32; 9],
    /// The bit at which node 0 would begin if all nodes were of that size,
    /// modulo 2⁶⁴.
    pub(crate) offsets: [u64; 9],
    /// Byte at which the level begins, and behind its end.
    pub(crate) start: usize,
    pub(crate) end: usize,
}

impl PackedLevel {
    /// A level that begins at byte `start`; none if there cannot be such one.
    pub(crate) fn new(
        counts: [u32; 9],
        shape_width: u32,
        width: u32,
        start: usize,
    ) -> Option<Self> {
        let mut firsts = [0; 9];
        let mut offsets = [0; 9];
        let mut nodes = 0_u32;
        let mut bit = 8 * start as u64;
        for references in 0..9 {
            let size = u64::from(shape_width + references as u32 * width);
            firsts[references] = nodes;
            offsets[references] = bit.wrapping_sub(u64::from(nodes) * size);
            nodes = nodes.checked_add(counts[references])?;
            bit = bit.checked_add(size * u64::from(counts[references]))?;
        }
        let level = Self {
            counts,
            shape_width,
            width,
            firsts,
            offsets,
            start,
            end: usize::try_from(bit.div_ceil(8)).ok()?,
        };
        let fits = nodes <= SHADOWED && shape_width <= 32 && width <= 32;
        (fits && Self::can_be(&counts, shape_width, width)).then_some(level)
    }

    /// False if two nodes would have to be equal: without that, nodes of no
    /// bits would cost a file nothing, and whoever reads it a lot.
    pub(crate) fn can_be(counts: &[u32; 9], shape_width: u32, width: u32) -> bool {
        (0..).zip(counts).all(|(references, &count)| {
            let size = shape_width + references * width;
            size >= u32::BITS || count <= 1 << size
        })
    }

    pub(crate) fn nodes(&self) -> u32 {
        self.firsts[8] + self.counts[8]
    }

    /// How many different references a node has.
    #[inline]
    pub(crate) fn references(&self, node: Reference) -> usize {
        self.firsts[1..]
            .iter()
            .map(|&first| usize::from(node >= first))
            .sum()
    }

    /// The bit at which a node begins.
    #[inline]
    pub(crate) fn address(&self, node: Reference) -> u64 {
        let references = self.references(node);
        let size = u64::from(self.shape_width) + references as u64 * u64::from(self.width);
        self.offsets[references & 15].wrapping_add(u64::from(node) * size)
    }
}

/// How nodes are stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Stored {
    Plain(Vec<PlainLevel>),
    Packed {
        /// Where the shapes of slice nodes and of others begin, and how many
        /// there are.
        shapes: [(usize, u32); 2],
        levels: Vec<PackedLevel>,
    },
}

/// What every file begins with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Head {
    pub(crate) form: u32,
    pub(crate) resolution: Resolution,
    pub(crate) root: Reference,
    pub(crate) light: Option<LightSpace>,
    pub(crate) mask_count: u32,
}

/// The forms of files, by their numbers.
pub(crate) mod form {
    pub(crate) const PLAIN: u32 = 0;
    pub(crate) const PACKED: u32 = 1;
    pub(crate) const COMPRESSED: u32 = 2;
}

fn bad_header(what: &'static str, value: u32) -> FileError {
    FileError::Header {
        what,
        value: u64::from(value),
    }
}

impl Head {
    /// Reads it from the beginning of a file.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self, FileError> {
        let magic = bytes.get(..8).unwrap_or(bytes);
        if magic != &MAGIC[..magic.len()] {
            return Err(set::other_kind(bytes).unwrap_or(FileError::Magic));
        }
        if bytes.len() < FORM {
            return Err(FileError::Truncated {
                given: bytes.len() as u64,
                expected: FORM as u64,
            });
        }
        let version = load_u32(bytes, 8);
        if version != VERSION {
            return Err(FileError::Version(version));
        }
        let log2 = load_u32(bytes, 20);
        let resolution = Resolution::from_log2(log2)
            .ok_or(bad_header("the logarithm of the resolution", log2))?;
        Ok(Self {
            form: load_u32(bytes, 16),
            resolution,
            root: load_u32(bytes, 24),
            light: read_light(bytes)?,
            mask_count: load_u32(bytes, 28),
        })
    }

    /// The bytes of it, but for the checksum.
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut head = MAGIC.to_vec();
        let numbers = [
            VERSION,
            0,
            self.form,
            self.resolution.log2(),
            self.root,
            self.mask_count,
        ];
        head.extend(numbers.into_iter().flat_map(u32::to_le_bytes));
        write_light(self.light.as_ref(), &mut head);
        head
    }

    /// # Errors
    /// [`FileError::Header`] unless the root suits a coarsest level of `roots`
    /// nodes. A single node is number 0 in any form.
    pub(crate) fn check_root(&self, roots: u32) -> Result<(), FileError> {
        let fits = match self.root {
            LIT | SHADOWED => roots == 0,
            root => root == 0 && roots == 1,
        };
        fits.then_some(()).ok_or(bad_header("the root", self.root))
    }
}

/// The places of everything in a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    pub(crate) resolution: Resolution,
    pub(crate) root: Reference,
    pub(crate) light: Option<LightSpace>,
    /// Where the masks begin, and how many there are.
    pub(crate) masks: usize,
    pub(crate) mask_count: u32,
    pub(crate) stored: Stored,
}

/// Goes through a file; sizes add up in 64 bits.
struct Place {
    at: u64,
    len: u64,
}

impl Place {
    /// Where `count` things of `size` bytes begin.
    fn take(&mut self, count: u64, size: u64) -> Result<usize, FileError> {
        let start = self.at;
        self.at = start.saturating_add(count.saturating_mul(size));
        if self.at > self.len {
            return Err(FileError::Truncated {
                given: self.len,
                expected: self.at,
            });
        }
        Ok(start as usize)
    }
}

impl Layout {
    pub(crate) fn form(&self) -> Form {
        match self.stored {
            Stored::Plain(_) => Form::Plain,
            Stored::Packed { .. } => Form::Packed,
        }
    }

    /// Reads the head and checks that everything it announces is there. The
    /// checksum and the nodes are not looked at.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self, FileError> {
        let head = Head::read(bytes)?;
        let mut place = Place {
            at: FORM as u64,
            len: bytes.len() as u64,
        };
        let Head {
            resolution,
            root,
            light,
            mask_count,
            ..
        } = head;
        let levels = resolution.root_level() + 1;
        let (masks, stored) = match head.form {
            form::PLAIN => read_plain(bytes, &mut place, levels, mask_count)?,
            form::PACKED => read_packed(bytes, &mut place, levels, mask_count)?,
            form::COMPRESSED => return Err(FileError::Compressed),
            form => return Err(bad_header("the form", form)),
        };
        if place.at != place.len {
            return Err(FileError::TooLong {
                given: place.len,
                expected: place.at,
            });
        }
        head.check_root(match &stored {
            Stored::Plain(levels) => levels[levels.len() - 1].nodes,
            Stored::Packed { levels, .. } => levels[levels.len() - 1].nodes(),
        })?;
        Ok(Self {
            resolution,
            root,
            light,
            masks,
            mask_count,
            stored,
        })
    }

    /// The numbers of the head as they stand in a file, but for the checksum.
    pub(crate) fn write(&self) -> Vec<u8> {
        let head = Head {
            form: match self.stored {
                Stored::Plain(_) => form::PLAIN,
                Stored::Packed { .. } => form::PACKED,
            },
            resolution: self.resolution,
            root: self.root,
            light: self.light,
            mask_count: self.mask_count,
        };
        let mut head = head.write();
        let mut put = |number: u32| head.extend(number.to_le_bytes());
        match &self.stored {
            Stored::Plain(levels) => {
                for level in levels {
                    put(level.nodes);
                    put(level.words);
                }
            }
            Stored::Packed { shapes, levels } => {
                put(shapes[0].1);
                put(shapes[1].1);
                for level in levels {
                    level.counts.into_iter().for_each(&mut put);
                    put(level.shape_width);
                    put(level.width);
                }
            }
        }
        head
    }
}

fn read_plain(
    bytes: &[u8],
    place: &mut Place,
    levels: usize,
    masks: u32,
) -> Result<(usize, Stored), FileError> {
    let table = place.take(levels as u64, 8)?;
    let masks = place.take(u64::from(masks), 8)?;
    let mut found = Vec::with_capacity(levels);
    for level in 0..levels {
        let nodes = load_u32(bytes, table + 8 * level);
        let words = load_u32(bytes, table + 8 * level + 4);
        found.push(PlainLevel {
            start: place.take(u64::from(words), 4)?,
            nodes,
            words,
        });
    }
    Ok((masks, Stored::Plain(found)))
}

fn read_packed(
    bytes: &[u8],
    place: &mut Place,
    levels: usize,
    masks: u32,
) -> Result<(usize, Stored), FileError> {
    let shape_counts = place.take(2, 4)?;
    let shape_counts = [0, 4].map(|at| load_u32(bytes, shape_counts + at));
    let table = place.take(levels as u64, 44)?;
    let masks = place.take(u64::from(masks), 8)?;
    let mut shapes = [(0, 0); 2];
    for (shapes, count) in shapes.iter_mut().zip(shape_counts) {
        *shapes = (place.take(u64::from(count), 4)?, count);
    }
    let mut found = Vec::with_capacity(levels);
    for number in 0..levels {
        let word = |i: usize| load_u32(bytes, table + 44 * number + 4 * i);
        let counts = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(word);
        let (shape_width, width) = (word(9), word(10));
        let level = (shape_width <= 32 && width <= 32)
            .then(|| PackedLevel::new(counts, shape_width, width, place.at as usize))
            .flatten()
            .ok_or(FileError::Level {
                level: number as u32,
            })?;
        place.take((level.end - level.start) as u64, 1)?;
        found.push(level);
    }
    place.take(BIT_PADDING as u64, 1)?;
    let levels = found;
    Ok((masks, Stored::Packed { shapes, levels }))
}

fn load_f64(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(load_u64(bytes, at))
}

fn read_light(bytes: &[u8]) -> Result<Option<LightSpace>, FileError> {
    let bad = |_| FileError::Light;
    let matrix: [f64; 16] = std::array::from_fn(|i| load_f64(bytes, 40 + 8 * i));
    let slices = match load_u32(bytes, 32) {
        0 => return Ok(None),
        1 => Slices::Linear,
        2 => Slices::logarithmic(load_f64(bytes, 168), load_f64(bytes, 176)).map_err(bad)?,
        kind => {
            return Err(FileError::Header {
                what: "the kind of the light",
                value: u64::from(kind),
            });
        }
    };
    LightSpace::new(glam::DMat4::from_cols_array(&matrix), slices)
        .map(Some)
        .map_err(bad)
}

fn write_light(light: Option<&LightSpace>, head: &mut Vec<u8>) {
    let (kind, ends) = match light.map(LightSpace::slices) {
        None => (0_u32, [0.0; 2]),
        Some(Slices::Linear) => (1, [0.0; 2]),
        Some(Slices::Logarithmic(ends)) => (2, [ends.near(), ends.far()]),
    };
    head.extend(kind.to_le_bytes());
    head.extend([0; 4]);
    let matrix = light.map_or([0.0; 16], |light| light.matrix().to_cols_array());
    for number in matrix.into_iter().chain(ends) {
        head.extend(number.to_le_bytes());
    }
}
