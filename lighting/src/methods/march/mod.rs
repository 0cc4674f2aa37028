//! Ray marching: visibility sampled in steps along the ray.

#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;

#[cfg(all(feature = "methods", feature = "translucent"))]
pub(super) use method::NO_PICTURE;
#[cfg(feature = "methods")]
pub(super) use method::{Marches, STEPS, methods};

use crate::airlight::far_end;
use crate::path::{Arc, Turns, axis_of};
use crate::scene::Emission;
use crate::visibility::{LitInterval, PointVisibility, Share, VisibilitySource};
use crate::{Emitter, Interleaving, Interval, LightPath, Part};

/// How a march divides a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spacing {
    /// Steps of equal length. A ray to the sky is marched for ten mean free paths of the
    /// thinnest colour channel that scatters. The light behind is left out, which is 4.5e-5 of
    /// the light of a sun.
    Distance,
    /// Steps of equal angle at a point light, which are steps of equal share
    /// of the inverse-square falloff (equi-angular sampling: Kulla and
    /// Fajardo, Importance Sampling Techniques for Path Tracing in
    /// Participating Media, EGSR 2012). For a directional light, which has no
    /// such angle, the same as [`Spacing::Distance`].
    EquiAngular,
    /// Steps of equal length in the image plane of a spotlight, which is that of its shadow map
    /// and of its cookie; see [`light_space`](crate::methods::light_space). Lights without a
    /// single image plane take [`Spacing::EquiAngular`] steps. A ray to the sky ends as with
    /// [`Spacing::Distance`].
    Picture,
}

/// Marches along a ray in steps, and asks at the middle of each which share of the light
/// arrives.
///
/// It yields one interval for each step that is not dark. With [`Midpoint`] this is brute-force
/// ray marching; with [`EquiAngular`] of one node and equi-angular steps it is equi-angular
/// sampling. If the gather joins parts that touch, the steps find the ends of the lit runs, and
/// the evaluator integrates each run.
///
/// `points` can be any source of visibility at points, for example a shadow map or a
/// transmittance map. It must be in the memory of the backend that marches, and belong to the
/// light that is gathered.
///
/// Cost: one lookup per step and ray. The ends of lit intervals are off by at most half a step,
/// plus what the resolution of the map adds. Where the share is smooth, the error is of second
/// order in the length of a step.
///
/// [`Midpoint`]: crate::airlight::Midpoint
/// [`EquiAngular`]: crate::airlight::EquiAngular
#[derive(Debug, Clone, Copy)]
pub struct March<P> {
    points: P,
    steps: u32,
    spacing: Spacing,
    interleaving: Interleaving,
}

impl<P> March<P> {
    /// A march of `steps` steps that asks `points`; 0 steps count as 1.
    pub fn new(points: P, steps: u32, spacing: Spacing) -> Self {
        Self {
            points,
            steps: steps.max(1),
            spacing,
            interleaving: Interleaving::NONE,
        }
    }

    /// The same march with rays that share their steps: each ray asks at every `of`-th step,
    /// which then counts `of` times.
    ///
    /// Do not combine this with joining parts that touch: the steps of a single ray no longer
    /// touch.
    #[must_use]
    pub fn interleaved(self, interleaving: Interleaving) -> Self {
        Self {
            interleaving,
            ..self
        }
    }

    /// The source that is asked at every step.
    pub fn points(&self) -> &P {
        &self.points
    }

    /// Number of steps per ray.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// How the steps are spread.
    pub fn spacing(&self) -> Spacing {
        self.spacing
    }

    /// How rays share their steps.
    pub fn interleaving(&self) -> Interleaving {
        self.interleaving
    }
}

impl<P: PointVisibility> VisibilitySource for March<P> {
    type Share = P::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<P::Share>>) {
        let part = self.interleaving.part(path.index());
        for_each_step(
            path,
            self.steps,
            self.spacing,
            part,
            |start, middle, end| {
                let visibility = self.points.visibility(path.ray().at(middle));
                if !visibility.is_dark() {
                    lit.push(LitInterval {
                        interval: Interval::new(start, end),
                        visibility: visibility.weighted(part.weight()),
                    });
                }
            },
        );
    }
}

