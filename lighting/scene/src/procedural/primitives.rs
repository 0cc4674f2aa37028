//! Closed meshes of simple shapes, counter-clockwise seen from outside.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::random::circle;
use crate::Mesh;

fn closed(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// The box between two corners: 12 triangles.
pub(crate) fn cuboid(min: Vec3, max: Vec3) -> Mesh {
    let corner = |i: u32| {
        let pick = |bit: u32, low, high| if i >> bit & 1 == 0 { low } else { high };
        Vec3::new(
            pick(0, min.x, max.x),
            pick(1, min.y, max.y),
            pick(2, min.z, max.z),
        )
    };
    // Corners of the sides −x, +x, −y, +y, −z, +z.
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    closed((0..8).map(corner).collect(), triangles)
}

/// A prism of `sides` ≥ 3 sides along +Y from 0 to `height`, whose corners lie
/// on circles of radius `bottom` and `top`: 4 `sides` − 4 triangles.
pub(super) fn frustum(sides: u32, bottom: f32, top: f32, height: f32) -> Mesh {
    let ring = |radius: f32, y: f32| {
        (0..sides).map(move |i| {
            let p = radius * circle(i as f32 / sides as f32);
            Vec3::new(p.x, y, -p.y)
        })
    };
    let positions = ring(bottom, 0.0).chain(ring(top, height)).collect();
    closed(positions, stacked_rings(2, sides))
}

/// A ball of radius 1: an icosahedron split `level` times, 20 · 4^`level`
/// triangles.
pub(super) fn icosphere(level: u32) -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let mut positions = Vec::with_capacity(12);
    for (one, long) in [
        (1.0, golden),
        (1.0, -golden),
        (-1.0, golden),
        (-1.0, -golden),
    ] {
        positions.push(Vec3::new(0.0, one, long).normalize());
        positions.push(Vec3::new(one, long, 0.0).normalize());
        positions.push(Vec3::new(long, 0.0, one).normalize());
    }
    // The faces are the triples of corners at edge distance from each other.
    let edge = 1.2 * (positions[0] - Vec3::new(0.0, -1.0, golden).normalize()).length();
    let near = |a: usize, b: usize| (positions[a] - positions[b]).length() < edge;
    let mut triangles = Vec::with_capacity(20);
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(|i| positions[i]);
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    let (b, c) = if outward { (b, c) } else { (c, b) };
                    triangles.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for _ in 0..level {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = positions[a as usize] + positions[b as usize];
                positions.push(sum.normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let ab = middle(a, b, &mut positions);
                let bc = middle(b, c, &mut positions);
                let ca = middle(c, a, &mut positions);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    closed(positions, triangles)
}

/// A tube of `sides` ≥ 3 sides around a curve of two or more different points,
/// with flat ends. The frame is carried along without twist.
pub(super) fn tube(curve: &[Vec3], radius: f32, sides: u32) -> Mesh {
    let tangent = |i: usize| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(curve.len() - 1));
        (curve[after] - curve[before]).normalize_or(Vec3::Y)
    };
    let mut across = tangent(0).any_orthonormal_vector();
    let mut positions = Vec::with_capacity(curve.len() * sides as usize);
    for (i, &centre) in curve.iter().enumerate() {
        let along = tangent(i);
        across = across
            .reject_from_normalized(along)
            .try_normalize()
            .unwrap_or_else(|| along.any_orthonormal_vector());
        let other = along.cross(across);
        for side in 0..sides {
            let p = radius * circle(side as f32 / sides as f32);
            positions.push(centre + p.x * across + p.y * other);
        }
    }
    closed(positions, stacked_rings(curve.len() as u32, sides))
}

