//! The measurements as they are written to `results.csv`.

use super::results::Results;
use super::study::{Cell, Column, Table};

/// Names of the columns; later versions add to the end.
const COLUMNS: [&str; 23] = [
    "scene",
    "light",
    "visibility",
    "airlight",
    "backend",
    "quality",
    "error_rmse",
    "error_max",
    "error_rel_p99",
    "seconds_build",
    "seconds_frame",
    "bytes",
    "quality_unit",
    "width",
    "height",
    "map",
    "map_refined",
    "error_map",
    "error_relmse",
    "error_flip",
    "repetitions",
    "seconds_frame_min",
    "seconds_frame_max",
];

/// One row per measurement: times are medians in seconds, errors are as in
/// [`Results`]. What a row has none of is empty.
pub(crate) fn records(results: &Results) -> Table {
    let mut table = Table::new(COLUMNS.map(Column::plain).into());
    let or_empty = |value: Option<f64>| value.map_or_else(|| Cell::from(""), Cell::from);
    for m in &results.measurements {
        let method = &results.methods[m.method];
        table.push(vec![
            results.scene.as_str().into(),
            results.light.as_str().into(),
            method.visibility.as_str().into(),
            method.airlight.as_str().into(),
            m.backend.as_str().into(),
            m.quality.into(),
            m.error.rmse.into(),
            m.error.max.into(),
            m.error.rel_p99.into(),
            m.seconds_build.into(),
            m.frame.median.into(),
            m.bytes.into(),
            method.quality.as_str().into(),
            results.size.width.into(),
            results.size.height.into(),
            m.map.map_or_else(|| Cell::from(""), Cell::from),
            u32::from(method.refines_map).into(),
            or_empty(results.floor(m)),
            m.error.rel_mse.into(),
            or_empty(m.error.flip),
            m.frame.repetitions.into(),
            m.frame.low.into(),
            m.frame.high.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};
    use crate::report::csv;

    fn lines_of(results: &Results) -> Vec<Vec<String>> {
        let text = csv(&records(results)).unwrap();
        let mut reader = ::csv::Reader::from_reader(&text[..]);
        let rows = reader.records().map(|row| row.unwrap());
        rows.map(|row| row.iter().map(str::to_owned).collect())
            .collect()
    }

    #[test]
    fn every_measurement_is_a_line_of_csv() {
        let mut results = example();
        results.measurements[1].error.flip = None;
        let lines = lines_of(&results);
        assert_eq!(lines.len(), results.measurements.len());
        for (line, m) in lines.iter().zip(&results.measurements) {
            assert_eq!(line.len(), COLUMNS.len());
            let number = |name: &str| -> Option<f64> {
                let place = COLUMNS.iter().position(|column| *column == name).unwrap();
                match line[place].as_str() {
                    "" => None,
                    text => Some(text.parse().unwrap()),
                }
            };
            assert_eq!(line[0], results.scene);
            assert_eq!(line[2], results.methods[m.method].visibility);
            assert_eq!(line[6].parse::<f64>().unwrap(), m.error.rmse);
            assert_eq!(line[11].parse::<u64>().unwrap(), m.bytes);
            assert_eq!(number("error_flip"), m.error.flip);
            assert_eq!(number("error_relmse"), Some(m.error.rel_mse));
            assert_eq!(number("map"), m.map.map(f64::from));
            assert_eq!(number("error_map"), m.map.map(|_| 1e-3));
            assert_eq!(number("seconds_frame_max"), Some(m.frame.high));
            assert_eq!(number("repetitions"), Some(2.0));
            assert_eq!((number("width"), number("height")), (Some(4.0), Some(2.0)));
        }
    }

    #[test]
    fn a_backend_whose_name_has_commas_is_one_column() {
        let lines = lines_of(&example_with_software());
        assert_eq!(lines.last().unwrap()[4], "gpu (a, \"b\", software)");
    }
}
