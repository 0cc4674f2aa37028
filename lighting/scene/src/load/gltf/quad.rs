//! Pairs of triangles that form a rectangle.

use glam::{Vec2, Vec3};

/// By how much, in relation to its sides, a rectangle may be off: ten times
/// what rounding does to a rectangle of 1 m at 1 km from the origin.
const TOLERANCE: f32 = 1e-3;

/// A rectangle whose front is the side of `edges[0] × edges[1]`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rectangle {
    pub(super) corner: Vec3,
    pub(super) edges: [Vec3; 2],
    pub(super) mapping: Mapping,
}

/// How texture coordinates lie on a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mapping {
    /// From (0, 0) at the corner to (1, 1) along the edges.
    Upright,
    /// From (0, 1) at the corner to (1, 0) along the edges.
    UpsideDown,
    /// In any other way, or there are none.
    Other,
}

impl Rectangle {
    /// The rectangle that two triangles form, seen counter-clockwise from its
    /// front. `None` if they form another shape.
    pub(super) fn new(
        triangles: [[Vec3; 3]; 2],
        coordinates: Option<[[Vec2; 3]; 2]>,
    ) -> Option<Self> {
        let [first, second] = triangles;
        // The corners that the triangles do not share.
        let i = alone(first, second)?;
        let j = alone(second, first)?;
        let turn = |i: usize| [i, (i + 1) % 3, (i + 2) % 3];
        let ([p, s, t], [q, t2, s2]) = (turn(i).map(|i| first[i]), turn(j).map(|j| second[j]));
        if s != s2 || t != t2 {
            // The triangles face different sides.
            return None;
        }
        let (a, b) = (s - p, t - p);
        let size = a.length().min(b.length());
        let is_rectangle = size > 0.0
            && a.dot(b).abs() <= TOLERANCE * a.length() * b.length()
            && (q - p - a - b).length() <= TOLERANCE * size;
        if !is_rectangle {
            return None;
        }
        let corners = [p, s, q, t];
        let mapping = coordinates.and_then(|[first, second]| {
            let ([p, s, t], [q, t2, s2]) = (turn(i).map(|i| first[i]), turn(j).map(|j| second[j]));
            (near(s, s2) && near(t, t2)).then_some([p, s, q, t])
        });
        Some(
            mapping
                .and_then(|uv| Self::mapped(corners, uv))
                .unwrap_or(Self {
                    corner: p,
                    edges: [a, b],
                    mapping: Mapping::Other,
                }),
        )
    }

    /// The back of the rectangle, with the texture where it was.
    pub(super) fn turned(&self) -> Self {
        let [u, v] = self.edges;
        let (corner, edges) = match self.mapping {
            // Mirrored, the rows run the other way.
            Mapping::Upright | Mapping::UpsideDown => (self.corner + v, [u, -v]),
            Mapping::Other => (self.corner, [v, u]),
        };
        Self {
            corner,
            edges,
            mapping: match self.mapping {
                Mapping::Upright => Mapping::UpsideDown,
                Mapping::UpsideDown => Mapping::Upright,
                Mapping::Other => Mapping::Other,
            },
        }
    }

    /// Starts at the corner that makes the edges run along u and v, with the
    /// front where it was. Corners are counter-clockwise from the front.
    fn mapped(corners: [Vec3; 4], uv: [Vec2; 4]) -> Option<Self> {
        let has = |start: usize, expected: [Vec2; 4]| {
            (0..4).all(|i| near(uv[(start + i) % 4], expected[i]))
        };
        let (zero, u, v, both) = (Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE);
        (0..4).find_map(|start| {
            let mapping = if has(start, [zero, u, both, v]) {
                Mapping::Upright
            } else if has(start, [v, both, u, zero]) {
                Mapping::UpsideDown
            } else {
                return None;
            };
            let corner = corners[start];
            let edges = [1, 3].map(|i| corners[(start + i) % 4] - corner);
            Some(Self {
                corner,
                edges,
                mapping,
            })
        })
    }
}

/// The only corner of one triangle that the other does not have.
fn alone(triangle: [Vec3; 3], other: [Vec3; 3]) -> Option<usize> {
    let mut alone = (0..3).filter(|&i| !other.contains(&triangle[i]));
    alone.next().filter(|_| alone.next().is_none())
}

