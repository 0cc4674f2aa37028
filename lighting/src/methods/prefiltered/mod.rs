//! Shadow maps that can be filtered: moments of depth.
//!
//! Based on: Donnelly and Lauritzen, Variance Shadow Maps, I3D 2006; Lauritzen and
//! McCool, Layered Variance Shadow Maps, GI 2008 (exponential variance); Peters and
//! Klein, Moment Shadow Mapping, I3D 2015; Peters, Münstermann, Wetzstein and Klein,
//! Beyond Hard Shadows: Moment Shadow Maps for Single Scattering, Soft Shadows and
//! Translucent Occluders, I3D 2016.
//!
//! The mean of some depths says nothing about a shadow, but the means of a few powers of depth
//! bound the share of texels in front of a point. So such a map can be averaged before it is
//! looked up. A [`PrefilteredMap`] is a level of a mip pyramid: means over squares of 2ˡ × 2ˡ
//! texels. A march with few steps that looks into it sees what lies between its steps, instead
//! of single texels.
//!
//! A [`MomentPyramid`] has all levels. It is asked about the way between two points, at a level
//! that fits the length of this way in the picture of the light
//! ([`PointVisibility::visibility_between`]).
//!
//! # What a lookup gives
//!
//! It gives the largest share of light that any distribution of depths with these moments lets
//! through. So light leaks, and shadows are never too dark, except by the bias that compensates
//! for rounding.
//!
//! | [`Moments`] | stored | bound |
//! |---|---|---|
//! | `Variance` | z, z² | Cantelli's inequality |
//! | `ExponentialVariance` | e^{cz}, e^{2cz}, −e^{−cz}, e^{−2cz} | the lesser of two such |
//! | `Four` | z … z⁴ | Hamburger's problem |
//! | `Six` | z … z⁶ | Hamburger's problem |
//!
//! z is the depth, mapped from the range of depths that casters can have to −1 to 1. Texels in
//! which the light sees nothing are at 1, behind all casters.
//!
//! # How it departs from the papers
//!
//! * Moments are f32, so they are neither quantised nor transformed to another basis. Bounds
//!   for six moments come from a factorisation and a bracketing solver.
//! * Between four texels the bounds are interpolated, not the moments. A mean of bounds is a
//!   bound for the mean; it leaks less light and does not magnify the rounding of the
//!   interpolation.
//! * A level may have any size; each of its texels is the mean of the texels of the map that it
//!   covers. Faces of a cube are filtered separately.
//!
//! # Error
//!
//! A level `l` blurs shadows over 2ˡ texels. The bias changes shares by up to 3e-5 (four
//! moments) or 1e-4 (six), or makes all depths uncertain by a thousandth of their range
//! (variance).

#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
mod moments;
mod pyramid;
#[cfg(test)]
mod tests;

#[cfg(feature = "methods")]
pub(super) use method::{finest_level, methods};
pub use pyramid::MomentPyramid;

use glam::Vec3;
use gpu_backend::{Backend, BufferOf, Cpu, Error, Host, Memory};

use moments::{least_before, not_before};

use crate::scene::Bounds;
use crate::scene::raster::{Face, Rays};
use crate::shadow_map::{EMPTY, Place, ShadowMap, locate};
use crate::visibility::PointVisibility;

/// The deepest caster is mapped to this depth; 1 stands for no caster.
const DEEPEST: f32 = 0.9;

/// Points behind all casters are mapped to this depth.
const BEHIND: f32 = 0.95;

/// The constant c of the exponential warps.
const WARP: f32 = 20.0;

/// The standard deviation of z that is assumed in variance maps at least.
const DEVIATION: f32 = 1e-3;

/// The kinds of moments that a map can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Moments {
    /// Mean and mean square of the depth.
    Variance,
    /// Mean and mean square of two exponentials of the depth.
    ExponentialVariance,
    /// Four powers of the depth.
    Four,
    /// Six powers.
    Six,
}

impl Moments {
    /// Numbers stored per texel.
    pub fn channels(self) -> usize {
        match self {
            Self::Variance => 2,
            Self::ExponentialVariance | Self::Four => 4,
            Self::Six => 6,
        }
    }

    /// The moments of a single depth from −1 to 1; the rest of the array is 0.
    fn of(self, z: f32) -> [f32; MOST] {
        let square = z * z;
        let fourth = square * square;
        match self {
            Self::Variance => [z, square, 0.0, 0.0, 0.0, 0.0],
            Self::ExponentialVariance => {
                let [up, down] = warped(z);
                [up, up * up, down, down * down, 0.0, 0.0]
            }
            Self::Four => [z, square, square * z, fourth, 0.0, 0.0],
            Self::Six => [z, square, square * z, fourth, fourth * z, fourth * square],
        }
    }

