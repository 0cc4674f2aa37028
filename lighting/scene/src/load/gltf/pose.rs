//! Skins in the pose of their joints, and morph targets at their weights.

use std::collections::BTreeMap;

use glam::{Affine3A, DAffine3, DMat4, Mat4, Vec3, Vec4};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Node, skin};

use super::node::local;
use super::{Builder, entry, label};
use crate::load::LoadError;

/// The parents of all nodes.
#[derive(Debug)]
pub(super) struct Joints {
    parents: BTreeMap<usize, usize>,
}

impl Joints {
    pub(super) fn of(nodes: &[Node]) -> Self {
        let mut parents = BTreeMap::new();
        for (parent, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten() {
                // Second parents are found when the tree is walked.
                parents.entry(child.value()).or_insert(parent);
            }
        }
        Self { parents }
    }
}

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
            let world = DMat4::from(self.world(joint.value())?);
            Ok(world * Mat4::from_cols_array(&inverse).as_dmat4())
        });
        matrices.collect()
    }

    /// From a node's space to the world's, whatever scene it is in.
    fn world(&self, node: usize) -> Result<DAffine3, LoadError> {
        let mut world = DAffine3::IDENTITY;
        let mut next = Some(node);
        for _ in 0..self.root.nodes.len() {
            let Some(index) = next else {
                break;
            };
            let node = &self.root.nodes[index];
            let name = label("node", index, node.name.as_deref());
            world = wide(local(node, &name)?) * world;
            next = self.joints.parents.get(&index).copied();
        }
        if next.is_some() || !world.is_finite() {
            return Err(LoadError::bad_value(
                label("node", node, self.root.nodes[node].name.as_deref()),
                "without a place in the world",
                "a tree of nodes with finite numbers",
            ));
        }
        Ok(world)
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

fn wide(transform: Affine3A) -> DAffine3 {
    DAffine3::from_mat4(Mat4::from(transform).as_dmat4())
}
