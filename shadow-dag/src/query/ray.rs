//! Which parts of a ray are lit.
//!
//! A ray of the world is walked from one homogeneous volume to the next. Where
//! it crosses the plane between two voxels only depends on the plane, not on
//! how it was reached, so that large steps and small ones agree bit for bit.

use glam::{DVec3, DVec4, UVec3, Vec3};

use super::point::{bit, octant};
use crate::dag::with_nodes;
use crate::nodes::Nodes;
use crate::pool::{LIT, SHADOWED};
use crate::top::Top;
use crate::{Error, LightSpace, Resolution, ShadowDag, Slices};

/// A ray in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    origin: Vec3,
    direction: Vec3,
    length: f32,
}

impl Ray {
    /// The points `origin + s · direction` with `s` from 0 to `length`, which
    /// may be infinite. Lengths are in units of the direction.
    ///
    /// # Errors
    /// [`Error::BadValue`] if the origin or the direction is not finite, the
    /// direction zero, or the length negative or NaN.
    pub fn new(
        origin: impl Into<[f32; 3]>,
        direction: impl Into<[f32; 3]>,
        length: f32,
    ) -> Result<Self, Error> {
        let origin = Vec3::from_array(origin.into());
        let direction = Vec3::from_array(direction.into());
        let endless = |vector: Vec3| vector.to_array().into_iter().find(|x| !x.is_finite());
        if let Some(coordinate) = endless(origin) {
            let what = "a coordinate of the origin of a ray";
            return Err(Error::bad_value(what, coordinate, "a finite number"));
        }
        if let Some(coordinate) = endless(direction) {
            let what = "a coordinate of the direction of a ray";
            return Err(Error::bad_value(what, coordinate, "a finite number"));
        }
        if direction == Vec3::ZERO {
            let what = "the length of the direction of a ray";
            return Err(Error::bad_value(what, 0.0_f32, "above 0"));
        }
        if !(length >= 0.0) {
            return Err(Error::bad_value("the length of a ray", length, "0 or more"));
        }
        Ok(Self {
            origin,
            direction,
            length,
        })
    }

    /// The point at parameter `s`.
    pub fn at(&self, s: f64) -> DVec3 {
        self.origin.as_dvec3() + self.direction.as_dvec3() * s
    }

    /// Where it ends, in units of its direction.
    pub fn length(&self) -> f32 {
        self.length
    }
}

/// How a ray crosses the planes between voxels across one axis.
///
/// Plane `i` is crossed at `s = (i a − b) / (c − i d)` for texels, or at
/// `(depth(i) − a) / b` for slices. Where planes lie evenly along the ray both
/// are `(i a − b) c`, without a division.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// +1, −1, or 0 if no plane is ever crossed.
    way: i32,
    kind: Planes,
}

#[derive(Debug, Clone, Copy)]
enum Planes {
    Even { a: f64, b: f64, c: f64 },
    Texels { a: f64, b: f64, c: f64, d: f64 },
    Slices { from: f64, slope: f64 },
}

/// A ray in a grid.
#[derive(Debug, Clone, Copy)]
struct Path {
    slices: Slices,
    side: u32,
    axes: [Axis; 3],
    /// Cells across axes along which the ray does not move.
    still: [u32; 3],
    from: DVec4,
    along: DVec4,
}

impl Path {
    fn new(space: &LightSpace, resolution: Resolution, ray: &Ray) -> Self {
        let from = space.homogeneous(ray.origin.as_dvec3().extend(1.0));
        let along = space.homogeneous(ray.direction.as_dvec3().extend(0.0));
        let side = f64::from(resolution.side());
        let way = |slope: f64| {
            if slope > 0.0 {
                1
            } else if slope < 0.0 {
                -1
            } else {
                0
            }
        };
        let texels = |i: usize| {
            let [a, b, c, d] = [from.w, side * from[i], side * along[i], along.w];
            Axis {
                way: way(along[i] * from.w - from[i] * along.w),
                kind: if d == 0.0 {
                    Planes::Even { a, b, c: 1.0 / c }
                } else {
                    Planes::Texels { a, b, c, d }
                },
            }
        };
        let (near, slope) = (from.z, along.z);
        let slices = match space.slices() {
            Slices::Linear => Planes::Even {
                a: 1.0 / side,
                b: near,
                c: 1.0 / slope,
            },
            Slices::Logarithmic(_) => Planes::Slices { from: near, slope },
        };
        let mut path = Self {
            slices: *space.slices(),
            side: resolution.side(),
            still: [0; 3],
            axes: [
                texels(0),
                texels(1),
                Axis {
                    way: way(along.z),
                    kind: slices,
                },
            ],
            from,
            along,
        };
        // On a line through the light both ends say where, if they are in
        // front of it.
        let h = if from.w > 0.0 { from } else { along };
        path.still = [0, 1, 2].map(|axis| match axis {
            2 => path.estimate(2, from),
            axis => path.estimate(axis, h),
        });
        path
    }

