//! How far an image is from its reference for those who see both in turn.

use flip_rs::{HdrOptions, RgbImage, hdr_flip};
use reference::oracle::image::Reference;

use crate::parse::Size;

/// Exposures at which images are compared, at most. The published rule takes one
/// for each stop between the median and the brightest pixel, which are many in a
/// picture that is mostly black; then they are further apart.
const MAX_EXPOSURES: usize = 8;

/// HDR-FLIP against one reference.
///
/// Andersson, Nilsson, Shirley and Akenine-Möller, Visualizing Errors in Rendered
/// High Dynamic Range Images, Eurographics 2021 (short papers): the mean over all
/// pixels of the largest FLIP error at any exposure, 0 to 1, with the published
/// exposures and tone curve and at 67 pixels per degree. Both images are divided by
/// the reference's mean radiance first, so that it does not depend on the unit of
/// radiance.
#[derive(Debug)]
pub(crate) struct Flip {
    /// `None` if the reference is black, or not finite: there is no exposure then.
    reference: Option<RgbImage<f32>>,
    scale: f64,
    options: HdrOptions,
}

impl Flip {
    /// Errors against this reference.
    pub(crate) fn new(size: Size, reference: &Reference) -> Self {
        let scale = 1.0 / reference.mean();
        let mut new = Self {
            reference: None,
            scale,
            options: HdrOptions::default(),
        };
        new.options.return_exposure_map = false;
        // The reference is rounded as images are, so that the best image has no error.
        let rounded = reference.radiance.iter().flatten();
        let rounded = rounded.map(|value| f64::from(*value as f32));
        let image = image(size, rounded.map(|value| (value * scale) as f32).collect());
        // A comparison of the reference with itself tells the exposures of the rule.
        new.options.num_exposures = Some(2);
        let rule = image
            .as_ref()
            .and_then(|image| hdr_flip(image, image, new.options).ok());
        if let Some(rule) = rule {
            let stops = rule.parameters.stop_exposure - rule.parameters.start_exposure;
            let exposures = (stops.ceil().max(2.0) as usize).min(MAX_EXPOSURES);
            new.options.num_exposures = Some(exposures);
            new.reference = image;
        }
        new
    }

    /// The error of an image (RGB and an ignored fourth component).
    ///
    /// Infinite for an image that is not finite; if the reference is black, 0 for an
    /// image that is black too, and 1 for any other.
    pub(crate) fn error(&self, radiance: impl Iterator<Item = [f32; 3]>) -> f64 {
        let values = radiance.flatten();
        let Some(reference) = &self.reference else {
            let mut largest = 0.0_f32;
            for value in values {
                if !value.is_finite() {
                    return f64::INFINITY;
                }
                largest = largest.max(value.abs());
            }
            return f64::from(u8::from(largest > 0.0));
        };
        let scaled = values.map(|value| (f64::from(value) * self.scale) as f32);
        let size = Size {
            width: reference.width() as u32,
            height: reference.height() as u32,
        };
        image(size, scaled.collect())
            .and_then(|test| hdr_flip(reference, &test, self.options).ok())
            .map_or(f64::INFINITY, |result| {
                f64::from(result.error_map.statistics().mean)
            })
    }
}

/// `None` if anything is not finite.
fn image(size: Size, values: Vec<f32>) -> Option<RgbImage<f32>> {
    let is_finite = values.iter().all(|value| value.is_finite());
    let [width, height] = [size.width as usize, size.height as usize];
    is_finite
        .then(|| RgbImage::new(width, height, values).ok())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 24,
        height: 16,
    };

    /// A ramp of some radiance with a bright spot.
    fn ramp(scale: f64) -> Reference {
        let pixels = SIZE.pixels();
        let value = |index: usize| {
            let x = (index % 24) as f64 / 24.0;
            let spot = if index == pixels / 2 { 9.0 } else { 0.0 };
            [0.5 + x + spot, 0.6 + x, 0.7].map(|value| scale * value)
        };
        Reference {
            radiance: (0..pixels).map(value).collect(),
            bound: vec![0.0; pixels],
        }
    }

    fn error(reference: &Reference, change: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> f64 {
        let pixels = reference.radiance.iter().enumerate();
        let changed = pixels.map(|(index, pixel)| change(index, pixel.map(|v| v as f32)));
        Flip::new(SIZE, reference).error(changed)
    }

    #[test]
    fn it_is_0_for_the_same_grows_with_the_difference_and_has_no_unit() {
        let by = |scale: f64, factor: f32| error(&ramp(scale), |_, p| p.map(|v| v * factor));
        assert_eq!(by(1.0, 1.0), 0.0);
        let errors = [1.01, 1.1, 2.0].map(|factor| by(1.0, factor));
        assert!(errors.is_sorted() && errors[0] > 0.0, "{errors:?}");
        assert!(errors[2] > 0.05 && errors[2] < 1.0, "{errors:?}");
        for scale in [1e-9, 1e9] {
            let error = by(scale, 1.1);
            assert!((error / errors[1] - 1.0).abs() < 1e-3, "{error} {errors:?}");
        }
    }

    #[test]
    fn what_cannot_be_seen_is_less_than_what_can() {
        // The same differences in blocks, and as a pattern that no eye resolves.
        let in_cells = |side: usize| {
            error(&ramp(1.0), |i, p| {
                let is_even = (i / 24 / side + i % 24 / side).is_multiple_of(2);
                let difference = if is_even { 0.05 } else { -0.05 };
                p.map(|v| v + difference)
            })
        };
        let [seen, unseen] = [in_cells(6), in_cells(1)];
        assert!(unseen > 0.0 && unseen < 0.5 * seen, "{unseen} {seen}");
    }

    #[test]
    fn black_and_infinite_images_have_errors_too() {
        let black = Reference {
            radiance: vec![[0.0; 3]; SIZE.pixels()],
            bound: vec![0.0; SIZE.pixels()],
        };
        assert_eq!(error(&black, |_, p| p), 0.0);
        assert_eq!(error(&black, |_, _| [0.1; 3]), 1.0);
        assert_eq!(error(&black, |_, _| [f32::NAN; 3]), f64::INFINITY);
        let one = |i: usize, p: [f32; 3]| if i == 3 { [f32::INFINITY; 3] } else { p };
        assert_eq!(error(&ramp(1.0), one), f64::INFINITY);
        // Mostly black: many stops, as many exposures as are allowed.
        let mut dark = ramp(1.0);
        for pixel in dark.radiance.iter_mut().skip(1) {
            *pixel = [0.0; 3];
        }
        let error = error(&dark, |_, p| p.map(|v| v + 0.01));
        assert!(error > 0.0 && error <= 1.0, "{error}");
    }
}
