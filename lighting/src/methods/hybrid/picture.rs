//! A picture of a light as a linear map, and bounds of what a triangle is there.

use glam::{DVec2, DVec3};

use crate::scene::raster::{Face, Rays};

/// Texels around a cell from which a triangle counts as one of its own.
const MARGIN: f64 = 1.0;

/// The largest rounding error of a direction, as an angle: tens of 2⁻²⁴. Narrow pictures have
/// texels that are smaller.
const ANGLE: f64 = 1e-5;

/// A picture of a light as a linear map to homogeneous texels: the light's origin plus
/// `v` is at the column `x/w` and the row `y/w`, from 0 to the resolution.
#[derive(Debug, Clone, Copy)]
pub(super) struct Picture {
    x: DVec3,
    y: DVec3,
    w: DVec3,
    /// The constant part of the map for points in parallel light.
    point: DVec3,
    /// Into the picture.
    forward: DVec3,
    /// Tangent of half the opening angle; `None` in parallel light.
    tan: Option<f64>,
    /// Texels per side.
    resolution: f64,
    margin: f64,
}

/// A rectangle of texels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Square {
    pub(super) low: DVec2,
    pub(super) high: DVec2,
}

impl Square {
    /// A cell of so many texels a side.
    pub(super) fn new([column, row]: [usize; 2], cell: f64) -> Self {
        let low = cell * DVec2::new(column as f64, row as f64);
        Self {
            low,
            high: low + cell,
        }
    }

    pub(super) fn wider(self, margin: f64) -> Self {
        Self {
            low: self.low - margin,
            high: self.high + margin,
        }
    }
}

/// `a x + b y + c` over texels.
#[derive(Debug, Clone, Copy, Default)]
struct Linear {
    a: f64,
    b: f64,
    c: f64,
    /// The largest error of the value.
    error: f64,
}

impl Linear {
    fn new(v: DVec3, resolution: f64) -> Self {
        Self {
            a: v.x,
            b: v.y,
            c: v.z,
            error: 1e-11 * ((v.x.abs() + v.y.abs()) * resolution + v.z.abs()),
        }
    }

    /// The greatest value in a rectangle, or more.
    fn greatest(&self, square: Square) -> f64 {
        let x = if self.a > 0.0 {
            square.high.x
        } else {
            square.low.x
        };
        let y = if self.b > 0.0 {
            square.high.y
        } else {
            square.low.y
        };
        self.a * x + (self.b * y + self.c) + self.error
    }
}

/// A triangle over the texels of a picture.
pub(super) struct Plane {
    /// Positive inside.
    edges: [Linear; 3],
    /// Minus the depth in parallel light, else the reciprocal of w.
    depth: Linear,
    /// The least depth of a corner, or w.
    least: f64,
}

