//! Which extensions are read, which may be left out, and which may not.

use std::collections::BTreeSet;

use gltf_json::{Root, Value};

use super::Builder;
use crate::load::LoadError;
use crate::load::error::printable;

/// Extensions that are read.
const SUPPORTED: &[&str] = &[
    "EXT_lights_area",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
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

/// Meshes compressed by Draco.
const DRACO: &str = "KHR_draco_mesh_compression";

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
            // A mesh that is there uncompressed too needs no decoder.
            let has_fallback = extension == DRACO && !is_required && has_fallback(root, self.value);
            if (is_required || is_geometric) && !has_fallback && !self.lenient {
                let why = if is_required {
                    "which the file requires"
                } else {
                    "which may carry geometry"
                };
                return Err(LoadError::Unsupported(format!(
                    "the extension {shown}, {why},"
                )));
            }
            let more = if has_fallback {
                "; meshes are there uncompressed too"
            } else if is_required || is_geometric {
                "; geometry may be missing"
            } else {
                ""
            };
            self.notes
                .add(format!("the extension {shown} is ignored{more}"));
        }
        Ok(())
    }

    /// True if a primitive is there only in a form that is not read.
    pub(super) fn is_unreadable(&self, mesh: usize, number: usize) -> bool {
        let primitive = &self.root.meshes[mesh].primitives[number];
        let has_draco = |value: &Value| value.get(DRACO).is_some();
        let extensions = || {
            let mesh = self.value.get("meshes")?.get(mesh)?;
            mesh.get("primitives")?.get(number)?.get("extensions")
        };
        extensions().is_some_and(has_draco)
            && primitive.attributes.values().any(|index| {
                let accessor = self.root.accessors.get(index.value());
                accessor.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none())
            })
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

/// True if every accessor that a mesh uses has data of its own.
fn has_fallback(root: &Root, document: &Value) -> bool {
    let meshes = document.get("meshes").and_then(Value::as_array);
    let meshes = meshes.into_iter().flatten().zip(&root.meshes);
    let primitives = meshes.flat_map(|(_, mesh)| &mesh.primitives);
    let mut accessors = primitives.flat_map(|p| p.attributes.values().copied().chain(p.indices));
    accessors.all(|index| {
        let accessor = root.accessors.get(index.value());
        accessor.is_none_or(|a| a.buffer_view.is_some() || a.sparse.is_some())
    })
}
