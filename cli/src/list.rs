//! Tables of what there is: methods and embedded scenes.

use gpu_backend::Cpu;
use lighting::procedural::{Embedded, figures};
use lighting::scene::Geometry;

use crate::args::Scenes;
use crate::failure::Failure;
use crate::methods::METHODS;
use crate::progress;

/// Runs `crepuscular methods`.
pub(crate) fn methods() {
    println!(
        "A method is a source of lit intervals × an evaluator of an interval. Qualities are\n\
         those of `compare`; `render` takes any with --visibility, --samples, --airlight, --nodes.\n"
    );
    for method in METHODS {
        let qualities: Vec<String> = method.qualities.iter().map(u32::to_string).collect();
        println!("{}", method.title);
        println!("    pair     {}", method.name().replace(" x ", " × "));
        println!("    for      {}", method.purpose);
        println!(
            "    quality  {}: {}",
            method.quality_name(),
            qualities.join(", ")
        );
        println!(
            "    on       {}",
            if method.visibility.is_traced() {
                "cpu (it traces; there is no shader)"
            } else {
                "cpu, gpu"
            }
        );
        if method.visibility.is_equi_angular() {
            println!("    not for  scenes whose only lights are directional");
        }
        println!("    paper    {}\n", method.paper);
    }
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
    print!("{text}");
    println!(
        "Figures are those of a light map of {0} x {0} texels (--map).",
        args.map
    );
    Ok(())
}
