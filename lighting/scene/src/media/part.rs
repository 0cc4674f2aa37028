//! One medium on one piece of a line.

use glam::DVec3;

use super::{Ball, depth};
use crate::cubic::Cubic;
use crate::{CellSpan, DensityGrid, HeightFog, Interpolation, Medium, PhaseFunction};

/// What a medium does to light at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattering {
    /// Extinction coefficient, 1/m.
    pub extinction: DVec3,
    /// Scattering coefficient, 1/m.
    pub scattering: DVec3,
    /// Emitted radiance per metre, 1/m of radiance.
    pub emission: DVec3,
    /// How scattered light spreads over directions.
    pub phase: PhaseFunction,
}

/// One medium on one [piece](super::MediaPiece) of a line.
#[derive(Debug, Clone, Copy)]
pub struct MediaPart<'a> {
    profile: Along,
    /// Extinction and scattering where the profile is 1, without the albedo of samples.
    extinction: DVec3,
    scattering: DVec3,
    phase: PhaseFunction,
    is_smoke: bool,
    /// The grid and the span of a cell, if samples have an albedo or an emission.
    samples: Option<(&'a DensityGrid, CellSpan)>,
}

/// How a coefficient changes along a piece.
#[derive(Debug, Clone, Copy)]
enum Along {
    Cubic(Cubic),
    /// From the height `y`, rising by `slope` per metre.
    Height {
        fog: HeightFog,
        y: f64,
        slope: f64,
    },
}

impl<'a> MediaPart<'a> {
    pub(super) fn even(medium: &Medium) -> Self {
        Self {
            profile: Along::Cubic(Cubic::constant(1.0)),
            extinction: medium.sigma_t().as_dvec3(),
            scattering: medium.sigma_s().as_dvec3(),
            phase: medium.phase(),
            is_smoke: false,
            samples: None,
        }
    }

    pub(super) fn height(fog: &HeightFog, y: f64, slope: f64) -> Self {
        Self {
            profile: Along::Height {
                fog: *fog,
                y,
                slope,
            },
            extinction: fog.sigma_t().as_dvec3(),
            scattering: fog.sigma_s().as_dvec3(),
            phase: fog.phase(),
            is_smoke: false,
            samples: None,
        }
    }

    pub(super) fn cell(grid: &'a DensityGrid, span: CellSpan) -> Self {
        let has_samples = !(grid.albedo_samples().is_empty() && grid.emission().is_empty());
        let extinction = grid.tint().as_dvec3();
        // The albedo of samples is multiplied by that of the grid.
        let albedo = match grid.albedo_samples() {
            [] => grid.albedo().as_dvec3(),
            _ => DVec3::ONE,
        };
        Self {
            profile: Along::Cubic(grid.cubic(&span)),
            extinction,
            scattering: albedo * extinction,
            phase: grid.phase(),
            is_smoke: true,
            samples: has_samples.then_some((grid, span)),
        }
    }

    /// The part of a ball between `from` and `to`, where the chord extends `half` on either
    /// side of `middle`.
    pub(super) fn ball(ball: &Ball<'_>, half: f64, middle: f64, from: f64, to: f64) -> Self {
        Self {
            profile: Along::Cubic(ball.cubic(half, middle, from, to)),
            extinction: DVec3::ONE,
            scattering: ball.of.albedo().as_dvec3(),
            phase: ball.of.phase(),
            is_smoke: true,
            samples: None,
        }
    }

    /// How scattered light spreads over directions.
    pub fn phase(&self) -> PhaseFunction {
        self.phase
    }

    /// True if it is a grid or a particle.
    pub(super) fn is_smoke(&self) -> bool {
        self.is_smoke
    }

    /// True if it emits light of its own.
    pub(super) fn emits(&self) -> bool {
        self.samples
            .is_some_and(|(grid, _)| !grid.emission().is_empty())
    }

    /// True if neither its extinction nor its emission changes along the piece.
    pub(super) fn is_even(&self) -> bool {
        let is_voxel = |grid: &DensityGrid| grid.interpolation() == Interpolation::Constant;
        let has_even_density = match self.profile {
            Along::Cubic(Cubic([first, rest @ ..])) => rest == [first; 3],
            Along::Height { .. } => self.extinction == DVec3::ZERO,
        };
        has_even_density && (!self.emits() || self.samples.is_none_or(|(grid, _)| is_voxel(grid)))
    }

    /// True if it has neither extinction nor emission.
    pub(super) fn is_nothing(&self) -> bool {
        let has_no_density = match self.profile {
            Along::Cubic(cubic) => cubic.0 == [0.0; 4],
            Along::Height { .. } => false,
        };
        (has_no_density || self.extinction == DVec3::ZERO) && !self.emits()
    }

    /// The coefficients at `x` metres behind the start of a piece of `length`.
    pub(super) fn at(&self, x: f64, length: f64) -> Scattering {
        let share = share(x, length);
        let profile = match self.profile {
            Along::Cubic(cubic) => cubic.value(share),
            Along::Height { fog, y, slope } => fog.density(y + slope * x),
        };
        let mut point = Scattering {
            extinction: depth(self.extinction, profile),
            scattering: depth(self.scattering, profile),
            emission: DVec3::ZERO,
            phase: self.phase,
        };
        if let Some((grid, span)) = self.samples {
            let place = span.place(share);
            if !grid.albedo_samples().is_empty() {
                point.scattering *= grid.albedo_in(span.cell, place);
            }
            point.emission = grid.emission_in(span.cell, place);
        }
        point
    }

    /// The share of its extinction that is scattering, at `x` metres behind the start of a
    /// piece of `length`; 0 in channels without extinction.
    pub(super) fn albedo(&self, x: f64, length: f64) -> DVec3 {
        let mut albedo = DVec3::select(
            self.extinction.cmpgt(DVec3::ZERO),
            self.scattering / self.extinction,
            DVec3::ZERO,
        );
        if let Some((grid, span)) = self.samples
            && !grid.albedo_samples().is_empty()
        {
            albedo *= grid.albedo_in(span.cell, span.place(share(x, length)));
        }
        albedo
    }

    /// The optical depth of the first `x` metres of a piece of `length`.
    pub(super) fn depth_to(&self, x: f64, length: f64) -> DVec3 {
        let profile = match self.profile {
            // An endless piece contains homogeneous fog alone.
            Along::Cubic(cubic) => cubic.up_to(share(x, length)).mean() * x,
            Along::Height { fog, y, slope } => fog.column(y, slope, x),
        };
        depth(self.extinction, profile)
    }
}

fn share(x: f64, length: f64) -> f64 {
    if length.is_finite() { x / length } else { 0.0 }
}
