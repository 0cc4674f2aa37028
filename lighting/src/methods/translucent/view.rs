//! The rays of a picture, in f64.

use glam::{DVec2, DVec3, Vec3};

use crate::scene::Bounds;
#[cfg(feature = "trace")]
use crate::scene::Camera;
use crate::scene::raster::{Face, Rays};

/// A [`Face`] with its number of texels, or the picture of a camera. *Local* coordinates are
/// those along its right, up and forward directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    origin: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Texels per metre to the right and up; per unit of the tangent for central rays.
    scale: DVec2,
    parallel: bool,
    /// Columns and rows, and half of them.
    extent: [u32; 2],
    half: DVec2,
    /// A strand is met at no fewer than this many radii from the origin of central rays.
    pub(super) nearest: f64,
}

/// The ray of a texel, and how those of its neighbours differ.
#[cfg(feature = "wgpu")]
#[derive(Debug, Clone, Copy)]
pub(super) struct WorldLine {
    /// That of the view.
    pub(super) origin: DVec3,
    /// From there to a point of the ray.
    pub(super) offset: DVec3,
    pub(super) direction: DVec3,
    /// What the next column adds to the offset; for central rays to the direction.
    pub(super) across: DVec3,
    /// What the next row adds.
    pub(super) down: DVec3,
}

/// The texels whose columns and rows are in these ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Texels {
    pub(crate) x: [u32; 2],
    pub(crate) y: [u32; 2],
}

