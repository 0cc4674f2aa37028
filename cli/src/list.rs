//! Tables of all methods and of all embedded scenes.

use gpu_backend::Cpu;
use lighting::methods::{Entry, Registry, Role};
use lighting::scene::Geometry;
use lighting::scene::procedural::Embedded;
use lighting::scene::statistics::{Figures, figures};
use serde_json::{Value, json};

use crate::args::{Methods, Scenes};
use crate::failure::Failure;
use crate::print::print;
use crate::progress;

/// Runs `crepuscular methods`.
pub(crate) fn methods(methods: &Registry, args: &Methods) -> Result<(), Failure> {
    if args.json {
        return print(&format!("{:#}\n", methods_as_json(methods)));
    }
    let mut text = String::from(
        "The qualities are those that `compare` measures. It compares the methods that see smoke in\n\
         scenes with smoke, and the others elsewhere. `render` takes any method with --method and\n\
         --quality. Most methods combine a visibility source with an airlight evaluator, and\n\
         `render` takes any such pair with --visibility, --samples, --airlight and --nodes.\n\n",
    );
    for entry in methods.compared() {
        let about = entry.about();
        let qualities: Vec<String> = about.qualities.iter().map(u32::to_string).collect();
        text += &format!("{}\n", about.title);
        text += &format!("    name     {}\n", about.name);
        text += &format!("    for      {}\n", about.purpose);
        text += &format!("    quality  {}: {}\n", about.quality, qualities.join(", "));
        let backends = match entry.runs_on_gpus() {
            true => "cpu, gpu",
            false => "cpu (it has no shader)",
        };
        text += &format!("    on       {backends}\n");
        text += &format!("    paper    {}\n\n", about.paper);
    }
    for (what, halves) in [
        (
            "visibility sources, which find the lit parts of rays",
            methods.visibilities(),
        ),
        (
            "airlight evaluators, which integrate the light of a lit part",
            methods.evaluators(),
        ),
    ] {
        text += &format!("{what}\n");
        for [name, title] in halves {
            text += &format!("    {name:20} {title}\n");
        }
        text += "\n";
    }
    print(&text)
}

fn methods_as_json(methods: &Registry) -> Value {
    let method = |entry: &Entry| {
        let about = entry.about();
        let backends: &[&str] = match entry.runs_on_gpus() {
            true => &["cpu", "gpu"],
            false => &["cpu"],
        };
        json!({
            "name": about.name,
            "title": about.title,
            "for": about.purpose,
            "role": match about.role {
                Role::Unshadowed => "unshadowed",
                Role::Baseline => "baseline",
                Role::Paper => "paper",
                Role::Engine => "engine",
                Role::Variant => "variant",
            },
            "quality": about.quality,
            "qualities": about.qualities,
            "backends": backends,
            "paper": about.paper,
        })
    };
    let half = |[name, title]: [&str; 2]| json!({"name": name, "title": title});
    json!({
        "methods": methods.compared().map(method).collect::<Vec<_>>(),
        "visibilities": methods.visibilities().into_iter().map(half).collect::<Vec<_>>(),
        "evaluators": methods.evaluators().into_iter().map(half).collect::<Vec<_>>(),
    })
}

/// An embedded scene with the figures of each of its lights, by kind.
struct Measured {
    embedded: Embedded,
    lights: Vec<(&'static str, Figures)>,
}

/// Runs `crepuscular scenes`.
pub(crate) fn scenes(args: &Scenes) -> Result<(), Failure> {
    let cpu = Cpu::new();
    let bar = progress::bar("figures", Embedded::listed().count() as u64);
    let mut all = Vec::new();
    for embedded in Embedded::listed() {
        let scene = embedded.build(args.seed);
        let geometry = Geometry::new(&scene)?;
        let mut lights = Vec::new();
        for light in &scene.lights {
            for emitter in light.emitters(1)? {
                let figures = figures(&scene, &geometry, &emitter, args.map, &cpu)?;
                lights.push((light.kind(), figures));
            }
        }
        all.push(Measured { embedded, lights });
        bar.inc(1);
    }
    bar.finish_and_clear();
    if args.json {
        let scenes: Vec<Value> = all.iter().map(Measured::json).collect();
        let list = json!({"seed": args.seed, "map": args.map, "scenes": scenes});
        return print(&format!("{list:#}\n"));
    }
    let mut text: String = all.iter().map(Measured::describe).collect();
    text += &format!(
        "Figures are those of a light map of {0} x {0} texels (--map).\n",
        args.map
    );
    print(&text)
}

impl Measured {
    fn describe(&self) -> String {
        let (name, description) = (self.embedded.name(), self.embedded.description());
        let mut text = format!("{name:14} {description}\n");
        for (kind, figures) in &self.lights {
            text += &format!("{:14} {kind} light: {figures}\n", "");
        }
        text
    }

    fn json(&self) -> Value {
        let light = |(kind, figures): &(&str, Figures)| {
            json!({
                "kind": kind,
                "solids": figures.solids,
                "triangles": figures.triangles,
                "covered_share": figures.covered_share,
                "silhouette_texel_edges": figures.silhouette_length,
                "depth_complexity": figures.depth_complexity,
            })
        };
        json!({
            "name": self.embedded.name(),
            "description": self.embedded.description(),
            "lights": self.lights.iter().map(light).collect::<Vec<_>>(),
        })
    }
}
