//! Lambertian materials and what they emit.

use glam::Vec3;
use gltf_json::material::AlphaMode;
use gltf_json::validation::Checked;
use gltf_json::{Index, material};

use super::texture::{Mapping, Placed};
use super::{Builder, entry, extras, label};
use crate::Material;
use crate::load::LoadError;

/// A material of the document that has been taken over.
#[derive(Debug, Clone)]
pub(super) struct Converted {
    /// Index into the scene's materials.
    pub(super) index: usize,
    pub(super) name: String,
    /// The texture coordinates that the albedo needs, if it is textured.
    pub(super) mapping: Option<Mapping>,
    /// The same of the transmission.
    pub(super) transmission_mapping: Option<Mapping>,
    pub(super) emission: Option<Emission>,
    pub(super) double_sided: bool,
    pub(super) no_shadow: bool,
}

/// Light that leaves a surface.
#[derive(Debug, Clone)]
pub(super) struct Emission {
    /// Radiance before the texture.
    pub(super) radiance: Vec3,
    pub(super) texture: Option<Placed>,
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
        let value = self
            .value
            .get("materials")
            .and_then(|m| m.get(index.value()));
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, opacity] = pbr.base_color_factor.0;
        if !(0.0..=1.0).contains(&opacity) {
            return Err(LoadError::bad_value(
                format!("the alpha of baseColorFactor of {what}"),
                opacity,
                "0 to 1",
            ));
        }
        let alpha = match material.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => crate::AlphaMode::Opaque,
            Checked::Valid(AlphaMode::Blend) => crate::AlphaMode::Blend,
            Checked::Valid(AlphaMode::Mask) => crate::AlphaMode::Mask {
                cutoff: material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0),
            },
            Checked::Invalid => {
                return Err(LoadError::bad_value(
                    format!("alphaMode of {what}"),
                    "unknown",
                    "OPAQUE, MASK or BLEND",
                ));
            }
        };
        if let crate::AlphaMode::Mask { cutoff } = alpha
            && !(cutoff.is_finite() && cutoff >= 0.0)
        {
            return Err(LoadError::bad_value(
                format!("alphaCutoff of {what}"),
                cutoff,
                "finite, not negative",
            ));
        }
        let base_color = Vec3::new(r, g, b);
        if !(base_color.cmpge(Vec3::ZERO).all() && base_color.cmple(Vec3::ONE).all()) {
            return Err(LoadError::bad_value(
                format!("baseColorFactor of {what}"),
                base_color,
                "numbers from 0 to 1",
            ));
        }
        let base_color_texture = match &pbr.base_color_texture {
            Some(info) => {
                let info_value = value
                    .and_then(|value| value.get("pbrMetallicRoughness"))
                    .and_then(|pbr| pbr.get("baseColorTexture"));
                let placed = self.placed_texture(info, info_value, &what)?;
                if placed.is_none() && alpha != crate::AlphaMode::Opaque {
                    self.notes.add(format!(
                        "{what} has the opacity of its factor alone: its texture is missing"
                    ));
                }
                placed
            }
            None => None,
        };
        let (transmission, transmission_texture) = self.transmission(index.value(), &what)?;
        let emission = self.emission(material, index.value(), &what)?;
        let emitted = match &emission {
            None => Vec3::ZERO,
            Some(Emission {
                radiance,
                texture: None,
            }) => *radiance,
            Some(Emission {
                radiance,
                texture: Some(Placed { texture, .. }),
            }) => {
                self.notes.add(format!(
                    "the emissive texture of {what} is averaged where its surface is seen"
                ));
                radiance * texture.mean()
            }
        };
        let name = material.name.clone().unwrap_or_default();
        let converted = Converted {
            index: self.scene.materials.len(),
            name: name.clone(),
            mapping: base_color_texture.as_ref().map(|placed| placed.mapping),
            transmission_mapping: transmission_texture.as_ref().map(|placed| placed.mapping),
            emission,
            double_sided: material.double_sided,
            no_shadow: extras::no_shadow(self.extras("materials", index.value()), &what)?
                == Some(true),
        };
        self.budget
            .take(&what, 1, size_of::<Material>() + 2 * name.len())?;
        self.scene.materials.push(Material {
            name,
            base_color,
            base_color_texture: base_color_texture.map(|placed| placed.texture),
            emitted,
            opacity,
            alpha,
            transmission,
            transmission_texture: transmission_texture.map(|placed| placed.texture),
            double_sided: material.double_sided,
        });
        self.materials.insert(index.value(), converted.clone());
        Ok(converted)
    }

    /// The material of primitives that name none: white.
    pub(super) fn plain_material(&mut self) -> Result<usize, LoadError> {
        if let Some(index) = self.plain {
            return Ok(index);
        }
        let index = self.scene.materials.len();
        self.budget.take("materials", 1, size_of::<Material>())?;
        self.scene.materials.push(Material {
            base_color: Vec3::ONE,
            ..Material::default()
        });
        self.plain = Some(index);
        Ok(index)
    }

    /// `KHR_materials_transmission`: the factor, and the texture that multiplies it.
    fn transmission(
        &mut self,
        index: usize,
        what: &str,
    ) -> Result<(f32, Option<Placed>), LoadError> {
        let extension = self.extension("materials", index, "KHR_materials_transmission");
        let Some(extension) = extension else {
            return Ok((0.0, None));
        };
        let Some(value) = extension.get("transmissionFactor") else {
            return Ok((0.0, None));
        };
        let factor = extras::number(value).filter(|factor| (0.0..=1.0).contains(factor));
        let Some(factor) = factor else {
            return Err(LoadError::bad_value(
                format!("transmissionFactor of {what}"),
                extras::number(value)
                    .map_or_else(|| extras::kind(value).into(), |number| number.to_string()),
                "0 to 1",
            ));
        };
        let texture = extension
            .get("transmissionTexture")
            .filter(|_| factor > 0.0)
            .cloned();
        let Some(info) = texture else {
            return Ok((factor, None));
        };
        let placed = self.placed_shares(&info, what)?;
        if placed.is_none() {
            self.notes.add(format!(
                "{what} has the transmission of its factor alone: its texture is missing"
            ));
        }
        Ok((factor, placed))
    }

    fn emission(
        &mut self,
        material: &material::Material,
        index: usize,
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
            Some(info) => {
                let value = self.value.get("materials").and_then(|m| m.get(index));
                let value = value.and_then(|value| value.get("emissiveTexture"));
                self.placed_texture(info, value, what)?
            }
            None => None,
        };
        Ok(Some(Emission { radiance, texture }))
    }
}
