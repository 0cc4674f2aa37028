//! What is known before the long work: the scene, its view, the plan.

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::plan::Plan;
use lighting::scene::Camera;
use lighting::view::View;

use super::results::LeftOut;
use super::selection::{Candidate, Selection, select};
use crate::args::{BackendName, Compare};
use crate::failure::Failure;
use crate::format::count;
use crate::input::{Input, describe_medium};
use crate::parse::Size;

/// The scene and what is to be done with it.
pub(crate) struct Prepared {
    pub(crate) input: Input,
    pub(crate) camera: Camera,
    pub(crate) frame: Frame,
    pub(crate) selection: Selection,
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
        let selection = select(args, &frame.plan);
        Ok(Self {
            input,
            camera,
            frame,
            selection,
        })
    }

    /// The emitters that the plan keeps.
    pub(crate) fn emitters(&self) -> Vec<Emitter> {
        let kept = self.frame.plan.emitters().iter();
        kept.map(|index| self.input.emitters[*index].clone())
            .collect()
    }

    /// What `--plan` prints.
    pub(crate) fn describe(&self, args: &Compare) -> String {
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
        for line in self.passes(args) {
            text += &format!("runs: {line}\n");
        }
        for LeftOut { what, why } in &self.selection.left_out {
            text += &format!("left out: {what} ({why})\n");
        }
        text
    }

    /// One line per pass that runs.
    pub(crate) fn passes(&self, args: &Compare) -> Vec<String> {
        let mut passes = vec![format!("view of {} rays", self.frame.size)];
        if self.selection.candidates.is_empty() {
            return passes;
        }
        passes.push("reference: exact intervals × quadrature with a bound on its error".into());
        passes.extend(self.frame.plan.passes().iter().map(ToString::to_string));
        let backends: Vec<&str> = backends(args).iter().map(|b| b.name()).collect();
        let mut methods: Vec<(&str, &str, Vec<String>)> = Vec::new();
        for Candidate { method, quality } in &self.selection.candidates {
            match methods.last_mut() {
                Some((title, _, qualities)) if *title == method.title => {
                    qualities.push(quality.to_string());
                }
                _ => {
                    let first = vec![quality.to_string()];
                    methods.push((method.title, method.quality_name(), first));
                }
            }
        }
        for (title, unit, qualities) in methods {
            passes.push(format!(
                "{title} with {} {unit} on {}",
                qualities.join(", "),
                backends.join(", ")
            ));
        }
        passes
    }
}

impl BackendName {
    fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
        }
    }
}

/// The backends asked for, or all that are present.
pub(crate) fn backends(args: &Compare) -> Vec<BackendName> {
    let mut all: Vec<BackendName> = Vec::new();
    for name in &args.backend {
        if !all.contains(name) {
            all.push(*name);
        }
    }
    if all.is_empty() {
        all.push(BackendName::Cpu);
    }
    all
}
