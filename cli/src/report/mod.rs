//! The page that shows a comparison: one HTML file that needs nothing else.

mod alone;
mod axis;
mod chart;
mod curves;
mod dag;
mod lines;
mod pictures;
mod plots;
mod summary;
mod tables;
mod voxels;

pub(crate) use summary::plain as sentences;

use std::fmt::Write;

use crate::compare::results::Results;
use crate::failure::Failure;
use crate::format::{count, error, escape, seconds};

/// What tells our reports from other folders.
pub(crate) const MARK: &str = "<meta name=\"generator\" content=\"crepuscular compare\">";

/// The whole page.
pub(crate) fn page(results: &Results) -> Result<String, Failure> {
    let mut html = String::new();
    let scene = escape(&results.scene);
    // Writing to a string cannot fail, here and below.
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{MARK}\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Light in fog: {scene}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
        include_str!("style.css")
    );
    head(&mut html, results);
    summary::write(&mut html, results);
    plots::write(&mut html, results);
    tables::write_targets(&mut html, results);
    pictures::write(&mut html, results)?;
    tables::write_measurements(&mut html, results);
    alone::write(&mut html, results);
    voxels::write(&mut html, results);
    curves::write(&mut html, results);
    dag::write(&mut html, results);
    passes(&mut html, results);
    how_measured(&mut html, results);
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

fn head(html: &mut String, results: &Results) {
    let _ = write!(
        html,
        "<h1>Error against run time: {}</h1>\n<p class=\"facts\">{}, {} triangles, {} pixels, {}. Measured on {}; {}: {}.</p>\n",
        escape(&results.scene),
        escape(&results.lights),
        results.triangles,
        results.size,
        escape(&results.medium),
        escape(&results.machine),
        if results.backends.len() == 1 {
            "backend"
        } else {
            "backends"
        },
        escape(&results.backends.join(", ")),
    );
}

fn passes(html: &mut String, results: &Results) {
    html.push_str("<h2>What ran, and what did not</h2>\n");
    let list = |html: &mut String, title: &str, items: &[String]| {
        if items.is_empty() {
            return;
        }
        let _ = writeln!(html, "<h3>{title}</h3>\n<ul>");
        for item in items {
            let _ = writeln!(html, "<li>{item}</li>");
        }
        html.push_str("</ul>\n");
    };
    let escaped: Vec<String> = results.notes.iter().map(|note| escape(note)).collect();
    list(html, "Placed, assumed or reduced", &escaped);
    let escaped: Vec<String> = results.ran.iter().map(|pass| escape(pass)).collect();
    list(html, "Passes", &escaped);
    let left_out: Vec<String> = results
        .left_out
        .iter()
        .map(|l| format!("<b>{}</b>: {}", escape(&l.what), escape(&l.why)))
        .collect();
    list(html, "Left out", &left_out);
    if left_out.is_empty() {
        html.push_str("<p>Nothing was left out.</p>\n");
    }
}

