//! A ray as the pictures of a light show it: its depth, the picture that shows each part of it,
//! and its lit parts.

use glam::DVec3;

use super::EMPTY;
use crate::Ray;
use crate::scene::raster::{Face, Rays};

/// A picture of a light as a linear map to homogeneous coordinates (x, y, w). Columns
/// correspond to x/w from −1 to 1; rows, from the top, to y/w from −1 to 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    x: DVec3,
    y: DVec3,
    /// The direction into the picture for central projections; `None` for parallel ones, where
    /// w is 1.
    w: Option<DVec3>,
}

impl Projection {
    pub(crate) fn new(face: &Face) -> Self {
        let (right, up) = (face.right.as_dvec3(), face.up.as_dvec3());
        match face.rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => Self {
                x: right / f64::from(half_width),
                y: -up / f64::from(half_height),
                w: None,
            },
            Rays::Central { tan } => Self {
                x: right / f64::from(tan),
                y: -up / f64::from(tan),
                w: Some(face.forward.as_dvec3()),
            },
        }
    }

    /// The image of the light's origin plus `v`.
    pub(crate) fn of_point(&self, v: DVec3) -> DVec3 {
        let w = self.w.map_or(1.0, |w| v.dot(w));
        DVec3::new(v.dot(self.x), v.dot(self.y), w)
    }

    /// The derivative of the image along `direction`.
    pub(crate) fn of_direction(&self, direction: DVec3) -> DVec3 {
        let w = self.w.map_or(0.0, |w| direction.dot(w));
        DVec3::new(direction.dot(self.x), direction.dot(self.y), w)
    }
}

/// The depth along a ray, as the light measures it.
#[derive(Debug, Clone, Copy)]
enum Depth {
    /// Depth √(h² + s²).
    Central { h2: f64 },
    /// Depth `base + slope s`.
    Parallel { base: f64, slope: f64 },
}

/// A ray as a light sees it. Positions `s` on it are measured from the foot point of a point
/// light, and from the ray's origin in parallel light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// From the light's origin to position 0.
    base: DVec3,
    direction: DVec3,
    /// Distance of position 0 from the eye.
    offset: f64,
    depth: Depth,
}

/// What the least and the greatest depth of some texels say about a part of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Lit,
    Dark,
    Unknown,
}

/// How clearly a part must be lit or dark, relative to its depth, for the verdict to hold for
/// each of its texels: thousands of times the rounding of an f64.
const CLEAR: f64 = 1e-12;

impl Line {
    pub(crate) fn new(ray: &Ray, face: &Face) -> Self {
        let v = (ray.origin() - face.origin).as_dvec3();
        // The stored direction is of unit length to f32 precision only.
        let direction = ray.direction().as_dvec3().normalize();
        match face.rays {
            Rays::Parallel { .. } => {
                let forward = face.forward.as_dvec3();
                Self {
                    base: v,
                    direction,
                    offset: 0.0,
                    depth: Depth::Parallel {
                        base: v.dot(forward),
                        slope: direction.dot(forward),
                    },
                }
            }
            Rays::Central { .. } => {
                let foot = -v.dot(direction);
                let base = v + foot * direction;
                Self {
                    base,
                    direction,
                    offset: foot,
                    depth: Depth::Central {
                        h2: v.cross(direction).length_squared(),
                    },
                }
            }
        }
    }

    /// The position of the point at distance `x` from the eye.
    pub(crate) fn position(&self, x: f32) -> f64 {
        f64::from(x) - self.offset
    }

    /// The distance of position `s` from the eye.
    pub(crate) fn distance(&self, s: f64) -> f32 {
        (s + self.offset) as f32
    }

    /// The image of position 0, and its derivative along the ray.
    pub(crate) fn pictures(&self, projection: &Projection) -> [DVec3; 2] {
        [
            projection.of_point(self.base),
            projection.of_direction(self.direction),
        ]
    }

    /// The depth at the position 0 and its slope, in parallel light.
    pub(crate) fn parallel_depth(&self) -> Option<[f64; 2]> {
        match self.depth {
            Depth::Central { .. } => None,
            Depth::Parallel { base, slope } => Some([base, slope]),
        }
    }

    /// The part of the range from `a` to `b` that is no deeper than a texel.
    #[inline]
    pub(crate) fn up_to(&self, texel: f32, a: f64, b: f64) -> [f64; 2] {
        if texel == EMPTY {
            return [a, b];
        }
        let texel = f64::from(texel);
        match self.depth {
            Depth::Central { h2 } => {
                let square = texel * texel - h2;
                if square < 0.0 {
                    return [a, a];
                }
                let half = square.sqrt();
                [a.max(-half), b.min(half)]
            }
            Depth::Parallel { base, slope } => {
                let rest = texel - base;
                if slope > 0.0 {
                    [a, b.min(rest / slope)]
                } else if slope < 0.0 {
                    [a.max(rest / slope), b]
                } else if rest >= 0.0 {
                    [a, b]
                } else {
                    [a, a]
                }
            }
        }
    }

