//! The lit share of a window of texels: percentage-closer filtering.

use glam::{DVec3, IVec3, Vec3};

use super::extent::window;
use crate::dag::with_nodes;
use crate::nodes::Nodes;
use crate::pool::{LIT, Reference, SHADOWED};
use crate::top::Top;
use crate::{Error, ShadowDag};

/// The width of a filter in texels: odd, 1 to 65535.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FilterSize(u16);

impl FilterSize {
    /// A filter of `width × width` texels.
    ///
    /// # Errors
    /// [`Error::BadValue`] if the width is even or above 65535.
    pub fn new(width: u32) -> Result<Self, Error> {
        match u16::try_from(width) {
            Ok(narrow) if width % 2 == 1 => Ok(Self(narrow)),
            _ => Err(Error::bad_value(
                "the width of a filter",
                width,
                "an odd number from 1 to 65535",
            )),
        }
    }

    /// Texels along each side.
    pub fn width(self) -> u32 {
        u32::from(self.0)
    }

    /// Texels of the window.
    fn area(self) -> u32 {
        self.width() * self.width()
    }

    /// The share of the window that so many texels are.
    #[inline]
    pub(super) fn share(self, texels: u32) -> f32 {
        texels as f32 / self.area() as f32
    }

    /// Texels on either side of the middle.
    fn half(self) -> i32 {
        i32::from(self.0 / 2)
    }
}

/// Texels of one slice, ends included.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) x: [u32; 2],
    pub(super) y: [u32; 2],
}

impl Window {
    /// The part of a window, in any whole numbers, that is on a map of `side`
    /// texels.
    #[inline(always)]
    fn clip(x: [i64; 2], y: [i64; 2], side: u32) -> Option<Self> {
        Some(Self {
            x: clip(x, side)?,
            y: clip(y, side)?,
        })
    }

    /// Texels of a window no larger than a filter, whose number fits.
    #[inline(always)]
    fn area(self) -> u32 {
        (self.x[1] - self.x[0] + 1) * (self.y[1] - self.y[0] + 1)
    }

    /// The part that is in the square of `1 << shift` texels at cell `(x, y)`.
    #[inline(always)]
    pub(super) fn cut(self, x: u32, y: u32, shift: u32) -> Self {
        let cut = |[first, last]: [u32; 2], cell: u32| {
            let origin = cell << shift;
            [first.max(origin), last.min(origin + ((1 << shift) - 1))]
        };
        Self {
            x: cut(self.x, x),
            y: cut(self.y, y),
        }
    }

    /// The bits of the mask of the tile in which all of the window is.
    #[inline(always)]
    fn bits(self) -> u64 {
        window(self.x[0] & 7, self.x[1] & 7, self.y[0] & 7, self.y[1] & 7)
    }
}

/// The part of a range that is on a map of `side` texels.
#[inline(always)]
fn clip([first, last]: [i64; 2], side: u32) -> Option<[u32; 2]> {
    let (first, last) = (first.max(0), last.min(i64::from(side) - 1));
    (first <= last).then_some([first as u32, last as u32])
}

/// Counts the lit texels of a window in one slice.
pub(super) trait Count {
    /// All of a part is lit.
    fn lit(&mut self, part: Window);

    /// A part within one tile is lit where `mask` is.
    fn masked(&mut self, part: Window, mask: u64);
}

/// How many there are.
impl Count for u32 {
    #[inline(always)]
    fn lit(&mut self, part: Window) {
        *self += part.area();
    }

    #[inline(always)]
    fn masked(&mut self, part: Window, mask: u64) {
        *self += (mask & part.bits()).count_ones();
    }
}

/// How many there are in each of four windows, next to each other along both axes.
pub(super) struct Four {
    /// The ends of those at the left and at the right; none beside the map.
    x: [Option<[u32; 2]>; 2],
    /// The ends of the upper and of the lower ones.
    y: [Option<[u32; 2]>; 2],
    /// Window `2 y + x`.
    lit: [u32; 4],
}

impl Four {
    /// What `count` says of the ends of each window along an axis that are in a part; 0 if there
    /// are none.
    #[inline(always)]
    fn meet<T: Default>(
        ends: [Option<[u32; 2]>; 2],
        part: [u32; 2],
        count: impl Fn([u32; 2]) -> T,
    ) -> [T; 2] {
        ends.map(|ends| match ends {
            Some([first, last]) if first <= part[1] && part[0] <= last => {
                count([first.max(part[0]), last.min(part[1])])
            }
            _ => T::default(),
        })
    }
}

impl Count for Four {
    #[inline(always)]
    fn lit(&mut self, part: Window) {
        let texels = |[first, last]: [u32; 2]| last - first + 1;
        let x = Self::meet(self.x, part.x, texels);
        let y = Self::meet(self.y, part.y, texels);
        for (i, lit) in self.lit.iter_mut().enumerate() {
            *lit += x[i & 1] * y[i >> 1];
        }
    }

