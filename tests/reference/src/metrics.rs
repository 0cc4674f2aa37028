//! How far an image is from its reference.

/// The darkest pixel whose relative error matters, as a share of the mean.
pub const DARKEST: f64 = 1e-3;

/// What keeps the relative squared error of dark pixels finite, as a share of the
/// squared mean: the usual 1e-2 for images whose mean is about 1.
pub const REL_MSE_FLOOR: f64 = 1e-2;

/// The airlight of every ray, and how wrong it can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Linear RGB radiance that the fog scatters into the eye. Surfaces are
    /// not included.
    pub radiance: Vec<[f64; 3]>,
    /// Bound on the error of the quadrature, per ray, for each channel.
    pub bound: Vec<f64>,
}

impl Reference {
    /// The mean of all channels of all pixels.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.radiance.iter().flatten().sum();
        sum / (3 * self.radiance.len()).max(1) as f64
    }

    /// The largest bound of any pixel.
    pub fn max_bound(&self) -> f64 {
        self.bound.iter().copied().fold(0.0, f64::max)
    }
}

/// The error of an image in linear radiance.
///
/// Root mean square and maximum run over all channels of all pixels and are
/// divided by the reference's mean radiance, so that 0.01 is 1 % of it. If that
/// mean is 0 they are absolute and [`ImageError::absolute`] is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageError {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Largest difference.
    pub max: f64,
    /// 99th percentile over pixels of the relative error of a pixel: its
    /// largest difference in any channel divided by its brightest channel in
    /// the reference, or by 1e-3 of the mean radiance if that is more. (If the
    /// mean is 0, of the largest difference itself.)
    pub rel_p99: f64,
    /// relMSE: the mean over all channels of all pixels of
    /// `(x - r)² / (r² + ε)` with `ε` = [`REL_MSE_FLOOR`] × mean² (Rousselle,
    /// Knaus, Zwicker, Adaptive Sampling and Reconstruction using Greedy Error
    /// Minimization, SIGGRAPH Asia 2011). If the mean is 0, of the squared
    /// difference itself.
    pub rel_mse: f64,
    /// Mean radiance of the reference over all channels of all pixels, by
    /// which `rmse` and `max` were divided.
    pub mean: f64,
    /// The reference is black and nothing was divided.
    pub absolute: bool,
}

/// The error of `test` (RGB and an ignored fourth component).
///
/// NaN and infinite pixels give infinite errors. An empty image has no error.
///
/// # Panics
/// If the image and the reference differ in their number of pixels.
pub fn image_error(test: &[[f32; 4]], reference: &Reference) -> ImageError {
    assert_eq!(
        test.len(),
        reference.radiance.len(),
        "the image and its reference differ in size"
    );
    let mean = reference.mean();
    let absolute = !(mean > 0.0);
    let unit = if absolute { 1.0 } else { mean };
    let mut squares = 0.0;
    let mut relative_squares = 0.0;
    let mut max = 0.0_f64;
    let mut relative = Vec::with_capacity(test.len());
    for (pixel, truth) in test.iter().zip(&reference.radiance) {
        let mut worst = 0.0_f64;
        for (value, truth) in pixel.iter().zip(truth) {
            // Divided first: squares of tiny radiances would vanish.
            let difference = (f64::from(*value) - truth).abs() / unit;
            // A NaN must not hide behind a comparison.
            let difference = if difference.is_nan() {
                f64::INFINITY
            } else {
                difference
            };
            let square = difference * difference;
            let scaled = truth / unit;
            squares += square;
            relative_squares += if absolute || square.is_infinite() {
                square
            } else {
                square / (scaled * scaled + REL_MSE_FLOOR)
            };
            worst = worst.max(difference);
        }
        max = max.max(worst);
        let brightest = truth.iter().copied().fold(0.0, f64::max);
        let floor = if absolute {
            1.0
        } else {
            (brightest / unit).max(DARKEST)
        };
        relative.push(worst / floor);
    }
    let channels = (3 * test.len()).max(1) as f64;
    ImageError {
        rmse: (squares / channels).sqrt(),
        max,
        rel_p99: percentile_99(&mut relative),
        rel_mse: relative_squares / channels,
        mean,
        absolute,
    }
}

