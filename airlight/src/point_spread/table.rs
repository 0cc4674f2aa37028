//! The point-spread function of one optical distance, in f32.

use std::f64::consts::PI;

use super::exact;
use crate::Error;
use crate::within::within;

/// Halvings of `sin²(γ/2)` that the table follows: to γ = 2e-12.
const OCTAVES: u32 = 80;
/// Bits of the mantissa that select a node: 64 nodes per octave.
const NODE_BITS: u32 = 6;
/// Bits of the mantissa between two nodes.
const REST_BITS: u32 = 23 - NODE_BITS;
/// The bits of the f32 at which the table starts, `2^{-80}`.
const FIRST: u32 = (127 - OCTAVES) << 23;
const NODES: usize = (OCTAVES << NODE_BITS) as usize + 1;

/// `N(γ)` for one optical distance, in 20 KiB.
///
/// The argument is `q = sin²(γ/2)`, which for two directions is a quarter of
/// their squared difference. The table holds `N √q`, which is between 0 and
/// 1/8, at nodes that follow the exponent and the first bits of `q`, and is
/// linear between them: finding a node takes a shift.
///
/// The relative error is below 3e-5 for optical distances up to 1e6, wherever
/// the result is a normal f32; beyond, it is larger for γ below 2e-12 only.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    optical_distance: f32,
    nodes: Vec<f32>,
}

impl Table {
    /// The table for the optical distance `T` of the light. Making it takes many times as long as
    /// a lookup, so keep it for all lookups at this distance.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless T is finite and at least 0.
    pub fn new(optical_distance: f32) -> Result<Self, Error> {
        if !(0.0..f32::INFINITY).contains(&optical_distance) {
            return Err(Error::bad_value(
                "the optical distance of the light",
                optical_distance,
                "a finite number, at least 0",
            ));
        }
        let nodes = (0..NODES as u32)
            .map(|index| {
                let q = f64::from(f32::from_bits(FIRST + (index << REST_BITS)));
                let half_sine = q.sqrt();
                let gamma = if q < 1.0 { 2.0 * half_sine.asin() } else { PI };
                (half_sine * exact::value(optical_distance.into(), gamma)) as f32
            })
            .collect();
        Ok(Self {
            optical_distance,
            nodes,
        })
    }

    /// `T`.
    pub fn optical_distance(&self) -> f32 {
        self.optical_distance
    }

    /// `N(γ)` in 1/sr at `q = sin²(γ/2)`: +∞ at 0. Numbers outside of [0, 1]
    /// count as the nearer end, NaN as 0.
    pub fn value(&self, q: f32) -> f32 {
        let q = within(q, 0.0, 1.0);
        // Below the first node N √q is constant.
        let bits = q.to_bits().max(FIRST) - FIRST;
        let index = ((bits >> REST_BITS) as usize).min(NODES - 2);
        let fraction = (bits - ((index as u32) << REST_BITS)) as f32 / (1_u32 << REST_BITS) as f32;
        let (low, high) = (self.nodes[index], self.nodes[index + 1]);
        (low + fraction * (high - low)) / q.sqrt()
    }

    /// Size of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_within_its_bound() {
        let mut distances = vec![0.0];
        distances.extend((-9..=6).map(|e| 10.0_f32.powi(e)));
        for t in distances {
            let table = Table::new(t).unwrap();
            assert!(table.bytes() <= 21 * 1024);
            let mut q = 1.0_f32;
            while q > 1e-37 {
                let gamma = if q < 1.0 {
                    2.0 * f64::from(q).sqrt().asin()
                } else {
                    PI
                };
                let expected = exact::value(t.into(), gamma);
                let error = f64::from(table.value(q)) / expected - 1.0;
                assert!(error.abs() < 3e-5, "T {t}, q {q:e}: {error:e}");
                q *= 0.9871;
            }
        }
    }

    #[test]
    fn no_argument_gives_nan() {
        let table = Table::new(3.0).unwrap();
        for q in [f32::NAN, -1.0, -0.0, 1e-45, 1.0, 2.0, f32::INFINITY] {
            assert!(table.value(q) > 0.0, "{q}");
        }
        assert_eq!(table.value(0.0), f32::INFINITY);
        assert_eq!(table.value(7.0), table.value(1.0));
    }

    #[test]
    fn distances_that_are_none_are_refused() {
        for t in [-1.0, f32::NAN, f32::INFINITY] {
            let error = Table::new(t).unwrap_err();
            assert!(error.to_string().contains("finite"), "{error}");
        }
    }
}
