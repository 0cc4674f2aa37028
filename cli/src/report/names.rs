//! Short names, for where there is little room.

/// Phrases of methods' titles and their short forms in the report. Longer phrases come before
/// those that they contain.
const SHORT: [(&str, &str); 15] = [
    ("map refined along", "finer maps"),
    (
        "exponential variance shadow maps",
        "exponential variance maps",
    ),
    ("area lights by many shadow volumes", "many shadow volumes"),
    ("precomputed voxelized shadows", "precomputed shadows"),
    ("voxelized shadow volumes", "voxelized shadows"),
    ("adaptive volumetric shadow map", "adaptive shadow map"),
    ("equi-angular sampling, ", "equi-angular, "),
    ("quadrature to a tolerance", "to a tolerance"),
    ("closed form in double precision", "double precision"),
    ("published airlight table", "published table"),
    ("airlight table", "table"),
    ("lit runs merged", "merged"),
    ("merged, table", "table"),
    ("a quarter of the pixels", "quarter"),
    ("with jitter and history", "with history"),
];

/// The title of a method in fewer letters; those of one's own methods as they are.
pub(super) fn short_title(title: &str) -> String {
    shortened(title, &SHORT)
}

fn shortened(title: &str, phrases: &[(&str, &str)]) -> String {
    let shorter = |title: String, (long, short): &(&str, &str)| title.replace(long, short);
    phrases.iter().fold(title.to_owned(), shorter)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use lighting::methods::Registry;

    use super::*;
    use crate::compare::shown;

    fn titles() -> impl Iterator<Item = String> {
        let all = shown::all(&Registry::standard());
        all.into_iter().map(|shown| shown.title)
    }

    #[test]
    fn short_names_fit_a_column_and_tell_methods_apart() {
        let mut seen = HashSet::new();
        for title in titles() {
            let short = short_title(&title);
            assert!(short.chars().count() <= 40, "{short}");
            assert!(seen.insert(short.clone()), "{short} names two methods");
        }
        assert_eq!(
            short_title("a method of one's own"),
            "a method of one's own"
        );
    }

    #[test]
    fn every_phrase_is_one_that_methods_have() {
        for (index, (long, _)) in SHORT.iter().enumerate() {
            let before = |title: &String| shortened(title, &SHORT[..index]);
            let is_used = titles().any(|title| before(&title).contains(long));
            assert!(is_used, "{long}");
        }
    }
}
