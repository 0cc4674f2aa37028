//! The published table on a GPU against the CPU.

use std::f64::consts::TAU;

use gpu_backend::testing;
use reference::tolerances::Allowed;

use super::agreement::{batches, evaluated};
use crate::{Evaluator, SunTable};

/// The error of two lookups, times the factor of their difference, and that of
/// the factor.
fn allowed(sigma_t: f32, x: f32, s: f32, h: f32, airlight: f32) -> f64 {
    let exponent = f64::from(sigma_t) * (f64::from(s) - f64::from(x));
    let factor = exponent.min(88.03).exp() / (TAU * f64::from(h));
    let relative = Allowed::GpuPublishedTableFactor.error()
        + exponent.abs() * Allowed::GpuPublishedTableDepth.error();
    Allowed::GpuPublishedTable.error() * factor + relative * f64::from(airlight)
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
