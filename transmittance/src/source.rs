//! Where the blockers of a map come from.

use gpu_backend::{Backend, Buffer, Host, Memory};

use crate::error::same_length;
use crate::{BlockerSegment, Error};

/// A part of a map that is made at once: the texels `x` and `y` in these ranges.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tile {
    /// Columns.
    pub x: std::ops::Range<usize>,
    /// Rows.
    pub y: std::ops::Range<usize>,
}

/// Where the blockers of a map come from.
///
/// Closures `|tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment<C>)|` are
/// sources.
pub trait Source<const C: usize = 1>: Sync {
    /// Calls `put` with each segment and the column and row of its texel, always
    /// in the same order. Texels outside of the tile are passed over, so that a
    /// source may hand over more than was asked for.
    fn segments(&self, tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment<C>));
}

impl<F, const C: usize> Source<C> for F
where
    F: Fn(&Tile, &mut dyn FnMut([usize; 2], BlockerSegment<C>)) + Sync,
{
    fn segments(&self, tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment<C>)) {
        self(tile, put);
    }
}

/// Segments that are in memory already, grouped by texel.
#[derive(Debug, Clone, Copy)]
pub struct Lists<'a, const C: usize = 1> {
    width: usize,
    height: usize,
    offsets: &'a [u32],
    segments: &'a [BlockerSegment<C>],
}

impl<'a, const C: usize> Lists<'a, C> {
    /// The segments of texel `x`, `y` are `segments[offsets[i]..offsets[i + 1]]`
    /// with `i = width y + x`, in this order.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there is one offset more than texels,
    /// [`Error::BadOffsets`] if one of them is less than the one before or
    /// beyond the segments.
    pub fn new(
        extent: [usize; 2],
        offsets: &'a [u32],
        segments: &'a [BlockerSegment<C>],
    ) -> Result<Self, Error> {
        let [width, height] = extent;
        let expected = width.saturating_mul(height).saturating_add(1);
        same_length("the list of offsets", expected, offsets.len())?;
        for (texel, pair) in offsets.windows(2).enumerate() {
            let [start, end] = [pair[0], pair[1]];
            if start > end || end as usize > segments.len() {
                return Err(Error::BadOffsets {
                    texel,
                    start,
                    end,
                    available: segments.len(),
                });
            }
        }
        Ok(Self {
            width,
            height,
            offsets,
            segments,
        })
    }
}

impl<const C: usize> Source<C> for Lists<'_, C> {
    fn segments(&self, tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment<C>)) {
        for y in tile.y.clone() {
            for x in tile.x.clone() {
                let texel = y * self.width + x;
                // A map larger than the lists has nothing in its other texels.
                if let Some(&[start, end]) = self
                    .offsets
                    .get(texel..texel + 2)
                    .and_then(|pair| pair.first_chunk())
                    && x < self.width
                {
                    for segment in &self.segments[start as usize..end as usize] {
                        put([x, y], *segment);
                    }
                }
            }
        }
    }
}

impl<const C: usize> Lists<'_, C> {
    /// The same lists on a backend.
    ///
    /// # Errors
    /// [`Error::Backend`] if they do not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<SegmentLists<B::Memory, C>, Error> {
        let lengths = self.offsets.windows(2).map(|pair| pair[1] - pair[0]);
        let longest = lengths.max().unwrap_or(0);
        let mut numbers = Vec::with_capacity(self.segments.len() * (2 + C));
        for segment in self.segments {
            numbers.extend([segment.entry(), segment.exit()]);
            numbers.extend(segment.optical_depth());
        }
        Ok(SegmentLists {
            extent: [self.width, self.height],
            longest,
            offsets: backend.upload(self.offsets)?,
            numbers: backend.upload(&numbers)?,
        })
    }
}

/// Segments grouped by texel in the buffers of a backend.
///
/// A segment is `2 + C` numbers: entry, exit, and the optical depth of each
/// channel.
#[derive(Debug)]
pub struct SegmentLists<M: Memory, const C: usize = 1> {
    extent: [usize; 2],
    longest: u32,
    offsets: M::Buffer<u32>,
    numbers: M::Buffer<f32>,
}

impl<M: Memory, const C: usize> SegmentLists<M, C> {
    /// Lists from buffers of one's own. The segments of texel `i`, counted along
    /// the rows, are those from `offsets[i]` to `offsets[i + 1]`; there is one
    /// offset more than texels, and no texel has more than `longest` segments.
    ///
    /// What the buffers hold is not looked at here. Numbers that make no
    /// [`BlockerSegment`] are left out, offsets that run backwards or beyond the
    /// segments are an empty list. A GPU takes no more than `longest` segments
    /// of a texel; a curve that lacks some has an error bound of 1.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there is one offset more than texels,
    /// and a whole number of segments.
    pub fn from_buffers(
        extent: [usize; 2],
        longest: u32,
        offsets: M::Buffer<u32>,
        numbers: M::Buffer<f32>,
    ) -> Result<Self, Error> {
        let expected = extent[0].saturating_mul(extent[1]).saturating_add(1);
        same_length("the list of offsets", expected, offsets.len())?;
        let whole = numbers.len() / (2 + C) * (2 + C);
        same_length("the numbers of segments", whole, numbers.len())?;
        Ok(Self {
            extent,
            longest,
            offsets,
            numbers,
        })
    }

    /// Columns and rows.
    pub fn extent(&self) -> [usize; 2] {
        self.extent
    }

    /// The largest number of segments that a texel has, as promised: it may be
    /// more than all lists hold.
    pub fn longest(&self) -> u32 {
        self.longest
    }

    /// Where the list of each texel begins, and where the last one ends.
    pub fn offsets(&self) -> &M::Buffer<u32> {
        &self.offsets
    }

    /// All segments, `2 + C` numbers each.
    pub fn numbers(&self) -> &M::Buffer<f32> {
        &self.numbers
    }
}

impl<const C: usize> Source<C> for SegmentLists<Host, C> {
    fn segments(&self, tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment<C>)) {
        let [width, height] = self.extent;
        for y in tile.y.start..tile.y.end.min(height) {
            for x in tile.x.start..tile.x.end.min(width) {
                let texel = y * width + x;
                let ends = [texel, texel + 1].map(|i| self.offsets[i] as usize * (2 + C));
                let list = self.numbers.get(ends[0]..ends[1]).unwrap_or_default();
                for numbers in list.chunks_exact(2 + C) {
                    let optical_depth = std::array::from_fn(|c| numbers[2 + c]);
                    let segment =
                        BlockerSegment::with_optical_depths(numbers[0], numbers[1], optical_depth);
                    if let Ok(segment) = segment {
                        put([x, y], segment);
                    }
                }
            }
        }
    }
}
