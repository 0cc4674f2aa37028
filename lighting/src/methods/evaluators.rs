//! The evaluators of airlight that are combined with every source.

use std::fmt::Debug;
use std::sync::Arc;

use airlight::{Exact, FrameTable, PhaseFunction, SunTable, Table};
use gpu_backend::Backend;

use super::{Frame, FrameInputs, MethodError, Verdict};
use crate::airlight::{
    AirlightEvaluator, Analytic, Daylight, EquiAngular, Midpoint, PerFrame, Quadrature,
};
use crate::path::full_cone;
use crate::scene::Emitter;

/// A kind of airlight evaluator.
pub trait Evaluators: Send + Sync + Debug {
    /// An evaluator.
    type Evaluator: AirlightEvaluator + Send + Sync + 'static;

    /// What it says of itself.
    const ABOUT: EvaluatorAbout;

    /// Whether each light of a frame has an evaluator of its own. It must be true where
    /// [`of_light`](Evaluators::of_light) is overridden.
    const IS_OF_LIGHT: bool = false;

    /// Makes an evaluator for media with this phase function.
    ///
    /// # Errors
    /// [`MethodError`], for example for a quality that is out of range.
    fn make(&self, phase: PhaseFunction, quality: u32) -> Result<Self::Evaluator, MethodError>;

    /// The memory of an evaluator, bytes.
    fn bytes(_evaluator: &Self::Evaluator) -> u64 {
        0
    }

    /// Evaluations of the integrand, or lookups, for one interval.
    fn work(quality: u32) -> f64 {
        f64::from(quality)
    }

    /// The relative error that it keeps in each interval, beside rounding; `None` if the error
    /// depends on the interval.
    fn tolerance(_quality: u32) -> Option<f64> {
        None
    }

    /// Whether it applies to a frame.
    fn applies(&self, _inputs: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }

    /// Remarks on what it does in another way than its name says.
    fn notes(&self, _inputs: &FrameInputs<'_>) -> Vec<String> {
        Vec::new()
    }

    /// The evaluator for the medium of a frame, from the frame's store.
    ///
    /// # Errors
    /// Those of [`Evaluators::make`].
    fn kept<B: Backend>(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
    ) -> Result<Arc<Self::Evaluator>, MethodError> {
        let phase = frame.inputs.medium.phase();
        frame
            .store
            .get(Self::ABOUT.title, quality, Self::bytes, || {
                self.make(phase, quality)
            })
    }

    /// The evaluator of one light in a frame. Override it where it depends on the eye or
    /// the light; the default is [`kept`](Evaluators::kept).
    ///
    /// # Errors
    /// Those of [`Evaluators::make`].
    fn of_light<B: Backend>(
        &self,
        frame: &Frame<'_, B>,
        _emitter: &Emitter,
        quality: u32,
    ) -> Result<Arc<Self::Evaluator>, MethodError> {
        self.kept(frame, quality)
    }
}

/// How a kind of evaluator describes itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EvaluatorAbout {
    /// The name by which it is asked for, such as `table`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// The unit of its quality; `None` if it has none.
    pub unit: Option<&'static str>,
    /// The quality that is used unless another is asked for: first for intervals that are
    /// single samples, then for other intervals.
    pub usual: [u32; 2],
}

impl FrameInputs<'_> {
    /// True if all lights are directional.
    pub fn has_only_suns(&self) -> bool {
        let is_sun = |emitter: &Emitter| matches!(emitter, Emitter::Directional(_));
        self.emitters.iter().all(is_sun)
    }

    /// The indices of the lights that differ from plain points in what an evaluator sees: those
    /// with a pattern, and those outside of a bounded medium. Directional lights are not among
    /// them, as they have a closed form.
    fn lights_with_a_pattern(&self) -> Vec<usize> {
        let has_pattern = |emitter: &Emitter| match emitter {
            Emitter::Directional(_) => false,
            Emitter::Point(point) => {
                let is_outside = self
                    .medium
                    .bounds()
                    .is_some_and(|bounds| !bounds.contains(point.position()));
                !point.is_plain() || is_outside
            }
        };
        let all = self.emitters.iter().enumerate();
        all.filter(|(_, emitter)| has_pattern(emitter))
            .map(|(index, _)| index)
            .collect()
    }

    /// The optical depth between the eye and the point light with the most fog in between.
    fn depth_of_lights(&self) -> f32 {
        let (eye, medium) = (self.camera.eye(), self.medium);
        let depths = self.emitters.iter().map(|emitter| match emitter {
            Emitter::Directional(_) => 0.0,
            Emitter::Point(point) => {
                let way = point.position() - eye;
                let inside = medium.length_inside(eye, way.normalize_or_zero(), way.length());
                medium.sigma_t().max_element() * inside
            }
        });
        depths.fold(0.0, f32::max)
    }

    /// Whether evaluators of plain points have something to evaluate: a plain point light, or
    /// the full cone of a spotlight.
    fn has_plain_points(&self) -> Verdict {
        let points = self
            .emitters
            .iter()
            .filter(|emitter| matches!(emitter, Emitter::Point(_)))
            .count();
        let has_full_cone = |emitter: &Emitter| match emitter {
            Emitter::Directional(_) => false,
            Emitter::Point(point) => {
                full_cone(point, self.medium).is_some_and(|spot| spot.outer_versine() > spot.rim())
            }
        };
        let others = self.lights_with_a_pattern();
        if points > others.len() || others.iter().any(|i| has_full_cone(&self.emitters[*i])) {
            return Verdict::Applies;
        }
        Verdict::Impossible(
            "no light shines alike in all directions of a cone from a point in the medium".into(),
        )
    }
}