impl View {
    pub(super) fn new(face: &Face, resolution: u32) -> Self {
        let half = 0.5 * f64::from(resolution);
        let (scale, parallel) = match face.rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => {
                let widths = DVec2::new(half_width.into(), half_height.into());
                (half / widths, true)
            }
            Rays::Central { tan } => (DVec2::splat(half / f64::from(tan)), false),
        };
        Self {
            origin: face.origin.as_dvec3(),
            right: face.right.as_dvec3(),
            up: face.up.as_dvec3(),
            forward: face.forward.as_dvec3(),
            scale,
            parallel,
            extent: [resolution; 2],
            half: DVec2::splat(half),
            nearest: 1.0,
        }
    }

    /// The picture of a camera with so many columns and rows.
    #[cfg(feature = "trace")]
    pub(crate) fn of_camera(camera: &Camera, extent: [u32; 2]) -> Self {
        let axis = |axis: Vec3| (camera.rotation() * axis).as_dvec3();
        let half = 0.5 * DVec2::from(extent.map(f64::from));
        let tan = (0.5 * f64::from(camera.vertical_fov())).tan();
        Self {
            origin: camera.eye().as_dvec3(),
            right: axis(Vec3::X),
            up: axis(Vec3::Y),
            forward: axis(Vec3::NEG_Z),
            scale: DVec2::splat(half.y / tan),
            parallel: false,
            extent,
            half,
            // A ribbon that faces the eye is then in front of it with all of its width.
            nearest: 2.0,
        }
    }

    /// True if rays are parallel and depth is measured along them from a plane.
    pub(super) fn is_parallel(&self) -> bool {
        self.parallel
    }

    /// Texels per metre to the right and up; per unit of the tangent for central rays.
    #[cfg(feature = "wgpu")]
    pub(super) fn scale(&self) -> DVec2 {
        self.scale
    }

    /// Texels per side of a face.
    pub(super) fn resolution(&self) -> u32 {
        self.extent[0]
    }

    pub(super) fn local(&self, point: Vec3) -> DVec3 {
        let v = point.as_dvec3() - self.origin;
        DVec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.forward))
    }

    /// Column and row of a local point, which must be in front of the origin of central rays.
    pub(super) fn texel(&self, local: DVec3) -> DVec2 {
        let plane = if self.parallel {
            local.truncate()
        } else {
            local.truncate() / local.z
        };
        let half = self.half;
        DVec2::new(
            half.x + plane.x * self.scale.x,
            half.y - plane.y * self.scale.y,
        )
    }

    /// Depth of a local point.
    pub(super) fn depth(&self, local: DVec3) -> f64 {
        if self.parallel {
            local.z
        } else {
            local.length()
        }
    }

    /// How far the middle of a texel is to the right and up, in metres; in units of the tangent
    /// for central rays.
    fn middle(&self, x: u32, y: u32) -> DVec2 {
        DVec2::new(
            (f64::from(x) + 0.5 - self.half.x) / self.scale.x,
            (self.half.y - f64::from(y) - 0.5) / self.scale.y,
        )
    }

    /// Start and unit direction of the ray through the middle of a texel, in
    /// local coordinates. Depth counts from the start.
    pub(super) fn ray(&self, x: u32, y: u32) -> (DVec3, DVec3) {
        let middle = self.middle(x, y);
        if self.parallel {
            (middle.extend(0.0), DVec3::Z)
        } else {
            (DVec3::ZERO, middle.extend(1.0).normalize())
        }
    }

    /// A local direction in world coordinates.
    fn turned(&self, v: DVec3) -> DVec3 {
        v.x * self.right + v.y * self.up + v.z * self.forward
    }

    /// The same ray in world coordinates.
    pub(super) fn world_ray(&self, x: u32, y: u32) -> (DVec3, DVec3) {
        let (start, direction) = self.ray(x, y);
        (self.origin + self.turned(start), self.turned(direction))
    }

    /// The ray of a texel in world coordinates: where it is `reach` metres in front of the
    /// origin, and its direction, which leads one metre forwards.
    #[cfg(feature = "wgpu")]
    pub(super) fn world_line(&self, x: u32, y: u32, reach: f64) -> WorldLine {
        let middle = self.middle(x, y);
        let [offset, direction] = if self.parallel {
            [middle.extend(reach), DVec3::Z]
        } else {
            [reach * middle.extend(1.0), middle.extend(1.0)]
        };
        WorldLine {
            origin: self.origin,
            offset: self.turned(offset),
            direction: self.turned(direction),
            across: self.right / self.scale.x,
            down: -self.up / self.scale.y,
        }
    }

    /// All texels that may see a part of a box, given two corners in the picture.
    pub(super) fn between(&self, min: DVec2, max: DVec2) -> Option<Texels> {
        let range = |low: f64, high: f64, count: u32| {
            let first = low.floor().max(0.0);
            let end = (high.floor() + 1.0).min(f64::from(count));
            (first < end).then_some([first as u32, end as u32])
        };
        let [columns, rows] = self.extent;
        Some(Texels {
            x: range(min.x, max.x, columns)?,
            y: range(min.y, max.y, rows)?,
        })
    }

    /// Every texel.
    pub(super) fn all(&self) -> Texels {
        let [x, y] = self.extent.map(|count| [0, count]);
        Texels { x, y }
    }

    /// The texels that may see a box.
    pub(super) fn of_box(&self, bounds: Bounds) -> Option<Texels> {
        let corners = bounds.corners().map(|corner| self.local(corner));
        if !self.parallel && corners.iter().any(|corner| corner.z <= 0.0) {
            return corners
                .iter()
                .any(|corner| corner.z > 0.0)
                .then(|| self.all());
        }
        let positions = corners.map(|corner| self.texel(corner));
        let min = positions.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let max = positions.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        self.between(min, max)
    }

    /// The texels that may see a ball, given in local coordinates.
    pub(super) fn of_ball(&self, centre: DVec3, radius: f64) -> Option<Texels> {
        if self.parallel {
            let (middle, reach) = (self.texel(centre), radius * self.scale);
            return self.between(middle - reach, middle + reach);
        }
        if centre.z + radius <= 0.0 {
            return None;
        }
        if centre.z <= radius {
            return Some(self.all());
        }
        // In the plane of an axis and the forward direction: the tangents of the two directions
        // that touch the circle.
        let touching = |x: f64| {
            let (z2, r2) = (centre.z * centre.z, radius * radius);
            let root = radius * (x * x + z2 - r2).sqrt();
            [
                (x * centre.z - root) / (z2 - r2),
                (x * centre.z + root) / (z2 - r2),
            ]
        };
        let ([left, right], [down, up]) = (touching(centre.x), touching(centre.y));
        let min = self.texel(DVec3::new(left, up, 1.0));
        let max = self.texel(DVec3::new(right, down, 1.0));
        self.between(min, max)
    }
}

impl Texels {
    /// The intersection with a tile.
    pub(crate) fn within(self, tile: &transmittance::Tile) -> Option<Self> {
        let both = |[first, end]: [u32; 2], range: &std::ops::Range<usize>| {
            let first = first.max(u32::try_from(range.start).unwrap_or(u32::MAX));
            let end = end.min(u32::try_from(range.end).unwrap_or(u32::MAX));
            (first < end).then_some([first, end])
        };
        Some(Self {
            x: both(self.x, &tile.x)?,
            y: both(self.y, &tile.y)?,
        })
    }

    /// Calls `texel(x, y)` for each, row by row.
    pub(super) fn for_each(self, mut texel: impl FnMut(u32, u32)) {
        for y in self.y[0]..self.y[1] {
            for x in self.x[0]..self.x[1] {
                texel(x, y);
            }
        }
    }
}
