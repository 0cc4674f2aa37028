//! Numbers of curves: the exponential function of optical depths, and shares of a
//! way.

use std::ops::{Add, Div, Mul, Sub};

use wide::{CmpGt, f32x4, i32x4};

/// Bound of the relative error of [`exp_neg`] where the result is at least
/// [`f32::MIN_POSITIVE`]; below, the result may be 0. Three roundings of half an
/// ULP in the argument and the last steps of the polynomial, whose own error is
/// 1e-8; the largest that the test meets is 0.7e-7.
pub(crate) const EXP_ERROR: f64 = 1.2e-7;

// From this argument on the result of `exp_neg` is 0: 2^-127 is written as exponent 0.
const LAST: f32 = 88.0;
// Adding 1.5 · 2²³ rounds to an integer and leaves it in the low bits.
const TO_INTEGER: f32 = 12_582_912.0;
// ln 2 in two parts, the first with 9 significant bits, so that its multiples up to
// 128 are exact.
const LN_2_HIGH: f32 = 0.693_359_4;
const LN_2_LOW: f32 = -2.121_944_4e-4;

/// `exp(−x)` for `x ≥ 0`, infinity included; 0 where the result is below the
/// range of normal numbers, and for NaN.
///
/// Without branches, table or calls, so that loops over it vectorise, and with
/// the same bits on every machine.
#[inline]
pub(crate) fn exp_neg(x: f32) -> f32 {
    // The comparison takes one instruction, and makes NaN LAST.
    let x = if x < LAST { x } else { LAST };
    let shifted = x * std::f32::consts::LOG2_E + TO_INTEGER;
    let k = shifted - TO_INTEGER;
    let r = (k * LN_2_HIGH - x) + k * LN_2_LOW;
    // Taylor series; |r| ≤ ln 2 / 2 leaves r⁷/7! < 1.2e-7 · 0.1.
    let p = 1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0));
    let p = 0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * p));
    let p = 1.0 + (r + r * r * p);
    let power = (127_u32 << 23).wrapping_sub(shifted.to_bits() << 23);
    p * f32::from_bits(power)
}

/// [`exp_neg`] of four numbers, with the same bits.
#[inline(always)]
pub(crate) fn exp_neg_4(x: f32x4) -> f32x4 {
    let number = f32x4::splat;
    // Not `fast_min`, which on some processors gives NaN for NaN.
    let x = f32x4::from(x.to_array().map(|x| smaller(x, LAST)));
    let shifted = x * number(std::f32::consts::LOG2_E) + number(TO_INTEGER);
    let k = shifted - number(TO_INTEGER);
    let r = (k * number(LN_2_HIGH) - x) + k * number(LN_2_LOW);
    let p = number(1.0 / 720.0) + r * number(1.0 / 5040.0);
    let p = number(1.0 / 24.0) + r * (number(1.0 / 120.0) + r * p);
    let p = number(0.5) + r * (number(1.0 / 6.0) + r * p);
    let p = number(1.0) + (r + r * r * p);
    let bits: i32x4 = bytemuck::cast(shifted);
    let power: f32x4 = bytemuck::cast(i32x4::splat(127 << 23) - (bits << 23));
    p * power
}

/// The smaller of two numbers: one instruction, where [`f32::min`] also has an
/// answer for NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// One number, or four at a time with the same results.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + From<f32>
{
    fn abs(self) -> Self;

    /// The larger of two numbers, the second where one is NaN.
    fn larger(self, other: Self) -> Self;

    /// The first of two numbers where this is above a bound, else the second.
    fn choose_above(self, bound: f32, above: Self, below: Self) -> Self;
}

impl Number for f32 {
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        larger(self, other)
    }

    #[inline(always)]
    fn choose_above(self, bound: f32, above: Self, below: Self) -> Self {
        if self > bound { above } else { below }
    }
}

impl Number for f32x4 {
    #[inline(always)]
    fn abs(self) -> Self {
        f32x4::abs(self)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.cmp_gt(other).blend(self, other)
    }

    #[inline(always)]
    fn choose_above(self, bound: f32, above: Self, below: Self) -> Self {
        self.cmp_gt(f32x4::splat(bound)).blend(above, below)
    }
}

/// Share of the way from `from` to `to` at which `depth` lies. In f64 neither
/// the depths of f32 nor their differences can overflow or get lost.
#[inline]
pub(crate) fn fraction(from: f32, to: f32, depth: f32) -> f64 {
    let from = f64::from(from);
    let length = f64::from(to) - from;
    let fraction = (f64::from(depth) - from) / length;
    // The division is always computed, because a branch costs more.
    if length != 0.0 { fraction } else { 0.0 }
}

/// `from + (to − from) · fraction`, rounded once. Beyond `to` by a rounding of f64 at
/// most, which counts where `to` is tiny beside `from`.
#[inline]
pub(crate) fn mix(from: f32, to: f32, fraction: f64) -> f32 {
    (f64::from(from) + (f64::from(to) - f64::from(from)) * fraction) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_is_within_its_bound_over_the_whole_range() {
        let mut worst = 0.0_f64;
        // Every 97th float from the smallest to 88.
        for bits in (0..88.0_f32.to_bits()).step_by(97) {
            let x = f32::from_bits(bits);
            let truth = (-f64::from(x)).exp();
            if truth >= f64::from(f32::MIN_POSITIVE) {
                worst = worst.max((f64::from(exp_neg(x)) / truth - 1.0).abs());
            } else {
                assert!(exp_neg(x) <= f32::MIN_POSITIVE);
            }
        }
        assert!(worst < EXP_ERROR, "{worst:e}");
    }

    #[test]
    fn the_ends_are_exact() {
        assert_eq!(exp_neg(0.0), 1.0);
        assert_eq!(exp_neg(f32::MIN_POSITIVE), 1.0);
        for x in [88.0, 1e3, 1e30, f32::MAX, f32::INFINITY, f32::NAN] {
            assert_eq!(exp_neg(x), 0.0, "{x}");
        }
    }

    #[test]
    fn four_at_once_are_as_each_by_itself() {
        let last = f32::INFINITY.to_bits();
        for bits in (0..last).step_by(9973).chain([last, f32::NAN.to_bits()]) {
            let x = std::array::from_fn(|lane| f32::from_bits(bits.saturating_sub(lane as u32)));
            let each: [u32; 4] = x.map(|x| exp_neg(x).to_bits());
            let at_once = exp_neg_4(f32x4::from(x)).to_array();
            assert_eq!(at_once.map(f32::to_bits), each, "{x:?}");
        }
    }
}
