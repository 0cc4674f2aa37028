//! The answer in a few sentences.

use std::collections::BTreeSet;

use maud::{Markup, html};

use crate::compare::results::{Measurement, Results, fastest_within};
use crate::format::{count, error, seconds, significant};

/// Errors at which methods are compared.
pub(super) const TARGETS: [f64; 7] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001];

/// A sentence about the scene, the picture and the methods that were compared.
pub(super) fn standfirst(results: &Results) -> String {
    let methods: BTreeSet<usize> = results.measurements.iter().map(|m| m.method).collect();
    let settings = match results.representative().count() {
        0 => results.measurements.len(),
        representative => representative,
    };
    format!(
        "The light that fog scatters towards the camera, with its shadows, computed by {} at {}. Each picture is compared with a converged reference: how large is its error, and how long does a frame take?",
        count(methods.len(), "method"),
        count(settings, "setting")
    )
}

/// The recommendation.
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

/// The recommendation as plain text for the terminal.
pub(crate) fn plain(results: &Results) -> Vec<String> {
    let plain = |Sentence(spans): Sentence| {
        let texts = spans.into_iter().map(|span| match span {
            Span::Plain(text) | Span::Strong(text) => text,
        });
        texts.collect()
    };
    let mut all: Vec<String> = sentences(results).into_iter().map(plain).collect();
    all.extend(results.software().map(|backend| {
        format!(
            "Times of {backend} are not representative: the CPU emulates the GPU. They do not count above."
        )
    }));
    all
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
                .strong(results.setting(best))
                .then(rest),
        );
    }
    let shadowless = all
        .iter()
        .filter(finite)
        .find(|m| !results.methods[m.method].has_shadows);
    if let Some(m) = shadowless {
        sentences.push(Sentence::new(format!(
            "Without shadows the error would be {}.",
            error(m.error.rmse, absolute)
        )));
    }
    sentences
}

/// Where something was measured, if several backends compete.
fn place(results: &Results, m: &Measurement) -> String {
    if results.several_compete() {
        format!(" on {}", m.backend)
    } else {
        String::new()
    }
}

/// The fastest methods of a backend at the errors that tell methods apart.
fn choices<'a>(results: &'a Results, backend: &str) -> Vec<Choice<'a>> {
    let own = || results.representative().filter(|m| m.backend == backend);
    let mut choices: Vec<Choice<'a>> = Vec::new();
    for target in decisive_targets(results, backend) {
        let Some(best) = fastest_within(own(), None, target) else {
            continue;
        };
        let fastest = |method: usize| fastest_within(own(), Some(method), target);
        let of_methods = (0..results.methods.len()).filter_map(fastest);
        let mut winners: Vec<&Measurement> = of_methods
            .filter(|m| m.frame.overlaps(&best.frame))
            .collect();
        winners.sort_by(|a, b| a.frame.median.total_cmp(&b.frame.median));
        let baseline = results.methods.iter().position(|m| m.is_baseline);
        let march = baseline.and_then(fastest);
        let written = error(target, results.reference.absolute);
        match choices.last_mut() {
            Some(last) if last.is(&winners, march) => last.targets.push(written),
            _ => choices.push(Choice {
                targets: vec![written],
                winners,
                march,
            }),
        }
    }
    choices
}

/// The fastest settings within one or more errors, beside plain ray marching.
struct Choice<'a> {
    targets: Vec<String>,
    /// The fastest setting, and those of other methods that the spreads of their
    /// times do not tell from it; at least one.
    winners: Vec<&'a Measurement>,
    march: Option<&'a Measurement>,
}

/// The largest number of equally fast settings that are named.
const NAMED: usize = 3;

impl Choice<'_> {
    fn is(&self, winners: &[&Measurement], march: Option<&Measurement>) -> bool {
        let address = |m: &Measurement| std::ptr::from_ref(m);
        let same = |(a, b): (&&Measurement, &&Measurement)| std::ptr::eq(*a, *b);
        self.winners.len() == winners.len()
            && self.winners.iter().zip(winners).all(same)
            && self.march.map(address) == march.map(address)
    }

    fn say(&self, results: &Results) -> Sentence {
        let best = self.winners[0];
        let at = place(results, best);
        let mut sentence = Sentence::new(format!(
            "For an error of at most {}{at}, ",
            self.targets.join(" or ")
        ));
        let time = |m: &Measurement| seconds(m.frame.median);
        if let [only] = self.winners[..] {
            let rest = format!(" is the fastest: {} a frame", time(only));
            sentence = sentence.strong(results.setting(only)).then(rest);
        } else {
            let named = &self.winners[..self.winners.len().min(NAMED)];
            let others = self.winners.len() - named.len();
            for (index, winner) in named.iter().enumerate() {
                let joint = match (index, index + 1 == named.len() && others == 0) {
                    (0, _) => "",
                    (_, true) => " and ",
                    (_, false) => ", ",
                };
                sentence = sentence
                    .then(joint)
                    .strong(results.setting(winner))
                    .then(format!(" ({})", time(winner)));
            }
            if others > 0 {
                sentence = sentence.then(format!(" and {others} more"));
            }
            sentence = sentence.then(" are equally fast: their times overlap");
        }
        sentence.then(self.against_marching(results)).then(".")
    }

    /// The time of plain ray marching for the same error, unless it is among the fastest.
    fn against_marching(&self, results: &Results) -> String {
        let best = self.winners[0];
        let is_baseline = |m: &&Measurement| results.methods[m.method].is_baseline;
        if self.winners.iter().any(&is_baseline) {
            return String::new();
        }
        let mut own = results
            .representative()
            .filter(|m| m.backend == best.backend);
        match self.march {
            Some(march) => format!(
                "; {}, takes {}, {} times as long",
                results.setting(march),
                seconds(march.frame.median),
                significant(march.frame.median / best.frame.median)
            ),
            None if own.any(|m| is_baseline(&m)) => {
                "; plain ray marching does not get there".into()
            }
            None => String::new(),
        }
    }
}

