//! Parts of rays, with the extinction around them, on which evaluators of airlight are measured:
//! ordinary ones, and those at which they break.

use std::f64::consts::PI;

use crate::oracle::Phase;
use crate::oracle::segment::{self, Part};
use crate::random::{Random, halton};

/// A part of a ray in a medium, and how much light comes from it.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Extinction, 1/m.
    pub sigma_t: f32,
    /// The part.
    pub part: Part,
    /// The airlight per unit of `σ_s I`, to 1e-9 of itself.
    pub truth: f64,
}

/// Geometry of a case, relative to the distance `D` between eye and light.
struct Shape {
    /// D, m.
    distance: f64,
    /// σ_t D.
    optical: f64,
    /// Angle between the ray and the light, as its cosine and sine.
    direction: [f64; 2],
    /// Start and length of the part, in D.
    part: [f64; 2],
}

impl Shape {
    fn case(&self, phase: Phase) -> Option<Case> {
        let Self {
            distance,
            optical,
            direction: [cos, sin],
            part: [start, length],
        } = *self;
        let sigma_t = (optical / distance) as f32;
        let part = Part {
            x: (start * distance) as f32,
            s: ((start - cos) * distance) as f32,
            h: (sin * distance) as f32,
            length: (length * distance) as f32,
        };
        if part.holds_the_light() || part.length == 0.0 {
            return None;
        }
        let truth = segment::airlight(phase, f64::from(sigma_t), part, 1e-9).value;
        Some(Case {
            sigma_t,
            part,
            truth,
        })
    }
}

/// Ordinary rays: optical distances of 0.1 to 2 between eye and light, every
/// direction, parts from the eye on that are neither tiny nor endless. All of
/// one extinction, for batches: 0.5 per metre.
pub fn easy(phase: impl Into<Phase>, count: usize) -> Vec<Case> {
    let phase = phase.into();
    (0..count).filter_map(|i| ordinary(i).case(phase)).collect()
}

/// The first `count` parts of [`easy`], each divided into `steps` of equal length, as a
/// march does.
pub fn steps(phase: impl Into<Phase>, count: usize, steps: u32) -> Vec<Case> {
    let phase = phase.into();
    let shapes = (0..count).flat_map(|i| {
        (0..steps).map(move |step| {
            let whole = ordinary(i);
            let length = whole.part[1] / f64::from(steps);
            Shape {
                part: [length * f64::from(step), length],
                ..whole
            }
        })
    });
    shapes.filter_map(|shape| shape.case(phase)).collect()
}

/// The shapes of [`easy`].
fn ordinary(index: usize) -> Shape {
    let halton = |base: u32| halton(index as u32 + 1, base);
    let optical = 0.1 * 20.0_f64.powf(halton(2));
    // Away from the poles, where an f32 cosine would do no harm either.
    let cos = 0.999 * (2.0 * halton(3) - 1.0);
    Shape {
        distance: optical / 0.5,
        optical,
        direction: [cos, (1.0 - cos * cos).sqrt()],
        part: [0.0, 0.3 * 10.0_f64.powf(halton(5))],
    }
}

/// Rays towards the light, past it and away from it, exactly and nearly; from
/// vacuum to where nothing is left; parts that are tiny, end just before the
/// light, begin just behind it, or never end; distances from micrometres to
/// a thousand kilometres. At least nine in ten of the results are normal f32,
/// the rest lie below.
pub fn stiff(phase: impl Into<Phase>) -> Vec<Case> {
    const ANGLES: [f64; 12] = [
        0.0,
        1e-7,
        1e-5,
        1e-3,
        0.1,
        1.0,
        0.5 * PI,
        2.0,
        3.0,
        PI - 1e-3,
        PI - 1e-6,
        PI,
    ];
    const OPTICAL: [f64; 12] = [
        0.0, 1e-9, 1e-6, 1e-3, 0.03, 0.3, 1.0, 3.0, 10.0, 30.0, 60.0, 80.0,
    ];
    const PARTS: [[f64; 2]; 20] = [
        [0.0, 1e-9],
        [0.0, 1e-4],
        [0.0, 0.3],
        [0.0, 0.9],
        [0.0, 0.999],
        [0.0, 1.0],
        [0.0, 1.001],
        [0.0, 2.0],
        [0.0, 30.0],
        [0.0, f64::INFINITY],
        [0.5, 1e-7],
        [0.5, 0.45],
        [0.9, 0.2],
        [0.999, 1e-5],
        [1.0, 1e-3],
        [1.0, f64::INFINITY],
        [1.001, 1e-6],
        [1.001, f64::INFINITY],
        [3.0, 0.01],
        [3.0, f64::INFINITY],
    ];
    let phase = phase.into();
    let mut cases = Vec::new();
    let mut below = Vec::new();
    for distance in [1e-6, 1.0, 1e6] {
        for optical in OPTICAL {
            for angle in ANGLES {
                for part in PARTS {
                    // At the half turn exactly the ray leaves the light in its
                    // line, which the sine of an f64 π does not say.
                    let sin = if angle == PI { 0.0 } else { angle.sin() };
                    let shape = Shape {
                        distance,
                        optical,
                        direction: [angle.cos(), sin],
                        part,
                    };
                    match shape.case(phase) {
                        Some(case) if case.truth >= f64::from(f32::MIN_POSITIVE) => {
                            cases.push(case);
                        }
                        Some(case) => below.push(case),
                        None => {}
                    }
                }
            }
        }
    }
    let most = cases.len() / 10;
    let every = below.len().div_ceil(most.max(1)).max(1);
    cases.extend(below.into_iter().step_by(every));
    cases
}

