//! Prints what building costs and what comes out, for a city and a landscape.
//!
//! `figures maps N` compares rules on maps of N×N; `figures bake N` bakes
//! triangles at 2048 and each doubling up to N; `figures floor N` does so for an
//! open floor under a sun and a lamp; `figures rebuild N` follows a car through a city
//! for a hundred frames.

#[allow(dead_code, reason = "the benches use other parts of it")]
#[path = "../benches/scenes/mod.rs"]
mod scenes;

use std::error::Error;
use std::time::{Duration, Instant};

use gpu_backend::Cpu;
use scenes::Maps;
use shadow_dag::{Builder, Form, KeptGrid, Mesh, Resolution, Rule, ShadowDag};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (what, side) = match arguments.as_slice() {
        [what, side] => (what.as_str(), side.parse()?),
        _ => ("maps", 1024),
    };
    let resolution = Resolution::new(side)?;
    if what == "floor" {
        let [sun, lamp] = scenes::posts(resolution)?;
        println!("floor under a sun");
        bake(sun, side)?;
        println!("floor under a lamp");
        return bake(lamp, side.min(8192));
    }
    if what == "rebuild" {
        return rebuild(resolution);
    }
    for (name, mesh) in [
        ("city", scenes::city(resolution, 20, 2)?),
        ("dense city", scenes::city(resolution, 60, 10)?),
        ("landscape", scenes::landscape(resolution, 512)?),
    ] {
        assert!(
            mesh.watertightness().is_closed(),
            "{:?}",
            mesh.watertightness()
        );
        println!("{name}");
        match what {
            "bake" => bake(mesh, side)?,
            _ => maps(&mesh)?,
        }
    }
    Ok(())
}

/// A car that moves on each time its last shadow is in place.
fn rebuild(resolution: Resolution) -> Result<(), Box<dyn Error>> {
    const LIMIT: Duration = Duration::from_millis(2);
    const STEPS: u32 = 100;
    let cpu = Cpu::new();
    let scene = |step: u32| scenes::traffic(resolution, 20, 0.3 + 0.001 * step as f32);
    let start = Instant::now();
    let mut kept = KeptGrid::new(&cpu, Builder::new(), &scene(0)?)?;
    println!("whole bake {:.2?}", start.elapsed());
    let (mut tiles, mut slices, mut replacing) = (0, 0, Duration::ZERO);
    let (mut making, mut longest) = (Duration::ZERO, Duration::ZERO);
    for step in 1..=STEPS {
        let mut rebuild = kept.rebuild(scene(step)?);
        tiles += rebuild.progress().tiles;
        while !rebuild.progress().is_complete() {
            let start = Instant::now();
            rebuild.advance(&cpu, LIMIT)?;
            slices += 1;
            making += start.elapsed();
            longest = longest.max(start.elapsed());
        }
        let start = Instant::now();
        kept.replace(rebuild)?;
        replacing += start.elapsed();
    }
    println!(
        "of each of {STEPS} steps: {:.1} tiles in {:.2?} and {:.1} slices, the longest {longest:.2?}; put in place in {:.2?}",
        tiles as f64 / f64::from(STEPS),
        making / STEPS,
        f64::from(slices) / f64::from(STEPS),
        replacing / STEPS
    );
    let fresh = Builder::new().bake(&cpu, &scene(STEPS)?)?;
    assert!(kept.grid().as_bytes() == fresh.as_bytes());
    Ok(())
}

fn maps(mesh: &Mesh) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let mut maps = Maps::of(mesh)?;
    let edges = maps.silhouette_edges();
    println!(
        "  rasterised in {:.2?}, {edges} silhouette edges",
        start.elapsed()
    );
    for open in [false, true] {
        maps.open = open;
        for rule in [Rule::Sintorn2014, Rule::Kampe2015, Rule::Aligned] {
            let mut times = Vec::new();
            let mut dag = None;
            for culling in [false, true] {
                let start = Instant::now();
                dag = Some(
                    Builder::new()
                        .rule(rule)
                        .culling(culling)
                        .build(&Cpu::new(), &maps)?,
                );
                times.push(start.elapsed());
            }
            let kind = if open { "open" } else { "closed" };
            println!(
                "  {kind} {rule:?}: {:.2?}, culled {:.2?}",
                times[0], times[1]
            );
            sizes(&dag.ok_or("nothing built")?, edges)?;
        }
    }
    Ok(())
}

fn sizes(plain: &ShadowDag, edges: usize) -> Result<(), Box<dyn Error>> {
    let packed = plain.to_form(Form::Packed)?;
    let bytes = [plain.sizes().file, packed.sizes().file];
    let start = Instant::now();
    let compressed = packed.compress();
    let compressing = start.elapsed();
    let start = Instant::now();
    let read = ShadowDag::read(&compressed)?;
    println!(
        "    compressed {} ({:.3} of packed) in {compressing:.2?}, read in {:.2?} to {}",
        compressed.len(),
        compressed.len() as f64 / bytes[1] as f64,
        start.elapsed(),
        read.sizes().file,
    );
    let texels = (plain.resolution().side() as usize).pow(2);
    println!(
        "    plain {} packed {} ({:.3}); {:.1} and {:.1} bits per edge; 1/{:.0} of a 16-bit map",
        bytes[0],
        bytes[1],
        bytes[1] as f64 / bytes[0] as f64,
        8.0 * bytes[0] as f64 / edges as f64,
        8.0 * bytes[1] as f64 / edges as f64,
        2.0 * texels as f64 / bytes[1] as f64,
    );
    Ok(())
}

fn bake(mut mesh: Mesh, most: u32) -> Result<(), Box<dyn Error>> {
    for side in (11..=20).map(|log2| 1 << log2).filter(|side| *side <= most) {
        mesh = mesh.with_resolution(Resolution::new(side)?);
        let start = Instant::now();
        let dag = Builder::new().bake(&Cpu::new(), &mesh)?;
        let baked = start.elapsed();
        let packed = dag.to_form(Form::Packed)?;
        println!(
            "  {side}: baked in {baked:.2?}, packed after {:.2?}; {} and {} bytes",
            start.elapsed(),
            dag.sizes().file,
            packed.sizes().file,
        );
        println!("    compressed {}", packed.compress().len());
    }
    Ok(())
}
