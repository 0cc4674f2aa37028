//! Size and time of the bake of each light, as the scene is and with all of it open.

use std::sync::Arc;
use std::time::Instant;

use gpu_backend::Cpu;
use lighting::precomputed::{
    BakedShadow, Builder, Form, Resolution, Surfaces, light_grids, surfaces,
};
use lighting::scene::Caster;
use shadow_dag::{Error, Holes, SetBake};

use super::{BakedLight, Extent, Limit, Subject, record};
use crate::compare::study::{
    Axis, Cell, Chart, Charts, Column, Key, Part, Point, Scale, Series, Shape, Study, Table, Unit,
};
use crate::failure::Failure;
use crate::format::{bytes, count, seconds};

/// The share of the time that bakes of the scene as it is may take, and those of it open.
const SHARES: [f64; 2] = [0.4, 0.55];

/// Triangles of surfaces, not of solids.
#[derive(Debug)]
struct NoHoles;

impl Holes for NoHoles {
    fn is_hole(&self, _: u32, _: f64, _: f64) -> bool {
        false
    }

    fn describe(&self, _: &mut dyn FnMut(u64)) {}
}

/// Bakes as many lights as there is time for, describes them, and returns them.
pub(super) fn measure(
    study: &mut Study,
    subject: &Subject<'_>,
    extent: &Extent,
    limit: &Limit<'_>,
) -> Result<Vec<BakedLight>, Failure> {
    let geometry = subject.geometry;
    let side = Resolution::new(extent.voxels)?;
    let as_it_is = surfaces(geometry)?;
    let watertightness = as_it_is.watertightness();
    let wanted = subject.emitters.len().min(extent.lights);
    let bake = |surfaces: &Surfaces<'_>, share: f64, most: usize| {
        let mut lights = Vec::new();
        let mut last = 0.0;
        for emitter in &subject.emitters[..most] {
            let until = (1.0 - share) * limit.seconds();
            let left = if until.is_finite() { until } else { 0.0 };
            if let Some(why) = limit.reached_after(left + last) {
                return Ok((lights, Some(why)));
            }
            let clock = Instant::now();
            let grids = light_grids(geometry, emitter, side)?;
            let bake = SetBake::new(Builder::new(), surfaces.clone(), vec![grids])?;
            let mut bake = bake.form(Form::Packed);
            match bake.advance(&Cpu::new(), usize::MAX, limit.stop(), |_| {}) {
                Err(Error::Cancelled { .. }) => return Ok((lights, Some("interrupted"))),
                result => result?,
            };
            let shadow = BakedShadow::of_set(&bake.finish()?)?.swap_remove(0);
            last = clock.elapsed().as_secs_f64();
            lights.push(BakedLight {
                emitter: emitter.clone(),
                shadow,
                seconds: last,
            });
        }
        Ok::<_, Failure>((lights, None))
    };
    let (lights, why) = bake(&as_it_is, SHARES[0], wanted)?;
    if let Some(why) = why {
        study.leave_out(
            &format!("all but {} of {wanted}", count(lights.len(), "light")),
            why,
        );
    }
    if lights.is_empty() {
        return Ok(lights);
    }
    of_each(study, extent, &lights);
    let name = match watertightness.is_closed() {
        true => "all parts are closed".to_owned(),
        false => format!(
            "{} of {} are open",
            watertightness.open_parts + watertightness.inverted_parts,
            count(watertightness.parts, "part")
        ),
    };
    let mut table = Table::new(vec![
        Column::plain("scene"),
        Column::plain("lights"),
        Column::new("all", Unit::Bytes),
        Column::new("a light", Unit::Bytes),
        Column::new("bakes", Unit::Seconds),
        Column::new("16-bit maps / grids", Unit::With("×")),
    ])
    .titled(
        "Closed and open",
        "The same lights in the scene as it is, and with all triangles as surfaces that enclose \
         nothing, as in a scene whose meshes have holes. 16-bit maps have a texel for every \
         column of a grid. Bakes are light by light, without sorting the triangles.",
    );
    whole(study, &mut table, extent, ("as it is", &name), &lights);
    if has_masks(subject) {
        study.leave_out("the scene as open surfaces", "it has masks");
    } else {
        let triangles = geometry.triangles().len() as u32;
        let all: Vec<u32> = (0..triangles).collect();
        let open = as_it_is.with_holes(&all, Arc::new(NoHoles));
        match bake(&open, SHARES[1], lights.len())? {
            (open, None) => whole(study, &mut table, extent, ("as open surfaces", ""), &open),
            (_, Some(why)) => study.leave_out("the scene as open surfaces", why),
        }
    }
    study.parts.push(Part::Table(table));
    Ok(lights)
}

