//! Smoke that the `extras` of a node name.

use glam::Affine3A;
use gltf_json::Value;

use super::Builder;
use super::medium::{Fields, OF_PHASE};
use crate::load::{LoadError, LoadOptions, OPEN_VDB, from_nvdb, from_vdb, from_vol};
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
        let Some(fields) = Fields::of(extras, "smoke", &["uri", "albedo"])? else {
            return Ok(());
        };
        let uri = fields.get("uri");
        let Some(uri) = uri.and_then(Value::as_str) else {
            let value = uri.unwrap_or(&Value::Null);
            return Err(fields.bad("uri", value, "the URI of a VOL, NanoVDB or OpenVDB file"));
        };
        let owner = format!("the smoke of {name}");
        let bytes = self.buffers.open(uri, &owner, &mut self.budget)?;
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
        for note in loaded.notes {
            self.notes.add(format!("{owner}: {note}"));
        }
        for caster in loaded.scene.translucent {
            let Translucent::Grid(grid) = caster else {
                continue;
            };
            let own = grid.transform();
            let mut grid = grid.with_transform(world * own)?;
            if let Some(albedo) = fields.colour("albedo")? {
                grid = grid.with_albedo(albedo)?;
            }
            if OF_PHASE.iter().any(|field| fields.get(field).is_some()) {
                grid = DensityGrid::with_phase(grid, fields.phase()?)?;
            }
            self.scene.translucent.push(grid.into());
        }
        Ok(())
    }
}
