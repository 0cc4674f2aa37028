//! What of a comparison is worth its time.

use lighting::methods::Role;
use lighting::prediction::Prediction;

use super::foresight::{Foresight, SECONDS, foreseen};
use crate::compare::prepare::Prepared;
use crate::compare::results::LeftOut;
use crate::failure::Failure;

/// How many times better another setting has to be in both time and error: what is foreseen
/// may be off by as much.
const MUCH: f64 = 2.0;

/// Leaves out the candidates that others are expected to beat by far in both time and error,
/// on every backend. The baseline, what has no shadows, and what cannot be foreseen stay.
pub(crate) fn keep_worthwhile(prepared: &mut Prepared) -> Result<(), Failure> {
    let profile = super::profile::read(None)?;
    let Some(foresight) = Foresight::new(prepared, &profile, SECONDS) else {
        return Ok(());
    };
    let number = prepared.selection.candidates.len();
    let mut beaten_by: Vec<Option<String>> = vec![None; number];
    let mut is_needed = vec![false; number];
    let place = |candidate: &_| {
        let all = &prepared.selection.candidates;
        all.iter().position(|other| std::ptr::eq(other, candidate))
    };
    for device in &prepared.backends.present {
        let candidates = foreseen(prepared, device);
        let forecast = foresight.of(device, &candidates)?;
        for row in &forecast.rows {
            let Some(index) = place(candidates[row.setting]) else {
                continue;
            };
            match forecast.rows.iter().find(|other| is_beaten(row, other)) {
                Some(other) => beaten_by[index] = Some(other.to_string()),
                None => is_needed[index] = true,
            }
        }
    }
    let selection = &mut prepared.selection;
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
