//! Tables of what there is: methods and embedded scenes.

use gpu_backend::Cpu;
use lighting::methods::Registry;
use lighting::scene::Geometry;
use lighting::scene::procedural::Embedded;
use lighting::scene::statistics::figures;

use crate::args::Scenes;
use crate::failure::Failure;
use crate::print::print;
use crate::progress;

/// Runs `crepuscular methods`.
pub(crate) fn methods(methods: &Registry) -> Result<(), Failure> {
    let mut text = String::from(
        "Qualities are those of `compare`; `render` takes any method with --method and --quality.\n\
         Most methods are a source of lit intervals × an evaluator of an interval; `render` takes\n\
         any such pair with --visibility, --samples, --airlight, --nodes.\n\n",
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
        ("sources of lit intervals", methods.visibilities()),
        ("evaluators of an interval", methods.evaluators()),
    ] {
        text += &format!("{what}\n");
        for [name, title] in halves {
            text += &format!("    {name:20} {title}\n");
        }
        text += "\n";
    }
    print(&text)
}

/// Runs `crepuscular scenes`.
pub(crate) fn scenes(args: &Scenes) -> Result<(), Failure> {
    let cpu = Cpu::new();
    let bar = progress::bar("figures", Embedded::ALL.len() as u64);
    let mut text = String::new();
    for embedded in Embedded::ALL {
        let scene = embedded.build(args.seed);
        let geometry = Geometry::new(&scene)?;
        text += &format!("{:14} {}\n", embedded.name(), embedded.description());
        for light in &scene.lights {
            for emitter in light.emitters(1)? {
                let figures = figures(&scene, &geometry, &emitter, args.map, &cpu)?;
                text += &format!("{:14} {} light: {figures}\n", "", light.kind());
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    text += &format!(
        "Figures are those of a light map of {0} x {0} texels (--map).\n",
        args.map
    );
    print(&text)
}