/// A closed surface of the topology of a torus: `point(u, v)` for u, v in
/// [0, 1), with ∂u × ∂v pointing outwards.
pub(super) fn torus_grid(columns: u32, rows: u32, point: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let mut positions = Vec::with_capacity((columns * rows) as usize);
    let mut triangles = Vec::with_capacity(2 * (columns * rows) as usize);
    for column in 0..columns {
        let next_column = (column + 1) % columns * rows;
        for row in 0..rows {
            positions.push(point(
                column as f32 / columns as f32,
                row as f32 / rows as f32,
            ));
            let next_row = (row + 1) % rows;
            let here = column * rows;
            let [a, b] = [here + row, next_column + row];
            let [c, d] = [next_column + next_row, here + next_row];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    closed(positions, triangles)
}

/// A block of `cells` × `cells` columns over a square centred on the origin,
/// whose top has the height `height(x, z)`, with vertical sides and a flat
/// bottom at `base`, below all heights.
pub(super) fn terrain_block(
    cells: u32,
    size: f32,
    base: f32,
    height: impl Fn(Vec2) -> f32,
) -> Mesh {
    let side = cells + 1;
    let at = |i: u32| size * (i as f32 / cells as f32 - 0.5);
    let mut positions = Vec::with_capacity((side * side + 4 * cells) as usize);
    let mut triangles = Vec::with_capacity((2 * cells * cells + 12 * cells) as usize);
    for j in 0..side {
        for i in 0..side {
            let (x, z) = (at(i), at(j));
            positions.push(Vec3::new(x, height(Vec2::new(x, z)), z));
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let [a, b] = [j * side + i, j * side + i + 1];
            let [c, d] = [a + side, b + side];
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    // The rim, counter-clockwise seen from above, and its foot below.
    let mut rim = Vec::with_capacity(4 * cells as usize);
    rim.extend((0..cells).map(|j| j * side));
    rim.extend((0..cells).map(|i| cells * side + i));
    rim.extend((0..cells).map(|j| (cells - j) * side + cells));
    rim.extend((0..cells).map(|i| cells - i));
    let foot = positions.len() as u32;
    for &top in &rim {
        let above = positions[top as usize];
        positions.push(Vec3::new(above.x, base, above.z));
    }
    let centre = positions.len() as u32;
    positions.push(Vec3::new(0.0, base, 0.0));
    let around = rim.len() as u32;
    for i in 0..around {
        let next = (i + 1) % around;
        let (top, top_next) = (rim[i as usize], rim[next as usize]);
        let (low, low_next) = (foot + i, foot + next);
        triangles.extend([
            [top, low, low_next],
            [top, low_next, top_next],
            [centre, low_next, low],
        ]);
    }
    closed(positions, triangles)
}

/// Both shapes in one mesh, each a component of its own.
pub(super) fn append(mesh: &mut Mesh, part: &Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend_from_slice(&part.positions);
    mesh.triangles.extend(
        part.triangles
            .iter()
            .map(|t| t.map(|corner| first + corner)),
    );
}

/// The volume a closed mesh holds, negative if it is inside out: a sixth of the
/// sum of the triple products of the corners.
#[cfg(test)]
pub(super) fn volume(mesh: &Mesh) -> f32 {
    let product = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles.iter().map(product).sum::<f64>() as f32
}

/// Triangles between `rings` rings of `sides` positions each, and two lids.
/// The rings run counter-clockwise seen from the far end.
fn stacked_rings(rings: u32, sides: u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity((2 * rings * sides) as usize);
    for ring in 0..rings - 1 {
        for side in 0..sides {
            let next = (side + 1) % sides;
            let [a, b] = [ring * sides + side, ring * sides + next];
            let [c, d] = [a + sides, b + sides];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let last = (rings - 1) * sides;
    for side in 1..sides - 1 {
        triangles.push([0, side + 1, side]);
        triangles.push([last, last + side, last + side + 1]);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::closed_components;

    fn check(mesh: &Mesh, triangles: usize, expected: f32) {
        assert_eq!(closed_components(mesh), 1);
        assert_eq!(mesh.triangles.len(), triangles);
        let volume = volume(mesh);
        assert!(
            (volume / expected - 1.0).abs() < 0.03,
            "{volume} {expected}"
        );
    }

    #[test]
    fn every_shape_is_closed_and_faces_outwards() {
        let pi = std::f32::consts::PI;
        check(&cuboid(Vec3::ONE, Vec3::new(2.0, 3.0, 4.0)), 12, 6.0);
        check(&frustum(32, 1.0, 1.0, 2.0), 124, 2.0 * pi);
        check(&frustum(32, 1.0, 0.5, 3.0), 124, 1.75 * pi);
        check(&icosphere(3), 1280, 4.0 / 3.0 * pi);
        let curve = [Vec3::ZERO, Vec3::X, Vec3::new(2.0, 0.0, 0.0)];
        check(&tube(&curve, 0.5, 32), 4 * 32 + 60, 0.5 * pi);
        let torus = torus_grid(64, 64, |u, v| {
            let (ring, tube) = (circle(u), circle(v));
            let radius = 3.0 + tube.x;
            Vec3::new(radius * ring.x, radius * ring.y, tube.y)
        });
        check(&torus, 8192, 6.0 * pi * pi);
        let slope = |p: Vec2| 1.0 + 0.1 * p.x;
        check(&terrain_block(8, 2.0, -1.0, slope), 128 + 96, 8.0);
    }

    #[test]
    fn appended_parts_stay_apart() {
        let mut mesh = cuboid(Vec3::ZERO, Vec3::ONE);
        append(&mut mesh, &icosphere(0));
        assert_eq!(closed_components(&mesh), 2);
    }
}