    /// The verdict on the range from `a` to `b`, from the least and the greatest depth of the
    /// texels that it crosses.
    #[inline]
    pub(crate) fn verdict(&self, [min, max]: [f32; 2], a: f64, b: f64) -> Verdict {
        let value = |texel: f32| match texel == EMPTY {
            true => f64::INFINITY,
            false => f64::from(texel),
        };
        let (min, max) = (value(min), value(max));
        let (is_lit, is_dark) = match self.depth {
            Depth::Central { h2 } => {
                let far = a.abs().max(b.abs());
                let near = if a <= 0.0 && 0.0 <= b {
                    0.0
                } else {
                    a.abs().min(b.abs())
                };
                let far = h2 + far * far;
                (
                    far * (1.0 + CLEAR) <= min * min,
                    h2 + near * near > max * max * (1.0 + CLEAR),
                )
            }
            Depth::Parallel { base, slope } => {
                let at = |s: f64| if slope == 0.0 { base } else { base + slope * s };
                let (near, far) = (at(a).min(at(b)), at(a).max(at(b)));
                let clear = |x: f64| CLEAR * (x.abs() + base.abs());
                (
                    far + clear(far) <= min,
                    near - clear(near) > max + CLEAR * max.abs(),
                )
            }
        };
        if is_lit {
            Verdict::Lit
        } else if is_dark {
            Verdict::Dark
        } else {
            Verdict::Unknown
        }
    }

    /// Calls `part` for each part of the range from `start` to `end` with the picture that
    /// shows it, or with `None` outside of all pictures.
    pub(crate) fn for_each_picture(
        &self,
        projections: &[Projection],
        [start, end]: [f64; 2],
        mut part: impl FnMut(Option<usize>, f64, f64),
    ) {
        let mut borders = [f64::INFINITY; 6];
        let mut count = 0;
        let mut add = |at: f64, slope: f64| {
            let s = -at / slope;
            if start < s && s < end {
                borders[count] = s;
                count += 1;
            }
        };
        let (v, d) = (self.base, self.direction);
        let [p, q] = self.pictures(&projections[0]);
        if projections.len() > 1 {
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                add(v[i] - v[j], d[i] - d[j]);
                add(v[i] + v[j], d[i] + d[j]);
            }
        } else {
            for axis in 0..2 {
                add(p.z - p[axis], q.z - q[axis]);
                add(p.z + p[axis], q.z + q[axis]);
            }
            add(p.z, q.z);
        }
        borders[..count].sort_unstable_by(f64::total_cmp);
        let mut a = start;
        for b in borders[..count].iter().copied().chain([end]) {
            if !(a < b) {
                continue;
            }
            let middle = middle([a, b]);
            let shown = if projections.len() > 1 {
                Some(cube_face(v + middle * d))
            } else {
                let at = p + middle * q;
                let inside = at.z > 0.0 && at.x.abs() <= at.z && at.y.abs() <= at.z;
                inside.then_some(0)
            };
            part(shown, a, b);
            a = b;
        }
    }
}

/// Which face of a cube, in the order +X −X +Y −Y +Z −Z, a direction points at.
pub(crate) fn cube_face(v: DVec3) -> usize {
    let a = v.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    2 * axis + usize::from(v[axis] < 0.0)
}

/// A part of a ray, from one position to another.
pub(crate) type Part = [f64; 2];

/// Joins lit parts of a ray, which come in order, into runs.
pub(crate) struct Runs<F: FnMut(Part)> {
    open: Part,
    emit: F,
}

impl<F: FnMut(Part)> Runs<F> {
    /// Calls `emit` for each finished run.
    pub(crate) fn new(emit: F) -> Self {
        let open = [f64::INFINITY, f64::NEG_INFINITY];
        Self { open, emit }
    }

    /// Adds a lit part, which may be empty.
    #[inline]
    pub(crate) fn push(&mut self, [start, end]: Part) {
        if !(start < end) {
            return;
        }
        if start <= self.open[1] {
            self.open[1] = self.open[1].max(end);
        } else {
            self.finish();
            self.open = [start, end];
        }
    }

    /// Emits the last run.
    pub(crate) fn finish(&mut self) {
        if self.open[0] < self.open[1] {
            (self.emit)(self.open);
        }
    }
}

/// A position inside a part, either end of which may be infinite.
pub(crate) fn middle([a, b]: Part) -> f64 {
    if b < f64::INFINITY {
        0.5 * (a + b)
    } else {
        a + a.abs().max(1.0)
    }
}
