//! The light rays that curves are made of, and the truth along them.

use lighting::translucent::FaceBlockers;
use reference::curves::{Blocker, transmittances};
use transmittance::{BlockerSegment, Source, Tile};

/// Texels per side of the map whose rays are looked at.
pub(crate) const RESOLUTION: u32 = 256;

/// Along both sides of the map, one ray in this many is looked at.
const STRIDE: usize = 8;

/// Rays are taken until they have this many segments.
const MOST_SEGMENTS: usize = 1 << 21;

/// Depths at which the mean error of a ray is sampled.
const SAMPLES: usize = 128;

/// Ends of segments, per ray, at which the largest error may be.
const MOST_ENDS: usize = 256;

/// Depths of a plotted line.
const PLOTTED: usize = 500;

/// Light rays, each with its blockers in the order in which a map receives them.
#[derive(Debug)]
pub(crate) struct Rays {
    rays: Vec<Ray>,
}

/// One of them.
#[derive(Debug)]
pub(crate) struct Ray {
    pub(crate) segments: Vec<BlockerSegment>,
    /// Depths from the first blocker to the last, evenly spread.
    pub(crate) samples: Vec<f32>,
    pub(crate) sample_truths: Vec<f64>,
    /// Depths just behind the ends of segments.
    pub(crate) ends: Vec<f32>,
    pub(crate) end_truths: Vec<f64>,
}

impl Rays {
    /// At most `most` rays through what a face sees, spread over those that meet
    /// at least a quarter as many blockers as the fullest; `None` if it sees
    /// nothing.
    pub(crate) fn collect(blockers: &FaceBlockers<'_>, most: usize) -> Option<Self> {
        let side = blockers.resolution() as usize;
        let per_row = side.div_ceil(STRIDE);
        let mut found = vec![Vec::new(); per_row * per_row];
        let mut total = 0;
        for first in (0..side).step_by(STRIDE) {
            if total > MOST_SEGMENTS {
                break;
            }
            let tile = Tile {
                x: 0..side,
                y: first..first + 1,
            };
            blockers.segments(&tile, &mut |[x, y], segment| {
                if y == first && x.is_multiple_of(STRIDE) && !segment.is_clear() {
                    found[first / STRIDE * per_row + x / STRIDE].push(segment);
                    total += 1;
                }
            });
        }
        // Rays with few blockers leave a curve nothing to choose.
        let fullest = found.iter().map(Vec::len).max().unwrap_or(0);
        found.retain(|segments| 4 * segments.len() >= fullest.max(1));
        let stride = found.len().div_ceil(most).max(1);
        let kept = found.into_iter().step_by(stride);
        let rays: Vec<Ray> = kept.filter_map(Ray::new).collect();
        (!rays.is_empty()).then_some(Self { rays })
    }

    pub(crate) fn len(&self) -> usize {
        self.rays.len()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Ray> {
        self.rays.iter()
    }

    /// Segments of all rays.
    pub(crate) fn segments(&self) -> usize {
        self.iter().map(|ray| ray.segments.len()).sum()
    }

    /// Depths between which all blockers lie.
    pub(crate) fn range(&self) -> [f32; 2] {
        let all = || self.iter().flat_map(|ray| &ray.segments);
        let near = all()
            .map(BlockerSegment::entry)
            .fold(f32::INFINITY, f32::min);
        let far = all()
            .map(BlockerSegment::exit)
            .fold(f32::NEG_INFINITY, f32::max);
        [near, far]
    }

    /// The ray with most blockers of those that let a twentieth of the light
    /// through, or of all if none does: where it is dark, there is nothing to
    /// be seen of a curve.
    pub(crate) fn shown(&self) -> &Ray {
        let rank = |ray: &Ray| {
            let left = ray.end_truths.last().copied().unwrap_or(1.0);
            (left >= 0.05, ray.segments.len())
        };
        let mut shown = &self.rays[0];
        for ray in &self.rays {
            if rank(ray) > rank(shown) {
                shown = ray;
            }
        }
        shown
    }

    /// Depths from a little in front of that ray's first blocker to a little
    /// behind its last.
    pub(crate) fn plotted_depths(&self) -> Vec<f32> {
        let [near, far] = self.shown().extent();
        let at = |i: usize| near + (far - near) * (1.06 * i as f32 / (PLOTTED - 1) as f32 - 0.03);
        (0..PLOTTED).map(at).collect()
    }
}

impl Ray {
    /// `None` if all blockers are at one depth.
    fn new(segments: Vec<BlockerSegment>) -> Option<Self> {
        let mut ray = Self {
            segments,
            samples: Vec::new(),
            sample_truths: Vec::new(),
            ends: Vec::new(),
            end_truths: Vec::new(),
        };
        let [near, far] = ray.extent();
        if near >= far {
            return None;
        }
        let share = |i: usize| (i as f32 + 0.5) / SAMPLES as f32;
        ray.samples = (0..SAMPLES)
            .map(|i| near + (far - near) * share(i))
            .collect();
        let both = |segment: &BlockerSegment| [segment.entry(), segment.exit()];
        let mut ends: Vec<f32> = ray.segments.iter().flat_map(both).collect();
        ends.sort_by(f32::total_cmp);
        ends.dedup();
        let stride = ends.len().div_ceil(MOST_ENDS).max(1);
        ray.ends = ends.into_iter().step_by(stride).map(f32::next_up).collect();
        ray.sample_truths = ray.truths(&ray.samples);
        ray.end_truths = ray.truths(&ray.ends);
        Some(ray)
    }

    fn extent(&self) -> [f32; 2] {
        let entries = self.segments.iter().map(BlockerSegment::entry);
        let exits = self.segments.iter().map(BlockerSegment::exit);
        [
            entries.fold(f32::INFINITY, f32::min),
            exits.fold(f32::NEG_INFINITY, f32::max),
        ]
    }

    /// The exact transmittance at depths in rising order.
    pub(crate) fn truths(&self, depths: &[f32]) -> Vec<f64> {
        let blockers = self.segments.iter().map(|segment| Blocker {
            entry: segment.entry(),
            exit: segment.exit(),
            optical_depth: segment.optical_depth()[0],
        });
        transmittances(blockers, depths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_the_product_of_all_blockers() {
        let segments = vec![
            BlockerSegment::from_optical_depth(1.0, 3.0, 0.8).unwrap(),
            BlockerSegment::surface(2.0, 0.5).unwrap(),
            BlockerSegment::from_optical_depth(2.5, 2.5, 0.0).unwrap(),
            BlockerSegment::opaque(4.0).unwrap(),
        ];
        let ray = Ray::new(segments).unwrap();
        let found = ray.truths(&[0.0, 1.0, 2.0, 2.0_f32.next_up(), 3.5, 4.0, 5.0]);
        let expected = [1.0, 1.0, (-0.4_f64).exp(), 0.5 * (-0.4_f64).exp()];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6);
        }
        assert!((found[4] - 0.5 * (-0.8_f64).exp()).abs() < 1e-6);
        assert_eq!((found[4], found[6]), (found[5], 0.0));
    }
}
