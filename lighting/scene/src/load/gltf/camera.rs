//! Cameras: the first perspective one, or what stands for an orthographic one.

use glam::{Affine3A, Vec3};
use gltf_json::Node;

use super::node::rotation;
use super::{Builder, entry, label};
use crate::load::LoadError;
use crate::{Camera, Mesh};

/// An orthographic camera that may have to be replaced.
#[derive(Debug, Clone)]
pub(super) struct Orthographic {
    what: String,
    world: Affine3A,
    /// Half the height of its frame, m.
    half: f32,
}

/// Full vertical field of view of the camera that stands for an orthographic one:
/// 30°. A smaller one would be nearer to its picture, but see it through more fog.
const FIELD_OF_VIEW: f32 = std::f32::consts::FRAC_PI_6;

impl Builder<'_> {
    /// Takes the camera of a node over.
    pub(super) fn camera(
        &mut self,
        node: &Node,
        name: &str,
        world: Affine3A,
    ) -> Result<(), LoadError> {
        let Some(index) = node.camera else {
            return Ok(());
        };
        let camera = entry(&self.root.cameras, index, name, "camera")?;
        let what = label("camera", index.value(), camera.name.as_deref());
        if camera.perspective.is_none()
            && let Some(orthographic) = &camera.orthographic
        {
            let half = orthographic.ymag;
            if !(half.is_finite() && half > 0.0) {
                return Err(LoadError::bad_value(
                    format!("ymag of {what}"),
                    half,
                    "a finite number above 0",
                ));
            }
            if self.orthographic.is_none() {
                self.orthographic = Some(Orthographic { what, world, half });
            }
            return Ok(());
        }
        let Some(perspective) = &camera.perspective else {
            self.notes
                .add(format!("{what} ignored: it has no projection"));
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
        self.scene.camera = Some(Camera::new(world.translation, rotation, perspective.yfov)?);
        Ok(())
    }

    /// Puts a perspective camera in the place of an orthographic one if there is no
    /// other: it looks the same way, and from so far that in the middle of the scene its
    /// frame has the same height.
    pub(super) fn replace_orthographic(&mut self) -> Result<(), LoadError> {
        let Some(Orthographic { what, world, half }) = self.orthographic.take() else {
            return Ok(());
        };
        if self.scene.camera.is_some() {
            self.notes.add(format!(
                "{what} ignored: the first perspective camera is used"
            ));
            return Ok(());
        }
        let Some(rotation) = rotation(world) else {
            self.notes
                .add(format!("{what} ignored: it is scaled to nothing"));
            return Ok(());
        };
        let forward = rotation * Vec3::NEG_Z;
        let place = Vec3::from(world.translation);
        let middle = self.middle_along(place, forward);
        let distance = half / (0.5 * FIELD_OF_VIEW).tan();
        let eye = place + (middle - distance) * forward;
        self.scene.camera = Some(Camera::new(eye, rotation, FIELD_OF_VIEW)?);
        self.notes.add(format!(
            "{what} is orthographic: a perspective one stands for it, whose picture has the \
             same height in the middle of the scene"
        ));
        Ok(())
    }

    /// How far along `forward` from `place` the middle of all instances is.
    fn middle_along(&self, place: Vec3, forward: Vec3) -> f32 {
        let corners = |mesh: &Mesh| {
            let finite = mesh
                .positions
                .iter()
                .filter(|position| position.is_finite());
            finite.fold(
                [Vec3::INFINITY, Vec3::NEG_INFINITY],
                |[min, max], position| [min.min(*position), max.max(*position)],
            )
        };
        let boxes: Vec<[Vec3; 2]> = self.scene.meshes.iter().map(corners).collect();
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for instance in &self.scene.instances {
            for corner in 0..8 {
                let pick = |axis: usize| boxes[instance.mesh][corner >> axis & 1][axis];
                let corner = Vec3::new(pick(0), pick(1), pick(2));
                let depth = (instance.transform.transform_point3(corner) - place).dot(forward);
                if depth.is_finite() {
                    least = least.min(depth);
                    most = most.max(depth);
                }
            }
        }
        if least <= most {
            0.5 * (least + most)
        } else {
            0.0
        }
    }
}
