//! Textures: images with the way they are laid over surfaces.

use glam::{Mat2, Vec2};
use gltf_json::texture::{self, MagFilter, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Value, image as document};

use super::{Builder, entry, label};
use crate::load::LoadError;
use crate::load::image::{Encoding, decode};
use crate::{Filter, Sampler, Texture, Wrap};

/// A texture as a material refers to it.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) texture: Texture,
    pub(super) mapping: Mapping,
}

/// Which texture coordinates a texture takes, and what is done to them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mapping {
    /// Number of the `TEXCOORD` attribute.
    pub(super) set: u32,
    offset: Vec2,
    linear: Mat2,
}

impl Mapping {
    /// The coordinates that the texture is looked up with.
    pub(super) fn apply(&self, coordinates: &mut [Vec2]) {
        if self.offset != Vec2::ZERO || self.linear != Mat2::IDENTITY {
            for uv in coordinates {
                *uv = self.linear * *uv + self.offset;
            }
        }
    }
}

impl Builder<'_> {
    /// The texture that a material refers to by a texture info; `None`, and a
    /// note, if it cannot be read.
    pub(super) fn placed_texture(
        &mut self,
        info: &texture::Info,
        value: Option<&Value>,
        owner: &str,
    ) -> Result<Option<Placed>, LoadError> {
        let mapping = mapping(info.tex_coord, value, owner)?;
        let texture = self.texture(info.index, Encoding::Srgb, owner)?;
        Ok(texture.map(|texture| Placed { texture, mapping }))
    }

    /// The same of a texture info in an extension, whose image holds shares.
    pub(super) fn placed_shares(
        &mut self,
        info: &Value,
        owner: &str,
    ) -> Result<Option<Placed>, LoadError> {
        let number = |name: &str| match info.get(name) {
            None => Ok(None),
            Some(value) => {
                let number = value.as_u64().and_then(|n| u32::try_from(n).ok());
                let bad = || {
                    let expected = "whole numbers as index and texCoord";
                    LoadError::bad_value(format!("a texture of {owner}"), "damaged", expected)
                };
                number.map(Some).ok_or_else(bad)
            }
        };
        let Some(index) = number("index")? else {
            let what = format!("a texture of {owner}");
            return Err(LoadError::bad_value(what, "nameless", "an index"));
        };
        let mapping = mapping(number("texCoord")?.unwrap_or(0), Some(info), owner)?;
        let texture = self.texture(Index::new(index), Encoding::Linear, owner)?;
        Ok(texture.map(|texture| Placed { texture, mapping }))
    }

    fn texture(
        &mut self,
        index: Index<texture::Texture>,
        encoding: Encoding,
        owner: &str,
    ) -> Result<Option<Texture>, LoadError> {
        let texture = entry(&self.root.textures, index, owner, "texture")?;
        let what = label("texture", index.value(), texture.name.as_deref());
        let sampler = match texture.sampler {
            Some(index) => sampler(entry(&self.root.samplers, index, &what, "sampler")?),
            None => Sampler::default(),
        };
        let image = self.encoded_image(texture.source, encoding, &what);
        Ok(image.map(|texture| texture.with_sampler(sampler)))
    }

    /// An image of the document in colour; `None`, and a note, if it cannot be read.
    /// Each is decoded once.
    pub(super) fn image(&mut self, index: Index<document::Image>, owner: &str) -> Option<Texture> {
        self.encoded_image(index, Encoding::Srgb, owner)
    }

    fn encoded_image(
        &mut self,
        index: Index<document::Image>,
        encoding: Encoding,
        owner: &str,
    ) -> Option<Texture> {
        let key = (index.value(), encoding);
        if let Some(decoded) = self.images.get(&key) {
            return decoded.clone();
        }
        let decoded = match self.decoded_image(index, encoding, owner) {
            Ok(texture) => Some(texture),
            Err(error) => {
                self.notes.add(format!("{owner} left out: {error}"));
                None
            }
        };
        self.images.insert(key, decoded.clone());
        decoded
    }

    fn decoded_image(
        &mut self,
        index: Index<document::Image>,
        encoding: Encoding,
        owner: &str,
    ) -> Result<Texture, LoadError> {
        let image = entry(&self.root.images, index, owner, "image")?;
        let what = label("image", index.value(), image.name.as_deref());
        match (&image.uri, image.buffer_view) {
            (Some(uri), None) => {
                let bytes = self.buffers.open(uri, &what, &mut self.budget)?;
                decode(&bytes, encoding, &what, &mut self.budget)
            }
            (_, Some(view)) => {
                let bytes = self.buffers.view(view, &what, &mut self.budget)?;
                decode(bytes, encoding, &what, &mut self.budget)
            }
            (None, None) => Err(LoadError::bad_value(
                what,
                "empty",
                "a URI or a buffer view",
            )),
        }
    }
}

/// How glTF's sampler continues and filters an image. Mipmaps have no effect.
fn sampler(sampler: &texture::Sampler) -> Sampler {
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let filter = match sampler.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        _ => Filter::Linear,
    };
    Sampler {
        wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)],
        filter,
    }
}

/// `KHR_texture_transform`, if the texture info has it: T · R · S.
fn mapping(set: u32, value: Option<&Value>, owner: &str) -> Result<Mapping, LoadError> {
    let transform = value
        .and_then(|info| info.get("extensions"))
        .and_then(|extensions| extensions.get("KHR_texture_transform"));
    let Some(transform) = transform else {
        return Ok(Mapping {
            set,
            offset: Vec2::ZERO,
            linear: Mat2::IDENTITY,
        });
    };
    let bad = || {
        LoadError::bad_value(
            format!("KHR_texture_transform of {owner}"),
            "damaged",
            "offset and scale of two numbers, rotation in radians, a whole texCoord",
        )
    };
    let number = |value: &Value| {
        let number = value.as_f64().map(|number| number as f32);
        number.filter(|number| number.is_finite()).ok_or_else(bad)
    };
    let pair = |name: &str, default: Vec2| match transform.get(name) {
        None => Ok(default),
        Some(value) => match value.as_array().map(Vec::as_slice) {
            Some([x, y]) => Ok(Vec2::new(number(x)?, number(y)?)),
            _ => Err(bad()),
        },
    };
    let (offset, scale) = (pair("offset", Vec2::ZERO)?, pair("scale", Vec2::ONE)?);
    let rotation = transform.get("rotation").map_or(Ok(0.0), number)?;
    let set = match transform.get("texCoord") {
        None => set,
        Some(value) => {
            let set = value.as_u64().and_then(|set| u32::try_from(set).ok());
            set.ok_or_else(bad)?
        }
    };
    let (sin, cos) = rotation.sin_cos();
    // Counter-clockwise in the image, whose v points down.
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    Ok(Mapping {
        set,
        offset,
        linear: rotation * Mat2::from_diagonal(scale),
    })
}
