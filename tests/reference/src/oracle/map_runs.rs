//! Which parts of a ray a shadow map says are lit.

use glam::DVec3;
use scene::raster::{Face, Rays};
use scene::{Interval, Ray};

/// A shadow map as plain numbers.
#[derive(Debug, Clone, Copy)]
pub struct Map<'a> {
    /// The pictures of the light: one, or six of a cube.
    pub faces: &'a [Face],
    /// Texels per side of each.
    pub resolution: u32,
    /// Their depths, each picture row by row from the top; `f32::MAX` is none.
    pub depth: &'a [f32],
}

impl Map<'_> {
    /// The lit parts of the span of a ray, in order: the ray is cut wherever it
    /// crosses a border of a row or a column of any picture, and each piece is asked for
    /// the texel in its middle.
    pub fn runs(&self, ray: &Ray, span: Interval) -> Vec<[f64; 2]> {
        let origin = (ray.origin() - self.faces[0].origin).as_dvec3();
        let direction = ray.direction().as_dvec3().normalize();
        let [start, end] = [f64::from(span.start), f64::from(span.end)];
        let mut cuts = vec![start, end];
        for face in self.faces {
            let [right, up, forward] =
                [face.right, face.up, face.forward].map(|axis| axis.as_dvec3());
            let mut cut = |plane: DVec3, height: f64| {
                let t = (height - origin.dot(plane)) / direction.dot(plane);
                if start < t && t < end {
                    cuts.push(t);
                }
            };
            for border in 0..=self.resolution {
                let x = 2.0 * f64::from(border) / f64::from(self.resolution) - 1.0;
                match face.rays {
                    Rays::Parallel {
                        half_width,
                        half_height,
                    } => {
                        cut(right, x * f64::from(half_width));
                        cut(up, x * f64::from(half_height));
                    }
                    Rays::Central { tan } => {
                        cut(right - x * f64::from(tan) * forward, 0.0);
                        cut(up - x * f64::from(tan) * forward, 0.0);
                    }
                }
            }
            if let Rays::Central { .. } = face.rays {
                cut(forward, 0.0);
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let mut runs: Vec<[f64; 2]> = Vec::new();
        for piece in cuts.windows(2) {
            let [a, b] = [piece[0], piece[1]];
            let middle = if b.is_finite() {
                0.5 * (a + b)
            } else {
                a + 1.0
            };
            let depth = self.texel(origin + middle * direction);
            let [from, to] = self.no_deeper(depth, origin, direction);
            let (from, to) = (a.max(from), b.min(to));
            if from < to {
                match runs.last_mut() {
                    Some(last) if last[1] == from => last[1] = to,
                    _ => runs.push([from, to]),
                }
            }
        }
        runs
    }

    /// The depth of the texel that shows the light's origin plus `v`.
    fn texel(&self, v: DVec3) -> f32 {
        let Some((face, place)) = self.place(v) else {
            return f32::MAX;
        };
        let side = self.resolution as usize;
        let [column, row] = place.map(|x| ((x * side as f64) as usize).min(side - 1));
        self.depth[(face * side + row) * side + column]
    }

    /// The picture that shows the light's origin plus `v`, and where in it: from 0 to 1.
    fn place(&self, v: DVec3) -> Option<(usize, [f64; 2])> {
        let shows = |face: &Face| {
            let (x, y) = (v.dot(face.right.as_dvec3()), v.dot(face.up.as_dvec3()));
            let z = v.dot(face.forward.as_dvec3());
            let (x, y) = match face.rays {
                Rays::Parallel {
                    half_width,
                    half_height,
                } => (x / f64::from(half_width), y / f64::from(half_height)),
                Rays::Central { tan } if z > 0.0 => {
                    (x / (z * f64::from(tan)), y / (z * f64::from(tan)))
                }
                Rays::Central { .. } => return None,
            };
            let inside = x.abs() <= 1.0 && y.abs() <= 1.0;
            inside.then_some([0.5 * (1.0 + x), 0.5 * (1.0 - y)])
        };
        (0..)
            .zip(self.faces)
            .find_map(|(i, face)| Some((i, shows(face)?)))
    }

    /// Whether the point at `x` on a ray may be lit, and whether it may be dark, if it is moved to the centre
    /// of a texel that is at most `aside` texels away in the picture, along rows and columns,
    /// without getting nearer to the light or farther from it along the axis of the picture, and
    /// then by up to `along` widths of a texel along that axis.
    pub fn near(&self, ray: &Ray, x: f64, aside: f64, along: f64) -> [bool; 2] {
        let origin = (ray.origin() - self.faces[0].origin).as_dvec3();
        let v = origin + x * ray.direction().as_dvec3().normalize();
        let Some((index, place)) = self.place(v) else {
            return [true, false];
        };
        let face = &self.faces[index];
        let side = self.resolution as usize;
        let z = v.dot(face.forward.as_dvec3());
        let texels = |x: f64| {
            let x = x * side as f64 - 0.5;
            let first = (x - aside).ceil().max(0.0) as usize;
            first..=((x + aside).floor() as usize).min(side - 1)
        };
        let mut near = [false; 2];
        for row in texels(place[1]) {
            for column in texels(place[0]) {
                let centre = [column, row].map(|i| (2 * i + 1) as f64 / side as f64 - 1.0);
                // The width of a texel, and the depth for each unit of z.
                let (width, scale) = match face.rays {
                    Rays::Parallel {
                        half_width,
                        half_height,
                    } => (2.0 * f64::from(half_width.min(half_height)), 1.0),
                    Rays::Central { tan } => {
                        let tan = f64::from(tan);
                        let aside = (centre[0] * tan).powi(2) + (centre[1] * tan).powi(2);
                        (2.0 * tan * z, (1.0 + aside).sqrt())
                    }
                };
                let off = along * width / side as f64;
                let depth = self.depth[(index * side + row) * side + column];
                near[0] |= depth == f32::MAX || (z - off) * scale <= f64::from(depth);
                near[1] |= depth < f32::MAX && (z + off) * scale > f64::from(depth);
            }
        }
        near
    }

    /// Where the line of a ray is no deeper than a texel.
    fn no_deeper(&self, texel: f32, origin: DVec3, direction: DVec3) -> [f64; 2] {
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        if texel == f32::MAX {
            return all;
        }
        let texel = f64::from(texel);
        let forward = self.faces[0].forward.as_dvec3();
        match self.faces[0].rays {
            Rays::Parallel { .. } => {
                let t = (texel - origin.dot(forward)) / direction.dot(forward);
                match direction.dot(forward) {
                    slope if slope > 0.0 => [f64::NEG_INFINITY, t],
                    slope if slope < 0.0 => [t, f64::INFINITY],
                    _ if origin.dot(forward) <= texel => all,
                    _ => none,
                }
            }
            Rays::Central { .. } => {
                let along = -origin.dot(direction);
                let aside = (origin + along * direction).length();
                if aside > texel {
                    return none;
                }
                let half = ((texel - aside) * (texel + aside)).sqrt();
                [along - half, along + half]
            }
        }
    }
}
