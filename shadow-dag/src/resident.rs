//! Shadows in the memory of a backend.

use std::any::TypeId;
use std::sync::Arc;

use gpu_backend::{Backend, Buffer, Host, Memory};

use crate::form::Form;
use crate::layout::{Layout, Stored};
use crate::{Error, ShadowDag};

/// Shadows whose nodes lie in a buffer of a backend, where the steps of
/// [`Query`](crate::Query) and shaders read them. In the memory of the CPU they
/// also answer one question at a time.
///
/// [`ShadowDag::upload`] makes one, [`ShadowDag::upload_all`] several in one
/// buffer. For each of them the buffer holds 32-bit words, little-endian:
///
/// * the file, filled up to whole words;
/// * a table of the levels, from the finest. Plain: the word at which the
///   level begins. Packed: the first node with 0, 1, … 8 references, the bit
///   at which node 0 would begin if all nodes were of that size, modulo 2³²,
///   the bits of the number of a shape and those of a reference. Words and bits
///   are counted from the beginning of the buffer;
/// * the cells of the top grid, cell `(z · 2^log2 + y) · 2^log2 + x`.
///
/// References are those of the file; 2³² − 1 is lit and 2³² − 2 shadowed
/// throughout.
pub type ResidentDag<M> = ShadowDag<Resident<M>>;

/// The bytes of one file of shadows in a buffer that may hold several.
#[derive(Debug)]
pub struct Resident<M: Memory> {
    words: Arc<M::Buffer<u32>>,
    /// The first word of the file.
    first: usize,
    /// Bytes of the file.
    len: usize,
    /// The first word of the table of the levels, and that of the cells.
    levels: usize,
    cells: usize,
    /// Logarithm of the number of cells along each axis.
    top: u32,
}

impl<M: Memory> Clone for Resident<M> {
    fn clone(&self) -> Self {
        Self {
            words: Arc::clone(&self.words),
            ..*self
        }
    }
}

impl AsRef<[u8]> for Resident<Host> {
    fn as_ref(&self) -> &[u8] {
        let bytes: &[u8] = bytemuck::cast_slice(&self.words[self.first..]);
        &bytes[..self.len]
    }
}

/// The words of the error for a graph that is too large.
const WHAT: &str =
    "a graph of shadows, which Form::Packed or half the resolution would make smaller,";

/// The memory that bit addresses of 32 bits reach.
const MOST_BYTES: u64 = 1 << 29;

fn is_host<M: Memory>() -> bool {
    TypeId::of::<M>() == TypeId::of::<Host>()
}

impl Form {
    /// The form in which nodes are walked best in a memory: plain by the CPU,
    /// packed by shaders, whose bindings are limited.
    pub fn suitable<M: Memory>() -> Self {
        if is_host::<M>() {
            Self::Plain
        } else {
            Self::Packed
        }
    }
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// Copies the shadows, with their top grid, into the memory of a backend,
    /// in the form that they have.
    ///
    /// # Errors
    /// [`gpu_backend::Error::TooLarge`] if they take more than 512 MiB on a
    /// GPU, or more than the device can bind at once: 128 MiB if it was made
    /// with the default limits of WebGPU. The packed form takes a fraction of
    /// the plain one.
    pub fn upload<T: Backend>(&self, backend: &T) -> Result<ResidentDag<T::Memory>, Error> {
        let mut all = Self::upload_all(std::slice::from_ref(self), backend)?;
        Ok(all.swap_remove(0))
    }

    /// [`ShadowDag::upload`] of several shadows into one buffer, so that a
    /// shader that asks all of them takes one binding.
    ///
    /// # Errors
    /// As for [`ShadowDag::upload`], of all of them together.
    pub fn upload_all<T: Backend>(
        dags: &[Self],
        backend: &T,
    ) -> Result<Vec<ResidentDag<T::Memory>>, Error> {
        let sizes = |dag: &Self| {
            let file = dag.as_bytes().len().div_ceil(4);
            (file, table_words(&dag.layout), dag.top.cells.len())
        };
        let count: usize = dags
            .iter()
            .map(sizes)
            .map(|(file, table, cells)| file + table + cells)
            .sum();
        if !is_host::<T::Memory>() && 4 * count as u64 > MOST_BYTES {
            return Err(Error::Backend(gpu_backend::Error::TooLarge {
                what: WHAT,
                requested: 4 * count as u64,
                limit: MOST_BYTES,
            }));
        }
        let mut words = vec![0_u32; count];
        let mut first = 0;
        let places: Vec<_> = (dags.iter())
            .map(|dag| {
                let bytes = dag.as_bytes();
                let (file, table_words, cells_words) = sizes(dag);
                let (levels, cells) = (first + file, first + file + table_words);
                bytemuck::cast_slice_mut(&mut words[first..levels])[..bytes.len()]
                    .copy_from_slice(bytes);
                let rest = (table(&dag.layout, first).into_iter())
                    .chain(dag.top.cells.iter().copied())
                    .map(u32::to_le);
                for (word, value) in words[levels..].iter_mut().zip(rest) {
                    *word = value;
                }
                let place = (first, bytes.len(), levels, cells);
                first = cells + cells_words;
                place
            })
            .collect();
        let words = backend.upload(&words).map_err(|error| match error {
            gpu_backend::Error::TooLarge {
                requested, limit, ..
            } => gpu_backend::Error::TooLarge {
                what: WHAT,
                requested,
                limit,
            },
            other => other,
        })?;
        let words = Arc::new(words);
        let resident = |(dag, (first, len, levels, cells)): (&Self, _)| {
            let bytes = Resident {
                words: Arc::clone(&words),
                first,
                len,
                levels,
                cells,
                top: dag.top.log2,
            };
            ShadowDag::from_parts(bytes, Arc::clone(&dag.layout), Arc::clone(&dag.top))
        };
        Ok(dags.iter().zip(places).map(resident).collect())
    }
}

/// Words of [`table`].
fn table_words(layout: &Layout) -> usize {
    match &layout.stored {
        Stored::Plain(levels) => levels.len(),
        Stored::Packed { levels, .. } => 20 * levels.len(),
    }
}

/// The table of levels for shaders, of a file that begins at word `first`.
fn table(layout: &Layout, first: usize) -> Vec<u32> {
    match &layout.stored {
        Stored::Plain(levels) => (levels.iter())
            .map(|level| (first + level.start / 4) as u32)
            .collect(),
        Stored::Packed { levels, .. } => (levels.iter())
            .flat_map(|level| {
                let before = 32 * first as u64;
                let offsets = level.offsets.map(|bit| bit.wrapping_add(before) as u32);
                let widths = [level.shape_width, level.width];
                level.firsts.into_iter().chain(offsets).chain(widths)
            })
            .collect(),
    }
}

impl<M: Memory> ShadowDag<Resident<M>> {
    /// The words of the buffer, for bindings of one's own.
    pub fn words(&self) -> &M::Buffer<u32> {
        &self.bytes.words
    }

    /// The word at which the file begins.
    pub fn first_word(&self) -> usize {
        self.bytes.first
    }

    /// The word at which the table of the levels begins.
    pub fn level_words(&self) -> usize {
        self.bytes.levels
    }

    /// The word at which the cells of the top grid begin, and the logarithm of
    /// their number along each axis.
    pub fn cell_words(&self) -> (usize, u32) {
        (self.bytes.cells, self.bytes.top)
    }

    /// Bytes of the buffer, with what it holds beside these shadows.
    pub fn buffer_bytes(&self) -> u64 {
        4 * self.words().len() as u64
    }
}