    /// The share of light that reaches the depth `z`.
    fn visibility(self, moments: &[f32; MOST], z: f32) -> f32 {
        match self {
            Self::Variance => not_before(moments[0], moments[1], DEVIATION * DEVIATION, z),
            Self::ExponentialVariance => {
                let [up, down] = warped(z);
                let least = |w: f32| (WARP * DEVIATION * w) * (WARP * DEVIATION * w);
                let a = not_before(moments[0], moments[1], least(up), up);
                a.min(not_before(moments[2], moments[3], least(down), down))
            }
            Self::Four => 1.0 - least_before(&moments[..4], 3e-5, z),
            Self::Six => 1.0 - least_before(&moments[..], 1e-4, z),
        }
    }
}

/// The largest number of values per texel.
const MOST: usize = 6;

/// Two exponentials of a depth, both increasing.
fn warped(z: f32) -> [f32; 2] {
    let up = (WARP * z).exp();
    [up, -up.recip()]
}

/// The layout of a [`PrefilteredMap`].
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    moments: Moments,
    resolution: u32,
    faces: Vec<Face>,
    /// The level, and its number of texels per side.
    level: u32,
    side: u32,
    /// The range of the casters' depths.
    depths: [f32; 2],
}

impl Level {
    fn new<M: Memory>(map: &ShadowMap<M>, moments: Moments, casters: &Bounds, level: u32) -> Self {
        let resolution = map.resolution();
        let level = level.min(resolution.next_power_of_two().ilog2());
        Self {
            moments,
            resolution,
            faces: map.faces().to_vec(),
            level,
            side: resolution.div_ceil(1 << level),
            depths: depths(&map.faces()[0], casters),
        }
    }

    /// Texels of all faces.
    fn texels(&self) -> usize {
        self.faces.len() * (self.side as usize).pow(2)
    }

    /// Numbers of all texels.
    fn len(&self) -> usize {
        self.moments.channels() * self.texels()
    }

    /// A depth between −1 and 1.
    fn depth(&self, depth: f32) -> f32 {
        if depth == EMPTY {
            return 1.0;
        }
        let [near, far] = self.depths;
        ((depth - near) * ((1.0 + DEEPEST) / (far - near)) - 1.0).clamp(-1.0, BEHIND)
    }

    /// The texels of the map that a texel covers along an axis.
    fn covered(&self, texel: u32) -> std::ops::Range<usize> {
        let first = texel << self.level;
        let end = (first + (1 << self.level)).min(self.resolution);
        first as usize..end as usize
    }

    /// The share of light that passes a texel and reaches the depth `z`; `stored` has the
    /// moments of all texels.
    fn share(&self, stored: &[f32], face: usize, [column, row]: [u32; 2], z: f32) -> f32 {
        let side = self.side as usize;
        let channels = self.moments.channels();
        let texel = (face * side + row as usize) * side + column as usize;
        let mut moments = [0.0; MOST];
        moments[..channels].copy_from_slice(&stored[channels * texel..channels * (texel + 1)]);
        self.moments.visibility(&moments, z)
    }

    /// The share of light that reaches a place, interpolated between the four texels around it.
    fn visibility(&self, stored: &[f32], place: &Place) -> f32 {
        let z = self.depth(place.depth);
        let scale = 1.0 / (1_u32 << self.level) as f32;
        let last = self.side - 1;
        let position = place
            .texel
            .map(|x| (x * scale - 0.5).clamp(0.0, last as f32));
        let low = position.map(|x| x as u32);
        let high = low.map(|x| (x + 1).min(last));
        let [x, y] = [0, 1].map(|axis| position[axis] - low[axis] as f32);
        let line = |row: u32| {
            let [a, b] =
                [low[0], high[0]].map(|column| self.share(stored, place.face, [column, row], z));
            a + x * (b - a)
        };
        let (a, b) = (line(low[1]), line(high[1]));
        a + y * (b - a)
    }
}

/// The range of depths of a box's corners, as a light sees them.
fn depths(face: &Face, casters: &Bounds) -> [f32; 2] {
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for corner in casters.corners() {
        let v = corner - face.origin;
        let depth = match face.rays {
            Rays::Parallel { .. } => v.dot(face.forward),
            Rays::Central { .. } => v.length(),
        };
        range = [range[0].min(depth), range[1].max(depth)];
    }
    if let Rays::Central { .. } = face.rays {
        range[0] = face
            .origin
            .clamp(casters.min(), casters.max())
            .distance(face.origin);
    }
    // A flat box is given some depth.
    let least = 1e-4 * range[1].abs().max(1e-20);
    [range[0], range[1].max(range[0] + least)]
}

/// Moments of the depths of a shadow map, filtered.
#[derive(Debug)]
pub struct PrefilteredMap<M: Memory> {
    level: Level,
    moments: M::Buffer<f32>,
}

/// A backend that filters shadow maps.
pub trait Prefilter: Backend {
    /// The moments of a level, face by face, each row by row.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    fn prefilter(
        &self,
        map: &ShadowMap<Self::Memory>,
        level: &Level,
    ) -> Result<BufferOf<Self, f32>, Error>;

    /// The moments of several levels, one after the other, each half as fine as the one before.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    fn prefilter_all(
        &self,
        map: &ShadowMap<Self::Memory>,
        levels: &[Level],
    ) -> Result<BufferOf<Self, f32>, Error>;
}

