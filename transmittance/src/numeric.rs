//! Numbers of curves: the exponential function of optical depths, and shares of a
//! way.

/// Bound of the relative error of [`exp_neg`] where the result is at least
/// [`f32::MIN_POSITIVE`]; below, the result may be 0. Three roundings of half an
/// ULP in the argument and the last steps of the polynomial, whose own error is
/// 1e-8; the largest that the test meets is 0.7e-7.
pub(crate) const EXP_ERROR: f64 = 1.2e-7;

/// `exp(−x)` for `x ≥ 0`, infinity included; 0 where the result is below the
/// range of normal numbers, and for NaN.
///
/// Without branches, table or calls, so that loops over it vectorise, and with
/// the same bits on every machine.
#[inline]
pub(crate) fn exp_neg(x: f32) -> f32 {
    // From this argument on the result is 0: 2^-127 is written as exponent 0.
    const LAST: f32 = 88.0;
    // Adding 1.5 · 2²³ rounds to an integer and leaves it in the low bits.
    const TO_INTEGER: f32 = 12_582_912.0;
    // ln 2 in two parts, the first with 9 significant bits, so that its
    // multiples up to 128 are exact.
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    // One instruction, also for NaN.
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

/// Share of the way from `from` to `to` at which `depth` lies. In f64 neither
/// the depths of f32 nor their differences can overflow or get lost.
#[inline]
pub(crate) fn fraction(from: f32, to: f32, depth: f32) -> f64 {
    let from = f64::from(from);
    let length = f64::from(to) - from;
    let fraction = (f64::from(depth) - from) / length;
    // Computed in any case: a branch costs more than a division.
    if length != 0.0 { fraction } else { 0.0 }
}

/// `from + (to − from) · fraction`, rounded once, and never beyond `to`.
#[inline]
pub(crate) fn mix(from: f32, to: f32, fraction: f64) -> f32 {
    let mixed = (f64::from(from) + (f64::from(to) - f64::from(from)) * fraction) as f32;
    smaller(larger(mixed, smaller(from, to)), larger(from, to))
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
}
