//! Small scenes whose shadows are known.

use glam::Vec3;
use scene::{Geometry, Mesh, Scene};

/// The checked form of loose triangles.
///
/// # Panics
/// If none has an area or a corner is not finite.
pub fn geometry(triangles: &[[Vec3; 3]]) -> Geometry {
    let scene = Scene::from(Mesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        ..Mesh::default()
    });
    Geometry::new(&scene).expect("triangles with an area")
}

/// A triangle of a millimetre, a thousand kilometres away: a scene must have
/// one, and this one is in nobody's light.
pub fn nothing() -> Geometry {
    let far = Vec3::new(-1e6, -1e6, -1e6);
    geometry(&[[far, far + Vec3::X, far + Vec3::Y]])
}

/// The parallelogram `corner + a u + b v`, 0 ≤ a, b ≤ 1.
pub fn parallelogram(corner: Vec3, u: Vec3, v: Vec3) -> Vec<[Vec3; 3]> {
    vec![
        [corner, corner + u, corner + u + v],
        [corner, corner + u + v, corner + v],
    ]
}

/// A closed box.
pub fn cuboid(min: Vec3, max: Vec3) -> Vec<[Vec3; 3]> {
    let size = max - min;
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    [
        (min, y, x),
        (min, x, z),
        (min, z, y),
        (max, -x, -y),
        (max, -z, -x),
        (max, -y, -z),
    ]
    .into_iter()
    .flat_map(|(corner, u, v)| parallelogram(corner, u, v))
    .collect()
}

/// A closed mesh inscribed in a sphere: an octahedron of which every triangle
/// was divided into four `levels` times.
pub fn sphere(centre: Vec3, radius: f32, levels: u32) -> Vec<[Vec3; 3]> {
    let mut unit = Vec::new();
    for x in [Vec3::X, Vec3::NEG_X] {
        for y in [Vec3::Y, Vec3::NEG_Y] {
            for z in [Vec3::Z, Vec3::NEG_Z] {
                let outward = x.cross(y).dot(z) > 0.0;
                unit.push(if outward { [x, y, z] } else { [x, z, y] });
            }
        }
    }
    for _ in 0..levels {
        unit = unit
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [d, e, f] = [a + b, b + c, c + a].map(Vec3::normalize);
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    unit.into_iter()
        .map(|corners| corners.map(|corner| centre + radius * corner))
        .collect()
}

/// The radius of the largest ball around `centre` that a closed, convex mesh
/// holds, up to rounding.
pub fn inner_radius(triangles: &[[Vec3; 3]], centre: Vec3) -> f64 {
    triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| (corner - centre).as_dvec3());
            (b - a).cross(c - a).normalize().dot(a).abs()
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    #[test]
    fn solids_are_closed_and_face_outwards() {
        let centre = Vec3::new(0.25, 0.5, -1.0);
        for solid in [
            sphere(centre, 0.75, 3),
            cuboid(centre - Vec3::ONE, centre + Vec3::splat(0.5)),
        ] {
            let mut edges = HashMap::new();
            for [a, b, c] in &solid {
                assert!((*b - *a).cross(*c - *a).dot(*a - centre) > 0.0);
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let key = |p: &Vec3| p.to_array().map(f32::to_bits);
                    *edges.entry((key(from), key(to))).or_insert(0) += 1;
                    *edges.entry((key(to), key(from))).or_insert(0) -= 1;
                }
            }
            assert!(edges.values().all(|count| *count == 0), "a gap");
        }
    }

    #[test]
    fn a_fine_sphere_is_nearly_round() {
        let mesh = sphere(Vec3::ONE, 2.0, 5);
        let inner = inner_radius(&mesh, Vec3::ONE);
        assert!(inner > 1.997 && inner < 2.0, "{inner}");
    }
}