fn how_measured(html: &mut String, results: &Results) {
    let reference = &results.reference;
    let unit = if reference.absolute {
        "The reference's mean radiance is 0, so errors are absolute, in units of radiance."
    } else {
        "Errors are divided by the reference's mean radiance, so 1 % is a hundredth of the mean brightness of the airlight."
    };
    let way = match reference.parts {
        None => format!(
            "exact lit intervals of every ray × quadrature in double precision with a bound on its error, \
by code that shares only its input with the methods: rays with their ends, lights, triangles. Asked for {} per pixel; the largest bound of a pixel is {}",
            error(reference.tolerance, false),
            error(reference.bound, reference.absolute)
        ),
        Some(parts) => format!(
            "exact lit intervals of every ray, cut into {parts} parts, each times the exact transmittance of hair and smoke at two points of it, in double precision, \
by code that shares only its input with the methods. The largest difference that it makes for a pixel to take one point of each part is {}, next to the edges of hair",
            error(reference.bound, reference.absolute)
        ),
    };
    let repetitions = results.measurements.iter().map(|m| m.frame.repetitions);
    let (least, most) = (repetitions.clone().min(), repetitions.max());
    let repetitions = match (least, most) {
        (Some(a), Some(b)) if a == b => count(a, "run"),
        (Some(a), Some(b)) => format!("{a} to {b} runs"),
        _ => "no runs".into(),
    };
    let gpu = if results.backends.iter().any(|backend| backend != "cpu") {
        "On a GPU a frame is recorded, submitted and waited for; pipelines were built, and rays and shadow maps uploaded, before the first one, and the picture is read back after the clock has stopped. "
    } else {
        ""
    };
    let software = match results.software() {
        Some(backend) => format!(
            "<b>Times of {} are not representative</b>: the processor plays the GPU. They are shown with an asterisk, and neither the summary nor the front nor the shaded cells count them. ",
            escape(backend)
        ),
        None => String::new(),
    };
    let _ = write!(
        html,
        "<h2>How this was measured</h2>\n<ul>\n\
<li><b>What is compared</b>: the airlight, that is the light scattered towards the eye along each ray of the picture, summed over the lights. \
Surfaces are the same for all methods and are left out of every error and every time.</li>\n\
<li><b>Reference</b>: {way}. Took {}. Mean radiance {}.</li>\n\
<li><b>Errors</b>: linear radiance over all pixels and colour channels. {unit} RMSE is the root of the mean square, max the largest difference; \
p99 is the 99th percentile of the error relative to the pixel itself.</li>\n\
<li><b>Times</b>: the frame is the airlight of one picture from given rays, the median of {repetitions} taken in turns, with the fastest and the slowest as bars; \
build is what has to exist first: the tracing structure, or the shadow maps ({}). {gpu}{software}Both grow with the picture or the map, so compare ratios, and only within one report.</li>\n\
<li><b>Shadow maps</b> set a floor: marches converge to what their map shows, not to the reference. Where a curve turns flat, more steps are wasted and a finer map is needed (<code>--map</code>). A frame of voxelized shadow volumes makes the voxels anew for each light. \
A quadrature with a fixed number of nodes has a floor of its own where the light along a lit run has kinks: the edge of a spotlight, the faces of a bounded medium.</li>\n\
<li><b>Total</b>: {}.</li>\n</ul>\n",
        seconds(reference.seconds),
        crate::format::significant(reference.mean),
        escape(&results.shadow_maps),
        seconds(results.seconds_total),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    /// Opening tags without a closing one, in order.
    fn unbalanced(html: &str) -> Vec<String> {
        const VOID: [&str; 4] = ["meta", "img", "br", "!doctype"];
        let mut open = Vec::new();
        for tag in html.split('<').skip(1) {
            let inner = tag.split('>').next().unwrap();
            if let Some(name) = inner.strip_prefix('/') {
                assert_eq!(open.pop().as_deref(), Some(name), "closed by </{name}>");
            } else if !inner.ends_with('/') {
                let name = inner.split_whitespace().next().unwrap();
                if !VOID.contains(&name) {
                    open.push(name.to_owned());
                }
            }
        }
        open
    }

    #[test]
    fn every_method_has_a_colour() {
        let style = include_str!("style.css");
        for slot in 0..crate::methods::METHODS.len() {
            assert!(style.contains(&format!(".m{slot} {{ color")), "{slot}");
            assert_eq!(style.matches(&format!("--m{slot}: #")).count(), 2, "{slot}");
        }
    }

    #[test]
    fn the_page_is_well_formed_and_needs_no_network() {
        let html = page(&example()).unwrap();
        assert_eq!(unbalanced(&html), Vec::<String>::new());
        for absent in [
            "http:", "https:", "<script", "src=\"/", "NaN", "inf ", "url(",
        ] {
            assert!(!html.contains(absent), "{absent}");
        }
        assert!(html[..1000].contains(MARK), "found again when replaced");
        assert!(html.contains("a &lt;test&gt;"), "names are escaped");
        assert!(html.contains("it never meets the view"));
    }

    #[test]
    fn times_of_a_software_adapter_are_marked_as_such() {
        let html = page(&example_with_software()).unwrap();
        assert_eq!(unbalanced(&html), Vec::<String>::new());
        assert!(html.contains("(a, &quot;b&quot;, software) are not representative</b>"));
        assert!(html.contains("ms* <span") || html.contains("µs* <span"));
        let html = page(&example()).unwrap();
        assert!(!html.contains("representative"));
    }

    #[test]
    fn a_scene_without_airlight_has_a_page_too() {
        let mut results = example();
        results.measurements.clear();
        results.pictures.methods.clear();
        results.reference.absolute = true;
        let html = page(&results).unwrap();
        assert_eq!(unbalanced(&html), Vec::<String>::new());
        assert!(html.contains("Nothing was measured"));
    }
}
