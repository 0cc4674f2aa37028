//! One picture: surfaces and airlight.

use std::path::Path;

use gpu_backend::gpu::Gpu;
use gpu_backend::{Cpu, Download};
use indicatif::ProgressBar;
use lighting::Watch;
use lighting::methods::{
    Entry, FROM_FILE, Frame, FrameInputs, GAUSS_NODES, MethodBackend, Registry, Store, Verdict,
};
use lighting::plan::{Plan, Reason};
use lighting::precomputed::FilterSize;
use lighting::scene::view::View;
use lighting::scene::{Camera, Medium};
use lighting::surface::{self, Lit};

use crate::args::{Render, SurfaceScattering};
use crate::devices::{self, Device};
use crate::failure::Failure;
use crate::format::{count, significant};
use crate::input::{Input, describe_medium};
use crate::output::PendingFile;
use crate::picture::Picture;
use crate::print::{complain, print};
use crate::shadow_files::Shadows;
use crate::{indirect, maps, progress, shadow_files, surfaces};

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
            "--exposure is that of a PNG; an EXR holds linear radiance",
        ));
    }
    let chosen = Chosen::new(methods, args)?;
    let file = PendingFile::create(&args.output)?;
    let (devices, _) = devices::find(&[args.backend])?;
    let mut input = Input::load(&args.scene, &args.options)?;
    chosen.check_map(args, &input)?;
    let cpu = Cpu::new();
    let camera = input.camera()?;
    let spinner = progress::spinner("surfaces");
    let view = View::new(
        &cpu,
        &camera,
        &input.tracer,
        args.size.width,
        args.size.height,
    )?;
    let shadows = shadow_files::read(&args.shadows, &input)?;
    let surfaces = light_surfaces(args, &mut input, &view, &shadows)?;
    spinner.finish_and_clear();
    let mut picture = Picture::new(args.size, &surfaces);
    let map = args.options.map.unwrap_or(1024);
    let indirect = indirect::radiance(&args.indirect, map, &devices[0], &mut input, &view)?;
    if let Some(indirect) = indirect {
        picture = picture.plus(&Picture::new(args.size, &indirect));
    }

    let plan = Plan::new(&input.emitters, input.scene.medium.as_ref(), view.rays());
    for part in plan.left_out() {
        if part.reason != Reason::OnlyDirectionalLight {
            (input.notes).push(format!("left out: {} ({})", part.subject, part.reason));
        }
    }
    if let Some(medium) = input.scene.medium {
        let (from_files, others): (Vec<usize>, Vec<usize>) =
            (plan.emitters().iter()).partition(|index| shadows[**index].is_some());
        let job = Job {
            args,
            camera: &camera,
            view: &view,
            medium: &medium,
            device: &devices[0],
        };
        if !others.is_empty() {
            let airlight = job.airlight(&mut input, &others, &chosen.entry, chosen.quality, &[])?;
            picture = picture.plus(&airlight);
        }
        if !from_files.is_empty() {
            let entry = chosen.of_files(methods)?;
            let own: Shadows = from_files.iter().map(|i| shadows[*i].clone()).collect();
            let airlight = job.airlight(&mut input, &from_files, &entry, FROM_FILE, &own)?;
            picture = picture.plus(&airlight);
        }
    }
    let odd = picture.non_finite();
    if odd > 0 {
        complain(&format!(
            "warning: {odd} of {} pixels are not finite; a PNG shows them in magenta",
            picture.pixels.len()
        ));
    }
    let content = match format {
        Format::Exr => picture.exr()?,
        Format::Png => {
            let exposure = args
                .exposure
                .unwrap_or_else(|| picture.automatic_exposure());
            input.notes.push(format!(
                "exposure {} stops (--exposure)",
                significant(f64::from(exposure))
            ));
            picture.png(exposure)?
        }
    };
    file.finish(&content)?;
    let mut text = String::new();
    for note in &input.notes {
        text += &format!("note: {note}\n");
    }
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
    text += &format!(
        "{}: {} in {}, {method}\n",
        args.output.display(),
        args.size,
        describe_medium(input.scene.medium.as_ref()),
    );
    print(&text)
}

