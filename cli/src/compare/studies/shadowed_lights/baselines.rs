//! Errors of shadows on surfaces: precomputed ones, plain shadow maps of 16 bits, and four
//! cascades of a sun.

use std::time::Instant;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::direct_light::ShadowsOfMany;
use lighting::precomputed::FilterSize;
use lighting::shadow_map::{Casters, Depth16Maps};
use lighting::visibility::SurfaceShadow;

use super::{
    BakedLight, Extent, Limit, Subject, Traced, capitalised, lit_from, points, record, view,
};
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// Texels along each side of the filters.
const WIDTHS: [u32; 2] = [1, 9];

/// The share of the time after which no further light is begun.
const SHARE: f64 = 0.75;

/// Sums over lights, by the kind of shadow.
#[derive(Debug, Clone, Default)]
struct Sums {
    lights: u32,
    bytes: u64,
    /// Time of the bake, or of drawing the map.
    seconds: f64,
    lookups: u64,
    /// Time of the lookups, by the width of the filter.
    each: [Errors; 2],
}

#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    /// How many results are on the other side of one half than the truth.
    wrong: u64,
    error: f64,
    seconds: f64,
}

/// A point, its normal, and whether it sees the light.
type Receiver = (Vec3, Vec3, bool);

impl Sums {
    fn add(&mut self, bytes: u64, seconds: f64, receivers: &[Receiver]) {
        self.lights += 1;
        self.bytes += bytes;
        self.seconds += seconds;
        self.lookups += receivers.len() as u64;
    }

    fn compare(&mut self, width: usize, receivers: &[Receiver], shadow: &dyn SurfaceShadow) {
        let clock = Instant::now();
        let found = Cpu::new().map(receivers.len(), |i| {
            let (point, normal, _) = receivers[i];
            shadow.visibility(point, normal).x
        });
        let errors = &mut self.each[width];
        errors.seconds += clock.elapsed().as_secs_f64();
        for (found, (_, _, is_lit)) in found.iter().zip(receivers) {
            let error = (found - f32::from(u8::from(*is_lit))).abs();
            errors.wrong += u64::from(error > 0.5);
            errors.error += f64::from(error);
        }
    }
}

const WAYS: [&str; 3] = ["grids", "16-bit maps", "four cascades"];

