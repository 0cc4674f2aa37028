//! Lights of KHR_lights_punctual.

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, Vec3};
use gltf_json::Node;
use gltf_json::extensions::scene::khr_lights_punctual::{Light as Punctual, Type};
use gltf_json::validation::Checked;

use super::node::rotation;
use super::{Builder, entry, label};
use crate::load::LoadError;
use crate::{Cone, DirectionalLight, Light, PointLight, SpotLight};

impl Builder<'_> {
    pub(super) fn punctual_light(
        &mut self,
        node: &Node,
        name: &str,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let extension = node.extensions.as_ref();
        let Some(reference) = extension.and_then(|e| e.khr_lights_punctual.as_ref()) else {
            return Ok(());
        };
        let lights: &[Punctual] = self.root.as_ref();
        let light = entry(lights, reference.light, name, "light")?;
        let what = label("light", reference.light.value(), light.name.as_deref());
        let power = Vec3::from(light.color) * light.intensity;
        if !(power.is_finite() && power.min_element() >= 0.0) {
            return Err(LoadError::bad_value(
                format!("color x intensity of {what}"),
                power,
                "finite, not negative",
            ));
        }
        let range = light.range.unwrap_or(f32::INFINITY);
        if !(range > 0.0) {
            return Err(LoadError::bad_value(
                format!("the range of {what}"),
                range,
                "a distance above 0",
            ));
        }
        let Checked::Valid(kind) = light.type_.as_ref() else {
            return Err(LoadError::bad_value(
                format!("the type of {what}"),
                "unknown",
                "directional, point or spot",
            ));
        };
        let position = world.translation.into();
        let rotation = match (kind, rotation(world)) {
            (Type::Point, _) => glam::Quat::IDENTITY,
            (_, Some(rotation)) => rotation,
            (_, None) => {
                self.notes
                    .add(format!("{what} ignored: {name} is scaled to nothing"));
                return Ok(());
            }
        };
        self.budget.take(&what, 1, size_of::<Light>())?;
        let light = match kind {
            Type::Point => Light::Point(PointLight {
                position,
                intensity: power,
                range,
            }),
            Type::Directional => Light::Directional(DirectionalLight {
                direction: rotation * Vec3::NEG_Z,
                irradiance: power,
            }),
            Type::Spot => Light::Spot(SpotLight {
                position,
                rotation,
                intensity: power,
                range,
                cone: self.cone(light, &what)?,
                texture: None,
            }),
        };
        self.scene.lights.push(light);
        Ok(())
    }

    fn cone(&mut self, light: &Punctual, what: &str) -> Result<Cone, LoadError> {
        let Some(spot) = &light.spot else {
            return Err(LoadError::bad_value(
                what,
                "without a cone",
                "the property spot",
            ));
        };
        let (mut inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
        if inner == outer {
            // Exporters write this for a hard edge, though the specification
            // wants the angles to differ.
            inner *= 0.999;
            self.notes.add(format!(
                "the edge of {what} was made 0.1 % softer than hard"
            ));
        }
        if !(inner >= 0.0 && inner < outer && outer <= FRAC_PI_2) {
            return Err(LoadError::bad_value(
                format!("the cone of {what}"),
                format!("{inner} to {outer} rad"),
                "0 <= inner < outer <= pi/2",
            ));
        }
        Ok(Cone { inner, outer })
    }
}