/// The light of surfaces, with the shadows of files where there are some.
fn light_surfaces(
    args: &Render,
    input: &mut Input,
    view: &View,
    shadows: &Shadows,
) -> Result<Vec<[f32; 4]>, Failure> {
    if shadows.iter().all(Option::is_none) {
        return surfaces::radiance(view, input, args.options.map.unwrap_or(1024));
    }
    if !input.scene.translucent.is_empty() {
        (input.notes).push("hair and smoke cast no shadow on surfaces with --shadows".into());
    }
    let filter = FilterSize::new(args.filter.unwrap_or(9))
        .map_err(|error| Failure::from(error).about("--filter"))?;
    let filtered: Vec<_> = shadows
        .iter()
        .map(|shadow| shadow.as_ref().map(|shadow| shadow.filtered(filter)))
        .collect();
    let lights: Vec<Lit<'_>> = (input.emitters.iter().zip(&filtered))
        .map(|(emitter, filtered)| (emitter, filtered.as_ref().map(|shadow| shadow as _)))
        .collect();
    Ok(surface::radiance_with(
        &Cpu::new(),
        view,
        &input.scene,
        &input.geometry,
        &input.tracer,
        &lights,
        input.scene.medium.as_ref(),
    ))
}

/// The method that the command line names.
struct Chosen {
    entry: Entry,
    quality: u32,
}

/// What pairs consist of unless something else is asked for.
const VISIBILITY: &str = "exact";
const AIRLIGHT: &str = "quadrature";

impl Chosen {
    fn new(methods: &Registry, args: &Render) -> Result<Self, Failure> {
        let entry = match &args.method {
            Some(name) => find(methods, name)?.clone(),
            None => {
                let visibility = args.visibility.as_deref().unwrap_or(VISIBILITY);
                let airlight = args.airlight.as_deref().unwrap_or(AIRLIGHT);
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
                    "--samples and --nodes are those of a pair; the quality of {} is --quality",
                    entry.about().name
                )));
            }
            let quality = args.quality.unwrap_or(entry.about().usual);
            return Ok(Self { entry, quality });
        };
        if args.samples.is_some() && steps.is_none() {
            return Err(Failure::new(format!(
                "--samples is a number of steps or voxels, and {visibility} visibility has none"
            )));
        }
        if args.nodes.is_some() && detail != Some(GAUSS_NODES) {
            return Err(Failure::new(format!(
                "--nodes is that of a quadrature with a number of nodes, which airlight by {airlight} is not"
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
                    "--nodes is the quality here: give one of the two",
                ));
            }
            (_, None) => (entry, given),
        };
        let quality = given.unwrap_or(entry.about().usual);
        Ok(Self { entry, quality })
    }

    /// The method of lights whose shadows are in files.
    fn of_files(&self, methods: &Registry) -> Result<Entry, Failure> {
        let [_, (airlight, _)] = self.entry.halves().ok_or_else(|| {
            Failure::new(format!(
                "--shadows goes with a pair of visibility and airlight, which {} is not",
                self.entry.about().name
            ))
        })?;
        shadow_files::method(methods, airlight)
    }

    /// Refuses a size of maps that nothing uses.
    fn check_map(&self, args: &Render, input: &Input) -> Result<(), Failure> {
        let used = self.entry.about().uses_shadow_map
            || !input.scene.translucent.is_empty()
            || args.indirect.surface_scattering == Some(SurfaceScattering::Shadowed);
        if args.options.map.is_some() && !used {
            return Err(Failure::new(format!(
                "--map is the size of shadow maps, and {} has none",
                self.entry.about().name
            )));
        }
        Ok(())
    }

    fn describe(&self) -> String {
        let about = self.entry.about();
        format!("{} with {} {}", about.name, self.quality, about.quality)
    }
}