impl Picture {
    pub(super) fn new(face: &Face, resolution: u32) -> Self {
        let [right, up, forward] = [face.right, face.up, face.forward].map(|v| v.as_dvec3());
        let n = f64::from(resolution);
        let half = 0.5 * n;
        match face.rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => Self {
                x: right * (half / f64::from(half_width)),
                y: -up * (half / f64::from(half_height)),
                w: DVec3::ZERO,
                point: DVec3::new(half, half, 1.0),
                forward,
                tan: None,
                resolution: n,
                margin: MARGIN,
            },
            Rays::Central { tan } => {
                let tan = f64::from(tan);
                Self {
                    x: half * (forward + right / tan),
                    y: half * (forward - up / tan),
                    w: forward,
                    point: DVec3::ZERO,
                    forward,
                    tan: Some(tan),
                    resolution: n,
                    margin: MARGIN + ANGLE * half / tan,
                }
            }
        }
    }

    /// Homogeneous texels of the light's origin plus `v`.
    #[inline]
    pub(super) fn of_point(&self, v: DVec3) -> DVec3 {
        self.point + self.of_direction(v)
    }

    /// Their change along `v`.
    #[inline]
    pub(super) fn of_direction(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.w))
    }

    pub(super) fn forward(&self) -> DVec3 {
        self.forward
    }

    pub(super) fn is_central(&self) -> bool {
        self.tan.is_some()
    }

    /// Texels around a cell from which a triangle counts as one of its own.
    pub(super) fn margin(&self) -> f64 {
        self.margin
    }

    /// The texels that a triangle may cover; `None` if it is behind the light.
    pub(super) fn bounds(&self, corners: &[DVec3; 3]) -> Option<Square> {
        let mut all = Square {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        };
        let corners = corners.map(|corner| self.of_point(corner));
        let scale = corners.iter().map(|p| p.z.abs()).fold(0.0, f64::max);
        let near = 1e-9 * scale;
        for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            let mut add = |p: DVec3| {
                let at = p.truncate() / p.z;
                (all.low, all.high) = (all.low.min(at), all.high.max(at));
            };
            if p.z >= near && p.z > 0.0 {
                add(p);
            }
            if (p.z >= near) != (q.z >= near) {
                let cut = p + (q - p) * ((near - p.z) / (q.z - p.z));
                add(cut.truncate().extend(near));
            }
        }
        (all.low.x <= all.high.x).then_some(all)
    }

    /// The distance of a point with so much depth, or w, within a rectangle, at least.
    fn least_distance(&self, depth: f64, Square { low, high }: Square) -> f32 {
        let Some(tan) = self.tan else {
            return depth as f32;
        };
        // Of the tangents between the two the one closest to 0.
        let tangent = |texel: DVec2| tan * (2.0 * texel / self.resolution - 1.0);
        let closest = tangent(low).max(DVec2::ZERO) + tangent(high).min(DVec2::ZERO);
        (depth.max(0.0) * (1.0 + closest.length_squared()).sqrt()) as f32
    }

    /// The distance from the light, or along it, of a triangle that covers no more than
    /// `all`, at least.
    pub(super) fn least_depth(&self, corners: &[DVec3; 3], all: Square) -> f32 {
        let depths = corners.map(|corner| corner.dot(self.forward));
        self.least_distance(depths.into_iter().fold(f64::INFINITY, f64::min), all)
    }

    /// `None` if it is seen edge-on: then it hides nothing.
    pub(super) fn plane(&self, corners: &[DVec3; 3]) -> Option<Plane> {
        let [a, b, c] = corners.map(|corner| self.of_point(corner));
        let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
        let determinant = a.dot(bc);
        if determinant == 0.0 {
            return None;
        }
        let linear = |v: DVec3| Linear::new(v, self.resolution);
        let depths = corners.map(|corner| corner.dot(self.forward));
        // At (x, y, 1) the corners have these weights over the determinant: their sum is
        // 1/w, or 1 in parallel light.
        let depth = match self.tan {
            Some(_) => bc + ca + ab,
            None => -(depths[0] * bc + depths[1] * ca + depths[2] * ab),
        };
        let magnitude = match self.tan {
            Some(_) => bc.abs() + ca.abs() + ab.abs(),
            None => {
                depths[0].abs() * bc.abs() + depths[1].abs() * ca.abs() + depths[2].abs() * ab.abs()
            }
        };
        let depth = Linear {
            error: linear(magnitude / determinant).error,
            ..linear(depth / determinant)
        };
        Some(Plane {
            edges: [bc, ca, ab].map(|edge| linear(edge * determinant.signum())),
            depth,
            least: depths.into_iter().fold(f64::INFINITY, f64::min),
        })
    }
}

impl Plane {
    /// The least depth of what of the triangle may be in a rectangle.
    pub(super) fn least_depth(&self, picture: &Picture, square: Square) -> Option<f32> {
        if self.edges.iter().any(|edge| edge.greatest(square) < 0.0) {
            return None;
        }
        let greatest = self.depth.greatest(square);
        let depth = match picture.tan {
            Some(_) if greatest <= 0.0 => return None,
            Some(_) => 1.0 / greatest,
            None => -greatest,
        };
        Some(picture.least_distance(depth.max(self.least), square))
    }
}
