//! Primitives as triangle meshes.

use glam::{Vec2, Vec3};
use gltf_json::Node;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked;

use super::texture::Mapping;
use super::{Builder, label};
use crate::load::LoadError;
use crate::{Mesh, SceneError};

/// A primitive that has been taken over.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// Index into the scene's meshes.
    pub(super) mesh: usize,
    /// Its name for messages.
    pub(super) name: String,
    /// Its material casts no shadow.
    pub(super) no_shadow: bool,
    pub(super) glow: Option<Glow>,
}

/// A primitive that emits.
#[derive(Debug, Clone)]
pub(super) struct Glow {
    /// Index into the document's materials.
    pub(super) material: usize,
    /// If it has two triangles, their corners in the mesh's space.
    pub(super) corners: Option<[[Vec3; 3]; 2]>,
    /// The coordinates of the emissive texture at these corners.
    pub(super) coordinates: Option<[[Vec2; 3]; 2]>,
}

/// A primitive in one of its forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    mesh: usize,
    primitive: usize,
    mirrored: bool,
    /// The node that has weights or a skin of its own for it.
    posed_by: Option<usize>,
}

impl Key {
    pub(super) fn new(
        node: &Node,
        number: usize,
        mesh: usize,
        primitive: usize,
        mirrored: bool,
    ) -> Self {
        let is_posed = node.skin.is_some() || node.weights.is_some();
        Self {
            mesh,
            primitive,
            mirrored,
            posed_by: is_posed.then_some(number),
        }
    }
}