pub(super) fn measure(
    study: &mut Study,
    subject: &Subject<'_>,
    extent: &Extent,
    (lights, limit): (&[BakedLight], &Limit<'_>),
) -> Result<(), Failure> {
    let cpu = Cpu::new();
    let picture = view(subject, extent.errors)?;
    let points = points(subject.geometry, &picture);
    let casters = Casters::upload(&cpu, subject.geometry)?;
    let along = picture.hits().iter().zip(picture.rays());
    let Extent { errors: size, .. } = extent;
    let pixels = [size.width, size.height];
    let forward = subject.camera.direction(
        0.5 * size.width as f32,
        0.5 * size.height as f32,
        size.width,
        size.height,
    );
    let depths = along.filter_map(|(hit, ray)| {
        let hit = hit.as_ref()?;
        Some(hit.distance * ray.direction().dot(forward))
    });
    let [near, far] = depths.fold([f32::INFINITY, 0.0], |[near, far]: [f32; 2], depth| {
        [near.min(depth), far.max(depth)]
    });
    if far <= 0.0 {
        study.leave_out("shadow maps", "no surface is in view");
        return Ok(());
    }
    // A little more, for surfaces that all are equally far away.
    let near = (0.99 * near).max(1e-4 * far);
    let seen = (subject.camera, pixels, [near, 1.01 * far]);
    let mut all: [[Sums; 3]; 2] = Default::default();
    for (done, light) in lights.iter().enumerate() {
        let until = (1.0 - SHARE) * limit.seconds();
        let left = if until.is_finite() { until } else { 0.0 };
        if let Some(why) = limit.reached_after(left) {
            study.leave_out(&format!("maps of more than {done} lights"), why);
            break;
        }
        let emitter = std::slice::from_ref(&light.emitter);
        let traced = Traced {
            tracer: subject.tracer,
            emitters: emitter,
        };
        let facing: Vec<_> = points
            .iter()
            .filter(|point| lit_from(&light.emitter, point).is_some())
            .collect();
        let receivers = cpu.map(facing.len(), |i| {
            let (point, normal) = (facing[i].position(), facing[i].normal());
            let is_lit = traced.visibility(0, point, normal) == Vec3::ONE;
            (point, normal, is_lit)
        });
        let sums = &mut all[usize::from(matches!(light.emitter, Emitter::Point(_)))];
        let (bytes, seconds) = (light.shadow.bytes(), light.seconds);
        sums[0].add(bytes, seconds, &receivers);
        for (i, width) in WIDTHS.into_iter().enumerate() {
            let filtered = light.shadow.filtered(FilterSize::new(width)?);
            sums[0].compare(i, &receivers, &filtered);
        }
        let clock = Instant::now();
        let maps = Depth16Maps::new(&cpu, &casters, &light.emitter, extent.voxels)?;
        let mut maps = vec![(maps, clock.elapsed().as_secs_f64())];
        if let Emitter::Directional(sun) = &light.emitter {
            let clock = Instant::now();
            let cascades = Depth16Maps::cascades(&cpu, &casters, sun, seen, extent.cascade)?;
            maps.push((cascades, clock.elapsed().as_secs_f64()));
        }
        for ((maps, seconds), sums) in maps.iter().zip(&mut sums[1..]) {
            sums.add(maps.bytes(), *seconds, &receivers);
            for (i, width) in WIDTHS.into_iter().enumerate() {
                sums.compare(i, &receivers, &maps.filtered(width));
            }
        }
    }
    describe(study, extent, &all);
    Ok(())
}

fn describe(study: &mut Study, extent: &Extent, all: &[[Sums; 3]; 2]) {
    let mut columns = vec![
        Column::plain("lights"),
        Column::plain("shadows"),
        Column::new("all", Unit::Bytes),
        Column::new("made in", Unit::Seconds),
    ];
    for width in WIDTHS {
        columns.push(Column::new(format!("{width}×{width}: wrong"), Unit::Share));
        columns.push(Column::new("mean error", Unit::Share));
        columns.push(Column::new("a lookup", Unit::Seconds));
    }
    let mut table = Table::new(columns).titled(
        "Beside the shadow maps of engines",
        format!(
            "On the surfaces of a picture of {} that face each light within its range and cone, \
             against shadow rays. Wrong is a lookup on the other side of one half; errors of wide \
             filters are those of soft edges, which shadow rays do not have. Maps have {} texels \
             per side and 16 bits for a depth, the cascades of a sun {} each, by the practical \
             split scheme and stabilised, over the depths of the surfaces in view. All are lifted \
             along the normal by half a filter and a texel, or voxel. Grids are made once, \
             cascades in every frame, maps when something moves.",
            extent.errors, extent.voxels, extent.cascade
        ),
    );
    for (kind, sums) in ["sun", "lamps"].into_iter().zip(all) {
        for (way, sums) in WAYS.into_iter().zip(sums) {
            if sums.lights == 0 || sums.lookups == 0 {
                continue;
            }
            let of = format!("{kind}, {way}");
            let size = match way {
                "four cascades" => extent.cascade,
                _ => extent.voxels,
            };
            record(study, "bytes", &of, size, sums.bytes as f64);
            record(study, "seconds to make", &of, size, sums.seconds);
            let lights = match kind {
                "lamps" => format!("{} {kind}", sums.lights),
                _ => capitalised(kind),
            };
            let mut cells: Vec<Cell> = vec![
                lights.into(),
                way.into(),
                sums.bytes.into(),
                sums.seconds.into(),
            ];
            for (width, errors) in WIDTHS.into_iter().zip(&sums.each) {
                let lookups = sums.lookups as f64;
                for (what, value) in [
                    ("wrong lookups", errors.wrong as f64 / lookups),
                    ("mean error", errors.error / lookups),
                    ("seconds of a lookup", errors.seconds / lookups),
                ] {
                    let what = format!("{what} of {width}x{width}");
                    record(study, &what, &of, size, value);
                    cells.push(value.into());
                }
            }
            table.push(cells);
        }
    }
    study.parts.push(Part::Table(table));
}
