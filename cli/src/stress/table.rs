//! The findings, method by method.

use serde_json::{Value, json};

use super::check::Finding;
use crate::format::count;

/// A method on a backend over all cases.
struct Row<'a> {
    method: &'a str,
    backend: &'a str,
    findings: Vec<&'a Finding>,
}

impl<'a> Row<'a> {
    /// The picture that is off the most.
    fn worst(&self) -> Option<&'a Finding> {
        let pictures = self.findings.iter().filter(|f| f.outcome.refused.is_none());
        let worst = pictures.max_by(|a, b| a.outcome.error.total_cmp(&b.outcome.error));
        worst.copied()
    }

    /// The median error.
    fn median(&self) -> f64 {
        let pictures = self.findings.iter().filter(|f| f.outcome.refused.is_none());
        let mut errors: Vec<f64> = pictures.map(|f| f.outcome.error).collect();
        errors.sort_by(f64::total_cmp);
        errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// A row for each method on each backend, in the order in which they were met.
fn rows(findings: &[Finding]) -> Vec<Row<'_>> {
    let mut rows: Vec<Row<'_>> = Vec::new();
    for finding in findings {
        let (method, backend) = (finding.method.as_str(), finding.backend.as_str());
        match (rows.iter_mut()).find(|row| (row.method, row.backend) == (method, backend)) {
            Some(row) => row.findings.push(finding),
            None => rows.push(Row {
                method,
                backend,
                findings: vec![finding],
            }),
        }
    }
    rows
}

pub(super) fn text(findings: &[Finding], cases: usize) -> String {
    let rows = rows(findings);
    let width = rows
        .iter()
        .map(|row| row.method.len())
        .max()
        .unwrap_or(0)
        .max(6);
    let mut text = format!(
        "{}. Errors are RMSE over the mean of the reference.\n\n{:width$}  {:8} {:>5} {:>8} {:>8}  worst case\n",
        count(cases, "hard case"),
        "method",
        "backend",
        "cases",
        "median",
        "worst",
    );
    for row in &rows {
        let (error, case) = row
            .worst()
            .map_or((f64::NAN, "none: all were refused"), |f| {
                (f.outcome.error, f.case)
            });
        text += &format!(
            "{:width$}  {:8} {:>5} {:>8.1e} {error:>8.1e}  {case}\n",
            row.method,
            row.backend.split(' ').next().unwrap_or_default(),
            row.findings.len(),
            row.median(),
        );
    }
    let mut refused: Vec<(String, usize)> = Vec::new();
    for finding in findings {
        if let Some(why) = &finding.outcome.refused {
            let line = format!("{}: {why}", finding.method);
            match refused.iter_mut().find(|(known, _)| *known == line) {
                Some((_, times)) => *times += 1,
                None => refused.push((line, 1)),
            }
        }
    }
    if !refused.is_empty() {
        text += "\nRefused, with the reason:\n";
        for (line, times) in refused {
            text += &format!("  {line} ({})\n", count(times, "case"));
        }
    }
    let violations: Vec<&Finding> = findings.iter().filter(|f| f.is_violation()).collect();
    text += &format!("\n{}\n", count(violations.len(), "violation"));
    for finding in violations {
        text += &format!(
            "  {}: {} at {} on {}: {}\n",
            finding.case,
            finding.method,
            finding.quality,
            finding.backend,
            finding.outcome.violations.join("; "),
        );
    }
    text
}

pub(super) fn json(findings: &[Finding], cases: usize) -> Value {
    let finding = |finding: &Finding| {
        let error = Some(finding.outcome.error).filter(|error| error.is_finite());
        json!({
            "case": finding.case,
            "method": finding.method,
            "backend": finding.backend,
            "quality": finding.quality,
            "error": error.filter(|_| finding.outcome.refused.is_none()),
            "refused": finding.outcome.refused,
            "violations": finding.outcome.violations,
        })
    };
    json!({
        "cases": cases,
        "violations": findings.iter().filter(|f| f.is_violation()).count(),
        "findings": findings.iter().map(finding).collect::<Vec<_>>(),
    })
}