impl Builder<'_> {
    /// Takes a primitive over into the scene, once per form; `None` if there is
    /// nothing to draw.
    pub(super) fn shape(&mut self, key: Key) -> Result<Option<Shape>, LoadError> {
        let Key {
            mesh,
            primitive: number,
            ..
        } = key;
        if let Some(shape) = self.shapes.get(&key) {
            return Ok(shape.clone());
        }
        let parent = &self.root.meshes[mesh];
        let mut name = label("mesh", mesh, parent.name.as_deref());
        if parent.primitives.len() > 1 {
            name = format!("primitive {number} of {name}");
        }
        if self.is_compressed(mesh, number)
            && let Err(error) = self.decompress(mesh, number, &name)
        {
            if !self.lenient {
                return Err(error);
            }
            self.notes.add(format!("{name} left out: {error}"));
            self.shapes.insert(key, None);
            return Ok(None);
        }
        let called = match &parent.name {
            Some(own) if !own.is_empty() => own.clone(),
            _ => name.clone(),
        };
        let shape = self.convert(key, name, called)?;
        self.buffers.forget_decompressed();
        self.shapes.insert(key, shape.clone());
        Ok(shape)
    }

    fn convert(
        &mut self,
        key: Key,
        name: String,
        called: String,
    ) -> Result<Option<Shape>, LoadError> {
        let root = self.root;
        let parent = &root.meshes[key.mesh];
        let primitive = &parent.primitives[key.primitive];
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                mode
            }
            Checked::Valid(mode) => {
                self.notes
                    .add(format!("{name} ignored: it is drawn as {mode:?}"));
                return Ok(None);
            }
            Checked::Invalid => {
                return Err(LoadError::bad_value(
                    format!("the mode of {name}"),
                    "unknown",
                    "0 to 6",
                ));
            }
        };
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(accessor) = attribute(Semantic::Positions) else {
            self.notes
                .add(format!("{name} ignored: it has no positions"));
            return Ok(None);
        };
        let mut positions = self.buffers.positions(accessor, &name, &mut self.budget)?;
        let node = key.posed_by.map(|node| &root.nodes[node]);
        let weights = node.and_then(|node| node.weights.as_ref());
        if let Some(weights) = weights.or(parent.weights.as_ref()) {
            self.morph(primitive, weights, &mut positions, &name)?;
        }
        if let Some(skin) = node.and_then(|node| node.skin) {
            self.skin(primitive, skin, &mut positions, &name)?;
        }
        let positions = positions;
        let corners = match primitive.indices {
            Some(accessor) => self.buffers.indices(accessor, &name, &mut self.budget)?,
            None => {
                self.budget
                    .take(&name, positions.len() as u64, size_of::<u32>())?;
                (0..positions.len()).map(|index| index as u32).collect()
            }
        };
        if let Some(&index) = corners.iter().find(|&&i| i as usize >= positions.len()) {
            return Err(LoadError::Scene(SceneError::IndexOutOfRange {
                owner: name,
                what: "vertex",
                index: index.into(),
                count: positions.len() as u64,
            }));
        }
        self.budget
            .take(&name, corners.len() as u64, size_of::<[u32; 3]>())?;
        let mut triangles = triangles(mode, &corners);
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            self.notes.add(format!(
                "{name} has {} corners: those behind the last whole triangle are ignored",
                corners.len()
            ));
        }
        if key.mirrored {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }

        let material = match primitive.material {
            Some(index) => Some((index.value(), self.material(index, &name)?)),
            None => None,
        };
        let coordinates = |builder: &mut Self, mapping: Mapping| {
            let Some(accessor) = attribute(Semantic::TexCoords(mapping.set)) else {
                return Ok(None);
            };
            let mut coordinates =
                builder
                    .buffers
                    .texture_coordinates(accessor, &name, &mut builder.budget)?;
            if coordinates.len() != positions.len() {
                return Err(LoadError::Scene(SceneError::LengthMismatch {
                    owner: name.clone(),
                    what: "texture coordinates",
                    actual: coordinates.len(),
                    expected: positions.len(),
                }));
            }
            mapping.apply(&mut coordinates);
            Ok(Some(coordinates))
        };
        let mapping = material.as_ref().and_then(|(_, m)| m.mapping);
        let texture_coordinates = match mapping {
            Some(mapping) => coordinates(self, mapping)?,
            None => None,
        };
        let transmission_coordinates =
            match material.as_ref().and_then(|(_, m)| m.transmission_mapping) {
                Some(mapping) => coordinates(self, mapping)?,
                None => None,
            };
        let colors = match attribute(Semantic::Colors(0)) {
            Some(accessor) => self.buffers.colors(accessor, &name, &mut self.budget)?,
            None => Vec::new(),
        };
        if !colors.is_empty() && colors.len() != positions.len() {
            return Err(LoadError::Scene(SceneError::LengthMismatch {
                owner: name,
                what: "vertex colours",
                actual: colors.len(),
                expected: positions.len(),
            }));
        }
        let glow = match &material {
            Some((material, converted)) if converted.emission.is_some() => {
                let emission = converted.emission.as_ref();
                let placed = emission.and_then(|emission| emission.texture.as_ref());
                let mut glow = Glow {
                    material: *material,
                    corners: None,
                    coordinates: None,
                };
                if let [a, b] = triangles[..] {
                    glow.corners = Some([a, b].map(|t| t.map(|c| positions[c as usize])));
                    if let Some(placed) = placed {
                        glow.coordinates = coordinates(self, placed.mapping)?
                            .map(|uv| [a, b].map(|t| t.map(|c| uv[c as usize])));
                    }
                }
                Some(glow)
            }
            _ => None,
        };
        let (material, no_shadow) = match material {
            Some((_, converted)) => (converted.index, converted.no_shadow),
            None => (self.plain_material()?, false),
        };
        let shape = Shape {
            mesh: self.scene.meshes.len(),
            name: name.clone(),
            no_shadow,
            glow,
        };
        self.budget.take(
            &name,
            1,
            size_of::<Mesh>() + size_of::<Shape>() + called.len(),
        )?;
        self.scene.meshes.push(Mesh {
            name: called,
            positions,
            texture_coordinates: texture_coordinates.unwrap_or_default(),
            transmission_coordinates: transmission_coordinates.unwrap_or_default(),
            colors,
            triangles,
            material: Some(material),
        });
        Ok(Some(shape))
    }
}

/// The triangles of a list, strip or fan, in the corner order of the glTF
/// specification, section 3.7.2.1.
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turn = |(i, w): (usize, &[u32])| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[0], w[2], w[1]],
            };
            corners.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => match corners {
            [centre, rim @ ..] => rim.windows(2).map(|w| [w[0], w[1], *centre]).collect(),
            [] => Vec::new(),
        },
        _ => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
    }
}
