//! glTF 2.0 and GLB.
//!
//! Only the document's structure is taken from the library; every index, offset
//! and length in it is checked here before it is used.

mod accessor;
mod area;
mod buffers;
mod camera;
mod container;
mod draco;
mod extension;
mod extras;
mod light;
mod material;
mod medium;
mod meshopt;
mod node;
mod pose;
mod primitive;
mod quad;
mod smoke;
#[cfg(test)]
mod tests;
mod texture;
mod uri;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use gltf_json::{Index, Root, Value};

use self::buffers::Buffers;
use self::camera::Orthographic;
use self::container::{Container, Document};
use self::material::Converted;
use self::pose::Places;
use self::primitive::{Key, Shape};
use super::error::printable;
use super::image::Encoding;
use super::limits::{Budget, Notes};
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES, OpenFile};
use crate::{Scene, SceneError, Texture};

/// Reads a glTF or GLB file; see the [module](super) for what is understood.
/// `open` returns the contents of a buffer or image file, given its decoded
/// path relative to the document; `data:` URIs never reach it. Of the options
/// only [`LoadOptions::lenient`] has an effect: glTF is in metres and +Y is up.
///
/// # Errors
/// Any [`LoadError`], those of `open` included. What is wrong with an image is
/// a note and not an error.
pub fn gltf_from_slice(
    bytes: &[u8],
    options: &LoadOptions,
    open: OpenFile<'_>,
) -> Result<Loaded, LoadError> {
    read(bytes, options, open, Budget::new(MAX_DECODED_BYTES))
}

fn read(
    bytes: &[u8],
    options: &LoadOptions,
    open: OpenFile<'_>,
    budget: Budget,
) -> Result<Loaded, LoadError> {
    options.check_gltf()?;
    let container = Container::split(bytes)?;
    let Document {
        root,
        value,
        has_animations,
    } = container::parse(container.json)?;
    let mut builder = Builder {
        root: &root,
        value: &value,
        lenient: options.lenient,
        places: Places::of(&root.nodes),
        offset: DVec3::ZERO,
        buffers: Buffers::new(&root, &value, container.binary, open),
        budget,
        notes: Notes::default(),
        scene: Scene::default(),
        images: BTreeMap::new(),
        materials: BTreeMap::new(),
        plain: None,
        upside_down: BTreeMap::new(),
        shapes: BTreeMap::new(),
        orthographic: None,
    };
    builder.document()?;
    if has_animations {
        builder.notes.add("animations are ignored");
    }
    Ok(Loaded {
        scene: builder.scene,
        notes: builder.notes.into_vec(),
        offset: builder.offset,
    })
}

/// A scene that is being made from a document.
struct Builder<'a> {
    root: &'a Root,
    /// The document as it is written.
    value: &'a Value,
    lenient: bool,
    places: Places,
    /// By how much the scene is moved to the origin.
    offset: DVec3,
    buffers: Buffers<'a>,
    budget: Budget,
    notes: Notes,
    scene: Scene,
    /// Images by their index, `None` if they cannot be read.
    images: BTreeMap<(usize, Encoding), Option<Texture>>,
    /// Materials by their index.
    materials: BTreeMap<usize, Converted>,
    /// Index into the scene's materials of the one for primitives without.
    plain: Option<usize>,
    /// Emissive textures in reverse row order, by material.
    upside_down: BTreeMap<usize, Texture>,
    /// Primitives; `None` if there is nothing to draw.
    shapes: BTreeMap<Key, Option<Shape>>,
    /// The first orthographic camera.
    orthographic: Option<Orthographic>,
}

impl<'a> Builder<'a> {
    /// An extension of an entry of a list of the document.
    fn extension(&self, list: &str, index: usize, name: &str) -> Option<&'a Value> {
        let entry = self.value.get(list)?.get(index)?;
        entry.get("extensions")?.get(name)
    }

    /// The extras of an entry of a list of the document.
    fn extras(&self, list: &str, index: usize) -> Option<&'a Value> {
        self.value.get(list)?.get(index)?.get("extras")
    }

    fn document(&mut self) -> Result<(), LoadError> {
        let root = self.root;
        self.check_extensions()?;
        self.find_offset();
        let scene = match (root.scene, root.scenes.first()) {
            (Some(index), _) => Some(entry(&root.scenes, index, "the document", "scene")?),
            (None, Some(first)) => {
                if root.scenes.len() > 1 {
                    self.notes.add("no scene is the default: the first is used");
                }
                Some(first)
            }
            (None, None) => None,
        };
        match scene {
            Some(scene) => {
                self.scene.name = scene.name.clone().unwrap_or_default();
                self.walk(&scene.nodes, "the scene")?;
            }
            None => self.walk_all()?,
        }
        self.replace_orthographic()?;
        let extras = [
            scene.map(|scene| &scene.extras),
            Some(&root.extras),
            Some(&root.asset.extras),
        ];
        for extras in extras.into_iter().flatten() {
            if self.scene.medium.is_none() {
                self.scene.medium = medium::medium(extras, self.offset)?;
            }
            if self.scene.height_fog.is_none() {
                self.scene.height_fog = medium::height_fog(extras, self.offset)?;
            }
        }
        let mut meshes = self
            .scene
            .instances
            .iter()
            .map(|i| &self.scene.meshes[i.mesh]);
        // Smoke alone is a scene, as it is in a file of its own.
        let has_smoke = !self.scene.translucent.is_empty();
        if !has_smoke && meshes.all(|mesh| mesh.triangles.is_empty()) {
            return Err(SceneError::Empty.into());
        }
        Ok(())
    }

    /// Without a scene, whatever is nobody's child is taken.
    fn walk_all(&mut self) -> Result<(), LoadError> {
        let nodes = &self.root.nodes;
        let children: BTreeSet<usize> = nodes
            .iter()
            .flat_map(|node| node.children.iter().flatten())
            .map(Index::value)
            .collect();
        let roots: Vec<_> = (0..nodes.len())
            .filter(|index| !children.contains(index))
            .map(|index| Index::new(index as u32))
            .collect();
        if roots.is_empty() && !nodes.is_empty() {
            return Err(LoadError::bad_value(
                "the hierarchy of nodes",
                "without a root",
                "a tree of nodes: no cycles, no second parent",
            ));
        }
        if !roots.is_empty() {
            self.notes
                .add("the document has no scene: all of its nodes are used");
        }
        self.walk(&roots, "the document")
    }
}

/// What an index points to. `owner` holds the index.
fn entry<'a, T>(
    items: &'a [T],
    index: Index<T>,
    owner: &str,
    what: &'static str,
) -> Result<&'a T, LoadError> {
    items.get(index.value()).ok_or_else(|| {
        LoadError::Scene(SceneError::IndexOutOfRange {
            owner: owner.to_owned(),
            what,
            index: index.value() as u64,
            count: items.len() as u64,
        })
    })
}

/// How a part of the document is called in messages.
fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} \"{}\"", printable(name)),
        _ => format!("{kind} {index}"),
    }
}
