//! Random numbers that are the same on every run and every machine.

/// Marsaglia's xorshift generator of 64 bits ("Xorshift RNGs", Journal of
/// Statistical Software 8(14), 2003; shifts 13, 7, 17).
///
/// ```
/// use reference::random::Random;
///
/// let mut random = Random::new(7);
/// let numbers = [random.unit(), random.unit()];
/// assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)));
/// assert_eq!(numbers[0], Random::new(7).unit());
/// ```
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed; any seed will do.
    pub const fn new(seed: u64) -> Self {
        // Small seeds are spread over all bits; the state must not be 0.
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// The sequence that follows a state of the generator, which is not 0.
    pub const fn from_state(state: u64) -> Self {
        assert!(state != 0, "the generator would stay at 0");
        Self(state)
    }

    /// 64 random bits, not all of them 0.
    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³.
    pub fn unit_f64(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// Uniform in [`low`, `high`).
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0 … `count` − 1; 0 if `count` is 0.
    pub fn below(&mut self, count: u32) -> u32 {
        (self.unit_f64() * f64::from(count)) as u32
    }

    /// Between two positive numbers, every magnitude alike.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit_f64())
    }

    /// Three numbers, each uniform in [−`size`, `size`).
    pub fn vector(&mut self, size: f32) -> [f32; 3] {
        [(); 3].map(|()| self.between(-size, size))
    }

    /// Puts items in any order, every order alike.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            let other = (self.unit() * (last + 1) as f32) as usize;
            items.swap(last, other.min(last));
        }
    }
}

/// Uniform in [0, 1): a number for each index, without pattern and in any order.
///
/// The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast splittable
/// pseudorandom number generators", OOPSLA 2014).
pub const fn noise(index: u64) -> f32 {
    let mut x = index.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 40) as f32 / (1 << 24) as f32
}

/// Halton's sequence, in [0, 1): of many points in a few dimensions, with bases
/// that are different primes, a box of a share of the volume holds about its share
/// of the points.
pub fn halton(mut index: u32, base: u32) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while index > 0 {
        share /= f64::from(base);
        value += share * f64::from(index % base);
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fill_their_range_evenly() {
        let mut random = Random::new(0);
        let mut counts = [0; 16];
        for _ in 0..16_000 {
            counts[random.below(16) as usize] += 1;
        }
        assert!(
            counts.iter().all(|count| (850..1150).contains(count)),
            "{counts:?}"
        );
        let logs = (0..1000).map(|_| random.log_uniform(1e-6, 1e6));
        let small = logs.filter(|x| *x < 1.0).count();
        assert!((400..600).contains(&small), "{small}");
    }

    #[test]
    fn noise_has_no_trend() {
        let mean = |first: u64| {
            (first..first + 4096)
                .map(|i| f64::from(noise(i)))
                .sum::<f64>()
                / 4096.0
        };
        assert!((mean(0) - 0.5).abs() < 0.02 && (mean(1 << 40) - 0.5).abs() < 0.02);
    }

    #[test]
    fn every_box_has_its_share_of_halton_points() {
        let inside = |i: &u32| halton(*i, 2) < 0.25 && halton(*i, 3) < 1.0 / 3.0;
        let count = (1..=1200).filter(inside).count();
        assert!((95..=105).contains(&count), "{count}");
        assert_eq!([1, 2, 3].map(|i| halton(i, 2)), [0.5, 0.25, 0.75]);
    }

    #[test]
    fn shuffling_keeps_the_items() {
        let mut items: Vec<u32> = (0..100).collect();
        Random::new(3).shuffle(&mut items);
        assert!(!items.is_sorted());
        items.sort_unstable();
        assert!(items.iter().copied().eq(0..100));
    }
}
