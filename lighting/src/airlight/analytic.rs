//! Evaluators of the crate `airlight`, for the lights of a scene.

use airlight::Segment;
use glam::Vec3;

use super::{AirlightEvaluator, Quadrature};
use crate::{Interval, LightPath};

/// An evaluator of the crate `airlight`, with a quadrature as the fallback.
///
/// The evaluator serves lights inside the medium that shine alike in all directions and do not
/// fade, and, of a spotlight without a cookie, the part of a ray in its full cone, where the
/// light is of that kind. The quadrature serves everything else: the rims of spotlights,
/// surface emitters, cookies, lights that fade towards their range, lights outside of a bounded
/// medium.
///
/// The evaluator must have been made for the phase function of the medium that it is used in. A
/// coloured medium takes one evaluation per channel, a grey one a single evaluation.
#[derive(Debug, Clone)]
pub struct Analytic<E> {
    evaluator: E,
    fallback: Quadrature,
}

impl<E: airlight::Evaluator> Analytic<E> {
    /// `evaluator` where it applies and `fallback` elsewhere.
    pub fn new(evaluator: E, fallback: Quadrature) -> Self {
        Self {
            evaluator,
            fallback,
        }
    }

    /// The evaluator.
    pub fn evaluator(&self) -> &E {
        &self.evaluator
    }

    /// The quadrature that is used where the evaluator does not apply.
    pub fn fallback(&self) -> &Quadrature {
        &self.fallback
    }
}

impl<E: airlight::Evaluator> AirlightEvaluator for Analytic<E> {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        by_cone(
            path,
            interval,
            |piece| self.plain(path, &path.part(piece)),
            |piece| self.fallback.radiance(path, piece),
        )
    }

    /// Evaluates parts in which the light shines alike in all directions as a batch, if the
    /// results of a batch do not depend on each other.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        let Some(path) = paths.first() else { return };
        if !self.evaluator.has_independent_batches() {
            let each = |&(path, interval): &(usize, _)| self.radiance(&paths[path], interval);
            return radiances.extend(parts.iter().map(each));
        }
        let first = radiances.len();
        radiances.resize(first + parts.len(), Vec3::ZERO);
        let radiances = &mut radiances[first..];
        let (mut plain, mut segments) = (Vec::new(), Vec::new());
        for (i, &(path, interval)) in parts.iter().enumerate() {
            let path = &paths[path];
            if let Some(segment) = path.segment(interval) {
                plain.push(i);
                segments.push(segment);
            } else {
                radiances[i] = self.radiance(path, interval);
            }
        }
        let mut airlight = vec![0.0; segments.len()];
        let sigma_t = path.medium().sigma_t();
        let is_grey = sigma_t == Vec3::splat(sigma_t.x);
        for channel in 0..if is_grey { 1 } else { 3 } {
            self.evaluator
                .airlight_batch(sigma_t[channel], &segments, &mut airlight);
            for (&i, &airlight) in plain.iter().zip(&airlight) {
                if is_grey {
                    radiances[i] = Vec3::splat(airlight);
                } else {
                    radiances[i][channel] = airlight;
                }
            }
        }
        for i in plain {
            radiances[i] = lit(path, radiances[i]);
        }
    }
}

/// The radiance for this airlight. A channel without light stays dark even where the airlight
/// is infinite, which it is through the light itself.
fn lit(path: &LightPath<'_>, airlight: Vec3) -> Vec3 {
    let light = path.medium().sigma_s() * path.emitter().intensity();
    Vec3::select(light.cmpgt(Vec3::ZERO), light * airlight, Vec3::ZERO)
}

/// The radiance of an interval: by `plain` where the light is inside the medium, shines alike
/// in all directions and does not fade, and by `fallback` elsewhere.
pub(super) fn by_cone(
    path: &LightPath<'_>,
    interval: Interval,
    plain: impl Fn(Interval) -> Vec3,
    fallback: impl Fn(Interval) -> Vec3,
) -> Vec3 {
    if path.segment(interval).is_some() {
        return plain(interval);
    }
    let Some(spot) = path.full_cone() else {
        return fallback(interval);
    };
    path.without_kinks(interval).fold(Vec3::ZERO, |sum, piece| {
        sum + if path.is_full(spot, piece) {
            plain(piece)
        } else {
            fallback(piece)
        }
    })
}

impl<E: airlight::Evaluator> Analytic<E> {
    /// The radiance of a part in which the light shines alike in all directions.
    fn plain(&self, path: &LightPath<'_>, segment: &Segment) -> Vec3 {
        let sigma_t = path.medium().sigma_t();
        let channel = |sigma: f32| self.evaluator.airlight(sigma, segment);
        let airlight = if sigma_t == Vec3::splat(sigma_t.x) {
            Vec3::splat(channel(sigma_t.x))
        } else {
            sigma_t.map(channel)
        };
        lit(path, airlight)
    }
}
