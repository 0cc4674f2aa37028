//! What loops over batches have in common.
//!
//! A batch is worked off in blocks of [`LANES`] segments. Within a block every
//! step is a loop over arrays that the compiler turns into vector
//! instructions, compiled for AVX-512, for AVX2 and for what every processor has,
//! and chosen when the program runs. No step fuses a multiplication with an addition, so
//! that all levels give the same bits, and for [`Table`](crate::Table) and
//! [`SunTable`](crate::SunTable) those of a segment by itself.

use std::f32::consts::LN_2;
use std::ops::Range;
use std::sync::LazyLock;

use pulp::{Arch, Simd, WithSimd};

use crate::Segment;

/// Segments in a block: a few vectors of any processor, so that the loops of
/// a block overlap, and little enough for the first-level cache.
pub(crate) const LANES: usize = 64;

/// One value for each segment of a block, on a cache line of its own.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Lanes<T>(pub(crate) [T; LANES]);

impl<T: Copy + Default> Default for Lanes<T> {
    fn default() -> Self {
        Self([T::default(); LANES])
    }
}

/// The airlight of blocks of segments.
pub(crate) trait Kernel {
    /// Memory for intermediate values. What a block leaves there does not matter; it is
    /// kept so that it need not be cleared for each block.
    type Scratch: Default;

    /// The airlight of a block. Must be `#[inline(always)]`, or it is not
    /// compiled for the instruction set it runs on.
    fn block(
        &self,
        scratch: &mut Self::Scratch,
        segments: &[Segment; LANES],
        airlight: &mut [f32; LANES],
    );

    /// Work that is better done for many blocks together. It is called after each block
    /// with all segments and results and the range that the block has `done`, and once
    /// more at the end with an empty range. Must be `#[inline(always)]` too.
    #[inline(always)]
    fn behind(
        &self,
        _: &mut Self::Scratch,
        _segments: &[Segment],
        _airlight: &mut [f32],
        _done: Range<usize>,
    ) {
    }
}

/// The airlight of a batch, with the best instructions there are.
///
/// # Panics
/// If the slices differ in length.
pub(crate) fn batch<K: Kernel>(kernel: &K, segments: &[Segment], airlight: &mut [f32]) {
    batch_on(arch(), kernel, segments, airlight);
}

/// The best instructions that this processor has, detected once.
pub(crate) fn arch() -> Arch {
    static ARCH: LazyLock<Arch> = LazyLock::new(Arch::new);
    *ARCH
}

/// All levels of instructions that this processor has.
#[cfg(test)]
pub(crate) fn every_arch() -> Vec<Arch> {
    let mut all = vec![Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        all.extend(pulp::x86::V3::try_new().map(Arch::V3));
        all.extend(pulp::x86::V4::try_new().map(Arch::V4));
    }
    all
}

/// The same with these instructions.
pub(crate) fn batch_on<K: Kernel>(
    arch: Arch,
    kernel: &K,
    segments: &[Segment],
    airlight: &mut [f32],
) {
    assert_eq!(segments.len(), airlight.len(), "one result per segment");
    arch.dispatch(Batch {
        kernel,
        segments,
        airlight,
    });
}

struct Batch<'a, K> {
    kernel: &'a K,
    segments: &'a [Segment],
    airlight: &'a mut [f32],
}

impl<K: Kernel> WithSimd for Batch<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            kernel,
            segments,
            airlight,
        } = self;
        let mut scratch = K::Scratch::default();
        let mut done = 0;
        let (blocks, rest) = segments.as_chunks::<LANES>();
        for block in blocks {
            if let Some(airlight) = airlight[done..].first_chunk_mut() {
                kernel.block(&mut scratch, block, airlight);
            }
            let first = done;
            done += LANES;
            kernel.behind(&mut scratch, segments, airlight, first..done);
        }
        if !rest.is_empty() {
            let mut block = [Segment::default(); LANES];
            block[..rest.len()].copy_from_slice(rest);
            let mut last = [0.0; LANES];
            kernel.block(&mut scratch, &block, &mut last);
            airlight[done..].copy_from_slice(&last[..rest.len()]);
            kernel.behind(&mut scratch, segments, airlight, done..segments.len());
        }
        kernel.behind(&mut scratch, segments, airlight, 0..0);
    }
}

/// `1.5 · 2^23`: the sum with a number between -2^22 and 2^22 has that number,
/// rounded to an integer, in its lowest bits.
pub(crate) const ROUND: f32 = 12_582_912.0;

/// `2^x` for x up to 127, with a relative error of at most 3e-7; 0 where the result is
/// below `2^-100`, and for NaN. (Arithmetic with subnormal numbers is a hundred times
/// slower.)
///
/// The polynomial interpolates `2^f` in the Chebyshev nodes of
/// `-1/2 ≤ f ≤ 1/2`, to 1.1e-7.
#[inline(always)]
pub(crate) fn exp2(x: f32) -> f32 {
    let rounded = x + ROUND;
    let f = x - (rounded - ROUND);
    let power = 1.000_000_1
        + f * (LN_2
            + f * (0.240_221_07 + f * (0.055_503_57 + f * (0.009_676_032 + f * 0.001_339_086_3))));
    let power = f32::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 23));
    if x > -100.0 { power } else { 0.0 }
}

/// `e^x` for x up to 0, with a relative error of at most 3e-16; 0 for x below -700, and
/// for NaN.
///
/// The rest of x beside a multiple of ln 2 is up to `ln 2 / 2`; its series ends where the
/// terms are below 1e-17.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    /// `1.5 · 2^52`, see [`ROUND`].
    const ROUND: f64 = 6_755_399_441_055_744.0;
    /// ln 2 in two parts, of which the first has zeros enough at its end for
    /// products with integers to be exact.
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    const SERIES: [f64; 14] = inverse_factorials();
    let rounded = x * std::f64::consts::LOG2_E + ROUND;
    let octaves = rounded - ROUND;
    let rest = (x - octaves * LN_2[0]) - octaves * LN_2[1];
    let power = SERIES
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * rest + coefficient);
    let power = f64::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 52));
    if x > -700.0 { power } else { 0.0 }
}

const fn inverse_factorials() -> [f64; 14] {
    let mut series = [1.0; 14];
    let mut k = 1;
    let mut factorial = 1.0;
    while k < 14 {
        factorial *= k as f64;
        series[k] = 1.0 / factorial;
        k += 1;
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_within_the_stated_error() {
        for step in -99_999..127_000_i32 {
            let x = step as f32 * 1e-3 + 1e-4;
            let truth = f64::from(x).exp2();
            let error = f64::from(exp2(x)) / truth - 1.0;
            assert!(error.abs() < 3e-7, "2^{x}: {error:e}");
        }
    }

    #[test]
    fn powers_below_the_range_and_of_nan_are_zero() {
        for x in [-100.0, -126.0, -1e30, f32::NEG_INFINITY, f32::NAN] {
            assert_eq!(exp2(x), 0.0, "2^{x}");
        }
    }

    #[test]
    fn exponentials_are_within_the_stated_error() {
        for step in 0..690_000_i32 {
            let x = -f64::from(step) * 1e-3 - 1e-4;
            let error = exp(x) / x.exp() - 1.0;
            assert!(error.abs() < 5e-16, "e^{x}: {error:e}");
        }
        assert_eq!(exp(0.0), 1.0);
        for x in [-700.0, -1e9, f64::NEG_INFINITY, f64::NAN] {
            assert_eq!(exp(x), 0.0, "e^{x}");
        }
    }
}
