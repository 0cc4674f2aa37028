//! What is in a file of precomputed voxelized shadows.

use shadow_dag::{Form, LevelSize, ShadowDag, ShadowSet, Slices};

use crate::args::Inspect;
use crate::failure::Failure;
use crate::format::{bytes, count, significant};
use crate::print::print;

/// Runs `crepuscular inspect`.
pub(crate) fn run(args: &Inspect) -> Result<(), Failure> {
    let name = args.file.display().to_string();
    let about = |failure: Failure| failure.about(&name);
    let file = std::fs::read(&args.file).map_err(|error| about(error.into()))?;
    let set = ShadowSet::from_bytes(&file).map_err(|error| about(error.into()))?;
    let lights = set.lights().len();
    let grids: Vec<_> = set.grids().collect();
    let mut sides: Vec<u32> = grids.iter().map(|grid| grid.resolution().side()).collect();
    sides.dedup();
    let sides: Vec<String> = sides.iter().map(|side| format!("{side}³")).collect();
    let of_lights = match lights {
        1 => String::new(),
        lights => format!(" of {}", count(lights, "light")),
    };
    let mut text = format!(
        "{name}: {}{of_lights} of {} voxels, {}, sound\n",
        count(grids.len(), "grid"),
        sides.join(", "),
        bytes(file.len() as u64)
    );
    for (index, grid) in grids.iter().enumerate() {
        if grids.len() > 1 {
            text += &format!("\ngrid {index}\n");
        }
        text += &describe(grid)?;
    }
    print(&text)
}

fn describe(grid: &ShadowDag<&[u8]>) -> Result<String, Failure> {
    let sizes = grid.sizes();
    let mut text = String::new();
    let mut line = |what: &str, value: &str| text += &format!("  {what:18} {value}\n");
    let slices = grid.light().map(|light| *light.slices());
    let light = match slices {
        None => "not known".into(),
        Some(Slices::Linear) => "parallel, slices of equal height".into(),
        Some(Slices::Logarithmic(ends)) => format!(
            "at a point, slices from {} m to {} m in equal ratios",
            significant(ends.near()),
            significant(ends.far())
        ),
    };
    line("light", &light);
    let (form, other) = match grid.form() {
        Form::Plain => ("plain", Form::Packed),
        Form::Packed => ("packed", Form::Plain),
    };
    let converted = grid.to_form(other)?.as_bytes().len();
    let other = match other {
        Form::Plain => "plain",
        Form::Packed => "packed",
    };
    let form = format!("{form}; {other} it would take {}", bytes(converted as u64));
    line("form", &form);
    let map = 2.0 * f64::from(grid.resolution().side()).powi(2);
    let share = format!(
        "{}, 1/{} of a 16-bit shadow map",
        bytes(sizes.file as u64),
        significant(map / sizes.file as f64)
    );
    line("size", &share);
    line("head", &bytes(sizes.head as u64));
    line("masks", &bytes(sizes.masks as u64));
    if sizes.shapes > 0 {
        line("shapes", &bytes(sizes.shapes as u64));
    }
    for LevelSize {
        side,
        nodes,
        bytes: size,
    } in &sizes.levels
    {
        let nodes = format!("{nodes:10} nodes, {}", bytes(*size as u64));
        line(&format!("level of {side}³"), &nodes);
    }
    line(
        "top grid",
        &format!("{}, in memory only", bytes(sizes.top_grid as u64)),
    );
    Ok(text)
}
