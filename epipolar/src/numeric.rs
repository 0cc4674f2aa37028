//! The one transcendental function that shader and processor share.

/// `atan r = r + r z p(z)`, `z = r²`, for `|r| ≤ tan(π/8)`: interpolation at
/// Chebyshev nodes, relative error 2.4e-9 before rounding.
pub(crate) const ATAN: [f32; 5] = [
    -0.333_333_3,
    0.199_995_4,
    -0.142_639_56,
    0.107_437_31,
    -0.064_519_28,
];

/// tan(π/8), where the octant is halved.
pub(crate) const TAN_EIGHTH: f32 = 0.414_213_57;

/// The angle of the vector (x, y) in [-π, π], 0 for the zero vector; relative
/// error 3e-7 (`epi_angle` in WGSL computes the same, where the built-in
/// function may be off by 4096 ULP).
#[inline(always)]
pub(crate) fn angle(y: f32, x: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let (a, b) = (x.abs(), y.abs());
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    // There is no branch, so that many angles are computed with vector instructions: the
    // operands are chosen, and one division serves both cases.
    let (above, below, offset) = if small > TAN_EIGHTH * large {
        (small - large, small + large, FRAC_PI_4)
    } else {
        (small, large, 0.0)
    };
    let r = above / below;
    let z = r * r;
    let p = ATAN[0] + z * (ATAN[1] + z * (ATAN[2] + z * (ATAN[3] + z * ATAN[4])));
    let mut angle = offset + (r + r * z * p);
    if b > a {
        angle = FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    if y < 0.0 {
        angle = -angle;
    }
    if large > 0.0 { angle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 5 roundings of half an ULP on the way to an angle in the same octant as
    /// its result, and the polynomial: 3e-7.
    const TOLERANCE: f64 = 3e-7;

    fn check(y: f32, x: f32) {
        let expected = f64::from(y).atan2(f64::from(x));
        let actual = f64::from(angle(y, x));
        assert!(
            (actual - expected).abs() <= TOLERANCE * expected.abs(),
            "{actual} for ({x}, {y}), expected {expected}"
        );
    }

    #[test]
    fn angles_are_right_on_axes_and_diagonals() {
        for (y, x) in [
            (0.0, 1.0),
            (1.0, 0.0),
            (-1.0, 0.0),
            (0.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (1.0, -1.0),
            (-1.0, -1.0),
            (TAN_EIGHTH, 1.0),
            (-1.0, TAN_EIGHTH),
            (1e-30, -1.0),
            (-1e-30, -1e-30),
        ] {
            check(y, x);
        }
        assert_eq!(angle(0.0, 0.0), 0.0);
    }

    proptest! {
        #![proptest_config(reference::property::cases(256))]

        #[test]
        fn angles_keep_their_relative_accuracy(
            log_y in -60.0_f32..60.0, log_x in -60.0_f32..60.0,
            negative_y: bool, negative_x: bool,
        ) {
            let sign = |negative| if negative { -1.0_f32 } else { 1.0 };
            check(sign(negative_y) * log_y.exp2(), sign(negative_x) * log_x.exp2());
        }
    }
}
