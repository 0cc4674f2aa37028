//! Meshes as large and as complicated as those that papers measure and nobody else has.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::primitives::{append, cuboid, icosphere, torus_grid, tube};
use crate::Mesh;

/// A closed mesh that stands for one of table 1 of Wyman and Ramsey, Interactive Volumetric
/// Shadows in Participating Media with Single-Scattering, RT 2008: with about as many
/// triangles, from 20,000 to 755,000, and about as complicated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StandIn {
    /// For a sphere.
    Ball,
    /// Five balls, for an elephant.
    Cluster,
    /// For a spring.
    Spring,
    /// A ball with dents, for a bunny.
    Dented,
    /// Thirty small balls, for the scene with a fairy.
    Crowd,
    /// Five thick rings, for a buddha.
    Stack,
    /// 59 thin rings through each other, for the one called YeahRight.
    Tangle,
}

impl StandIn {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 7] = [
        Self::Ball,
        Self::Cluster,
        Self::Spring,
        Self::Dented,
        Self::Crowd,
        Self::Stack,
        Self::Tangle,
    ];

    /// What it is.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Cluster => "cluster of balls",
            Self::Spring => "spring",
            Self::Dented => "dented ball",
            Self::Crowd => "crowd of balls",
            Self::Stack => "stack of rings",
            Self::Tangle => "tangle of rings",
        }
    }

    /// The mesh, in a ball of radius 1.25 m around the origin.
    pub fn mesh(self) -> Mesh {
        match self {
            Self::Ball => icosphere(5),
            Self::Cluster => cluster(),
            Self::Spring => spring(),
            Self::Dented => dented(),
            Self::Crowd => crowd(),
            Self::Stack => stack(),
            Self::Tangle => tangle(),
        }
    }

    /// The mesh in the place of the ball of the scene
    /// [`TexturedSpot`](super::Embedded::TexturedSpot), above its floor.
    pub fn above_a_floor(self) -> Mesh {
        let mut mesh = moved(&self.mesh(), 1.0, Quat::IDENTITY, 1.3 * Vec3::Y);
        let floor = cuboid(Vec3::new(-12.0, -0.3, -12.0), Vec3::new(12.0, 0.0, 12.0));
        append(&mut mesh, &floor);
        mesh
    }
}

/// The same mesh elsewhere.
fn moved(mesh: &Mesh, scale: f32, rotation: Quat, to: Vec3) -> Mesh {
    let place = |p: &Vec3| to + rotation * (scale * *p);
    Mesh {
        positions: mesh.positions.iter().map(place).collect(),
        triangles: mesh.triangles.clone(),
        ..Mesh::default()
    }
}

/// Directions that are spread evenly: the golden angle between neighbours.
fn direction(index: u32, of: u32) -> Vec3 {
    let z = 1.0 - (2.0 * index as f32 + 1.0) / of as f32;
    let turn = 2.399_963 * index as f32;
    let radius = (1.0 - z * z).sqrt();
    Vec3::new(radius * turn.cos(), z, radius * turn.sin())
}

fn cluster() -> Mesh {
    let ball = icosphere(4);
    let mut mesh = moved(&ball, 0.6, Quat::IDENTITY, Vec3::ZERO);
    for index in 0..4 {
        let to = 0.65 * direction(index, 4);
        append(&mut mesh, &moved(&ball, 0.35, Quat::IDENTITY, to));
    }
    mesh
}

fn spring() -> Mesh {
    let curve: Vec<Vec3> = (0..=640)
        .map(|i| {
            let t = i as f32 / 640.0;
            let turn = 8.0 * TAU * t;
            Vec3::new(0.75 * turn.cos(), 1.8 * t - 0.9, 0.75 * turn.sin())
        })
        .collect();
    tube(&curve, 0.07, 25)
}

fn dented() -> Mesh {
    let mut mesh = icosphere(6);
    for p in &mut mesh.positions {
        let waves = (7.0 * p.x).sin() * (6.0 * p.y).sin() * (8.0 * p.z).sin();
        *p *= 0.85 + 0.15 * waves;
    }
    mesh
}

fn crowd() -> Mesh {
    let ball = icosphere(4);
    let mut mesh = Mesh::default();
    for index in 0..30 {
        let distance = 0.45 + 0.5 * (index % 5) as f32 / 4.0;
        let scale = 0.09 + 0.04 * (index % 3) as f32;
        let to = distance * direction(index, 30);
        append(&mut mesh, &moved(&ball, scale, Quat::IDENTITY, to));
    }
    mesh
}

/// A ring of radius 1 around the y axis, `thin` thick.
fn ring(columns: u32, rows: u32, thin: f32) -> Mesh {
    torus_grid(columns, rows, |u, v| {
        let (around, across) = (TAU * u, TAU * v);
        let radius = 1.0 + thin * across.cos();
        Vec3::new(
            radius * around.cos(),
            thin * across.sin(),
            -radius * around.sin(),
        )
    })
}

fn stack() -> Mesh {
    let ring = ring(500, 50, 0.3);
    let mut mesh = Mesh::default();
    for index in 0..5 {
        let height = 0.4 * index as f32 - 0.8;
        let scale = 0.7 - 0.15 * height.abs();
        let to = height * Vec3::Y;
        append(&mut mesh, &moved(&ring, scale, Quat::IDENTITY, to));
    }
    mesh
}

fn tangle() -> Mesh {
    let ring = ring(320, 20, 0.06);
    let mut mesh = Mesh::default();
    for index in 0..59 {
        let axis = direction(index, 59);
        let to = 0.45 * direction((7 * index) % 59, 59);
        let rotation = Quat::from_rotation_arc(Vec3::Y, axis);
        append(&mut mesh, &moved(&ring, 0.5, rotation, to));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geometry, Scene};

    #[test]
    fn stand_ins_have_about_as_many_triangles_as_the_meshes_of_the_table() {
        let paper = [20e3, 24e3, 32e3, 70e3, 155e3, 250e3, 755e3];
        for (stand_in, triangles) in StandIn::ALL.into_iter().zip(paper) {
            let mesh = stand_in.mesh();
            let ratio = mesh.triangles.len() as f64 / triangles;
            assert!((0.9..1.2).contains(&ratio), "{stand_in:?}: {ratio}");
            let reach = mesh.positions.iter().map(|p| p.length());
            assert!(reach.fold(0.0, f32::max) < 1.25, "{stand_in:?}");
            let geometry = Geometry::new(&Scene::from(mesh)).unwrap();
            assert_eq!(geometry.dropped(), 0, "{stand_in:?}");
            let whole = stand_in.above_a_floor();
            assert_eq!(whole.triangles.len(), geometry.triangles().len() + 12);
        }
    }
}
