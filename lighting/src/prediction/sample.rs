//! The pixels that represent a picture.

use gpu_backend::Cpu;

use crate::scene::Medium;
use crate::{Emitter, LightPath, Ray};

/// Pixels in a segment, which are neighbours in a row. This is half of what a backend takes at
/// once, so that their rays are as coherent as those of a whole picture.
const SEGMENT: u32 = 32;

/// One segment in so many is in the smaller of the two samples for timing.
const SMALLER: usize = 4;

/// Some pixels of a picture, in segments that are spread over it evenly. They depend on the
/// size of the picture alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sample {
    pixels: Vec<u32>,
    /// For each segment, the index of its first pixel in `pixels`, and then the end of the last
    /// segment, behind which are the pixels nearest to lights.
    starts: Vec<usize>,
    total: usize,
}

impl Sample {
    /// About `most` pixels of a picture; all of them, if these are no more than twice as many.
    pub fn new([width, height]: [u32; 2], most: usize) -> Self {
        let total = width as usize * height as usize;
        let mut sample = Self {
            pixels: Vec::new(),
            starts: vec![0],
            total,
        };
        if total <= most.saturating_mul(2) {
            for row in 0..height {
                for first in (0..width).step_by(SEGMENT as usize) {
                    sample.push(row * width + first, SEGMENT.min(width - first));
                }
            }
            return sample;
        }
        let length = SEGMENT.min(width);
        let segments = (most / length as usize).max(1);
        let square = (segments as f64 * f64::from(width) / f64::from(height)).sqrt();
        let columns = (square as u32).clamp(1, (width / length).min(segments as u32));
        let rows = (segments as u32 / columns).clamp(1, height);
        for row in 0..rows {
            let [top, bottom] = [row, row + 1].map(|edge| cut(height, edge, rows));
            // In each row of cells, no two segments are in the same row of pixels.
            let mut cells: Vec<u32> = (0..columns)
                .map(|column| {
                    let [left, right] = [column, column + 1].map(|edge| cut(width, edge, columns));
                    let cell = u64::from(row * columns + column);
                    let x = left + below(right - left - length + 1, 2 * cell);
                    let y = top + below(bottom - top, 2 * cell + 1);
                    y * width + x
                })
                .collect();
            cells.sort_unstable();
            for first in cells {
                sample.push(first, length);
            }
        }
        sample
    }

    /// Adds the `number` pixels whose rays pass lights most closely. Methods that take steps
    /// have a large part of their error there, because light falls off with the square of the
    /// distance. These pixels represent only themselves.
    ///
    /// Cost: one operation for each ray and point light. A light whose range or cone the ray
    /// misses does not count.
    #[must_use]
    pub fn with_nearest(mut self, rays: &[Ray], emitters: &[Emitter], number: usize) -> Self {
        if self.is_whole() {
            return self;
        }
        let bright = Cpu::new().map(rays.len(), |index| brightness(&rays[index], emitters));
        let mut nearest: Vec<(f32, u32)> = (bright.into_iter().zip(0..))
            .filter(|(brightness, _)| *brightness > 0.0)
            .collect();
        let number = number.min(nearest.len());
        if number == 0 {
            return self;
        }
        let order = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        nearest.select_nth_unstable_by(number - 1, order);
        let mut nearest: Vec<u32> = nearest[..number].iter().map(|(_, pixel)| *pixel).collect();
        nearest.sort_unstable();
        let mut others = Self {
            pixels: Vec::new(),
            starts: vec![0],
            total: self.total,
        };
        for segment in 0..self.segments() {
            let own = self.segment(segment).map(|place| self.pixels[place]);
            let far = own.filter(|pixel| nearest.binary_search(pixel).is_err());
            others.pixels.extend(far);
            others.starts.push(others.pixels.len());
        }
        self = others;
        self.pixels.extend(nearest);
        self
    }

    fn push(&mut self, first: u32, length: u32) {
        self.pixels.extend(first..first + length);
        self.starts.push(self.pixels.len());
    }