    /// Where plane `plane` across an axis is crossed; grows along the way of
    /// the ray. Infinite for the plane behind the last slice, which ends
    /// nothing, and where nothing is crossed.
    fn crossing(&self, axis: usize, plane: u32) -> f64 {
        let Axis { way, kind } = self.axes[axis];
        if way == 0 || (axis == 2 && plane == self.side && way > 0) {
            return f64::INFINITY;
        }
        let i = f64::from(plane);
        let s = match kind {
            Planes::Even { a, b, c } => (i * a - b) * c,
            Planes::Texels { a, b, c, d } => {
                // The denominator has the other sign for planes beyond the ray's vanishing
                // point. A ray that goes away from the light never meets those; one that comes
                // towards it has met them before all others.
                let denominator = c - i * d;
                if denominator * f64::from(way) <= 0.0 {
                    return if d < 0.0 {
                        f64::NEG_INFINITY
                    } else {
                        f64::INFINITY
                    };
                }
                (i * a - b) / denominator
            }
            Planes::Slices { from, slope } => {
                (self.slices.depth(i / f64::from(self.side)) - from) / slope
            }
        };
        if s.is_nan() { f64::INFINITY } else { s }
    }

    /// The cell of an axis at `s`: all planes up to `s` have been crossed.
    fn cell(&self, axis: usize, s: f64) -> u32 {
        let way = self.axes[axis].way;
        let last = self.side - 1;
        if way == 0 {
            return self.still[axis];
        }
        // Whether cell `i`, counted along the way, has been left at `s`.
        let plane = |i: u32| if way > 0 { i + 1 } else { last - i };
        let left = |i: u32| self.crossing(axis, plane(i)) <= s;
        let near = self.estimate(axis, self.from + self.along * s);
        let near = if way > 0 { near } else { last - near };
        let guess = [near, near.saturating_sub(1), (near + 1).min(last)];
        let found = guess
            .into_iter()
            .find(|&i| (i == 0 || left(i - 1)) && (i == last || !left(i)));
        // For rays that nearly lie in a plane, rounding can put the estimate farther off
        // than that.
        let i = found.unwrap_or_else(|| {
            let (mut low, mut high) = (0, last);
            while low < high {
                let middle = low + (high - low) / 2;
                if left(middle) {
                    low = middle + 1;
                } else {
                    high = middle;
                }
            }
            low
        });
        if way > 0 { i } else { last - i }
    }

    /// The cell behind a plane that has been crossed at `s`, if it is the one
    /// at `s`: the plane behind it has not been crossed.
    fn behind(&self, axis: usize, plane: u32, s: f64) -> Option<u32> {
        let (cell, next) = if self.axes[axis].way > 0 {
            (plane, plane + 1)
        } else {
            (plane.checked_sub(1)?, plane - 1)
        };
        (cell < self.side && self.crossing(axis, next) > s).then_some(cell)
    }

    /// The cell by where a point is, good to a rounding error.
    fn estimate(&self, axis: usize, h: DVec4) -> u32 {
        let position = match axis {
            2 => self.slices.position(h.z),
            axis => h[axis] / h.w,
        };
        // Saturates, and takes NaN to 0.
        ((position * f64::from(self.side)) as u32).min(self.side - 1)
    }

    /// The part of the ray up to `length` that is above the map and behind
    /// its front, as a range of `s`; it may be empty.
    fn clip(&self, length: f64) -> (f64, f64) {
        let (mut start, mut end) = (0.0_f64, length);
        // Each of these bounds is linear along the ray and not negative inside.
        let near = self.slices.depth(0.0);
        let bounds = |h: DVec4, near: f64| [h.x, h.w - h.x, h.y, h.w - h.y, h.z - near];
        let from = bounds(self.from, near);
        let along = bounds(self.along, 0.0);
        for (from, along) in from.into_iter().zip(along) {
            let zero = -from / along;
            if along > 0.0 {
                start = start.max(zero);
            } else if along < 0.0 {
                end = end.min(zero);
            } else if !(from >= 0.0) {
                end = -1.0;
            }
        }
        (start, end)
    }
}

