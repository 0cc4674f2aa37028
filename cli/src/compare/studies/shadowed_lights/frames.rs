//! Frames of a camera that turns around: lists of lights, shadows and shading, and when a
//! bake has paid for itself.

use std::f32::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use lighting::culling::{PointLists, RayTiles, TileLights};
use lighting::direct_light::{AddDirectLight, LitPoints, ShadowsOfMany};
use lighting::precomputed::FilterSize;
use lighting::scene::Camera;
use lighting::scene::view::View;
use lighting::visibility::Unshadowed;
use lighting::{Emitter, SurfacePoint};

use super::{BakedLight, Extent, Limit, Subject, Traced, points, record};
use crate::compare::study::{
    Axis, Chart, Charts, Column, Key, Part, Point, Scale, Series, Shape, Study, Table, Unit,
};
use crate::failure::Failure;
use crate::format::{seconds, significant};

/// Texels along each side of the filter.
const FILTER: u32 = 9;

/// About how many seconds a shadow ray takes, to foresee times.
const SHADOW_RAY: f64 = 2e-6;

/// One frame.
#[derive(Debug, Clone, Copy, Default)]
struct Frame {
    /// Lights in the list of a tile, and of those at the surface of a pixel, in the mean.
    listed: [f64; 2],
    /// Pairs of a pixel and a light that shines on the front of its surface.
    pairs: usize,
    lists: f64,
    shading: f64,
    shadows: f64,
    /// Shadow rays in place of lookups, where there was time for them.
    exact: Option<f64>,
}

/// Shadows that count their lookups.
struct Counted(AtomicUsize);

impl ShadowsOfMany for Counted {
    fn visibility(&self, _: usize, _: Vec3, _: Vec3) -> Vec3 {
        self.0.fetch_add(1, Ordering::Relaxed);
        Vec3::ONE
    }
}

pub(super) fn measure(
    study: &mut Study,
    subject: &Subject<'_>,
    extent: &Extent,
    (lights, limit): (&[BakedLight], &Limit<'_>),
) -> Result<(), Failure> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut last = 0.0;
    for number in 0..extent.frames {
        if let Some(why) = limit.reached_after(last) {
            study.leave_out(&format!("more than {number} frames"), why);
            break;
        }
        let before = limit.elapsed();
        let turned = Quat::from_rotation_y(TAU * number as f32 / extent.frames as f32);
        let of = subject.camera;
        let camera = Camera::new(of.eye(), turned * of.rotation(), of.vertical_fov())?;
        frames.push(frame(subject, extent, &camera, (lights, limit))?);
        last = limit.elapsed() - before;
    }
    describe(study, extent, &frames, lights);
    Ok(())
}

