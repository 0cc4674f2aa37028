//! Voxels of epipolar space: from coordinates to texels and bits, and back.

use std::ops::Range;

use glam::Vec2;

use crate::angle::cross;
use crate::guess::Guess;
use crate::{
    Angle, Coordinates, Error, EyeRay, LightRay, Phi, Ranges, Resolution, Space, Spacing,
    ViewVolume,
};

/// The voxels of what a view sees in an epipolar space.
///
/// A *position* is a coordinate counted in voxels: voxel `i` reaches from `i`
/// to `i + 1` and has its centre at `i + ½`. α and θ are divided evenly, φ by
/// the chosen [`Spacing`]. What lies outside of the ranges belongs to the nearest
/// voxel.
///
/// Positions along α, θ and φ are off by at most 8e-7 rad (the 4e-7 of
/// [`Space::coordinates`], relative to α and φ, and the angle function's 3e-7, of
/// the distance from where a range begins), divided by the width of a voxel.
/// Shaders lose up to 2⁻³³ of the coordinates more, which close to the axis,
/// divided by sin α, is an angle of θ. Voxels should be several times as wide.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    space: Space,
    ranges: Ranges,
    resolution: Resolution,
    alpha_start: Angle,
    alpha_scale: f32,
    theta_centre: Angle,
    theta_scale: f32,
    /// Twice the width of a voxel, the larger of α and the mean of φ; 0 for a
    /// directional light, whose rays do not approach eye rays.
    thinnest: f32,
    /// Bounds of the voxels along φ, one more than there are bits.
    bounds: Vec<Vec2>,
    guess: Guess,
    /// Centres of the voxels along φ.
    light_angles: Vec<Vec2>,
    /// Centres of the voxels along θ: unit vectors.
    planes: Vec<Vec2>,
}

impl Lattice {
    /// Divides the [`Ranges`] of what `view` sees. [`Resolution`] and [`Spacing`] say which
    /// values to begin with.
    ///
    /// # Errors
    /// Those of [`Ranges::new`]; [`Error::BadValue`] for a `spacing` whose
    /// extinction is negative or not finite, or that asks for equal distances in a
    /// view without a far end.
    pub fn new(
        space: Space,
        view: &ViewVolume,
        resolution: Resolution,
        spacing: Spacing,
    ) -> Result<Self, Error> {
        let ranges = Ranges::new(&space, view)?;
        let bounds = crate::spacing::bounds(&space, view, &ranges, spacing, resolution.bits())?;
        // Both ends are unit vectors, or have w = 1: their mean is the middle.
        let middle = |ends: &[Vec2]| {
            let mean = 0.5 * (ends[0] + ends[1]);
            if space.is_directional() {
                mean
            } else {
                mean.normalize()
            }
        };
        let theta_step = ranges.theta_extent() / f64::from(resolution.theta());
        let theta_low = ranges.theta_centre() - 0.5 * ranges.theta_extent();
        let [alpha_low, alpha_high] = ranges.alpha();
        Ok(Self {
            alpha_start: Angle::from_radians(alpha_low),
            alpha_scale: (f64::from(resolution.alpha()) / (alpha_high - alpha_low)) as f32,
            theta_centre: Angle::from_radians(ranges.theta_centre()),
            theta_scale: (1.0 / theta_step) as f32,
            thinnest: if space.is_directional() {
                0.0
            } else {
                let phi = ranges.phi();
                let alpha_step = (alpha_high - alpha_low) / f64::from(resolution.alpha());
                let phi_step = (phi[1] - phi[0]) / f64::from(resolution.bits());
                (2.0 * alpha_step.max(phi_step)) as f32
            },
            guess: Guess::new(&bounds, space.is_directional()),
            light_angles: bounds.windows(2).map(middle).collect(),
            planes: (0..resolution.theta())
                .map(|i| theta_low + (f64::from(i) + 0.5) * theta_step)
                .map(|theta| Angle::from_radians(theta).0)
                .collect(),
            bounds,
            space,
            ranges,
            resolution,
        })
    }

    /// The coordinates that are divided.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// What is divided.
    pub fn ranges(&self) -> &Ranges {
        &self.ranges
    }

    /// Into how many voxels.
    pub fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// The bounds of the voxels along φ, as the pairs of [`Phi`]: one more than
    /// there are bits, in order.
    pub fn bounds(&self) -> &[[f32; 2]] {
        bytemuck::cast_slice(&self.bounds)
    }

