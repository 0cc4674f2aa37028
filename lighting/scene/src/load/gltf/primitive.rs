//! Primitives as triangle meshes.

use glam::{Vec2, Vec3};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;

use super::material::Emission;
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

impl Builder<'_> {
    /// Takes a primitive over into the scene, once per handedness; `None` if
    /// there is nothing to draw.
    pub(super) fn shape(
        &mut self,
        mesh: usize,
        number: usize,
        mirrored: bool,
    ) -> Result<Option<Shape>, LoadError> {
        let key = (mesh, number, mirrored);
        if let Some(shape) = self.shapes.get(&key) {
            return Ok(shape.clone());
        }
        let parent = &self.root.meshes[mesh];
        let mut name = label("mesh", mesh, parent.name.as_deref());
        if parent.primitives.len() > 1 {
            name = format!("primitive {number} of {name}");
        }
        let shape = self.convert(&parent.primitives[number], name, mirrored)?;
        self.shapes.insert(key, shape.clone());
        Ok(shape)
    }

    fn convert(
        &mut self,
        primitive: &Primitive,
        name: String,
        mirrored: bool,
    ) -> Result<Option<Shape>, LoadError> {
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
        if primitive.targets.as_ref().is_some_and(|t| !t.is_empty()) {
            self.notes
                .add(format!("the morph targets of {name} are ignored"));
        }
        let positions = self.buffers.positions(accessor, &name, &mut self.budget)?;
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
        if mirrored {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }

        let material = match primitive.material {
            Some(index) => Some((index.value(), self.material(index, &name)?)),
            None => None,
        };
        let coordinates = |builder: &mut Self, set| {
            let Some(accessor) = attribute(Semantic::TexCoords(set)) else {
                return Ok(None);
            };
            let coordinates =
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
            Ok(Some(coordinates))
        };
        let base_color_set = material.as_ref().and_then(|(_, m)| m.base_color_set);
        let texture_coordinates = match base_color_set {
            Some(set) => coordinates(self, set)?,
            None => None,
        };
        let glow = match &material {
            Some((material, converted)) if converted.emission.is_some() => {
                let emission = converted.emission.as_ref();
                let texture_set = emission.and_then(Emission::texture_set);
                let mut glow = Glow {
                    material: *material,
                    corners: None,
                    coordinates: None,
                };
                if let [a, b] = triangles[..] {
                    glow.corners = Some([a, b].map(|t| t.map(|c| positions[c as usize])));
                    if let Some(set) = texture_set {
                        glow.coordinates = coordinates(self, set)?
                            .map(|uv| [a, b].map(|t| t.map(|c| uv[c as usize])));
                    }
                }
                Some(glow)
            }
            _ => None,
        };
        let shape = Shape {
            mesh: self.scene.meshes.len(),
            name: name.clone(),
            glow,
        };
        self.budget
            .take(&name, 1, size_of::<Mesh>() + size_of::<Shape>())?;
        self.scene.meshes.push(Mesh {
            name,
            positions,
            texture_coordinates: texture_coordinates.unwrap_or_default(),
            triangles,
            material: material.map(|(_, converted)| converted.index),
        });
        Ok(Some(shape))
    }
}

impl Emission {
    fn texture_set(&self) -> Option<u32> {
        self.texture.as_ref().map(|(_, set)| *set)
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
