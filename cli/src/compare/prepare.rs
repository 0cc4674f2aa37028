//! What is known before the long work: the scene, its view, the plan.

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::emitter::Emission;
use lighting::plan::Plan;
use lighting::scene::{Camera, PhaseFunction};
use lighting::view::View;

use super::backends::Backends;
use super::results::LeftOut;
use super::selection::{Candidate, Evaluated, Selection, select};
use crate::args::Compare;
use crate::failure::Failure;
use crate::format::count;
use crate::input::{Input, describe_medium};
use crate::methods::Method;
use crate::parse::Size;

/// The scene and what is to be done with it.
pub(crate) struct Prepared {
    pub(crate) input: Input,
    pub(crate) camera: Camera,
    pub(crate) frame: Frame,
    pub(crate) selection: Selection,
    pub(crate) backends: Backends,
}

/// A picture of the scene and the passes it needs.
pub(crate) struct Frame {
    pub(crate) size: Size,
    pub(crate) view: View,
    pub(crate) plan: Plan,
}

impl Frame {
    fn new(input: &Input, camera: &Camera, size: Size) -> Result<Self, Failure> {
        let Size { width, height } = size;
        let view = View::new(&Cpu::new(), camera, &input.tracer, width, height)?;
        let plan = Plan::new(&input.emitters, input.scene.medium.as_ref(), view.rays());
        Ok(Self { size, view, plan })
    }

    /// Becomes a smaller picture. The plan stays as it is, unless the new rays
    /// need an emitter that was dropped, which happens where one of them
    /// grazes its cone: true then.
    pub(crate) fn shrink(
        &mut self,
        input: &Input,
        camera: &Camera,
        size: Size,
    ) -> Result<bool, Failure> {
        let Self { view, plan, .. } = Self::new(input, camera, size)?;
        self.size = size;
        self.view = view;
        let mut needed = plan.emitters().iter();
        let grown = needed.any(|index| !self.plan.emitters().contains(index));
        if grown {
            self.plan = plan;
        }
        Ok(grown)
    }
}

impl Prepared {
    pub(crate) fn new(args: &Compare) -> Result<Self, Failure> {
        let input = Input::load(&args.scene, &args.options)?;
        let (width, height) = if args.quick { (160, 90) } else { (480, 270) };
        let size = args.size.unwrap_or(Size { width, height });
        let camera = input.camera()?;
        let frame = Frame::new(&input, &camera, size)?;
        let is_even = |emitter: &Emitter| matches!(emitter, Emitter::Point(p) if *p.emission() == Emission::Isotropic);
        let kept = || frame.plan.emitters().iter().map(|i| &input.emitters[*i]);
        let phase = input.scene.medium.map(|medium| medium.phase());
        let evaluated = Evaluated {
            has_even_points: kept().any(is_even),
            is_isotropic: phase == Some(PhaseFunction::Isotropic),
            is_translucent: !input.scene.translucent.is_empty(),
        };
        let mut selection = select(args, &frame.plan, evaluated);
        let backends = Backends::find(args)?;
        selection.left_out.extend(backends.left_out.clone());
        selection
            .left_out
            .extend(backends.gaps(&selection.candidates));
        Ok(Self {
            input,
            camera,
            frame,
            selection,
            backends,
        })
    }

    /// The emitters that the plan keeps.
    pub(crate) fn emitters(&self) -> Vec<Emitter> {
        let kept = self.frame.plan.emitters().iter();
        kept.map(|index| self.input.emitters[*index].clone())
            .collect()
    }

    /// What `--plan` prints.
    pub(crate) fn describe(&self) -> String {
        let input = &self.input;
        let mut text = format!(
            "{}: {} as {}, {}, {}\n",
            input.scene.name,
            input.lights(),
            count(input.emitters.len(), "emitter"),
            count(input.geometry.triangles().len(), "triangle"),
            describe_medium(input.scene.medium.as_ref())
        );
        for note in &input.notes {
            text += &format!("note: {note}\n");
        }
        for line in self.passes() {
            text += &format!("runs: {line}\n");
        }
        for LeftOut { what, why } in &self.selection.left_out {
            text += &format!("left out: {what} ({why})\n");
        }
        text
    }

    /// One line per pass that runs.
    pub(crate) fn passes(&self) -> Vec<String> {
        let mut passes = vec![format!("view of {} rays", self.frame.size)];
        if self.selection.candidates.is_empty() {
            return passes;
        }
        passes.push(if self.input.scene.translucent.is_empty() {
            "reference: exact intervals × quadrature with a bound on its error".into()
        } else {
            "reference: exact intervals, in short parts × their exact transmittance × quadrature"
                .into()
        });
        passes.extend(self.frame.plan.passes().iter().map(ToString::to_string));
        let mut methods: Vec<(&Method, Vec<String>)> = Vec::new();
        for Candidate { method, quality } in &self.selection.candidates {
            match methods.last_mut() {
                Some((last, qualities)) if std::ptr::eq(*last, *method) => {
                    qualities.push(quality.to_string());
                }
                _ => {
                    methods.push((method, vec![quality.to_string()]));
                }
            }
        }
        for (method, qualities) in methods {
            let backends = self.backends.running(method);
            if !backends.is_empty() {
                passes.push(format!(
                    "{} with {} {} on {}",
                    method.title,
                    qualities.join(", "),
                    method.quality_name(),
                    backends.join(", ")
                ));
            }
        }
        passes
    }
}
