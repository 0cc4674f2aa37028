//! One picture: surfaces and airlight.

use std::path::Path;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::plan::{Plan, Reason};
use lighting::precomputed::FilterSize;
use lighting::scene::{Camera, Medium};
use lighting::shadow_map::Casters;
use lighting::view::{Lit, View};
use lighting::voxels::Eye;

use crate::args::Render;
use crate::baked;
use crate::engine::{Held, Stage, Tables, Voxels, affordable_resolution, shadow_maps};
use crate::failure::Failure;
use crate::format::{count, significant};
use crate::input::{Input, describe_medium};
use crate::methods::{Airlight, Setting, Visibility};
use crate::output::PendingFile;
use crate::picture::Picture;
use crate::print::{complain, print};
use crate::{progress, veils};

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
    let is_exact_only = matches!(args.airlight, Airlight::Double | Airlight::Published);
    if is_exact_only && !args.shadows.is_empty() {
        return Err(Failure::new(
            "--airlight double and published go with exact visibility only, not with --shadows",
        ));
    }
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
    let shadows = baked::read(&args.shadows, &input)?;
    let filter =
        FilterSize::new(args.filter).map_err(|error| Failure::from(error).about("--filter"))?;
    let filtered: Vec<_> = shadows
        .iter()
        .map(|shadow| shadow.as_ref().map(|shadow| shadow.filtered(filter)))
        .collect();
    let lights: Vec<Lit<'_>> = (input.emitters.iter().zip(&filtered))
        .map(|(emitter, filtered)| (emitter, filtered.as_ref().map(|shadow| shadow as _)))
        .collect();
    let traced = shadows.iter().all(Option::is_none);
    let surfaces = if traced && !input.scene.translucent.is_empty() {
        veils::surfaces(&view, &input, args.options.map.unwrap_or(1024))?
    } else {
        if !input.scene.translucent.is_empty() {
            (input.notes).push("hair and smoke cast no shadow on surfaces with --shadows".into());
        }
        view.surface_radiance_with(
            &cpu,
            &input.scene,
            &input.geometry,
            &input.tracer,
            &lights,
            medium.as_ref(),
        )
    };
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
        let (from_files, others): (Vec<usize>, Vec<usize>) =
            (plan.emitters().iter()).partition(|index| shadows[**index].is_some());
        let pick = |indices: &[usize]| -> Vec<Emitter> {
            let emitters = indices.iter().map(|index| input.emitters[*index].clone());
            emitters.collect()
        };
        let setting = setting(args);
        let others = pick(&others);
        let held = match setting.visibility {
            Visibility::Dag => baked::bake(&input, &others, setting.samples)?,
            _ => Vec::new(),
        };
        let own = from_files
            .iter()
            .filter_map(|index| shadows[*index].clone());
        let from_file = Held {
            resolution: 0,
            shadows: own.collect(),
        };
        let groups = [
            (others, held, setting),
            (pick(&from_files), vec![from_file], setting_of_files(args)),
        ];
        for group in groups.iter().filter(|(emitters, ..)| !emitters.is_empty()) {
            let airlight = airlight(args, &mut input, (&camera, &view), medium, group)?;
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
    let baked = shadows.iter().flatten().count();
    let method = match baked {
        0 => describe(setting(args)),
        _ if baked == input.emitters.len() => "baked shadows".into(),
        _ => format!(
            "baked shadows of {}, {}",
            count(baked, "light"),
            describe(setting(args))
        ),
    };
    text += &format!(
        "{}: {} in {}, {method}\n",
        args.output.display(),
        args.size,
        describe_medium(medium.as_ref()),
    );
    print(&text)
}

/// Unless told otherwise, intervals that are single steps get one node.
fn setting(args: &Render) -> Setting {
    let steps_apart = matches!(
        args.visibility,
        Visibility::March
            | Visibility::EquiAngular
            | Visibility::VoxelBits
            | Visibility::Translucent
    );
    let samples = match args.visibility.voxel_detail() {
        Some(_) => 512,
        None if args.visibility == Visibility::Dag => 2048,
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

/// Of lights whose shadows are in files, whatever their resolution: it counts
/// as 0.
fn setting_of_files(args: &Render) -> Setting {
    let setting = setting(args);
    let detail = match args.airlight {
        Airlight::EquiAngular | Airlight::Midpoint => args.nodes.unwrap_or(8),
        _ => setting.detail,
    };
    Setting {
        visibility: Visibility::Dag,
        samples: 0,
        detail,
        ..setting
    }
}

fn describe(setting: Setting) -> String {
    let mut text = format!("{} visibility", setting.visibility.name());
    if setting.visibility.has_steps() {
        text += &format!(" with {} steps", setting.samples);
    } else if setting.visibility.voxel_detail().is_some() || setting.visibility == Visibility::Dag {
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

/// Lights that are rendered alike, with the shadows that were baked for them.
type Group = (Vec<Emitter>, Vec<Held<Cpu>>, Setting);

fn airlight(
    args: &Render,
    input: &mut Input,
    (camera, view): (&Camera, &View),
    medium: &Medium,
    (emitters, held, setting): &Group,
) -> Result<Picture, Failure> {
    let setting = *setting;
    let cpu = Cpu::new();
    let mut maps = Vec::new();
    if setting.visibility.needs_shadow_map() {
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
    let mut veils = Vec::new();
    if setting.visibility == Visibility::Translucent {
        let side = veils::resolution(args.options.map.unwrap_or(1024), emitters);
        veils = veils::veils(input, Some(&input.geometry), emitters, side)?;
    } else if !input.scene.translucent.is_empty() {
        // Shadows from files have no resolution of their own.
        let option = match setting.samples {
            0 => "--shadows".to_owned(),
            _ => format!("--visibility {}", setting.visibility.name()),
        };
        (input.notes).push(format!(
            "hair and smoke cast no shadow into the air with {option}"
        ));
    }
    let tables = Tables::new(medium.phase(), std::iter::once(setting))?;
    let size = [args.size.width, args.size.height];
    let eye = Eye::of_camera(camera, size, view.rays(), medium);
    let voxels = Voxels::default();
    let bar = progress::bar("airlight", view.rays().len() as u64);
    let mut radiance = Vec::with_capacity(view.rays().len());
    // Voxels are made anew for each bundle of rays.
    let batch = match setting.visibility.voxel_detail() {
        Some(_) => view.rays().len(),
        None => BATCH,
    };
    for rays in view.rays().chunks(batch.max(1)) {
        let stage = Stage {
            backend: &cpu,
            tracer: &input.tracer,
            medium,
            emitters,
            maps: &maps,
            veils: &veils,
            tables: &tables,
            eye,
            voxels: &voxels,
            baked: held,
            rays: rays.to_vec(),
            count: rays.len(),
        };
        radiance.extend(stage.airlight(setting)?);
        bar.inc(rays.len() as u64);
    }
    bar.finish_and_clear();
    Ok(Picture::new(args.size, &radiance))
}
