//! Segments that come in any order, put into lists by texel.

use gpu_backend::{Backend, BufferOf, Cpu, Host};

use crate::error::same_length;
use crate::{Error, SegmentLists};

/// How the segments of a texel follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// As they were captured.
    #[default]
    Captured,
    /// By entry, then exit, then optical depth, so that any order of the same
    /// segments gives the same curve; what [`Sorted`](crate::Sorted) does.
    FrontToBack,
}

/// Puts captured segments into lists: the other way to make a map, with memory in
/// proportion to the number of segments. In shaders `gpu::build_from_candidates` makes them
/// where they are met, and needs none.
///
/// A renderer that rasterises blockers in any order appends each fragment's
/// segment and texel to two buffers, captures all of them, and compresses the
/// lists with [`BuildMap`](crate::BuildMap).
pub trait CaptureSegments<const C: usize = 1>: Backend {
    /// The lists of a map of `extent` texels. BlockerSegment `i`, of `2 + C` numbers (see
    /// [`SegmentLists`]), is one of texel `texels[i]`, counted along the rows;
    /// those of texels that the map does not have are left out, so that places
    /// that nobody wrote may be marked by [`u32::MAX`]. No texel may have more
    /// than `longest` segments, as in [`SegmentLists::from_buffers`].
    ///
    /// The result does not depend on chance. The work is in proportion to the
    /// number of segments, and to the number of their bits that decide.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there are `2 + C` numbers per texel of the
    /// list, [`Error::TooLarge`] for maps of 2³² texels and more, errors of the
    /// backend.
    fn capture_segments(
        &self,
        extent: [usize; 2],
        texels: &BufferOf<Self, u32>,
        numbers: &BufferOf<Self, f32>,
        longest: u32,
        order: Order,
    ) -> Result<SegmentLists<Self::Memory, C>, Error>;
}

/// The number of texels, if the lengths are right.
pub(crate) fn check<const C: usize>(
    extent: [usize; 2],
    segments: usize,
    numbers: usize,
) -> Result<u32, Error> {
    let expected = segments.saturating_mul(2 + C);
    same_length("the numbers of captured segments", expected, numbers)?;
    let texels = (extent[0] as u64).saturating_mul(extent[1] as u64);
    match u32::try_from(texels) {
        Ok(texels) if texels < u32::MAX => Ok(texels),
        _ => Err(Error::TooLarge {
            width: extent[0],
            height: extent[1],
            requested: texels.saturating_mul(4),
        }),
    }
}

impl<const C: usize> CaptureSegments<C> for Cpu {
    fn capture_segments(
        &self,
        extent: [usize; 2],
        texels: &Vec<u32>,
        numbers: &Vec<f32>,
        longest: u32,
        order: Order,
    ) -> Result<SegmentLists<Host, C>, Error> {
        let count = check::<C>(extent, texels.len(), numbers.len())?;
        let mut offsets = self.zeros::<u32>(count as usize + 1)?;
        for &texel in texels.iter().filter(|texel| **texel < count) {
            offsets[texel as usize + 1] += 1;
        }
        let mut sum = 0;
        for offset in &mut offsets {
            sum += *offset;
            *offset = sum;
        }
        let mut next = offsets.clone();
        let mut lists = self.zeros::<f32>(sum as usize * (2 + C))?;
        for (&texel, segment) in texels.iter().zip(numbers.chunks_exact(2 + C)) {
            if texel < count {
                let place = next[texel as usize] as usize * (2 + C);
                lists[place..place + 2 + C].copy_from_slice(segment);
                next[texel as usize] += 1;
            }
        }
        if order == Order::FrontToBack {
            let mut rest = &mut lists[..];
            let mut each = Vec::with_capacity(count as usize);
            for pair in offsets.windows(2) {
                let (list, behind) = rest.split_at_mut((pair[1] - pair[0]) as usize * (2 + C));
                each.push(list);
                rest = behind;
            }
            self.for_each_chunk(&mut each, 256, |_, lists| {
                for list in lists {
                    let mut segments: Vec<_> = list.chunks_exact(2 + C).collect();
                    segments.sort_by(|a, b| {
                        let pairs = a.iter().zip(*b);
                        pairs.fold(std::cmp::Ordering::Equal, |order, (a, b)| {
                            order.then(a.total_cmp(b))
                        })
                    });
                    let sorted = segments.concat();
                    list.copy_from_slice(&sorted);
                }
            });
        }
        SegmentLists::from_buffers(extent, longest, offsets, lists)
    }
}
