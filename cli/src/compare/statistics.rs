//! The scene in numbers.

use gpu_backend::Cpu;
use lighting::scene::statistics::figures;

use crate::format::significant;
use crate::input::Input;

/// Texels per side of the light map that figures are counted on.
const MAP: u32 = 512;

/// The largest number of triangles whose figures are counted: those of more take longer than a
/// reader would wait for them.
const MOST_TRIANGLES: usize = 300_000;

/// The figures of a scene: names and values.
pub(crate) fn of(input: &Input, kept: usize) -> Vec<(&'static str, String)> {
    let bounds = input.geometry.bounds();
    let extent = bounds.max() - bounds.min();
    let metres = extent.to_array().map(|side| significant(f64::from(side)));
    let triangles = input.geometry.triangles().len();
    let mut all = vec![
        ("triangles", triangles.to_string()),
        ("size", format!("{} m", metres.join(" × "))),
        ("lights", input.scene.lights.len().to_string()),
        (
            "emitters",
            format!("{}, {kept} of them reach the view", input.emitters.len()),
        ),
        ("hair and smoke", input.scene.translucent.len().to_string()),
    ];
    if let Some(dynamic) = input.geometry.dynamic_part() {
        all.push(("dynamic triangles", dynamic.triangles().len().to_string()));
    }
    let Some(emitter) = input
        .emitters
        .first()
        .filter(|_| triangles <= MOST_TRIANGLES)
    else {
        return all;
    };
    let cpu = Cpu::new();
    if let Ok(figures) = figures(&input.scene, &input.geometry, emitter, MAP, &cpu) {
        all.push(("closed solids", figures.solids.to_string()));
        all.push((
            "covered by casters, as the first light sees it",
            format!("{} %", significant(100.0 * figures.covered_share)),
        ));
        all.push((
            "silhouettes on its map of 512 × 512 texels",
            format!("{} texel edges", figures.silhouette_length),
        ));
        all.push((
            "layers behind a covered texel",
            significant(figures.depth_complexity),
        ));
    }
    all
}
