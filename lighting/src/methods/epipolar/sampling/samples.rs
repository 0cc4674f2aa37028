//! The samples of a line.

use glam::DVec2;

use super::lines::{Area, Line};
use super::surfaces::Surfaces;

/// Pixels from one sample of a line to the next, at most, as a share of the distance
/// from the epipole: the light of a lamp changes there as one over that distance, which
/// linear interpolation meets to 1/8 of the square of this share.
const OF_RADIUS: f64 = 0.125;

/// Pixels around the epipole that are gathered by themselves: lines a pixel apart blur
/// there what a cookie or a caster next to a lamp draws.
const AROUND: f64 = 16.0;

/// Pixels on both sides of a discontinuity that take the light of the sample beside it.
const REACH: f32 = 2.5;

/// A resemblance at which nothing better is looked for.
const ENOUGH: f32 = 0.5;

/// Pixels by which a line is sampled beyond where it is needed.
const MARGIN: f64 = 2.0;

/// How far apart lines and samples are, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spacing {
    /// From line to line at the border of the picture.
    pub(super) lines: f64,
    /// From sample to sample of a line, where nothing is discontinuous.
    pub(super) samples: f64,
}

impl Spacing {
    /// Pixels to the next sample at a distance from the epipole; 1 or less where pixels
    /// are gathered by themselves.
    pub(super) fn at(&self, radius: f64) -> f64 {
        match radius < AROUND {
            true => 1.0,
            false => self.samples.min(OF_RADIUS * radius),
        }
    }
}

/// A point of a line at which light is gathered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Its distance from the border, pixels.
    pub(super) distance: f32,
    pub(super) pixel: u32,
    /// Whether a discontinuity is between it and the next.
    pub(super) is_last_of_surface: bool,
}

/// A line and its samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SampledLine {
    pub(super) line: Line,
    pub(super) samples: Vec<Sample>,
}

/// Light between the sample `index` of a line and the next, and how much what is seen
/// there is like what a pixel sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tap {
    pub(super) index: usize,
    pub(super) along: f32,
    pub(super) resemblance: f32,
}

/// The pixel of a point of the area.
pub(super) fn pixel_at(point: DVec2, area: Area) -> [u32; 2] {
    std::array::from_fn(|i| {
        let last = area.size[i] - 1;
        // Saturates at 0.
        area.from[i] + (point[i] as u32).min(last)
    })
}

impl SampledLine {
    /// Samples along `line` as far as points of at least `share` of its distance from
    /// the epipole need them: at a regular spacing, and on both sides of every
    /// discontinuity between those. All are at whole pixels from the border.
    pub(super) fn new(
        surfaces: &Surfaces<'_>,
        area: Area,
        line: Line,
        (spacing, share): (Spacing, f64),
    ) -> Self {
        let columns = surfaces.inputs().size[0];
        let sample = |distance: u32, [x, y]: [u32; 2], is_last_of_surface| Sample {
            distance: distance as f32,
            pixel: y * columns + x,
            is_last_of_surface,
        };
        let mut length = line.length;
        if line.radius.is_finite() {
            length = length.min(line.radius * (1.0 - share) + MARGIN);
        }
        let at = |distance: u32| pixel_at(line.at(distance.into()), area);
        // The last point that was looked at, and the last that is a sample.
        let (mut here, mut since) = (0, 0);
        let mut samples = vec![sample(0, at(0), false)];
        while here < length as u32 {
            let next = here + 1;
            let spacing = spacing.at(line.radius - f64::from(since));
            if surfaces.is_edge(at(here), at(next)) {
                match samples.last_mut() {
                    Some(last) if since == here => last.is_last_of_surface = true,
                    _ => samples.push(sample(here, at(here), true)),
                }
                samples.push(sample(next, at(next), false));
                since = next;
            } else if f64::from(next - since + 1) > spacing || next == length as u32 {
                samples.push(sample(next, at(next), false));
                since = next;
            }
            if since == next && spacing <= 1.0 {
                // From here on pixels are gathered by themselves.
                break;
            }
            here = next;
        }
        Self { line, samples }
    }

    /// What the line says of a pixel whose middle is at `point` of the area.
    pub(super) fn tap(
        &self,
        surfaces: &Surfaces<'_>,
        area: Area,
        (point, pixel): (DVec2, usize),
    ) -> Tap {
        let samples = &self.samples;
        // Pixels at the border may lie before all samples.
        let distance = self.line.closest(point).max(0.0) as f32;
        let index = samples.partition_point(|sample| sample.distance <= distance);
        let index = index.saturating_sub(1);
        let here = samples[index];
        let next = samples.get(index + 1);
        let of_sample = |index: usize| Tap {
            index,
            along: 0.0,
            resemblance: match (samples[index].distance - distance).abs() <= REACH {
                true => surfaces.resemblance(pixel, samples[index].pixel as usize),
                false => 0.0,
            },
        };
        let mut best = match next {
            Some(next) if !here.is_last_of_surface => {
                let along = (distance - here.distance) / (next.distance - here.distance);
                // One of the points that the search for discontinuities looked at.
                let [x, y] = pixel_at(self.line.at(distance.round().into()), area);
                let there = (y * surfaces.inputs().size[0] + x) as usize;
                Tap {
                    index,
                    along: along.clamp(0.0, 1.0),
                    resemblance: surfaces.resemblance(pixel, there),
                }
            }
            _ => of_sample(index),
        };
        if best.resemblance < ENOUGH {
            // The pixel may lie beyond a discontinuity that the line meets further on,
            // or has met.
            let others = [
                here.is_last_of_surface.then_some(index + 1),
                index
                    .checked_sub(1)
                    .filter(|i| samples[*i].is_last_of_surface),
                next.filter(|next| next.is_last_of_surface)
                    .map(|_| index + 2),
            ];
            for other in others.into_iter().flatten() {
                if other < samples.len() {
                    let other = of_sample(other);
                    if other.resemblance > best.resemblance {
                        best = other;
                    }
                }
            }
        }
        best
    }
}
