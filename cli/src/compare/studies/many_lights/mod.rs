//! Many lamps in the air of the scene: the cost of a picture of their light, by the number of
//! lamps and by the number of those that reach a pixel.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of Voxelized
//! Shadows, I3D 2015, section 4 and figure 4, whose lights shine on surfaces; and Olsson,
//! Billeter and Assarsson, Clustered Deferred and Forward Shading, HPG 2012.

mod lamps;
mod pictures;

use gpu_backend::Cpu;
use lighting::scene::view::View;

use super::{Kind, Limit, Subject, record, value_columns};
use crate::compare::study::{
    Axis, Cell, Chart, Charts, Column, Key, Part, Point, Scale, Series, Shape, Study, Table, Unit,
};
use crate::failure::Failure;
use crate::format::{seconds, significant};
use crate::parse::Size;
use crate::progress;
use lamps::{Counts, Crowd, Lamps};
use pictures::Way;

pub(super) const KIND: Kind = Kind {
    title: "many lights",
    csv: "many-lights.csv",
    columns: value_columns,
    seconds: Some([1.0, 40.0]),
    in_fog: true,
    pointless: |_| None,
    run,
};

/// The picture, and the numbers of lamps.
struct Extent {
    size: Size,
    lamps: &'static [u32],
    /// The numbers of lamps with precomputed shadows, which have `voxels` along each axis.
    shadowed: &'static [u32],
    voxels: u32,
}

const ALL: Extent = Extent {
    size: Size {
        width: 480,
        height: 270,
    },
    lamps: &[10, 30, 100, 300, 1000, 3000, 10_000],
    shadowed: &[10, 100, 1000],
    voxels: 256,
};
const QUICK: Extent = Extent {
    size: Size {
        width: 64,
        height: 36,
    },
    lamps: &[10, 100],
    shadowed: &[8],
    voxels: 64,
};

/// One frame of some lamps.
struct Frame {
    lamps: u32,
    counts: Counts,
    /// Seconds to make the lists of the tiles, and those of the clusters.
    lists: [f64; 2],
    /// Seconds of the gather in each way that there was time for.
    seconds: Vec<(Way, f64)>,
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let extent = if subject.quick { &QUICK } else { &ALL };
    let Size { width, height } = extent.size;
    if let Some(why) = limit.reached() {
        study.leave_out("", why);
        return Ok(study);
    }
    let view = View::new(&Cpu::new(), subject.camera, subject.tracer, width, height)?;
    if view.hits().iter().all(Option::is_none) {
        study.leave_out("", "no surface is in view");
        return Ok(study);
    }
    let bar = progress::bar(
        "many lights",
        (2 * extent.lamps.len() + extent.shadowed.len()) as u64,
    );
    for (crowd, name) in [
        (Crowd::Constant, "as many lamps reach a pixel"),
        (Crowd::Growing, "lamps of one size"),
    ] {
        let mut frames = Vec::new();
        for &count in extent.lamps {
            let last = frames.last().map_or(0.0, |frame: &Frame| {
                frame.seconds.iter().map(|(_, seconds)| seconds).sum()
            });
            if let Some(why) = limit.reached_after(2.0 * last) {
                let most = frames.last().map_or(0, |frame: &Frame| frame.lamps);
                study.leave_out(&format!("{name}: more than {most} lamps"), why);
                break;
            }
            let lamps = Lamps::new(&view, width, crowd, count)?;
            frames.push(pictures::unshadowed(subject, &view, &lamps, limit)?);
            bar.inc(1);
        }
        describe(&mut study, extent, (name, crowd), &frames);
    }
    let mut frames = Vec::new();
    let mut before = limit.elapsed();
    for &count in extent.shadowed {
        let last = limit.elapsed() - before;
        before = limit.elapsed();
        let more = if frames.is_empty() { 0.0 } else { 10.0 * last };
        if let Some(why) = limit.reached_after(more) {
            study.leave_out(&format!("{count} lamps with precomputed shadows"), why);
            break;
        }
        let lamps = Lamps::new(&view, width, Crowd::Constant, count)?;
        frames.push(pictures::shadowed(
            subject,
            &view,
            &lamps,
            (extent.voxels, limit),
        )?);
        bar.inc(1);
    }
    let name = "with precomputed shadows";
    describe(&mut study, extent, (name, Crowd::Constant), &frames);
    bar.finish_and_clear();
    if subject.quick {
        study.leave_out("more lamps, and a larger picture", "--quick");
    }
    study.introduction = format!(
        "Lamps of limited range in the air before the surfaces of the scene, in place of its \
         lights. On the CPU, pictures of {width} x {height} pixels; airlight by {} Gauss nodes. \
         A light reaches a pixel where its range meets the pixel's ray. Listed are the lights \
         that the ray's tile of 4 x 4 pixels names and that begin before its end; at surfaces \
         those of the point's cluster, and those of its tile. Times of gathers are the faster of \
         two frames; lists are made once. Without culling there are at most some 300 lamps at \
         480 x 270 pixels, and a way that there is no time for is left blank.",
        pictures::NODES,
    );
    Ok(study)
}

