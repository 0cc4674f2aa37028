//! Cubic polynomials over a part of a line.

/// A polynomial of degree 3 in `u` from 0 to 1, given by its Bernstein coefficients.
///
/// The coefficients of densities are not negative, so values and integrals are sums of terms
/// that are not negative, and lose no digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cubic(pub(crate) [f64; 4]);

impl Cubic {
    pub(crate) const fn constant(value: f64) -> Self {
        Self([value; 4])
    }

    /// A quadratic by its Bernstein coefficients.
    pub(crate) fn quadratic([a, b, c]: [f64; 3]) -> Self {
        Self([a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c])
    }

    /// The integral over all of it.
    pub(crate) fn mean(self) -> f64 {
        let [a, b, c, d] = self.0;
        0.25 * ((a + b) + (c + d))
    }

    /// The same polynomial on the domain 0 to `u`, by de Casteljau's algorithm.
    pub(crate) fn up_to(self, u: f64) -> Self {
        let mix = |a: f64, b: f64| a * (1.0 - u) + b * u;
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (mix(a, b), mix(b, c), mix(c, d));
        let (abc, bcd) = (mix(ab, bc), mix(bc, cd));
        Self([a, ab, abc, mix(abc, bcd)])
    }

    pub(crate) fn value(self, u: f64) -> f64 {
        self.up_to(u).0[3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_integrals_are_those_of_the_polynomial() {
        // 1 + 2u + 3u² + 4u³ and its integral.
        let cubic = Cubic([1.0, 1.0 + 2.0 / 3.0, 1.0 + 4.0 / 3.0 + 1.0, 10.0]);
        for u in [0.0, 0.25, 0.5, 1.0] {
            let value = 1.0 + u * (2.0 + u * (3.0 + u * 4.0));
            assert!((cubic.value(u) - value).abs() < 1e-14, "{u}");
            let integral = u * (1.0 + u * (1.0 + u * (1.0 + u)));
            assert!((u * cubic.up_to(u).mean() - integral).abs() < 1e-14, "{u}");
        }
        assert!((cubic.mean() - 4.0).abs() < 1e-14);
        let quadratic = Cubic::quadratic([0.0, 0.0, 1.0]);
        assert!((quadratic.value(0.3) - 0.09).abs() < 1e-16);
    }
}
