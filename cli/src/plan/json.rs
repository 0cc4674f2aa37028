//! A plan as JSON.

use lighting::prediction::{Forecast, Prediction, Skipped, Target, Unmet};
use serde_json::{Value, json};

use super::analysis::{Analysis, LEAST_ERROR, QUIET};
use crate::compare::prepare::Prepared;
use crate::compare::results::LeftOut;

/// The choice, or the setting that comes nearest.
pub(super) type Choice = Option<(Target, Result<Prediction, Box<Unmet>>)>;

/// The facts that are known before anything is foreseen.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) passes: &'a [String],
    pub(super) left_out: &'a [&'a LeftOut],
}

/// One object. Measurements have the names that they have in `compare --json`; unknown values are
/// null.
pub(super) fn of(
    known: Known<'_>,
    forecast: &Forecast,
    choice: &Choice,
    analysis: Option<&Analysis>,
) -> Value {
    let Known {
        prepared,
        passes,
        left_out,
    } = known;
    let (rows, skipped) = (forecast.rows.iter(), forecast.skipped.iter());
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": prepared.input.scene.name,
        "width": prepared.size.width,
        "height": prepared.size.height,
        "passes": passes,
        "left_out": left_out.iter().map(|LeftOut { what, why }| json!({
            "what": what,
            "why": why,
        })).collect::<Vec<_>>(),
        "rows": rows.map(|row| of_row(row, analysis)).collect::<Vec<_>>(),
        "skipped": skipped.map(|Skipped { what, why, .. }| json!({
            "what": what,
            "why": why,
        })).collect::<Vec<_>>(),
        "choice": choice.as_ref().map(|(target, choice)| of_choice(*target, choice)),
        "analysis": analysis.map(|analysis| json!({
            "copy_spread": analysis.copy_spread,
            "quiet": analysis.copy_spread <= QUIET,
            "least_error": LEAST_ERROR,
        })),
    })
}

fn of_row(row: &Prediction, analysis: Option<&Analysis>) -> Value {
    let pair = analysis.and_then(|analysis| {
        let is_it = |expected: &Prediction| {
            (expected.setting, &expected.backend) == (row.setting, &row.backend)
        };
        analysis.pairs.iter().find(|pair| is_it(&pair.expected))
    });
    json!({
        "method": row.method,
        "backend": row.backend,
        "quality": row.quality,
        "quality_unit": row.unit,
        "seconds_start": row.start,
        "seconds_build": row.once,
        "seconds_frame": row.frame,
        "bytes": row.bytes,
        "error_rmse": row.rmse,
        "error_rmse_spread": row.rmse_spread,
        "known": row.known.name(),
        "actual": pair.map(|pair| json!({
            "seconds_build": pair.actual.seconds_build,
            "seconds_frame_min": pair.actual.frame.low,
            "bytes": pair.actual.bytes,
            "error_rmse": pair.actual.error.rmse,
            "q_time": pair.time(),
            "q_error": pair.error(),
        })),
    })
}

fn of_choice(target: Target, choice: &Result<Prediction, Box<Unmet>>) -> Value {
    let row = match choice {
        Ok(row) => Some(row),
        Err(unmet) => unmet.nearest.as_ref(),
    };
    let (error, time) = match target {
        Target::Error(error) => (Some(error), None),
        Target::Time(time) => (None, Some(time)),
    };
    json!({
        "error": error,
        "time": time,
        "met": choice.is_ok(),
        "method": row.map(|row| &row.method),
        "backend": row.map(|row| &row.backend),
        "quality": row.map(|row| row.quality),
    })
}
