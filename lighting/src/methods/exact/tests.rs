//! Solid casters.

use reference::random::Random;

use super::*;
use crate::Ray;
use crate::scene::{Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};

fn tracer(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Tracer {
    let scene = Scene::from(Mesh {
        positions,
        triangles,
        ..Mesh::default()
    });
    Tracer::new(&Geometry::new(&scene).unwrap())
}

/// A square of side 2 in the plane y = `height`, centred over the origin.
fn plate(height: f32) -> Tracer {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    tracer(
        corners.map(|(x, z)| Vec3::new(x, height, z)).into(),
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

fn lit(tracer: &Tracer, light: &Emitter, ray: Ray) -> Vec<(f32, f32)> {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let Some(path) = LightPath::new(&ray, light, &medium) else {
        return Vec::new();
    };
    let mut lit = Vec::new();
    Exact::new(tracer).lit_intervals(&path, &mut lit);
    lit.iter()
        .map(|part| (part.interval.start, part.interval.end))
        .collect()
}

/// Walls that meet in a lamp, whose corners rounding puts to either side of it.
#[test]
fn a_light_in_a_corner_of_walls_lights_what_is_between_them() {
    let corner = Vec3::new(3.0, -1.5, -4.0);
    let (x, y, z) = (-6.0 * Vec3::X, 4.0 * Vec3::Y, 5.0 * Vec3::Z);
    let positions = vec![
        corner,
        corner + x,
        corner + x + y,
        corner + y,
        corner + z,
        corner + x + z,
    ];
    let walls = tracer(positions, vec![[0, 2, 1], [0, 3, 2], [0, 5, 4], [0, 1, 5]]);
    let light = point(corner.x, corner.y, corner.z);
    let eye = Vec3::new(-0.3, 0.4, 2.5);
    for step in 0..50 {
        let turn = 0.01 * (step - 25) as f32;
        let ray = Ray::new(eye, Vec3::new(turn, 0.3 * turn, -1.0).normalize(), 5.0).unwrap();
        let parts = lit(&walls, &light, ray);
        assert_eq!(parts.len(), 1, "{step}: {parts:?}");
        assert_eq!(parts[0].0, 0.0, "{step}: {parts:?}");
    }
}

fn point(x: f32, y: f32, z: f32) -> Emitter {
    let position = Vec3::new(x, y, z);
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
}

fn close(found: &[(f32, f32)], expected: &[(f32, f32)]) {
    let same = |a: f32, b: f32| a == b || (a - b).abs() < 1e-5;
    assert!(
        found.len() == expected.len()
            && found
                .iter()
                .zip(expected)
                .all(|(f, e)| same(f.0, e.0) && same(f.1, e.1)),
        "{found:?} instead of {expected:?}"
    );
}

const INF: f32 = f32::INFINITY;

#[test]
fn a_plate_casts_the_shadow_of_similar_triangles() {
    let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.1), Vec3::X, 10.0).unwrap();
    // Halfway between ray and light, so the shadow is twice as wide.
    close(
        &lit(&plate(1.0), &point(0.0, 2.0, 0.1), ray),
        &[(0.0, 3.0), (7.0, 10.0)],
    );
    close(
        &lit(&plate(3.0), &point(0.0, 2.0, 0.1), ray),
        &[(0.0, 10.0)],
    );
    close(
        &lit(&plate(-1.0), &point(0.0, 2.0, 0.1), ray),
        &[(0.0, 10.0)],
    );
    // A light in the plane of the plate is not blocked by it.
    close(
        &lit(&plate(1.0), &point(5.0, 1.0, 0.1), ray),
        &[(0.0, 10.0)],
    );
    let sun = Emitter::directional(Vec3::new(1.0, -1.0, 0.0), Vec3::ONE).unwrap();
    close(&lit(&plate(1.0), &sun, ray), &[(0.0, 5.0), (7.0, 10.0)]);
}

#[test]
fn shadows_reach_the_horizon() {
    let sky = Ray::new(Vec3::new(-5.0, 0.0, 0.1), Vec3::X, INF).unwrap();
    close(
        &lit(&plate(1.0), &point(0.0, 2.0, 0.1), sky),
        &[(0.0, 3.0), (7.0, INF)],
    );
    // What rises above the light shadows all that follows.
    let wall = [(1.0, 0.5, -9.0), (1.0, 0.5, 9.0), (1.0, 100.0, 0.1)];
    let tracer = tracer(wall.map(Vec3::from).into(), vec![[0, 1, 2]]);
    let end = 5.0 + 4.0 / 3.0;
    close(&lit(&tracer, &point(0.0, 2.0, 0.1), sky), &[(0.0, end)]);
}

#[test]
fn on_the_line_of_the_light_blockers_decide_by_distance() {
    let tracer = plate(1.0);
    let down = Ray::new(Vec3::new(0.1, 3.0, 0.2), Vec3::NEG_Y, 8.0).unwrap();
    close(&lit(&tracer, &point(0.1, 4.0, 0.2), down), &[(0.0, 2.0)]);
    close(&lit(&tracer, &point(0.1, 2.5, 0.2), down), &[(0.0, 2.0)]);
    close(&lit(&tracer, &point(0.1, 0.0, 0.2), down), &[(2.0, 8.0)]);
    close(&lit(&tracer, &point(0.1, -9.0, 0.2), down), &[(2.0, 8.0)]);
    let sun = |y: f32| Emitter::directional(Vec3::Y * y, Vec3::ONE).unwrap();
    close(&lit(&tracer, &sun(-1.0), down), &[(0.0, 2.0)]);
    close(&lit(&tracer, &sun(1.0), down), &[(2.0, 8.0)]);
}

#[test]
fn lit_points_are_those_with_a_free_line_to_the_light() {
    let mut random = Random::new(7);
    let mut next = || random.unit() - 0.5;
    let mut vector = |scale: f32| Vec3::new(next(), next(), next()) * scale;
    let mut positions = Vec::new();
    for _ in 0..40 {
        let centre = vector(8.0);
        positions.extend([0; 3].map(|_| centre + vector(3.0)));
    }
    let triangles = (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let tracer = tracer(positions, triangles);
    let mut seen = [0; 2];
    for round in 0..200 {
        let (origin, direction) = (vector(12.0), vector(1.0));
        let ray = Ray::new(origin, direction, 15.0).unwrap();
        let position = vector(10.0);
        let light = if round % 2 == 0 {
            point(position.x, position.y, position.z)
        } else {
            Emitter::directional(position, Vec3::ONE).unwrap()
        };
        let found = lit(&tracer, &light, ray);
        for k in 0..100 {
            let x = 15.0 * (k as f32 + 0.5) / 100.0;
            let near_end = found
                .iter()
                .any(|&(a, b)| (x - a).abs() < 1e-3 || (x - b).abs() < 1e-3);
            if near_end {
                continue;
            }
            let here = ray.at(x);
            let (to_light, distance) = match &light {
                Emitter::Point(_) => (position - here, (position - here).length()),
                Emitter::Directional(sun) => (-sun.direction(), INF),
            };
            let free = !tracer.occluded(here, to_light.normalize(), 0.0, distance);
            let claimed = found.iter().any(|&(a, b)| a < x && x < b);
            assert_eq!(free, claimed, "round {round}, x = {x}, {found:?}");
            seen[usize::from(free)] += 1;
        }
    }
    assert!(seen[0] > 1000 && seen[1] > 1000, "{seen:?}");
}
