//! The contents of a file of precomputed voxelized shadows.

use std::ops::Range;

use serde_json::{Value, json};
use shadow_dag::{Form, LevelSize, LightEntry, ShadowDag, ShadowSet, Sizes, Slices};

use crate::args::Inspect;
use crate::failure::Failure;
use crate::file;
use crate::format::{bytes, count, significant};
use crate::print::print;

/// Runs `crepuscular inspect`.
pub(crate) fn run(args: &Inspect) -> Result<(), Failure> {
    let name = args.file.display().to_string();
    let about = |failure: Failure| failure.about(&name);
    let file = file::read(&args.file).map_err(|error| about(error.into()))?;
    let set = ShadowSet::read(&file).map_err(|error| about(error.into()))?;
    // A file that can be read, but not used in place, is compressed.
    let is_compressed = ShadowSet::from_bytes(file.as_slice()).is_err();
    let entries = LightEntry::directory(&file).map_err(|error| about(error.into()))?;
    let lights = lights(&set, entries.as_deref());
    let grids: Vec<Grid> = set.grids().map(Grid::of).collect::<Result<_, _>>()?;
    let text = if args.json {
        let grids: Vec<Value> = grids.iter().map(Grid::json).collect();
        let file = json!({
            "file": name,
            "bytes": file.len(),
            "compressed": is_compressed,
            "lights": lights.len(),
            "directory": lights.iter().map(Light::json).collect::<Vec<_>>(),
            "grids": grids,
        });
        format!("{file:#}\n")
    } else {
        describe(&name, (file.len(), is_compressed), &lights, &grids)
    };
    print(&text)
}

/// A light of the file.
struct Light {
    /// The numbers of its grids.
    grids: Range<usize>,
    side: u32,
    bias: f32,
    /// Where its grids are in the file, if there is a directory that says so.
    bytes: Option<Range<u64>>,
}

/// The lights of a set, with the entries of the directory of its file, if it has one.
fn lights<B>(set: &ShadowSet<B>, entries: Option<&[LightEntry]>) -> Vec<Light> {
    let mut first = 0;
    let light = |(index, grids): (usize, &[ShadowDag<B>])| {
        let own = first..first + grids.len();
        first = own.end;
        Light {
            grids: own,
            side: grids[0].resolution().side(),
            bias: set.bias(index),
            bytes: entries.and_then(|entries| Some(entries.get(index)?.bytes.clone())),
        }
    };
    set.lights().enumerate().map(light).collect()
}

impl Light {
    fn json(&self) -> Value {
        let bytes = self.bytes.as_ref().map(|bytes| [bytes.start, bytes.end]);
        json!({
            "first_grid": self.grids.start,
            "grids": self.grids.len(),
            "side": self.side,
            "bias": self.bias,
            "bytes": bytes,
        })
    }

    fn describe(&self) -> String {
        let grids = match self.grids.len() {
            1 => format!("grid {}", self.grids.start),
            _ => format!("grids {} to {}", self.grids.start, self.grids.end - 1),
        };
        let place = match &self.bytes {
            Some(at) => format!(", {} from byte {} on", bytes(at.end - at.start), at.start),
            None => String::new(),
        };
        format!(
            "{grids} of {}³ voxels, bias {}{place}",
            self.side, self.bias
        )
    }
}

/// Sizes and counts of a grid.
struct Grid {
    side: u32,
    slices: Option<Slices>,
    form: Form,
    /// Bytes that it would take in the other form.
    converted: usize,
    sizes: Sizes,
}

impl Grid {
    fn of<B: AsRef<[u8]>>(grid: &ShadowDag<B>) -> Result<Self, Failure> {
        let other = match grid.form() {
            Form::Plain => Form::Packed,
            Form::Packed => Form::Plain,
        };
        Ok(Self {
            side: grid.resolution().side(),
            slices: grid.light().map(|light| *light.slices()),
            form: grid.form(),
            converted: grid.to_form(other)?.as_bytes().len(),
            sizes: grid.sizes(),
        })
    }

    /// The names of its form and of the other one.
    fn forms(&self) -> [&'static str; 2] {
        match self.form {
            Form::Plain => ["plain", "packed"],
            Form::Packed => ["packed", "plain"],
        }
    }

    fn json(&self) -> Value {
        let light = match &self.slices {
            None => Value::Null,
            Some(Slices::Linear) => json!({"kind": "parallel"}),
            Some(Slices::Logarithmic(ends)) => {
                json!({"kind": "point", "near": ends.near(), "far": ends.far()})
            }
        };
        let [form, other] = self.forms();
        let level = |level: &LevelSize| json!({"side": level.side, "nodes": level.nodes, "bytes": level.bytes});
        let levels: Vec<Value> = self.sizes.levels.iter().map(level).collect();
        json!({
            "side": self.side,
            "light": light,
            "form": form,
            "bytes": self.sizes.file,
            "bytes_in_other_form": {other: self.converted},
            "bytes_of_head": self.sizes.head,
            "bytes_of_masks": self.sizes.masks,
            "bytes_of_shapes": self.sizes.shapes,
            "bytes_of_top_grid_in_memory": self.sizes.top_grid,
            "levels": levels,
        })
    }

    fn describe(&self) -> String {
        let sizes = &self.sizes;
        let mut text = String::new();
        let mut line = |what: &str, value: &str| text += &format!("  {what:18} {value}\n");
        let light = match self.slices {
            None => "not known".into(),
            Some(Slices::Linear) => "directional, slices of equal height".into(),
            Some(Slices::Logarithmic(ends)) => format!(
                "point light, slices from {} m to {} m in equal ratios",
                significant(ends.near()),
                significant(ends.far())
            ),
        };
        line("light", &light);
        let [form, other] = self.forms();
        let converted = bytes(self.converted as u64);
        line(
            "form",
            &format!("{form}; {other} it would take {converted}"),
        );
        let map = 2.0 * f64::from(self.side).powi(2);
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
        text
    }
}

fn describe(
    name: &str,
    (size, is_compressed): (usize, bool),
    lights: &[Light],
    grids: &[Grid],
) -> String {
    let mut sides: Vec<u32> = grids.iter().map(|grid| grid.side).collect();
    sides.sort_unstable();
    sides.dedup();
    let sides: Vec<String> = sides.iter().map(|side| format!("{side}³")).collect();
    let of_lights = match lights.len() {
        1 => String::new(),
        lights => format!(" of {}", count(lights, "light")),
    };
    let compressed = if is_compressed { " compressed" } else { "" };
    let mut text = format!(
        "{name}: {}{of_lights} of {} voxels, {}{compressed}, sound\n",
        count(grids.len(), "grid"),
        sides.join(", "),
        bytes(size as u64)
    );
    if is_compressed {
        text += "the following is about the packed form into which it is decoded\n";
    }
    if lights.len() > 1 || lights.iter().any(|light| light.bytes.is_some()) {
        for (index, light) in lights.iter().enumerate() {
            text += &format!("light {index}: {}\n", light.describe());
        }
    }
    for (index, grid) in grids.iter().enumerate() {
        if grids.len() > 1 {
            text += &format!("\ngrid {index}\n");
        }
        text += &grid.describe();
    }
    text
}