/// Divides the span of the path into `samples` steps, and calls `step(start, middle, end)` for
/// each step that belongs to `part` and is not empty.
#[inline]
fn for_each_step(
    path: &LightPath<'_>,
    samples: u32,
    spacing: Spacing,
    part: Part,
    mut step: impl FnMut(f32, f32, f32),
) {
    let span = path.span();
    let depths = depths(path, spacing);
    let arc = match (spacing, path.emitter()) {
        (Spacing::EquiAngular | Spacing::Picture, Emitter::Point(_)) if depths.is_none() => {
            Arc::new(path, span)
        }
        _ => None,
    };
    let halves = 2.0 * f64::from(samples);
    match arc {
        Some(arc) => {
            let mut turns = Turns::new(arc, halves);
            let mut start = span.start;
            for i in 0..samples {
                // Each position follows from the last one, also for steps that are skipped.
                let middle = turns.advance();
                let end = if i + 1 == samples {
                    span.end
                } else {
                    turns.advance()
                };
                if start < end && i % part.of == part.index {
                    step(start, middle, end);
                }
                start = start.max(end);
            }
        }
        None => {
            let end = span.end.min(span.start + far_end(path.medium()));
            let length = f64::from(end - span.start);
            let depths = depths.map(|depths| depths(end));
            let position = |count: f64| {
                let t = count / halves;
                let share = match depths {
                    None => t,
                    // Equal steps in the image plane: each end is weighted by the depth of the
                    // other.
                    Some([at_start, at_end]) => {
                        let weight = t * at_start;
                        weight / (weight + (1.0 - t) * at_end)
                    }
                };
                span.start + (length * share) as f32
            };
            for i in part.numbers(samples) {
                let count = 2.0 * f64::from(i);
                let start = position(count);
                let middle = position(count + 1.0);
                let end = if i + 1 == samples {
                    end
                } else {
                    position(count + 2.0)
                };
                if start < end {
                    step(start, middle, end);
                }
            }
        }
    }
}

/// The smallest depth of one end of a path in front of a light, as a share of the depth of the
/// other end. Steps next to the light are at least the square of this times the length of the
/// farthest.
const LEAST_DEPTH: f64 = 1e-3;

