//! Which extensions are read, which may be left out, and which may not.

use std::collections::BTreeSet;

use gltf_json::Value;

use super::{Builder, draco};
use crate::load::LoadError;
use crate::load::error::printable;

/// Extensions that are read.
const SUPPORTED: &[&str] = &[
    "EXT_lights_area",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    draco::NAME,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Beginnings of the names of extensions that neither carry geometry nor remove
/// any: what surfaces look like, sound, behaviour, statements about the file.
const HARMLESS: &[&str] = &[
    "ADOBE_materials_",
    "AGI_",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_",
    "GODOT_",
    "KHR_animation_",
    "KHR_audio",
    "KHR_interactivity",
    "KHR_materials_",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_",
    "KHR_texture_",
    "KHR_xmp",
    "MOZ_",
    "MSFT_lod",
    "MSFT_packing_",
    "MSFT_texture_",
    "OMI_",
    "VRM",
];

/// Extensions on nodes or on the document that carry geometry.
const GEOMETRIC: &[&str] = &[
    "CESIUM_RTC",
    "EXT_implicit_",
    "EXT_primitive_voxels",
    "KHR_accessor_float64",
    "KHR_gaussian_splatting",
    "KHR_implicit_shapes",
    "MPEG_mesh_linking",
];

pub(super) fn is_supported(extension: &str) -> bool {
    SUPPORTED.contains(&extension)
}

fn begins_with_any(extension: &str, beginnings: &[&str]) -> bool {
    beginnings
        .iter()
        .any(|beginning| extension.starts_with(beginning))
}

impl Builder<'_> {
    /// Notes the extensions that are left out, or refuses the file.
    pub(super) fn check_extensions(&mut self) -> Result<(), LoadError> {
        let root = self.root;
        let on_data = extensions_on_data(self.value);
        let named = root.extensions_used.iter().chain(&root.extensions_required);
        let all: BTreeSet<&str> = named
            .map(String::as_str)
            .chain(on_data.iter().copied())
            .collect();
        for extension in all {
            if is_supported(extension) {
                continue;
            }
            let shown = printable(extension);
            if begins_with_any(extension, HARMLESS) {
                self.notes.add(format!(
                    "the extension {shown} is ignored; it carries no geometry"
                ));
                continue;
            }
            let is_required = root.extensions_required.iter().any(|e| e == extension);
            let is_geometric = on_data.contains(extension) || begins_with_any(extension, GEOMETRIC);
            if (is_required || is_geometric) && !self.lenient {
                let why = if is_required {
                    "which the file requires"
                } else {
                    "which may carry geometry"
                };
                return Err(LoadError::Unsupported(format!(
                    "the extension {shown}, {why},"
                )));
            }
            let more = if is_required || is_geometric {
                "; geometry may be missing"
            } else {
                ""
            };
            self.notes
                .add(format!("the extension {shown} is ignored{more}"));
        }
        Ok(())
    }
}

/// Names of extensions on primitives, meshes, accessors, buffer views and
/// buffers.
fn extensions_on_data(document: &Value) -> BTreeSet<&str> {
    let list = |name: &str| document.get(name).and_then(Value::as_array);
    let mut owners: Vec<&Value> = Vec::new();
    for name in ["meshes", "accessors", "bufferViews", "buffers"] {
        owners.extend(list(name).into_iter().flatten());
    }
    for mesh in list("meshes").into_iter().flatten() {
        let primitives = mesh.get("primitives").and_then(Value::as_array);
        owners.extend(primitives.into_iter().flatten());
    }
    let extensions = owners
        .into_iter()
        .filter_map(|owner| owner.get("extensions"));
    let names = extensions.filter_map(Value::as_object);
    names
        .flat_map(|map| map.keys().map(String::as_str))
        .collect()
}
