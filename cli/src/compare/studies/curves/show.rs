//! The study of curves in words, charts and tables.

use super::{Family, Figure, Found, Line, RANGES, Row, Specimen};
use crate::compare::study::{
    self, Axis, Cell, Chart, Charts, Part, Point, Scale, Series, Shape, Study, Unit,
};
use crate::format::{bytes, seconds, significant};

/// Puts the measurements into words, charts and tables.
pub(super) fn describe(study: &mut Study, found: &Found) {
    let Found { specimens, figures } = found;
    if specimens.is_empty() {
        return;
    }
    study.introduction = "How much light gets how far through hair and smoke: every kind of curve on the same light rays, \
in the order in which a map is told of their blockers, against Beer–Lambert in double precision. \
Errors are differences of transmittance; the mean is over depths from the first blocker of a ray to its last. \
Times are of one segment and of one lookup, on one thread; memory is that of a texel. \
The table is that of Salvi et al. 2010 (table 1) with errors, and with curves that the paper does not have."
        .into();
    for Specimen { name, rows, .. } in specimens {
        for row in rows {
            study.records.push(vec![
                name.as_str().into(),
                Cell::keyed(row.family.title(), row.family.key()),
                row.setting.as_str().into(),
                row.mean[0].into(),
                row.max[0].into(),
                row.insertion.median.into(),
                row.lookup.median.into(),
                row.bytes.into(),
                row.mean[1].into(),
                row.max[1].into(),
                row.mean[2].into(),
                row.max[2].into(),
            ]);
        }
    }
    let headings = [
        ("curve", "curve"),
        ("setting", "setting"),
        ("mean", "mean error"),
        ("max", "max"),
        ("seconds_segment", "per segment"),
        ("seconds_lookup", "per lookup"),
        ("bytes", "per texel"),
        ("mean_range_4", "mean, range 4×"),
        ("mean_range_10", "range 10×"),
    ];
    study.parts.push(Part::Charts(Charts {
        share_legend: true,
        all: specimens.iter().map(chart).collect(),
    }));
    for specimen in specimens {
        let caption = format!(
            "{} light rays of {} segments on average. \
Methods that have to be told a range of depths are given the tightest that holds all rays, and ones {} and {} times as long; the others need none.",
            specimen.rays,
            significant(specimen.segments),
            RANGES[1],
            RANGES[2],
        );
        let own = |row: &study::Row| row.cells[0].text() == Some(&specimen.name);
        let table = study.records.view(&headings, own);
        let mut table = table.titled(specimen.name.as_str(), caption);
        table.grouped = true;
        study.parts.push(Part::Table(table));
    }
    study.parts.push(Part::Charts(Charts {
        share_legend: false,
        all: figures.iter().map(draw).collect(),
    }));
}

/// Error against time of all kinds.
fn chart(specimen: &Specimen) -> Chart {
    let point = |row: &Row| Point {
        x: row.insertion.median,
        y: row.mean[0],
        spread: [row.insertion.low, row.insertion.high],
        label: row.setting.clone(),
        title: format!(
            "{}, {}: mean {}, max {}, {} per segment, {} per texel",
            row.family.title(),
            row.setting,
            significant(row.mean[0]),
            significant(row.max[0]),
            seconds(row.insertion.median),
            bytes(row.bytes.round() as u64)
        ),
    };
    let points = |family: Family| {
        let rows = specimen.rows.iter();
        rows.filter(|row| row.family == family).map(point).collect()
    };
    Chart {
        title: specimen.name.clone(),
        caption: "mean error against the time of one segment".into(),
        description:
            "mean error of transmittance against the time of one segment, both logarithmic".into(),
        x: Axis {
            label: "time of one segment".into(),
            scale: Scale::Log,
            unit: Unit::Seconds,
        },
        y: Axis {
            label: "mean error of transmittance".into(),
            scale: Scale::Log,
            unit: Unit::Number,
        },
        front: true,
        series: series_of_kinds(points),
    }
}

/// The kinds that have points in a chart of errors. The truth itself would leave no room for
/// the others.
pub(crate) fn series_of_kinds(points: impl Fn(Family) -> Vec<Point>) -> Vec<Series> {
    let series = |family: Family| Series {
        name: family.title().into(),
        aside: String::new(),
        key: family.key(),
        competes: true,
        shape: Shape::Points,
        points: points(family),
    };
    let kinds = Family::ALL.into_iter();
    kinds
        .filter(|family| *family != Family::Uncompressed)
        .map(series)
        .filter(|series| !series.points.is_empty())
        .collect()
}

/// Transmittance against depth.
fn draw(figure: &Figure) -> Chart {
    let series = |line: &Line| {
        let points = figure.depths.iter().zip(&line.values);
        Series {
            name: line.name.clone(),
            aside: String::new(),
            key: line.key,
            competes: false,
            shape: Shape::Line,
            points: points.map(|(x, y)| Point::bare(*x, *y)).collect(),
        }
    };
    Chart {
        title: figure.title.clone(),
        caption: String::new(),
        description: figure.title.clone(),
        x: Axis {
            label: "depth, m".into(),
            scale: Scale::Linear,
            unit: Unit::Number,
        },
        y: Axis {
            label: "transmittance".into(),
            scale: Scale::Between(0.0, 1.0),
            unit: Unit::Number,
        },
        front: false,
        series: figure.lines.iter().map(series).collect(),
    }
}
