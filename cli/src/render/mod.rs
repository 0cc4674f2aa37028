//! One picture: surfaces and airlight.

mod baked;
mod chosen;
mod hair;
mod layers;
mod light;
mod quickest;

use std::cell::OnceCell;
use std::path::Path;
use std::sync::Arc;

use gpu_backend::Cpu;
use lighting::methods::{Entry, FROM_FILE, Registry};
use lighting::plan::{Plan, Subject};
use lighting::prediction::Target;
use lighting::scene::view::View;
use lighting::scene::{Camera, Medium};
use lighting::translucent::TransmittanceMap;

use crate::args::{Render, SurfaceShadows};
use crate::devices::{self, BackendName, Device};
use crate::failure::Failure;
use crate::format::{count, significant};
use crate::input::{Input, describe_media};
use crate::output::PendingFile;
use crate::parse::Size;
use crate::picture::Picture;
use crate::print::{complain, note};
use crate::shadow_files::Shadows;
use crate::{indirect, progress, shadow_files, surfaces};
use chosen::Chosen;
use hair::Hair;
use light::Job;

/// Formats by file name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

impl Format {
    fn of(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Failure::new(format!(
                "cannot write {}: its name must end in .png or .exr",
                path.display()
            ))),
        }
    }
}

/// Runs `crepuscular render`.
pub(crate) fn run(methods: &Registry, args: &Render) -> Result<(), Failure> {
    let format = Format::of(&args.output)?;
    if format == Format::Exr && args.exposure.is_some() {
        return Err(Failure::new(
            "--exposure applies to PNG files only; an EXR file holds linear radiance",
        ));
    }
    if format == Format::Png && args.layers {
        return Err(Failure::new(
            "--layers needs an EXR file, which can hold more channels",
        ));
    }
    let size = (args.size.of_rays(args.spp)).map_err(|why| Failure::new(why).about("--spp"))?;
    let environment = args.indirect.environment.as_deref().map(Path::new);
    let inputs: Vec<&Path> = environment.into_iter().collect();
    let file = PendingFile::beside(&args.output, &inputs)?;
    let target = args.error.map(Target::Error);
    let target = target.or(args.time.map(Target::Time));
    let (chosen, device, expected) = match target {
        Some(target) => {
            let (chosen, device, expected) = Chosen::foreseen(methods, args, size, target)?;
            (chosen, Some(device), expected)
        }
        None => {
            let device = args.backend.name().map(devices::find_one).transpose()?;
            (Chosen::new(methods, args)?, device, Vec::new())
        }
    };
    let mut input = Input::for_picture(&args.scene, &args.options, args.size)?;
    let chosen = chosen.for_media(methods, args, &mut input);
    input.notes.extend(expected);
    if target.is_none() {
        chosen.check_map(args, &input)?;
    }
    if args.layers {
        layers::check(args.size, input.scene.lights.len())?;
    }
    let camera = input.camera()?;
    if let Some(colour) = args.hair_colour {
        hair::paint(&mut input.scene, colour)?;
    }
    let spinner = progress::spinner("camera rays");
    let view = View::new(&Cpu::new(), &camera, &input.tracer, size.width, size.height)?;
    let (hair, view) = Hair::before(view, &camera, &input.scene, args.fibre);
    spinner.finish_and_clear();
    if hair.is_some() {
        chosen.note_hair(args, &mut input);
    } else if args.fibre.is_some() || args.hair_colour.is_some() {
        return Err(Failure::new(
            "--fibre and --hair-colour apply to hair, and the scene has none",
        ));
    }
    let shadows = shadow_files::read(&args.shadows, &input)?;
    if shadows.iter().any(Option::is_some) && !input.scene.translucent.is_empty() {
        (input.notes).push("hair and smoke cast no shadow on surfaces with --shadows".into());
    }
    let plan = Plan::of_media(&input.emitters, &input.media(), view.rays());
    let device = match device {
        Some(device) => device,
        None => {
            let cpu = devices::find_one(BackendName::Cpu)?;
            let work = input.medium_of_air().map(|medium| {
                let job = Job {
                    args,
                    size,
                    camera: &camera,
                    view: &view,
                    medium: &medium,
                    device: &cpu,
                    maps: &[],
                };
                job.work(&input, plan.emitters(), (&chosen.entry, chosen.quality))
            });
            let work = work.unwrap_or_default();
            let (device, why) = quickest::device(&chosen, &work, view.rays().len())?;
            input.notes.extend(why);
            device
        }
    };
    let mut shot = Shot {
        methods,
        args,
        size,
        medium: input.medium_of_air(),
        camera,
        view: &view,
        device: &device,
        chosen: &chosen,
        shadows: &shadows,
        hair,
        maps: OnceCell::new(),
        kept: plan.emitters().to_vec(),
        unshadowed: None,
    };
    let plan = shot.planned(plan, &input)?;
    for part in plan.left_out() {
        let is_of_lights = match &part.subject {
            Subject::Airlight | Subject::Emitters(_) => true,
            Subject::Shadows(emitters) => (shot.unshadowed.as_ref())
                .is_some_and(|all| emitters.iter().all(|index| all.emitters.contains(index))),
            _ => false,
        };
        if is_of_lights {
            let mut part = part.clone();
            if !chosen.entry.about().uses_shadow_map {
                (part.saving.texels, part.saving.bytes) = (0, 0);
            }
            (input.notes).push(format!("left out: {} ({})", part.subject, part.why()));
        }
    }
    let (picture, content) = shot.taken(&mut input, format)?;
    let odd = picture.non_finite();
    if odd > 0 {
        complain(&format!(
            "warning: {odd} of {} pixels are not finite; a PNG shows them in magenta",
            picture.pixels.len()
        ));
    }
    let written = file.finish(&content)?;
    let described = describe_media(&input.media());
    // Each light has the same to say.
    let mut notes: Vec<String> = Vec::new();
    for note in input.notes {
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    note(&notes);
    let from_files = shadows.iter().flatten().count();
    let method = match from_files {
        0 => chosen.describe(),
        _ if from_files == input.emitters.len() => "precomputed shadows".into(),
        _ => format!(
            "precomputed shadows of {}, {}",
            count(from_files, "light"),
            chosen.describe()
        ),
    };
    written.summarise(&format!(
        "{}: {} in {}, {method}",
        args.output.display(),
        args.size,
        described,
    ))
}

/// A picture that is being taken. Pictures that it returns have the size that was
/// asked for.
struct Shot<'a> {
    methods: &'a Registry,
    args: &'a Render,
    /// Size of the picture of all rays.
    size: Size,
    medium: Option<Medium>,
    camera: Camera,
    view: &'a View,
    device: &'a Device,
    chosen: &'a Chosen,
    shadows: &'a Shadows,
    hair: Option<Hair>,
    /// The light of each emitter that translucent casters let through, once it is asked for.
    maps: OnceCell<Vec<Arc<TransmittanceMap>>>,
    /// The emitters that the plan keeps for the air.
    kept: Vec<usize>,
    /// The unshadowed ones among them, if the picture makes use of that.
    unshadowed: Option<Unshadowed>,
}