fn near(a: Vec2, b: Vec2) -> bool {
    (a - b).abs().max_element() <= TOLERANCE
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn square(turn: Quat) -> [Vec3; 4] {
        [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| turn * Vec3::new(x, y, 0.0) + Vec3::new(5.0, -3.0, 2.0))
    }

    #[test]
    fn every_way_to_split_a_rectangle_keeps_its_front() {
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(2.1);
        let [a, b, c, d] = square(turn);
        for first in [[a, b, c], [b, c, a], [c, a, b]] {
            for second in [[a, c, d], [c, d, a], [d, a, c]] {
                for pair in [[first, second], [second, first]] {
                    let rectangle = Rectangle::new(pair, None).unwrap();
                    let [u, v] = rectangle.edges;
                    assert!((u.cross(v) - turn * Vec3::Z * 2.0).length() < 1e-5);
                    let middle = rectangle.corner + 0.5 * (u + v);
                    assert!((middle - 0.5 * (a + c)).length() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn a_texture_keeps_its_place_on_the_rectangle() {
        let corners = square(Quat::IDENTITY);
        let unit = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        for turned in 0..4 {
            for mirrored in [false, true] {
                let uv: [Vec2; 4] = std::array::from_fn(|i| {
                    unit[if mirrored { 7 - i + turned } else { i + turned } % 4]
                });
                let pick = |[a, b, c, d]: [Vec2; 4]| [[a, b, c], [a, c, d]];
                let [a, b, c, d] = corners;
                let rectangle = Rectangle::new([[a, b, c], [a, c, d]], Some(pick(uv))).unwrap();
                let [u, v] = rectangle.edges;
                assert!(u.cross(v).z > 0.0);
                for (corner, uv) in corners.into_iter().zip(uv) {
                    let along = match rectangle.mapping {
                        Mapping::Upright => uv,
                        Mapping::UpsideDown => Vec2::new(uv.x, 1.0 - uv.y),
                        Mapping::Other => panic!("{uv}"),
                    };
                    let place = rectangle.corner + along.x * u + along.y * v;
                    assert!((place - corner).length() < 1e-5, "{rectangle:?}");
                }
            }
        }
        let [a, b, c, d] = corners;
        for uv in [
            [[Vec2::ZERO; 3]; 2],
            [
                [Vec2::ZERO, Vec2::X, Vec2::ONE],
                [Vec2::ZERO, Vec2::Y, Vec2::ONE],
            ],
            [[Vec2::NAN; 3]; 2],
        ] {
            let rectangle = Rectangle::new([[a, b, c], [a, c, d]], Some(uv)).unwrap();
            assert_eq!(rectangle.mapping, Mapping::Other);
        }
    }

    #[test]
    fn the_back_has_every_texel_where_the_front_has_it() {
        for mapping in [Mapping::Upright, Mapping::UpsideDown, Mapping::Other] {
            let front = Rectangle {
                corner: Vec3::new(1.0, 2.0, 3.0),
                edges: [Vec3::X * 2.0, Vec3::Y],
                mapping,
            };
            let back = front.turned();
            let normal = |r: &Rectangle| r.edges[0].cross(r.edges[1]);
            assert_eq!(normal(&back), -normal(&front));
            // Where the texture's (0.3, 0.2) is, upright or not.
            let place = |r: &Rectangle| {
                let v = if r.mapping == Mapping::UpsideDown {
                    0.8
                } else {
                    0.2
                };
                r.corner + 0.3 * r.edges[0] + v * r.edges[1]
            };
            if mapping != Mapping::Other {
                assert!(
                    (place(&back) - place(&front)).length() < 1e-6,
                    "{mapping:?}"
                );
            }
            assert_eq!(back.turned(), front);
        }
    }

    #[test]
    fn other_shapes_are_no_rectangles() {
        let [a, b, c, d] = square(Quat::IDENTITY);
        let lifted = d + Vec3::Z * 0.1;
        let slanted = Vec3::X * 0.1;
        for triangles in [
            [[a, b, c], [a, d, c]],
            [[a, b, c], [a, c, lifted]],
            [[a, b, c + slanted], [a, c + slanted, d + slanted]],
            [[a, b, c], [a, c, c + c - b]],
            [[a, b, c], [a, b, c]],
            [[a, a, c], [a, c, d]],
            [[a, b, d], [c, b, c]],
            [[a, b, c], [b, Vec3::NAN, c]],
            [[a, b, Vec3::INFINITY], [a, Vec3::INFINITY, d]],
        ] {
            assert_eq!(Rectangle::new(triangles, None), None, "{triangles:?}");
        }
    }
}
