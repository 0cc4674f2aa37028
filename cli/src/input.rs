//! A scene from the command line, ready to be measured or rendered.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use gpu_backend::Host;
use lighting::Emitter;
use lighting::methods::{Store, tracer};
use lighting::scene::load::{Loaded, scene_from_path};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{
    AreaEmitters, Bounds, Camera, Geometry, Light, Media, Medium, PhaseFunction, Scene, SceneError,
    Translucent,
};

use crate::args::{MediumOptions, Phase, SceneOptions};
use crate::failure::Failure;
use crate::format::count;
use crate::parse::Size;
use crate::{progress, suggest};

/// A checked scene with everything that does not depend on the picture.
pub(crate) struct Input {
    pub(crate) scene: Scene,
    pub(crate) geometry: Geometry,
    pub(crate) tracer: Arc<Tracer>,
    /// The store of everything that methods share on the host; at the beginning it holds the
    /// tracer.
    pub(crate) host: Store<Host>,
    /// Every light as emitters, area lights as several.
    pub(crate) emitters: Vec<Emitter>,
    /// Whether any triangle stays, but for a ground that was laid.
    stays: bool,
    /// Which emitters each light consists of.
    pub(crate) of_light: Vec<Range<usize>>,
    /// What was placed, assumed or ignored.
    pub(crate) notes: Vec<String>,
}

