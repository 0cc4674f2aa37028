//! The answer in a few sentences.

use maud::{Markup, html};

use crate::compare::results::{Measurement, Results, fastest_within};
use crate::format::{error, seconds, significant};

/// Errors at which methods are compared.
pub(super) const TARGETS: [f64; 7] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001];

pub(super) fn section(results: &Results) -> Markup {
    html! {
        .summary {
            @for Sentence(spans) in sentences(results) {
                p {
                    @for span in spans {
                        @match span {
                            Span::Plain(text) => (text),
                            Span::Strong(text) => b { (text) },
                        }
                    }
                }
            }
        }
    }
}

/// The summary as plain text for the terminal.
pub(crate) fn plain(results: &Results) -> Vec<String> {
    let plain = |Sentence(spans): Sentence| {
        let texts = spans.into_iter().map(|span| match span {
            Span::Plain(text) | Span::Strong(text) => text,
        });
        texts.collect()
    };
    sentences(results).into_iter().map(plain).collect()
}

/// A sentence in pieces.
struct Sentence(Vec<Span>);

/// A piece of a sentence.
enum Span {
    Plain(String),
    Strong(String),
}

impl Sentence {
    fn new(text: impl Into<String>) -> Self {
        Self(vec![Span::Plain(text.into())])
    }

    fn strong(mut self, text: String) -> Self {
        self.0.push(Span::Strong(text));
        self
    }

    fn then(mut self, text: impl Into<String>) -> Self {
        self.0.push(Span::Plain(text.into()));
        self
    }
}

fn sentences(results: &Results) -> Vec<Sentence> {
    if results.measurements.is_empty() {
        let nothing = "Nothing was measured; the report lists what was left out and why.";
        return vec![Sentence::new(nothing)];
    }
    let mut sentences = Vec::new();
    for backend in &results.backends {
        sentences.extend(
            choices(results, backend)
                .iter()
                .map(|choice| choice.say(results)),
        );
    }
    let absolute = results.reference.absolute;
    let finite = |m: &&Measurement| m.error.rmse.is_finite();
    let all = &results.measurements;
    let odd = all.len() - all.iter().filter(finite).count();
    if odd > 0 {
        sentences.push(Sentence::new(format!(
            "{odd} of {} measurements have no finite error.",
            all.len()
        )));
    }
    let errors = |a: &&Measurement, b: &&Measurement| a.error.rmse.total_cmp(&b.error.rmse);
    if let Some(best) = results.representative().filter(finite).min_by(errors) {
        let least = format!(
            "The least error is {}, by ",
            error(best.error.rmse, absolute)
        );
        let rest = format!(
            "{} in {} a frame.",
            place(results, best),
            seconds(best.frame.median)
        );
        sentences.push(
            Sentence::new(least)
                .strong(setting(results, best))
                .then(rest),
        );
    }
    let shadowless = all
        .iter()
        .filter(finite)
        .find(|m| !results.methods[m.method].has_shadows);
    if let Some(m) = shadowless {
        sentences.push(Sentence::new(format!(
            "Leaving the shadows out altogether would be an error of {}.",
            error(m.error.rmse, absolute)
        )));
    }
    if let Some(backend) = results.software() {
        sentences.push(Sentence::new(format!(
            "Times of {backend} are not representative: the processor plays the GPU. They decide nothing above."
        )));
    }
    sentences
}

/// Where something was measured, if there are several backends.
fn place(results: &Results, m: &Measurement) -> String {
    if results.backends.len() > 1 {
        format!(" on {}", m.backend)
    } else {
        String::new()
    }
}

/// What a backend's fastest methods are at the errors that tell them apart.
fn choices<'a>(results: &'a Results, backend: &str) -> Vec<Choice<'a>> {
    let own = || results.representative().filter(|m| m.backend == backend);
    let baseline = results.methods.iter().position(|m| m.is_baseline);
    let mut choices: Vec<Choice<'a>> = Vec::new();
    for target in decisive_targets(results, backend) {
        let Some(best) = fastest_within(own(), None, target) else {
            continue;
        };
        let march = baseline.and_then(|march| fastest_within(own(), Some(march), target));
        let written = error(target, results.reference.absolute);
        match choices.last_mut() {
            Some(last) if last.is(best, march) => last.targets.push(written),
            _ => choices.push(Choice {
                targets: vec![written],
                best,
                march,
            }),
        }
    }
    choices
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

    fn say(&self, results: &Results) -> Sentence {
        let best = self.best;
        let mut rest = format!(
            " is the fastest{}: {} a frame",
            place(results, best),
            seconds(best.frame.median)
        );
        if !results.methods[best.method].is_baseline {
            let marches = |m: &Measurement| {
                m.backend == best.backend && results.methods[m.method].is_baseline
            };
            match self.march {
                Some(march) => {
                    let ratio = march.frame.median / best.frame.median;
                    rest += &format!(
                        ", against {} by plain {} with {} steps ({} times as long)",
                        seconds(march.frame.median),
                        results.methods[march.method].title,
                        march.quality,
                        significant(ratio)
                    );
                }
                None if results.representative().any(marches) => {
                    rest += "; plain ray marching does not get there";
                }
                None => {}
            }
        }
        rest.push('.');
        Sentence::new(format!("For an error of {}, ", self.targets.join(" or ")))
            .strong(setting(results, best))
            .then(rest)
    }
}

/// A measurement's method and quality in words.
pub(super) fn setting(results: &Results, m: &Measurement) -> String {
    let method = &results.methods[m.method];
    format!("{} with {} {}", method.title, m.quality, method.quality)
}

/// At most two errors at which there is a choice on a backend: the coarsest that at least
/// two methods with shadows reach, and the finest such.
fn decisive_targets(results: &Results, backend: &str) -> Vec<f64> {
    if results.reference.absolute {
        return Vec::new();
    }
    let reached = |target: f64| {
        let methods = results.methods.iter().enumerate();
        methods
            .filter(|(_, method)| method.has_shadows)
            .filter(|(index, _)| {
                let own = results.representative().filter(|m| m.backend == backend);
                fastest_within(own, Some(*index), target).is_some()
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
