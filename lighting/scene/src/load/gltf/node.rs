//! The node hierarchy: what stands where in the world.

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, Mat3, Quat, Vec3};
use gltf_json::accessor::Accessor;
use gltf_json::{Index, Node, Value};

use super::primitive::{Key, Shape};
use super::quad::{Mapping, Rectangle};
use super::texture::Placed;
use super::{Builder, entry, extras, label};
use crate::load::LoadError;
use crate::{AreaLight, Instance, Light, Texture};

/// What a node hands down to its children.
#[derive(Debug, Clone, Copy)]
struct Inherited {
    world: DAffine3,
    visible: bool,
    no_shadow: bool,
    dynamic: bool,
}

impl Builder<'_> {
    /// Takes over what hangs below `roots`, parents first.
    pub(super) fn walk(&mut self, roots: &[Index<Node>], owner: &str) -> Result<(), LoadError> {
        let mut reached = vec![false; self.root.nodes.len()];
        let mut waiting = Vec::new();
        let start = Inherited {
            world: DAffine3::IDENTITY,
            visible: true,
            no_shadow: false,
            dynamic: false,
        };
        for &root in roots.iter().rev() {
            entry(&self.root.nodes, root, owner, "node")?;
            waiting.push((root.value(), start));
        }
        while let Some((index, parent)) = waiting.pop() {
            let node = &self.root.nodes[index];
            let name = label("node", index, node.name.as_deref());
            if std::mem::replace(&mut reached[index], true) {
                return Err(LoadError::bad_value(
                    name,
                    "reached twice",
                    "a tree of nodes: no cycles, no second parent",
                ));
            }
            let in_file = parent.world * self.local(index, &name)?;
            let world = self.moved(in_file);
            if !world.is_finite() {
                return Err(LoadError::bad_value(
                    format!("the place of {name} in the world"),
                    format!("{world:?}"),
                    "finite numbers",
                ));
            }
            let no_shadow = extras::no_shadow(self.extras("nodes", index), &name)?;
            let dynamic = extras::dynamic(self.extras("nodes", index), &name)?;
            let inherited = Inherited {
                world: in_file,
                visible: parent.visible && self.is_visible(index, &name)?,
                no_shadow: no_shadow.unwrap_or(parent.no_shadow),
                dynamic: dynamic.unwrap_or(parent.dynamic),
            };
            if inherited.visible {
                self.mesh_instances(index, &name, inherited, world)?;
                self.punctual_light(index, &name, world)?;
                self.extension_area_light(index, &name, world)?;
                self.smoke(index, &name, world)?;
            }
            self.camera(node, &name, world)?;
            for &child in node.children.iter().flatten().rev() {
                entry(&self.root.nodes, child, &name, "node")?;
                waiting.push((child.value(), inherited));
            }
        }
        Ok(())
    }

    /// From a node's space to its parent's, with the digits of the file.
    pub(super) fn local(&self, index: usize, name: &str) -> Result<DAffine3, LoadError> {
        let value = self.value.get("nodes").and_then(|nodes| nodes.get(index));
        // The library has checked that there are as many numbers as there should be.
        let number = |field: &str, place: usize, default: f64| {
            let field = value.and_then(|value| value.get(field));
            let number = field
                .and_then(|field| field.get(place))
                .and_then(Value::as_f64);
            number.unwrap_or(default)
        };
        if self.root.nodes[index].matrix.is_some() {
            let matrix = std::array::from_fn(|place| number("matrix", place, f64::NAN));
            let matrix = DMat4::from_cols_array(&matrix);
            if matrix.row(3) != glam::DVec4::W {
                return Err(LoadError::bad_value(
                    format!("the last row of the matrix of {name}"),
                    matrix.row(3),
                    "0, 0, 0, 1",
                ));
            }
            return Ok(DAffine3::from_mat4(matrix));
        }
        let vector = |field: &str, default: f64| {
            DVec3::from_array([0, 1, 2].map(|place| number(field, place, default)))
        };
        let rotation = [0, 1, 2, 3].map(|place| number("rotation", place, f64::from(place == 3)));
        let rotation = DQuat::from_array(rotation);
        let length = rotation.length();
        if !(length.is_finite() && length > 0.0) {
            return Err(LoadError::bad_value(
                format!("the rotation of {name}"),
                rotation,
                "a finite quaternion other than 0",
            ));
        }
        Ok(DAffine3::from_scale_rotation_translation(
            vector("scale", 1.0),
            rotation.normalize(),
            vector("translation", 0.0),
        ))
    }

    fn is_visible(&mut self, index: usize, name: &str) -> Result<bool, LoadError> {
        let extension = self.extension("nodes", index, "KHR_node_visibility");
        let Some(visible) = extension.and_then(|extension| extension.get("visible")) else {
            return Ok(true);
        };
        let visible = visible.as_bool().ok_or_else(|| {
            LoadError::bad_value(
                format!("the visibility of {name}"),
                extras::kind(visible),
                "true or false",
            )
        })?;
        if !visible {
            self.notes
                .add("nodes that are not visible are left out with their lights");
        }
        Ok(visible)
    }

    fn mesh_instances(
        &mut self,
        number: usize,
        name: &str,
        inherited: Inherited,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let root = self.root;
        let node = &root.nodes[number];
        let Some(index) = node.mesh else {
            return Ok(());
        };
        let mesh = entry(&root.meshes, index, name, "mesh")?;
        let worlds = match node.skin {
            // The place of a skinned mesh is that of its joints.
            Some(_) => vec![Affine3A::IDENTITY],
            None => self.placements(number, name, world)?,
        };
        let shape_casts = extras::no_shadow(self.extras("meshes", index.value()), name)?;
        for world in worlds {
            let mirrored = world.matrix3.determinant() < 0.0;
            for primitive in 0..mesh.primitives.len() {
                let key = Key::new(node, number, index.value(), primitive, mirrored);
                let Some(shape) = self.shape(key)? else {
                    continue;
                };
                let no_shadow = inherited.no_shadow || shape_casts == Some(true) || shape.no_shadow;
                self.budget.take(
                    name,
                    1,
                    size_of::<Instance>() + node.name.as_ref().map_or(0, String::len),
                )?;
                self.scene.instances.push(Instance {
                    name: node.name.clone().unwrap_or_default(),
                    mesh: shape.mesh,
                    transform: world,
                    no_shadow,
                    dynamic: inherited.dynamic,
                });
                self.glow(&shape, world)?;
            }
        }
        Ok(())
    }

    /// Where a node's mesh stands: where the node is, or in the places of
    /// `EXT_mesh_gpu_instancing`.
    fn placements(
        &mut self,
        number: usize,
        name: &str,
        world: Affine3A,
    ) -> Result<Vec<Affine3A>, LoadError> {
        let Some(extension) = self.extension("nodes", number, "EXT_mesh_gpu_instancing") else {
            return Ok(vec![world]);
        };
        let what = format!("the instances of {name}");
        let attribute = |name: &str| -> Result<Option<Index<Accessor>>, LoadError> {
            let Some(value) = extension.get("attributes").and_then(|a| a.get(name)) else {
                return Ok(None);
            };
            let index = value.as_u64().and_then(|index| u32::try_from(index).ok());
            let index = index.ok_or_else(|| {
                LoadError::bad_value(
                    format!("{name} of {what}"),
                    extras::kind(value),
                    "the index of an accessor",
                )
            })?;
            Ok(Some(Index::new(index)))
        };
        let [translations, rotations, scales] = [
            attribute("TRANSLATION")?,
            attribute("ROTATION")?,
            attribute("SCALE")?,
        ];
        let (buffers, budget) = (&mut self.buffers, &mut self.budget);
        let translations = translations.map(|index| buffers.vectors(index, &what, budget));
        let translations = translations.transpose()?;
        let rotations = rotations.map(|index| buffers.rotations(index, &what, budget));
        let rotations = rotations.transpose()?;
        let scales = scales.map(|index| buffers.vectors(index, &what, budget));
        let scales = scales.transpose()?;
        let lengths = [
            translations.as_ref().map(Vec::len),
            rotations.as_ref().map(Vec::len),
            scales.as_ref().map(Vec::len),
        ];
        let mut known = lengths.into_iter().flatten();
        let Some(count) = known
            .next()
            .filter(|count| known.all(|other| other == *count))
        else {
            return Err(LoadError::bad_value(
                format!("the number of {what}"),
                format!("{lengths:?}"),
                "one number for all attributes, of which there is at least one",
            ));
        };
        budget.take(&what, count as u64, size_of::<Affine3A>())?;
        let mut worlds = Vec::with_capacity(count);
        for instance in 0..count {
            let pick = |list: &Option<Vec<Vec3>>, default| {
                list.as_ref().map_or(default, |list| list[instance])
            };
            let rotation = rotations
                .as_ref()
                .map_or(Quat::IDENTITY, |list| Quat::from_vec4(list[instance]));
            let length = rotation.length();
            let world = world
                * Affine3A::from_scale_rotation_translation(
                    pick(&scales, Vec3::ONE),
                    rotation.normalize(),
                    pick(&translations, Vec3::ZERO),
                );
            if !(length > 0.0 && world.is_finite()) {
                return Err(LoadError::bad_value(
                    format!("instance {instance} of {what}"),
                    "without a place",
                    "finite numbers and a rotation other than 0",
                ));
            }
            worlds.push(world);
        }
        Ok(worlds)
    }

    /// Makes area lights of a rectangle that emits.
    fn glow(&mut self, shape: &Shape, world: Affine3A) -> Result<(), LoadError> {
        let Some(glow) = &shape.glow else {
            return Ok(());
        };
        let corners = glow.corners.map(|corners| {
            corners.map(|triangle| triangle.map(|corner| world.transform_point3(corner)))
        });
        let rectangle = corners.and_then(|corners| Rectangle::new(corners, glow.coordinates));
        let Some(rectangle) = rectangle else {
            self.notes.add(format!(
                "{} glows but does not light the scene: it is not one rectangle",
                shape.name
            ));
            return Ok(());
        };
        self.area_light(glow.material, &rectangle, &shape.name)?;
        if self.materials[&glow.material].double_sided {
            self.area_light(glow.material, &rectangle.turned(), &shape.name)?;
        }
        Ok(())
    }

    fn area_light(
        &mut self,
        material: usize,
        rectangle: &Rectangle,
        name: &str,
    ) -> Result<(), LoadError> {
        let Some(emission) = self.materials[&material].emission.clone() else {
            return Ok(());
        };
        let mut radiance = emission.radiance;
        let texture = match (emission.texture, rectangle.mapping) {
            (None, _) => None,
            (Some(placed), Mapping::Upright) => Some(placed.texture),
            (Some(placed), Mapping::UpsideDown) => {
                Some(self.upside_down(material, &placed.texture, name)?)
            }
            (Some(Placed { texture, .. }), Mapping::Other) => {
                radiance *= texture.mean();
                self.notes.add(format!(
                    "{name} lights the scene with the mean of its texture: the texture does \
                     not cover it exactly once"
                ));
                None
            }
        };
        self.budget.take(name, 1, size_of::<Light>())?;
        self.scene.lights.push(Light::Area(AreaLight {
            corner: rectangle.corner,
            edges: rectangle.edges,
            radiance,
            texture,
            name: self.materials[&material].name.clone(),
            ..AreaLight::default()
        }));
        Ok(())
    }

    /// The emissive texture of a material with its rows in reverse order.
    fn upside_down(
        &mut self,
        material: usize,
        texture: &Texture,
        name: &str,
    ) -> Result<Texture, LoadError> {
        if let Some(turned) = self.upside_down.get(&material) {
            return Ok(turned.clone());
        }
        let texels = texture.texels();
        self.budget
            .take(name, texels.len() as u64, size_of::<Vec3>())?;
        let rows = texels.rchunks_exact(texture.width() as usize);
        let turned = rows.flatten().copied().collect();
        let turned = Texture::new(texture.width(), texture.height(), turned)?;
        self.upside_down.insert(material, turned.clone());
        Ok(turned)
    }
}

/// The rotation that takes local −Z and, as well as possible, +Y to where the
/// transform takes them; `None` if it flattens one of them.
pub(super) fn rotation(world: Affine3A) -> Option<Quat> {
    let axes = Mat3::from(world.matrix3);
    let back = axes.z_axis.try_normalize()?;
    let up = axes.y_axis.try_normalize()?;
    let right = up.cross(back).try_normalize()?;
    let axes = Mat3::from_cols(right, back.cross(right), back);
    Some(Quat::from_mat3(&axes).normalize())
}
