//! The published table on a GPU against the CPU.

use std::f64::consts::TAU;

use gpu_backend::testing;

use super::agreement::{batches, evaluated};
use crate::{Evaluator, SunTable};

/// The lookup of F is off by up to 32 roundings of a number of about 1: a few
/// each for the angle, its polynomial and the position in the table, whose
/// last digit counts as one of π/2, and the same again for the row. The factor
/// of the difference multiplies that. The exponent of the factor is rounded
/// four times on either side.
fn allowed(sigma_t: f32, x: f32, s: f32, h: f32, airlight: f32) -> f64 {
    let exponent = f64::from(sigma_t) * (f64::from(s) - f64::from(x));
    let factor = exponent.min(88.03).exp() / (TAU * f64::from(h));
    let relative = 16.0 + 8.0 * exponent.abs();
    (2.0 * 32.0 * factor + relative * f64::from(airlight)) / f64::from(1 << 24)
}

#[test]
fn the_published_table_agrees_with_the_cpu_as_far_as_it_has_digits() {
    let Some(gpu) = testing::gpu() else { return };
    for table in [SunTable::new(), SunTable::with_range(20.0).unwrap()] {
        let (mut all, mut worst) = (0, 0.0_f64);
        for (sigma_t, segments) in batches(4000) {
            let actual = evaluated(&gpu, &table, sigma_t, &segments);
            for (segment, actual) in segments.iter().zip(actual) {
                let expected = table.airlight(sigma_t, segment).min(f32::MAX);
                let allowed = allowed(sigma_t, segment.x, segment.s, segment.h, expected);
                let error = (f64::from(actual) - f64::from(expected)).abs();
                if error > f64::from(f32::MIN_POSITIVE) {
                    worst = worst.max(error / allowed);
                    assert!(
                        error <= allowed,
                        "{expected} on the CPU, {actual} on the GPU for {sigma_t} {segment:?}"
                    );
                }
                all += 1;
            }
        }
        println!("{worst} of the allowed error over {all} segments");
    }
}
