//! The method that the command line names.

use lighting::methods::{Entry, GAUSS_NODES, Method, Registry};
use lighting::prediction::Target;

use crate::args::{Render, SurfaceScattering};
use crate::compare::prepare::Asked;
use crate::devices::{BackendName, Device, PictureBackend};
use crate::failure::Failure;
use crate::input::Input;
use crate::parse::Size;
use crate::plan;
use crate::shadow_files;
use crate::suggest::unknown_method;

/// A method with a quality.
pub(crate) struct Chosen {
    pub(crate) entry: Entry,
    pub(crate) quality: u32,
}

/// The halves of a pair unless others are asked for.
const VISIBILITY: &str = "exact";
const AIRLIGHT: &str = "quadrature";

fn runs_on(entry: &Entry, backend: PictureBackend) -> bool {
    backend != PictureBackend::Gpu || entry.runs_on_gpus()
}

impl Chosen {
    /// The method that is expected to meet a target, with its device, and notes about both.
    pub(crate) fn foreseen(
        methods: &Registry,
        args: &Render,
        size: Size,
        target: Target,
    ) -> Result<(Self, Device, Vec<String>), Failure> {
        let asked = Asked {
            scene: &args.scene,
            size: Some(size),
            quick: false,
            methods: &[],
            backend: &[args.backend.name().unwrap_or(BackendName::Cpu)],
            smoke_unseen: false,
            options: &args.options,
        };
        let may_start = args.backend == PictureBackend::Auto;
        let found = plan::choose(methods, asked, target, may_start)?;
        let chosen = Self {
            entry: found.candidate.entry,
            quality: found.candidate.quality,
        };
        let mut notes = vec![format!("for {target}: {}", found.row)];
        notes.extend(found.note);
        Ok((chosen, found.device, notes))
    }

    pub(crate) fn new(methods: &Registry, args: &Render) -> Result<Self, Failure> {
        let entry = match &args.method {
            Some(name) => {
                let found = methods.find(name);
                found.ok_or_else(|| unknown_method(methods, name))?
            }
            None => {
                let airlight = args.airlight.as_deref().unwrap_or(AIRLIGHT);
                let visibility = args.visibility.as_deref().unwrap_or(VISIBILITY);
                let missing =
                    || Failure::new(format!("there is no method {visibility} x {airlight}"));
                methods
                    .pair(visibility, airlight, None)
                    .ok_or_else(missing)?
            }
        };
        let Some([(visibility, steps), (airlight, detail)]) = entry.halves() else {
            if args.samples.is_some() || args.nodes.is_some() {
                return Err(Failure::new(format!(
                    "--samples and --nodes apply to a pair of visibility and airlight; the quality of {} is --quality",
                    entry.about().name
                )));
            }
            let quality = args.quality.unwrap_or(entry.about().usual);
            return Ok(Self { entry, quality });
        };
        if args.samples.is_some() && steps.is_none() {
            return Err(Failure::new(format!(
                "--samples is a number of steps or voxels, and {visibility} visibility has neither"
            )));
        }
        if args.nodes.is_some() && detail != Some(GAUSS_NODES) {
            return Err(Failure::new(format!(
                "--nodes applies to a quadrature with a fixed number of nodes, which {airlight} is not"
            )));
        }
        let given = args.quality.or(args.samples);
        // Without a quality of the visibility, nodes are the quality of the pair.
        let (entry, given) = match (steps, args.nodes) {
            (Some(_), Some(nodes)) => {
                let entry = methods.pair(visibility, airlight, Some(nodes));
                (entry.expect("the pair was found before"), given)
            }
            (None, Some(nodes)) if given.is_none() => (entry, Some(nodes)),
            (None, Some(_)) => {
                return Err(Failure::new(
                    "--nodes is the quality of this pair: give only one of --nodes, --quality and --samples",
                ));
            }
            (_, None) => (entry, given),
        };
        let quality = given.unwrap_or(entry.about().usual);
        Ok(Self { entry, quality })
    }

    /// The same, or, where nothing was asked for and there is smoke in the scene, a method that
    /// sees it.
    pub(crate) fn for_media(self, methods: &Registry, args: &Render, input: &mut Input) -> Self {
        if input.media().is_homogeneous() || self.entry.sees_heterogeneous_media() {
            return self;
        }
        let asked = args.method.is_some() || args.visibility.is_some() || args.airlight.is_some();
        // A quality that is given alone is that of the method that is taken.
        let is_free = !asked && args.samples.is_none();
        let seeing = methods.for_heterogeneous_media();
        let seeing = seeing.filter(|entry| runs_on(entry, args.backend));
        match seeing {
            Some(entry) if is_free && args.nodes.is_none() && args.shadows.is_empty() => Self {
                quality: args.quality.unwrap_or(entry.about().usual),
                entry: entry.clone(),
            },
            _ => {
                let name = self.entry.about().name;
                input.notes.push(format!(
                    "with {name} smoke casts shadows into the fog and dims the surfaces behind it, but \
                     the light that it scatters is not drawn"
                ));
                self
            }
        }
    }

    /// Notes what a picture does not show of hair.
    pub(crate) fn note_hair(&self, args: &Render, input: &mut Input) {
        let has_fog = input.scene.medium.is_some() || !input.media().is_homogeneous();
        if has_fog && !self.entry.sees_cover() {
            let name = self.entry.about().name;
            (input.notes).push(format!(
                "with {name} the fog behind hair is not dimmed by it"
            ));
        }
        let indirect = &args.indirect;
        if indirect.environment.is_some() || indirect.surface_scattering.is_some() {
            (input.notes).push(
                "hair is lit by the lights alone, not by the environment or by scattered light"
                    .into(),
            );
        }
        if indirect.ambient.ambient.is_some() {
            (input.notes).push("ambient light in the fog behind hair is not dimmed by it".into());
        }
    }

    /// The method of lights whose shadows are in files.
    pub(crate) fn of_files(&self, methods: &Registry) -> Result<Entry, Failure> {
        let [_, (airlight, _)] = self.entry.halves().ok_or_else(|| {
            Failure::new(format!(
                "--shadows needs a pair of visibility and airlight, which {} is not",
                self.entry.about().name
            ))
        })?;
        shadow_files::method(methods, airlight)
    }

    /// Refuses a size of maps that nothing uses.
    pub(crate) fn check_map(&self, args: &Render, input: &Input) -> Result<(), Failure> {
        let used = self.entry.uses_maps_of(&input.geometry)
            || !input.scene.translucent.is_empty()
            || (!args.shadows.is_empty() && input.geometry.dynamic_part().is_some())
            || args.indirect.surface_scattering == Some(SurfaceScattering::Shadowed);
        if args.options.map.is_some() && !used {
            return Err(Failure::new(format!(
                "--map is the size of shadow maps, and {} uses none",
                self.entry.about().name
            )));
        }
        Ok(())
    }

    pub(crate) fn describe(&self) -> String {
        let about = self.entry.about();
        format!("{} with {} {}", about.name, self.quality, about.quality)
    }
}
