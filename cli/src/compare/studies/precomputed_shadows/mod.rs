//! Precomputed voxelized shadows without a picture: time and memory of a bake, the size of its
//! file, and the cost of a lookup.
//!
//! Based on: Sintorn et al., "Compact Precomputed Voxelized Shadows", 2014, and
//! Kämpe et al., "Fast, Memory-Efficient Construction of Voxelized Shadows",
//! 2015, whose tables of sizes and times it repeats on the scene at hand.

mod bakes;
mod filters;
mod sizes;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{Builder, Resolution, Watertightness, light_spaces, surfaces};
use lighting::scene::Geometry;
use shadow_dag::LightSpace;

use super::{Kind, Limit, Subject};
use crate::compare::study::NO_TIME;
use crate::compare::study::{Cell, Column, Study, Unit};
use crate::failure::Failure;
use crate::format::count;
use crate::parse::Size;
use crate::progress;
use bakes::Bake;
use filters::Filters;
use sizes::Sizes;

pub(super) const KIND: Kind = Kind {
    title: "precomputed voxelized shadows",
    csv: "precomputed-voxelized-shadows.csv",
    columns,
    seconds: Some([1.2, 25.0]),
    in_fog: false,
    pointless,
    run,
};

/// The measurements of this study.
#[derive(Debug, Default)]
struct Found {
    /// The light in words; empty if there was no time to choose one.
    light: String,
    watertightness: Watertightness,
    sizes: Option<Sizes>,
    bakes: Vec<Bake>,
    filters: Option<Filters>,
}

/// Resolutions, and the picture whose surfaces are shadowed.
struct Extent {
    sizes: u32,
    /// The first and the last, if the time allows.
    bakes: [u32; 2],
    filters: u32,
    picture: Size,
}

/// The largest side of bakes if everything is to be measured: the next would take longer than
/// everything else together.
const UNLIMITED: u32 = 1 << 15;

const QUICK: Extent = Extent {
    sizes: 512,
    bakes: [1 << 11, 1 << 13],
    filters: 1024,
    picture: Size {
        width: 320,
        height: 180,
    },
};
const ALL: Extent = Extent {
    sizes: 2048,
    bakes: [1 << 11, 1 << 18],
    filters: 8192,
    picture: Size {
        width: 1920,
        height: 1080,
    },
};

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    let none = subject.emitters.is_empty();
    none.then_some("no light reaches the view")
}

fn columns() -> Vec<Column> {
    vec![
        Column::plain("what"),
        Column::plain("setting"),
        Column::plain("voxels"),
        Column::plain("unit"),
        Column::new("value", Unit::Number),
    ]
}

/// Adds one number to the records.
fn record(study: &mut Study, what: &str, setting: &str, voxels: u32, (unit, value): (&str, f64)) {
    let cells: [Cell; 5] = [
        what.into(),
        setting.into(),
        voxels.into(),
        unit.into(),
        value.into(),
    ];
    study.records.push(cells.into());
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let found = measure_all(&mut study, subject, limit)?;
    describe(&mut study, &found);
    study.introduction += subject.dynamic_baked();
    Ok(study)
}

/// Puts the measurements into words and tables.
fn describe(study: &mut Study, found: &Found) {
    if found.light.is_empty() {
        return;
    }
    let watertightness = &found.watertightness;
    let closed = if watertightness.is_closed() {
        "All of its parts are closed.".to_owned()
    } else {
        format!(
            "{} of its {} have holes or are turned inside out: these are baked as surfaces, which compress less.",
            watertightness.open_parts + watertightness.inverted_parts,
            count(watertightness.parts, "part")
        )
    };
    study.introduction = format!(
        "Compact precomputed voxelized shadows of {}, in one grid. {closed}",
        found.light
    );
    if let Some(sizes) = &found.sizes {
        sizes.describe(study);
    }
    bakes::describe(study, &found.bakes);
    if let Some(filters) = &found.filters {
        filters.describe(study);
    }
}

/// Bakes the first light whose shadows one grid can hold, or the fullest grid
/// of the first light. Nothing is begun that would end long after the limit.
fn measure_all(
    study: &mut Study,
    subject: &Subject<'_>,
    limit: &Limit<'_>,
) -> Result<Found, Failure> {
    let extent = if subject.quick { QUICK } else { ALL };
    let geometry = subject.geometry;
    let mut found = Found::default();
    let is_over = || limit.reached().is_some();
    let Some((emitter, light, grid)) = suitable(geometry, subject.emitters, is_over)? else {
        study.leave_out("", limit.reached().unwrap_or(NO_TIME));
        return Ok(found);
    };
    let space = |side: u32| -> Result<(LightSpace, Resolution), Failure> {
        let resolution = Resolution::new(side)?;
        let mut spaces = light_spaces(geometry, emitter, resolution)?;
        Ok((spaces.swap_remove(grid), resolution))
    };
    let bar = progress::bar("precomputed shadows", 3);
    found.light = light;
    let (light, resolution) = space(extent.sizes)?;
    let mesh = surfaces(geometry)?.seen_from(light, resolution);
    found.watertightness = mesh.watertightness();
    // In a scene of millions of triangles there is no time for tables.
    let sorted = limit.elapsed();
    match limit.reached_after(0.85 * limit.seconds()) {
        None => found.sizes = Some(Sizes::measure(&mesh)?),
        Some(why) => study.leave_out("rules and forms", why),
    }
    bar.inc(1);
    match limit.reached_after(sorted + 0.6 * limit.seconds()) {
        None => {
            let (light, resolution) = space(extent.filters)?;
            let plain = Builder::new().bake(
                &Cpu::new(),
                &surfaces(geometry)?.seen_from(light, resolution),
            )?;
            found.filters = Some(Filters::measure(&plain, subject, emitter, extent.picture)?);
        }
        Some(why) => study.leave_out("filters", why),
    }
    bar.inc(1);
    let mut side = extent.bakes[0];
    let mut last = sorted;
    let last_side = match limit.seconds().is_finite() {
        true => extent.bakes[1],
        false => extent.bakes[1].min(UNLIMITED),
    };
    while side <= last_side {
        if let Some(why) = limit.reached_after(2.5 * last) {
            study.leave_out("bakes at higher resolutions", why);
            break;
        }
        let (light, resolution) = space(side)?;
        // None if it was interrupted, which the next round says.
        if let Some(bake) = Bake::measure(geometry, light, resolution, limit.stop())? {
            last = bake.seconds();
            found.bakes.push(bake);
            side *= 2;
        }
    }
    bar.finish_and_clear();
    Ok(found)
}

