//! The answers of a shadow volume for an eye ray, and for a point.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013:
//! interpolation (section 3.3 and appendix A), biases and the axis (section 5).
//!
//! Departures. The paper counts bits, which is done here for the lit share of a part of a
//! ray ([`RayShadow::lit_fraction_between`]). Lit intervals and sums with any weights come
//! from the same texels as runs of equal bits, found a word at a time. Towards the light
//! the paper compares distances at the axis itself; here all rays within a part of a voxel
//! of it are treated like this.

use epipolar::{EyeRay, FARTHEST, Lattice, RAYS, RayBlock};
use glam::Vec3;
use gpu_backend::{Host, Memory};

use crate::error::same_resolution;
use crate::runs::Pair;
use crate::{Error, Grid, LitInterval, Run, Runs, Weights};

/// How voxels are looked up.
///
/// The default is right in the air: shadows are neither early nor late on average.
///
/// # Surfaces
///
/// A voxel is in shadow from its edge nearest to the light on, so that a lit surface
/// shadows itself. [`Sampling::PAPER`] pushes shadows two voxels away from it, which is
/// enough where light falls on the surface steeply. On ground that the light or the eye
/// grazes a voxel covers a long stretch of the surface, and no bias in voxels that keeps
/// the shadow at its caster is enough: the ground shows moiré. There, look up the
/// renderer's own shadow map, with the bias that it has anyway, and take the volume for the
/// air alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Added to positions along α, in voxels: negative values look up nearer to
    /// the light and so push shadows away from it, to keep lit surfaces from
    /// shadowing themselves.
    pub alpha_bias: f32,
    /// Added to positions along φ, in voxels: negative values push shadows away
    /// from the eye.
    pub phi_bias: f32,
    /// Rays less than this many voxels (along α) away from the direction to the
    /// light are decided by comparing distances.
    pub axis: f32,
    /// Whether to interpolate linearly: between two texels along θ, and for
    /// points between bits along φ. Never along α, where visibility changes at
    /// blockers only.
    pub interpolate: bool,
}

impl Default for Sampling {
    /// [`Sampling::UNBIASED`].
    fn default() -> Self {
        Self::UNBIASED
    }
}

impl Sampling {
    /// Shadows that are neither early nor late on average. A voxel is in shadow
    /// from its edge nearest to the light on, whereas its blocker lies anywhere
    /// inside: half a voxel too early along α, nothing along φ and θ.
    ///
    /// For light in the air, where a bias is an error; surfaces want
    /// [`Sampling::PAPER`], or they shadow themselves.
    pub const UNBIASED: Self = Self {
        alpha_bias: -0.5,
        phi_bias: 0.0,
        axis: 0.5,
        interpolate: true,
    };

    /// The paper's biases, for surfaces.
    pub const PAPER: Self = Self {
        alpha_bias: -2.25,
        phi_bias: -1.0,
        ..Self::UNBIASED
    };

    /// The voxel that holds a sample, as it is.
    pub const NEAREST: Self = Self {
        alpha_bias: 0.0,
        phi_bias: 0.0,
        axis: 0.0,
        interpolate: false,
    };

    /// # Errors
    /// [`Error::BadValue`] for biases beyond ±1024 voxels, or an axis that is
    /// not 0 to 1024.
    fn checked(self) -> Result<Self, Error> {
        let least = [-1024.0, -1024.0, 0.0];
        let values = [self.alpha_bias, self.phi_bias, self.axis];
        let names = [
            "the bias along alpha",
            "the bias along phi",
            "the width of the axis",
        ];
        for ((value, least), what) in values.into_iter().zip(least).zip(names) {
            if !(value >= least && value <= 1024.0) {
                return Err(Error::BadValue {
                    what,
                    value: f64::from(value),
                    expected: "at most 1024 voxels (a width not negative)",
                });
            }
        }
        Ok(self)
    }
}

/// A grid, or a tile of an atlas, with the lattice that says where its voxels are.
#[derive(Debug)]
pub struct ShadowVolume<'a, M: Memory> {
    lattice: &'a Lattice,
    words: &'a M::Buffer<u32>,
    /// Number of the first of its words.
    first: usize,
    sampling: Sampling,
}

impl<'a, M: Memory> ShadowVolume<'a, M> {
    /// The volume of an extruded `grid`; that of a tile is
    /// [`AtlasGrid::volume`](crate::AtlasGrid::volume).
    ///
    /// # Errors
    /// [`Error::Resolution`] if grid and lattice differ in size,
    /// [`Error::BadValue`] for a bias beyond ±1024 voxels or an axis that is not 0
    /// to 1024 voxels wide.
    pub fn new(lattice: &'a Lattice, grid: &'a Grid<M>, sampling: Sampling) -> Result<Self, Error> {
        same_resolution("a bit grid", lattice.resolution(), grid.resolution())?;
        Self::of_words(lattice, grid.words(), 0, sampling)
    }