    /// The centres of the voxels along φ, as the pairs of [`Phi`]; of length 1
    /// for a light at a point, with w = 1 for a directional one.
    pub fn light_angles(&self) -> &[[f32; 2]] {
        bytemuck::cast_slice(&self.light_angles)
    }

    /// The centres of the voxels along θ, as unit vectors.
    pub fn planes(&self) -> &[[f32; 2]] {
        bytemuck::cast_slice(&self.planes)
    }

    /// Start of the range of α, texels per radian; centre of the range of θ,
    /// texels per radian.
    #[cfg(feature = "wgsl")]
    pub(crate) fn scales(&self) -> (Angle, f32, Angle, f32) {
        (
            self.alpha_start,
            self.alpha_scale,
            self.theta_centre,
            self.theta_scale,
        )
    }

    /// The angle of the thinnest shadow that has voxels, radians; see
    /// [`Lattice::blocked_from`].
    #[cfg(feature = "wgsl")]
    pub(crate) fn thinnest(&self) -> f32 {
        self.thinnest
    }

    /// Whether the first voxel along α begins on the axis towards the light.
    pub fn starts_on_axis(&self) -> bool {
        self.ranges.alpha()[0] == 0.0
    }

    /// The position of an α; below 0 or above the number of texels if it is
    /// outside of the range.
    #[inline(always)]
    pub fn alpha_position(&self, alpha: Angle) -> f32 {
        alpha.relative_to(self.alpha_start) * self.alpha_scale
    }

    /// The position of a θ; below 0 or above the number of texels if it is
    /// outside of a range that does not [wrap](Ranges::wraps).
    #[inline(always)]
    pub fn theta_position(&self, theta: Angle) -> f32 {
        0.5 * self.resolution.theta() as f32
            + theta.relative_to(self.theta_centre) * self.theta_scale
    }

    /// The position of a φ, from 0 to the number of bits; non-decreasing in φ.
    ///
    /// Within a voxel it is the sine of the angle from one bound divided by the
    /// sum of the sines from both, which is the share of the angle to 1e-3 for
    /// 32 bits over half a turn, and better the narrower the voxel. For a
    /// directional light it is the share of the distance.
    #[inline]
    pub fn phi_position(&self, phi: Phi) -> f32 {
        self.phi_position_in(self.guess.cell(phi.0), phi.0)
    }

    /// The cell of a pair, from which [`Lattice::phi_position_in`] starts.
    #[inline(always)]
    pub(crate) fn phi_cell(&self, pair: Vec2) -> usize {
        self.guess.cell(pair)
    }

    /// The position of a φ, whatever the cell, soonest with its own.
    #[inline]
    pub(crate) fn phi_position_in(&self, cell: usize, pair: Vec2) -> f32 {
        let last = self.bounds.len() - 2;
        let guess = self.guess.bound(cell);
        let after = cross(self.bounds[guess + 1], pair) >= 0.0;
        let first = (guess + usize::from(after)).min(last);
        let passed = cross(self.bounds[first], pair);
        let left = cross(pair, self.bounds[first + 1]);
        let found = (first == 0 || passed >= 0.0) && (first == last || left > 0.0);
        if found {
            position_between(first, passed, left)
        } else {
            self.search_phi(pair)
        }
    }

    /// The position of a φ without a guess.
    #[cold]
    pub(crate) fn search_phi(&self, pair: Vec2) -> f32 {
        let mut first = 0;
        let mut count = self.bounds.len() - 1;
        // The last bound at or below φ, the end of the range excluded.
        while count > 1 {
            let half = count / 2;
            let passed = cross(self.bounds[first + half], pair) >= 0.0;
            first += if passed { half } else { 0 };
            count -= half;
        }
        let passed = cross(self.bounds[first], pair);
        position_between(first, passed, cross(pair, self.bounds[first + 1]))
    }

