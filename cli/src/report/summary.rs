//! The answer in a few sentences.

use std::fmt::Write;

use crate::compare::results::{Measurement, Results, fastest_within};
use crate::format::{error, escape, seconds, significant};
use crate::methods::{Airlight, METHODS, Method, Visibility};

/// Errors at which methods are compared.
pub(super) const TARGETS: [f64; 7] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001];

pub(super) fn write(html: &mut String, results: &Results) {
    html.push_str("<div class=\"summary\">\n");
    for sentence in sentences(results, escape) {
        let _ = writeln!(html, "<p>{sentence}</p>");
    }
    html.push_str("</div>\n");
}

/// The sentences of the summary, as HTML without paragraphs. `name` writes a
/// backend's name.
fn sentences(results: &Results, name: fn(&str) -> String) -> Vec<String> {
    let several = results.backends.len() > 1;
    let absolute = results.reference.absolute;
    let shown = |m: &Measurement| format!("<b>{}</b>", setting(m));
    if results.measurements.is_empty() {
        return vec!["Nothing was measured; the report lists what was left out and why.".into()];
    }
    let place = |backend: &str| {
        if several {
            format!(" on {}", name(backend))
        } else {
            String::new()
        }
    };
    let mut sentences = Vec::new();
    for backend in &results.backends {
        let own = || results.representative().filter(|m| m.backend == *backend);
        let mut choices: Vec<Choice<'_>> = Vec::new();
        for target in decisive_targets(results, backend) {
            let Some(best) = fastest_within(own(), None, target) else {
                continue;
            };
            let march = fastest_within(own(), Some(baseline()), target);
            let written = error(target, absolute);
            match choices.last_mut() {
                Some(last) if last.is(best, march) => last.targets.push(written),
                _ => choices.push(Choice {
                    targets: vec![written],
                    best,
                    march,
                }),
            }
        }
        for Choice {
            targets,
            best,
            march,
        } in choices
        {
            let mut text = format!(
                "For an error of {}, {} is the fastest{}: {} a frame",
                targets.join(" or "),
                shown(best),
                place(backend),
                seconds(best.frame.median)
            );
            if !is_baseline(best.method) {
                match march {
                    Some(march) => {
                        let ratio = march.frame.median / best.frame.median;
                        let _ = write!(
                            text,
                            ", against {} by plain {} with {} steps ({} times as long)",
                            seconds(march.frame.median),
                            march.method.title,
                            march.quality,
                            significant(ratio)
                        );
                    }
                    None if own().any(|m| is_baseline(m.method)) => {
                        text.push_str("; plain ray marching does not get there");
                    }
                    None => {}
                }
            }
            text.push('.');
            sentences.push(text);
        }
    }
    let finite = |m: &&Measurement| m.error.rmse.is_finite();
    let all = &results.measurements;
    let odd = all.len() - all.iter().filter(finite).count();
    if odd > 0 {
        sentences.push(format!(
            "{odd} of {} measurements have no finite error.",
            all.len()
        ));
    }
    let errors = |a: &&Measurement, b: &&Measurement| a.error.rmse.total_cmp(&b.error.rmse);
    if let Some(best) = results.representative().filter(finite).min_by(errors) {
        sentences.push(format!(
            "The least error is {}, by {}{} in {} a frame.",
            error(best.error.rmse, absolute),
            shown(best),
            place(&best.backend),
            seconds(best.frame.median)
        ));
    }
    let shadowless = all
        .iter()
        .filter(finite)
        .find(|m| m.method.visibility == Visibility::None);
    if let Some(m) = shadowless {
        sentences.push(format!(
            "Leaving the shadows out altogether would be an error of {}.",
            error(m.error.rmse, absolute)
        ));
    }
    if let Some(backend) = results.software() {
        sentences.push(format!(
            "Times of {} are not representative: the processor plays the GPU. They decide nothing above.",
            name(backend)
        ));
    }
    sentences
}