/// For steps in the image plane of a spotlight: a function from the distance of the path's end
/// to the depths of its start and its end in front of the light. `None` for other steps and
/// lights.
fn depths(path: &LightPath<'_>, spacing: Spacing) -> Option<impl Fn(f32) -> [f64; 2]> {
    let (Spacing::Picture, Emitter::Point(point)) = (spacing, path.emitter()) else {
        return None;
    };
    let Emission::Spot(spot) = point.emission() else {
        return None;
    };
    let axis = axis_of(spot);
    let from_light = path.ray().origin().as_dvec3() - point.position().as_dvec3();
    let (before, slope) = (
        from_light.dot(axis),
        path.ray().direction().as_dvec3().dot(axis),
    );
    let start = path.span().start;
    Some(move |end: f32| {
        let depths = [start, end].map(|x| (before + f64::from(x) * slope).max(0.0));
        let least = LEAST_DEPTH * depths[0].max(depths[1]);
        if least > 0.0 {
            depths.map(|depth| depth.max(least))
        } else {
            [1.0; 2]
        }
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gpu_backend::Cpu;

    use super::*;
    use crate::airlight::{AirlightEvaluator, Midpoint};
    use crate::scene::{Geometry, Medium, Mesh, PhaseFunction, Scene};
    use crate::shadow_map::{Casters, RenderShadowMap};
    use crate::visibility::join_touching;
    use crate::{Ray, VisibilitySource};

    #[test]
    fn samples_find_the_shadow_to_half_a_step_and_merge_into_runs() {
        let cpu = Cpu::new();
        let scene = Scene::from(Mesh {
            positions: vec![
                Vec3::new(-1.0, 1.0, -9.0),
                Vec3::new(1.0, 1.0, -9.0),
                Vec3::new(0.0, 1.0, 9000.0),
            ],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        let casters = Casters::upload(&cpu, &Geometry::new(&scene).unwrap()).unwrap();
        let position = Vec3::new(0.0, 2.0, 0.0);
        let light =
            Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let map = cpu.shadow_map(&casters, &light, 2048).unwrap();
        let fog = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X, 10.0).unwrap();
        let path = LightPath::new(&ray, &light, &fog).unwrap();
        for spacing in [Spacing::Distance, Spacing::EquiAngular] {
            for samples in [1_u32, 10, 100, 1000] {
                let march = March::new(&map, samples, spacing);
                let mut steps = Vec::new();
                march.lit_intervals(&path, &mut steps);
                assert!(
                    steps
                        .windows(2)
                        .all(|w| w[0].interval.end <= w[1].interval.start)
                );
                let mut runs = steps;
                join_touching(&mut runs, 0);
                if samples < 10 {
                    continue;
                }
                assert_eq!(runs.len(), 2, "{spacing:?} {samples}");
                // The shadow of the plate is [-2, 2], seen from x = -5.
                let tolerance = 10.0 / samples as f32 + 0.02;
                assert!((runs[0].interval.end - 3.0).abs() < tolerance);
                assert!((runs[1].interval.start - 7.0).abs() < tolerance);
                assert_eq!(runs[0].interval.start, 0.0);
                assert_eq!(runs[1].interval.end, 10.0);
            }
        }
    }

    /// To the last bit: the same steps, each by one of the rays.
    #[test]
    fn rays_that_share_the_steps_have_all_of_them_together() {
        let lamp = Vec3::new(0.0, 2.0, 0.0);
        let light = Emitter::point(lamp, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let fog = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X, 10.0).unwrap();
        let path = LightPath::new(&ray, &light, &fog).unwrap();
        let everywhere = crate::visibility::Unshadowed;
        for spacing in [Spacing::Distance, Spacing::EquiAngular] {
            for steps in [1_u32, 3, 4, 37] {
                let march = March::new(everywhere, steps, spacing);
                let mut whole = Vec::new();
                march.lit_intervals(&path, &mut whole);
                let mut shared = Vec::new();
                for ray in 0..4 {
                    let march = march.interleaved(Interleaving::new(4, 1));
                    march.lit_intervals(&path.with_index(ray), &mut shared);
                }
                assert!(shared.iter().all(|step| step.visibility == 4.0));
                shared.sort_by(|a, b| a.interval.start.total_cmp(&b.interval.start));
                let intervals = |all: &[LitInterval]| -> Vec<Interval> {
                    all.iter().map(|step| step.interval).collect()
                };
                assert_eq!(intervals(&shared), intervals(&whole), "{spacing:?} {steps}");
            }
        }
    }

    #[test]
    fn the_sky_is_marched_to_an_end_where_only_one_colour_scatters() {
        let cpu = Cpu::new();
        let below = Scene::from(Mesh {
            positions: vec![
                Vec3::NEG_Y,
                Vec3::new(1.0, -1.0, 0.0),
                Vec3::new(0.0, -1.0, 1.0),
            ],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        let casters = Casters::upload(&cpu, &Geometry::new(&below).unwrap()).unwrap();
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        let map = cpu.shadow_map(&casters, &sun, 64).unwrap();
        let sigma_s = Vec3::new(0.1, 0.0, 0.0);
        let red = Medium::new(sigma_s, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap();
        let path = LightPath::new(&ray, &sun, &red).unwrap();
        let mut steps = Vec::new();
        March::new(&map, 1000, Spacing::Distance).lit_intervals(&path, &mut steps);
        assert_eq!((steps.len(), steps[999].interval.end), (1000, 100.0));
        let radiance = steps
            .iter()
            .map(|step| Midpoint.radiance(&path, step.interval));
        let sum: Vec3 = radiance.sum();
        // Ten mean free paths of a phase function of 1/4π, in steps of a
        // hundredth: second order, 4e-6 of it, beside the rest of 4.5e-5.
        let expected = Vec3::new(0.25 / std::f32::consts::PI, 0.0, 0.0);
        assert!(
            (sum - expected).abs().max_element() < 1e-4 * expected.x,
            "{sum}"
        );
        // In one step too.
        assert!(Midpoint.radiance(&path, path.span()).is_finite());
    }
}