/// A homogeneous volume of the grid.
#[derive(Debug, Clone, Copy)]
struct Volume {
    lit: bool,
    /// Logarithm of its width.
    shift: u32,
}

/// The largest stored volume around a voxel that is homogeneous.
fn volume<N: Nodes>(nodes: &N, top: &Top, voxel: UVec3) -> Volume {
    let UVec3 { x, y, z } = voxel;
    let mut reference = top.find(x, y, z);
    let mut level = top.level;
    loop {
        let shift = level as u32 + 3;
        match reference {
            LIT => return Volume { lit: true, shift },
            SHADOWED => return Volume { lit: false, shift },
            _ => {}
        }
        let node = nodes.node(level, reference);
        if level == 0 {
            let lit = match nodes.child(node, z & 7) {
                LIT => true,
                SHADOWED => false,
                slice => nodes.mask(slice) >> bit(x, y) & 1 == 1,
            };
            return Volume { lit, shift: 0 };
        }
        reference = nodes.child(node, octant(level, x, y, z));
        level -= 1;
    }
}

/// Joins what touches.
#[derive(Debug, Default)]
struct Joined {
    intervals: Vec<[f64; 2]>,
}

impl Joined {
    fn push(&mut self, start: f64, end: f64) {
        if !(start < end) {
            return;
        }
        match self.intervals.last_mut() {
            Some(last) if last[1] == start => last[1] = end,
            _ => self.intervals.push([start, end]),
        }
    }
}

/// `find` gives the volume around a voxel: of any size, as long as it is
/// aligned and homogeneous.
fn walk(find: impl Fn(UVec3) -> Volume, path: &Path, length: f64) -> Joined {
    let mut lit = Joined::default();
    let (start, end) = path.clip(length);
    if !(start < end) {
        lit.push(0.0, length);
        return lit;
    }
    lit.push(0.0, start);
    let mut s = start;
    let mut voxel = [0, 1, 2].map(|axis| path.cell(axis, s));
    while s < end {
        let volume = find(UVec3::from_array(voxel));
        // The side of the volume at which it is left, along each axis.
        let planes = [0, 1, 2].map(|axis| {
            let cell = voxel[axis] >> volume.shift;
            (cell + u32::from(path.axes[axis].way > 0)) << volume.shift
        });
        let crossings = [0, 1, 2].map(|axis| path.crossing(axis, planes[axis]));
        // A plane that is crossed already is the rim of the map, or was met while clipping.
        let exit = (crossings.iter().filter(|crossing| **crossing > s))
            .fold(end, |exit, &crossing| exit.min(crossing));
        if volume.lit {
            lit.push(s, exit);
        }
        s = exit;
        for axis in 0..3 {
            let known = if crossings[axis] > s {
                // The next plane of a single voxel is already known.
                (volume.shift == 0).then_some(voxel[axis])
            } else {
                path.behind(axis, planes[axis], s)
            };
            voxel[axis] = known.unwrap_or_else(|| path.cell(axis, s));
        }
    }
    lit.push(end, length);
    lit
}

/// The lit parts of a ray, in order, as ranges of its parameter `s`. No two of
/// them touch.
pub type LitIntervals = Vec<[f64; 2]>;

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// The parts of a ray of the world that are lit; those beside the map or
    /// in front of it are, those behind the last slice are as in the last.
    ///
    /// Takes a step for each homogeneous volume on the way. For shadows
    /// without a [`ShadowDag::light`] rays are in voxels.
    pub fn lit_intervals(&self, ray: &Ray) -> LitIntervals {
        let path = self.path(ray);
        let length = f64::from(ray.length);
        with_nodes!(self, nodes => {
            walk(|voxel| volume(nodes, &self.top, voxel), &path, length)
        })
        .intervals
    }

    /// The length of the lit parts of a ray together, in units of its
    /// direction.
    pub fn lit_length(&self, ray: &Ray) -> f64 {
        let lengths = self.lit_intervals(ray);
        lengths.iter().map(|[start, end]| end - start).sum()
    }

    fn path(&self, ray: &Ray) -> Path {
        let voxels = LightSpace::of_voxels(self.resolution());
        let space = self.light().unwrap_or(&voxels);
        Path::new(space, self.resolution(), ray)
    }
}

/// [`ShadowDag::lit_intervals`] by a step per voxel.
#[cfg(test)]
pub(crate) fn stepping(dag: &ShadowDag, ray: &Ray) -> LitIntervals {
    let single = |voxel: UVec3| Volume {
        lit: dag.is_lit(voxel.as_ivec3()),
        shift: 0,
    };
    walk(single, &dag.path(ray), f64::from(ray.length)).intervals
}