    /// The volume whose words begin at `first`, as many as the lattice needs.
    pub(crate) fn of_words(
        lattice: &'a Lattice,
        words: &'a M::Buffer<u32>,
        first: usize,
        sampling: Sampling,
    ) -> Result<Self, Error> {
        Ok(Self {
            lattice,
            words,
            first,
            sampling: sampling.checked()?,
        })
    }

    /// Where the voxels are.
    pub fn lattice(&self) -> &'a Lattice {
        self.lattice
    }

    /// The words that its bits are among, in the order of [`Grid`].
    pub fn words(&self) -> &'a M::Buffer<u32> {
        self.words
    }

    /// Number of the first of its words: 0, but for tiles of an atlas.
    pub fn first_word(&self) -> usize {
        self.first
    }

    /// How they are looked up.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }
}

impl<'a> ShadowVolume<'a, Host> {
    /// The shadow along the eye ray into `direction` (of any length), up to the
    /// first surface at the distance `surface` in metres (+∞ for the sky; less
    /// than 0 or NaN counts as 0).
    ///
    /// What lies outside of the lattice's ranges is as visible as the nearest voxel;
    /// so is what lies before its near distance. If only a part of the ray matters,
    /// give the surface nevertheless and cut the intervals.
    ///
    /// On the axis: looking at the light, the ray is lit if `surface` lies behind
    /// the light, and dark otherwise, because then the surface is between eye
    /// and light; looking away from it, all of the ray is as lit as the eye.
    #[inline]
    pub fn ray_shadow(&self, direction: impl Into<[f32; 3]>, surface: f32) -> RayShadow<'a> {
        let space = self.lattice.space();
        let ray = space.ray(direction);
        let surface = surface.max(0.0);
        let end = self.lattice.phi_position(space.phi_along(&ray, surface));
        let alpha = self.lattice.alpha_position(ray.alpha);
        let theta = self.lattice.theta_position(ray.theta);
        let texels = self.texels([alpha, theta], surface);
        self.shadow_of(texels, ray, surface, end)
    }

    /// [`ShadowVolume::ray_shadow`] of many rays, for less time: calls `each`
    /// with the number and the shadow of each ray, in order. Rays are a direction of any
    /// length and, as the fourth number, the distance of the surface in metres.
    ///
    /// What binds is the reading of the runs, with a branch that is hard to foresee at the end
    /// of each, and the cache miss of a texel that no neighbour has read. Where their intervals
    /// are asked for, [`ShadowVolume::lit_intervals`] takes 0.8 to 0.9 of the time.
    #[inline]
    pub fn ray_shadows(&self, rays: &[[f32; 4]], mut each: impl FnMut(usize, RayShadow<'a>)) {
        let mut block = RayBlock::default();
        let mut number = 0;
        for rays in rays.chunks(RAYS) {
            self.lattice.locate_rays(rays, &mut block);
            for i in 0..rays.len() {
                let surface = block.surface(i);
                let positions = [block.alpha_position(i), block.theta_position(i)];
                let texels = self.texels(positions, surface);
                let shadow = self.shadow_of(texels, block.ray(i), surface, block.end(i));
                each(number, shadow);
                number += 1;
            }
        }
    }

    #[inline]
    pub(crate) fn shadow_of(
        &self,
        texels: Texels<'a>,
        ray: EyeRay,
        surface: f32,
        end: f32,
    ) -> RayShadow<'a> {
        RayShadow {
            lattice: self.lattice,
            texels,
            phi_bias: self.sampling.phi_bias,
            interpolate: self.sampling.interpolate,
            ray,
            surface,
            end,
        }
    }

    /// The visibility of the light from a visible point of a surface, in
    /// [0, 1]. [`Sampling`] says which bias surfaces need, and where none is enough. A point
    /// that is not finite counts as one in the direction of the light.
    pub fn visibility(&self, point: impl Into<[f32; 3]>) -> f32 {
        let point = Vec3::from(point.into());
        let space = self.lattice.space();
        let place = space.coordinates(point);
        let surface = (point - Vec3::from(space.eye())).length();
        let alpha = self.lattice.alpha_position(place.ray.alpha);
        let theta = self.lattice.theta_position(place.ray.theta);
        let texels = self.texels([alpha, theta], surface);
        let position = self.lattice.phi_position(place.phi);
        sample(texels, position, self.sampling)
    }

    /// The texels of a ray, from its positions along α and θ.
    #[inline]
    pub(crate) fn texels(&self, [alpha, theta]: [f32; 2], surface: f32) -> Texels<'a> {
        let resolution = self.lattice.resolution();
        if self.lattice.starts_on_axis() && alpha < self.sampling.axis {
            return Texels::Axis {
                lit: surface >= self.lattice.space().distance().min(FARTHEST),
            };
        }
        let highest = (resolution.alpha() - 1) as f32;
        let row = (alpha + self.sampling.alpha_bias).clamp(0.0, highest) as u32;
        let planes = resolution.theta();
        let (first, second, share) = if self.sampling.interpolate {
            let (below, share) = split(theta - 0.5, planes);
            (
                self.plane(below, planes),
                self.plane(below + 1, planes),
                share,
            )
        } else {
            let plane = self.plane(split(theta, planes).0, planes);
            (plane, plane, 0.0)
        };
        Texels::Pair(Pair {
            first: self.texel(row, first),
            second: self.texel(row, second),
            share,
        })
    }

    /// The words of a texel.
    #[inline]
    fn texel(&self, alpha: u32, theta: u32) -> &'a [u32] {
        let resolution = self.lattice.resolution();
        let words = resolution.words_per_texel();
        let texel = alpha as usize * resolution.theta() as usize + theta as usize;
        let start = self.first + texel * words;
        &self.words[start..start + words]
    }

    /// The plane of a number that is one turn outside at most.
    #[inline]
    fn plane(&self, index: i32, planes: u32) -> u32 {
        let turn = planes as i32;
        let inside = if !self.lattice.ranges().wraps() {
            index
        } else if index < 0 {
            index + turn
        } else if index >= turn {
            index - turn
        } else {
            index
        };
        // Both bounds are numbers of planes.
        inside.clamp(0, turn - 1) as u32
    }
}

