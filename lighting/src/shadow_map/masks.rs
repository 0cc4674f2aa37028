//! Masks as the shaders of shadow maps read them.

use std::collections::BTreeMap;

use glam::Vec2;
use gpu_backend::{Backend, Error, Memory};

use super::masked::Masked;
use crate::scene::{AlphaMode, Caster, Coating, Filter, Wrap};

/// Words of a record: `light_Mask` of `mask.wgsl`.
pub(crate) const WORDS: usize = 16;

/// The masks of the masked triangles of a scene.
#[derive(Debug)]
pub(crate) struct Masks<M: Memory> {
    /// One record for each masked triangle.
    pub(crate) records: M::Buffer<[u32; WORDS]>,
    /// The opacities of all textures, one after the other.
    pub(crate) opacities: M::Buffer<f32>,
}

impl<M: Memory> Masks<M> {
    pub(super) fn upload<B: Backend<Memory = M>>(
        backend: &B,
        masked: &Masked,
    ) -> Result<Self, Error> {
        let mut opacities = Vec::new();
        // For the address of a texture's texels, the index of the first of them in `opacities`.
        let mut known = BTreeMap::new();
        let mut records = Vec::with_capacity(masked.len());
        for index in 0..masked.len() {
            if let Caster::Masked(coating) = masked.caster(index) {
                records.push(record(&coating, |texels| {
                    *known.entry(texels.as_ptr()).or_insert_with(|| {
                        opacities.extend_from_slice(texels);
                        opacities.len() - texels.len()
                    })
                })?);
            }
        }
        Ok(Self {
            records: backend.upload(&records)?,
            opacities: backend.upload(&opacities)?,
        })
    }
}

/// The record of a triangle; `first` gives the index of a texture's first texel.
fn record(
    coating: &Coating<'_>,
    first: impl FnOnce(&[f32]) -> usize,
) -> Result<[u32; WORDS], Error> {
    let mut words = [0; WORDS];
    let mut coordinates = coating.texture_coordinates();
    if let Some(texture) = coating.texture()
        && !coordinates.iter().all(|uv| uv.is_finite())
    {
        // Coordinates that are not finite count as the middle of the first texel.
        let size = Vec2::new(texture.width() as f32, texture.height() as f32);
        coordinates = [0.5 / size; 3];
    }
    for (word, value) in words
        .iter_mut()
        .zip(coordinates.map(|uv| uv.to_array()).as_flattened())
    {
        *word = value.to_bits();
    }
    for (word, color) in words[6..].iter_mut().zip(coating.colors()) {
        *word = (coating.base_opacity() * color.w).to_bits();
    }
    if let AlphaMode::Mask { cutoff } = coating.mode() {
        words[9] = cutoff.to_bits();
    }
    if let Some(texture) = coating.texture()
        && let Some(alpha) = texture.alpha()
    {
        let first = first(alpha);
        words[10] = u32::try_from(first).map_err(|_| Error::TooLarge {
            what: "the opacities of masks",
            requested: 4 * first as u64,
            limit: 4 * u64::from(u32::MAX),
        })?;
        let sampler = texture.sampler();
        let wrap = |wrap: Wrap| match wrap {
            Wrap::Repeat => 0,
            Wrap::Mirror => 1,
            Wrap::Clamp => 2,
        };
        words[11] = texture.width();
        words[12] = texture.height();
        words[13] = wrap(sampler.wrap[0]);
        words[14] = wrap(sampler.wrap[1]);
        words[15] = u32::from(sampler.filter == Filter::Nearest);
    }
    Ok(words)
}
