//! The error of a picture, estimated from some of its pixels.

use super::Judged;
use super::sample::Segment;

/// A relative root mean square error with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub(super) rmse: f64,
    /// Its standard error; 0 if the truth of all pixels is known.
    pub(super) spread: f64,
}

/// The error of `light`, which is the radiance of the sample's pixels.
pub(super) fn estimate(light: &[[f32; 4]], judged: &Judged) -> Estimate {
    let mut squares = Vec::new();
    let mut mean = 0.0;
    for segment in judged.segments() {
        let (square, light) = of_segment(light, segment);
        squares.push(square);
        mean += light;
    }
    let number = squares.len().max(1) as f64;
    let (nearest, share) = judged.nearest();
    let (square_nearest, mean_nearest) = of_segment(light, nearest);
    let mean = share * mean_nearest + (1.0 - share) * mean / number;
    let square = share * square_nearest + (1.0 - share) * squares.iter().sum::<f64>() / number;
    let scale = if mean > 0.0 { mean } else { 1.0 };
    let rmse = square.sqrt() / scale;
    // Neighbouring cells have similar light, so their differences are due to chance.
    let steps: f64 = squares
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum();
    let variance = (1.0 - share).powi(2) * steps / (2.0 * (number - 1.0).max(1.0) * number);
    let spread = match judged.is_whole() || !(square > 0.0) {
        true => 0.0,
        false => variance.sqrt() / (2.0 * square.sqrt()) / scale,
    };
    Estimate { rmse, spread }
}

/// The mean squared difference in a segment, and the mean of the reference; 0 for an empty
/// segment.
fn of_segment(light: &[[f32; 4]], segment: &Segment) -> (f64, f64) {
    let number = 3.0 * segment.places.len().max(1) as f64;
    let (mut square, mut mean) = (0.0, 0.0);
    for (place, truth) in segment.places.iter().zip(&segment.truth) {
        for channel in 0..3 {
            square += (f64::from(light[*place][channel]) - truth[channel]).powi(2);
            mean += truth[channel];
        }
    }
    (square / number, mean / number)
}
