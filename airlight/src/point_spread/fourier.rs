//! Fourier transforms of several rows at once.

use std::f64::consts::TAU;

/// Rows that are transformed together; the compiler turns operations on all of
/// them into vector instructions.
pub(super) const LANES: usize = 4;

/// One complex number of each row.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Lanes {
    pub(super) re: [f64; LANES],
    pub(super) im: [f64; LANES],
}

impl Lanes {
    /// Adds a multiple of others.
    pub(super) fn add(&mut self, factor: f64, others: &Self) {
        for lane in 0..LANES {
            self.re[lane] += factor * others.re[lane];
            self.im[lane] += factor * others.im[lane];
        }
    }
}

/// The discrete Fourier transform of a power of two.
#[derive(Debug, Clone)]
pub(super) struct Fourier {
    /// `e^{−2πik/len}` for k below half of the length.
    roots: Vec<(f64, f64)>,
    len: usize,
}

impl Fourier {
    /// Of `len` numbers, a power of two.
    pub(super) fn new(len: usize) -> Self {
        debug_assert!(len.is_power_of_two());
        let roots = (0..len / 2)
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / len as f64).sin_cos();
                (cos, -sin)
            })
            .collect();
        Self { roots, len }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// `X_k = Σ x_j e^{−2πijk/len}` in place, by Cooley and Tukey's method.
    pub(super) fn transform(&self, data: &mut [Lanes]) {
        assert_eq!(data.len(), self.len, "the length of the transform");
        if self.len < 2 {
            return;
        }
        let shift = usize::BITS - self.len.trailing_zeros();
        for i in 0..self.len {
            let j = i.reverse_bits() >> shift;
            if i < j {
                data.swap(i, j);
            }
        }
        let mut half = 1;
        while half < self.len {
            let stride = self.len / (2 * half);
            for block in data.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                let roots = self.roots.iter().step_by(stride);
                for ((a, b), &root) in low.iter_mut().zip(high).zip(roots) {
                    butterfly(a, b, root);
                }
            }
            half *= 2;
        }
    }
}

/// `(a, b) ← (a + root b, a − root b)`.
fn butterfly(a: &mut Lanes, b: &mut Lanes, (cos, sin): (f64, f64)) {
    for lane in 0..LANES {
        let re = b.re[lane] * cos - b.im[lane] * sin;
        let im = b.re[lane] * sin + b.im[lane] * cos;
        b.re[lane] = a.re[lane] - re;
        b.im[lane] = a.im[lane] - im;
        a.re[lane] += re;
        a.im[lane] += im;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_agree_with_their_definition() {
        for len in [1, 2, 4, 32] {
            let data: Vec<Lanes> = (0..len)
                .map(|j| Lanes {
                    re: std::array::from_fn(|lane| ((j * 7 + lane) as f64).sin()),
                    im: std::array::from_fn(|lane| ((j + 3 * lane) as f64).cos()),
                })
                .collect();
            let mut transformed = data.clone();
            Fourier::new(len).transform(&mut transformed);
            for (k, value) in transformed.iter().enumerate() {
                for lane in 0..LANES {
                    let (mut re, mut im) = (0.0, 0.0);
                    for (j, x) in data.iter().enumerate() {
                        let (sin, cos) = (-TAU * (j * k) as f64 / len as f64).sin_cos();
                        re += x.re[lane] * cos - x.im[lane] * sin;
                        im += x.re[lane] * sin + x.im[lane] * cos;
                    }
                    assert!((value.re[lane] - re).abs() < 1e-12);
                    assert!((value.im[lane] - im).abs() < 1e-12);
                }
            }
        }
    }
}
