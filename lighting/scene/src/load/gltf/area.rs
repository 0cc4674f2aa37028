//! Lights of EXT_lights_area.

use glam::{Affine3A, Vec3};
use gltf_json::Value;

use super::node::rotation;
use super::{Builder, extras};
use crate::load::LoadError;
use crate::load::error::printable;
use crate::{AreaLight, AreaShape, Light, SceneError};

impl Builder<'_> {
    /// The area light of a node, if it has one.
    pub(super) fn extension_area_light(
        &mut self,
        number: usize,
        name: &str,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let Some(reference) = self.extension("nodes", number, "EXT_lights_area") else {
            return Ok(());
        };
        let lights = self.value.get("extensions");
        let lights = lights.and_then(|extensions| extensions.get("EXT_lights_area"));
        let lights = lights.and_then(|extension| extension.get("lights"));
        let lights = lights
            .and_then(Value::as_array)
            .map_or(&[][..], Vec::as_slice);
        let index = reference.get("light").and_then(Value::as_u64);
        let index = index.unwrap_or(u64::MAX);
        let light = usize::try_from(index)
            .ok()
            .and_then(|index| lights.get(index));
        let Some(light) = light else {
            return Err(LoadError::Scene(SceneError::IndexOutOfRange {
                owner: name.to_owned(),
                what: "area light",
                index,
                count: lights.len() as u64,
            }));
        };
        let own_name = light.get("name").and_then(Value::as_str);
        let own_name = own_name.filter(|name| !name.is_empty());
        let what = match own_name {
            Some(name) => format!("area light {index} \"{}\"", printable(name)),
            None => format!("area light {index}"),
        };
        let field = |owner: &Value, field: &'static str, default: f32| match owner.get(field) {
            None => Ok(default),
            Some(value) => {
                let number = extras::number(value).filter(|number| *number >= 0.0);
                number.ok_or_else(|| {
                    LoadError::bad_value(
                        format!("{field} of {what}"),
                        extras::kind(value),
                        "a finite number, not negative",
                    )
                })
            }
        };
        let color = match light.get("color") {
            None => Vec3::ONE,
            Some(value) => {
                let channels = value.as_array().map_or(&[][..], Vec::as_slice);
                let channels: Vec<f32> = channels.iter().filter_map(extras::number).collect();
                match channels[..] {
                    [r, g, b] if r.min(g).min(b) >= 0.0 => Vec3::new(r, g, b),
                    _ => {
                        return Err(LoadError::bad_value(
                            format!("the color of {what}"),
                            extras::kind(value),
                            "three finite numbers, not negative",
                        ));
                    }
                }
            }
        };
        let (shape, aspect) = match light.get("type").and_then(Value::as_str) {
            Some("rect") => {
                let rectangle = light.get("rect").unwrap_or(&Value::Null);
                (AreaShape::Rectangle, field(rectangle, "aspect", 1.0)?)
            }
            Some("disk") => (AreaShape::Disk, 1.0),
            _ => {
                return Err(LoadError::bad_value(
                    format!("the type of {what}"),
                    "unknown",
                    "rect or disk",
                ));
            }
        };
        let radiance = color * field(light, "intensity", 1000.0)?;
        let axes = world.matrix3;
        let scale = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length());
        let scale = scale.into_iter().fold(0.0, f32::max);
        let height = scale * field(light, "size", 1.0)?;
        let width = height * aspect;
        let Some(rotation) = rotation(world).filter(|_| width > 0.0 && height > 0.0) else {
            self.notes.add(format!("{what} ignored: it has no area"));
            return Ok(());
        };
        // It shines along −Z: −X × Y.
        let edges = [rotation * (-width * Vec3::X), rotation * (height * Vec3::Y)];
        let called = own_name.map(str::to_owned);
        let called = called.or_else(|| self.root.nodes[number].name.clone());
        let called = called.unwrap_or_default();
        self.budget
            .take(&what, 1, size_of::<Light>() + called.len())?;
        self.scene.lights.push(Light::Area(AreaLight {
            name: called,
            shape,
            corner: Vec3::from(world.translation) - 0.5 * (edges[0] + edges[1]),
            edges,
            radiance,
            texture: None,
        }));
        Ok(())
    }
}
