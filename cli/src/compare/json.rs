//! The summary of a comparison as JSON.

use std::path::Path;

use serde_json::{Value, json};

use super::files;
use super::results::{Film, LeftOut, Measurement, Results, Slope, slopes};
use super::study::{self, Cell, Row};
use crate::report;

/// What `--json` prints: one object, with a line feed at its end. Errors, times and
/// names are those of `results.csv`; what is not known, or not finite, is null.
pub(crate) fn summary(results: &Results, place: &Path) -> String {
    let pictured = |index: usize| {
        let mut all = results.pictures.methods.iter();
        all.any(|shown| shown.measurement == index)
            .then(|| files::of_measurement(results, index))
    };
    let measurements = results.measurements.iter().enumerate();
    let statistics = results.statistics.iter();
    let summary = json!({
        "version": results.run.version,
        "command": results.run.command,
        "date": results.run.date,
        "machine": results.machine,
        "backends": results.backends,
        "report": place.join(files::PAGE).display().to_string(),
        "seconds": results.seconds_total,
        "scene": {
            "name": results.scene,
            "lights": results.lights,
            "medium": results.medium,
            "triangles": results.triangles,
            "statistics": statistics
                .map(|(what, value)| ((*what).to_owned(), Value::from(value.as_str())))
                .collect::<serde_json::Map<_, _>>(),
        },
        "width": results.size.width,
        "height": results.size.height,
        "reference": {
            "mean": results.reference.mean,
            "bound": results.reference.bound,
            "tolerance": results.reference.tolerance,
            "absolute": results.reference.absolute,
            "seconds": results.reference.seconds,
        },
        "summary": report::sentences(results),
        "notes": results.notes,
        "shadow_map_floors": results.floors.iter().map(|floor| json!({
            "map": floor.map,
            "error_rmse": floor.rmse,
        })).collect::<Vec<_>>(),
        "measurements": measurements
            .map(|(index, m)| measurement(results, m, pictured(index)))
            .collect::<Vec<_>>(),
        "slopes": slopes(&results.measurements)
            .iter()
            .map(|slope| of_slope(results, slope))
            .collect::<Vec<_>>(),
        "film": results.film.as_ref().map(of_film),
        "left_out": results.left_out.iter().map(|LeftOut { what, why }| json!({
            "what": what,
            "why": why,
        })).collect::<Vec<_>>(),
    });
    format!("{summary:#}\n")
}

fn measurement(results: &Results, m: &Measurement, picture: Option<String>) -> Value {
    let method = &results.methods[m.method];
    json!({
        "method": method.name,
        "title": method.setting(m.quality),
        "backend": m.backend,
        "representative": m.representative,
        "quality": m.quality,
        "quality_unit": method.quality,
        "map": m.map,
        "map_refined": method.refines_map,
        "error_rmse": m.error.rmse,
        "error_max": m.error.max,
        "error_rel_p99": m.error.rel_p99,
        "error_relmse": m.error.rel_mse,
        "error_flip": m.error.flip,
        "error_map": results.floor(m),
        "seconds_build": m.seconds_build,
        "seconds_frame": m.frame.median,
        "seconds_frame_min": m.frame.low,
        "seconds_frame_max": m.frame.high,
        "repetitions": m.frame.repetitions,
        "bytes": m.bytes,
        "picture": picture,
    })
}

fn of_slope(results: &Results, slope: &Slope) -> Value {
    let method = &results.methods[slope.method];
    json!({
        "method": method.name,
        "map_refined": method.refines_map,
        "backend": slope.backend,
        "error_over_quality": slope.over_quality,
        "error_over_time": slope.over_time,
    })
}

/// The rows of `film.csv`, each as an object.
fn of_film(film: &Film) -> Value {
    let records = &film.study.records;
    let row = |row: &Row| -> Value {
        let cells = records.columns.iter().zip(&row.cells);
        let named = cells.map(|(column, cell)| (column.name.clone(), of_cell(cell)));
        named.collect::<serde_json::Map<_, _>>().into()
    };
    json!({
        "frames": film.frames,
        "width": film.size.width,
        "height": film.size.height,
        "rows": records.rows().iter().map(row).collect::<Vec<_>>(),
    })
}

/// The value of a cell; null if it is empty.
fn of_cell(cell: &Cell) -> Value {
    match &cell.value {
        study::Value::Text(text) if text.is_empty() => Value::Null,
        study::Value::Text(text) => text.as_str().into(),
        study::Value::Count(count) => (*count).into(),
        study::Value::Number(number) => (*number).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::example;

    #[test]
    fn everything_that_was_measured_is_in_the_summary() {
        let mut results = example();
        results.measurements[2].error.rmse = f64::NAN;
        let text = summary(&results, Path::new("out"));
        let read: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(read["scene"]["name"], results.scene.as_str());
        assert_eq!(read["command"], results.run.command.as_str());
        let rows = read["measurements"].as_array().unwrap();
        assert_eq!(rows.len(), results.measurements.len());
        assert_eq!(rows[0]["error_rmse"], results.measurements[0].error.rmse);
        assert!(rows[2]["error_rmse"].is_null(), "not a number");
        assert_eq!(rows[1]["picture"], "airlight-exact-x-gauss-2-cpu.exr");
        assert!(rows[0]["picture"].is_null());
        let slopes = read["slopes"].as_array().unwrap();
        assert_eq!(slopes.len(), results.methods.len());
        assert_eq!(slopes[2]["error_over_quality"], -1.0);
        assert_eq!(read["shadow_map_floors"][0]["map"], 1024);
        assert_eq!(read["left_out"][0]["what"], "light 3");
    }
}
