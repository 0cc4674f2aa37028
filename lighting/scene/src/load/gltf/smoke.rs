//! Smoke that the `extras` of a node name.

use glam::{Affine3A, Vec3};
use gltf_json::Value;

use super::Builder;
use super::medium::{Fields, OF_PHASE};
use crate::load::{
    LoadError, LoadOptions, OPEN_VDB, SmokeColours, from_nvdb, from_vdb, from_vol, printable,
};
use crate::{DensityGrid, Translucent};

impl Builder<'_> {
    /// Adds the grids of a node's `smoke`, which stand where the node does.
    pub(super) fn smoke(
        &mut self,
        index: usize,
        name: &str,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let Some(extras) = self.extras("nodes", index) else {
            return Ok(());
        };
        let Some(fields) = Fields::of(extras, "smoke", &["uri", "albedo", "emission"])? else {
            return Ok(());
        };
        let owner = format!("the smoke of {name}");
        let mut open = |uri: &Value, field: &str, expected| match uri.as_str() {
            Some(uri) => self.buffers.open(uri, &owner, &mut self.budget),
            None => Err(fields.bad(field, uri, expected)),
        };
        let uri = fields.get("uri").unwrap_or(&Value::Null);
        let bytes = open(uri, "uri", "the URI of a VOL, NanoVDB or OpenVDB file")?;
        let mut colours = |field: &str, own: &[&str]| {
            let Some(object) = fields.get(field).filter(|value| value.is_object()) else {
                return Ok(None);
            };
            check_names(object, field, own)?;
            let file = object.get("uri");
            let file = file.map(|uri| open(uri, field, "the URI of a VOL file"));
            file.transpose()
        };
        let albedo_file = colours("albedo", &["uri"])?;
        let emission_file = colours("emission", &["uri", "scale"])?;
        let emission = fields.get("emission");
        let says_nothing =
            |value: &&Value| value.as_object().is_none_or(|fields| fields.is_empty());
        if let Some(value) = emission.filter(says_nothing) {
            return Err(fields.bad("emission", value, "an object with a uri, a scale or both"));
        }
        let colours = SmokeColours {
            albedo: albedo_file.as_deref(),
            emission: emission_file.as_deref(),
            emission_scale: match emission.and_then(|emission| emission.get("scale")) {
                Some(scale) => Some(fields.as_colour("emission.scale", scale)?),
                None => None,
            },
        };
        let options = LoadOptions::default();
        let loaded = match &bytes[..] {
            [b'V', b'O', b'L', ..] => from_vol(&bytes, &options)?,
            [b'N', b'a', b'n', b'o', ..] => from_nvdb(&bytes, &options)?,
            bytes if bytes.starts_with(&OPEN_VDB) => from_vdb(bytes, &options)?,
            _ => {
                return Err(LoadError::Unsupported(format!(
                    "{owner}, which is neither VOL, NanoVDB nor OpenVDB,"
                )));
            }
        };
        let mut notes = loaded.notes;
        for caster in loaded.scene.translucent {
            let Translucent::Grid(grid) = caster else {
                continue;
            };
            let own = grid.transform();
            let emits = emission_file.is_some() || !grid.emission().is_empty();
            let lists = usize::from(albedo_file.is_some()) + usize::from(emits);
            let size = size_of::<f32>() + lists * size_of::<Vec3>();
            // What a file may be decoded to is limited for each; the scene keeps all of them.
            self.budget
                .take(&owner, grid.density().len() as u64, size)?;
            let grid = colours.apply(grid, options.up, &options, &mut notes)?;
            let mut grid = grid.with_transform(world * own)?;
            if albedo_file.is_none()
                && let Some(albedo) = fields.colour("albedo")?
            {
                grid = grid.with_albedo(albedo)?;
            }
            if OF_PHASE.iter().any(|field| fields.get(field).is_some()) {
                grid = DensityGrid::with_phase(grid, fields.phase()?)?;
            }
            self.scene.translucent.push(grid.into());
        }
        for note in notes {
            self.notes.add(format!("{owner}: {note}"));
        }
        Ok(())
    }
}

/// Refuses fields of an object that it does not have.
fn check_names(object: &Value, owner: &str, own: &[&str]) -> Result<(), LoadError> {
    let mut names = object
        .as_object()
        .into_iter()
        .flat_map(|object| object.keys());
    match names.find(|name| !own.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => Err(LoadError::bad_value(
            format!("a field of \"{owner}\" in the smoke of the extras"),
            printable(name),
            "uri, or scale of an emission",
        )),
    }
}
