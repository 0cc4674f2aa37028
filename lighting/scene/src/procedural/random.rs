//! Random numbers and circles that are the same on every machine.

use glam::{Vec2, Vec3};

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014): a counter and a mixing function, so that any
/// seed, 0 included, starts a good sequence.
#[derive(Debug, Clone)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴.
    pub(super) fn unit(&mut self) -> f32 {
        to_unit(self.next())
    }

    /// Uniform in [`low`, `high`).
    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0 … `count` − 1. The bias is below 2⁻⁵⁰ for counts that
    /// matter here.
    pub(super) fn below(&mut self, count: u32) -> u32 {
        (self.next() % u64::from(count)) as u32
    }

    /// A point in the ball of radius 1, by rejection: no trigonometry.
    pub(super) fn in_ball(&mut self) -> Vec3 {
        loop {
            let point = Vec3::new(
                self.between(-1.0, 1.0),
                self.between(-1.0, 1.0),
                self.between(-1.0, 1.0),
            );
            if point.length_squared() <= 1.0 {
                return point;
            }
        }
    }

    /// A direction, uniform over the sphere.
    pub(super) fn direction(&mut self) -> Vec3 {
        loop {
            let point = self.in_ball();
            if point.length_squared() > 1e-4 {
                return point.normalize();
            }
        }
    }
}

/// A number in [0, 1) that belongs to the lattice point (`x`, `y`).
pub(super) fn lattice(seed: u64, x: i32, y: i32) -> f32 {
    let point = u64::from(x as u32) << 32 | u64::from(y as u32);
    to_unit(mix(mix(seed ^ 0x6a09_e667_f3bc_c908).wrapping_add(point)))
}

/// Smooth noise in [0, 1) between the lattice points: quintic interpolation,
/// whose second derivative is continuous.
pub(super) fn value_noise(seed: u64, position: Vec2) -> f32 {
    let base = position.floor();
    let t = position - base;
    let t = t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (x, y) = (base.x as i32, base.y as i32);
    let row = |y| {
        let (a, b) = (lattice(seed, x, y), lattice(seed, x + 1, y));
        a + (b - a) * t.x
    };
    let (a, b) = (row(y), row(y + 1));
    a + (b - a) * t.y
}

/// Cosine and sine of an angle given in full turns.
///
/// Only multiplies and adds, so that scenes do not depend on the platform's
/// mathematical library: a series for an eighth of the angle, then three
/// doublings. The error is below 1e-10.
pub(super) fn circle(turns: f32) -> Vec2 {
    let turns = f64::from(turns);
    let angle = (turns - turns.round()) * (std::f64::consts::TAU / 8.0);
    let a2 = angle * angle;
    let mut cos = 1.0 - a2 / 2.0 * (1.0 - a2 / 12.0 * (1.0 - a2 / 30.0 * (1.0 - a2 / 56.0)));
    let mut sin = angle * (1.0 - a2 / 6.0 * (1.0 - a2 / 20.0 * (1.0 - a2 / 42.0)));
    for _ in 0..3 {
        (cos, sin) = (cos * cos - sin * sin, 2.0 * cos * sin);
    }
    Vec2::new(cos as f32, sin as f32)
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn to_unit(bits: u64) -> f32 {
    (bits >> 40) as f32 / (1_u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        let mut random = Random::new(1_234_567);
        assert_eq!(random.next(), 6_457_827_717_110_365_317);
        assert_eq!(random.next(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn the_circle_is_round() {
        for i in -50..50 {
            let turns = 0.037 * i as f32;
            let angle = f64::from(turns) * std::f64::consts::TAU;
            let point = circle(turns).as_dvec2();
            let error = point - glam::DVec2::new(angle.cos(), angle.sin());
            assert!(error.length() < 1e-7, "{turns}: {error}");
        }
    }

    #[test]
    fn noise_meets_its_lattice_and_is_continuous() {
        let at = |x: f32| value_noise(3, Vec2::new(x, -2.0));
        assert_eq!(at(5.0), lattice(3, 5, -2));
        assert!((at(5.999_999) - at(6.0)).abs() < 1e-5);
        assert!((at(-0.000_001) - at(0.0)).abs() < 1e-5);
    }
}