/// At most two errors at which there is a choice on a backend: the coarsest that at least
/// two methods with shadows reach, and the finest such; without a choice, the finest
/// that one reaches.
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
    };
    let all: Vec<f64> = TARGETS[2..]
        .iter()
        .copied()
        .filter(|t| reached(*t) >= 2)
        .collect();
    match all[..] {
        [] => {
            let coarse = TARGETS[..2]
                .iter()
                .rev()
                .copied()
                .find(|t| reached(*t) >= 2);
            // If one method alone comes near, the error is as fine as it reaches.
            let alone = || TARGETS.iter().rev().copied().find(|t| reached(*t) >= 1);
            coarse.or_else(alone).into_iter().collect()
        }
        [only] => vec![only],
        [first, .., last] => vec![first, last],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::Times;
    use crate::compare::results::tests::{example, example_with_software};

    #[test]
    fn the_fastest_within_an_error_is_named_with_its_price() {
        let mut results = example();
        for m in &mut results.measurements {
            // Nothing is as fast as exact visibility.
            if results.methods[m.method].visibility == "exact" {
                m.frame = Times::of(&[0.1 * m.frame.low, 0.1 * m.frame.high]);
            }
        }
        let text = plain(&results).join("\n");
        assert!(text.contains("For an error of at most 10 %, "), "{text}");
        assert!(text.contains(" is the fastest: "), "{text}");
        assert!(text.contains("; ray marching, 8 steps, takes "), "{text}");
        assert!(text.contains("The least error is"), "{text}");
        assert!(
            text.contains("Without shadows the error would be"),
            "{text}"
        );
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
        assert!(!text.contains(" on cpu"), "nothing else competes: {text}");
    }

    #[test]
    fn a_method_that_is_alone_is_named_too() {
        let mut results = example();
        let alone = results.methods.iter().position(|m| m.visibility == "exact");
        results.measurements.retain(|m| Some(m.method) == alone);
        let text = plain(&results).join("\n");
        assert!(
            text.contains("For an error of at most 1 %, exact visibility, 8 "),
            "{text}"
        );
    }

    #[test]
    fn backends_that_compete_are_named() {
        let mut results = example_with_software();
        for m in &mut results.measurements {
            m.representative = true;
        }
        let text = plain(&results).join("\n");
        assert!(text.contains(" % on cpu, "), "{text}");
        assert!(text.contains(" on gpu (a, \"b\", software), "), "{text}");
    }

    #[test]
    fn the_same_answer_for_two_errors_is_given_once() {
        let mut results = example();
        for m in &mut results.measurements {
            m.error.rmse = 1e-4;
        }
        let text = plain(&results).join("\n");
        assert!(
            text.contains("For an error of at most 10 % or 0.1 %"),
            "{text}"
        );
        assert_eq!(text.matches("is the fastest").count(), 1, "{text}");
    }

    #[test]
    fn no_winner_is_named_where_spreads_overlap() {
        let mut results = example();
        for m in &mut results.measurements {
            m.frame = Times::of(&[0.9 * m.frame.median, 3.0 * m.frame.median]);
        }
        let text = plain(&results).join("\n");
        assert!(
            text.contains(" are equally fast: their times overlap"),
            "{text}"
        );
        assert!(!text.contains("is the fastest"), "{text}");
        for m in &mut results.measurements {
            m.frame = Times::of(&[1.0, 2.0]);
            m.error.rmse = 0.05;
        }
        let text = plain(&results).join("\n");
        assert!(text.contains(" and 2 more are equally fast"), "{text}");
        assert!(!text.contains("times as long"), "{text}");
    }

    #[test]
    fn the_first_sentence_counts_what_competes() {
        let text = standfirst(&example_with_software());
        assert!(text.contains("5 methods at 22 settings"), "{text}");
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