/// The light to be baked: in words, and the number of the grid. None if there is
/// no light, or the time is over before it is found, as it may be in a scene of
/// many triangles.
fn suitable<'a>(
    geometry: &Geometry,
    emitters: &'a [Emitter],
    mut is_over: impl FnMut() -> bool,
) -> Result<Option<(&'a Emitter, String, usize)>, Failure> {
    let coarse = Resolution::new(64)?;
    let name = |emitter: &Emitter| match emitter {
        Emitter::Directional(_) => "the sun",
        _ => "a light at a point",
    };
    let mut fullest = None;
    for emitter in emitters {
        if is_over() {
            return Ok(None);
        }
        let spaces = light_spaces(geometry, emitter, coarse)?;
        if let [_] = spaces[..] {
            return Ok(Some((emitter, name(emitter).into(), 0)));
        }
        if fullest.is_some() {
            continue;
        }
        let mut most = (0, 0);
        for (grid, space) in spaces.into_iter().enumerate() {
            let mesh = surfaces(geometry)?.seen_from(space, coarse);
            let bytes = Builder::new().bake(&Cpu::new(), &mesh)?.as_bytes().len();
            most = most.max((bytes, grid));
            if is_over() {
                return Ok(None);
            }
        }
        let name = format!("{}, the fullest of its six grids", name(emitter));
        fullest = Some((emitter, name, most.1));
    }
    Ok(fullest)
}

#[cfg(test)]
mod tests {
    use lighting::scene::procedural::Embedded;

    use super::*;
    use crate::compare::studies::tests::Stand;
    use crate::compare::study::{Part, Value};

    #[test]
    fn every_part_of_a_scene_is_measured_and_rules_get_better_over_the_years() {
        for embedded in [Embedded::City, Embedded::Coil] {
            let stand = Stand::of(embedded);
            let mut study = KIND.blank();
            let found = measure_all(&mut study, &stand.subject(), &Limit::of(1e6)).unwrap();
            assert_eq!(study.left_out, []);
            let sizes = found.sizes.as_ref().unwrap();
            assert!(sizes.edges > 100, "{}", sizes.edges);
            for pair in sizes.rows.windows(2) {
                assert!(pair[1].bytes[1] <= pair[0].bytes[1], "{sizes:?}");
            }
            let filters = found.filters.as_ref().unwrap();
            assert!(filters.receivers > 1000);
            assert!(!found.light.is_empty());
            assert_eq!(found.bakes.last().unwrap().resolution, QUICK.bakes[1]);
            describe(&mut study, &found);
            assert_eq!(study.parts.len(), 3);
            for row in study.records.rows() {
                let value = &row.cells[4].value;
                assert!(
                    matches!(value, Value::Number(value) if *value > 0.0),
                    "{row:?}"
                );
            }
        }
    }

    #[test]
    fn nothing_is_begun_when_the_time_is_over() {
        let stand = Stand::of(Embedded::Coil);
        let study = run(&stand.subject(), &Limit::of(0.0)).unwrap();
        let left_out = &study.left_out[..];
        assert!(
            matches!(left_out, [only] if only.what == format!("study of {}", KIND.title)),
            "{left_out:?}"
        );
        assert!(study.parts.is_empty() && study.records.rows().is_empty());
        // The clock is looked at before the light and after each of its grids.
        for most in 0..7 {
            let mut looks = 0;
            let is_over = || {
                looks += 1;
                looks > most
            };
            let found = suitable(&stand.geometry, &stand.emitters[..1], is_over).unwrap();
            assert!(found.is_none() && looks == most + 1, "{most} {looks}");
        }
        let found = suitable(&stand.geometry, &stand.emitters[..1], || false).unwrap();
        assert!(found.is_some());
    }

    #[test]
    fn what_is_not_known_is_said_in_words() {
        let found = Found {
            light: "the <sun>".into(),
            sizes: Some(sizes::tests::example()),
            bakes: bakes::tests::example(),
            filters: Some(filters::tests::example()),
            ..Found::default()
        };
        let mut study = KIND.blank();
        describe(&mut study, &found);
        let texts: Vec<&str> = study
            .parts
            .iter()
            .filter_map(|part| match part {
                Part::Table(table) => Some(table.rows()),
                _ => None,
            })
            .flatten()
            .flat_map(|row| row.cells.iter().filter_map(Cell::text))
            .collect();
        for text in ["no edges", "–", "not known"] {
            assert!(texts.contains(&text), "{text}: {texts:?}");
        }
    }
}