/// What is the fastest within one or more errors, and what plain ray marching
/// does there.
struct Choice<'a> {
    targets: Vec<String>,
    best: &'a Measurement,
    march: Option<&'a Measurement>,
}

impl Choice<'_> {
    fn is(&self, best: &Measurement, march: Option<&Measurement>) -> bool {
        let address = |m: &Measurement| std::ptr::from_ref(m);
        std::ptr::eq(self.best, best) && self.march.map(address) == march.map(address)
    }
}

/// The summary as plain text for the terminal.
pub(crate) fn plain(results: &Results) -> Vec<String> {
    sentences(results, str::to_owned)
        .iter()
        .map(|sentence| sentence.replace("<b>", "").replace("</b>", ""))
        .collect()
}

/// A measurement's method and quality in words.
pub(super) fn setting(m: &Measurement) -> String {
    format!(
        "{} with {} {}",
        m.method.title,
        m.quality,
        m.method.quality_name()
    )
}

/// At most two errors at which there is a choice on a backend: the coarsest that at least
/// two methods with shadows reach, and the finest such.
fn decisive_targets(results: &Results, backend: &str) -> Vec<f64> {
    if results.reference.absolute {
        return Vec::new();
    }
    let reached = |target: f64| {
        METHODS
            .iter()
            .filter(|method| method.visibility != Visibility::None)
            .filter(|method| {
                let own = results.representative().filter(|m| m.backend == backend);
                fastest_within(own, Some(method), target).is_some()
            })
            .count()
            >= 2
    };
    let all: Vec<f64> = TARGETS[2..]
        .iter()
        .copied()
        .filter(|t| reached(*t))
        .collect();
    match all[..] {
        [] => TARGETS[..2]
            .iter()
            .rev()
            .copied()
            .find(|t| reached(*t))
            .into_iter()
            .collect(),
        [only] => vec![only],
        [first, .., last] => vec![first, last],
    }
}

fn baseline() -> &'static Method {
    METHODS
        .iter()
        .find(|method| is_baseline(method))
        .expect("the registry has plain ray marching")
}

fn is_baseline(method: &Method) -> bool {
    method.visibility == Visibility::March && method.airlight == Airlight::Midpoint
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    #[test]
    fn the_fastest_within_an_error_is_named_with_its_price() {
        let text = plain(&example()).join("\n");
        assert!(text.contains("For an error of 10 %"), "{text}");
        assert!(text.contains("against"), "{text}");
        assert!(text.contains("The least error is"), "{text}");
        assert!(text.contains("Leaving the shadows out"), "{text}");
        assert!(!text.contains("representative"), "{text}");
    }

    #[test]
    fn a_software_adapter_wins_nothing_and_is_named() {
        let results = example_with_software();
        let text = plain(&results);
        let (last, rest) = text.split_last().unwrap();
        assert!(last.contains("Times of gpu (a, \"b\", software) are not representative"));
        assert!(!rest.join("\n").contains("gpu"), "{text:?}");
        let text = rest.join("\n");
        assert!(text.contains("is the fastest on cpu"), "{text}");
    }

    #[test]
    fn the_same_answer_for_two_errors_is_given_once() {
        let mut results = example();
        for m in &mut results.measurements {
            m.error.rmse = 1e-4;
        }
        let text = plain(&results).join("\n");
        assert!(text.contains("For an error of 10 % or 0.1 %"), "{text}");
        assert_eq!(text.matches("is the fastest").count(), 1, "{text}");
    }

    #[test]
    fn what_is_not_a_number_is_not_an_error() {
        let mut results = example();
        results.measurements[0].error.rmse = -f64::NAN;
        results.measurements[1].error.rmse = f64::INFINITY;
        let some = plain(&results).join("\n");
        assert!(some.contains("2 of"), "{some}");
        assert!(some.contains("The least error is"), "{some}");
        for m in &mut results.measurements {
            m.error.rmse = f64::NAN;
        }
        let none = plain(&results).join("\n");
        for text in [some, none] {
            assert!(text.contains("no finite error"), "{text}");
            assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
        }
    }
}
