//! The light that media emit themselves, which needs no lamp and is added once for each ray.
//!
//! ```text
//! L = ∫ T(x) j(x) dx,      T(x) = exp(−∫₀ˣ σ_t)
//! ```
//!
//! where `j` is the emission of all grids at x. If neither j nor `σ_t` changes along a piece,
//! its light is `j (1 − e^−τ) / σ_t`. Otherwise j is a cubic and the optical depth a polynomial
//! of degree four; then a Gauss rule of four nodes integrates parts of at most half a mean free
//! path, with a relative error of 1e-8.

use glam::DVec3;
use gpu_backend::{Backend, BufferOf, Cpu, Error};

use super::memory::{MediaMemory, MediaOf};
use crate::eye_panes::Behind;
use crate::gather::check_lengths;
use crate::scene::{Media, MediaPiece};
use crate::{EyePanes, Ray};

/// Rays through media that emit light.
#[derive(Debug)]
pub struct EmittingRays<'a, 'm, M: MediaMemory> {
    /// The rays, in the memory of the backend.
    pub rays: &'a M::Buffer<Ray>,
    /// The media that emit and attenuate, in the memory of the backend.
    pub media: &'a MediaOf<'m, M>,
    /// See-through surfaces and hair in front of the ends of the rays; `None` if there are
    /// none.
    pub panes: Option<&'a EyePanes>,
}

/// The step that adds what media emit, beside the gathers of lamps and the light of
/// surfaces.
pub trait AddEmission: Backend<Memory: MediaMemory> {
    /// Adds to the first three components of `radiance[i]` what media emit along
    /// `seen.rays[i]`, as far as the media themselves and the [panes](EmittingRays::panes) let
    /// it through.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length; nothing is written
    /// then. On GPUs also those of a dispatch.
    fn add_emission(
        &self,
        seen: &EmittingRays<'_, '_, Self::Memory>,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

/// Rays in a unit of work.
const RAYS: usize = 16;

impl AddEmission for Cpu {
    fn add_emission(
        &self,
        seen: &EmittingRays<'_, '_, Self::Memory>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(seen.rays.len(), radiance.len())?;
        if !seen.media.emits() {
            return Ok(());
        }
        self.for_each_chunk(radiance, RAYS, |first, chunk| {
            for (i, (sum, ray)) in chunk.iter_mut().zip(&seen.rays[first..]).enumerate() {
                // Rays beyond those that a u32 counts have no panes.
                let panes = seen.panes.map_or(&[][..], |all| all.of((first + i) as u32));
                let light = along(ray, panes, seen.media);
                for (sum, light) in sum.iter_mut().zip(light.to_array()) {
                    *sum += light as f32;
                }
            }
        });
        Ok(())
    }
}

fn along(ray: &Ray, mut panes: &[Behind], media: &Media<'_>) -> DVec3 {
    let direction = ray.direction().as_dvec3().normalize();
    let origin = ray.origin().as_dvec3();
    let mut pieces = media.along(origin, direction, 0.0, ray.length().into());
    let (mut sum, mut seen) = (DVec3::ZERO, DVec3::ONE);
    while let Some(piece) = pieces.advance() {
        if piece.depth_before().min_element() > OPAQUE {
            break;
        }
        if !piece.emits() {
            continue;
        }
        let mut from = piece.start();
        while from < piece.end() {
            while let Some((pane, others)) = panes.split_first()
                && f64::from(pane.from) <= from
            {
                (seen, panes) = (pane.share.as_dvec3(), others);
            }
            let next = panes.first().map(|pane| f64::from(pane.from));
            let to = next.map_or(piece.end(), |next| next.min(piece.end()));
            sum += seen * (-piece.depth_to(from)).exp() * emitted(&piece, [from, to]);
            from = to;
        }
    }
    sum
}

/// Behind this optical depth less than 1e-30 of the light is left, which counts as nothing.
const OPAQUE: f64 = 70.0;

/// The largest growth of the optical depth over a part, and its largest deviation from a
/// straight line in the middle of the part.
const PART_DEPTH: f64 = 0.5;
const PART_BEND: f64 = 0.05;

/// The light that a part of a piece emits, as seen from the start of that part.
fn emitted(piece: &MediaPiece<'_>, [from, to]: [f64; 2]) -> DVec3 {
    let before = piece.own_depth_to(from);
    let depth = piece.own_depth_to(to) - before;
    if piece.is_even() {
        let emission = piece.emission(from);
        let mean = |tau: f64| match tau {
            0.0 => 1.0,
            tau => -(-tau).exp_m1() / tau,
        };
        return emission * (to - from) * depth.map(mean);
    }
    let of_channel = |channel: usize| {
        let own = |x: f64| piece.own_depth_to(x)[channel] - before[channel];
        emitted_through(own, |x| piece.emission(x), [from, to])
    };
    let first = of_channel(0);
    if depth == DVec3::splat(depth.x) {
        return first;
    }
    DVec3::new(first.x, of_channel(1).y, of_channel(2).z)
}

/// ∫ exp(−τ(x)) j(x) dx, as a sum over parts.
fn emitted_through(
    depth: impl Fn(f64) -> f64,
    emission: impl Fn(f64) -> DVec3,
    [from, to]: [f64; 2],
) -> DVec3 {
    let (mut sum, mut start, mut length) = (DVec3::ZERO, from, to - from);
    while start < to {
        let before = depth(start);
        if before > OPAQUE {
            break;
        }
        let mut end = (start + length).min(to);
        loop {
            let (middle, own) = (0.5 * (start + end), depth(end) - before);
            let bend = (depth(middle) - before - 0.5 * own).abs();
            let is_short = own <= PART_DEPTH && bend <= PART_BEND;
            // No float lies between the ends.
            if is_short || !(start < middle && middle < end) {
                break;
            }
            end = middle;
        }
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        for (node, weight) in NODES {
            for x in [middle - half * node, middle + half * node] {
                sum += half * weight * (-depth(x)).exp() * emission(x);
            }
        }
        (length, start) = (2.0 * (end - start), end);
    }
    sum
}

/// The four-node Gauss rule on (−1, 1), as nodes and weights of one half.
const NODES: [(f64, f64); 2] = [
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];