/// The whole number below a position and what is left, positions far outside
/// of `0..count` brought closer. Without [`f32::floor`], which is a function call
/// on processors of the lowest common denominator.
#[inline]
fn split(position: f32, count: u32) -> (i32, f32) {
    let shifted = position.clamp(-1.0, count as f32) + 1.0;
    let below = shifted as i32;
    (below - 1, shifted - below as f32)
}

/// Where the visibility of a ray is found.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Texels<'a> {
    /// Nowhere: it was decided by distances.
    Axis {
        lit: bool,
    },
    Pair(Pair<'a>),
}

/// The words that stand for a ray on the axis.
static LIT: [u32; 1] = [0];
static DARK: [u32; 1] = [u32::MAX];

impl<'a> Texels<'a> {
    fn pair(self) -> Pair<'a> {
        match self {
            Self::Pair(pair) => pair,
            Self::Axis { lit } => {
                let texel = if lit { &LIT } else { &DARK };
                Pair {
                    first: texel,
                    second: texel,
                    share: 0.0,
                }
            }
        }
    }
}

/// The visibility at a position along φ.
fn sample(texels: Texels<'_>, position: f32, sampling: Sampling) -> f32 {
    let texels = texels.pair();
    let bits = 32 * texels.first.len() as u32;
    let position = position + sampling.phi_bias;
    if !sampling.interpolate {
        return texels.visibility_at(position);
    }
    let (below, share) = split(position - 0.5, bits);
    let highest = bits as i32 - 1;
    let [a, b] = [below, below + 1].map(|bit| texels.visibility(bit.clamp(0, highest) as u32));
    a + share * (b - a)
}

/// The shadow along an eye ray: one texel, or two between which is
/// interpolated.
#[derive(Debug, Clone, Copy)]
pub struct RayShadow<'a> {
    lattice: &'a Lattice,
    texels: Texels<'a>,
    phi_bias: f32,
    interpolate: bool,
    ray: EyeRay,
    surface: f32,
    /// The position along φ of the surface.
    end: f32,
}

impl<'a> RayShadow<'a> {
    /// The ray's coordinates.
    pub fn ray(&self) -> EyeRay {
        self.ray
    }

    /// The position along φ at which the ray meets its surface, in voxels.
    pub fn end(&self) -> f32 {
        self.end
    }

