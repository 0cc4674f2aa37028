//! Everything that is prepared before the long work: the scene, its view, the plan.

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::methods::{FrameInputs, Registry};
use lighting::plan::Plan;
use lighting::scene::view::View;
use lighting::scene::{AreaEmitters, Camera, Medium, Translucent};

use super::backends::Backends;
use super::measure::Job;
use super::selection::{Candidate, Selection, select};
use super::size::{Counted, fitted};
use super::study::described;
use crate::args::{Compare, SceneOptions};
use crate::devices::BackendName;
use crate::failure::Failure;
use crate::format::count;
use crate::input::{Input, describe_media, describe_medium};
use crate::maps;
use crate::parse::Size;

/// The arguments that decide on which pictures methods are compared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub(crate) scene: &'a str,
    pub(crate) size: Option<Size>,
    pub(crate) quick: bool,
    pub(crate) methods: &'a [String],
    pub(crate) backend: &'a [BackendName],
    pub(crate) smoke_unseen: bool,
    pub(crate) options: &'a SceneOptions,
}

impl Compare {
    pub(crate) fn asked(&self) -> Asked<'_> {
        Asked {
            scene: &self.scene,
            size: self.size,
            quick: self.quick,
            methods: &self.methods,
            backend: &self.backend,
            smoke_unseen: self.smoke_unseen,
            options: &self.options,
        }
    }
}

/// The scene, its picture, and all that is going to be measured on it.
pub(crate) struct Prepared {
    pub(crate) input: Input,
    pub(crate) camera: Camera,
    /// The size that was asked for, and the one that is compared.
    pub(crate) asked: Size,
    pub(crate) size: Size,
    pub(crate) view: View,
    /// The plan for the lights, the medium, the rays and what casts shadows.
    pub(crate) plan: Plan,
    /// The emitters that the plan keeps.
    pub(crate) emitters: Vec<Emitter>,
    /// The area lights among them.
    pub(crate) areas: Vec<AreaEmitters>,
    /// The homogeneous medium; a vacuum where others are seen alone.
    pub(crate) medium: Option<Medium>,
    /// Whether smoke and fog that thins out are seen.
    pub(crate) sees_media: bool,
    /// Texels per side of shadow maps.
    pub(crate) map: u32,
    pub(crate) selection: Selection,
    pub(crate) backends: Backends,
    /// Counted work of a pixel of the reference.
    pub(crate) per_pixel: f64,
}

impl Prepared {
    pub(crate) fn new(methods: &Registry, args: Asked<'_>, seconds: f64) -> Result<Self, Failure> {
        let (width, height) = if args.quick { (160, 90) } else { (480, 270) };
        let asked = args.size.unwrap_or(Size { width, height });
        let mut input = Input::for_picture(args.scene, args.options, asked)?;
        let camera = input.camera()?;
        let sees_media = !args.smoke_unseen && !input.media().is_homogeneous();
        let counted = match sees_media {
            true => counted_in_media(&input),
            false => Counted {
                lights: input.counted_lights(),
                casters: input.counted_casters(),
                parts: parts(&input, args.quick),
            },
        };
        let size = fitted(asked, counted, seconds);
        let view = View::new(&Cpu::new(), &camera, &input.tracer, size.width, size.height)?;
        let medium = match sees_media {
            true => input.medium_of_air(),
            false => input.scene.medium,
        };
        let plan = match sees_media {
            true => Plan::of_media(&input.emitters, &input.media(), view.rays()),
            false => Plan::new(&input.emitters, medium.as_ref(), view.rays()),
        };
        if sees_media && input.scene.translucent.iter().any(emits) {
            input
                .notes
                .push("what smoke emits itself is not compared".into());
        }
        let emitters = input.picked(plan.emitters());
        let areas = input.areas(plan.emitters());
        let asked_map = args
            .options
            .map
            .unwrap_or(if args.quick { 512 } else { 1024 });
        let map = maps::affordable(asked_map, &input.geometry, &emitters, &mut input.notes);
        let backends = Backends::find(args.backend)?;
        let mut prepared = Self {
            input,
            camera,
            asked,
            size,
            view,
            plan,
            emitters,
            areas,
            medium,
            sees_media,
            map,
            selection: Selection::default(),
            backends,
            per_pixel: counted.per_pixel(),
        };
        let (plan, mut selection) = {
            let job = prepared.job(args.quick);
            let inputs = job.as_ref().map(|job| job.inputs(&()));
            let plan = prepared.plan_of_frame(inputs.as_ref())?;
            let selection = select(methods, &args, &plan, inputs.as_ref(), sees_media);
            (plan, selection)
        };
        prepared.plan = plan;
        let backends = &prepared.backends;
        selection.left_out.extend(backends.left_out.clone());
        selection
            .left_out
            .extend(backends.gaps(&selection.candidates));
        prepared.selection = selection;
        Ok(prepared)
    }

