//! Rays that are asked together have the shadows that they have by themselves.

use glam::Vec3;
use reference::random::Random;

use super::{Exact, Plane, Shadow, darken};
use crate::scene::trace::Tracer;
use crate::scene::{
    AlphaMode, Emission, Emitter, Geometry, Material, Medium, Mesh, PhaseFunction, Scene,
};
use crate::visibility::{LitInterval, VisibilitySource};
use crate::{LightPath, Ray};

type Lit = Vec<LitInterval<Vec3>>;

/// Random numbers, and vectors in a cube around zero.
struct Draw(Random);

impl Draw {
    fn below(&mut self, count: usize) -> usize {
        ((self.0.unit() * count as f32) as usize).min(count - 1)
    }

    fn vector(&mut self, side: f32) -> Vec3 {
        let mut next = || self.0.unit() - 0.5;
        Vec3::new(next(), next(), next()) * side
    }

    /// Triangles of all sizes, strips that share edges and floors along the axes, some of
    /// them see-through.
    fn scene(&mut self) -> Scene {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for _ in 0..[1, 5, 40, 300][self.below(4)] {
            let first = positions.len() as u32;
            let (centre, size) = (self.vector(8.0), [0.01, 0.3, 3.0, 30.0][self.below(4)]);
            match self.below(3) {
                0 => {
                    positions.extend([0; 3].map(|_| centre + self.vector(size)));
                    triangles.push([first, first + 1, first + 2]);
                }
                1 => {
                    positions.extend([0; 8].map(|_| centre + self.vector(size)));
                    triangles.extend((first..first + 6).map(|i| [i, i + 1, i + 2]));
                }
                _ => {
                    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
                    positions.extend(corners.map(|(x, z)| centre + size * Vec3::new(x, 0.0, z)));
                    triangles.push([first, first + 1, first + 2]);
                    triangles.push([first, first + 2, first + 3]);
                }
            }
        }
        let mesh = |material| Mesh {
            positions: positions.clone(),
            triangles: triangles.clone(),
            material,
            ..Mesh::default()
        };
        let mut scene = Scene::from(mesh((self.below(4) == 0).then_some(0)));
        scene.materials.push(Material {
            opacity: 0.25,
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
        scene
    }

    /// A light near the eye, among the triangles, far away or infinitely far.
    fn light(&mut self, eye: Vec3) -> Emitter {
        let position = match self.below(6) {
            0 => eye + self.vector(1e-3),
            1 => eye + self.vector(1e6),
            2 => eye,
            3 => return Emitter::directional(self.vector(1.0), Vec3::ONE).unwrap(),
            4 => return Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap(),
            _ => self.vector(8.0),
        };
        let range = [f32::INFINITY, 5.0][self.below(2)];
        Emitter::point(position, Vec3::ONE, range, Emission::Isotropic).unwrap()
    }

    /// A ray into any direction or about one, at the light, away from it or just beside.
    fn ray(&mut self, eye: Vec3, view: Vec3, light: &Emitter) -> Ray {
        let to_light = match light {
            Emitter::Point(point) => point.position() - eye,
            Emitter::Directional(sun) => -sun.direction(),
        };
        let to_light = to_light.try_normalize().unwrap_or(Vec3::X);
        let direction = match self.below(8) {
            0 => self.vector(1.0),
            1 => to_light,
            2 => -to_light,
            3 => to_light + self.vector(1e-5),
            4 => to_light + self.vector(1e-2),
            _ => view + self.vector(0.3),
        };
        let length = match self.below(6) {
            0 => 0.0,
            1 => f32::INFINITY,
            2 => 1e-3,
            _ => 20.0 * self.0.unit(),
        };
        Ray::new(eye, direction.normalize(), length).unwrap()
    }
}

/// The lit parts by asking every triangle.
fn by_all(geometry: &Geometry, path: &LightPath<'_>) -> Option<Lit> {
    let plane = Plane::new(path)?;
    let mut shadow = Shadow::new(path);
    for (index, triangle) in geometry.triangles().iter().enumerate() {
        let caster = geometry.coatings().caster(index);
        darken(&mut shadow, &plane, &plane.seen(triangle), caster);
    }
    let mut lit = Vec::new();
    shadow.lit(&mut lit);
    Some(lit)
}

#[test]
fn rays_have_the_same_lit_parts_alone_together_and_by_all_triangles() {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let mut draw = Draw(Random::new(22));
    let mut shadowed = 0;
    for round in 0..600 {
        let scene = draw.scene();
        let geometry = Geometry::new(&scene).unwrap();
        let tracer = Tracer::new(&geometry);
        let exact = Exact::new(&tracer);
        let eye = draw.vector(10.0);
        let light = draw.light(eye);
        let view = draw.vector(1.0);
        let count = [1, 2, 30, 200][draw.below(4)];
        let rays: Vec<Ray> = (0..count).map(|_| draw.ray(eye, view, &light)).collect();
        let order = exact.neighbours(&rays, &light);
        let order = order.unwrap_or_else(|| (0..rays.len() as u32).collect());
        let mut numbers = order.clone();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..rays.len() as u32));
        for group in order.chunks([1, 64, 1000][draw.below(3)]) {
            let paths: Vec<LightPath<'_>> = (group.iter())
                .filter_map(|ray| LightPath::new(&rays[*ray as usize], &light, &medium))
                .collect();
            let mut together = vec![Vec::new(); paths.len()];
            exact.lit_of_neighbours(&paths, &mut |path, lit| together[path].append(lit));
            for (path, together) in paths.iter().zip(together) {
                let mut alone = Vec::new();
                exact.lit_intervals(path, &mut alone);
                assert_eq!(together, alone, "round {round}: {path:?}");
                if let Some(by_all) = by_all(&geometry, path) {
                    assert_eq!(alone, by_all, "round {round}: {path:?}");
                }
                let whole = LitInterval::unshadowed(path.span().start, path.span().end);
                shadowed += usize::from(alone != [whole]);
            }
        }
    }
    assert!(shadowed > 3000, "{shadowed}");
}

#[test]
fn rays_from_several_eyes_are_asked_as_well() {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let mut draw = Draw(Random::new(23));
    let tracer = Tracer::new(&Geometry::new(&draw.scene()).unwrap());
    let exact = Exact::new(&tracer);
    let lights = [draw.light(Vec3::X), draw.light(Vec3::Y)];
    let rays: Vec<Ray> = (0..100)
        .map(|_| {
            let eye = draw.vector(10.0);
            draw.ray(eye, Vec3::Z, &lights[0])
        })
        .collect();
    assert_eq!(exact.neighbours(&rays, &lights[0]), None);
    let paths: Vec<LightPath<'_>> = (rays.iter().enumerate())
        .filter_map(|(i, ray)| LightPath::new(ray, &lights[i % 2], &medium))
        .collect();
    let mut together = vec![Vec::new(); paths.len()];
    exact.lit_of_neighbours(&paths, &mut |path, lit| together[path].append(lit));
    for (path, together) in paths.iter().zip(together) {
        let mut alone = Vec::new();
        exact.lit_intervals(path, &mut alone);
        assert_eq!(together, alone);
    }
}