fn frame(
    subject: &Subject<'_>,
    extent: &Extent,
    camera: &Camera,
    (lights, limit): (&[BakedLight], &Limit<'_>),
) -> Result<Frame, Failure> {
    let cpu = Cpu::new();
    let emitters: Vec<Emitter> = lights.iter().map(|light| light.emitter.clone()).collect();
    let (width, height) = (extent.picture.width, extent.picture.height);
    let view = View::new(&cpu, camera, subject.tracer, width, height)?;
    let points = points(subject.geometry, &view);
    let rays = view.rays();
    let mut frame = Frame::default();
    let clock = Instant::now();
    let lists = PointLists::of_picture(&cpu, rays, width, &emitters);
    frame.lists = clock.elapsed().as_secs_f64();
    let tiles = RayTiles::new(&cpu, rays, width, None)
        .ok_or_else(|| Failure::new("the rays of the view do not start at one eye"))?;
    let of_tiles = TileLights::new(&cpu, &tiles, &emitters)?.entries() as f64;
    let (mut surfaces, mut at_surfaces) = (0, 0);
    for (i, _) in points
        .iter()
        .enumerate()
        .filter(|(_, point)| point.reflects())
    {
        surfaces += 1;
        at_surfaces += lists.of(i).len();
    }
    frame.listed = [
        of_tiles / tiles.tiles() as f64,
        at_surfaces as f64 / f64::from(surfaces.max(1)),
    ];
    let counted = Counted(AtomicUsize::new(0));
    lit(&cpu, (&points, &emitters, &lists), &counted)?;
    frame.pairs = counted.0.into_inner();
    let filter = FilterSize::new(FILTER)?;
    let filtered: Vec<_> = lights
        .iter()
        .map(|light| light.shadow.filtered(filter))
        .collect();
    let of = (&points, &emitters[..], &lists);
    frame.shading = lit(&cpu, of, &Unshadowed)?;
    frame.shadows = (lit(&cpu, of, &filtered)? - frame.shading).max(0.0);
    if limit
        .reached_after(SHADOW_RAY * frame.pairs as f64)
        .is_none()
    {
        let traced = Traced {
            tracer: subject.tracer,
            emitters: &emitters,
        };
        frame.exact = Some((lit(&cpu, of, &traced)? - frame.shading).max(0.0));
    }
    Ok(frame)
}

/// Seconds of the faster of two runs.
fn lit<V: ShadowsOfMany>(
    cpu: &Cpu,
    (points, emitters, lists): (&Vec<SurfacePoint>, &[Emitter], &PointLists),
    shadows: &V,
) -> Result<f64, Failure> {
    let mut least = f64::INFINITY;
    for _ in 0..2 {
        let mut radiance = vec![[0.0; 4]; points.len()];
        let clock = Instant::now();
        let lit = LitPoints::new(points, emitters, lists, None);
        cpu.add_direct_light(&lit, shadows, &mut radiance)?;
        least = least.min(clock.elapsed().as_secs_f64());
    }
    Ok(least)
}

fn describe(study: &mut Study, extent: &Extent, frames: &[Frame], lights: &[BakedLight]) {
    if frames.is_empty() {
        return;
    }
    let mean =
        |of: &dyn Fn(&Frame) -> f64| frames.iter().map(of).sum::<f64>() / frames.len() as f64;
    let pairs: usize = frames.iter().map(|frame| frame.pairs).sum();
    let lookups: f64 = frames.iter().map(|frame| frame.shadows).sum();
    let bakes: f64 = lights.iter().map(|light| light.seconds).sum();
    let traced = frames
        .iter()
        .filter_map(|frame| Some((frame.exact?, frame.shadows)));
    let (mut saved, mut count) = (0.0, 0);
    for (exact, shadows) in traced {
        saved += exact - shadows;
        count += 1;
    }
    // Frames after which the bake has cost less than shadow rays, where it ever does.
    let paid = (saved > 0.0).then(|| (bakes / (saved / f64::from(count))).ceil());
    let of = format!("{FILTER}x{FILTER}");
    let each = lookups / pairs.max(1) as f64;
    let mut values = vec![
        ("lights of a tile", mean(&|frame| frame.listed[0])),
        (
            "lights of the cluster of a surface",
            mean(&|frame| frame.listed[1]),
        ),
        (
            "lights that shine on a pixel",
            pairs as f64 / frames.len() as f64 / pixels(extent),
        ),
        ("seconds of lists", mean(&|frame| frame.lists)),
        ("seconds of shadows", mean(&|frame| frame.shadows)),
        ("seconds of shading", mean(&|frame| frame.shading)),
        ("seconds of a pixel and a light, packed", each),
    ];
    values.extend(paid.map(|frames| ("frames until the bake has paid for itself", frames)));
    for (what, value) in &values {
        record(study, what, &of, extent.picture.height, *value);
    }
    let paid = match paid {
        Some(frames) => format!(
            "After {} frames the bake has cost less than shadow rays.",
            significant(frames)
        ),
        None if count > 0 => "Shadow rays cost less here than lookups.".into(),
        None => "There was no time for shadow rays.".into(),
    };
    let mut table = Table::new(vec![
        Column::plain("frame"),
        Column::plain("lights of a tile"),
        Column::plain("of a cluster"),
        Column::plain("shining on a pixel"),
        Column::new("lists", Unit::Seconds),
        Column::new("shadows", Unit::Seconds),
        Column::new("shading", Unit::Seconds),
        Column::new("shadow rays", Unit::Seconds),
    ])
    .titled(
        "Frames",
        format!(
            "The camera turns around once in {} frames of {}. Lists of lights are made in every frame, \
             shadows are lookups of {FILTER} × {FILTER} texels, shading is all else of the light of \
             surfaces; times are the faster of two, shadow rays are in place of lookups. A pixel and \
             a light take {}. {paid}",
            frames.len(),
            extent.picture,
            seconds(each)
        ),
    );
    for (frame, number) in frames.iter().zip(1u32..) {
        table.push(vec![
            number.into(),
            frame.listed[0].into(),
            frame.listed[1].into(),
            (frame.pairs as f64 / pixels(extent)).into(),
            frame.lists.into(),
            frame.shadows.into(),
            frame.shading.into(),
            frame.exact.map_or("–".into(), Into::into),
        ]);
    }
    study.parts.push(Part::Table(table));
    if frames.len() > 1 {
        study.parts.push(Part::Charts(Charts {
            share_legend: true,
            all: vec![chart(frames)],
        }));
    }
}

fn pixels(extent: &Extent) -> f64 {
    f64::from(extent.picture.width) * f64::from(extent.picture.height)
}

/// A part of a frame, by its name.
type Named = (&'static str, fn(&Frame) -> f64);

/// The parts of each frame.
fn chart(frames: &[Frame]) -> Chart {
    let parts: [Named; 3] = [
        ("lists", |frame| frame.lists),
        ("shadows", |frame| frame.shadows),
        ("shading", |frame| frame.shading),
    ];
    let series = |(slot, (name, of)): (usize, Named)| Series {
        name: name.into(),
        aside: String::new(),
        key: Key::new(slot),
        competes: false,
        shape: Shape::Points,
        points: (frames.iter().zip(1..))
            .map(|(frame, number)| Point {
                x: f64::from(number),
                y: of(frame),
                spread: [f64::from(number); 2],
                label: String::new(),
                title: format!("frame {number}, {name}: {}", seconds(of(frame))),
            })
            .collect(),
    };
    Chart {
        title: "The parts of a frame".into(),
        caption: String::new(),
        description: "time of lists, shadows and shading in each frame".into(),
        x: Axis {
            label: "frame".into(),
            scale: Scale::Linear,
            unit: Unit::Number,
        },
        y: Axis {
            label: "time".into(),
            scale: Scale::Log,
            unit: Unit::Seconds,
        },
        front: false,
        series: parts.into_iter().enumerate().map(series).collect(),
    }
}