impl<M: Memory> PrefilteredMap<M> {
    /// The moments of `map`, averaged over squares of 2^`level` texels; `level` is at most that
    /// of a single texel. `casters` must be a box around everything in the map.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    pub fn new<B>(
        backend: &B,
        map: &ShadowMap<M>,
        moments: Moments,
        casters: &Bounds,
        level: u32,
    ) -> Result<Self, Error>
    where
        B: Prefilter + Backend<Memory = M>,
    {
        let level = Level::new(map, moments, casters, level);
        Ok(Self {
            moments: backend.prefilter(map, &level)?,
            level,
        })
    }

    /// Which moments it holds.
    pub fn kind(&self) -> Moments {
        self.level.moments
    }

    /// The level at which it is looked up.
    pub fn level(&self) -> u32 {
        self.level.level
    }

    /// The moments, face by face, each row by row.
    pub fn moments(&self) -> &M::Buffer<f32> {
        &self.moments
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        4 * self.level.len() as u64
    }
}

impl Prefilter for Cpu {
    fn prefilter(&self, map: &ShadowMap<Host>, level: &Level) -> Result<Vec<f32>, Error> {
        let mut all = self.zeros::<f32>(level.len())?;
        filter(self, map, level, &mut all);
        Ok(all)
    }

    fn prefilter_all(&self, map: &ShadowMap<Host>, levels: &[Level]) -> Result<Vec<f32>, Error> {
        let mut all = self.zeros::<f32>(levels.iter().map(Level::len).sum())?;
        let mut rest = &mut all[..];
        let mut finer: Option<(&Level, &[f32])> = None;
        for level in levels {
            let (own, others) = rest.split_at_mut(level.len());
            match finer {
                None => filter(self, map, level, own),
                Some((finer, moments)) => coarsen(self, finer, moments, level, own),
            }
            (finer, rest) = (Some((level, &*own)), others);
        }
        Ok(all)
    }
}

/// Computes the moments of a level from the map.
fn filter(cpu: &Cpu, map: &ShadowMap<Host>, level: &Level, all: &mut [f32]) {
    let channels = level.moments.channels();
    let side = level.resolution as usize;
    let width = level.side as usize;
    cpu.for_each_chunk(all, channels * width, |first, line| {
        let number = first / (channels * width);
        let (face, number) = (number / width, number % width);
        let rows = level.covered(number as u32);
        for (column, texel) in line.chunks_exact_mut(channels).enumerate() {
            let columns = level.covered(column as u32);
            let mut sums = [0.0_f32; MOST];
            for row in rows.clone() {
                // The sum is taken row by row, which rounds less than one long sum.
                let mut sum = [0.0_f32; MOST];
                let depths = &map.depth()[(face * side + row) * side..][columns.clone()];
                for depth in depths {
                    let moments = level.moments.of(level.depth(*depth));
                    for (sum, moment) in sum.iter_mut().zip(moments) {
                        *sum += moment;
                    }
                }
                for (total, sum) in sums.iter_mut().zip(sum) {
                    *total += sum;
                }
            }
            let count = (rows.len() * columns.len()) as f32;
            for (to, sum) in texel.iter_mut().zip(sums) {
                *to = sum / count;
            }
        }
    });
}

/// Computes the moments of a level from those of the next finer one. Texels at the far borders
/// may cover fewer texels of the map, and have less weight then.
fn coarsen(cpu: &Cpu, finer: &Level, moments: &[f32], level: &Level, all: &mut [f32]) {
    let channels = level.moments.channels();
    let (side, width) = (finer.side, level.side as usize);
    cpu.for_each_chunk(all, channels * width, |first, line| {
        let number = first / (channels * width);
        let (face, row) = (number / width, number % width);
        for (column, texel) in line.chunks_exact_mut(channels).enumerate() {
            let mut count = 0.0_f32;
            let first = [2 * column as u32, 2 * row as u32];
            for [column, row] in [[0, 0], [1, 0], [0, 1], [1, 1]]
                .map(|[x, y]| [first[0] + x, first[1] + y])
                .into_iter()
                .filter(|at| at.iter().all(|at| *at < side))
            {
                let [x, y] = [column, row].map(|at| finer.covered(at).len() as f32);
                let own = (face * side as usize + row as usize) * side as usize + column as usize;
                for (sum, moment) in texel.iter_mut().zip(&moments[channels * own..]) {
                    *sum += x * y * moment;
                }
                count += x * y;
            }
            for sum in texel {
                *sum /= count;
            }
        }
    });
}

impl PointVisibility for PrefilteredMap<Host> {
    type Share = f32;

    fn visibility(&self, point: Vec3) -> f32 {
        let place = locate(&self.level.faces, self.level.resolution, point);
        place.map_or(1.0, |place| self.level.visibility(&self.moments, &place))
    }
}
