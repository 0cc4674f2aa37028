//! Tables of what there is: methods and embedded scenes.

use gpu_backend::Cpu;
use lighting::scene::Geometry;
use lighting::scene::procedural::Embedded;
use lighting::scene::statistics::figures;

use crate::args::Scenes;
use crate::failure::Failure;
use crate::methods::{METHODS, Visibility};
use crate::print::print;
use crate::progress;

/// Runs `crepuscular methods`.
pub(crate) fn methods() -> Result<(), Failure> {
    let mut text = String::from(
        "A method is a source of lit intervals × an evaluator of an interval. Qualities are\n\
         those of `compare`; `render` takes any with --visibility, --samples, --airlight, --nodes.\n\n",
    );
    for method in METHODS {
        let qualities: Vec<String> = method.qualities.iter().map(u32::to_string).collect();
        text += &format!("{}\n", method.title);
        text += &format!("    pair     {}\n", method.name().replace(" x ", " × "));
        text += &format!("    for      {}\n", method.purpose);
        text += &format!(
            "    quality  {}: {}\n",
            method.quality_name(),
            qualities.join(", ")
        );
        text += &format!(
            "    on       {}\n",
            if method.visibility.is_traced() {
                "cpu (it traces; there is no shader)"
            } else {
                "cpu, gpu"
            }
        );
        if method.visibility == Visibility::Translucent {
            text += "    not for  scenes without hair or smoke\n";
        }
        if method.visibility.is_equi_angular() {
            text += "    not for  scenes whose only lights are directional\n";
        }
        text += &format!("    paper    {}\n\n", method.paper);
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
