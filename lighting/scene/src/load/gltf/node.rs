//! The node hierarchy: what stands where in the world.

use glam::{Affine3A, Mat3, Mat4, Quat, Vec3};
use gltf_json::{Index, Node};

use super::quad::{Mapping, Rectangle};
use super::{Builder, entry, label};
use crate::load::LoadError;
use crate::{AreaLight, Camera, Instance, Light, Texture};

impl Builder<'_> {
    /// Takes over what hangs below `roots`, parents first.
    pub(super) fn walk(&mut self, roots: &[Index<Node>], owner: &str) -> Result<(), LoadError> {
        let mut reached = vec![false; self.root.nodes.len()];
        let mut waiting = Vec::new();
        for &root in roots.iter().rev() {
            entry(&self.root.nodes, root, owner, "node")?;
            waiting.push((root.value(), Affine3A::IDENTITY));
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
            let world = parent * local(node, &name)?;
            if !world.is_finite() {
                return Err(LoadError::bad_value(
                    format!("the place of {name} in the world"),
                    format!("{world:?}"),
                    "finite numbers",
                ));
            }
            self.mesh_instances(node, &name, world)?;
            self.camera(node, &name, world)?;
            self.punctual_light(node, &name, world)?;
            for &child in node.children.iter().flatten().rev() {
                entry(&self.root.nodes, child, &name, "node")?;
                waiting.push((child.value(), world));
            }
        }
        Ok(())
    }

    fn mesh_instances(
        &mut self,
        node: &Node,
        name: &str,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let Some(index) = node.mesh else {
            return Ok(());
        };
        if node.skin.is_some() {
            self.notes.add(format!(
                "{name} keeps the pose that its mesh was modelled in"
            ));
        }
        let mesh = entry(&self.root.meshes, index, name, "mesh")?;
        let mirrored = world.matrix3.determinant() < 0.0;
        for number in 0..mesh.primitives.len() {
            let Some(shape) = self.shape(index.value(), number, mirrored)? else {
                continue;
            };
            self.budget.take(name, 1, size_of::<Instance>())?;
            self.scene.instances.push(Instance {
                mesh: shape.mesh,
                transform: world,
            });
            let Some(glow) = &shape.glow else {
                continue;
            };
            let rectangle = glow.corners.and_then(|corners| {
                let corners = corners.map(|t| t.map(|p| world.transform_point3(p)));
                Rectangle::new(corners, glow.coordinates)
            });
            match rectangle {
                Some(rectangle) => self.area_light(glow.material, &rectangle, &shape.name)?,
                None => self.notes.add(format!(
                    "{} glows but does not light the scene: it is not one rectangle",
                    shape.name
                )),
            }
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
            (Some((texture, _)), Mapping::Upright) => Some(texture),
            (Some((texture, _)), Mapping::UpsideDown) => {
                Some(self.upside_down(material, &texture, name)?)
            }
            (Some((texture, _)), Mapping::Other) => {
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

    fn camera(&mut self, node: &Node, name: &str, world: Affine3A) -> Result<(), LoadError> {
        let Some(index) = node.camera else {
            return Ok(());
        };
        let camera = entry(&self.root.cameras, index, name, "camera")?;
        let what = label("camera", index.value(), camera.name.as_deref());
        let Some(perspective) = &camera.perspective else {
            self.notes
                .add(format!("{what} ignored: it has no perspective"));
            return Ok(());
        };
        if self.scene.camera.is_some() {
            self.notes.add(format!(
                "{what} of {name} ignored: the first camera is used"
            ));
            return Ok(());
        }
        let Some(rotation) = rotation(world) else {
            self.notes
                .add(format!("{what} ignored: {name} is scaled to nothing"));
            return Ok(());
        };
        self.scene.camera = Some(Camera::new(
            world.translation.into(),
            rotation,
            perspective.yfov,
        )?);
        Ok(())
    }
}

/// From a node's space to its parent's.
fn local(node: &Node, name: &str) -> Result<Affine3A, LoadError> {
    if let Some(matrix) = &node.matrix {
        let matrix = Mat4::from_cols_array(matrix);
        if matrix.row(3) != glam::Vec4::W {
            return Err(LoadError::bad_value(
                format!("the last row of the matrix of {name}"),
                matrix.row(3),
                "0, 0, 0, 1",
            ));
        }
        return Ok(Affine3A::from_mat4(matrix));
    }
    let rotation = node
        .rotation
        .map_or(Quat::IDENTITY, |q| Quat::from_array(q.0));
    let length = rotation.length();
    if !(length.is_finite() && length > 0.0) {
        return Err(LoadError::bad_value(
            format!("the rotation of {name}"),
            rotation,
            "a finite quaternion other than 0",
        ));
    }
    Ok(Affine3A::from_scale_rotation_translation(
        node.scale.map_or(Vec3::ONE, Vec3::from),
        rotation.normalize(),
        node.translation.map_or(Vec3::ZERO, Vec3::from),
    ))
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
