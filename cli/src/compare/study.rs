//! What a study returns: headings, tables, charts and notes as plain data.
//!
//! A study measures one algorithm by itself. It knows nothing of HTML or CSV:
//! [`crate::report`] shows every [`Study`] with one renderer and writes its
//! [`records`](Study::records) with one writer, the same that serve the main
//! results. Numbers stay numbers up to there; the [`Unit`] of their column says
//! how they are written for people.

use crate::parse::Size;

/// One study, as far as it was carried out.
#[derive(Debug, Clone)]
pub(crate) struct Study {
    /// Its heading.
    pub(crate) title: &'static str,
    /// It says what was measured, on what, and what the numbers mean.
    pub(crate) introduction: String,
    /// Everything that is shown, in reading order. A study without parts has no section.
    pub(crate) parts: Vec<Part>,
    /// Name of its CSV file.
    pub(crate) csv: &'static str,
    /// Everything that was measured, for that file. It has its columns even
    /// where there are no rows.
    pub(crate) records: Table,
    /// Everything for which there was no time or no cause.
    pub(crate) left_out: Vec<LeftOut>,
}

/// A piece of a study's section.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    Table(Table),
    Charts(Charts),
    /// Films beside each other.
    Strips(Vec<Strip>),
    /// A paragraph.
    Note(String),
}

/// A film as an animated PNG file.
#[derive(Debug, Clone)]
pub(crate) struct Strip {
    pub(crate) name: String,
    pub(crate) size: Size,
    pub(crate) file: Vec<u8>,
}

/// Something that the scene or the budget made pointless.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LeftOut {
    pub(crate) what: String,
    pub(crate) why: String,
}

/// A line for each reason, with the names of all things that were left out for it.
pub(crate) fn described<'a>(left_out: impl IntoIterator<Item = &'a LeftOut>) -> String {
    let mut lines: Vec<(&'a str, Vec<&'a str>)> = Vec::new();
    for LeftOut { what, why } in left_out {
        match lines.iter_mut().find(|(reason, _)| reason == why) {
            Some((_, all)) => all.push(what),
            None => lines.push((why, vec![what])),
        }
    }
    let line = |(why, all): (&str, Vec<&str>)| format!("left out: {} ({why})\n", all.join(", "));
    lines.into_iter().map(line).collect()
}

/// The reason of everything that is left out for lack of time.
pub(crate) const NO_TIME: &str = "no time left (--time-budget)";

/// Rows of cells under named columns.
#[derive(Debug, Clone, Default)]
pub(crate) struct Table {
    /// Its heading; none if empty.
    pub(crate) title: String,
    /// The paragraph above it; none if empty.
    pub(crate) caption: String,
    pub(crate) columns: Vec<Column>,
    /// Each has as many cells as there are columns.
    rows: Vec<Row>,
    /// Neighbouring rows with the same first cell belong together: it is shown
    /// once, below a rule.
    pub(crate) grouped: bool,
}

/// One column of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    /// Its heading in a table for people, its name in CSV.
    pub(crate) name: String,
    pub(crate) unit: Unit,
    /// Its cells are of less weight than the others.
    pub(crate) soft: bool,
}

/// How the numbers of a column or an axis are written for people; CSV has them
/// plain, in seconds, bytes and metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Unit {
    /// Three significant digits.
    Number,
    /// Three significant digits; all numbers from this one on are written as `≥` this one.
    Below(f64),
    /// A percentage.
    Share,
    /// A duration in the unit that suits it.
    Seconds,
    /// An amount of memory in the unit that suits it.
    Bytes,
    /// Three significant digits, followed by this text.
    With(&'static str),
}

/// One row of a table.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) cells: Vec<Cell>,
    /// It stands out from the others.
    pub(crate) shaded: bool,
}

/// One cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cell {
    pub(crate) value: Value,
    /// The colour and marker in front of a name.
    pub(crate) key: Option<Key>,
    /// Text right behind the value.
    pub(crate) mark: &'static str,
    /// A few words of less weight behind it.
    pub(crate) aside: String,
    /// It stands out from the others of its column.
    pub(crate) shaded: bool,
}

/// The value of a cell.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Text(String),
    Count(u64),
    Number(f64),
}

/// The colour and marker of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key {
    /// Number of the colour.
    pub(crate) slot: usize,
    pub(crate) dashed: bool,
}

/// Charts side by side.
#[derive(Debug, Clone, Default)]
pub(crate) struct Charts {
    /// One legend for all of them; otherwise each has its own.
    pub(crate) share_legend: bool,
    pub(crate) all: Vec<Chart>,
}

