//! The section "voxels alone": where time and error of voxelized shadow
//! volumes come from.

use std::fmt::Write;

use super::plots::short_name;
use crate::compare::results::{Results, Times};
use crate::compare::voxels::{Axis, Voxels};
use crate::format::{error, seconds, significant};

pub(super) fn write(html: &mut String, results: &Results) {
    let voxels = &results.voxels;
    if voxels.refinements.is_empty() {
        return;
    }
    html.push_str("<h2>Voxelized shadow volumes alone</h2>\n");
    html.push_str("<p>One light of the scene, its first that is seen. Errors are RMSE of the airlight over its mean, of bits with a weight each.</p>\n");
    steps(html, results);
    refinements(html, voxels);
    detachments(html, voxels);
    html.push_str("<p class=\"soft\">The same as in <code>voxels.csv</code>.</p>\n");
}

fn steps(html: &mut String, results: &Results) {
    if results.voxels.steps.is_empty() {
        return;
    }
    html.push_str("<h3>A frame of 512³ voxels, step by step</h3>\n<p class=\"soft\">Creation and use take 7.2 ms in Wyman and Dai 2013, on a GPU of that year and without the runs; other rays and another scene.</p>\n<div class=\"wide\"><table>\n<tr><th>backend</th><th>rectify</th><th>voxelise</th><th>scan</th><th>gather: average</th><th>creation and use</th><th>gather: runs instead</th><th>rays</th></tr>\n");
    for row in &results.voxels.steps {
        let time = |times: &Times| seconds(times.median);
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            short_name(results, &row.backend),
            time(&row.rectify),
            time(&row.voxelise),
            time(&row.extrude),
            time(&row.average),
            seconds(row.total()),
            time(&row.runs),
            row.rays
        );
    }
    html.push_str("</table></div>\n");
}

fn refinements(html: &mut String, voxels: &Voxels) {
    let rows = &voxels.refinements;
    // The time may not have sufficed for all axes.
    let measured = |axis: Axis| rows.iter().filter(move |row| row.axis == axis);
    let first = rows.first().map_or(Axis::All, |row| row.axis);
    let sizes: Vec<u32> = measured(first).map(|row| row.size).collect();
    let (Some(coarsest), Some(finest)) = (sizes.first(), sizes.last()) else {
        return;
    };
    let _ = write!(
        html,
        "<h3>Which resolution the error comes from</h3>\n<p class=\"soft\">As figure 8 of Wyman and Dai 2013, in numbers. The shadow map has twice the size on each side. Where all but one are at {finest}, a row shows what that one adds; where all but one are at {coarsest}, what refining it alone brings.</p>\n<div class=\"wide\"><table>\n<tr><th>varied</th><th>the rest</th>"
    );
    for size in &sizes {
        let _ = write!(html, "<th>{size}</th>");
    }
    html.push_str("</tr>\n");
    for axis in Axis::ALL {
        for (index, rest) in [coarsest, finest].into_iter().enumerate() {
            // All together have no rest.
            if (axis == Axis::All && index > 0) || measured(axis).next().is_none() {
                continue;
            }
            let rest = match axis {
                Axis::All => String::new(),
                _ => rest.to_string(),
            };
            let class = if index == 0 { " class=\"first\"" } else { "" };
            let _ = write!(html, "<tr{class}><td>{}</td><td>{rest}</td>", axis.name());
            for row in measured(axis) {
                let value = [row.rest_coarse, row.rest_fine][index];
                let _ = write!(html, "<td>{}</td>", error(value, false));
            }
            html.push_str("</tr>\n");
        }
    }
    html.push_str("</table></div>\n");
    let _ = writeln!(
        html,
        "<p>With the biases of the paper (α −2.25 voxels, φ −1), which keep surfaces from shadowing themselves, the error at {finest} is {}; without a bias, as in all methods of this report, {}.</p>",
        error(voxels.biased, false),
        error(voxels.unbiased, false)
    );
}

fn detachments(html: &mut String, voxels: &Voxels) {
    if voxels.detachments.is_empty() {
        return;
    }
    html.push_str("<h3>Where shadows begin</h3>\n<p class=\"soft\">As figure 7 of Wyman and Dai 2013, in numbers: metres along the light between a blocker and its shadow, median and 90th percentile over light rays that meet one in view.</p>\n<div class=\"wide\"><table>\n<tr><th>α</th><th>bias −2.25: median</th><th>90 %</th><th>no bias: median</th><th>90 %</th></tr>\n");
    for row in &voxels.detachments {
        let _ = write!(html, "<tr><td>{}</td>", row.alpha);
        for length in row.paper.iter().chain(&row.unbiased) {
            let _ = write!(html, "<td>{} m</td>", significant(*length));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div>\n");
}
