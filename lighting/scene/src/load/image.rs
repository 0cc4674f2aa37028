//! Images decoded to linear RGB and opacity.

use std::io::Cursor;

use glam::Vec3;
use image::{DynamicImage, ImageDecoder, ImageReader, Limits};

use super::LoadError;
use super::limits::Budget;
use crate::Texture;

/// Images are at most this many pixels wide and high.
const MAX_SIDE: u32 = 8192;

/// What the numbers of an image stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Encoding {
    /// Colours in sRGB.
    Srgb,
    /// Shares, as they are.
    #[cfg(feature = "gltf")]
    Linear,
}

impl Encoding {
    fn linear(self, encoded: f32) -> f32 {
        match self {
            Self::Srgb => linear(encoded),
            #[cfg(feature = "gltf")]
            Self::Linear => encoded,
        }
    }
}

/// Decodes a PNG or JPEG image; its alpha channel is kept if it is not
/// opaque everywhere.
pub(super) fn decode(
    bytes: &[u8],
    encoding: Encoding,
    what: &str,
    budget: &mut Budget,
) -> Result<Texture, LoadError> {
    let unreadable =
        |error: &dyn std::fmt::Display| LoadError::Unsupported(format!("{what} ({error})"));
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Err(unreadable(&"WebP"));
    }
    if bytes.starts_with(b"\xabKTX 20\xbb\r\n\x1a\n") {
        return Err(unreadable(&"KTX2"));
    }
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| unreadable(&error))?;
    if reader.format().is_none() {
        return Err(unreadable(&"neither PNG nor JPEG"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    reader.limits(limits);
    // What the decoder says may repeat bytes of the file.
    let damaged = |_| unreadable(&"damaged, or of a kind that is not supported");
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(LoadError::bad_value(
            format!("the size of {what}"),
            format!("{width} x {height}"),
            "at most 8192 x 8192",
        ));
    }
    let pixels = u64::from(width) * u64::from(height);
    budget.take(what, decoder.total_bytes(), 1)?;
    // One copy in four channels, one in linear RGB and alpha.
    budget.take(what, pixels, 8 + size_of::<Vec3>() + size_of::<f32>())?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let has_alpha = image.color().has_alpha();
    let (texels, alpha): (Vec<Vec3>, Vec<f32>);
    if image.color().bytes_per_pixel() == image.color().channel_count() {
        let table: Vec<f32> = (0..=255)
            .map(|value| encoding.linear(value as f32 / 255.0))
            .collect();
        let lookup = |channel: u8| table[usize::from(channel)];
        let image = image.into_rgba8();
        let colour = |p: &image::Rgba<u8>| Vec3::new(lookup(p[0]), lookup(p[1]), lookup(p[2]));
        texels = image.pixels().map(colour).collect();
        let opacity = image.pixels().map(|p| f32::from(p[3]) / 255.0);
        alpha = if has_alpha {
            opacity.collect()
        } else {
            Vec::new()
        };
    } else {
        let lookup = |channel: u16| encoding.linear(f32::from(channel) / 65535.0);
        let image = image.into_rgba16();
        let colour = |p: &image::Rgba<u16>| Vec3::new(lookup(p[0]), lookup(p[1]), lookup(p[2]));
        texels = image.pixels().map(colour).collect();
        let opacity = image.pixels().map(|p| f32::from(p[3]) / 65535.0);
        alpha = if has_alpha {
            opacity.collect()
        } else {
            Vec::new()
        };
    }
    let texture = Texture::new(width, height, texels)?;
    if alpha.iter().all(|alpha| *alpha == 1.0) {
        return Ok(texture);
    }
    Ok(texture.with_alpha(alpha)?)
}

/// The inverse of the transfer function of sRGB (IEC 61966-2-1).
fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}