impl Input {
    /// All that fills the air.
    pub(crate) fn media(&self) -> Media<'_> {
        Media::of(&self.scene)
    }

    /// The homogeneous medium of the air; a vacuum where there are other media alone, and
    /// `None` if there are none.
    pub(crate) fn medium_of_air(&self) -> Option<Medium> {
        let has_others = !self.media().is_homogeneous();
        self.scene.medium.or(has_others.then_some(Medium::VACUUM))
    }

    /// Reads or builds the scene that `name` stands for, to be seen in pictures that
    /// are as wide as high, or wider.
    pub(crate) fn load(name: &str, options: &SceneOptions) -> Result<Self, Failure> {
        Self::for_pictures(name, options, 1.0)
    }

    /// The same for pictures of one size.
    pub(crate) fn for_picture(
        name: &str,
        options: &SceneOptions,
        size: Size,
    ) -> Result<Self, Failure> {
        let aspect = f64::from(size.width) / f64::from(size.height);
        // No viewer would step back as far as it takes to see all of the scene through a narrow
        // slit.
        Self::for_pictures(name, options, aspect.clamp(0.5, 4.0) as f32)
    }

    fn for_pictures(name: &str, options: &SceneOptions, aspect: f32) -> Result<Self, Failure> {
        let spinner = progress::spinner("loading the scene");
        let Loaded {
            mut scene,
            mut notes,
            offset,
        } = read(name, options)?;
        let about = |failure: Failure| failure.about(name);
        let is_bare = scene.camera.is_none() && scene.lights.is_empty();
        options.surroundings.place(&mut scene, offset)?;
        let for_file = options.file.for_file();
        (options.added).add(&mut scene, offset, &for_file, &mut notes)?;
        for meant in &options.no_shadow {
            let found = scene.set_casts_shadow(meant, false);
            check_name(&scene, ("--no-shadow", meant), found).map_err(about)?;
        }
        for meant in &options.dynamic {
            let found = scene.set_dynamic(meant, true);
            check_name(&scene, ("--dynamic", meant), found).map_err(about)?;
        }
        let floor = scene.lay_floor();
        notes.extend(floor.as_ref().map(ToString::to_string));
        let mut geometry = Geometry::new(&scene).map_err(|error| about(error.into()))?;
        if geometry.dropped() > 0 {
            notes.push(format!(
                "{} without area left out",
                count(geometry.dropped(), "triangle")
            ));
        }
        for caster in &scene.translucent {
            notes.push(format!("translucent: {}", caster.describe()));
        }
        let part = geometry.static_part();
        // What is placed here must not depend on what moves.
        let (any, stays) = (part.is_some(), part.unwrap_or(&geometry));
        let mut bounds = self::bounds(&scene, stays);
        // A ground that was laid below hair and smoke need not be in view.
        let solid = if floor.is_none() {
            stays.triangles()
        } else {
            &[]
        };
        let points = solid.as_flattened().iter().copied();
        let points = points.chain(translucent_corners(&scene));
        let placed = scene.complete_around(bounds, points, aspect);
        let placed = placed.map_err(|error| about(error.into()))?;
        options
            .surroundings
            .brighten(&mut scene, 0.5 * (bounds.min() + bounds.max()));
        notes.extend(placed.iter().map(ToString::to_string));
        if is_bare
            && !options.surroundings.no_ground
            && let Some(ground) = scene.lay_ground(stays)
        {
            notes.push(ground.to_string());
            geometry = Geometry::new(&scene).map_err(|error| about(error.into()))?;
        }
        if is_bare {
            // The light and the camera are outside of the model; what is clear enough for
            // these paths lets it be seen.
            bounds = surroundings(bounds).map_err(|error| about(error.into()))?;
        }
        set_medium(&mut scene, bounds, &options.medium, &mut notes)?;
        let (mut emitters, mut of_light) = (Vec::new(), Vec::new());
        for light in &scene.lights {
            let begin = emitters.len();
            let found = light.emitters(options.lights);
            emitters.extend(found.map_err(|error| about(error.into()))?);
            of_light.push(begin..emitters.len());
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
            stays: any,
            of_light,
            notes,
        })
    }

    /// The casters whose shadows files have.
    pub(crate) fn casters_that_stay(&self) -> Result<&Geometry, Failure> {
        let part = self.geometry.static_part().filter(|_| self.stays);
        part.ok_or_else(|| {
            Failure::new("all triangles are dynamic, so there are no shadows to precompute")
        })
    }

    /// How many lights the reference takes the time of: emitters, and for area
    /// lights the points at which it looks at each, about 400.
    pub(crate) fn counted_lights(&self) -> usize {
        let all: Vec<usize> = (0..self.emitters.len()).collect();
        let areas = self.areas(&all).len();
        self.emitters.len() + 400 * areas
    }

    /// Triangles, and what hair and smoke consist of; a grid counts as one.
    pub(crate) fn counted_casters(&self) -> usize {
        let pieces = self.scene.translucent.iter().map(|caster| match caster {
            Translucent::Strands(strands) => strands.piece_count(),
            Translucent::Grid(_) => 1,
            Translucent::Particles(particles) => particles.all().len(),
        });
        self.geometry.triangles().len() + pieces.sum::<usize>()
    }

    /// The area lights of some of the emitters, which are numbered anew.
    pub(crate) fn areas(&self, emitters: &[usize]) -> Vec<AreaEmitters> {
        self.areas_of(&self.scene.lights, emitters)
    }

    /// The same where the lights of the scene have moved.
    pub(crate) fn areas_of(&self, lights: &[Light], emitters: &[usize]) -> Vec<AreaEmitters> {
        let owner = |emitter: &usize| {
            let has_it = |range: &Range<usize>| range.contains(emitter);
            self.of_light.iter().position(has_it)
        };
        let owners: Vec<usize> = emitters.iter().filter_map(owner).collect();
        AreaEmitters::find(lights, &owners)
    }

    /// The scene's camera.
    pub(crate) fn camera(&self) -> Result<Camera, Failure> {
        self.scene
            .camera
            .ok_or_else(|| Failure::new("the scene has no camera, and no place for one was found"))
    }

    /// The emitters of these numbers.
    pub(crate) fn picked(&self, indices: &[usize]) -> Vec<Emitter> {
        let emitters = indices.iter().map(|index| self.emitters[*index].clone());
        emitters.collect()
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

/// A box around all that is in the scene.
fn bounds(scene: &Scene, geometry: &Geometry) -> Bounds {
    match scene.translucent_bounds() {
        Some(bounds) => bounds.around(geometry.bounds()),
        None => geometry.bounds(),
    }
}

/// The cube that is twice as large as the ball around a box.
fn surroundings(bounds: Bounds) -> Result<Bounds, SceneError> {
    let [min, max] = [bounds.min(), bounds.max()];
    let (centre, radius) = (0.5 * (min + max), 0.5 * (max - min).length());
    Bounds::new(centre - 2.0 * radius, centre + 2.0 * radius)
}

/// The corners of the box around all that is translucent.
fn translucent_corners(scene: &Scene) -> impl Iterator<Item = Vec3> + use<> {
    let bounds = scene.translucent_bounds().into_iter();
    bounds.flat_map(|bounds| bounds.corners())
}

/// Refuses a name of an option that nothing has.
fn check_name(scene: &Scene, (option, name): (&str, &str), found: usize) -> Result<(), Failure> {
    if found > 0 {
        return Ok(());
    }
    let objects = scene.instances.iter().map(|instance| &instance.name);
    let meshes = scene.meshes.iter().map(|mesh| &mesh.name);
    let materials = scene.materials.iter().map(|material| &material.name);
    let names = objects.chain(meshes).chain(materials);
    Err(Failure::new(format!(
        "{option} {name}: no object, mesh or material has that name{}",
        suggest::question(name, names)
    )))
}

/// The embedded scene of that name, or else the file.
fn read(name: &str, options: &SceneOptions) -> Result<Loaded, Failure> {
    let SceneOptions { seed, file, .. } = options;
    if let Some(embedded) = Embedded::from_name(name) {
        let no_ground = options.surroundings.no_ground.then_some("--no-ground");
        let of_file = file.first_given().filter(|_| options.added.is_empty());
        if let Some(option) = of_file.or(no_ground) {
            return Err(Failure::new(format!(
                "{option} applies to files, and {name} is an embedded scene"
            )));
        }
        return Ok(Loaded {
            scene: embedded.build(seed.unwrap_or(1)),
            ..Loaded::default()
        });
    }
    let path = Path::new(name);
    if !path.exists() {
        return Err(no_scene(name));
    }
    if seed.is_some() {
        return Err(Failure::new(format!(
            "--seed applies to embedded scenes, and {name} is a file"
        )));
    }
    let mut loaded = scene_from_path(path, &file.for_file())
        .map_err(|error| Failure::from(error).about(name))?;
    if let Some(stem) = path.file_name() {
        loaded.scene.name = stem.to_string_lossy().into_owned();
    }
    Ok(loaded)
}

/// The message if there is no such scene.
fn no_scene(name: &str) -> Failure {
    /// Files of a folder that are compared with the name.
    const FILES: usize = 10_000;
    let path = Path::new(name);
    let folder = path.parent().unwrap_or(Path::new(""));
    let place = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let files = std::fs::read_dir(place).into_iter().flatten().flatten();
    let files = files.take(FILES).filter_map(|file| {
        let file = folder.join(file.file_name());
        let extension = file.extension()?.to_string_lossy().to_lowercase();
        let known = ["gltf", "glb", "ply", "obj", "hair", "vol", "nvdb", "vdb"];
        known
            .contains(&&*extension)
            .then(|| file.display().to_string())
    });
    let embedded: Vec<&str> = Embedded::listed().map(Embedded::name).collect();
    let names = files.chain(embedded.iter().map(ToString::to_string));
    Failure::new(format!(
        "there is no file {name}, and no embedded scene of that name{}; embedded scenes are {}",
        suggest::question(name, names),
        embedded.join(", ")
    ))
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
            let zero = Vec3::ZERO;
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
    let vacuum = sigma_s == Vec3::ZERO && sigma_a == Vec3::ZERO;
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
        // Those with several parameters cannot be named by one option.
        PhaseFunction::DoubleHenyeyGreenstein { .. }
        | PhaseFunction::HenyeyGreensteinDraine { .. } => (Phase::Hg, None),
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
            let message = "--g applies to --phase hg, cornette-shanks and schlick only";
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
            "--phase {name} needs its parameter --g"
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
    let coefficient = |value: Vec3| {
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

/// All that fills the air in words.
pub(crate) fn describe_media(media: &Media<'_>) -> String {
    let mut parts = Vec::new();
    if let Some(medium) = media.medium().filter(|medium| **medium != Medium::VACUUM) {
        parts.push(describe_medium(Some(medium)));
    }
    if let Some(fog) = media.height_fog() {
        parts.push(format!(
            "fog that thins out by e every {} m",
            crate::format::significant(f64::from(fog.scale_height()))
        ));
    }
    if !media.is_homogeneous() && media.boxes().next().is_some() {
        let smoke = media.boxes().count()
            - usize::from(
                media
                    .medium()
                    .is_some_and(|medium| medium.bounds().is_some()),
            );
        if smoke > 0 {
            parts.push("smoke".into());
        }
    }
    match &parts[..] {
        [] => "vacuum".into(),
        [first, rest @ ..] => rest
            .iter()
            .fold(first.clone(), |all, part| all + " and " + part),
    }
}

/// The phase function in words.
pub(crate) fn describe_phase(phase: PhaseFunction) -> String {
    match phase {
        PhaseFunction::Isotropic => "isotropic".into(),
        PhaseFunction::Rayleigh => "Rayleigh".into(),
        PhaseFunction::HenyeyGreenstein { g } => format!("Henyey-Greenstein, g = {g}"),
        PhaseFunction::CornetteShanks { g } => format!("Cornette-Shanks, g = {g}"),
        PhaseFunction::Schlick { k } => format!("Schlick, k = {k}"),
        PhaseFunction::DoubleHenyeyGreenstein { g: [a, b], weight } => {
            format!("double Henyey-Greenstein, g = {a} and {b}, weight {weight}")
        }
        PhaseFunction::HenyeyGreensteinDraine {
            g,
            draine_g,
            alpha,
            weight,
        } => format!(
            "Henyey-Greenstein, g = {g}, and Draine, g = {draine_g}, alpha = {alpha}, weight {weight}"
        ),
    }
}
