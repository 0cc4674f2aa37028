//! One picture: surfaces and airlight.

use std::path::Path;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::plan::{Plan, Reason};
use lighting::scene::{Camera, Medium};
use lighting::shadow_map::Casters;
use lighting::view::View;
use lighting::voxels::{Eye, depth_range};

use crate::args::Render;
use crate::engine::{Stage, Tables, Voxels, affordable_resolution, shadow_maps};
use crate::failure::Failure;
use crate::format::{count, significant};
use crate::input::{Input, describe_medium};
use crate::methods::{Airlight, Setting, Visibility};
use crate::output::PendingFile;
use crate::picture::Picture;
use crate::print::{complain, print};
use crate::progress;

/// Rays between two moves of the progress bar.
const BATCH: usize = 1 << 13;

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
pub(crate) fn run(args: &Render) -> Result<(), Failure> {
    let format = Format::of(&args.output)?;
    let file = PendingFile::create(&args.output)?;
    let mut input = Input::load(&args.scene, &args.options)?;
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
    let medium = input.scene.medium;
    let surfaces = view.surface_radiance(
        &cpu,
        &input.scene,
        &input.geometry,
        &input.tracer,
        &input.emitters,
        medium.as_ref(),
    );
    spinner.finish_and_clear();
    let mut picture = Picture::new(args.size, &surfaces);

    let plan = Plan::new(&input.emitters, medium.as_ref(), view.rays());
    for part in plan.left_out() {
        let unused =
            part.reason == Reason::OnlyDirectionalLight && !args.visibility.is_equi_angular();
        if !unused {
            input
                .notes
                .push(format!("left out: {} ({})", part.subject, part.reason));
        }
    }
    if let (Some(medium), false) = (&medium, plan.emitters().is_empty()) {
        let kept = plan.emitters().iter();
        let emitters: Vec<Emitter> = kept.map(|index| input.emitters[*index].clone()).collect();
        let airlight = airlight(args, &mut input, (&camera, &view), medium, &emitters)?;
        picture = picture.plus(&airlight);
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
    text += &format!(
        "{}: {} in {}, {}\n",
        args.output.display(),
        args.size,
        describe_medium(medium.as_ref()),
        describe(setting(args))
    );
    print(&text)
}

/// Unless told otherwise, intervals that are single steps get one node.
fn setting(args: &Render) -> Setting {
    let steps_apart = matches!(
        args.visibility,
        Visibility::March | Visibility::EquiAngular | Visibility::VoxelBits
    );
    let samples = match args.visibility.voxel_detail() {
        Some(_) => 512,
        None => 64,
    };
    Setting {
        visibility: args.visibility,
        samples: args.samples.unwrap_or(samples),
        airlight: args.airlight,
        detail: match args.airlight {
            Airlight::EquiAngular | Airlight::Midpoint => {
                args.nodes.unwrap_or(if steps_apart { 1 } else { 8 })
            }
            Airlight::Quadrature => 4,
            Airlight::Table | Airlight::Double => 64,
            Airlight::Published => 512,
        },
    }
}

fn describe(setting: Setting) -> String {
    let mut text = format!("{} visibility", setting.visibility.name());
    if setting.visibility.has_steps() {
        text += &format!(" with {} steps", setting.samples);
    } else if setting.visibility.voxel_detail().is_some() {
        text += &format!(" with {} voxels a side", setting.samples);
    }
    match setting.airlight {
        Airlight::Midpoint => text + " × midpoint",
        Airlight::EquiAngular => {
            let nodes = count(setting.detail as usize, "node");
            text + &format!(" × equi-angular quadrature of {nodes}")
        }
        Airlight::Quadrature => text + " × quadrature to 1e-4",
        Airlight::Table => text + " × table of 64 KiB",
        Airlight::Double => text + " × double precision",
        Airlight::Published => text + " × the published table",
    }
}

fn airlight(
    args: &Render,
    input: &mut Input,
    (camera, view): (&Camera, &View),
    medium: &Medium,
    emitters: &[Emitter],
) -> Result<Picture, Failure> {
    let cpu = Cpu::new();
    let mut maps = Vec::new();
    if args.visibility.needs_shadow_map() {
        let asked = args.options.map.unwrap_or(1024);
        let map = affordable_resolution(asked, &input.geometry, emitters);
        if map < asked {
            input.notes.push(format!(
                "shadow maps have {map} texels per side instead of {asked}, so that all fit into 512 MiB"
            ));
        }
        let bar = progress::bar("shadow maps", emitters.len() as u64);
        let casters = Casters::upload(&cpu, &input.geometry)?;
        maps = shadow_maps(&cpu, &casters, emitters, map, || bar.inc(1))?;
        bar.finish_and_clear();
    }
    let tables = Tables::new(medium.phase(), std::iter::once(setting(args)))?;
    let depths = depth_range(view.rays(), medium);
    let eye = Eye::of_camera(camera, args.size.width, args.size.height, depths);
    let voxels = Voxels::default();
    let bar = progress::bar("airlight", view.rays().len() as u64);
    let mut radiance = Vec::with_capacity(view.rays().len());
    for rays in view.rays().chunks(BATCH) {
        let stage = Stage {
            backend: &cpu,
            tracer: &input.tracer,
            medium,
            emitters,
            maps: &maps,
            tables: &tables,
            eye,
            voxels: &voxels,
            rays: rays.to_vec(),
            count: rays.len(),
        };
        radiance.extend(stage.airlight(setting(args))?);
        bar.inc(rays.len() as u64);
    }
    bar.finish_and_clear();
    Ok(Picture::new(args.size, &radiance))
}