    #[inline(always)]
    fn masked(&mut self, part: Window, mask: u64) {
        let x = Self::meet(self.x, part.x, |[first, last]| {
            window(first & 7, last & 7, 0, 7)
        });
        let y = Self::meet(self.y, part.y, |[first, last]| {
            window(0, 7, first & 7, last & 7)
        });
        for (i, lit) in self.lit.iter_mut().enumerate() {
            *lit += (mask & x[i & 1] & y[i >> 1]).count_ones();
        }
    }
}

/// Goes down to the masks under `part` of slice `z`, together as long as they
/// share nodes. `part` lies in the footprint of the node.
fn count<N: Nodes, C: Count>(
    nodes: &N,
    mut level: usize,
    mut reference: Reference,
    part: Window,
    z: u32,
    into: &mut C,
) {
    loop {
        match reference {
            LIT => return into.lit(part),
            SHADOWED => return,
            _ => {}
        }
        let node = nodes.node(level, reference);
        if level == 0 {
            return match nodes.child(node, z & 7) {
                LIT => into.lit(part),
                SHADOWED => {}
                slice => into.masked(part, nodes.mask(slice)),
            };
        }
        let shift = level as u32 + 2;
        let far = (z >> shift & 1) << 2;
        let (x, y) = (part.x.map(|x| x >> shift), part.y.map(|y| y >> shift));
        level -= 1;
        if x[0] == x[1] && y[0] == y[1] {
            reference = nodes.child(node, far | (y[0] & 1) << 1 | (x[0] & 1));
            continue;
        }
        for y in y[0]..=y[1] {
            for x in x[0]..=x[1] {
                let child = nodes.child(node, far | (y & 1) << 1 | (x & 1));
                count(nodes, level, child, part.cut(x, y, shift), z, into);
            }
        }
        return;
    }
}

pub(super) fn count_all<N: Nodes, C: Count>(
    nodes: &N,
    top: &Top,
    all: Window,
    z: u32,
    into: &mut C,
) {
    let shift = top.shift();
    let z_cell = z >> shift;
    for y in all.y[0] >> shift..=all.y[1] >> shift {
        for x in all.x[0] >> shift..=all.x[1] >> shift {
            let part = all.cut(x, y, shift);
            count(nodes, top.level, top.cell(x, y, z_cell), part, z, into);
        }
    }
}

/// The slice of a grid of `side` that answers for slice `z`.
fn slice(z: i32, side: u32) -> Option<u32> {
    u32::try_from(z).ok().map(|z| z.min(side - 1))
}

/// [`ShadowDag::count_lit`] in a grid of `side`, where `count` adds the lit texels of a window
/// in one slice.
#[inline(always)]
pub(super) fn count_lit(
    voxel: IVec3,
    size: FilterSize,
    side: u32,
    count: impl FnOnce(Window, u32, &mut u32),
) -> u32 {
    let half = i64::from(size.half());
    let range = |middle: i32| [i64::from(middle) - half, i64::from(middle) + half];
    let inside = Window::clip(range(voxel.x), range(voxel.y), side);
    let (Some(inside), Some(z)) = (inside, slice(voxel.z, side)) else {
        return size.area();
    };
    let mut lit = size.area() - inside.area();
    count(inside, z, &mut lit);
    lit
}

