//! The error over the size of the light.

use std::borrow::Cow;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::scene::{AreaLight, Texture};
use lighting::shadow_map::LevelOfDetail;
use lighting::voxelized::Detail;

use super::frames::{Maps, Setting};
use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// Edges, relative to those of the scene's light.
const SIZES: &[f32] = &[0.25, 0.5, 1.0, 2.0];

const LIGHTS: u32 = 64;

/// As far as the time allows.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    let mut table = Table::new(vec![
        Column::plain("light"),
        Column::new("imperfect maps, average", Unit::Share),
        Column::new("exact maps, average", Unit::Share),
        Column::new("exact maps, runs", Unit::Share),
    ])
    .titled(
        "The size of the light",
        format!("As in figure 11 of Wyman and Dai 2013: the scene's light with its edges multiplied by a factor, sampled at {LIGHTS} points, and the light with one half black."),
    );
    let mut clock = limit.elapsed();
    let mut last = 0.0;
    let sized = SIZES.iter().map(|size| (*size, false));
    for (size, half) in sized.chain([(1.0, true)]) {
        if let Some(why) = limit.reached_after(last) {
            study.leave_out("other sizes of the light", why);
            break;
        }
        let light = changed(scene.light, size, half);
        let scene = Scene {
            light: &light,
            ..scene
        };
        let truth = scene.truth();
        let run = |maps, detail| {
            let setting = Setting {
                lights: LIGHTS,
                maps,
                detail,
                ..Setting::default()
            };
            setting.error(cpu, scene, &truth)
        };
        let imperfect = Maps::Imperfect(4096, LevelOfDetail::Near);
        let errors = [
            ("imperfect average", run(imperfect, Detail::Average)?.rmse),
            ("exact average", run(Maps::Exact, Detail::Average)?.rmse),
            ("exact runs", run(Maps::Exact, Detail::Runs)?.rmse),
        ];
        let name: Cow<'_, str> = match half {
            true => "half black".into(),
            false => format!("× {size}").into(),
        };
        let mut cells = vec![name.clone().into_owned().into()];
        for (kind, rmse) in errors {
            record(study, &format!("rmse {kind}"), &name, LIGHTS, rmse);
            cells.push(rmse.into());
        }
        table.push(cells);
        last = limit.elapsed() - clock;
        clock += last;
    }
    if !table.rows().is_empty() {
        study.parts.push(Part::Table(table));
    }
    Ok(())
}

/// The light with other edges around the same middle and as much power, and with its
/// first half black.
fn changed(light: &AreaLight, size: f32, half: bool) -> AreaLight {
    let middle = light.corner + 0.5 * (light.edges[0] + light.edges[1]);
    let edges = light.edges.map(|edge| size * edge);
    let card = || {
        let texels = (0..64).map(|i| if i % 64 < 32 { Vec3::ZERO } else { Vec3::ONE });
        Texture::new(64, 1, texels.collect()).ok()
    };
    AreaLight {
        corner: middle - 0.5 * (edges[0] + edges[1]),
        edges,
        radiance: light.radiance / (size * size),
        texture: if half { card() } else { light.texture.clone() },
        ..light.clone()
    }
}

#[cfg(test)]
mod tests {
    use lighting::Emitter;
    use lighting::scene::Pattern;

    use super::*;

    #[test]
    fn a_light_of_another_size_has_as_much_power() {
        let light = AreaLight::default();
        let power = |light: &AreaLight| -> Vec3 {
            let points = light.virtual_lights(Pattern::Lattice, 500).unwrap();
            points.iter().map(Emitter::intensity).sum()
        };
        for size in SIZES {
            let ratio = power(&changed(&light, *size, false)) / power(&light);
            assert!((ratio - 1.0).length() < 1e-4, "{size}");
        }
        let ratio = power(&changed(&light, 1.0, true)) / power(&light);
        assert!((ratio - 0.5).length() < 0.01, "{ratio}");
    }
}