/// Points or lines between two axes.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    pub(crate) title: String,
    /// Text behind the title; may be empty.
    pub(crate) caption: String,
    /// The chart in words, for those who do not see it.
    pub(crate) description: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Shows the Pareto front of the points that compete.
    pub(crate) front: bool,
    pub(crate) series: Vec<Series>,
}

/// One axis of a chart.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    pub(crate) label: String,
    pub(crate) scale: Scale,
    /// How the numbers beside its ticks are written.
    pub(crate) unit: Unit,
}

/// How numbers lie along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Scale {
    /// By their logarithm, around all that are positive; numbers that are not
    /// lie at the lower end.
    Log,
    /// Evenly, from the least to the greatest.
    Linear,
    /// Evenly between two ends; numbers beyond them lie at the nearer one.
    Between(f64, f64),
}

/// Points of one kind.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) name: String,
    /// A few words of less weight behind the name.
    pub(crate) aside: String,
    pub(crate) key: Key,
    /// False if its points may not be on the front.
    pub(crate) competes: bool,
    pub(crate) shape: Shape,
    pub(crate) points: Vec<Point>,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Each point has a marker, and its neighbours are joined.
    Points,
    /// A line of many points, of which a few have markers.
    Line,
}

/// One point of a series.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// The least and the greatest x of several measurements.
    pub(crate) spread: [f64; 2],
    /// Written beside it at the ends of a series.
    pub(crate) label: String,
    /// Shown while a pointer rests on it.
    pub(crate) title: String,
}

impl Study {
    /// The study with that heading and file, before anything is measured.
    pub(crate) fn new(title: &'static str, csv: &'static str, columns: Vec<Column>) -> Self {
        Self {
            title,
            introduction: String::new(),
            parts: Vec::new(),
            csv,
            records: Table::new(columns),
            left_out: Vec::new(),
        }
    }

    /// Leaves a part of the study out, or all of it if `part` is empty.
    pub(crate) fn leave_out(&mut self, part: &str, why: impl Into<String>) {
        let title = self.title;
        self.left_out.push(LeftOut {
            what: match part {
                "" => format!("study of {title}"),
                part => format!("study of {title}: {part}"),
            },
            why: why.into(),
        });
    }
}

impl Table {
    /// A table without rows.
    pub(crate) fn new(columns: Vec<Column>) -> Self {
        Self {
            columns,
            ..Self::default()
        }
    }

    /// The same table below a heading and a paragraph.
    pub(crate) fn titled(self, title: impl Into<String>, caption: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            caption: caption.into(),
            ..self
        }
    }

    /// Adds a row of one cell per column.
    pub(crate) fn push(&mut self, cells: Vec<Cell>) {
        self.push_row(cells, false);
    }

    /// Adds a row that may stand out.
    pub(crate) fn push_row(&mut self, cells: Vec<Cell>, shaded: bool) {
        assert_eq!(cells.len(), self.columns.len(), "a row has every column");
        self.rows.push(Row { cells, shaded });
    }

    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Some of the columns of the rows that `keep` accepts, under new headings.
    ///
    /// `columns` pairs the name of a column with its heading; a name that no
    /// column has is a mistake in the study, and panics.
    pub(crate) fn view(&self, columns: &[(&str, &str)], keep: impl Fn(&Row) -> bool) -> Self {
        let place = |name: &str| {
            let mut all = self.columns.iter();
            all.position(|column| column.name == name)
                .unwrap_or_else(|| panic!("no column is called {name}"))
        };
        let places: Vec<usize> = columns.iter().map(|(name, _)| place(name)).collect();
        let headed = |(place, (_, heading)): (&usize, &(&str, &str))| Column {
            name: (*heading).into(),
            ..self.columns[*place].clone()
        };
        let mut view = Self::new(places.iter().zip(columns).map(headed).collect());
        for row in self.rows.iter().filter(|row| keep(row)) {
            let cells = places.iter().map(|place| row.cells[*place].clone());
            view.push_row(cells.collect(), row.shaded);
        }
        view
    }
}

impl Column {
    pub(crate) fn new(name: impl Into<String>, unit: Unit) -> Self {
        Self {
            name: name.into(),
            unit,
            soft: false,
        }
    }

    /// A column of text or counts.
    pub(crate) fn plain(name: impl Into<String>) -> Self {
        Self::new(name, Unit::Number)
    }
}

impl Cell {
    /// A name with its colour and marker.
    pub(crate) fn keyed(name: impl Into<String>, key: Key) -> Self {
        Self {
            key: Some(key),
            ..Self::from(name.into())
        }
    }

    /// The cell's text, if that is what it holds.
    pub(crate) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}

