//! How wrong imperfect shadow maps are, over the number of points.

use gpu_backend::{Cpu, Host};
use lighting::Emitter;
use lighting::shadow_map::{
    CasterPoints, Casters, FillHoles, LevelOfDetail, RenderImperfectMaps, RenderShadowMapAtlas,
    ShadowMapAtlas,
};

use super::frames::{CASTER_POINTS, Setting};
use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// Points per map.
const POINTS: &[u32] = &[512, 1024, 2048, 4096, 8192, 16_384];
const QUICK_POINTS: &[u32] = &[512, 4096];

const LIGHTS: u32 = 16;
/// Fewer lights for a quick comparison, because exact maps of many triangles take long.
const QUICK_LIGHTS: u32 = 4;
const TEXELS: u32 = 128;

/// Levels of the pyramid that fills holes, as the method of the list has them.
const HOLE_LEVELS: u32 = 2;

/// Positions along each ray.
const PLACES: u32 = 16;

/// Maps of a few lights against the triangles, at points of the air.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    quick: bool,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    if let Some(why) = limit.reached() {
        study.leave_out("errors of imperfect maps", why);
        return Ok(());
    }
    let setting = Setting {
        lights: if quick { QUICK_LIGHTS } else { LIGHTS },
        ..Setting::default()
    };
    let lights = setting.emitters(scene)?;
    let air = Air::new(scene, &lights);
    let mut columns = vec![Column::plain("points per map")];
    let names = [
        "even: false-lit",
        "false-shadow",
        "near: false-lit",
        "false-shadow",
        "near, filled: false-lit",
        "false-shadow",
    ];
    columns.extend(names.map(|name| Column::new(name, Unit::Share)));
    let mut table = Table::new(columns).titled(
        "Imperfect shadow maps over the number of points",
        "Of all pairs of a point of the air and a light, the shares for which maps of 128² texels say lit although a triangle is between, and dark although none is. Even is the paper's way: every light takes the same points. Near takes more points where casters are near the light, and as many in all. Filled has its holes filled by pull-push.",
    );
    let casters = Casters::upload(cpu, scene.geometry)?;
    let exact = air.wrong(&cpu.shadow_map_atlas(&casters, &lights, TEXELS)?);
    let mut put = |name: Cell, shares: [[f64; 2]; 3]| {
        let shares = shares.into_iter().flatten().map(Cell::from);
        table.push([name].into_iter().chain(shares).collect());
    };
    let mut note = |kind: &str, size: u32, [lit, dark]: [f64; 2]| {
        record(study, "false-lit", kind, size, lit);
        record(study, "false-shadow", kind, size, dark);
    };
    let all = CasterPoints::sample(cpu, scene.geometry, CASTER_POINTS)?;
    for &points in if quick { QUICK_POINTS } else { POINTS } {
        let maps = |level| cpu.imperfect_maps(&all, &lights, TEXELS, points, level);
        let even = air.wrong(&maps(LevelOfDetail::Even)?);
        let mut maps = maps(LevelOfDetail::Near)?;
        let near = air.wrong(&maps);
        cpu.fill_holes(&mut maps, HOLE_LEVELS)?;
        let filled = air.wrong(&maps);
        for (kind, shares) in [("even", even), ("near", near), ("filled", filled)] {
            note(kind, points, shares);
        }
        put(points.into(), [even, near, filled]);
    }
    note("exact", 0, exact);
    put("triangles".into(), [exact; 3]);
    study.parts.push(Part::Table(table));
    Ok(())
}

/// Pairs of a light and a place in front of it, and whether nothing is between.
struct Air(Vec<(usize, glam::Vec3, bool)>);

impl Air {
    fn new(scene: Scene<'_>, lights: &[Emitter]) -> Self {
        let mut pairs = Vec::new();
        for (index, ray) in scene.rays.iter().enumerate() {
            // Another place along each ray.
            let share = (index as u32 % PLACES) as f32 + 0.5;
            let end = ray.length().min(scene.eye.depths.end);
            let place = ray.at(end * share / PLACES as f32);
            for (light, emitter) in lights.iter().enumerate() {
                let Emitter::Point(lamp) = emitter else {
                    continue;
                };
                let way = place - lamp.position();
                let distance = way.length();
                let direction = way / distance;
                if lamp.emission().factor(direction).max_element() > 0.0 {
                    let tracer = scene.tracer;
                    let is_dark = tracer.occluded(lamp.position(), direction, 0.0, distance);
                    pairs.push((light, place, !is_dark));
                }
            }
        }
        Self(pairs)
    }

    /// Shares of false light and of false shadow.
    fn wrong(&self, maps: &ShadowMapAtlas<Host>) -> [f64; 2] {
        let mut counts = [0_u32; 2];
        for &(light, place, is_lit) in &self.0 {
            if maps.is_lit(light, place) != is_lit {
                counts[usize::from(is_lit)] += 1;
            }
        }
        counts.map(|count| f64::from(count) / self.0.len().max(1) as f64)
    }
}
