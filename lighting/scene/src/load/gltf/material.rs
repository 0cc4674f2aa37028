//! Lambertian materials and what they emit.

use glam::Vec3;
use gltf_json::material::AlphaMode;
use gltf_json::validation::Checked;
use gltf_json::{Index, material};

use super::{Builder, entry, label};
use crate::load::LoadError;
use crate::{Material, Texture};

/// A material of the document that has been taken over.
#[derive(Debug, Clone)]
pub(super) struct Converted {
    /// Index into the scene's materials.
    pub(super) index: usize,
    /// The texture coordinates that the albedo needs, if it is textured.
    pub(super) base_color_set: Option<u32>,
    pub(super) emission: Option<Emission>,
}

/// Light that leaves a surface.
#[derive(Debug, Clone)]
pub(super) struct Emission {
    /// Radiance before the texture.
    pub(super) radiance: Vec3,
    /// The texture and the texture coordinates that it needs.
    pub(super) texture: Option<(Texture, u32)>,
}

impl Builder<'_> {
    /// Takes a material over into the scene, once.
    pub(super) fn material(
        &mut self,
        index: Index<material::Material>,
        owner: &str,
    ) -> Result<Converted, LoadError> {
        if let Some(converted) = self.materials.get(&index.value()) {
            return Ok(converted.clone());
        }
        let material = entry(&self.root.materials, index, owner, "material")?;
        let what = label("material", index.value(), material.name.as_deref());
        if material.alpha_mode != Checked::Valid(AlphaMode::Opaque) {
            self.notes.add(format!("{what} is drawn opaque"));
        }
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor.0;
        let base_color = Vec3::new(r, g, b);
        if !(base_color.cmpge(Vec3::ZERO).all() && base_color.cmple(Vec3::ONE).all()) {
            return Err(LoadError::bad_value(
                format!("baseColorFactor of {what}"),
                base_color,
                "numbers from 0 to 1",
            ));
        }
        let base_color_texture = match &pbr.base_color_texture {
            Some(info) => self
                .texture(info.index, &what)?
                .map(|t| (t, info.tex_coord)),
            None => None,
        };
        let emission = self.emission(material, &what)?;
        let emitted = match &emission {
            None => Vec3::ZERO,
            Some(Emission {
                radiance,
                texture: None,
            }) => *radiance,
            Some(Emission {
                radiance,
                texture: Some((texture, _)),
            }) => {
                self.notes.add(format!(
                    "the emissive texture of {what} is averaged where its surface is seen"
                ));
                radiance * texture.mean()
            }
        };
        let converted = Converted {
            index: self.scene.materials.len(),
            base_color_set: base_color_texture.as_ref().map(|(_, set)| *set),
            emission,
        };
        self.budget.take(&what, 1, size_of::<Material>())?;
        self.scene.materials.push(Material {
            base_color,
            base_color_texture: base_color_texture.map(|(texture, _)| texture),
            emitted,
        });
        self.materials.insert(index.value(), converted.clone());
        Ok(converted)
    }

    fn emission(
        &mut self,
        material: &material::Material,
        what: &str,
    ) -> Result<Option<Emission>, LoadError> {
        let factor = Vec3::from(material.emissive_factor.0);
        let strength = material
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let radiance = factor * strength;
        if !(radiance.is_finite() && factor.min_element() >= 0.0 && strength >= 0.0) {
            return Err(LoadError::bad_value(
                format!("emissiveFactor x emissiveStrength of {what}"),
                format!("{factor} x {strength}"),
                "finite, not negative",
            ));
        }
        if radiance == Vec3::ZERO {
            return Ok(None);
        }
        let texture = match &material.emissive_texture {
            Some(info) => self.texture(info.index, what)?.map(|t| (t, info.tex_coord)),
            None => None,
        };
        Ok(Some(Emission { radiance, texture }))
    }
}
