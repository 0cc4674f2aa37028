//! What the suites share: set-ups, blockers, random maps.
#![allow(dead_code, reason = "each suite uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use epipolar::{Lattice, Light, LightRay, Resolution, Space, Spacing, ViewVolume};
use glam::Vec3;
use gpu_backend::{Cpu, Host};
use voxel_shadow::{BuildGrid, Grid, IndexMap, Rectify};

pub(crate) const EYE: Vec3 = Vec3::new(0.2, 1.7, 8.0);

pub(crate) fn camera(near: f32, far: f32) -> ViewVolume {
    ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.9, 0.6], near, far).unwrap()
}

/// In view, above the screen, beside it, behind the eye, almost at the eye,
/// parallel from the side and from the front and from behind, a cone.
pub(crate) fn lights() -> Vec<Light> {
    vec![
        Light::point(Vec3::new(1.0, 3.0, -2.0)).unwrap(),
        Light::point(Vec3::new(0.5, 9.0, 3.0)).unwrap(),
        Light::point(Vec3::new(9.0, 2.0, 2.0)).unwrap(),
        Light::point(Vec3::new(0.4, 2.2, 14.0)).unwrap(),
        Light::point(EYE + Vec3::new(1e-3, 2e-3, -1e-3)).unwrap(),
        Light::directional(Vec3::new(1.0, -0.6, 0.1)).unwrap(),
        Light::directional(Vec3::new(0.05, -0.1, 1.0)).unwrap(),
        Light::directional(Vec3::new(0.05, -0.1, -1.0)).unwrap(),
        spot(),
    ]
}

/// A spotlight that shines downwards.
pub(crate) fn spot() -> Light {
    Light::spot(Vec3::new(0.0, 6.0, 0.0), Vec3::NEG_Y, 0.6).unwrap()
}

pub(crate) fn lattice(light: Light, view: &ViewVolume, [alpha, theta, bits]: [u32; 3]) -> Lattice {
    let space = Space::new(light, EYE).unwrap();
    let resolution = Resolution::new(alpha, theta, bits).unwrap();
    Lattice::new(space, view, resolution, Spacing::Angle).unwrap()
}

/// A ball, and where a ray first meets it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) centre: Vec3,
    pub(crate) radius: f32,
}

impl Ball {
    pub(crate) fn distance(&self, ray: &LightRay, parallel: bool) -> f32 {
        let to_centre = (self.centre - Vec3::from(ray.origin)).as_dvec3();
        let direction = Vec3::from(ray.direction).as_dvec3();
        let along = to_centre.dot(direction) / direction.length();
        let h2 = to_centre.cross(direction).length_squared() / direction.length_squared();
        let inside = f64::from(self.radius).powi(2) - h2;
        if inside < 0.0 {
            return f32::INFINITY;
        }
        let near = along - inside.sqrt();
        if parallel || near >= 0.0 {
            near as f32
        } else if along + inside.sqrt() >= 0.0 {
            0.0
        } else {
            f32::INFINITY
        }
    }
}

pub(crate) fn balls() -> Vec<Ball> {
    [
        ([0.0, 1.5, 2.0], 0.8),
        ([-2.0, 2.5, 0.0], 0.6),
        ([1.6, 0.7, 3.0], 0.4),
        ([0.0, 3.5, -4.0], 1.2),
    ]
    .map(|(centre, radius)| Ball {
        centre: Vec3::from_array(centre),
        radius,
    })
    .into()
}

/// The first of several balls.
pub(crate) fn first(balls: &[Ball], parallel: bool) -> impl Fn(&LightRay) -> f32 + Sync + '_ {
    move |ray| {
        balls
            .iter()
            .map(|ball| ball.distance(ray, parallel))
            .fold(f32::INFINITY, f32::min)
    }
}

/// An extruded grid.
pub(crate) fn build(lattice: &Lattice, balls: &[Ball]) -> (IndexMap<Host>, Grid<Host>) {
    let cpu = Cpu::new();
    let mut map = IndexMap::new(&cpu, lattice.resolution()).unwrap();
    let mut grid = Grid::new(&cpu, lattice.resolution()).unwrap();
    let parallel = lattice.space().is_directional();
    cpu.rectify(lattice, &first(balls, parallel), &mut map)
        .unwrap();
    cpu.voxelise(&map, &mut grid).unwrap();
    cpu.extrude(&mut grid).unwrap();
    (map, grid)
}

/// Whether a ball is between a point and the light.
pub(crate) fn is_lit(light: Light, balls: &[Ball], sun: Vec3, point: Vec3) -> bool {
    balls.iter().all(|ball| {
        let to_centre = (ball.centre - point).as_dvec3();
        let to_light = match light.position() {
            Some(position) => (Vec3::from(position) - point).as_dvec3(),
            None => -1e6 * sun.as_dvec3(),
        };
        let t = (to_centre.dot(to_light) / to_light.length_squared()).clamp(0.0, 1.0);
        (to_centre - t * to_light).length() > f64::from(ball.radius)
    })
}
