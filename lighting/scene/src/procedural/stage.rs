//! A scene while it is being set up.
//!
//! The constructors here take numbers that are written down in this module's
//! neighbours, so that a number out of its domain is a mistake in the source
//! and not a user's; the tests build every scene.

use glam::{Affine3A, Mat3, Quat, Vec3};

use super::primitives::cuboid;
use super::random::circle;
use crate::{AreaLight, Camera, Instance, Light, Material, Medium, Mesh, PhaseFunction, Scene};

/// Meshes and instances so far.
#[derive(Debug)]
pub(super) struct Stage(Scene);

/// A mesh on the stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape(usize);

impl Stage {
    pub(super) fn new(name: &str) -> Self {
        Self(Scene {
            name: name.into(),
            ..Scene::default()
        })
    }

    /// Adds a mesh of its own material, to be placed any number of times.
    pub(super) fn shape(&mut self, name: &str, mesh: Mesh, material: Material) -> Shape {
        self.0.materials.push(material);
        self.0.meshes.push(Mesh {
            name: name.into(),
            material: Some(self.0.materials.len() - 1),
            ..mesh
        });
        Shape(self.0.meshes.len() - 1)
    }

    /// Places a mesh in the world.
    pub(super) fn place(&mut self, shape: Shape, transform: Affine3A) {
        self.0.instances.push(Instance {
            mesh: shape.0,
            transform,
            ..Instance::default()
        });
    }

    /// Places a mesh that moves.
    pub(super) fn place_dynamic(&mut self, shape: Shape, transform: Affine3A) {
        self.0.instances.push(Instance {
            mesh: shape.0,
            transform,
            dynamic: true,
            ..Instance::default()
        });
    }

    /// Adds a mesh and places it where it is.
    pub(super) fn add(&mut self, name: &str, mesh: Mesh, material: Material) {
        let shape = self.shape(name, mesh, material);
        self.place(shape, Affine3A::IDENTITY);
    }

    /// A rectangle along X and Z that glows downwards, X × Z = −Y, under a casing.
    pub(super) fn panel(
        &mut self,
        corner: Vec3,
        [width, depth]: [f32; 2],
        radiance: Vec3,
    ) -> AreaLight {
        let casing = cuboid(
            corner + Vec3::new(0.0, 0.01, 0.0),
            corner + Vec3::new(width, 0.09, depth),
        );
        let glow = Material {
            base_color: Vec3::ZERO,
            emitted: 0.008 * radiance,
            ..Material::default()
        };
        self.add("light", casing, glow);
        AreaLight {
            corner,
            edges: [width * Vec3::X, depth * Vec3::Z],
            radiance,
            ..AreaLight::default()
        }
    }

    /// A grey floor of 24 m a side.
    pub(super) fn floor(&mut self) {
        let floor = cuboid(Vec3::new(-12.0, -0.3, -12.0), Vec3::new(12.0, 0.0, 12.0));
        self.add("floor", floor, paint(0.55, 0.55, 0.55));
    }

    /// The finished scene.
    pub(super) fn seen(self, camera: Camera, lights: Vec<Light>, medium: Medium) -> Scene {
        Scene {
            camera: Some(camera),
            lights,
            medium: Some(medium),
            ..self.0
        }
    }
}

/// A diffuse surface.
pub(super) fn paint(red: f32, green: f32, blue: f32) -> Material {
    Material {
        base_color: Vec3::new(red, green, blue),
        ..Material::default()
    }
}

/// Scaled, turned about +Y by a fraction of a full turn, and moved.
pub(super) fn upright(scale: Vec3, turns: f32, position: Vec3) -> Affine3A {
    let p = circle(turns);
    let turn = Mat3::from_cols(Vec3::new(p.x, 0.0, -p.y), Vec3::Y, Vec3::new(p.y, 0.0, p.x));
    Affine3A::from_mat3_translation(turn * Mat3::from_diagonal(scale), position)
}

/// A camera at `eye`, with `target` in the middle and the vertical field of
/// view in degrees.
pub(super) fn look(eye: Vec3, target: Vec3, degrees: f32) -> Camera {
    Camera::look_at(eye, target, degrees.to_radians()).expect("numbers of this program")
}

/// The rotation of a light at `from` that shines on `to`: that of a camera.
pub(super) fn aim(from: Vec3, to: Vec3) -> Quat {
    look(from, to, 60.0).rotation()
}

/// An even fog that scatters nearly all of what it takes.
pub(super) fn pale_fog() -> Medium {
    let isotropic = PhaseFunction::Isotropic;
    fog(Vec3::splat(0.10), Vec3::splat(0.01), isotropic)
}

/// A medium without bounds.
pub(super) fn fog(sigma_s: Vec3, sigma_a: Vec3, phase: PhaseFunction) -> Medium {
    Medium::new(sigma_s, sigma_a, phase).expect("numbers of this program")
}