/// The method of a name.
fn find<'a>(methods: &'a Registry, name: &str) -> Result<&'a Entry, Failure> {
    methods.find(name).ok_or_else(|| {
        let names: Vec<_> = methods.compared().map(|entry| entry.about().name).collect();
        Failure::new(format!(
            "no method is called \"{name}\", or several are; there are {}",
            names.join(", ")
        ))
    })
}

/// What is the same for all lights of a picture.
struct Job<'a> {
    args: &'a Render,
    camera: &'a Camera,
    view: &'a View,
    medium: &'a Medium,
    device: &'a Device,
}

impl Job<'_> {
    /// The airlight of some emitters by a method; `given` are shadows from files.
    fn airlight(
        &self,
        input: &mut Input,
        indices: &[usize],
        entry: &Entry,
        quality: u32,
        given: &[Option<shadow_files::Shadow>],
    ) -> Result<Picture, Failure> {
        let emitters = indices.iter().map(|index| input.emitters[*index].clone());
        let emitters = &emitters.collect::<Vec<_>>();
        let areas = &input.areas(indices);
        let asked = self.args.options.map.unwrap_or(1024);
        let map = if entry.about().uses_shadow_map {
            maps::affordable(asked, &input.geometry, emitters, &mut input.notes)
        } else {
            asked
        };
        // Lights are numbered anew.
        let host = Store::new();
        lighting::methods::share_tracer(&host, &input.tracer);
        for (light, shadow) in given.iter().enumerate() {
            if let Some(shadow) = shadow {
                lighting::methods::share_precomputed(&host, light, shadow);
            }
        }
        let rays = self.view.rays().len() * emitters.len();
        let bar = Bar(progress::bar("airlight", rays as u64));
        let inputs = FrameInputs {
            emitters,
            areas,
            medium: self.medium,
            geometry: &input.geometry,
            translucent: &input.scene.translucent,
            camera: self.camera,
            size: [self.args.size.width, self.args.size.height],
            rays: self.view.rays(),
            hits: self.view.hits(),
            map,
            host: &host,
            watch: &bar,
        };
        match entry.method().applies(&inputs) {
            Verdict::Impossible(why) => {
                let name = entry.about().name;
                return Err(Failure::new(format!("{name}: {why}")));
            }
            Verdict::Applies | Verdict::Pointless(_) => {}
        }
        let notes = entry.method().notes(&inputs);
        let radiance = match &self.device.context {
            None => run_on(&Cpu::new(), &host, inputs, entry, quality)?,
            Some(context) => {
                let store = Store::new();
                run_on(&Gpu::new(context.clone()), &store, inputs, entry, quality)?
            }
        };
        bar.0.finish_and_clear();
        input.notes.extend(notes);
        Ok(Picture::new(self.args.size, &radiance))
    }
}

/// A progress bar that counts rays.
struct Bar(ProgressBar);

impl Watch for Bar {
    fn gathered(&self, rays: usize) {
        self.0.inc(rays as u64);
    }
}

fn run_on<B: MethodBackend + Download>(
    backend: &B,
    store: &Store<B::Memory>,
    inputs: FrameInputs<'_>,
    entry: &Entry,
    quality: u32,
) -> Result<Vec<[f32; 4]>, Failure> {
    let method = entry.on::<B>().ok_or_else(|| {
        let name = entry.about().name;
        Failure::new(format!("{name} has no shader: it runs with --backend cpu"))
    })?;
    let frame = Frame::new(backend, inputs, store)?;
    let mut radiance = backend.zeros::<[f32; 4]>(inputs.rays.len())?;
    method.add_radiance(&frame, quality, &mut radiance)?;
    Ok(backend.download(&radiance)?)
}
