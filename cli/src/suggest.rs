//! Suggestions in place of a name that does not exist.

use lighting::methods::Registry;

use crate::failure::Failure;

/// The most similar of `names`, as a question to add to a message; nothing if
/// none is similar. Upper and lower case are the same.
pub(crate) fn question<S: AsRef<str>>(meant: &str, names: impl IntoIterator<Item = S>) -> String {
    match nearest(meant, names) {
        Some(name) => format!(" (did you mean \"{name}\"?)"),
        None => String::new(),
    }
}

/// The message if `name` is not the name of one method, or of none.
pub(crate) fn unknown_method(methods: &Registry, name: &str) -> Failure {
    let names: Vec<_> = methods.compared().map(|entry| entry.about().name).collect();
    let several = match methods.compared().any(|entry| entry.matches(name)) {
        true => "several methods are",
        false => "no method is",
    };
    Failure::new(format!(
        "{several} called \"{name}\"{}; there are {}",
        question(name, &names),
        names.join(", ")
    ))
}

fn nearest<S: AsRef<str>>(meant: &str, names: impl IntoIterator<Item = S>) -> Option<String> {
    /// Two names are similar above this; the same number that clap has for options.
    const SIMILAR: f64 = 0.7;
    let meant = meant.to_lowercase();
    let mut best = (SIMILAR, None);
    for name in names {
        let similarity = strsim::jaro(&meant, &name.as_ref().to_lowercase());
        if similarity > best.0 {
            best = (similarity, Some(name.as_ref().to_owned()));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_are_understood_and_nonsense_is_not() {
        let names = ["city", "fence", "coil", "march x midpoint"];
        for (meant, name) in [
            ("citty", "city"),
            ("Fenec", "fence"),
            ("march x mitpoint", "march x midpoint"),
        ] {
            let expected = format!(" (did you mean \"{name}\"?)");
            assert_eq!(question(meant, names), expected);
        }
        for meant in ["", "zzz", "photon-mapping"] {
            assert_eq!(question(meant, names), "");
        }
    }
}
