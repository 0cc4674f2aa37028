//! Shadows in the memory of a backend.

use std::sync::Arc;

use gpu_backend::{Backend, Host, Memory};

use crate::layout::{Layout, Stored};
use crate::top::Top;
use crate::{Error, Form, LightSpace, Resolution, ShadowDag};

/// Shadows whose nodes lie in a buffer of a backend, where the steps of
/// [`Query`](crate::Query) and shaders read them.
///
/// The buffer holds 32-bit words, little-endian:
///
/// * the file, filled up to whole words;
/// * a table of the levels, from the finest. Plain: the word at which the
///   level begins. Packed: the first node with 0, 1, … 8 references, the bit
///   at which node 0 would begin if all nodes were of that size, modulo 2³²,
///   the bits of the number of a shape and those of a reference;
/// * the cells of the top grid, cell `(z · 2^log2 + y) · 2^log2 + x`.
///
/// References are those of the file; 2³² − 1 is lit and 2³² − 2 shadowed
/// throughout.
#[derive(Debug)]
pub struct ResidentDag<M: Memory> {
    words: M::Buffer<u32>,
    /// Bytes of the file.
    pub(crate) len: usize,
    pub(crate) layout: Arc<Layout>,
    pub(crate) top: Arc<Top>,
}

/// What bit addresses of 32 bits reach.
const MOST_BYTES: u64 = 1 << 29;

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// Copies the shadows, with their top grid, into the memory of a backend.
    ///
    /// # Errors
    /// [`gpu_backend::Error::TooLarge`] if they take more than 512 MiB, or
    /// more than the device can bind at once: 128 MiB if it was made with the
    /// default limits of WebGPU. The packed form takes a fraction of the
    /// plain one.
    pub fn upload<T: Backend>(&self, backend: &T) -> Result<ResidentDag<T::Memory>, Error> {
        let file = self.as_bytes();
        let levels = file.len().div_ceil(4);
        let table = table(&self.layout);
        let words = levels + table.len() + self.top.cells.len();
        if 4 * words as u64 > MOST_BYTES {
            return Err(Error::Backend(gpu_backend::Error::TooLarge {
                what: "a graph of shadows",
                requested: 4 * words as u64,
                limit: MOST_BYTES,
            }));
        }
        let mut words = vec![0_u32; words];
        bytemuck::cast_slice_mut(&mut words)[..file.len()].copy_from_slice(file);
        let rest = table.iter().chain(&self.top.cells);
        for (word, value) in words[levels..].iter_mut().zip(rest) {
            *word = value.to_le();
        }
        Ok(ResidentDag {
            words: backend.upload(&words)?,
            len: file.len(),
            layout: Arc::clone(&self.layout),
            top: Arc::clone(&self.top),
        })
    }
}

/// What shaders need to know of the levels.
fn table(layout: &Layout) -> Vec<u32> {
    match &layout.stored {
        Stored::Plain(levels) => (levels.iter())
            .map(|level| (level.start / 4) as u32)
            .collect(),
        Stored::Packed { levels, .. } => (levels.iter())
            .flat_map(|level| {
                let offsets = level.offsets.map(|bit| bit as u32);
                let widths = [level.shape_width, level.width];
                level.firsts.into_iter().chain(offsets).chain(widths)
            })
            .collect(),
    }
}

impl<M: Memory> ResidentDag<M> {
    /// Voxels along each axis.
    pub fn resolution(&self) -> Resolution {
        self.layout.resolution
    }

    /// Where in the grid a point of the world is, if that is known.
    pub fn light(&self) -> Option<&LightSpace> {
        self.layout.light.as_ref()
    }

    /// How the nodes are stored.
    pub fn form(&self) -> Form {
        self.layout.form()
    }

    /// The words, for bindings of one's own.
    pub fn words(&self) -> &M::Buffer<u32> {
        &self.words
    }
}

impl ResidentDag<Host> {
    /// The shadows, to ask one question at a time.
    pub fn dag(&self) -> ShadowDag<&[u8]> {
        let bytes: &[u8] = bytemuck::cast_slice(&self.words);
        ShadowDag::from_parts(
            &bytes[..self.len],
            Arc::clone(&self.layout),
            Arc::clone(&self.top),
        )
    }
}
