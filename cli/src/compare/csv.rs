//! `results.csv`: one line per method, quality and backend.

use std::fmt::Write;

use super::results::Results;

pub(crate) const HEADER: &str = "scene,light,visibility,airlight,backend,quality,error_rmse,error_max,error_rel_p99,seconds_build,seconds_frame,bytes";

/// The measurements as comma-separated values (RFC 4180, but with plain line
/// feeds). Times are medians in seconds; errors are as in [`Results`].
pub(crate) fn write(results: &Results) -> String {
    let mut out = format!("{HEADER}\n");
    for m in &results.measurements {
        let texts = [
            results.scene.as_str(),
            &results.light,
            m.method.visibility.name(),
            &m.method.airlight_name(),
            &m.backend,
        ];
        for text in texts {
            out.push_str(&quoted(text));
            out.push(',');
        }
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{},{:e},{:e},{:e},{:e},{:e},{}",
            m.quality,
            m.error.rmse,
            m.error.max,
            m.error.rel_p99,
            m.seconds_build,
            m.frame.median,
            m.bytes
        );
    }
    out
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    #[test]
    fn every_line_has_every_column() {
        let results = example();
        let text = write(&results);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(HEADER));
        let columns = HEADER.split(',').count();
        for line in lines {
            let rest = line.strip_prefix("\"a <test>, \"\"quoted\"\"\",").unwrap();
            assert_eq!(rest.split(',').count(), columns - 1, "{line}");
            for number in rest.split(',').skip(4) {
                assert!(number.parse::<f64>().unwrap().is_finite());
            }
        }
        assert_eq!(text.lines().count(), 1 + results.measurements.len());
    }

    #[test]
    fn a_backend_whose_name_has_commas_is_one_column() {
        let text = write(&example_with_software());
        let last = text.lines().last().unwrap();
        assert!(
            last.contains(",\"gpu (a, \"\"b\"\", software)\","),
            "{last}"
        );
    }
}