/// One sample at the middle of each interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Midpoints;

impl Evaluators for Midpoints {
    type Evaluator = Midpoint;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "midpoint",
        title: "one sample in the middle",
        unit: None,
        usual: [1, 1],
    };

    fn make(&self, _: PhaseFunction, _: u32) -> Result<Midpoint, MethodError> {
        Ok(Midpoint)
    }
}

/// The unit of the quality of Gauss quadrature.
pub const GAUSS_NODES: &str = "Gauss nodes per lit run";

/// Gauss–Legendre quadrature with a fixed number of nodes, in the equi-angular variable for
/// point lights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gauss;

impl Evaluators for Gauss {
    type Evaluator = EquiAngular;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "gauss",
        title: "Gauss-Legendre quadrature, equi-angular at a point light",
        unit: Some(GAUSS_NODES),
        usual: [1, 8],
    };

    fn make(&self, _: PhaseFunction, nodes: u32) -> Result<EquiAngular, MethodError> {
        EquiAngular::new(nodes).map_err(MethodError::resource("a quadrature"))
    }
}

/// Gauss–Legendre quadrature with as many nodes as a tolerance asks for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerances;

impl Evaluators for Tolerances {
    type Evaluator = Quadrature;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "quadrature",
        title: "quadrature to a tolerance",
        unit: Some("digits"),
        usual: [4, 4],
    };

    fn make(&self, phase: PhaseFunction, digits: u32) -> Result<Quadrature, MethodError> {
        if !(1..=6).contains(&digits) {
            return Err(MethodError::Quality {
                value: digits,
                unit: "digits",
                expected: "1 to 6".into(),
            });
        }
        Quadrature::with_tolerance(phase, 10_f32.powi(-(digits as i32)))
            .map_err(MethodError::resource("a quadrature"))
    }

    fn tolerance(digits: u32) -> Option<f64> {
        Some(0.1_f64.powf(digits.into()))
    }

    fn work(digits: u32) -> f64 {
        4.0 * f64::from(digits)
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if inputs.has_only_suns() {
            let why = "the airlight of a directional light is in closed form";
            return Verdict::Pointless(why.into());
        }
        Verdict::Applies
    }
}

/// The tolerance for lights that a table does not serve, far below the error of the tables.
const FALLBACK: f32 = 1e-5;

fn fallback(phase: PhaseFunction) -> Result<Quadrature, MethodError> {
    Quadrature::with_tolerance(phase, FALLBACK).map_err(MethodError::resource("a quadrature"))
}

fn falls_back(inputs: &FrameInputs<'_>, name: &str) -> Vec<String> {
    let others = inputs.lights_with_a_pattern();
    let text = others.iter().map(ToString::to_string);
    let text = text.collect::<Vec<_>>().join(", ");
    match others.len() {
        0 => Vec::new(),
        _ => vec![format!(
            "airlight by {name} is that of plain points and of full cones; where a light has a pattern, or stands outside of the medium, it is a quadrature to 1e-5 (emitters {text})"
        )],
    }
}

/// A table for point lights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tables;

