//! The froxels of a view.

use glam::Vec3;

use crate::path::depth_range;
use crate::scene::{Camera, Medium};
use crate::{Emitter, Interval, Ray};

/// The largest width and height of a picture, pixels.
const MAX_SIDE: u32 = 16384;

/// The number of tiles unless another is asked for: 160 × 90, as is usual in engines.
const TILES: f64 = 160.0 * 90.0;

/// The largest number of slices.
pub const MOST_SLICES: u32 = 1024;

/// The largest number of froxels: 128 MiB of four `f32` each, which is what WebGPU lets a
/// shader bind.
pub const MOST_FROXELS: u64 = 1 << 23;

/// Why froxels could not be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FroxelError {
    /// The picture has no pixels, or too many.
    #[error("a picture of {width} x {height} pixels was given, expected 1 to {MAX_SIDE} per side")]
    Picture {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The tiles have no pixels.
    #[error("tiles of 0 pixels were asked for, expected 1 or more")]
    Tile,
    /// The number of slices is out of range.
    #[error("{slices} slices were asked for, expected 1 to {MOST_SLICES}")]
    Slices {
        /// What was asked for.
        slices: u32,
    },
    /// There are too many froxels.
    #[error(
        "{columns} x {rows} x {slices} froxels were asked for, expected {MOST_FROXELS} at most"
    )]
    TooMany {
        /// Tiles per row of the picture.
        columns: u32,
        /// Rows of tiles.
        rows: u32,
        /// Slices in depth.
        slices: u32,
    },
    /// The slices begin behind their end, or do not end.
    #[error(
        "slices from {start} m to {end} m were asked for, expected 0 <= start < end < infinity"
    )]
    Depths {
        /// Where the first slice begins.
        start: f32,
        /// Where the last one ends.
        end: f32,
    },
    /// The weight of earlier frames is out of range.
    #[error("a share of {share} for earlier frames was asked for, expected 0 to 1, 1 excluded")]
    History {
        /// What was asked for.
        share: f32,
    },
}

/// Froxels: the tiles of a picture, each divided in depth.
///
/// Tiles are squares of pixels; the last one in a row or column may extend beyond the picture.
/// Slices are shells around the eye: depth is the distance `x` along the ray, not the distance
/// to the plane of the camera, so a slice is as long in the corners of the picture as in the
/// middle. The borders are quadratic:
/// ```text
/// x(u) = near + (far − near) (u / N)²        u = 0 … N
/// ```
///
/// Slices are short near the eye, where a shadow covers many pixels; the last one is (2N − 1) /
/// N² of the whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FroxelGrid {
    pub(super) eye: Vec3,
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    pub(super) forward: Vec3,
    /// Side of a tile in the image plane at distance 1.
    pub(super) tile: f32,
    /// The place of the camera's axis in the picture, in tiles.
    pub(super) middle: [f32; 2],
    pub(super) columns: u32,
    pub(super) rows: u32,
    pub(super) slices: u32,
    pub(super) near: f32,
    pub(super) far: f32,
}