impl From<Value> for Cell {
    fn from(value: Value) -> Self {
        Self {
            value,
            key: None,
            mark: "",
            aside: String::new(),
            shaded: false,
        }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Value::Text(text).into()
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Value::Text(text.into()).into()
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Value::Count(count).into()
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        u64::from(count).into()
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        (count as u64).into()
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Value::Number(number).into()
    }
}

impl Key {
    pub(crate) const fn new(slot: usize) -> Self {
        Self {
            slot,
            dashed: false,
        }
    }
}

impl Point {
    /// A point of a line: without a spread and without words.
    pub(crate) fn bare(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            spread: [x, x],
            label: String::new(),
            title: String::new(),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_for_one_reason_is_one_line() {
        let of = |what: &str, why: &str| LeftOut {
            what: what.into(),
            why: why.into(),
        };
        let all = ["a", "b", "c", "d", "e"].map(|what| of(what, "not asked for"));
        let mut left_out = all.to_vec();
        left_out.insert(1, of("x", NO_TIME));
        let expected =
            format!("left out: a, b, c, d, e (not asked for)\nleft out: x ({NO_TIME})\n");
        assert_eq!(described(&left_out), expected);
        assert_eq!(described(&[]), "");
    }

    /// A study with one of everything, and with text that HTML and CSV must
    /// escape.
    pub(crate) fn example() -> Study {
        let columns = vec![
            Column::plain("subject"),
            Column::new("error", Unit::Below(10.0)),
            Column::new("time", Unit::Seconds),
            Column::new("memory", Unit::Bytes),
        ];
        let mut study = Study::new("an <example>", "example.csv", columns);
        study.introduction = "Smoke & \"hair\".".into();
        for (error, seconds) in [(1e-4, 1e-8), (20.0, f64::NAN), (f64::INFINITY, 2e-8)] {
            let subject = Cell::keyed("smoke & \"hair\", <both>", Key::new(2));
            let cells = vec![subject, error.into(), seconds.into(), 65536_u64.into()];
            study.records.push(cells);
        }
        let mut table = study.records.clone().titled("A <table>", "Its <caption>.");
        table.grouped = true;
        let point = |x: f64, y: f64| Point {
            label: "4 & more".into(),
            title: "<here>".into(),
            ..Point::bare(x, y)
        };
        let series = |shape, points| Series {
            name: "a <series>".into(),
            aside: String::new(),
            key: Key::new(2),
            competes: true,
            shape,
            points,
        };
        let axis = |label: &str, scale| Axis {
            label: label.into(),
            scale,
            unit: Unit::Number,
        };
        let chart = |scale, series| Chart {
            title: "a ray <of> light".into(),
            caption: "one & all".into(),
            description: "error against \"time\"".into(),
            x: axis("time", scale),
            y: axis("error <%>", scale),
            front: scale == Scale::Log,
            series: vec![series],
        };
        let few = vec![point(1.0, 0.1), point(2.0, 0.0), point(3.0, f64::NAN)];
        let many = (0..200).map(|i| 0.01 * f64::from(i));
        let many = many.map(|x| Point::bare(x, 1.5 - x));
        study.parts = vec![
            Part::Charts(Charts {
                share_legend: true,
                all: vec![chart(Scale::Log, series(Shape::Points, few))],
            }),
            Part::Table(table),
            Part::Note("A <note>.".into()),
            Part::Charts(Charts {
                share_legend: false,
                all: vec![chart(Scale::Linear, series(Shape::Line, many.collect()))],
            }),
        ];
        study
    }

    #[test]
    fn a_view_has_the_chosen_columns_of_the_chosen_rows() {
        let study = example();
        let view = study
            .records
            .view(&[("memory", "size"), ("error", "worst")], |row| {
                row.cells[1].value == Value::Number(20.0)
            });
        let names: Vec<&str> = view.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["size", "worst"]);
        assert_eq!(view.columns[0].unit, Unit::Bytes);
        assert_eq!(view.rows().len(), 1);
        assert_eq!(view.rows()[0].cells, [65536_u64.into(), 20.0.into()]);
    }

    #[test]
    #[should_panic(expected = "a row has every column")]
    fn a_row_without_all_columns_is_refused() {
        example().records.push(vec!["alone".into()]);
    }

    #[test]
    fn what_is_left_out_names_its_study() {
        let mut study = Study::new("curves", "curves.csv", Vec::new());
        study.leave_out("", "no light");
        study.leave_out("moments", "no time");
        let what: Vec<&str> = study.left_out.iter().map(|l| l.what.as_str()).collect();
        assert_eq!(what, ["study of curves", "study of curves: moments"]);
    }
}
