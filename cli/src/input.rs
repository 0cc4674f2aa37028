//! A scene from the command line, ready to be measured or rendered.

use std::path::Path;
use std::sync::Arc;

use gpu_backend::Host;
use lighting::Emitter;
use lighting::methods::{Store, tracer};
use lighting::scene::load::{LoadOptions, Loaded, scene_from_path};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{AreaEmitters, Bounds, Camera, Geometry, Medium, PhaseFunction, Scene};

use crate::args::{MediumOptions, Phase, SceneOptions};
use crate::failure::Failure;
use crate::format::count;
use crate::progress;

/// A checked scene with everything that does not depend on the picture.
pub(crate) struct Input {
    pub(crate) scene: Scene,
    pub(crate) geometry: Geometry,
    pub(crate) tracer: Arc<Tracer>,
    /// What methods share on the host, the tracer to begin with.
    pub(crate) host: Store<Host>,
    /// Every light as emitters, area lights as several.
    pub(crate) emitters: Vec<Emitter>,
    /// Of which light of the scene each of them is.
    owners: Vec<usize>,
    /// What was placed, assumed or ignored.
    pub(crate) notes: Vec<String>,
}

impl Input {
    /// Reads or builds the scene that `name` stands for.
    pub(crate) fn load(name: &str, options: &SceneOptions) -> Result<Self, Failure> {
        let spinner = progress::spinner("loading the scene");
        let Loaded {
            mut scene,
            mut notes,
            ..
        } = read(name, options.seed)?;
        let about = |failure: Failure| failure.about(name);
        for meant in &options.no_shadow {
            if scene.set_casts_shadow(meant, false) == 0 {
                return Err(Failure::new(format!(
                    "--no-shadow {meant}: no object, mesh or material has that name"
                ))
                .about(name));
            }
        }
        notes.extend(scene.lay_floor().map(|floor| floor.to_string()));
        let geometry = Geometry::new(&scene).map_err(|error| about(error.into()))?;
        if geometry.dropped() > 0 {
            notes.push(format!(
                "{} without area left out",
                count(geometry.dropped(), "triangle")
            ));
        }
        for caster in &scene.translucent {
            notes.push(format!("translucent: {}", caster.describe()));
        }
        let bounds = match scene.translucent_bounds() {
            Some(bounds) => bounds.around(geometry.bounds()),
            None => geometry.bounds(),
        };
        let placed = scene
            .complete(bounds)
            .map_err(|error| about(error.into()))?;
        notes.extend(placed.iter().map(ToString::to_string));
        set_medium(&mut scene, bounds, &options.medium, &mut notes)?;
        let (mut emitters, mut owners) = (Vec::new(), Vec::new());
        for (index, light) in scene.lights.iter().enumerate() {
            let found = light.emitters(options.lights);
            emitters.extend(found.map_err(|error| about(error.into()))?);
            owners.resize(emitters.len(), index);
        }
        let host = Store::new();
        let tracer = tracer(&host, &geometry)?;
        spinner.finish_and_clear();
        Ok(Self {
            scene,
            geometry,
            tracer,
            host,
            emitters,
            owners,
            notes,
        })
    }

    /// How many lights the reference takes the time of: emitters, and for area
    /// lights the points at which it looks at each, about 400.
    pub(crate) fn counted_lights(&self) -> usize {
        let all: Vec<usize> = (0..self.emitters.len()).collect();
        let areas = self.areas(&all).len();
        self.emitters.len() + 400 * areas
    }

    /// The area lights of some of the emitters, which are numbered anew.
    pub(crate) fn areas(&self, emitters: &[usize]) -> Vec<AreaEmitters> {
        let owners: Vec<usize> = emitters.iter().map(|index| self.owners[*index]).collect();
        AreaEmitters::find(&self.scene.lights, &owners)
    }

    /// The scene's camera.
    pub(crate) fn camera(&self) -> Result<Camera, Failure> {
        self.scene
            .camera
            .ok_or_else(|| Failure::new("the scene has no camera, and none could be placed"))
    }

    /// [`Input::light_kinds`] as a noun: `point light`, `165 spot lights`.
    pub(crate) fn lights(&self) -> String {
        let plural = if self.scene.lights.len() == 1 {
            ""
        } else {
            "s"
        };
        format!("{} light{plural}", self.light_kinds())
    }

    /// Kinds of lights with their numbers: `point`, `165 spot`, `1 directional
    /// + 4 spot`.
    pub(crate) fn light_kinds(&self) -> String {
        let mut kinds: Vec<(&str, usize)> = Vec::new();
        for light in &self.scene.lights {
            match kinds.iter_mut().find(|(kind, _)| *kind == light.kind()) {
                Some((_, number)) => *number += 1,
                None => kinds.push((light.kind(), 1)),
            }
        }
        match kinds[..] {
            [] => "no".into(),
            [(kind, 1)] => kind.into(),
            _ => {
                let texts = kinds
                    .iter()
                    .map(|(kind, number)| format!("{number} {kind}"));
                texts.collect::<Vec<_>>().join(" + ")
            }
        }
    }
}