    /// Runs of equally visible voxels up to the surface.
    #[inline]
    pub fn runs(&self) -> Runs<'a> {
        match self.texels {
            Texels::Pair(pair) => Runs::new(pair, self.phi_bias, self.end),
            // One word for all bits.
            Texels::Axis { .. } => Runs::new(self.texels.pair(), f32::NEG_INFINITY, self.end),
        }
    }

    /// The visibility at a distance from the eye, in [0, 1].
    pub fn visibility(&self, distance: f32) -> f32 {
        let distance = distance.max(0.0);
        let phi = self.lattice.space().phi_along(&self.ray, distance);
        let sampling = Sampling {
            phi_bias: self.phi_bias,
            interpolate: self.interpolate,
            ..Sampling::NEAREST
        };
        sample(self.texels, self.lattice.phi_position(phi), sampling)
    }

    /// The share of the voxels up to the surface that are lit, in [0, 1]: the
    /// paper's average visibility. For a ray without a voxel the visibility of its
    /// start.
    pub fn lit_fraction(&self) -> f32 {
        let mut lit = 0.0;
        for run in self.runs() {
            if self.end == 0.0 {
                return run.visibility;
            }
            lit += run.visibility * (run.end - run.start);
        }
        if self.end > 0.0 {
            (lit / self.end).min(1.0)
        } else {
            0.0
        }
    }

    /// The sum of the weights of the lit voxels up to the surface, parts of
    /// a voxel in proportion. The rounding error is a few ULP of the sum of all
    /// weights before the surface.
    ///
    /// # Panics
    /// If there are not as many weights as bits per texel.
    pub fn weighted_sum(&self, weights: &Weights) -> f32 {
        let bits = self.lattice.resolution().bits() as usize;
        assert_eq!(weights.sums().len(), bits + 1, "one weight per bit");
        self.runs()
            .map(|run| run.visibility * (weights.before(run.end) - weights.before(run.start)))
            .sum()
    }

    /// The position along φ at which the ray has gone a distance, in voxels; at
    /// most that of its surface.
    #[inline]
    pub fn position(&self, distance: f32) -> f32 {
        let phi = self.lattice.space().phi_along(&self.ray, distance.max(0.0));
        self.lattice.phi_position(phi).min(self.end)
    }

    /// The share of the voxels between two distances that are lit, in [0, 1]; if
    /// there is no voxel between them the visibility at the first.
    pub fn lit_fraction_between(&self, start: f32, end: f32) -> f32 {
        let (from, to) = (self.position(start), self.position(end));
        let texels = match self.texels {
            Texels::Axis { lit } => return if lit { 1.0 } else { 0.0 },
            Texels::Pair(pair) => pair,
        };
        if from < to {
            (texels.lit_length(self.phi_bias, from, to) / (to - from)).min(1.0)
        } else {
            texels.visibility_at(from + self.phi_bias)
        }
    }

    /// The lit parts of the ray from the eye to the surface: in order, not
    /// overlapping; neighbours that touch differ in visibility.
    #[inline]
    pub fn lit_runs(&self) -> impl Iterator<Item = LitInterval> + use<'a> {
        self.intervals(self.runs())
    }

    /// The same, voxel by voxel: one part for each that is lit.
    #[inline]
    pub fn lit_voxels(&self) -> impl Iterator<Item = LitInterval> + use<'a> {
        let bias = self.phi_bias;
        let voxels = move |run: Run| {
            let mut start = run.start;
            let mut border = (start + bias).floor() + 1.0;
            std::iter::from_fn(move || {
                // A border may be rounded down to where the run starts.
                while border - bias <= start && start < run.end {
                    border += 1.0;
                }
                let voxel = Run {
                    start,
                    end: run.end.min(border - bias),
                    ..run
                };
                start = voxel.end;
                (voxel.start < voxel.end).then_some(voxel)
            })
        };
        // A ray on the axis has one run of no length, and no voxels.
        let undivided = self.end == 0.0 || matches!(self.texels, Texels::Axis { .. });
        let whole = self.runs().filter(move |_| undivided);
        let divided = self.runs().filter(move |_| !undivided).flat_map(voxels);
        self.intervals(whole.chain(divided))
    }

    /// Appends [`RayShadow::lit_runs`] to `lit`.
    #[inline]
    pub fn lit_intervals(&self, lit: &mut Vec<LitInterval>) {
        lit.extend(self.lit_runs());
    }

    /// Where runs begin and end.
    #[inline]
    fn intervals<I>(&self, runs: I) -> impl Iterator<Item = LitInterval> + use<'a, I>
    where
        I: Iterator<Item = Run>,
    {
        let Self {
            lattice,
            ray,
            surface,
            end,
            ..
        } = *self;
        let distance = move |position: f32| {
            let phi = lattice.phi_at(position);
            lattice.space().distance_along(&ray, phi).min(surface)
        };
        // Where the last run ended, as a position and as a distance.
        let (mut last, mut reached) = (0.0, 0.0_f32);
        runs.map(move |run| {
            let start = if run.start == last {
                reached
            } else {
                // Positions that all but coincide may be rounded past each other.
                distance(run.start).max(reached)
            };
            let to = if run.end < end {
                distance(run.end)
            } else {
                surface
            };
            last = run.end;
            reached = to.max(start);
            LitInterval {
                start,
                end: reached,
                visibility: run.visibility,
            }
        })
        // A ray on the axis of a sun never comes to its second voxel; `f32::MAX` may stand for the
        // distance of the sky.
        .filter(|part| part.start < f32::MAX)
    }
}
