//! Linear radiance as files: tone-mapped PNG, linear EXR, difference pictures.

use base64::Engine;
use exr::prelude::WritableImage;
use image::{ExtendedColorType, ImageEncoder};

use crate::failure::Failure;
use crate::parse::Size;

/// Linear RGB radiance, row by row from the top.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    pub(crate) size: Size,
    pub(crate) pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// The first three channels of a gathered image; `radiance` must have as
    /// many entries as `size` has pixels.
    pub(crate) fn new(size: Size, radiance: &[[f32; 4]]) -> Self {
        assert_eq!(radiance.len(), size.pixels(), "one entry per pixel");
        let pixels = radiance.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Self { size, pixels }
    }

    /// The same from a reference, which is more precise than a picture needs.
    pub(crate) fn of_reference(size: Size, radiance: &[[f64; 3]]) -> Self {
        assert_eq!(radiance.len(), size.pixels(), "one entry per pixel");
        let pixels = radiance.iter().map(|p| p.map(|c| c as f32)).collect();
        Self { size, pixels }
    }

    /// No light at all.
    pub(crate) fn black(size: Size) -> Self {
        Self {
            size,
            pixels: vec![[0.0; 3]; size.pixels()],
        }
    }

    /// The sum of two pictures of one size.
    #[must_use]
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let add = |(a, b): (&[f32; 3], &[f32; 3])| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        Self {
            size: self.size,
            pixels: self.pixels.iter().zip(&other.pixels).map(add).collect(),
        }
    }

    /// The picture whose pixels are the means of `side` × `side` of these, or of as many as there
    /// are across or down. Rows and columns that are left over below and at the right are not in
    /// it.
    #[must_use]
    pub(crate) fn averaged(self, side: u32) -> Self {
        if side == 1 {
            return self;
        }
        let [across, down] = [self.size.width, self.size.height].map(|length| side.min(length));
        let size = Size {
            width: self.size.width / across,
            height: self.size.height / down,
        };
        let [across, down] = [across, down].map(|side| side as usize);
        let (stride, width) = (self.size.width as usize, size.width as usize);
        let weight = 1.0 / (across * down) as f64;
        let pixels = (0..size.pixels()).map(|pixel| {
            let (row, column) = (pixel / width * down, pixel % width * across);
            let mut sum = [0.0_f64; 3];
            for y in row..row + down {
                let begin = y * stride + column;
                for value in &self.pixels[begin..begin + across] {
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += f64::from(*value);
                    }
                }
            }
            sum.map(|sum| (weight * sum) as f32)
        });
        Self {
            size,
            pixels: pixels.collect(),
        }
    }

    /// The number of pixels with a channel that is not finite.
    pub(crate) fn non_finite(&self) -> usize {
        self.pixels.iter().filter(|p| !is_finite(p)).count()
    }

    /// The exposure, in stops, at which the 95th percentile of the luminance
    /// reaches two thirds of the display's light; 0 for a black picture.
    pub(crate) fn automatic_exposure(&self) -> f32 {
        let mut values: Vec<f32> = self.pixels.iter().map(luminance).collect();
        values.retain(|value| *value > 0.0 && value.is_finite());
        if values.is_empty() {
            return 0.0;
        }
        let rank = values.len() * 95 / 100;
        let (_, value, _) = values.select_nth_unstable_by(rank, f32::total_cmp);
        // 1 - exp(-x) is 2/3 at x = ln 3.
        (3_f32.ln() / *value).log2().clamp(-60.0, 60.0)
    }

    /// An 8-bit sRGB picture: radiance times 2^`exposure`, then
    /// `1 - exp(-x)` per channel, which is linear in the dark and never clips.
    /// Pixels that are not finite are magenta.
    pub(crate) fn png(&self, exposure: f32) -> Result<Vec<u8>, Failure> {
        encode_png(self.size, &self.tones(exposure))
    }

    /// The bytes of [`Picture::png`], three for each pixel.
    pub(crate) fn tones(&self, exposure: f32) -> Vec<u8> {
        let scale = exposure.exp2();
        let tone = |x: f32| encode_srgb(-(-(x * scale).max(0.0)).exp_m1());
        let colour = |p: &[f32; 3]| if is_finite(p) { p.map(tone) } else { SIGNAL };
        self.pixels.iter().flat_map(colour).collect()
    }

    /// An EXR file of 32-bit floats with the radiance as it is.
    pub(crate) fn exr(&self) -> Result<Vec<u8>, Failure> {
        let width = self.size.width as usize;
        let pixel = |position: exr::prelude::Vec2<usize>| {
            let [r, g, b] = self.pixels[position.y() * width + position.x()];
            (r, g, b)
        };
        let channels = exr::prelude::SpecificChannels::rgb(pixel);
        let image =
            exr::prelude::Image::from_channels((width, self.size.height as usize), channels);
        let mut file = std::io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut file)?;
        Ok(file.into_inner())
    }

    /// The signed difference in luminance to `reference`: blue where this is darker, orange where
    /// it is brighter, full colour at ± `scale`. Differences of 0 are grey; those that are not
    /// finite are magenta.
    pub(crate) fn difference_png(&self, reference: &Self, scale: f32) -> Result<Vec<u8>, Failure> {
        encode_png(self.size, &self.differences(reference, scale))
    }

    /// The bytes of [`Picture::difference_png`], three for each pixel.
    pub(crate) fn differences(&self, reference: &Self, scale: f32) -> Vec<u8> {
        let colour = |(a, b): (&[f32; 3], &[f32; 3])| {
            if !is_finite(a) || !is_finite(b) {
                return SIGNAL;
            }
            let t = ((luminance(a) - luminance(b)) / scale).clamp(-1.0, 1.0);
            diverging(if t.is_nan() { 1.0 } else { t })
        };
        let pairs = self.pixels.iter().zip(&reference.pixels);
        pairs.flat_map(colour).collect()
    }

    /// Absolute differences in luminance to `reference`, sorted.
    pub(crate) fn sorted_differences(&self, reference: &Self) -> Vec<f32> {
        let pairs = self.pixels.iter().zip(&reference.pixels);
        let mut all: Vec<f32> = pairs
            .map(|(a, b)| (luminance(a) - luminance(b)).abs())
            .collect();
        all.sort_by(f32::total_cmp);
        all
    }
}