    /// The picture on which methods are measured; `None` if there is no airlight.
    pub(crate) fn job(&self, quick: bool) -> Option<Job<'_>> {
        let medium = self.medium.as_ref()?;
        (!self.emitters.is_empty()).then_some(Job {
            input: &self.input,
            camera: &self.camera,
            view: &self.view,
            size: self.size,
            medium,
            emitters: &self.emitters,
            areas: &self.areas,
            map: self.map,
            parts: (!self.sees_media)
                .then(|| parts(&self.input, quick))
                .flatten(),
            sees_media: self.sees_media,
        })
    }

    /// The plan, which takes casters into account. The lights in `inputs` are those that the plan
    /// keeps.
    fn plan_of_frame(&self, inputs: Option<&FrameInputs<'_>>) -> Result<Plan, Failure> {
        let plan = self.plan.clone();
        let Some(inputs) = inputs else {
            return Ok(plan);
        };
        let all: Vec<usize> = (0..self.input.emitters.len()).collect();
        Ok(plan.with_casters(&FrameInputs {
            emitters: &self.input.emitters,
            areas: &self.input.areas(&all),
            ..*inputs
        })?)
    }

    /// The text that `--plan` prints.
    pub(crate) fn describe(&self) -> String {
        let input = &self.input;
        let mut text = format!(
            "{}: {} as {}, {}{}, {}\n",
            input.scene.name,
            input.lights(),
            count(input.emitters.len(), "emitter"),
            count(input.geometry.triangles().len(), "triangle"),
            input
                .geometry
                .dynamic_part()
                .map_or_else(String::new, |dynamic| {
                    format!(", {} of them dynamic", dynamic.triangles().len())
                }),
            self.describe_air()
        );
        for note in self.notes() {
            text += &format!("note: {note}\n");
        }
        for line in self.passes() {
            text += &format!("runs: {line}\n");
        }
        text + &described(&self.selection.left_out)
    }

    /// The media that are seen, in words.
    pub(crate) fn describe_air(&self) -> String {
        match self.sees_media {
            true => describe_media(&self.input.media()),
            false => describe_medium(self.input.scene.medium.as_ref()),
        }
    }

    /// What was placed, assumed or reduced.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = self.input.notes.clone();
        notes.extend(self.size_note());
        notes
    }

    /// A note that the picture is smaller than asked for, if it is.
    pub(crate) fn size_note(&self) -> Option<String> {
        (self.size != self.asked).then(|| {
            format!(
                "the picture is {} instead of {}, because of the number of lights, triangles and parts of smoke and hair and the time available (--time-budget, --fixed)",
                self.size, self.asked
            )
        })
    }

    /// One line per pass that runs.
    pub(crate) fn passes(&self) -> Vec<String> {
        let mut passes = vec![format!("view of {} rays", self.size)];
        if self.selection.candidates.is_empty() {
            return passes;
        }
        passes.push(if self.sees_media {
            "reference: exact visibility × quadrature through the media, cell by cell towards \
             eye and light"
                .into()
        } else if self.input.scene.translucent.is_empty() {
            "reference: exact visibility × quadrature with a bound on its error".into()
        } else {
            "reference: exact visibility, in short parts × their exact transmittance × quadrature"
                .into()
        });
        passes.extend(self.plan.passes().iter().map(ToString::to_string));
        let mut methods: Vec<(&Candidate, Vec<String>)> = Vec::new();
        for candidate in &self.selection.candidates {
            match methods.last_mut() {
                Some((last, qualities)) if last.method == candidate.method => {
                    qualities.push(candidate.quality.to_string());
                }
                _ => methods.push((candidate, vec![candidate.quality.to_string()])),
            }
        }
        for (candidate, qualities) in methods {
            let Candidate { entry, title, .. } = candidate;
            let backends = self.backends.running(candidate);
            if !backends.is_empty() {
                passes.push(format!(
                    "{title} with {} {} on {}",
                    qualities.join(", "),
                    entry.about().quality,
                    backends.join(", ")
                ));
            }
        }
        passes
    }
}

/// Whether a caster emits light.
fn emits(caster: &Translucent) -> bool {
    matches!(caster, Translucent::Grid(grid) if !grid.emission().is_empty())
}

/// The work of the reference in media that are seen: from each cell on a ray it looks through
/// as many cells towards the light, it asks every particle, and it cuts the ray at the edges of
/// the shadows of strands.
fn counted_in_media(input: &Input) -> Counted {
    let mut cells = 0.0;
    let mut pieces = 0;
    for caster in &input.scene.translucent {
        match caster {
            Translucent::Grid(grid) => {
                let [x, y, z] = grid.resolution().map(f64::from);
                cells += (x * y * z).cbrt();
            }
            Translucent::Particles(some) => pieces += some.all().len(),
            Translucent::Strands(strands) => pieces += strands.piece_count() / PIECES_PER_PARTICLE,
        }
    }
    Counted {
        // Here points stand for area lights.
        lights: input.emitters.len(),
        // Triangles take no time beside cells.
        casters: 0,
        parts: Some(PARTS_IN_MEDIA + (cells * cells * PARTS_PER_CELL_PAIR) as u32 + pieces as u32),
    }
}

/// How many parts are as much work as a ray through fog that thins out, and as one cell seen
/// through another. Counted on grids of 48 to 128 cells a side.
const PARTS_IN_MEDIA: u32 = 6;
const PARTS_PER_CELL_PAIR: f64 = 0.008;

/// How many pieces of strands are as much work as a particle.
const PIECES_PER_PARTICLE: usize = 40;

/// The number of parts into which the reference cuts rays if there is hair or smoke.
fn parts(input: &Input, quick: bool) -> Option<u32> {
    let is_translucent = !input.scene.translucent.is_empty();
    is_translucent.then_some(if quick { 48 } else { 128 })
}