    /// The φ at a position: the inverse of [`Lattice::phi_position`] to 2 ULP
    /// of the position and what the rounding of a pair to f32 is in voxels, 6e-8
    /// rad (of a directional light 6e-8 of the distance) over the width of a
    /// voxel. Positions outside of the range count as its ends.
    #[inline]
    pub fn phi_at(&self, position: f32) -> Phi {
        let bits = self.resolution.bits();
        let position = position.clamp(0.0, bits as f32);
        let first = (position as usize).min(bits as usize - 1);
        let share = f64::from(position - first as f32);
        if share == 0.0 {
            return Phi(self.bounds[first]);
        }
        let [from, to] = [first, first + 1].map(|i| self.bounds[i].as_dvec2());
        Phi::of((from + share * (to - from)).as_vec2())
    }

    /// The α at a position.
    pub fn alpha_at(&self, position: f32) -> Angle {
        Angle::from_radians(
            self.ranges.alpha()[0] + f64::from(position) / f64::from(self.alpha_scale),
        )
    }

    /// The θ at a position.
    pub fn theta_at(&self, position: f32) -> Angle {
        let from_centre = f64::from(position) - 0.5 * f64::from(self.resolution.theta());
        Angle::from_radians(self.ranges.theta_centre() + from_centre / f64::from(self.theta_scale))
    }

    /// The coordinates of the centre of a voxel.
    pub fn centre(&self, alpha: u32, theta: u32, bit: u32) -> Coordinates {
        Coordinates {
            ray: EyeRay {
                alpha: self.alpha_at(alpha as f32 + 0.5),
                theta: self.theta_at(theta as f32 + 0.5),
            },
            phi: Phi::of(self.light_angles[bit as usize]),
        }
    }

    /// The light ray through the centres of all voxels (·, θ, bit).
    ///
    /// # Panics
    /// If the indices are not below those of [`Lattice::resolution`].
    #[inline]
    pub fn light_ray(&self, theta: usize, bit: usize) -> LightRay {
        self.space
            .light_ray_of_units(self.planes[theta], self.light_angles[bit])
    }

    /// The first voxel along α that light does not pass freely if a light ray of
    /// `bit` meets a blocker at `distance` from its origin (metres): the index
    /// from which on all voxels are shadowed.
    ///
    /// 0 if the blocker lies before the range, the number of texels if it lies
    /// behind, is infinite or [`f32::MAX`], or the distance is NaN.
    ///
    /// Light and eye rays that are nearly parallel have next to no shadow between
    /// them: seen from a blocker at distance x from the eye, the light is beside
    /// the eye by at most D/x, where D is the distance between the two. Where that
    /// is less than two voxels the answer is the number of texels, too. The voxel
    /// that holds a blocker is dark, and of an eye ray that ends on it one of n such
    /// voxels is the last part, from n/(n+1) of its length on: with few of them all
    /// rays would lose more light to that than some have in shadows so thin. A light a
    /// few centimetres from the eye so becomes what it is there, a light without
    /// visible shadows.
    #[inline]
    pub fn blocked_from(&self, bit: usize, distance: f32) -> u32 {
        if self.space.is_directional() {
            self.blocked::<true>(self.light_angles[bit], distance)
        } else {
            self.blocked::<false>(self.light_angles[bit], distance)
        }
    }

    /// [`Lattice::blocked_from`] for a light ray of [`Lattice::light_angles`].
    #[inline(always)]
    pub(crate) fn blocked<const DIRECTIONAL: bool>(&self, phi: Vec2, distance: f32) -> u32 {
        let alpha = self.space.alpha_of::<DIRECTIONAL>(phi, distance);
        // The vector of a point light's α is as long as the blocker is away.
        let thin = self.space.distance() < self.thinnest * alpha.length();
        let blocks = (distance.abs() < f32::MAX) & !thin;
        // Negative numbers become 0.
        let index = (self.alpha_position(Angle(alpha)) as u32).min(self.resolution.alpha());
        if blocks {
            index
        } else {
            self.resolution.alpha()
        }
    }

    /// Some of [`Lattice::light_angles`].
    pub(crate) fn units(&self, bits: Range<usize>) -> &[Vec2] {
        &self.light_angles[bits]
    }
}

/// The position between two bounds, from the cross products with both.
#[inline(always)]
fn position_between(first: usize, passed: f64, left: f64) -> f32 {
    let (passed, left) = (passed.max(0.0), left.max(0.0));
    let sum = passed + left;
    let share = if sum > 0.0 { passed / sum } else { 0.5 };
    // In f64, not to be rounded before the sum is.
    (f64::from(first as u32) + share) as f32
}
