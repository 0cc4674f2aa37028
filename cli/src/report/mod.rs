//! The page that shows a comparison, one HTML file that needs nothing else, and
//! the tables beside it as CSV.
//!
//! [`section`] shows any table, chart or study, [`csv`] writes any table; both
//! know only the plain data of [`crate::compare::study`]. The other modules turn
//! the main results into such data. maud escapes every text on its way into the
//! page.

mod axis;
mod chart;
mod csv;
mod how;
mod numbers;
mod pictures;
mod plots;
mod section;
mod summary;
mod tables;

pub(crate) use csv::csv;
pub(crate) use plots::short_name;
pub(crate) use summary::plain as sentences;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::compare::results::{LeftOut, Results};
use crate::failure::Failure;

/// What tells our reports from other folders.
pub(crate) const MARK: &str = "<meta name=\"generator\" content=\"crepuscular compare\">";

/// The whole page.
pub(crate) fn page(results: &Results) -> Result<String, Failure> {
    let pictures = pictures::section(results)?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                (PreEscaped(MARK))
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Light in fog: " (results.scene) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                (facts(results))
                (summary::section(results))
                (plots::section(results))
                (tables::targets(results))
                (pictures)
                (tables::measurements(results))
                @for study in &results.studies {
                    (section::study(study))
                }
                (passes(results))
                (how::section(results))
            }
        }
    };
    Ok(page.into_string())
}

fn facts(results: &Results) -> Markup {
    let noun = match results.backends[..] {
        [_] => "backend",
        _ => "backends",
    };
    html! {
        h1 { "Error against run time: " (results.scene) }
        p.facts {
            (results.lights) ", " (results.triangles) " triangles, " (results.size) " pixels, "
            (results.medium) ". Measured on " (results.machine) "; " (noun) ": "
            (results.backends.join(", ")) "."
        }
    }
}

fn passes(results: &Results) -> Markup {
    let list = |title: &str, items: &[String]| {
        html! {
            @if !items.is_empty() {
                h3 { (title) }
                ul {
                    @for item in items {
                        li { (item) }
                    }
                }
            }
        }
    };
    html! {
        h2 { "What ran, and what did not" }
        (list("Placed, assumed or reduced", &results.notes))
        (list("Passes", &results.ran))
        @if results.left_out.is_empty() {
            p { "Nothing was left out." }
        } @else {
            h3 { "Left out" }
            ul {
                @for LeftOut { what, why } in &results.left_out {
                    li { b { (what) } ": " (why) }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    /// Opening tags without a closing one, in order.
    pub(super) fn unbalanced(html: &str) -> Vec<String> {
        const VOID: [&str; 4] = ["meta", "img", "br", "!DOCTYPE"];
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
    fn every_slot_has_a_colour() {
        let style = include_str!("style.css");
        for slot in 0..plots::COLOURS {
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
