//! Everything that was left out, by reason.

use maud::{Markup, html};

use crate::compare::results::LeftOut;

/// One list entry per reason, in the order of their first mention; of long ones the
/// items are folded.
pub(super) fn list(all: &[LeftOut]) -> Markup {
    html! {
        @if all.is_empty() {
            p { "Nothing was left out." }
        } @else {
            dl.reasons {
                @for (why, what) in by_reason(all) {
                    dt { (capital(why)) }
                    @if what.len() > FOLDED {
                        dd {
                            details {
                                summary { (what.len()) " items" }
                                ul { @for item in what { li { (item) } } }
                            }
                        }
                    } @else {
                        @for item in what {
                            dd { (item) }
                        }
                    }
                }
            }
        }
    }
}

/// More items than this are folded.
const FOLDED: usize = 6;

/// Every reason with everything that was left out for it.
fn by_reason(all: &[LeftOut]) -> Vec<(&str, Vec<&str>)> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for LeftOut { what, why } in all {
        match groups.iter_mut().find(|(known, _)| known == why) {
            Some((_, items)) => items.push(what),
            None => groups.push((why, vec![what])),
        }
    }
    groups
}

/// The text with a capital letter in front.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(what: &str, why: &str) -> LeftOut {
        LeftOut {
            what: what.into(),
            why: why.into(),
        }
    }

    #[test]
    fn what_has_one_reason_stands_together() {
        let all = [
            item("a", "no <time>"),
            item("b", "no shader"),
            item("c", "no <time>"),
        ];
        let groups = by_reason(&all);
        assert_eq!(
            groups,
            [("no <time>", vec!["a", "c"]), ("no shader", vec!["b"])]
        );
        let html = list(&all).into_string();
        assert_eq!(html.matches("No &lt;time&gt;").count(), 1, "{html}");
        assert_eq!(html.matches("<dd>").count(), 3);
    }

    #[test]
    fn many_items_of_one_reason_are_folded_and_none_is_lost() {
        let all: Vec<LeftOut> = (0..40)
            .map(|i| item(&format!("<{i}>"), "no time"))
            .collect();
        let html = list(&all).into_string();
        assert!(html.contains("<summary>40 items</summary>"));
        assert_eq!(html.matches("<li>&lt;").count(), 40);
        assert!(list(&[]).into_string().contains("Nothing was left out"));
        assert_eq!(capital(""), "");
    }
}
