//! Which parts of a mesh are closed solids.

use crate::Mesh;

/// The number of connected components without a hole.
///
/// Triangles are connected if they share a position index; positions that
/// coincide under different indices are not welded. A component is closed if
/// each of its directed edges occurs once and has exactly one opposite.
/// Triangles that use an index twice have no area and are ignored.
///
/// # Panics
/// If a corner is not an index of the positions.
pub fn closed_components(mesh: &Mesh) -> usize {
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut edges = Vec::with_capacity(3 * mesh.triangles.len());
    for &[a, b, c] in &mesh.triangles {
        if a == b || b == c || c == a {
            continue;
        }
        join(&mut parent, a, b);
        join(&mut parent, b, c);
        // Both directions of an edge become neighbours in sorted order.
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edges.push((from.min(to), from.max(to), from < to));
        }
    }
    edges.sort_unstable();

    let mut used = vec![false; parent.len()];
    let mut open = vec![false; parent.len()];
    for run in edges.chunk_by(|l, r| (l.0, l.1) == (r.0, r.1)) {
        let component = root(&mut parent, run[0].0) as usize;
        used[component] = true;
        open[component] |= !matches!(run, [(_, _, false), (_, _, true)]);
    }
    (0..parent.len()).filter(|&i| used[i] && !open[i]).count()
}

fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        // Halving the path keeps all later searches short.
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn tetrahedron() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_hole_or_a_flipped_face_opens_only_its_own_component() {
        let mut mesh = tetrahedron();
        assert_eq!(closed_components(&mesh), 1);
        let second = mesh.triangles.clone();
        mesh.positions.extend_from_within(..);
        mesh.triangles
            .extend(second.iter().map(|t| t.map(|corner| corner + 4)));
        assert_eq!(closed_components(&mesh), 2);
        let mut holed = mesh.clone();
        holed.triangles.pop();
        assert_eq!(closed_components(&holed), 1);
        mesh.triangles[0].reverse();
        assert_eq!(closed_components(&mesh), 1);
    }

    #[test]
    fn an_edge_of_four_faces_and_a_repeated_face_are_not_closed() {
        let mut doubled = tetrahedron();
        doubled.triangles.push([1, 2, 3]);
        assert_eq!(closed_components(&doubled), 0);
        let mut thin = tetrahedron();
        thin.triangles.push([1, 1, 3]);
        assert_eq!(closed_components(&thin), 1, "no area, no edge");
        assert_eq!(closed_components(&Mesh::default()), 0);
    }
}
