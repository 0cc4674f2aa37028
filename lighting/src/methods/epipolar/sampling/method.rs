//! Epipolar sampling around what finds the lit parts of rays.

use gpu_backend::{BufferOf, Cpu};

use super::choice::Choice;
use super::fill::FillFromLines;
use super::samples::Spacing;
use super::surfaces::Surfaces;
use crate::culling::PickPixels;
use crate::methods::{
    About, Evaluators, Frame, FrameInputs, LightSources, Method, MethodError, PerLight, Role,
    RunOn, SourceOn, Verdict, Work,
};
use crate::scene::Geometry;
use crate::{EyePanes, Gather, LitRays};

/// Pixels for whose number of samples a quality stands, and the best quality: a sample
/// in every pixel.
const PIXELS: u32 = 64;

/// Lines are closer than samples by this factor, as far as a pixel.
const CLOSER: f64 = 16.0;

/// Comparisons and searches for a pixel, as a share of a lookup of a method.
const CHOICE: f64 = 1.0;

/// A visibility source and an evaluator whose light is gathered along the epipolar lines
/// of each light; see the [module](super).
///
/// In a frame that is a [part](crate::methods::Selection) of a picture, or whose rays are
/// not those of the camera's pixels, there are no lines, and all rays are gathered.
#[derive(Debug, Clone)]
pub struct EpipolarSampling<S, E> {
    sources: S,
    evaluators: E,
    /// The evaluator's quality.
    detail: u32,
    whole: PerLight<S, E>,
}

impl<S: LightSources + Clone, E: Evaluators + Clone> EpipolarSampling<S, E> {
    /// Around a kind of source without a quality, with that of the evaluator.
    pub fn new(sources: S, evaluators: E, detail: u32) -> Self {
        let whole = PerLight::new(sources.clone(), evaluators.clone(), None).with_detail(detail);
        Self {
            sources,
            evaluators,
            detail,
            whole,
        }
    }
}

/// The distances of a quality.
fn spacing(quality: u32) -> Result<Spacing, MethodError> {
    if !(1..=PIXELS).contains(&quality) {
        return Err(MethodError::Quality {
            value: quality,
            unit: QUALITY,
            expected: format!("1 to {PIXELS}"),
        });
    }
    let samples = f64::from(PIXELS) / f64::from(quality);
    Ok(Spacing {
        lines: (samples / CLOSER).max(1.0),
        samples,
    })
}

const QUALITY: &str = "samples per 64 pixels of a line";

/// Whether the rays are those of the pixels of the camera.
fn is_picture(inputs: &FrameInputs<'_>) -> bool {
    let [columns, rows] = inputs.size;
    let pixels = columns as usize * rows as usize;
    if inputs.selection.pixels.is_some()
        || pixels == 0
        || inputs.rays.len() != pixels
        || inputs.hits.len() != pixels
    {
        return false;
    }
    let corners = [
        [0, 0],
        [columns - 1, 0],
        [0, rows - 1],
        [columns - 1, rows - 1],
        [columns / 2, rows / 2],
    ];
    corners.into_iter().all(|[x, y]| {
        let (at_x, at_y) = (x as f32 + 0.5, y as f32 + 0.5);
        let expected = inputs.camera.direction(at_x, at_y, columns, rows);
        let ray = inputs.rays[(y * columns + x) as usize];
        // A few roundings.
        ray.origin() == inputs.camera.eye() && (ray.direction() - expected).length() < 1e-5
    })
}

impl<S: LightSources + Clone, E: Evaluators + Clone> Method for EpipolarSampling<S, E> {
    fn about(&self) -> About {
        About {
            name: "epipolar-sampling".into(),
            title: "epipolar sampling",
            purpose: "what engines call light scattering with epipolar sampling: a few samples \
                 for each line towards a light, more where depth is discontinuous",
            paper: "Engelhardt and Dachsbacher, Epipolar Sampling for Shadows and Crepuscular \
                 Rays in Participating Media with Single Scattering, I3D 2010",
            quality: QUALITY,
            qualities: &[1, 2, 4, 8, 16],
            quick: &[2, 8],
            pictured: 4,
            usual: 4,
            role: Role::Paper,
            ..self.whole.about()
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        self.whole.applies(inputs)
    }

    fn uses_maps_of(&self, geometry: &Geometry) -> bool {
        self.whole.uses_maps_of(geometry)
    }

    fn takes_some_pixels(&self) -> Verdict {
        Verdict::Impossible("its samples are those of lines through a whole picture".into())
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        self.whole.notes(inputs)
    }

    fn work(&self, inputs: &FrameInputs<'_>, quality: u32) -> Work {
        let mut work = self.whole.work(inputs, self.detail);
        if let Ok(spacing) = spacing(quality) {
            // Lines through an epipole in view are closer inside than at the border.
            work.per_ray *= (1.5 / (spacing.lines * spacing.samples)).min(1.0);
            work.per_ray += CHOICE * inputs.emitters.len() as f64;
        }
        work
    }
}

impl<B, S, E> RunOn<B> for EpipolarSampling<S, E>
where
    B: FillFromLines + PickPixels + Gather<<S as SourceOn<B>>::Source, E::Evaluator>,
    S: SourceOn<B> + Clone,
    E: Evaluators + Clone,
{
    fn prepare(&self, frame: &Frame<'_, B>, _: u32) -> Result<(), MethodError> {
        self.whole.prepare(frame, self.detail)
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let spacing = spacing(quality)?;
        let inputs = &frame.inputs;
        if !is_picture(inputs) {
            return self.whole.add_radiance(frame, self.detail, radiance);
        }
        let cpu = Cpu::new();
        let backend: &B = frame.backend;
        let surfaces = frame.pass("discontinuities", || Ok(Surfaces::new(&cpu, inputs)))?;
        let tracer = match inputs.geometry.coatings().any_see_through() {
            true => Some(inputs.tracer()?),
            false => None,
        };
        for (light, emitter) in inputs.emitters.iter().enumerate() {
            let emitter = &*self.sources.evaluated(emitter);
            let choice = frame.pass("choice of samples", || {
                Ok(Choice::new(&cpu, &surfaces, emitter, spacing))
            })?;
            let Some(choice) = choice else {
                inputs.watch.gathered(inputs.rays.len());
                continue;
            };
            let part = frame.with_inputs(choice.inputs(inputs))?;
            let panes = tracer
                .as_ref()
                .and_then(|tracer| EyePanes::new(&cpu, tracer, &choice.rays));
            let source = self.sources.source(&part, light, 0)?;
            let evaluator = self.evaluators.of_light(&part, emitter, self.detail)?;
            let mut gathered = backend.zeros::<[f32; 4]>(choice.rays.len())?;
            let lit = LitRays {
                touching: self.sources.about().touching,
                panes: panes.as_ref(),
                ..LitRays::new(&part.rays, emitter, inputs.medium)
            };
            frame.pass("gather", || {
                Ok(backend.gather(&lit, &source, &*evaluator, &mut gathered)?)
            })?;
            self.sources.done(&part, source, 0);
            frame.pass("filling", || {
                Ok(backend.fill_from_lines(&choice, &gathered, radiance)?)
            })?;
            inputs.watch.gathered(inputs.rays.len());
        }
        Ok(())
    }
}