    /// The indices of the pixels, row by row from the top: first those of the segments, then
    /// those nearest to lights.
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// The pixels of a quarter of the segments, for timing.
    pub fn smaller(&self) -> Vec<u32> {
        let first = (SMALLER / 2).min(self.segments().saturating_sub(1));
        let segments = (first..self.segments()).step_by(SMALLER);
        segments
            .flat_map(|segment| self.segment(segment))
            .map(|place| self.pixels[place])
            .collect()
    }

    /// Whether the sample is the whole picture.
    pub fn is_whole(&self) -> bool {
        self.pixels.len() == self.total
    }

    /// Number of pixels of the picture.
    pub fn of(&self) -> usize {
        self.total
    }

    fn segments(&self) -> usize {
        self.starts.len() - 1
    }

    fn segment(&self, index: usize) -> std::ops::Range<usize> {
        self.starts[index]..self.starts[index + 1]
    }

    /// The range in `pixels` of those nearest to lights.
    fn nearest(&self) -> std::ops::Range<usize> {
        self.starts[self.segments()]..self.pixels.len()
    }
}

/// The sum over the lights of the irradiance at the point of the ray that is nearest to the
/// light.
fn brightness(ray: &Ray, emitters: &[Emitter]) -> f32 {
    let of = |emitter: &Emitter| {
        let Emitter::Point(light) = emitter else {
            return 0.0;
        };
        if LightPath::new(ray, emitter, &Medium::VACUUM).is_none() {
            return 0.0;
        }
        let to_light = light.position() - ray.origin();
        let along = to_light.dot(ray.direction()).clamp(0.0, ray.length());
        let distance = (to_light - along * ray.direction()).length_squared();
        light.intensity().element_sum() / distance.max(1e-12 * to_light.length_squared())
    };
    let sum: f32 = emitters.iter().map(of).sum();
    // A ray that starts at a light counts as dark: all rays from that eye are equally near to
    // it.
    if sum.is_finite() { sum } else { 0.0 }
}

/// Start of part number `edge` if a length is divided into `parts` parts.
fn cut(length: u32, edge: u32, parts: u32) -> u32 {
    (u64::from(length) * u64::from(edge) / u64::from(parts)) as u32
}

/// A pseudo-random number below `count`, which must not be 0: the finaliser of SplitMix64
/// (Steele, Lea and Flood, OOPSLA 2014).
fn below(count: u32, index: u64) -> u32 {
    let mut x = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((((x ^ (x >> 31)) >> 32) * u64::from(count)) >> 32) as u32
}

/// The reference radiance of some of a sample's pixels.
#[derive(Debug, Clone)]
pub struct Judged {
    segments: Vec<Segment>,
    nearest: Segment,
    /// The share of the picture's pixels that are in `nearest`.
    share: f64,
    number: usize,
    is_whole: bool,
}

/// The pixels of a segment whose truth is known.
#[derive(Debug, Clone, Default)]
pub(super) struct Segment {
    /// Indices in the sample, rising within each of the two rounds.
    pub(super) places: Vec<usize>,
    pub(super) truth: Vec<[f64; 3]>,
}

/// The least number of pixels that a segment gets in the second round, as a share of the mean
/// number: light that does not vary between a few pixels may vary between others.
const LEAST: f64 = 0.2;