/// Unshadowed emitters, and the method that gathers their light.
struct Unshadowed {
    emitters: Vec<usize>,
    entry: Entry,
    quality: u32,
}

impl Shot<'_> {
    /// The plan, which takes casters into account and divides the lights of the air.
    fn planned(&mut self, plan: Plan, input: &Input) -> Result<Plan, Failure> {
        let Some(medium) = self.medium.filter(|_| !self.args.all_shadows) else {
            return Ok(plan);
        };
        let Chosen { entry, quality } = self.chosen;
        let (plan, mut emitters) = self.job(&medium).planned(plan, input, entry)?;
        emitters.retain(|index| self.shadows[*index].is_none());
        if !emitters.is_empty() {
            let closed = self.methods.unshadowed(entry, *quality);
            self.unshadowed = closed.map(|(entry, quality)| Unshadowed {
                emitters,
                entry,
                quality,
            });
        }
        Ok(plan)
    }

    /// The picture, and the file that holds it.
    fn taken(&self, input: &mut Input, format: Format) -> Result<(Picture, Vec<u8>), Failure> {
        if self.args.layers {
            let layers = layers::Layers::of(self, input)?;
            return Ok((layers.picture.clone(), layers.exr()?));
        }
        let all: Vec<usize> = (0..input.emitters.len()).collect();
        let mut picture = self.surfaces(input, &all)?;
        if let Some(indirect) = self.indirect(input)? {
            picture = picture.plus(&indirect);
        }
        if let Some(airlight) = self.airlight(input, &self.kept)? {
            picture = picture.plus(&airlight);
        }
        if let Some(emission) = self.emission(input)? {
            picture = picture.plus(&emission);
        }
        if format == Format::Exr {
            let content = picture.exr()?;
            return Ok((picture, content));
        }
        let exposure = self.args.exposure;
        let exposure = exposure.unwrap_or_else(|| picture.automatic_exposure());
        input.notes.push(format!(
            "exposure {} stops (--exposure)",
            significant(f64::from(exposure))
        ));
        let content = picture.png(exposure)?;
        Ok((picture, content))
    }

    /// What all rays see, as pixels.
    fn pixels(&self, radiance: &[[f32; 4]]) -> Picture {
        Picture::new(self.size, radiance).averaged(self.args.spp.side)
    }

    /// The light of surfaces that some emitters send.
    fn surfaces(&self, input: &mut Input, emitters: &[usize]) -> Result<Picture, Failure> {
        let spinner = progress::spinner("surfaces");
        let way = self.args.surface_shadows.unwrap_or(SurfaceShadows::Traced);
        if way != SurfaceShadows::Traced && !emitters.is_empty() {
            spinner.finish_and_clear();
            return self.surfaces_from_voxels(input, emitters, way);
        }
        let shadows: Shadows = emitters.iter().map(|i| self.shadows[*i].clone()).collect();
        let maps = self.maps(input, emitters)?;
        let lights = input.picked(emitters);
        let radiance = baked::of_surfaces(
            self.args,
            input,
            (self.view, self.device),
            &lights,
            &shadows,
            &maps,
        )?;
        let mut picture = self.pixels(&radiance);
        if let Some(hair) = self.hair(input, emitters)? {
            picture = picture.plus(&hair);
        }
        spinner.finish_and_clear();
        Ok(picture)
    }

    /// The same with the shadows that the method of the airlight knows.
    fn surfaces_from_voxels(
        &self,
        input: &mut Input,
        emitters: &[usize],
        way: SurfaceShadows,
    ) -> Result<Picture, Failure> {
        let Chosen { entry, quality } = self.chosen;
        let refused = |why: String| Failure::new(why).about("--surface-shadows");
        if entry
            .on::<Cpu>()
            .is_none_or(|method| method.surfaces().is_none())
        {
            let name = entry.about().name;
            return Err(refused(format!(
                "{name} has no shadows on surfaces; methods for area lights do"
            )));
        }
        let Some(medium) = &input.scene.medium.clone() else {
            return Err(refused(
                "the scene has no fog, and the voxels come from the method for the airlight".into(),
            ));
        };
        if input.geometry.coatings().any_see_through() || !input.scene.translucent.is_empty() {
            input.notes.push(
                "see-through surfaces, hair and smoke cast no shadow on surfaces from voxels"
                    .into(),
            );
        }
        let emitted = self.surfaces(input, &[])?;
        let interpolate = way == SurfaceShadows::Interpolated;
        let job = self.job(medium);
        let lit = job.on_surfaces(input, emitters, (entry, *quality), interpolate)?;
        let picture = emitted.plus(&self.pixels(&lit));
        let hair = self.hair(input, emitters)?;
        Ok(hair.map_or(picture.clone(), |hair| picture.plus(&hair)))
    }

    /// The maps of some emitters; none if nothing is translucent.
    fn maps(&self, input: &Input, emitters: &[usize]) -> Result<Vec<&TransmittanceMap>, Failure> {
        let all = match self.maps.get() {
            Some(all) => all,
            None => {
                let made = surfaces::maps(input, self.args.options.map())?;
                self.maps.get_or_init(|| made)
            }
        };
        Ok(emitters
            .iter()
            .filter_map(|i| Some(all.get(*i)?.as_ref()))
            .collect())
    }

    /// The light of hair that some emitters send; `None` if there is none.
    fn hair(&self, input: &mut Input, emitters: &[usize]) -> Result<Option<Picture>, Failure> {
        let Some(hair) = self.hair.as_ref().filter(|_| !emitters.is_empty()) else {
            return Ok(None);
        };
        let maps = self.maps(input, emitters)?;
        let lights = input.picked(emitters);
        let radiance = hair.radiance((self.view, self.device), input, &lights, &maps)?;
        Ok(Some(self.pixels(&radiance)))
    }

    /// Everything that is the same for all lights.
    fn job<'a>(&'a self, medium: &'a Medium) -> Job<'a> {
        Job {
            args: self.args,
            size: self.size,
            camera: &self.camera,
            view: self.view,
            medium,
            device: self.device,
            maps: self.maps.get().map_or(&[], Vec::as_slice),
        }
    }

    /// The light by way of the fog and from all around, if it is asked for.
    fn indirect(&self, input: &mut Input) -> Result<Option<Picture>, Failure> {
        let map = self.args.options.map();
        let options = &self.args.indirect;
        let radiance = indirect::radiance(options, map, self.device, input, self.view)?;
        Ok(radiance.map(|radiance| self.pixels(&radiance)))
    }

    /// The light that smoke emits; nothing if it is dark.
    fn emission(&self, input: &Input) -> Result<Option<Picture>, Failure> {
        let radiance = light::of_media(input, self.view, self.device)?;
        Ok(radiance.map(|radiance| self.pixels(&radiance)))
    }

    /// The light of some emitters that the air scatters; nothing if there is none.
    fn airlight(&self, input: &mut Input, emitters: &[usize]) -> Result<Option<Picture>, Failure> {
        let Some(medium) = self.medium else {
            return Ok(None);
        };
        let job = self.job(&medium);
        let (from_files, others): (Vec<usize>, Vec<usize>) =
            (emitters.iter()).partition(|index| self.shadows[**index].is_some());
        let Chosen { entry, quality } = self.chosen;
        let mut sum: Option<Picture> = None;
        let mut add = |picture: Picture| {
            sum = Some(match &sum {
                Some(sum) => sum.plus(&picture),
                None => picture,
            });
        };
        let is_unshadowed = |index: &usize| {
            let all = self.unshadowed.as_ref();
            all.is_some_and(|all| all.emitters.contains(index))
        };
        let (unshadowed, shadowed): (Vec<usize>, Vec<usize>) =
            others.into_iter().partition(is_unshadowed);
        if !shadowed.is_empty() {
            add(job.airlight(input, &shadowed, entry, *quality, &[])?);
        }
        if let Some(closed) = &self.unshadowed
            && !unshadowed.is_empty()
        {
            add(job.airlight(input, &unshadowed, &closed.entry, closed.quality, &[])?);
        }
        if !from_files.is_empty() {
            let entry = self.chosen.of_files(self.methods)?;
            let own: Shadows = from_files
                .iter()
                .map(|i| self.shadows[*i].clone())
                .collect();
            add(job.airlight(input, &from_files, &entry, FROM_FILE, &own)?);
        }
        Ok(sum.map(|sum| sum.averaged(self.args.spp.side)))
    }
}
