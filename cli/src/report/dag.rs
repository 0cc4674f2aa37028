//! The section "baked shadows alone": sizes, bakes and filters.

use std::fmt::Write;

use crate::compare::dag::{Bake, Dag, Filters, STAGES, Sizes};
use crate::compare::results::Results;
use crate::format::{bytes, count, escape, seconds, significant};

pub(super) fn write(html: &mut String, results: &Results) {
    let dag = &results.dag;
    if dag.light.is_empty() {
        return;
    }
    let closed = if dag.watertightness.is_closed() {
        "All of its parts are closed.".to_owned()
    } else {
        format!(
            "{} of its {} have holes or are turned inside out: these are baked as surfaces, which compress less.",
            dag.watertightness.open_parts + dag.watertightness.inverted_parts,
            count(dag.watertightness.parts, "part")
        )
    };
    let _ = writeln!(
        html,
        "<h2>Baked shadows alone</h2>\n\
<p>Compact precomputed voxelized shadows of {}, in one grid. {closed}</p>",
        escape(&dag.light)
    );
    if let Some(sizes) = &dag.sizes {
        write_sizes(html, sizes);
    }
    write_bakes(html, dag);
    if let Some(filters) = &dag.filters {
        write_filters(html, filters);
    }
    html.push_str("<p class=\"soft\">The same as in <code>shadows.csv</code>.</p>\n");
}

fn write_sizes(html: &mut String, sizes: &Sizes) {
    let map = 2 * u64::from(sizes.resolution).pow(2);
    let _ = write!(
        html,
        "<h3>What rules and forms take</h3>\n<p class=\"soft\">{0}³ voxels, built from the same maps. \
A 16-bit shadow map takes {1}. The map has {2} silhouette edges: edges between texels whose depths, \
from entering solids to leaving them, have nothing in common. Building is without what made the maps.</p>\n\
<div class=\"wide\"><table>\n<tr><th>rule</th><th>plain</th><th>packed</th><th>packed / plain</th>\
<th>map / packed</th><th>bits per edge, plain</th><th>packed</th><th>build</th><th>without culling</th></tr>\n",
        sizes.resolution,
        bytes(map),
        sizes.edges
    );
    for row in &sizes.rows {
        let [plain, packed] = row.bytes;
        let per_edge = |size: u64| match sizes.edges {
            0 => "no edges".into(),
            edges => significant(8.0 * size as f64 / edges as f64),
        };
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            row.rule,
            bytes(plain),
            bytes(packed),
            significant(packed as f64 / plain as f64),
            significant(map as f64 / packed as f64),
            per_edge(plain),
            per_edge(packed),
            seconds(row.seconds[0]),
            seconds(row.seconds[1]),
        );
    }
    html.push_str("</table></div>\n");
}

fn write_bakes(html: &mut String, dag: &Dag) {
    if dag.bakes.is_empty() {
        return;
    }
    html.push_str(
        "<h3>From triangles to a file</h3>\n<p class=\"soft\">As far as the time allows. Growth is that of the whole over the bake of half the resolution. \
Memory is the most that the whole program held during a stage, the scene and all that the comparison keeps included; systems other than Linux do not tell.</p>\n\
<div class=\"wide\"><table>\n<tr><th>voxels</th>",
    );
    for stage in STAGES {
        let _ = write!(html, "<th>{stage}</th>");
    }
    html.push_str("<th>all</th><th>growth</th><th>most memory</th><th>packed file</th><th>16-bit map / file</th></tr>\n");
    let mut previous: Option<&Bake> = None;
    for bake in &dag.bakes {
        let _ = write!(html, "<tr><td>{}³</td>", bake.resolution);
        for (time, _) in bake.stages {
            let _ = write!(html, "<td>{}</td>", seconds(time));
        }
        let growth = previous.map_or("–".into(), |previous| {
            format!("{}×", significant(bake.seconds() / previous.seconds()))
        });
        let memory = bake.stages.iter().filter_map(|stage| stage.1).max();
        let map = 2.0 * f64::from(bake.resolution).powi(2);
        let _ = writeln!(
            html,
            "<td>{}</td><td>{growth}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            seconds(bake.seconds()),
            memory.map_or("not known".into(), bytes),
            bytes(bake.bytes),
            significant(map / bake.bytes as f64),
        );
        previous = Some(bake);
    }
    html.push_str("</table></div>\n");
}

fn write_filters(html: &mut String, filters: &Filters) {
    let _ = write!(
        html,
        "<h3>Shadows on surfaces</h3>\n<p class=\"soft\">One question for each of the {} pixels of a picture of {} whose surface faces the light, \
in a grid of {}³ voxels, on all threads; of all of them, and of one.</p>\n\
<div class=\"wide\"><table>\n<tr><th>filter</th><th>plain</th><th>each</th><th>packed</th><th>each</th></tr>\n",
        filters.receivers, filters.size, filters.resolution
    );
    for (width, times) in &filters.rows {
        let _ = write!(html, "<tr><td>{width}×{width}</td>");
        for time in times {
            let each = time.median / filters.receivers.max(1) as f64;
            let _ = write!(
                html,
                "<td>{}</td><td>{}</td>",
                seconds(time.median),
                seconds(each)
            );
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div>\n");
}