/// [`ShadowDag::filter_bilinear`] in a grid of `side`, where `count` adds the lit texels of a
/// window in one slice.
#[inline(always)]
pub(super) fn filter_bilinear(
    position: Vec3,
    size: FilterSize,
    side: u32,
    count: impl FnOnce(Window, u32, &mut Four),
) -> f32 {
    if !position.is_finite() {
        return 1.0;
    }
    // Texel centres are at one half.
    let corner = (position.truncate() - 0.5).floor();
    let weight = position.truncate() - 0.5 - corner;
    let half = i64::from(size.half());
    let range = |middle: f32, step: i64| {
        let middle = (middle as i64).saturating_add(step);
        [middle.saturating_sub(half), middle.saturating_add(half)]
    };
    let Some(z) = slice(position.z.floor() as i32, side) else {
        return 1.0;
    };
    let all = size.area();
    let ends = |middle: f32| [0, 1].map(|step| clip(range(middle, step), side));
    let (x, y) = (ends(corner.x), ends(corner.y));
    let texels = |ends: Option<[u32; 2]>| ends.map_or(0, |[first, last]| last - first + 1);
    let mut four = Four {
        x,
        y,
        lit: [0, 1, 2, 3].map(|i| all - texels(x[i & 1]) * texels(y[i >> 1])),
    };
    let join = |ends: [Option<[u32; 2]>; 2]| {
        let ends = ends.into_iter().flatten();
        ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    };
    if let (Some(x), Some(y)) = (join(x), join(y)) {
        count(Window { x, y }, z, &mut four);
    }
    let share = four.lit.map(|lit| lit as f32 / all as f32);
    let mix = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
    mix(
        mix(share[0], share[1], weight.x),
        mix(share[2], share[3], weight.x),
        weight.y,
    )
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// The lit share, 0 to 1, of the `size × size` voxels around `voxel` in
    /// its slice. Exactly the mean of [`ShadowDag::is_lit`] over them; voxels
    /// beside the map count as lit.
    pub fn filter(&self, voxel: impl Into<[i32; 3]>, size: FilterSize) -> f32 {
        let voxel = IVec3::from_array(voxel.into());
        size.share(self.count_lit(voxel, size))
    }

    /// The number of lit voxels of those that [`ShadowDag::filter`] averages
    /// over.
    pub fn count_lit(&self, voxel: impl Into<[i32; 3]>, size: FilterSize) -> u32 {
        let voxel = IVec3::from_array(voxel.into());
        count_lit(voxel, size, self.resolution().side(), |window, z, lit| {
            with_nodes!(self, nodes => count_all(nodes, &self.top, window, z, lit));
        })
    }

    /// The lit share of a window that is `size` texels wide and lies around
    /// `position` exactly, in the slice of `position`: texels at its rim count
    /// by the share of them that it covers, so that it changes smoothly along
    /// the map.
    ///
    /// The mean of the four nearest results of [`ShadowDag::filter`], weighted
    /// bilinearly. Positions that are not finite are lit.
    pub fn filter_bilinear(&self, position: impl Into<[f32; 3]>, size: FilterSize) -> f32 {
        let position = Vec3::from_array(position.into());
        let side = self.resolution().side();
        filter_bilinear(position, size, side, |window, z, four| {
            with_nodes!(self, nodes => count_all(nodes, &self.top, window, z, four));
        })
    }
}

impl FilterSize {
    /// The voxel at which to ask for the light on a surface at `position`, in
    /// voxels, whose normal in the grid is `normal`: half a filter width
    /// along the normal, so that the window clears the surface itself.
    ///
    /// The offset is in whole voxels, and the normal of any length; without
    /// one (zero or not finite) there is no offset.
    pub fn bias(self, position: impl Into<[f64; 3]>, normal: impl Into<[f32; 3]>) -> IVec3 {
        self.bias_beyond(0.0, position, normal)
    }

    /// How far beyond half a filter's width the bias has to go for a plane with this normal
    /// never to shadow itself, in voxels: what to give [`FilterSize::bias_beyond`] where
    /// surfaces show acne.
    ///
    /// With the unit normal n and the width w, all of a window is in the light if it is
    /// moved along n by
    ///
    /// ```text
    /// (w + 1)/2 (|n.x| + |n.y|) + 3/2 |n.z|
    /// ```
    ///
    /// voxels: the window reaches (w − 1)/2 (|n.x| + |n.y|) into a plane that rises towards
    /// its corner, rounding of the point and of the offset to voxels takes |n.x| + |n.y| +
    /// |n.z|, and the surface is known to half a slice. The returned number is that less w/2; it
    /// is negative where half a width is more than enough, on surfaces that face the light.
    /// From 0.7 widths on, shadows part visibly from what casts them: a finer grid or a
    /// narrower filter helps, a smaller bias does not. It is 0 without a normal.
    ///
    /// The same offset in texels of a map of one's own, with its own filter's width and the
    /// normal in the map's axes, serves ordinary shadow maps as well.
    pub fn clearance(self, normal: impl Into<[f32; 3]>) -> f32 {
        let normal = Vec3::from_array(normal.into()).normalize_or_zero().abs();
        if normal == Vec3::ZERO {
            return 0.0;
        }
        let width = self.width() as f32;
        0.5 * ((width + 1.0) * (normal.x + normal.y) + 3.0 * normal.z - width)
    }

    /// The same as [`FilterSize::bias`], `beyond` voxels farther along the normal.
    pub fn bias_beyond(
        self,
        beyond: f32,
        position: impl Into<[f64; 3]>,
        normal: impl Into<[f32; 3]>,
    ) -> IVec3 {
        let position = DVec3::from_array(position.into());
        let normal = Vec3::from_array(normal.into());
        let offset = normal.normalize_or_zero() * (0.5 * self.width() as f32 + beyond);
        // Conversions saturate.
        let floor = position.floor().as_ivec3();
        let step = offset.round().as_ivec3();
        IVec3::new(
            floor.x.saturating_add(step.x),
            floor.y.saturating_add(step.y),
            floor.z.saturating_add(step.z),
        )
    }
}
