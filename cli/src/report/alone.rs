//! The section "airlight alone": evaluators without a scene.

use std::fmt::Write;

use super::chart::{Curve, Labels, Point, chart, swatch};
use crate::compare::alone::{Alone, Family, Judgement, WORST};
use crate::compare::results::Results;
use crate::format::{bytes, escape, seconds, significant};

pub(super) fn write(html: &mut String, results: &Results) {
    let all = &results.alone;
    if all.is_empty() {
        return;
    }
    html.push_str("<h2>Airlight alone</h2>\n");
    let _ = writeln!(
        html,
        "<p>Every evaluator of the light from a part of a ray, without a scene, for this scene's phase function ({}): \
the largest relative error over a list of segments against the time of one evaluation, in batches on one thread. \
The stiff list holds rays towards the light, past it and away from it, exactly and nearly, vacuum and optical depths of 80, \
parts from a billionth of the distance to infinity, and distances from a micrometre to a thousand kilometres; \
the ordinary one holds rays from the eye on at optical distances of 0.1 to 2.</p>",
        escape(&results.phase)
    );
    html.push_str("<ul class=\"legend\">\n");
    for (slot, family) in Family::ALL.into_iter().enumerate() {
        if all.iter().any(|alone| alone.family == family) {
            let (swatch, title) = (swatch(slot, false), family.title());
            let _ = writeln!(html, "<li>{swatch}<span>{title}</span></li>");
        }
    }
    html.push_str("</ul>\n<div class=\"plots\">\n");
    for (caption, judgement) in [
        (
            "<b>Stiff segments</b>: the worst of them",
            stiff as fn(&Alone) -> &Judgement,
        ),
        ("<b>Ordinary segments</b>: the worst of them", easy),
    ] {
        if let Some(plot) = plot(all, judgement) {
            let _ = writeln!(
                html,
                "<figure><figcaption>{caption}.</figcaption><div class=\"wide\">{plot}</div></figure>"
            );
        }
    }
    html.push_str("</div>\n");
    table(html, all);
}

fn stiff(alone: &Alone) -> &Judgement {
    &alone.stiff
}

fn easy(alone: &Alone) -> &Judgement {
    &alone.easy
}

fn plot(all: &[Alone], judgement: fn(&Alone) -> &Judgement) -> Option<String> {
    let point = |alone: &Alone| {
        let Judgement { worst, time, .. } = *judgement(alone);
        Point {
            time: time.median,
            spread: (time.low, time.high),
            error: worst,
            label: alone.setting.clone(),
            title: format!(
                "{}, {}: {} in {}",
                alone.family.title(),
                alone.setting,
                relative(worst),
                seconds(time.median)
            ),
        }
    };
    let curves: Vec<Curve> = Family::ALL
        .into_iter()
        .enumerate()
        .map(|(slot, family)| Curve {
            slot,
            dashed: false,
            competes: true,
            points: all
                .iter()
                .filter(|alone| alone.family == family)
                .map(point)
                .collect(),
        })
        .filter(|curve| !curve.points.is_empty())
        .collect();
    chart(
        &curves,
        &Labels {
            description: "largest relative error against the time of one evaluation, both logarithmic",
            time: "time of one evaluation",
            error: "largest relative error",
            write_time: &seconds,
            write_error: &relative,
        },
    )
}

fn table(html: &mut String, all: &[Alone]) {
    html.push_str(
        "<p class=\"soft\">Errors are relative, of results that f32 can hold. The same as in <code>airlight.csv</code>.</p>\n\
<div class=\"wide\"><table>\n<tr><th>evaluator</th><th>setting</th><th>stiff: worst</th><th>median</th><th>time</th><th>ordinary: worst</th><th>median</th><th>time</th><th>tables</th><th>build</th></tr>\n",
    );
    let mut previous = None;
    for alone in all {
        let first = previous.replace(alone.family) != Some(alone.family);
        let name = if first {
            format!(
                "<span class=\"name\">{} {}</span>",
                swatch(slot(alone.family), false),
                alone.family.title()
            )
        } else {
            String::new()
        };
        let class = if first { " class=\"first\"" } else { "" };
        let _ = write!(
            html,
            "<tr{class}><td>{name}</td><td>{}</td>",
            escape(&alone.setting)
        );
        for judgement in [&alone.stiff, &alone.easy] {
            let _ = write!(
                html,
                "<td>{}</td><td>{}</td><td>{}</td>",
                relative(judgement.worst),
                relative(judgement.median),
                seconds(judgement.time.median)
            );
        }
        let _ = writeln!(
            html,
            "<td>{}</td><td>{}</td></tr>",
            bytes(alone.bytes),
            seconds(alone.seconds_build)
        );
    }
    html.push_str("</table></div>\n");
}

/// Colour and marker of a family.
fn slot(family: Family) -> usize {
    Family::ALL
        .into_iter()
        .position(|other| other == family)
        .unwrap_or(0)
}

/// A relative error as people read it.
fn relative(value: f64) -> String {
    if value >= WORST {
        format!("≥ {}", significant(WORST))
    } else {
        significant(value)
    }
}