impl Judged {
    /// Asks `truth` for the reference radiance of about `most` pixels of a sample, at least
    /// one, in addition to those nearest to lights. Half of them are at equal distances, the
    /// others in the segments where these differ most from their neighbours.
    ///
    /// # Errors
    /// Those of `truth`.
    pub fn new<E>(
        sample: &Sample,
        most: usize,
        mut truth: impl FnMut(&[u32]) -> Result<Vec<[f64; 3]>, E>,
    ) -> Result<Self, E> {
        let mut segments = vec![Segment::default(); sample.segments()];
        let number = sample.starts[sample.segments()];
        if most >= number {
            ask(sample, &mut segments, &mut truth, |segment| {
                sample.segment(segment).collect()
            })?;
        } else {
            let each = (most / 2 / sample.segments().max(1)).max(1);
            let apart = (sample.segments() as f64 / most as f64).max(1.0);
            // With fewer pixels than segments, some segments have none.
            let has_any = |segment: usize| {
                ((segment as f64 / apart) as usize as f64 * apart).ceil() as usize == segment
            };
            ask(sample, &mut segments, &mut truth, |segment| {
                match has_any(segment) {
                    true => spread(&sample.segment(segment).collect::<Vec<_>>(), each, segment),
                    false => Vec::new(),
                }
            })?;
            let left = most.saturating_sub(each * sample.segments());
            if left > 0 {
                let shares = shares(&segments, left);
                let first = segments.clone();
                ask(sample, &mut segments, &mut truth, |segment| {
                    let mut free: Vec<usize> = sample.segment(segment).collect();
                    free.retain(|place| !first[segment].places.contains(place));
                    spread(&free, shares[segment], segment)
                })?;
            }
        }
        segments.retain(|segment| !segment.places.is_empty());
        let mut nearest = [Segment::default()];
        ask(sample, &mut nearest, &mut truth, |_| {
            sample.nearest().collect()
        })?;
        let [nearest] = nearest;
        Ok(Self {
            share: nearest.places.len() as f64 / sample.total.max(1) as f64,
            number: (segments.iter().chain([&nearest]))
                .map(|segment| segment.places.len())
                .sum(),
            is_whole: sample.is_whole() && most >= number,
            segments,
            nearest,
        })
    }

    /// Number of pixels whose truth is known.
    pub fn number(&self) -> usize {
        self.number
    }

    pub(super) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The pixels nearest to lights, and their share of the picture.
    pub(super) fn nearest(&self) -> (&Segment, f64) {
        (&self.nearest, self.share)
    }

    pub(super) fn is_whole(&self) -> bool {
        self.is_whole
    }
}

/// Asks for the reference at some pixels of each segment, with a single call.
fn ask<E>(
    sample: &Sample,
    segments: &mut [Segment],
    truth: &mut impl FnMut(&[u32]) -> Result<Vec<[f64; 3]>, E>,
    places: impl Fn(usize) -> Vec<usize>,
) -> Result<(), E> {
    let wanted: Vec<Vec<usize>> = (0..segments.len()).map(places).collect();
    let all: Vec<u32> = wanted
        .iter()
        .flatten()
        .map(|place| sample.pixels[*place])
        .collect();
    let mut light = truth(&all)?.into_iter();
    for (segment, places) in segments.iter_mut().zip(wanted) {
        segment.truth.extend(light.by_ref().take(places.len()));
        segment.places.extend(places);
    }
    Ok(())
}

/// `count` of some pixels at equal distances, or all of them.
fn spread(free: &[usize], count: usize, seed: usize) -> Vec<usize> {
    let count = count.min(free.len());
    let offset = f64::from(below(1 << 16, seed as u64)) / f64::from(1 << 16);
    let place = |k: usize| ((k as f64 + offset) / count as f64 * free.len() as f64) as usize;
    (0..count)
        .map(|k| free[place(k).min(free.len() - 1)])
        .collect()
}

/// The number of further pixels that each segment gets, by how much its light varies.
fn shares(segments: &[Segment], left: usize) -> Vec<usize> {
    let grey = |light: &[f64; 3]| light.iter().sum::<f64>() / 3.0;
    let variation = |index: usize| {
        let around = &segments[index.saturating_sub(1)..(index + 2).min(segments.len())];
        let light: Vec<f64> = around.iter().flat_map(|s| &s.truth).map(grey).collect();
        let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
        let squares: f64 = light.iter().map(|x| (x - mean).powi(2)).sum();
        (squares / light.len().max(1) as f64).sqrt()
    };
    let all: Vec<f64> = (0..segments.len()).map(variation).collect();
    let even = 1.0 / segments.len() as f64;
    let sum: f64 = all.iter().sum();
    let share = |x: &f64| match sum > 0.0 {
        true => LEAST * even + (1.0 - LEAST) * x / sum,
        false => even,
    };
    all.iter()
        .map(|x| (share(x) * left as f64).round() as usize)
        .collect()
}
