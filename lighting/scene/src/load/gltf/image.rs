//! Textures: images decoded to linear RGB.

use std::io::Cursor;

use glam::Vec3;
use gltf_json::{Index, image as document, texture};
use image::{DynamicImage, ImageDecoder, ImageReader, Limits};

use super::{Builder, entry, label};
use crate::Texture;
use crate::load::LoadError;
use crate::load::limits::Budget;

/// Images are at most this many pixels wide and high.
const MAX_SIDE: u32 = 8192;

impl Builder<'_> {
    /// The texture that a material refers to; `None`, and a note, if it cannot
    /// be read. Each image is decoded once.
    pub(super) fn texture(
        &mut self,
        index: Index<texture::Texture>,
        owner: &str,
    ) -> Result<Option<Texture>, LoadError> {
        let texture = entry(&self.root.textures, index, owner, "texture")?;
        let what = label("texture", index.value(), texture.name.as_deref());
        let image = texture.source.value();
        if let Some(decoded) = self.images.get(&image) {
            return Ok(decoded.clone());
        }
        let decoded = match self.image(texture.source, &what) {
            Ok(texture) => Some(texture),
            Err(error) => {
                self.notes.add(format!("{what} left out: {error}"));
                None
            }
        };
        self.images.insert(image, decoded.clone());
        Ok(decoded)
    }

    fn image(&mut self, index: Index<document::Image>, owner: &str) -> Result<Texture, LoadError> {
        let image = entry(&self.root.images, index, owner, "image")?;
        let what = label("image", index.value(), image.name.as_deref());
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                let bytes = self.buffers.open(uri, &what, &mut self.budget)?;
                decode(&bytes, &what, &mut self.budget)
            }
            (None, Some(view)) => {
                let bytes = self.buffers.view(view, &what, &mut self.budget)?;
                decode(bytes, &what, &mut self.budget)
            }
            (None, None) => Err(LoadError::bad_value(
                what,
                "empty",
                "a URI or a buffer view",
            )),
        }
    }
}

fn decode(bytes: &[u8], what: &str, budget: &mut Budget) -> Result<Texture, LoadError> {
    let unreadable =
        |error: &dyn std::fmt::Display| LoadError::Unsupported(format!("{what} ({error})"));
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
    let decoder = reader.into_decoder().map_err(|error| unreadable(&error))?;
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
    // One copy in three channels, one in linear RGB.
    budget.take(what, pixels, 6 + size_of::<Vec3>())?;
    let image = DynamicImage::from_decoder(decoder).map_err(|error| unreadable(&error))?;
    let texels = if image.color().bytes_per_pixel() == image.color().channel_count() {
        let table: Vec<f32> = (0..=255)
            .map(|value| linear(value as f32 / 255.0))
            .collect();
        let lookup = |channel: u8| table[usize::from(channel)];
        let image = image.into_rgb8();
        image
            .pixels()
            .map(|p| Vec3::from(p.0.map(lookup)))
            .collect()
    } else {
        let lookup = |channel: u16| linear(f32::from(channel) / 65535.0);
        let image = image.into_rgb16();
        image
            .pixels()
            .map(|p| Vec3::from(p.0.map(lookup)))
            .collect()
    };
    Ok(Texture::new(width, height, texels)?)
}

/// The inverse of the transfer function of sRGB (IEC 61966-2-1).
fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}