/// The embedded scene of that name, or else the file.
fn read(name: &str, seed: Option<u64>) -> Result<Loaded, Failure> {
    if let Some(embedded) = Embedded::from_name(name) {
        return Ok(Loaded {
            scene: embedded.build(seed.unwrap_or(1)),
            ..Loaded::default()
        });
    }
    let path = Path::new(name);
    if !path.exists() {
        let names: Vec<&str> = Embedded::ALL.iter().map(|scene| scene.name()).collect();
        return Err(Failure::new(format!(
            "there is no file {name}, and no embedded scene of that name; embedded scenes are {}",
            names.join(", ")
        )));
    }
    if seed.is_some() {
        return Err(Failure::new(format!(
            "--seed is that of an embedded scene, and {name} is a file"
        )));
    }
    let mut loaded = scene_from_path(path, &LoadOptions::default())
        .map_err(|error| Failure::from(error).about(name))?;
    if let Some(stem) = path.file_name() {
        loaded.scene.name = stem.to_string_lossy().into_owned();
    }
    Ok(loaded)
}

/// Applies the options; fills a scene that has no medium with fog unless they
/// say what it holds.
fn set_medium(
    scene: &mut Scene,
    bounds: Bounds,
    options: &MediumOptions,
    notes: &mut Vec<String>,
) -> Result<(), Failure> {
    let coefficients_given = options.sigma_s.is_some() || options.sigma_a.is_some();
    if scene.medium.is_none() {
        if coefficients_given {
            let zero = glam::Vec3::ZERO;
            scene.medium = Some(Medium::new(zero, zero, PhaseFunction::Isotropic)?);
        } else if let Some(placement) = scene.fill_with_fog(bounds)? {
            notes.push(placement.to_string());
        }
    }
    let Some(old) = scene.medium else {
        return Ok(());
    };
    let phase = phase_function(options, old.phase())?;
    let sigma_s = options.sigma_s.unwrap_or(old.sigma_s());
    let sigma_a = options.sigma_a.unwrap_or(old.sigma_a());
    let medium = Medium::new(sigma_s, sigma_a, phase)?;
    let vacuum = sigma_s == glam::Vec3::ZERO && sigma_a == glam::Vec3::ZERO;
    scene.medium = match options.medium_box.or(old.bounds()) {
        _ if vacuum => None,
        Some(bounds) => Some(medium.within(bounds)),
        None => Some(medium),
    };
    Ok(())
}

fn phase_function(options: &MediumOptions, old: PhaseFunction) -> Result<PhaseFunction, Failure> {
    let own = match old {
        PhaseFunction::Isotropic => (Phase::Isotropic, None),
        PhaseFunction::Rayleigh => (Phase::Rayleigh, None),
        PhaseFunction::HenyeyGreenstein { g } => (Phase::Hg, Some(g)),
        PhaseFunction::CornetteShanks { g } => (Phase::CornetteShanks, Some(g)),
        PhaseFunction::Schlick { k } => (Phase::Schlick, Some(k)),
    };
    let kind = match (options.phase, options.g) {
        (None, None) => return Ok(old),
        (Some(kind), _) => kind,
        // A parameter alone is that of the scene's function, if it has one.
        (None, Some(_)) if own.1.is_some() => own.0,
        (None, Some(_)) => Phase::Hg,
    };
    let parameter = options.g.or(own.1.filter(|_| kind == own.0));
    match (kind, options.g) {
        (Phase::Isotropic, None) => return Ok(PhaseFunction::Isotropic),
        (Phase::Rayleigh, None) => return Ok(PhaseFunction::Rayleigh),
        (Phase::Isotropic | Phase::Rayleigh, Some(_)) => {
            let message = "--g goes with --phase hg, cornette-shanks and schlick only";
            return Err(Failure::new(message));
        }
        _ => {}
    }
    let Some(g) = parameter else {
        let name = match kind {
            Phase::CornetteShanks => "cornette-shanks",
            Phase::Schlick => "schlick",
            _ => "hg",
        };
        return Err(Failure::new(format!(
            "--phase {name} needs its parameter: --g"
        )));
    };
    Ok(match kind {
        Phase::CornetteShanks => PhaseFunction::CornetteShanks { g },
        Phase::Schlick => PhaseFunction::Schlick { k: g },
        _ => PhaseFunction::HenyeyGreenstein { g },
    })
}

/// The medium in words.
pub(crate) fn describe_medium(medium: Option<&Medium>) -> String {
    let Some(medium) = medium else {
        return "vacuum".into();
    };
    let coefficient = |value: glam::Vec3| {
        let text = |v: f32| crate::format::significant(f64::from(v));
        if value.x == value.y && value.y == value.z {
            text(value.x)
        } else {
            format!("({}, {}, {})", text(value.x), text(value.y), text(value.z))
        }
    };
    let phase = describe_phase(medium.phase());
    let place = if medium.bounds().is_some() {
        "in a box"
    } else {
        "everywhere"
    };
    format!(
        "fog of σ_s {} and σ_a {} per metre ({phase}) {place}",
        coefficient(medium.sigma_s()),
        coefficient(medium.sigma_a())
    )
}

/// The phase function in words.
pub(crate) fn describe_phase(phase: PhaseFunction) -> String {
    match phase {
        PhaseFunction::Isotropic => "isotropic".into(),
        PhaseFunction::Rayleigh => "Rayleigh".into(),
        PhaseFunction::HenyeyGreenstein { g } => format!("Henyey-Greenstein, g = {g}"),
        PhaseFunction::CornetteShanks { g } => format!("Cornette-Shanks, g = {g}"),
        PhaseFunction::Schlick { k } => format!("Schlick, k = {k}"),
    }
}
