//! Segments that are hard for numbers, for tests.

use std::f64::consts::PI;

use crate::{Exact, PhaseFunction, Segment, Segment64};

/// Extinctions and segments: distances of 1e-6 m to 1e6 m and optical depths
/// of 1e-12 to 90 between eye and light, log-uniform; one ray in five each
/// goes exactly towards and away from the light, and one in five each misses
/// either by down to 1e-8; parts of 1e-9 of the distance to infinity, many of
/// which end just before, at or behind the foot point. The airlight of all is a
/// normal `f32`.
pub(crate) fn cases(number: usize) -> Vec<(f32, Segment)> {
    let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
    let mut random = Random(88_172_645_463_325_252);
    let mut cases = Vec::with_capacity(number);
    while cases.len() < number {
        let distance = random.log(1e-6, 1e6);
        let sigma_t = random.log(1e-12, 90.0) / distance;
        let angle = match random.below(5) {
            0 => 0.0,
            1 => PI,
            2 => random.log(1e-8, 1.5),
            3 => PI - random.log(1e-8, 1.5),
            _ => PI * random.unit(),
        };
        let x = distance
            * match random.below(3) {
                0 => 0.0,
                1 => 3.0 * random.unit(),
                _ => 1.0 - random.log(1e-8, 1.0),
            };
        let s = x - distance * angle.cos();
        let h = if angle == 0.0 || angle == PI {
            0.0
        } else {
            distance * angle.sin()
        };
        let length = match random.below(4) {
            0 => f64::INFINITY,
            1 | 2 => distance * random.log(1e-9, 100.0),
            _ => -s * (1.0 - random.log(1e-8, 1.0)),
        };
        let [sigma_t, x, s, h, length] = [sigma_t, x, s, h, length].map(|v| v as f32);
        let segment = Segment { x, s, h, length };
        let value = exact.airlight(sigma_t.into(), &Segment64::from(segment));
        if length > 0.0 && value > 1e-37 && value < 1e38 {
            cases.push((sigma_t, segment));
        }
    }
    cases
}

/// Halton's sequence, in [0, 1): of `number` points in a few dimensions with bases
/// that are different primes, a box of a share of the volume holds its share of the
/// points to within some.
pub(crate) fn halton(mut index: u32, base: u32) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while index > 0 {
        share /= f64::from(base);
        value += share * f64::from(index % base);
        index /= base;
    }
    value
}

/// Segments that start at the eye, 1 m from the light, at all angles: half of them
/// endless, the others from 1e-3 m to 1e3 m long, through extinctions from 1e-3 to
/// 10 per metre. The logarithms of tan(θ/2) from 1e-4 to 1e4, of the length and of
/// the extinction are spread evenly.
pub(crate) fn spread(number: u32) -> impl Iterator<Item = (f32, Segment)> {
    let log = |from: f64, to: f64, unit: f64| from * (to / from).powf(unit);
    (1..=number).map(move |index| {
        let tangent = log(1e-4, 1e4, halton(index, 2));
        let square = tangent * tangent;
        let length = if index.is_multiple_of(3) {
            log(1e-3, 1e3, halton(index, 7))
        } else {
            f64::INFINITY
        };
        let segment = Segment {
            x: 0.0,
            s: ((square - 1.0) / (1.0 + square)) as f32,
            h: (2.0 * tangent / (1.0 + square)) as f32,
            length: length as f32,
        };
        (log(1e-3, 10.0, halton(index, 5)) as f32, segment)
    })
}

/// Marsaglia's xorshift generator.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.unit() * f64::from(n)) as u32
    }

    fn log(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.unit())
    }
}