/// An image file as the address of an `<img>`.
pub(crate) fn data_uri(png: &[u8]) -> String {
    let text = base64::engine::general_purpose::STANDARD.encode(png);
    format!("data:image/png;base64,{text}")
}

/// Magenta: no light in fog looks like this by accident.
const SIGNAL: [u8; 3] = [255, 0, 255];

fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|channel| channel.is_finite())
}

/// Rec. 709 weights.
fn luminance(pixel: &[f32; 3]) -> f32 {
    0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2]
}

/// From display-linear [0, 1] to an sRGB byte.
fn encode_srgb(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * encoded).round() as u8
}

/// Blue (-1), dark grey (0), orange (1); distinct to colour-blind eyes.
fn diverging(t: f32) -> [u8; 3] {
    const ZERO: [f32; 3] = [32.0, 33.0, 36.0];
    const BELOW: [f32; 3] = [86.0, 180.0, 255.0];
    const ABOVE: [f32; 3] = [255.0, 159.0, 28.0];
    let end = if t < 0.0 { BELOW } else { ABOVE };
    let weight = t.abs().sqrt();
    std::array::from_fn(|c| (ZERO[c] + weight * (end[c] - ZERO[c])).round() as u8)
}

fn encode_png(size: Size, rgb: &[u8]) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    image::codecs::png::PngEncoder::new(&mut file).write_image(
        rgb,
        size.width,
        size.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers};

    use super::*;

    fn picture(values: &[f32]) -> Picture {
        let size = Size {
            width: values.len() as u32,
            height: 1,
        };
        let radiance: Vec<[f32; 4]> = values.iter().map(|v| [*v; 4]).collect();
        Picture::new(size, &radiance)
    }

    fn decode(png: &[u8]) -> image::RgbImage {
        image::load_from_memory(png).unwrap().to_rgb8()
    }

    #[test]
    fn tone_mapping_is_monotonic_and_survives_anything() {
        let values = [-1.0, 0.0, 1e-9, 0.1, 0.5, 2.0, 1e30];
        let image = decode(&picture(&values).png(0.0).unwrap());
        let row: Vec<u8> = image.pixels().map(|p| p.0[0]).collect();
        assert!(row.is_sorted(), "{row:?}");
        assert_eq!((row[0], row[6]), (0, 255));
    }

    #[test]
    fn what_is_not_finite_is_counted_and_seen() {
        let odd = picture(&[f32::NAN, f32::INFINITY, 1.0]);
        assert_eq!(odd.non_finite(), 2);
        let same = decode(&odd.difference_png(&odd, 1.0).unwrap());
        for image in [decode(&odd.png(0.0).unwrap()), same] {
            let seen: Vec<bool> = image.pixels().map(|p| p.0 == SIGNAL).collect();
            assert_eq!(seen, [true, true, false]);
        }
    }

    #[test]
    fn pixels_are_the_mean_of_their_rays() {
        let size = Size {
            width: 6,
            height: 4,
        };
        let radiance: Vec<[f32; 4]> = (0..24).map(|i| [i as f32, 1.0, 0.1, 0.0]).collect();
        let mean = Picture::new(size, &radiance).averaged(2);
        assert_eq!((mean.size.width, mean.size.height), (3, 2));
        let red: Vec<f32> = mean.pixels.iter().map(|p| p[0]).collect();
        assert_eq!(red, [3.5, 5.5, 7.5, 15.5, 17.5, 19.5]);
        assert!(mean.pixels.iter().all(|p| p[1..] == [1.0, 0.1]));
    }

    #[test]
    fn automatic_exposure_brings_any_scale_to_the_display() {
        for scale in [1e-6_f32, 1.0, 1e6] {
            let values: Vec<f32> = (1..100).map(|i| scale * i as f32).collect();
            let picture = picture(&values);
            let image = decode(&picture.png(picture.automatic_exposure()).unwrap());
            let bright = image.get_pixel(94, 0).0[0];
            assert!((205..225).contains(&bright), "{bright}");
        }
        assert_eq!(picture(&[0.0, 0.0]).automatic_exposure(), 0.0);
    }

    #[test]
    fn exr_keeps_every_bit() {
        let values = [0.0, 1e-20, 0.1, 12345.678];
        let file = picture(&values).exr().unwrap();
        let read = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| vec![[0.0_f32; 3]; size.area()],
                |pixels, at, (r, g, b): (f32, f32, f32)| pixels[at.x()] = [r, g, b],
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(std::io::Cursor::new(file))
            .unwrap();
        let pixels = read.layer_data.channel_data.pixels;
        assert_eq!(pixels, values.map(|v| [v; 3]));
    }

    #[test]
    fn differences_have_a_sign_and_a_scale() {
        let (a, b) = (picture(&[1.0, 1.0, 1.0]), picture(&[1.0, 0.0, 9.0]));
        let image = decode(&a.difference_png(&b, 1.0).unwrap());
        assert_eq!(image.get_pixel(0, 0).0, diverging(0.0));
        assert_eq!(image.get_pixel(1, 0).0, diverging(1.0));
        assert_eq!(image.get_pixel(2, 0).0, diverging(-1.0));
        assert_eq!(a.sorted_differences(&b), [0.0, 1.0, 8.0]);
        assert!(data_uri(&[1]).starts_with("data:image/png;base64,"));
        assert_eq!(a.plus(&b).pixels[2], [10.0; 3]);
    }
}