/// Puts the frames of a crowd into records, a table and a chart.
fn describe(study: &mut Study, extent: &Extent, (name, crowd): (&str, Crowd), frames: &[Frame]) {
    if frames.is_empty() {
        return;
    }
    let pixels = f64::from(extent.size.width) * f64::from(extent.size.height);
    let mut columns = vec![Column::plain("lamps"), Column::plain("reach a pixel")];
    columns.extend(["listed", "at surfaces: lit", "by clusters", "by tiles"].map(Column::plain));
    let times = ["lists", "clusters"].iter().copied();
    let ways = Way::ALL.iter().map(|way| way.name());
    columns.extend(
        times
            .chain(ways)
            .map(|name| Column::new(name, Unit::Seconds)),
    );
    let caption = match crowd {
        Crowd::Constant => {
            "The more lamps there are, the smaller they are, so that the same number reaches a pixel on average."
        }
        Crowd::Growing => "All lamps have the same size as seen from the eye.",
    };
    let mut title = name.to_owned();
    title[..1].make_ascii_uppercase();
    let mut table = Table::new(columns).titled(title.clone(), caption);
    for frame in frames {
        let each = |count: u64| count as f64 / pixels;
        let Counts {
            reach,
            listed,
            lit,
            by_clusters,
            by_tiles,
            surfaces,
        } = frame.counts;
        let at_surface = |count: u64| count as f64 / surfaces.max(1) as f64;
        let mut cells: Vec<Cell> = vec![frame.lamps.into()];
        for (what, value) in [
            ("lights that reach a pixel", each(reach)),
            ("lights listed for a pixel", each(listed)),
            ("lights that reach a surface", at_surface(lit)),
            ("lights of a cluster", at_surface(by_clusters)),
            ("lights of a tile", at_surface(by_tiles)),
        ] {
            record(study, what, name, frame.lamps, value);
            cells.push(value.into());
        }
        for (what, value) in [
            ("seconds for lists", frame.lists[0]),
            ("seconds for clusters", frame.lists[1]),
        ] {
            record(study, what, name, frame.lamps, value);
            cells.push(value.into());
        }
        for way in Way::ALL {
            let found = frame.seconds.iter().find(|(other, _)| *other == way);
            cells.push(found.map_or("–".into(), |(_, seconds)| (*seconds).into()));
            if let Some((_, seconds)) = found {
                let what = format!("seconds of a pixel, {}", way.name());
                record(study, &what, name, frame.lamps, seconds / pixels);
            }
        }
        table.push(cells);
    }
    study.parts.push(Part::Table(table));
    study.parts.push(Part::Charts(Charts {
        share_legend: true,
        all: vec![chart(&title, frames, pixels)],
    }));
}

/// The cost of a pixel against the number of lamps.
fn chart(title: &str, frames: &[Frame], pixels: f64) -> Chart {
    let point = |way: Way, frame: &Frame| {
        let (_, total) = frame.seconds.iter().find(|(other, _)| *other == way)?;
        let each = total / pixels;
        Some(Point {
            x: f64::from(frame.lamps),
            y: each,
            spread: [f64::from(frame.lamps); 2],
            label: frame.lamps.to_string(),
            title: format!(
                "{}, {} lamps, of which {} reach a pixel: {} a pixel",
                way.name(),
                frame.lamps,
                significant(frame.counts.reach as f64 / pixels),
                seconds(each)
            ),
        })
    };
    let series = |(slot, way): (usize, Way)| Series {
        name: way.name().into(),
        aside: String::new(),
        key: Key::new(slot),
        competes: false,
        shape: Shape::Points,
        points: frames
            .iter()
            .filter_map(|frame| point(way, frame))
            .collect(),
    };
    let axis = |label: &str, unit| Axis {
        label: label.into(),
        scale: Scale::Log,
        unit,
    };
    Chart {
        title: format!("{title}: the cost of a pixel"),
        caption: String::new(),
        description: format!("time of a pixel against the number of lamps, {title}"),
        x: axis("lamps", Unit::Number),
        y: axis("time of a pixel", Unit::Seconds),
        front: false,
        series: Way::ALL.into_iter().enumerate().map(series).collect(),
    }
}

#[cfg(test)]
mod tests {
    use lighting::scene::procedural::Embedded;

    use super::*;
    use crate::compare::studies::tests::Stand;
    use crate::compare::study::Value;

    #[test]
    fn a_quick_study_has_every_part_and_one_without_time_says_so() {
        let stand = Stand::of(Embedded::Fence);
        let subject = stand.subject();
        let study = run(&subject, &Limit::of(f64::INFINITY)).unwrap();
        assert!(study.left_out.len() == 1 && !study.introduction.is_empty());
        assert_eq!(study.parts.len(), 6);
        for row in study.records.rows() {
            assert!(matches!(row.cells[3].value, Value::Number(value) if value >= 0.0));
        }
        let none = run(&subject, &Limit::of(0.0)).unwrap();
        assert!(none.records.rows().is_empty() && none.left_out.len() == 1);
    }
}
