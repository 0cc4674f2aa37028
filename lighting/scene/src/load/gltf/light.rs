//! Lights of KHR_lights_punctual.

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, Quat, Vec3};
use gltf_json::Index;
use gltf_json::extensions::scene::khr_lights_punctual::{Light as Punctual, Type};
use gltf_json::validation::Checked;

use super::node::rotation;
use super::{Builder, entry, extras, label};
use crate::load::LoadError;
use crate::{Cone, DirectionalLight, Falloff, Light, PointLight, SpotLight, Texture};

/// A cookie spans the square around the outer cone, which must be finite.
const WIDEST_COOKIE: f32 = 1.5;

impl Builder<'_> {
    pub(super) fn punctual_light(
        &mut self,
        number: usize,
        name: &str,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let node = &self.root.nodes[number];
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
        let mut range = light.range.unwrap_or(f32::INFINITY);
        if range == 0.0 {
            range = f32::INFINITY;
            self.notes.add(format!(
                "the range of {what} is 0, which is taken for no limit"
            ));
        }
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
        // Editors put what the user adds to a light on its node.
        let of_light = || {
            let extension = self.value.get("extensions")?.get("KHR_lights_punctual")?;
            let lights = extension.get("lights")?;
            lights.get(reference.light.value())?.get("extras")
        };
        let extras = [of_light(), self.extras("nodes", number)];
        let mut falloff = None;
        for extras in extras.into_iter().flatten() {
            falloff = falloff.or(extras::falloff(extras, &what)?);
        }
        let falloff = falloff.unwrap_or(Falloff::Smooth);
        let own_name = light.name.as_ref().filter(|name| !name.is_empty());
        let called = own_name.or(node.name.as_ref()).cloned().unwrap_or_default();
        self.budget
            .take(&what, 1, size_of::<Light>() + called.len())?;
        let light = match kind {
            Type::Point => Light::Point(PointLight {
                name: called,
                position,
                intensity: power,
                range,
                falloff,
            }),
            Type::Directional => {
                let mut angular_diameter = None;
                for extras in extras.into_iter().flatten() {
                    angular_diameter =
                        angular_diameter.or(extras::angular_diameter(extras, &what)?);
                }
                Light::Directional(DirectionalLight {
                    name: called,
                    direction: rotation * Vec3::NEG_Z,
                    irradiance: power,
                    angular_diameter: angular_diameter.unwrap_or(0.0),
                })
            }
            Type::Spot => {
                let cone = self.cone(light, &what)?;
                let mut cookie = None;
                for extras in extras.into_iter().flatten() {
                    cookie = cookie.or(extras::cookie(extras, &what)?);
                }
                let (texture, turn) = self.cookie(cookie, cone, &what)?;
                Light::Spot(SpotLight {
                    name: called,
                    position,
                    rotation: rotation * turn,
                    intensity: power,
                    range,
                    falloff,
                    cone,
                    texture,
                })
            }
        };
        self.scene.lights.push(light);
        Ok(())
    }

    /// The image in front of a spotlight, and how the light turns with it.
    fn cookie(
        &mut self,
        cookie: Option<(u32, f32)>,
        cone: Cone,
        what: &str,
    ) -> Result<(Option<Texture>, Quat), LoadError> {
        let Some((image, rotation)) = cookie else {
            return Ok((None, Quat::IDENTITY));
        };
        if cone.outer > WIDEST_COOKIE {
            return Err(LoadError::bad_value(
                format!("the cone of {what}, which has a cookie,"),
                format!("{} rad", cone.outer),
                "at most 1.5 rad",
            ));
        }
        entry(
            &self.root.images,
            Index::new(image),
            &format!("the cookie of {what}"),
            "image",
        )?;
        let texture = self.image(Index::new(image), &format!("the cookie of {what}"));
        // The light looks along −Z: what turns about +Z turns counter-clockwise.
        Ok((texture, Quat::from_rotation_z(rotation)))
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