/// Whether a triangle has holes.
fn has_masks(subject: &Subject<'_>) -> bool {
    let coatings = subject.geometry.coatings();
    let mut triangles = 0..subject.geometry.triangles().len();
    triangles.any(|triangle| matches!(coatings.caster(triangle), Caster::Masked(_)))
}

/// Bytes of the 16-bit maps with a texel for each column of the grids of a light.
fn of_maps(light: &BakedLight, extent: &Extent) -> u64 {
    2 * u64::from(extent.voxels).pow(2) * light.shadow.grids().len() as u64
}

/// A row of all lights.
fn whole(
    study: &mut Study,
    table: &mut Table,
    extent: &Extent,
    (name, aside): (&str, &str),
    lights: &[BakedLight],
) {
    let bytes: u64 = lights.iter().map(|light| light.shadow.bytes()).sum();
    let maps: u64 = lights.iter().map(|light| of_maps(light, extent)).sum();
    let seconds: f64 = lights.iter().map(|light| light.seconds).sum();
    let ratio = maps as f64 / bytes as f64;
    for (what, value) in [
        ("bytes of all lights", bytes as f64),
        ("seconds of all bakes", seconds),
        ("bytes of 16-bit maps / bytes of grids", ratio),
    ] {
        record(study, what, name, extent.voxels, value);
    }
    let mut first = Cell::from(name);
    first.aside = aside.into();
    table.push(vec![
        first,
        (lights.len() as u32).into(),
        bytes.into(),
        (bytes / lights.len().max(1) as u64).into(),
        seconds.into(),
        ratio.into(),
    ]);
}

/// The bake of one light.
struct Each {
    bytes: u64,
    seconds: f64,
    number: usize,
}

/// Size and time of each light.
fn of_each(study: &mut Study, extent: &Extent, lights: &[BakedLight]) {
    let mut by_size: Vec<Each> = (lights.iter().enumerate())
        .map(|(number, light)| Each {
            bytes: light.shadow.bytes(),
            seconds: light.seconds,
            number,
        })
        .collect();
    for light in &by_size {
        let of = format!("light {}", light.number);
        record(study, "bytes", &of, extent.voxels, light.bytes as f64);
        record(
            study,
            "seconds of the bake",
            &of,
            extent.voxels,
            light.seconds,
        );
    }
    by_size.sort_by_key(|light| std::cmp::Reverse(light.bytes));
    let chart = |title: &str, unit, y: fn(&Each) -> (f64, String)| {
        let points = by_size.iter().zip(1..).map(|(light, rank)| {
            let (y, text) = y(light);
            let x = f64::from(rank);
            Point {
                x,
                y,
                spread: [x; 2],
                label: String::new(),
                title: format!("light {}: {text}", light.number),
            }
        });
        Chart {
            title: title.into(),
            caption: String::new(),
            description: format!("{title} of each light, the largest first"),
            x: Axis {
                label: "lights, the largest first".into(),
                scale: Scale::Linear,
                unit: Unit::Number,
            },
            y: Axis {
                label: title.into(),
                scale: Scale::Log,
                unit,
            },
            front: false,
            series: vec![Series {
                name: "a light".into(),
                aside: String::new(),
                key: Key::new(0),
                competes: false,
                shape: Shape::Points,
                points: points.collect(),
            }],
        }
    };
    if lights.len() > 1 {
        study.parts.push(Part::Charts(Charts {
            share_legend: true,
            all: vec![
                chart("Size", Unit::Bytes, |light| {
                    (light.bytes as f64, bytes(light.bytes))
                }),
                chart("Time of the bake", Unit::Seconds, |light| {
                    (light.seconds, seconds(light.seconds))
                }),
            ],
        }));
    }
}