/// Extinctions and parts without a pattern: distances of 1e-6 m to 1e6 m and
/// optical depths of 1e-12 to 90 between eye and light, log-uniform; one ray in
/// five each goes exactly towards and away from the light, and one in five each
/// misses either by down to 1e-8; parts of 1e-9 of the distance to infinity, many
/// of which end just before, at or behind the foot point. The airlight of all in
/// isotropic fog is a normal `f32`.
pub fn random_stiff(number: usize) -> Vec<(f32, Part)> {
    let mut random = Random::from_state(88_172_645_463_325_252);
    let mut cases = Vec::with_capacity(number);
    while cases.len() < number {
        let distance = random.log_uniform(1e-6, 1e6);
        let sigma_t = random.log_uniform(1e-12, 90.0) / distance;
        let angle = match random.below(5) {
            0 => 0.0,
            1 => PI,
            2 => random.log_uniform(1e-8, 1.5),
            3 => PI - random.log_uniform(1e-8, 1.5),
            _ => PI * random.unit_f64(),
        };
        let x = distance
            * match random.below(3) {
                0 => 0.0,
                1 => 3.0 * random.unit_f64(),
                _ => 1.0 - random.log_uniform(1e-8, 1.0),
            };
        let s = x - distance * angle.cos();
        let h = if angle == 0.0 || angle == PI {
            0.0
        } else {
            distance * angle.sin()
        };
        let length = match random.below(4) {
            0 => f64::INFINITY,
            1 | 2 => distance * random.log_uniform(1e-9, 100.0),
            _ => -s * (1.0 - random.log_uniform(1e-8, 1.0)),
        };
        let [sigma_t, x, s, h, length] = [sigma_t, x, s, h, length].map(|v| v as f32);
        let part = Part { x, s, h, length };
        if !(length > 0.0) || part.holds_the_light() {
            continue;
        }
        // Only its magnitude is asked for.
        let value = segment::airlight(Phase::Isotropic, f64::from(sigma_t), part, 1e-3).value;
        if value > 1e-37 && value < 1e38 {
            cases.push((sigma_t, part));
        }
    }
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stiff_list_is_mostly_in_range_and_reaches_the_corners() {
        let cases = stiff(Phase::Isotropic);
        let normal = |case: &&Case| case.truth >= f64::from(f32::MIN_POSITIVE);
        let share = cases.iter().filter(normal).count() as f64 / cases.len() as f64;
        assert!(cases.len() > 5000 && share > 0.9, "{} {share}", cases.len());
        assert!(cases.iter().all(|case| case.truth.is_finite()));
        assert!(cases.iter().any(|case| case.truth > 1e10));
        assert!(
            cases
                .iter()
                .any(|case| case.part.h == 0.0 && case.part.s < 0.0)
        );
        let random = random_stiff(500);
        let grazing = random.iter().filter(|(_, part)| part.h == 0.0).count();
        assert!(
            random.len() == 500 && (100..300).contains(&grazing),
            "{grazing}"
        );
        let easy = easy(Phase::Rayleigh, 500);
        assert_eq!(easy.len(), 500);
        assert!(
            easy.iter()
                .all(|case| case.sigma_t == 0.5 && case.truth > 0.0)
        );
        let steps = steps(Phase::Rayleigh, 5, 10);
        for (whole, steps) in easy.iter().zip(steps.chunks(10)) {
            let sum: f64 = steps.iter().map(|case| case.truth).sum();
            assert!((sum / whole.truth - 1.0).abs() < 1e-5, "{sum}");
        }
    }
}
