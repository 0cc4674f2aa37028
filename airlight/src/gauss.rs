//! Gauss–Legendre rules.

use std::f64::consts::PI;

use crate::Error;

/// The Gauss–Legendre rule of some number of nodes on the interval (0, 1):
/// `∫ f dt ≈ Σ weight · f(node)`, exact for polynomials of a degree below
/// twice the number of nodes.
///
/// Nodes rise and lie symmetric about ½, weights are positive and sum to 1;
/// both are within 1e-14 of their true value.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

/// More nodes are of no use in double precision, and take long to find.
const MOST: u32 = 4096;

/// Whether there is a rule of so many nodes.
pub(crate) fn check(nodes: u32) -> Result<(), Error> {
    if (1..=MOST).contains(&nodes) {
        Ok(())
    } else {
        Err(Error::bad_value("the number of nodes", nodes, "1 to 4096"))
    }
}

impl Rule {
    /// The rule of `nodes` nodes; the time grows with their square.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to 4096 nodes.
    pub fn new(nodes: u32) -> Result<Self, Error> {
        check(nodes)?;
        Ok(Self::of(nodes))
    }

    /// The rule of `count` nodes, which are known to be 1 to 4096.
    pub(crate) fn of(count: u32) -> Self {
        let n = f64::from(count);
        let mut nodes = vec![0.5; count as usize];
        let mut weights = vec![0.0; count as usize];
        for i in 0..count.div_ceil(2) {
            // Newton's method from Tricomi's estimate, on 1 − x = 2 sin²(φ/2),
            // which keeps the digits that nodes near the ends need.
            let mut angle = PI * (f64::from(i) + 0.75) / (n + 0.5);
            let mut slope = 1.0;
            for _ in 0..20 {
                let x = angle.cos();
                let (mut p, mut previous) = (1.0, 0.0);
                for k in 0..count {
                    let k = f64::from(k);
                    (p, previous) = (((2.0 * k + 1.0) * x * p - k * previous) / (k + 1.0), p);
                }
                // dP/dφ = −sin φ P'(x) = n (x P_n − P_{n−1}) / sin φ
                slope = n * (x * p - previous) / angle.sin();
                let step = p / slope;
                angle -= step;
                if step.abs() <= 1e-16 * angle {
                    break;
                }
            }
            // The weight on (−1, 1) is 2 / ((1 − x²) P'²) = 2 / (dP/dφ)²; on (0, 1) it is half.
            let weight = 1.0 / (slope * slope);
            let half_sine = (0.5 * angle).sin();
            let node = half_sine * half_sine;
            let (near, far) = (i as usize, (count - 1 - i) as usize);
            if near != far {
                nodes[near] = node;
                nodes[far] = 1.0 - node;
            }
            weights[near] = weight;
            weights[far] = weight;
        }
        Self { nodes, weights }
    }

    /// The nodes, rising.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// One weight per node.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Node and weight together.
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.nodes.iter().copied().zip(self.weights.iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_the_degree_of_a_rule_are_integrated() {
        for count in [1, 2, 3, 4, 7, 10, 15, 16, 31, 64, 200] {
            let rule = Rule::new(count).unwrap();
            for degree in 0..(2 * count).min(60) as i32 {
                let sum: f64 = rule.iter().map(|(t, w)| w * t.powi(degree)).sum();
                let exact = 1.0 / (f64::from(degree) + 1.0);
                assert!(
                    (sum - exact).abs() < 1e-14,
                    "{count} nodes, degree {degree}"
                );
            }
        }
    }

    #[test]
    fn nodes_rise_and_are_symmetric_up_to_the_largest_rule() {
        for count in [2, 3, 100, 1001, 4096] {
            let rule = Rule::new(count).unwrap();
            assert!(rule.nodes()[0] > 0.0 && rule.nodes()[count as usize - 1] < 1.0);
            assert!(rule.nodes().windows(2).all(|pair| pair[0] < pair[1]));
            assert!(rule.weights().iter().all(|&w| w > 0.0));
            let total: f64 = rule.weights().iter().sum();
            assert!((total - 1.0).abs() < 1e-13, "{count}: {total}");
            // ∫ 4 / (1 + t²) = π
            let pi: f64 = rule.iter().map(|(t, w)| 4.0 * w / (1.0 + t * t)).sum();
            assert!(count < 100 || (pi - PI).abs() < 1e-13, "{count}: {pi}");
        }
    }

    #[test]
    fn known_rules() {
        let two = Rule::new(2).unwrap();
        assert!((two.nodes()[0] - (0.5 - 0.5 / 3_f64.sqrt())).abs() < 1e-16);
        let three = Rule::new(3).unwrap();
        assert!((three.weights()[1] - 4.0 / 9.0).abs() < 1e-15);
        assert_eq!(three.nodes()[1], 0.5);
    }

    #[test]
    fn numbers_of_nodes_out_of_range_are_refused() {
        assert!(Rule::new(0).is_err() && Rule::new(4097).is_err());
    }
}
