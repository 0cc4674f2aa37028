//! Maps of curves, one per texel.
//!
//! Based on the software pipeline of M. Salvi, K. Vidimče, A. Lauritzen,
//! A. Lefohn, "Adaptive Volumetric Shadow Maps", Eurographics Symposium on
//! Rendering 2010: the map is divided into tiles; each tile goes through the
//! blockers that may touch it in their own order, and every texel keeps one
//! curve of fixed size. Memory does not depend on the number of blockers, and
//! the result depends neither on the number of threads nor on chance.

use gpu_backend::Cpu;

use crate::error::same_length;
use crate::filter::filtered;
use crate::{Accumulate, Error, Evaluate, Filter, Receiver, Source, Tile};

/// Texels along each side of a tile.
const TILE: usize = 16;

/// Curves of any kind, one per texel of a light's view, in `C` channels, in
/// ordinary memory: baselines, whose size is not fixed, are among them. Curves of
/// fixed size go to a backend by [`CurveMap::upload`].
///
/// ```
/// use gpu_backend::Cpu;
/// use transmittance::{Filter, Packed, Receiver, BlockerSegment, CurveMap, Stream, Tile};
///
/// // Fog that is thicker to the right.
/// let fog = |tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)| {
///     for y in tile.y.clone() {
///         for x in tile.x.clone() {
///             let segment = BlockerSegment::from_density(1.0, 3.0, 0.1 * x as f32);
///             put([x, y], segment.expect("finite numbers"));
///         }
///     }
/// };
/// let map = CurveMap::<Packed<8>>::build(&Cpu::new(), [64, 32], &Stream::<8>::new(), &fog)?;
/// let receiver = Receiver { position: [11.0, 5.5], depth: 2.0 };
/// let transmittance = map.transmittance(receiver, Filter::Bilinear)[0];
/// assert!((transmittance - 0.5 * ((-1.0_f32).exp() + (-1.1_f32).exp())).abs() < 1e-6);
/// # Ok::<(), transmittance::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CurveMap<T, const C: usize = 1> {
    width: usize,
    height: usize,
    texels: Vec<T>,
}

impl<T: Evaluate<C> + Send, const C: usize> CurveMap<T, C> {
    /// Makes a map of `[width, height]` texels. Each texel starts as a copy of
    /// `clear`, takes the source's segments, and is stored as a `T`: the curve
    /// itself, or a packed form of it.
    ///
    /// A map without texels is legal; nothing is in the way anywhere.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if there is no memory for the map.
    pub fn build<A, S>(cpu: &Cpu, extent: [usize; 2], clear: &A, source: &S) -> Result<Self, Error>
    where
        A: Accumulate<C> + Clone + Sync,
        A::Curve: Into<T>,
        S: Source<C> + ?Sized,
    {
        let [width, height] = extent;
        let too_large = || Error::TooLarge {
            width,
            height,
            requested: (width as u64)
                .saturating_mul(height as u64)
                .saturating_mul(size_of::<T>() as u64),
        };
        let count = width.checked_mul(height).ok_or_else(too_large)?;
        let mut texels = Vec::new();
        texels.try_reserve_exact(count).map_err(|_| too_large())?;
        if count == 0 {
            return Ok(Self {
                width,
                height,
                texels,
            });
        }
        // A few rows of tiles at a time: enough tiles to keep threads busy,
        // while little is held twice when their texels are put in order.
        const AT_ONCE: usize = 512;
        let columns = width.div_ceil(TILE);
        let rows = height.div_ceil(TILE);
        let rows_at_once = (AT_ONCE / columns).max(1);
        for first in (0..rows).step_by(rows_at_once) {
            let rows = first..rows.min(first + rows_at_once);
            let tile = |index: usize| Tile {
                x: part(index % columns, width),
                y: part(first + index / columns, height),
            };
            let made = cpu.map(rows.len() * columns, |index| {
                make::<T, C, A, S>(&tile(index), clear, source)
            });
            let mut made: Vec<_> = made.into_iter().map(Vec::into_iter).collect();
            for (row, tiles) in made.chunks_mut(columns).enumerate() {
                for _ in part(first + row, height) {
                    for (column, tile) in tiles.iter_mut().enumerate() {
                        texels.extend(tile.by_ref().take(part(column, width).len()));
                    }
                }
            }
        }
        Ok(Self {
            width,
            height,
            texels,
        })
    }
}

/// The texels of the tile of this number, along a side of `len` texels.
fn part(tile: usize, len: usize) -> std::ops::Range<usize> {
    tile * TILE..len.min((tile + 1) * TILE)
}

/// The texels of a tile, row by row.
fn make<T, const C: usize, A, S>(tile: &Tile, clear: &A, source: &S) -> Vec<T>
where
    A: Accumulate<C> + Clone,
    A::Curve: Into<T>,
    S: Source<C> + ?Sized,
{
    let mut curves = vec![clear.clone(); tile.x.len() * tile.y.len()];
    source.segments(tile, &mut |[x, y], segment| {
        if tile.x.contains(&x) && tile.y.contains(&y) {
            curves[(y - tile.y.start) * tile.x.len() + (x - tile.x.start)].insert(&segment);
        }
    });
    curves
        .into_iter()
        .map(|curve| curve.finish().into())
        .collect()
}

impl<T, const C: usize> CurveMap<T, C> {
    /// Texels along a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The texels, row by row.
    #[must_use]
    pub fn texels(&self) -> &[T] {
        &self.texels
    }
}

impl<T: Evaluate<C>, const C: usize> CurveMap<T, C> {
    /// Share of the light that gets to a receiver, per channel. The error of a
    /// filtered result is at most that of the worst of its texels, and 4
    /// roundings; of a [`Filter::Square`] of k texels per side, 2 k + 6.
    #[must_use]
    pub fn transmittance(&self, receiver: Receiver, filter: Filter) -> [f32; C] {
        let texel = |index: usize| self.texels[index].evaluate(receiver.depth);
        filtered([self.width, self.height], receiver.position, filter, texel)
    }

    /// [`CurveMap::transmittance`] for many receivers, on all threads.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there is one result per receiver.
    pub fn transmittances(
        &self,
        cpu: &Cpu,
        receivers: &[Receiver],
        filter: Filter,
        out: &mut [[f32; C]],
    ) -> Result<(), Error>
    where
        T: Sync,
    {
        same_length("the list of results", receivers.len(), out.len())?;
        cpu.for_each_chunk(out, 1024, |first, chunk| {
            for (out, receiver) in chunk.iter_mut().zip(&receivers[first..]) {
                *out = self.transmittance(*receiver, filter);
            }
        });
        Ok(())
    }
}