impl Evaluators for Tables {
    type Evaluator = Analytic<Table>;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "table",
        title: "a table of the scaled tail",
        unit: Some("KiB"),
        usual: [64, 64],
    };

    fn make(&self, phase: PhaseFunction, size: u32) -> Result<Self::Evaluator, MethodError> {
        let table = Table::new(&phase, size).map_err(MethodError::resource("a table"))?;
        Ok(Analytic::new(table, fallback(phase)?))
    }

    fn bytes(evaluator: &Self::Evaluator) -> u64 {
        evaluator.evaluator().bytes() as u64
    }

    fn work(_: u32) -> f64 {
        2.0
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        inputs.has_plain_points()
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        falls_back(inputs, Self::ABOUT.name)
    }
}

/// A table for each light, made anew in every frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameTables;

impl Evaluators for FrameTables {
    type Evaluator = PerFrame;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "frame-table",
        title: "a table of the frame for each light",
        unit: Some("rows"),
        usual: [128, 128],
    };

    const IS_OF_LIGHT: bool = true;

    fn make(&self, phase: PhaseFunction, rows: u32) -> Result<PerFrame, MethodError> {
        FrameTable::check_rows(rows).map_err(MethodError::resource("a table of the frame"))?;
        Ok(PerFrame::new(fallback(phase)?))
    }

    fn of_light<B: Backend>(
        &self,
        frame: &Frame<'_, B>,
        emitter: &Emitter,
        rows: u32,
    ) -> Result<Arc<PerFrame>, MethodError> {
        let inputs = &frame.inputs;
        let fallback = self.kept(frame, rows)?.fallback().clone();
        frame.pass("table of the frame", || {
            let eye = inputs.camera.eye();
            PerFrame::of_light(fallback, eye, emitter, inputs.medium, rows)
                .map(Arc::new)
                .map_err(MethodError::resource("a table of the frame"))
        })
    }

    fn work(_: u32) -> f64 {
        2.0
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        inputs.has_plain_points()
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        falls_back(inputs, Self::ABOUT.name)
    }
}

/// The closed form in double precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Doubles;

impl Evaluators for Doubles {
    type Evaluator = Analytic<Exact>;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "double",
        title: "double precision",
        unit: Some("bits"),
        usual: [64, 64],
    };

    fn make(&self, phase: PhaseFunction, _: u32) -> Result<Self::Evaluator, MethodError> {
        let exact = Exact::new(phase).map_err(MethodError::resource("double precision"))?;
        Ok(Analytic::new(exact, fallback(phase)?))
    }

    fn tolerance(_: u32) -> Option<f64> {
        Some(0.0)
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        inputs.has_plain_points().and(|| {
            if inputs.lights_with_a_pattern().is_empty() {
                return Verdict::Applies;
            }
            let why = "double precision is for plain points, and there are lights with a pattern";
            Verdict::Impossible(why.into())
        })
    }
}

/// `exp` of more than this overflows single precision.
const DEEPEST: f32 = 88.0;

/// The table of Sun et al. as it was published.
#[derive(Debug, Clone, Copy)]
pub(super) struct Published;

impl Evaluators for Published {
    type Evaluator = Analytic<SunTable>;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "published",
        title: "the published table",
        unit: Some("texels a side"),
        usual: [512, 512],
    };

    fn make(&self, phase: PhaseFunction, _: u32) -> Result<Self::Evaluator, MethodError> {
        Ok(Analytic::new(SunTable::new(), fallback(phase)?))
    }

    fn bytes(evaluator: &Self::Evaluator) -> u64 {
        evaluator.evaluator().bytes() as u64
    }

    fn work(_: u32) -> f64 {
        2.0
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if inputs.medium.phase() != PhaseFunction::Isotropic {
            let why = "the published table is one of isotropic scattering";
            return Verdict::Impossible(why.into());
        }
        let depth = inputs.depth_of_lights();
        if depth > DEEPEST {
            let why = format!(
                "the factor of the published table grows like e^τ beyond what single precision holds: \
                 a light is {depth:.1e} mean free paths away"
            );
            return Verdict::Impossible(why.into());
        }
        inputs.has_plain_points()
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        falls_back(inputs, Self::ABOUT.name)
    }
}

/// The model of daylight, for point lights too. It leaves out what the light of a lamp depends
/// on most, and serves those who want its look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Daylights;

impl Evaluators for Daylights {
    type Evaluator = Daylight;

    const ABOUT: EvaluatorAbout = EvaluatorAbout {
        name: "daylight",
        title: "daylight, as strong as at a distance from the light",
        unit: Some("metres"),
        usual: [4, 4],
    };

    fn make(&self, _: PhaseFunction, metres: u32) -> Result<Daylight, MethodError> {
        Daylight::new(metres as f32).map_err(MethodError::resource("daylight"))
    }

    fn work(_: u32) -> f64 {
        1.0
    }
}
