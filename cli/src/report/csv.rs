//! Tables as comma-separated values.

use crate::compare::study::{Table, Value};
use crate::failure::Failure;

/// A header and one line per row, as RFC 4180 but with plain line feeds.
///
/// Numbers are written with as many digits as it takes to read the same `f64`
/// back, in seconds, bytes and metres. What is not finite is `NaN`, `inf` or
/// `-inf`. Keys, marks and asides of cells are left out.
pub(crate) fn csv(table: &Table) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(table.columns.iter().map(|column| &column.name))?;
    for row in table.rows() {
        let texts = row.cells.iter().map(|cell| match &cell.value {
            Value::Text(text) => text.clone(),
            Value::Count(count) => count.to_string(),
            Value::Number(number) => format!("{number:e}"),
        });
        writer.write_record(texts)?;
    }
    Ok(writer.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::study::tests::example;
    use crate::compare::study::{Cell, Column, Unit};

    /// The header and the rows of a text.
    fn read(text: &[u8]) -> (Vec<String>, Vec<Vec<String>>) {
        let mut reader = csv::Reader::from_reader(text);
        let fields = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect();
        let header = fields(reader.headers().unwrap());
        let rows = reader.records().map(|record| fields(&record.unwrap()));
        (header, rows.collect())
    }

    #[test]
    fn what_is_written_is_read_back() {
        let numbers = [
            0.0,
            -0.5,
            1.0 / 3.0,
            1e-300,
            f64::MAX,
            5e-324,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        let texts = [
            "",
            "plain",
            "a, b",
            "\"quoted\"",
            "two\nlines",
            "φ = 1°",
            " ",
        ];
        let columns = ["text, quoted", "count", "number"];
        let mut table = Table::new(columns.map(|name| Column::new(name, Unit::Seconds)).into());
        for (index, number) in numbers.into_iter().enumerate() {
            let text = texts[index % texts.len()];
            let count = u64::MAX - index as u64;
            table.push(vec![text.into(), count.into(), number.into()]);
        }
        let (header, rows) = read(&csv(&table).unwrap());
        assert_eq!(header, columns);
        assert_eq!(rows.len(), numbers.len());
        for (index, (row, number)) in rows.iter().zip(numbers).enumerate() {
            assert_eq!(row[0], texts[index % texts.len()]);
            assert_eq!(row[1].parse::<u64>().unwrap(), u64::MAX - index as u64);
            let read: f64 = row[2].parse().unwrap();
            assert!(
                read == number || read.is_nan() && number.is_nan(),
                "{number}"
            );
        }
    }

    #[test]
    fn a_table_without_rows_has_a_header() {
        let table = Table::new(vec![Column::plain("a"), Column::plain("b")]);
        assert_eq!(csv(&table).unwrap(), b"a,b\n");
    }

    #[test]
    fn only_values_are_written() {
        let mut table = example().records;
        let text = String::from_utf8(csv(&table).unwrap()).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("subject,error,time,memory"));
        let row = "\"smoke & \"\"hair\"\", <both>\",1e-4,1e-8,65536";
        assert_eq!(lines.next(), Some(row));
        table.push(vec![
            Cell {
                mark: "*",
                aside: "aside".into(),
                shaded: true,
                ..Cell::from("x")
            },
            1.0.into(),
            1.0.into(),
            1.0.into(),
        ]);
        let text = String::from_utf8(csv(&table).unwrap()).unwrap();
        assert!(text.ends_with("\nx,1e0,1e0,1e0\n"), "{text}");
    }

    #[test]
    fn a_long_table_is_written_as_a_whole() {
        let mut table = Table::new(vec![Column::plain("n"), Column::plain("square")]);
        for n in 0..20_000_u64 {
            table.push(vec![n.into(), ((n * n) as f64).into()]);
        }
        let (_, rows) = read(&csv(&table).unwrap());
        assert_eq!(rows.len(), 20_000);
        assert_eq!(rows[19_999], ["19999", "3.99960001e8"]);
    }
}
