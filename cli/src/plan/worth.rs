//! The candidates of a comparison that are worth their time.

use lighting::methods::Role;
use lighting::prediction::Prediction;

use super::foresight::SECONDS;
use crate::compare::prepare::Prepared;
use crate::compare::results::LeftOut;
use crate::devices::BackendName;
use crate::failure::Failure;

/// How many times better another setting has to be in both time and error: forecasts may be off
/// by as much.
const MUCH: f64 = 2.0;

/// Leaves out the candidates that others are expected to beat by far in both time and error, on
/// every backend. The baseline, methods without shadows, and candidates that cannot be foreseen
/// on one of the backends stay. Backends are those that were `asked` for, or all but a software
/// GPU.
pub(crate) fn keep_worthwhile(
    prepared: &mut Prepared,
    asked: &[BackendName],
) -> Result<(), Failure> {
    let profile = super::profile::read(None)?;
    let (forecasts, failed) = super::forecasts(prepared, asked, &profile, SECONDS, None)?;
    let number = prepared.selection.candidates.len();
    let mut beaten_by: Vec<Option<String>> = vec![None; number];
    let mut is_needed = vec![false; number];
    let place = |candidate: &_| {
        let all = &prepared.selection.candidates;
        all.iter().position(|other| std::ptr::eq(other, candidate))
    };
    for (_, candidates, forecast) in &forecasts {
        for (setting, candidate) in candidates.iter().enumerate() {
            let Some(index) = place(*candidate) else {
                continue;
            };
            let mut rows = forecast.rows.iter();
            let row = rows.find(|row| row.setting == setting);
            let other = row.and_then(|row| forecast.rows.iter().find(|o| is_beaten(row, o)));
            match other {
                Some(other) => beaten_by[index] = Some(other.to_string()),
                None => is_needed[index] = true,
            }
        }
    }
    let selection = &mut prepared.selection;
    selection.left_out.extend(failed);
    let mut kept = Vec::new();
    for (index, candidate) in std::mem::take(&mut selection.candidates)
        .into_iter()
        .enumerate()
    {
        let role = candidate.entry.about().role;
        let stays = is_needed[index] || matches!(role, Role::Baseline | Role::Unshadowed);
        match beaten_by[index].take().filter(|_| !stays) {
            Some(other) => selection.left_out.push(LeftOut {
                what: candidate.name(),
                why: format!("expected to be beaten by far (--auto): {other}"),
            }),
            None => kept.push(candidate),
        }
    }
    selection.candidates = kept;
    Ok(())
}

fn is_beaten(row: &Prediction, other: &Prediction) -> bool {
    MUCH * other.frame < row.frame && MUCH * other.rmse < row.rmse
}

#[cfg(test)]
mod tests {
    use lighting::prediction::Known;

    use super::*;

    #[test]
    fn beaten_by_far_is_what_is_twice_as_slow_and_twice_as_far_off() {
        let row = |frame: f64, rmse: f64| Prediction {
            setting: 0,
            method: "any".into(),
            backend: "cpu".into(),
            quality: 1,
            unit: "steps",
            start: 0.0,
            once: 0.0,
            frame,
            bytes: 0,
            rmse,
            rmse_spread: 0.0,
            known: Known::Probed,
            counted: [1.0; 2],
        };
        let this = row(1.0, 0.1);
        assert!(is_beaten(&this, &row(0.4, 0.04)));
        for other in [row(0.4, 0.06), row(0.6, 0.04), row(2.0, 0.0), this.clone()] {
            assert!(!is_beaten(&this, &other), "{other}");
        }
    }
}
