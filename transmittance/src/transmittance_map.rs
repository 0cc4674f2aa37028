//! Maps of stored curves in the buffers of any backend.

use std::marker::PhantomData;

use gpu_backend::{Backend, BufferOf, Cpu, Download, Host, Memory};

use crate::error::{does_not_fit, same_length};
use crate::filter::filtered;
use crate::{Accumulate, CurveMap, Error, Filter, Packed, Receiver, Source, Stored};

/// Curves stored as `P`, one per texel of a light's view, in the memory `M` of a
/// backend. Several faces of one width may lie below each other.
///
/// `P` is [`Packed`](crate::Packed) for lookups alone,
/// [`PackedHalf`](crate::PackedHalf) for less memory, or
/// [`Curve`](crate::Curve) with error bounds. The words of the texels follow
/// each other row by row, as [`Stored`] has them.
///
/// ```
/// use gpu_backend::{Backend, Cpu, Download};
/// use transmittance::{
///     BuildMap, TransmittanceMap, Error, Filter, Lists, Packed, QueryMap, Receiver, BlockerSegment,
///     SegmentLists, Stream,
/// };
///
/// // Written once for all backends.
/// fn behind<B>(backend: &B) -> Result<Vec<f32>, Error>
/// where
///     B: Download + QueryMap<Packed<8>>,
///     B: BuildMap<Stream<8>, SegmentLists<<B as Backend>::Memory>, Packed<8>>,
/// {
///     // Smoke and a leaf in the first texel, nothing in the second.
///     let segments = [BlockerSegment::from_density(1.0, 3.0, 0.5)?, BlockerSegment::surface(2.0, 0.25)?];
///     let lists = Lists::new([2, 1], &[0, 2, 2], &segments)?.upload(backend)?;
///     let mut map = TransmittanceMap::new(backend, [2, 1])?;
///     backend.build_map(&Stream::new(), &lists, &mut map)?;
///
///     let receiver = |x| Receiver { position: [x, 0.5], depth: 4.0 };
///     let receivers = backend.upload(&[0.5, 1.0, 1.5].map(receiver))?;
///     let mut transmittances = backend.zeros(3)?;
///     backend.query_map(&map, &receivers, Filter::Bilinear, &mut transmittances)?;
///     Ok(backend.download(&transmittances)?)
/// }
///
/// let exact = 0.25 * (-1.0_f32).exp();
/// let found = behind(&Cpu::new())?;
/// for (found, expected) in found.iter().zip([exact, 0.5 * (exact + 1.0), 1.0]) {
///     assert!((found - expected).abs() < 1e-6);
/// }
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct TransmittanceMap<M: Memory, P = Packed<8>, const C: usize = 1> {
    extent: [usize; 2],
    words: M::Buffer<u32>,
    stored: PhantomData<P>,
}

impl<M: Memory, P: Stored<C>, const C: usize> TransmittanceMap<M, P, C> {
    /// A map of `[width, height]` texels without blockers. A map without texels
    /// is legal.
    ///
    /// # Errors
    /// [`Error::DoesNotFit`] if it does not fit on the backend, with a size that does;
    /// [`Error::TooLarge`] if it fits nowhere.
    pub fn new<B: Backend<Memory = M>>(backend: &B, extent: [usize; 2]) -> Result<Self, Error> {
        let too_large = || Error::TooLarge {
            width: extent[0],
            height: extent[1],
            requested: (extent[0] as u64)
                .saturating_mul(extent[1] as u64)
                .saturating_mul(4 * P::WORDS as u64),
        };
        let len = extent[0]
            .checked_mul(extent[1])
            .and_then(|texels| texels.checked_mul(P::WORDS))
            .ok_or_else(too_large)?;
        let mut clear = vec![0; P::WORDS];
        P::clear().write(&mut clear);
        let named = does_not_fit(extent, 4 * P::WORDS);
        let words = if clear.iter().all(|word| *word == 0) {
            backend.zeros(len).map_err(named)?
        } else {
            let mut words = Vec::new();
            words.try_reserve_exact(len).map_err(|_| too_large())?;
            words.extend(clear.iter().copied().cycle().take(len));
            backend.upload(&words).map_err(named)?
        };
        Ok(Self {
            extent,
            words,
            stored: PhantomData,
        })
    }

    /// The curves of several maps in one row, one map after the other, each row by row: texel
    /// `(x, y)` of a map of `width` columns is at `x + width × y` behind those of the maps before.
    ///
    /// # Errors
    /// [`Error::Backend`] if they do not fit on the backend.
    pub fn in_one_row<B: Backend<Memory = M>>(
        backend: &B,
        maps: &[CurveMap<P, C>],
    ) -> Result<Self, Error> {
        let count = maps.iter().map(|map| map.texels().len()).sum::<usize>();
        let mut words = vec![0; count * P::WORDS];
        let curves = maps.iter().flat_map(CurveMap::texels);
        for (curve, words) in curves.zip(words.chunks_exact_mut(P::WORDS)) {
            curve.write(words);
        }
        Ok(Self {
            extent: [count, usize::from(count > 0)],
            words: backend.upload(&words)?,
            stored: PhantomData,
        })
    }

    /// Columns and rows.
    pub fn extent(&self) -> [usize; 2] {
        self.extent
    }

    /// All words.
    pub fn words(&self) -> &M::Buffer<u32> {
        &self.words
    }

