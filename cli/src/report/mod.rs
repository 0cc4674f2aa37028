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
mod engines;
mod front;
mod how;
mod labels;
mod left_out;
mod names;
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

use crate::compare::results::Results;
use crate::failure::Failure;

/// The mark that tells our reports from other folders.
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
                header {
                    h1 { "Light in fog: " (results.scene) }
                    p.standfirst { (summary::standfirst(results)) }
                    (summary::section(results))
                }
                (plots::first(results))
                (facts(results))
                (pictures)
                (tables::section(results))
                (engines::section(results))
                (more(results))
                (passes(results))
                (how::section(results))
                script { (PreEscaped(include_str!("viewer.js"))) }
            }
        }
    };
    Ok(page.into_string())
}

/// The facts on which the figures depend.
fn facts(results: &Results) -> Markup {
    let noun = match results.backends[..] {
        [_] => "backend",
        _ => "backends",
    };
    let run = &results.run;
    html! {
        p.facts {
            (results.scene) ": " (results.lights) ", " (results.triangles) " triangles, " (results.size)
            " pixels, " (results.medium) ". Measured on " (results.machine) "; " (noun) ": "
            (results.backends.join(", ")) ". crepuscular " (run.version) ", " (run.date) ": "
            code { (run.command) }
        }
    }
}

/// The parts that most readers can do without, folded: further plots, a software GPU, studies.
fn more(results: &Results) -> Markup {
    let others = plots::others(results);
    let software = tables::on_software(results);
    let film = results.film.iter().map(|film| &film.study);
    let studies = film.chain(&results.studies).map(section::study);
    let studies: Vec<Markup> = studies.collect();
    let is_empty = |part: &Markup| part.0.is_empty();
    html! {
        @if ![&others, &software].into_iter().chain(&studies).all(is_empty) {
            section.more {
                h2 { "More plots and studies" }
                (others)
                (software)
                @for study in &studies {
                    (study)
                }
            }
        }
    }
}

fn passes(results: &Results) -> Markup {
    html! {
        h2 { "The scene, and what did not run" }
        dl.numbers {
            @for (what, number) in &results.statistics {
                dt { (what) } dd { (number) }
            }
        }
        @if !results.notes.is_empty() {
            h3 { "Placed, assumed or reduced" }
            ul {
                @for note in &results.notes {
                    li { (note) }
                }
            }
        }
        @if !results.ran.is_empty() {
            details {
                summary { "Passes that ran" }
                ul {
                    @for pass in &results.ran {
                        li { (pass) }
                    }
                }
            }
        }
        h3 { "Left out" }
        (left_out::list(&results.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    /// Opening tags without a closing one, in order.
    pub(super) fn unbalanced(html: &str) -> Vec<String> {
        const VOID: [&str; 5] = ["meta", "img", "br", "input", "!DOCTYPE"];
        let mut open = Vec::new();
        let script = include_str!("viewer.js");
        for tag in html.replace(script, "").split('<').skip(1) {
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
        let script = include_str!("viewer.js");
        assert!(!script.contains("</") && !script.contains("<!--"));
        for absent in [
            "http:", "https:", "<script ", "src=\"/", "NaN", "inf ", "url(", "@import",
        ] {
            assert!(!html.contains(absent), "{absent}");
        }
        assert_eq!(html.matches("<script>").count(), 1);
        assert!(html[..1000].contains(MARK), "found again when replaced");
        assert!(html.contains("a &lt;test&gt;"), "names are escaped");
        assert!(html.contains("It never meets the view"));
        for fact in ["1.2.3", "2026-03-14 15:09 UTC", "compare '&lt;scene&gt;'"] {
            assert!(html.contains(fact), "{fact}");
        }
    }

    #[test]
    fn times_of_a_software_adapter_are_marked_as_such() {
        let html = page(&example_with_software()).unwrap();
        assert_eq!(unbalanced(&html), Vec::<String>::new());
        assert!(html.contains("(a, &quot;b&quot;, software) are not representative</b>"));
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
