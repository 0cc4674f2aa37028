//! All levels of the moments of a shadow map.

use glam::Vec3;
use gpu_backend::{Backend, Error, Host, Memory};

use super::{Level, Moments, Prefilter};
use crate::scene::Bounds;
use crate::scene::raster::{Face, Rays};
use crate::shadow_map::{Place, ShadowMap, locate};
use crate::visibility::PointVisibility;

/// The moments of a shadow map as a mip pyramid.
///
/// At a point the finest level is looked up. Between two points the level is chosen whose
/// texels are the largest that are no longer than half of the way between the points, in the
/// picture of the light. The interpolation between four of them is then about as wide as the
/// way is long.
#[derive(Debug)]
pub struct MomentPyramid<M: Memory> {
    /// The levels, the finest first, each half as fine as the one before, down to a single
    /// texel.
    pub(super) levels: Vec<Level>,
    /// For each level, the index of its first moment.
    pub(super) firsts: Vec<usize>,
    pub(super) moments: M::Buffer<f32>,
}

impl<M: Memory> MomentPyramid<M> {
    /// The moments of `map`, averaged over squares of 2^`finest` texels and of all larger
    /// powers of two. `casters` must be a box around everything in the map.
    ///
    /// It takes four thirds of the memory of the finest level.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the moments do not fit into memory.
    pub fn new<B>(
        backend: &B,
        map: &ShadowMap<M>,
        moments: Moments,
        casters: &Bounds,
        finest: u32,
    ) -> Result<Self, Error>
    where
        B: Prefilter + Backend<Memory = M>,
    {
        let first = Level::new(map, moments, casters, finest);
        let top = map.resolution().next_power_of_two().ilog2();
        let others = first.level + 1..=top;
        let others = others.map(|level| Level::new(map, moments, casters, level));
        let levels: Vec<Level> = std::iter::once(first.clone()).chain(others).collect();
        let mut all = 0;
        let firsts = levels.iter().map(|level| {
            let first = all;
            all += level.len();
            first
        });
        Ok(Self {
            firsts: firsts.collect(),
            moments: backend.prefilter_all(map, &levels)?,
            levels,
        })
    }

    /// Which moments it holds.
    pub fn kind(&self) -> Moments {
        self.levels[0].moments
    }

    /// The finest level.
    pub fn finest(&self) -> u32 {
        self.levels[0].level
    }

    /// The moments, level by level from the finest, each face by face and row by row.
    pub fn moments(&self) -> &M::Buffer<f32> {
        &self.moments
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|level| 4 * level.len() as u64).sum()
    }

    /// The index of the level for a way that is so many texels of the map long.
    fn number(&self, texels: f32) -> usize {
        // The exponent of the length, rounded down. That of 0 is the smallest, and that of NaN
        // the largest.
        let exponent = (texels.to_bits() >> 23) as i32 - 127;
        let number = exponent - 1 - self.levels[0].level as i32;
        number.clamp(0, self.levels.len() as i32 - 1) as usize
    }
}

impl MomentPyramid<Host> {
    fn visibility_at(&self, number: usize, place: &Place) -> f32 {
        self.levels[number].visibility(&self.moments[self.firsts[number]..], place)
    }
}

/// The length in the picture, in texels, of a way along `along` whose middle is the origin of
/// the face plus `v`.
pub(super) fn texels_along(face: &Face, resolution: u32, v: Vec3, along: Vec3) -> f32 {
    let half = 0.5 * resolution as f32;
    let [x, y] = match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => [
            along.dot(face.right) / half_width,
            along.dot(face.up) / half_height,
        ],
        Rays::Central { tan } => {
            let depth = v.dot(face.forward);
            let towards = along.dot(face.forward) / depth;
            let scale = 1.0 / (depth * tan);
            [face.right, face.up].map(|axis| scale * (along.dot(axis) - v.dot(axis) * towards))
        }
    };
    half * (x * x + y * y).sqrt()
}

impl PointVisibility for MomentPyramid<Host> {
    type Share = f32;

    fn visibility(&self, point: Vec3) -> f32 {
        let Level {
            faces, resolution, ..
        } = &self.levels[0];
        let place = locate(faces, *resolution, point);
        place.map_or(1.0, |place| self.visibility_at(0, &place))
    }

    fn visibility_between(&self, from: Vec3, to: Vec3) -> f32 {
        let Level {
            faces, resolution, ..
        } = &self.levels[0];
        let middle = 0.5 * (from + to);
        let Some(place) = locate(faces, *resolution, middle) else {
            return 1.0;
        };
        let face = &faces[place.face];
        let texels = texels_along(face, *resolution, middle - face.origin, to - from);
        self.visibility_at(self.number(texels), &place)
    }
}