impl FroxelGrid {
    /// Froxels for a picture of `size` pixels that `camera` takes, with tiles of `tile` pixels
    /// per side and `slices` slices between two distances.
    ///
    /// # Errors
    /// [`FroxelError`] for a number that is out of range.
    pub fn new(
        camera: &Camera,
        [width, height]: [u32; 2],
        tile: u32,
        slices: u32,
        depths: Interval,
    ) -> Result<Self, FroxelError> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(FroxelError::Picture { width, height });
        }
        if tile == 0 {
            return Err(FroxelError::Tile);
        }
        if !(1..=MOST_SLICES).contains(&slices) {
            return Err(FroxelError::Slices { slices });
        }
        let [columns, rows] = [width, height].map(|side| side.div_ceil(tile));
        if u64::from(columns) * u64::from(rows) * u64::from(slices) > MOST_FROXELS {
            return Err(FroxelError::TooMany {
                columns,
                rows,
                slices,
            });
        }
        let Interval { start, end } = depths;
        if !(start >= 0.0 && start < end && end < f32::INFINITY) {
            return Err(FroxelError::Depths { start, end });
        }
        let half = f64::from(0.5 * camera.vertical_fov()).tan();
        let side = f64::from(tile);
        Ok(Self {
            eye: camera.eye(),
            right: camera.rotation() * Vec3::X,
            up: camera.rotation() * Vec3::Y,
            forward: camera.rotation() * Vec3::NEG_Z,
            tile: (2.0 * half * side / f64::from(height)) as f32,
            middle: [width, height].map(|pixels| (0.5 * f64::from(pixels) / side) as f32),
            columns,
            rows,
            slices,
            near: start,
            far: end,
        })
    }

    /// The smallest side of tiles, in pixels, for which a picture of `size` pixels has no more
    /// than 160 × 90 of them, apart from rounding at the borders: 6 at 960 × 540, and 1 for
    /// pictures of up to 160 × 90.
    pub fn usual_tile([width, height]: [u32; 2]) -> u32 {
        let pixels = f64::from(width) * f64::from(height);
        (pixels / TILES).sqrt().ceil().max(1.0) as u32
    }

    /// Numbers of columns, rows and slices.
    pub fn counts(&self) -> [u32; 3] {
        [self.columns, self.rows, self.slices]
    }

    /// Number of froxels.
    pub fn froxels(&self) -> usize {
        // This cannot overflow, as it was checked at construction.
        self.columns as usize * self.rows as usize * self.slices as usize
    }

    /// The distances between which the slices lie, m.
    pub fn depths(&self) -> Interval {
        Interval::new(self.near, self.far)
    }

    /// The distance of the border `u` of slices; a fractional `u` gives a distance inside a
    /// slice.
    pub fn depth(&self, u: f32) -> f32 {
        let t = u / self.slices as f32;
        self.near + (self.far - self.near) * (t * t)
    }

    /// The fractional border at the distance `x`, from 0 to the number of slices: the inverse
    /// of [`FroxelGrid::depth`].
    pub fn slice(&self, x: f32) -> f32 {
        let t = ((x - self.near) / (self.far - self.near)).clamp(0.0, 1.0);
        self.slices as f32 * t.sqrt()
    }

    /// The unit direction through a point of the picture, given in tiles from its upper left
    /// corner.
    pub fn direction(&self, at: [f32; 2]) -> Vec3 {
        let right = (at[0] - self.middle[0]) * self.tile;
        let down = (at[1] - self.middle[1]) * self.tile;
        (self.forward + right * self.right - down * self.up).normalize()
    }

    /// The point of the picture at which a direction is seen, in tiles; it may be outside of
    /// the picture. `None` for directions behind the camera.
    pub fn place(&self, direction: Vec3) -> Option<[f32; 2]> {
        let scale = direction.dot(self.forward) * self.tile;
        (scale > 0.0).then(|| {
            [
                self.middle[0] + direction.dot(self.right) / scale,
                self.middle[1] - direction.dot(self.up) / scale,
            ]
        })
    }

    /// The borders of the slices, in order.
    pub(super) fn borders(&self) -> Vec<f32> {
        (0..=self.slices).map(|k| self.depth(k as f32)).collect()
    }

    /// The direction through the tile of this index, and the part of the ray along it that is
    /// in the medium, up to the far end.
    pub(super) fn column(
        &self,
        number: usize,
        offset: [f32; 2],
        medium: &Medium,
    ) -> (Vec3, Option<Interval>) {
        let columns = self.columns as usize;
        let (column, row) = ((number % columns) as f32, (number / columns) as f32);
        let direction = self.direction([column + offset[0], row + offset[1]]);
        let whole = Interval::new(0.0, self.far);
        let inside = match medium.bounds() {
            Some(bounds) => bounds.clip(self.eye, direction, whole),
            None => Some(whole),
        };
        (direction, inside)
    }
}

/// The distances from the eye between which `rays` receive light of `emitters` from the air: in
/// the medium, in front of the surfaces at the ends of the rays or up to ten mean free paths to
/// the sky, and within the range of at least one light. Empty if there are none.
pub fn lit_depths(eye: Vec3, rays: &[Ray], medium: &Medium, emitters: &[Emitter]) -> Interval {
    let depths = depth_range(rays, medium);
    let farthest = |emitter: &Emitter| match emitter {
        Emitter::Point(point) => eye.distance(point.position()) + point.range(),
        Emitter::Directional(_) => f32::INFINITY,
    };
    let end = emitters.iter().map(farthest).fold(0.0, f32::max);
    Interval::new(depths.start, depths.end.min(end).max(depths.start))
}
