//! The section "transmittance alone": curves of light rays through hair and
//! smoke, without a picture.

use std::fmt::Write;

use super::chart::{Curve, Labels, Point, chart, swatch};
use super::lines;
use crate::compare::curves::{Family, Figure, RANGES, Row, Subject};
use crate::compare::results::Results;
use crate::format::{bytes, escape, seconds, significant};

pub(super) fn write(html: &mut String, results: &Results) {
    let curves = &results.curves;
    if curves.subjects.is_empty() {
        return;
    }
    html.push_str("<h2>Transmittance alone</h2>\n");
    html.push_str(
        "<p>How much light gets how far through hair and smoke: every kind of curve on the same light rays, \
in the order in which a map is told of their blockers, against Beer–Lambert in double precision. \
Errors are differences of transmittance; the mean is over depths from the first blocker of a ray to its last. \
Times are of one segment and of one question, on one thread; memory is that of a texel. \
The table is that of Salvi et al. 2010 (table 1) with errors, and with curves that the paper does not have.</p>\n",
    );
    html.push_str("<ul class=\"legend\">\n");
    for family in Family::ALL {
        let (swatch, title) = (swatch(slot(family), false), family.title());
        let _ = writeln!(html, "<li>{swatch}<span>{title}</span></li>");
    }
    html.push_str("</ul>\n<div class=\"plots\">\n");
    for subject in &curves.subjects {
        if let Some(plot) = plot(subject) {
            let _ = writeln!(
                html,
                "<figure><figcaption><b>{}</b>: mean error against the time of one segment.</figcaption><div class=\"wide\">{plot}</div></figure>",
                escape(&subject.name)
            );
        }
    }
    html.push_str("</div>\n");
    for subject in &curves.subjects {
        table(html, subject);
    }
    html.push_str(
        "<p class=\"soft\">The same as in <code>curves.csv</code>.</p>\n<div class=\"plots\">\n",
    );
    for figure in &curves.figures {
        draw(html, figure);
    }
    html.push_str("</div>\n");
}

fn plot(subject: &Subject) -> Option<String> {
    let point = |row: &Row| Point {
        time: row.insertion.median,
        spread: (row.insertion.low, row.insertion.high),
        error: row.mean[0],
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
    let curves: Vec<Curve> = Family::ALL
        .into_iter()
        // The truth itself would leave no room for the others.
        .filter(|family| *family != Family::Uncompressed)
        .map(|family| Curve {
            slot: slot(family),
            dashed: false,
            competes: true,
            points: subject
                .rows
                .iter()
                .filter(|row| row.family == family)
                .map(point)
                .collect(),
        })
        .filter(|curve| !curve.points.is_empty())
        .collect();
    chart(
        &curves,
        &Labels {
            description: "mean error of transmittance against the time of one segment, both logarithmic",
            time: "time of one segment",
            error: "mean error of transmittance",
            write_time: &seconds,
            write_error: &significant,
        },
    )
}

fn table(html: &mut String, subject: &Subject) {
    let _ = write!(
        html,
        "<h3>{}</h3>\n<p class=\"soft\">{} light rays of {} segments on average. \
Methods that have to be told a range of depths are given the tightest that holds all rays, and ones {} and {} times as long; the others need none.</p>\n\
<div class=\"wide\"><table>\n<tr><th>curve</th><th>setting</th><th>mean error</th><th>max</th><th>per segment</th><th>per question</th><th>per texel</th><th>mean, range {}×</th><th>range {}×</th></tr>\n",
        escape(&subject.name),
        subject.rays,
        significant(subject.segments),
        RANGES[1],
        RANGES[2],
        RANGES[1],
        RANGES[2],
    );
    let mut previous = None;
    for row in &subject.rows {
        let first = previous.replace(row.family) != Some(row.family);
        let name = if first {
            let (swatch, title) = (swatch(slot(row.family), false), row.family.title());
            format!("<span class=\"name\">{swatch} {title}</span>")
        } else {
            String::new()
        };
        let class = if first { " class=\"first\"" } else { "" };
        let _ = writeln!(
            html,
            "<tr{class}><td>{name}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&row.setting),
            significant(row.mean[0]),
            significant(row.max[0]),
            seconds(row.insertion.median),
            seconds(row.lookup.median),
            bytes(row.bytes.round() as u64),
            significant(row.mean[1]),
            significant(row.mean[2]),
        );
    }
    html.push_str("</table></div>\n");
}

fn draw(html: &mut String, figure: &Figure) {
    let Some(plot) = lines::plot(figure) else {
        return;
    };
    let _ = write!(
        html,
        "<figure><figcaption><b>{}</b>.</figcaption><div class=\"wide\">{plot}</div>\n<ul class=\"legend\">\n",
        escape(&figure.title)
    );
    for line in &figure.lines {
        let (swatch, name) = (swatch(line.slot, false), escape(&line.name));
        let _ = writeln!(html, "<li>{swatch}<span>{name}</span></li>");
    }
    html.push_str("</ul></figure>\n");
}

/// Colour and marker of a family; the first is that of the truth.
fn slot(family: Family) -> usize {
    let mut all = Family::ALL.into_iter();
    1 + all.position(|other| other == family).unwrap_or(0)
}