    #[cfg(feature = "wgpu")]
    pub(crate) fn words_mut(&mut self) -> &mut M::Buffer<u32> {
        &mut self.words
    }

    /// The same map in ordinary memory.
    ///
    /// # Errors
    /// Any error of the work that is still outstanding on the backend.
    pub fn download<B: Download<Memory = M>>(
        &self,
        backend: &B,
    ) -> Result<TransmittanceMap<Host, P, C>, Error> {
        Ok(TransmittanceMap {
            extent: self.extent,
            words: backend.download(&self.words)?,
            stored: PhantomData,
        })
    }
}

impl<P: Stored<C>, const C: usize> TransmittanceMap<Host, P, C> {
    /// The curve of column `x` and row `y`.
    ///
    /// # Panics
    /// If there is no such texel.
    pub fn texel(&self, x: usize, y: usize) -> P {
        let [width, height] = self.extent;
        assert!(x < width && y < height, "no such texel");
        self.curve(y * width + x)
    }

    fn curve(&self, texel: usize) -> P {
        P::read(&self.words[texel * P::WORDS..(texel + 1) * P::WORDS])
    }

    /// [`CurveMap::transmittance`] of the same curves.
    #[must_use]
    pub fn transmittance(&self, receiver: Receiver, filter: Filter) -> [f32; C] {
        let texel = |texel: usize| self.curve(texel).evaluate(receiver.depth);
        filtered(self.extent, receiver.position, filter, texel)
    }

    /// The same map on another backend.
    ///
    /// # Errors
    /// [`Error::Backend`] if it does not fit there.
    pub fn upload<B: Backend>(
        &self,
        backend: &B,
    ) -> Result<TransmittanceMap<B::Memory, P, C>, Error> {
        Ok(TransmittanceMap {
            extent: self.extent,
            words: backend.upload(&self.words)?,
            stored: PhantomData,
        })
    }
}

impl<T: Stored<C>, const C: usize> CurveMap<T, C> {
    /// The same curves in the memory of a backend.
    ///
    /// # Errors
    /// [`Error::Backend`] if they do not fit there.
    pub fn upload<B: Backend>(
        &self,
        backend: &B,
    ) -> Result<TransmittanceMap<B::Memory, T, C>, Error> {
        let row = TransmittanceMap::in_one_row(backend, std::slice::from_ref(self))?;
        Ok(TransmittanceMap {
            extent: [self.width(), self.height()],
            ..row
        })
    }
}

/// Makes the curves of a map from a source of type `S` by the rule of `A`:
/// [`Curve`](crate::Curve) for the paper's, or [`Stream`](crate::Stream).
///
/// On the CPU any [`Source`] is one and every [`Accumulate`] is a rule. On every
/// backend [`SegmentLists`](crate::SegmentLists) is one.
pub trait BuildMap<A, S: ?Sized, P, const C: usize = 1>: Backend {
    /// Gives every texel the curve of its segments, taken in their order. `clear`
    /// is what each starts from. Texels that the source does not have are clear.
    ///
    /// # Errors
    /// Errors of the backend.
    fn build_map(
        &self,
        clear: &A,
        source: &S,
        map: &mut TransmittanceMap<Self::Memory, P, C>,
    ) -> Result<(), Error>;
}

impl<A, S, P, const C: usize> BuildMap<A, S, P, C> for Cpu
where
    A: Accumulate<C> + Clone + Sync,
    A::Curve: Into<P>,
    S: Source<C> + ?Sized,
    P: Stored<C>,
{
    fn build_map(
        &self,
        clear: &A,
        source: &S,
        map: &mut TransmittanceMap<Host, P, C>,
    ) -> Result<(), Error> {
        let made = CurveMap::<P, C>::build(self, map.extent, clear, source)?;
        self.for_each_chunk(&mut map.words, 256 * P::WORDS, |first, words| {
            let texels = &made.texels()[first / P::WORDS..];
            for (words, texel) in words.chunks_exact_mut(P::WORDS).zip(texels) {
                texel.write(words);
            }
        });
        Ok(())
    }
}

/// Answers many receivers of a map of curves stored as `P`.
pub trait QueryMap<P, const C: usize = 1>: Backend {
    /// [`CurveMap::transmittance`] of each receiver: `C` numbers each.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there are `C` results per receiver; errors
    /// of the backend.
    fn query_map(
        &self,
        map: &TransmittanceMap<Self::Memory, P, C>,
        receivers: &BufferOf<Self, Receiver>,
        filter: Filter,
        transmittances: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;
}

/// Returns an error unless there is room for the answers of a batch of questions.
pub(crate) fn room_for_answers<const C: usize>(
    receivers: usize,
    results: usize,
) -> Result<(), Error> {
    same_length("the list of results", receivers.saturating_mul(C), results)
}

impl<P: Stored<C>, const C: usize> QueryMap<P, C> for Cpu {
    fn query_map(
        &self,
        map: &TransmittanceMap<Host, P, C>,
        receivers: &Vec<Receiver>,
        filter: Filter,
        transmittances: &mut Vec<f32>,
    ) -> Result<(), Error> {
        room_for_answers::<C>(receivers.len(), transmittances.len())?;
        self.for_each_chunk(transmittances, 1024 * C, |first, chunk| {
            let receivers = &receivers[first / C..];
            for (out, receiver) in chunk.chunks_exact_mut(C).zip(receivers) {
                out.copy_from_slice(&map.transmittance(*receiver, filter));
            }
        });
        Ok(())
    }
}
