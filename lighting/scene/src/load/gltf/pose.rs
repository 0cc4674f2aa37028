//! Skins in the pose of their joints, and morph targets at their weights.

use std::collections::BTreeMap;

use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat4, Vec3, Vec4};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Node, skin};

use super::{Builder, entry, label};
use crate::load::LoadError;

/// Where nodes are in the world, whatever scene they are in.
#[derive(Debug)]
pub(super) struct Places {
    parents: BTreeMap<usize, usize>,
    /// Those that have been asked for; `None` if they have no place.
    known: BTreeMap<usize, Option<DAffine3>>,
}

impl Places {
    pub(super) fn of(nodes: &[Node]) -> Self {
        let mut parents = BTreeMap::new();
        for (parent, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten() {
                // Second parents are found when the tree is walked.
                parents.entry(child.value()).or_insert(parent);
            }
        }
        Self {
            parents,
            known: BTreeMap::new(),
        }
    }
}

/// Scenes whose meshes are farther out than this, m, are moved to the origin if
/// they are also far out for their extent: f32 steps by 8 mm there.
const FAR: f64 = 65536.0;

impl Builder<'_> {
    /// From the space of the skinned mesh to the world, by joint.
    fn joint_matrices(
        &mut self,
        index: Index<skin::Skin>,
        owner: &str,
    ) -> Result<Vec<DMat4>, LoadError> {
        let root = self.root;
        let skin = entry(&root.skins, index, owner, "skin")?;
        let what = label("skin", index.value(), skin.name.as_deref());
        let inverse = match skin.inverse_bind_matrices {
            Some(accessor) => self.buffers.matrices(accessor, &what, &mut self.budget)?,
            None => vec![Mat4::IDENTITY.to_cols_array(); skin.joints.len()],
        };
        if inverse.len() < skin.joints.len() {
            return Err(LoadError::bad_value(
                format!("the number of inverse bind matrices of {what}"),
                inverse.len(),
                "one for each joint",
            ));
        }
        self.budget
            .take(&what, skin.joints.len() as u64, size_of::<DMat4>())?;
        let joints = skin.joints.iter().zip(inverse);
        let matrices = joints.map(|(joint, inverse)| {
            entry(&root.nodes, *joint, &what, "node")?;
            let Some(mut world) = self.place(joint.value()) else {
                return Err(LoadError::bad_value(
                    format!("node {} of {what}", joint.value()),
                    "without a place in the world",
                    "a tree of nodes with finite numbers",
                ));
            };
            world.translation -= self.offset;
            Ok(DMat4::from(world) * Mat4::from_cols_array(&inverse).as_dmat4())
        });
        matrices.collect()
    }

    /// From a node's space to the file's, whatever scene it is in; `None` if it
    /// is part of a cycle, or its numbers are bad. Each node is placed once.
    fn place(&mut self, node: usize) -> Option<DAffine3> {
        let mut path = Vec::new();
        let mut next = Some(node);
        let mut world = Some(DAffine3::IDENTITY);
        while let Some(index) = next {
            if let Some(known) = self.places.known.get(&index) {
                world = *known;
                break;
            }
            if path.len() > self.root.nodes.len() {
                world = None;
                break;
            }
            path.push(index);
            next = self.places.parents.get(&index).copied();
        }
        for index in path.into_iter().rev() {
            world = world.and_then(|world| {
                let world = world * self.local(index, "a node").ok()?;
                world.is_finite().then_some(world)
            });
            self.places.known.insert(index, world);
        }
        world
    }

    /// Finds out by how much the scene has to be moved, from the places of the
    /// nodes that have meshes.
    pub(super) fn find_offset(&mut self) {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (index, node) in self.root.nodes.iter().enumerate() {
            if node.mesh.is_some()
                && let Some(world) = self.place(index)
            {
                min = min.min(world.translation);
                max = max.max(world.translation);
            }
        }
        let farthest = min.abs().max(max.abs()).max_element();
        if farthest.is_finite() && farthest > FAR && farthest > 16.0 * (max - min).max_element() {
            self.offset = (0.5 * (min + max)).round();
            self.notes.add(format!(
                "the scene was moved by {} m to the origin, where single precision is enough",
                self.offset
            ));
        }
    }

    /// A transform to the file's space as one to the scene's.
    pub(super) fn moved(&self, world: DAffine3) -> Affine3A {
        let translation = world.translation - self.offset;
        Affine3A::from_mat3_translation(world.matrix3.as_mat3(), translation.as_vec3())
    }

    /// Adds the morph targets of a primitive to its positions.
    pub(super) fn morph(
        &mut self,
        primitive: &Primitive,
        weights: &[f32],
        positions: &mut [Vec3],
        owner: &str,
    ) -> Result<(), LoadError> {
        let targets = primitive.targets.iter().flatten();
        for (number, (target, &weight)) in targets.zip(weights).enumerate() {
            let Some(accessor) = target.positions.filter(|_| weight != 0.0) else {
                continue;
            };
            let what = format!("morph target {number} of {owner}");
            let moved = self.buffers.positions(accessor, &what, &mut self.budget)?;
            if moved.len() != positions.len() {
                return Err(LoadError::bad_value(
                    format!("the number of positions of {what}"),
                    moved.len(),
                    "as many as the primitive has",
                ));
            }
            for (position, moved) in positions.iter_mut().zip(moved) {
                *position += weight * moved;
            }
        }
        Ok(())
    }

    /// Moves the positions of a primitive to where its skin puts them in the
    /// world.
    pub(super) fn skin(
        &mut self,
        primitive: &Primitive,
        index: Index<skin::Skin>,
        positions: &mut [Vec3],
        owner: &str,
    ) -> Result<(), LoadError> {
        let matrices = self.joint_matrices(index, owner)?;
        let mut sums = Vec::new();
        self.budget
            .take(owner, positions.len() as u64, size_of::<(DMat4, f32)>())?;
        sums.resize(positions.len(), (DMat4::ZERO, 0.0));
        for set in 0_u32.. {
            let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
            let joints = attribute(Semantic::Joints(set));
            let Some((joints, weights)) = joints.zip(attribute(Semantic::Weights(set))) else {
                break;
            };
            let joints = self.buffers.joints(joints, owner, &mut self.budget)?;
            let weights = self.buffers.weights(weights, owner, &mut self.budget)?;
            if joints.len() != positions.len() || weights.len() != positions.len() {
                return Err(LoadError::bad_value(
                    format!("the number of joints and weights of {owner}"),
                    format!("{} and {}", joints.len(), weights.len()),
                    "as many as there are positions",
                ));
            }
            for ((joints, weights), sum) in joints.into_iter().zip(weights).zip(&mut sums) {
                add(&matrices, joints, weights, sum, owner)?;
            }
        }
        for (position, (matrix, weight)) in positions.iter_mut().zip(sums) {
            // What no joint holds stays where it is.
            if weight > 0.0 {
                // The last row holds the sum of the weights, so that weights
                // which do not quite sum to 1 cannot scale.
                *position = matrix.project_point3(position.as_dvec3()).as_vec3();
            }
        }
        Ok(())
    }
}

/// Adds the matrices of four joints by weight.
fn add(
    matrices: &[DMat4],
    joints: [u16; 4],
    weights: Vec4,
    sum: &mut (DMat4, f32),
    owner: &str,
) -> Result<(), LoadError> {
    for (joint, weight) in joints.into_iter().zip(weights.to_array()) {
        if weight == 0.0 {
            continue;
        }
        let Some(matrix) = matrices.get(usize::from(joint)) else {
            return Err(LoadError::bad_value(
                format!("a joint of {owner}"),
                joint,
                "below the number of joints of the skin",
            ));
        };
        sum.0 += f64::from(weight) * *matrix;
        sum.1 += weight;
    }
    Ok(())
}
