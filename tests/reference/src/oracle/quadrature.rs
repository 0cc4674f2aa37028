//! Adaptive Gauss–Kronrod quadrature of RGB functions with an error bound.

use glam::DVec3;

/// Positive nodes of the 15-point Kronrod rule on [−1, 1]; every second one is
/// a node of the 7-point Gauss rule. From QUADPACK (Piessens et al. 1983).
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_56,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];
/// Weights of the Gauss rule at `NODES[1]`, `[3]`, `[5]`, `[7]`.
const GAUSS: [f64; 4] = [
    0.129_484_966_168_869_7,
    0.279_705_391_489_276_64,
    0.381_830_050_505_118_9,
    0.417_959_183_673_469_4,
];

/// The difference of the two rules is the error of the Gauss rule, which for
/// smooth integrands is far above that of the Kronrod rule. At a boundary layer
/// that neither resolves they are about as wrong as each other; this much is
/// added for that.
const SAFETY: f64 = 4.0;

/// Pieces beyond which an integral is left as inaccurate as it is.
const MOST_PIECES: usize = 1 << 14;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative to the brightest channel of the result.
    pub relative: f64,
    /// In the units of the result. The larger of the two counts.
    pub absolute: f64,
}

impl Tolerance {
    /// Only relative.
    pub const fn relative(relative: f64) -> Self {
        Self {
            relative,
            absolute: 0.0,
        }
    }
}

/// A result and how wrong it can be.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// The result, linear RGB.
    pub value: DVec3,
    /// Bound on the error of each channel.
    pub bound: f64,
}

/// A piece of an integral over `t`. `term` says of which function.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) term: usize,
    pub(super) start: f64,
    pub(super) end: f64,
    value: DVec3,
    error: f64,
}

impl Piece {
    pub(super) fn new(term: usize, start: f64, end: f64, f: &impl Fn(usize, f64) -> DVec3) -> Self {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        let centre = f(term, middle);
        let mut kronrod = KRONROD[7] * centre;
        let mut gauss = GAUSS[3] * centre;
        for i in 0..7 {
            let pair = f(term, middle - half * NODES[i]) + f(term, middle + half * NODES[i]);
            kronrod += KRONROD[i] * pair;
            if i % 2 == 1 {
                gauss += GAUSS[i / 2] * pair;
            }
        }
        Self {
            term,
            start,
            end,
            value: half * kronrod,
            error: SAFETY * half.abs() * (kronrod - gauss).abs().max_element(),
        }
    }
}

/// Sum over pieces. Halves those with the largest errors until their sum is
/// within `tolerance`, or there are 16384 of them; the bound that comes back
/// says how good it got.
///
/// Integrands are not negative here, so nothing cancels and the rounding is
/// relative to the result.
pub(super) fn integrate(
    pieces: &mut Vec<Piece>,
    tolerance: Tolerance,
    f: impl Fn(usize, f64) -> DVec3,
) -> Estimate {
    loop {
        let mut value = DVec3::ZERO;
        let mut error = 0.0;
        for piece in pieces.iter() {
            value += piece.value;
            error += piece.error;
        }
        let brightest = value.max_element();
        let rounding = 1e-14 * brightest;
        let target = (tolerance.relative * brightest)
            .max(tolerance.absolute)
            .max(rounding);
        let estimate = Estimate {
            value,
            bound: error + rounding,
        };
        if !(error > target) || !error.is_finite() {
            return estimate;
        }
        // Some piece exceeds this as long as the sum exceeds the target.
        let share = 0.5 * target / pieces.len() as f64;
        let before = pieces.len();
        for index in 0..before {
            let Piece {
                term,
                start,
                end,
                error,
                ..
            } = pieces[index];
            let middle = 0.5 * (start + end);
            let divisible = start < middle && middle < end;
            if error > share && divisible && pieces.len() < MOST_PIECES {
                pieces[index] = Piece::new(term, start, middle, &f);
                pieces.push(Piece::new(term, middle, end, &f));
            }
        }
        if pieces.len() == before {
            return estimate;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(start: f64, end: f64, tolerance: f64, f: impl Fn(f64) -> f64) -> Estimate {
        let f = |_: usize, t: f64| DVec3::splat(f(t));
        let mut pieces = vec![Piece::new(0, start, end, &f)];
        integrate(&mut pieces, Tolerance::relative(tolerance), f)
    }

    #[test]
    fn polynomials_up_to_degree_22_need_no_subdivision() {
        for degree in 0..=22 {
            let f = |_: usize, t: f64| DVec3::splat(t.powi(degree));
            let piece = Piece::new(0, 0.0, 2.0, &f);
            let exact = 2.0_f64.powi(degree + 1) / f64::from(degree + 1);
            assert!(
                (piece.value.x / exact - 1.0).abs() < 1e-14,
                "degree {degree}"
            );
            assert!(
                degree > 13 || piece.error < 1e-13 * exact,
                "degree {degree}"
            );
        }
    }

    #[test]
    fn bounds_hold_for_kinks_peaks_and_endless_oscillation() {
        let kink = of(0.0, 1.0, 1e-9, |t| (t - 0.3).abs());
        let exact = 0.5 * (0.09 + 0.49);
        assert!((kink.value.x - exact).abs() <= kink.bound && kink.bound < 2e-9);

        let peak = of(-1.0, 1.0, 1e-9, |t| 1e-4 / (t * t + 1e-8));
        let exact = 2.0 * (1e4_f64).atan();
        assert!((peak.value.x - exact).abs() <= peak.bound && peak.bound < 1e-8);

        let wild = of(0.0, 1.0, 1e-9, |t| 1.0 + (1.0 / t).sin());
        assert!(wild.bound < 1e-3 && wild.value.x > 1.0);
    }
}