/// The least value that at least 99 % of `values` do not exceed; 0 for none.
fn percentile_99(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = (values.len() * 99).div_ceil(100) - 1;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// The order of convergence that pairs of samples and errors show: the slope of
/// log error over log 1 / samples, by least squares.
pub fn order(errors: &[(u32, f64)]) -> f64 {
    let points: Vec<_> = errors.iter().map(|(n, e)| (f64::from(*n), *e)).collect();
    -log_slope(&points)
}

/// The slope of log y over log x, by least squares. Not finite for fewer than two
/// different x, and for values that are not positive.
pub fn log_slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let points = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
    let (x, y) = (x / count, y / count);
    let (above, below) = points.fold((0.0, 0.0), |sum, p| {
        (sum.0 + (p.0 - x) * (p.1 - y), sum.1 + (p.0 - x).powi(2))
    });
    above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f64]) -> Reference {
        Reference {
            radiance: values.iter().map(|v| [*v; 3]).collect(),
            bound: vec![0.0; values.len()],
        }
    }

    #[test]
    fn tiny_radiances_have_errors_too() {
        let reference = grey(&[1e-200, 3e-200]);
        let error = image_error(&[[0.0; 4]; 2], &reference);
        assert!((error.rmse - 1.25_f64.sqrt()).abs() < 1e-12, "{error:?}");
        assert!((error.max - 1.5).abs() < 1e-12 && (error.rel_p99 - 1.0).abs() < 1e-12);
        let infinite = image_error(&[[1.0; 4]], &grey(&[f64::INFINITY]));
        assert!(infinite.rmse.is_infinite() && infinite.max.is_infinite());
    }

    #[test]
    fn errors_are_relative_to_the_mean() {
        let reference = grey(&[1.0, 3.0]);
        let error = image_error(&[[1.0, 1.0, 1.0, 7.0], [3.2, 3.2, 3.2, 0.0]], &reference);
        assert!((error.max - 0.1).abs() < 1e-6, "{error:?}");
        assert!(
            (error.rmse - 0.1 / 2.0_f64.sqrt()).abs() < 1e-6,
            "{error:?}"
        );
        assert!((error.rel_p99 - 0.2 / 3.0).abs() < 1e-6, "{error:?}");
        assert_eq!((error.mean, error.absolute), (2.0, false));
        // (0.1 / 1.5)² of one pixel of two, and what keeps dark ones finite.
        let expected = 0.5 * 0.01 / (2.25 + REL_MSE_FLOOR);
        assert!((error.rel_mse / expected - 1.0).abs() < 1e-5, "{error:?}");
    }

    #[test]
    fn a_relative_error_weighs_dark_pixels_more_and_has_no_scale() {
        let rel_mse = |scale: f64, wrong: usize| {
            let truth = [0.2 * scale, 1.8 * scale];
            let mut image = truth.map(|value| [value as f32; 4]);
            image[wrong] = image[wrong].map(|value| value + 0.1 * scale as f32);
            image_error(&image, &grey(&truth)).rel_mse
        };
        assert!(rel_mse(1.0, 0) > 50.0 * rel_mse(1.0, 1));
        for scale in [1e-12, 1e12] {
            assert!((rel_mse(scale, 0) / rel_mse(1.0, 0) - 1.0).abs() < 1e-4);
        }
        let black = image_error(&[[0.5; 4]], &grey(&[0.0]));
        assert_eq!(black.rel_mse, 0.25);
    }

    #[test]
    fn a_black_reference_gives_absolute_errors() {
        let error = image_error(&[[0.25; 4]; 2], &grey(&[0.0, 0.0]));
        assert!(error.absolute && error.max == 0.25 && error.rmse == 0.25);
        assert_eq!(error.rel_p99, 0.25);
    }

    #[test]
    fn nan_is_an_infinite_error_and_nothing_is_no_error() {
        let error = image_error(&[[f32::NAN; 4]], &grey(&[1.0]));
        assert_eq!(error.rmse, f64::INFINITY);
        assert_eq!(error.max, f64::INFINITY);
        assert_eq!(error.rel_mse, f64::INFINITY);
        assert_eq!(image_error(&[], &grey(&[])).max, 0.0);
        assert_eq!(image_error(&[], &grey(&[])).rel_mse, 0.0);
    }

    #[test]
    fn one_pixel_in_a_hundred_may_be_wrong_without_moving_the_percentile() {
        let reference = grey(&[1.0; 100]);
        let mut image = [[1.0; 4]; 100];
        image[7] = [9.0; 4];
        assert_eq!(image_error(&image, &reference).rel_p99, 0.0);
        image[8] = [3.0; 4];
        assert_eq!(image_error(&image, &reference).rel_p99, 2.0);
    }

    #[test]
    fn a_power_law_has_its_exponent_as_slope() {
        let points = [1.0, 3.0, 10.0, 50.0].map(|x: f64| (x, 7.0 * x.powf(-1.5)));
        assert!((log_slope(&points) + 1.5).abs() < 1e-12);
        assert!((order(&[(1, 1.0), (2, 0.25), (4, 0.0625)]) - 2.0).abs() < 1e-12);
        for none in [&points[..1], &[], &[(1.0, 1.0), (2.0, 0.0)]] {
            assert!(!log_slope(none).is_finite());
        }
    }
}
