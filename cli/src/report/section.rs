//! Studies and their pieces as HTML: the one renderer of them all, which the
//! main results use too.

use maud::{Markup, html};

use super::chart::{chart, swatch};
use super::numbers::value;
use crate::compare::study::{Cell, Charts, Column, Part, Row, Series, Strip, Study, Table};
use crate::picture::data_uri;

/// A study's section, folded; nothing if it has no parts.
pub(super) fn study(study: &Study) -> Markup {
    html! {
        @if !study.parts.is_empty() {
            details.study {
                summary { "Study: " (study.title) }
                @if !study.introduction.is_empty() {
                    p { (study.introduction) }
                }
                @for part in &study.parts {
                    @match part {
                        Part::Table(part) => (table(part)),
                        Part::Charts(part) => (charts(part)),
                        Part::Strips(part) => (strips(part)),
                        Part::Note(text) => p { (text) },
                    }
                }
                p.soft { "All numbers are in " code { (study.csv) } "." }
            }
        }
    }
}

/// Films, one below the other where there is no room beside.
fn strips(strips: &[Strip]) -> Markup {
    html! {
        .strips {
            @for strip in strips {
                figure {
                    figcaption { (strip.name) }
                    img loading="lazy" src=(data_uri(&strip.file)) width=(strip.size.width) height=(strip.size.height) alt={ "film of " (strip.name) };
                }
            }
        }
    }
}

/// A table below its heading and its paragraph.
pub(super) fn table(table: &Table) -> Markup {
    html! {
        @if !table.title.is_empty() {
            h3 { (table.title) }
        }
        @if !table.caption.is_empty() {
            p.soft.above { (table.caption) }
        }
        .wide role="region" aria-label=(label(table)) tabindex="0" {
            table {
                thead {
                    tr {
                        @for column in &table.columns {
                            th scope="col" { (column.name) }
                        }
                    }
                }
                @for group in groups(table) {
                    tbody class=[table.grouped.then_some("group")] {
                        @for (index, row) in group.iter().enumerate() {
                            tr class=[row.shaded.then_some("best")] {
                                @for (column, content) in table.columns.iter().zip(&row.cells).take(1) {
                                    @if !table.grouped {
                                        (head(column, content, 1))
                                    } @else if index == 0 {
                                        (head(column, content, group.len()))
                                    }
                                }
                                @for (column, content) in table.columns.iter().zip(&row.cells).skip(1) {
                                    (cell(column, content))
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The name of a table for readers who hear it.
fn label(table: &Table) -> String {
    if table.title.is_empty() {
        let first = table.columns.first();
        format!("table by {}", first.map_or("row", |column| &column.name))
    } else {
        table.title.clone()
    }
}

/// The rows that belong together: those with one first cell, or else all.
fn groups(table: &Table) -> Vec<&[Row]> {
    let first = |row: &Row| row.cells.first().map(|cell| cell.value.clone());
    if table.grouped {
        let groups = table.rows().chunk_by(|a, b| first(a) == first(b));
        groups.collect()
    } else {
        vec![table.rows()]
    }
}

/// The first cell of so many rows, which names them.
fn head(column: &Column, cell: &Cell, rows: usize) -> Markup {
    let text = value(&cell.value, column.unit);
    let rows = (rows > 1).then_some(rows);
    html! {
        th scope="row" rowspan=[rows] class=[classes([(column.soft, "soft"), (cell.shaded, "won")])] {
            (content(cell, &text))
        }
    }
}

fn cell(column: &Column, cell: &Cell) -> Markup {
    let text = value(&cell.value, column.unit);
    html! {
        td class=[classes([(column.soft, "soft"), (cell.shaded, "won")])] {
            (content(cell, &text))
        }
    }
}

fn content(cell: &Cell, text: &str) -> Markup {
    html! {
        @if let Some(key) = cell.key {
            span.name { (swatch(key)) span { (text) (cell.mark) (aside(cell)) } }
        } @else {
            (text) (cell.mark) (aside(cell))
        }
    }
}

/// Words of less weight behind a value.
fn aside(cell: &Cell) -> Markup {
    html! {
        @if !cell.aside.is_empty() {
            " " span.aside { (cell.aside) }
        }
    }
}

/// The classes that apply; `None` if none does.
fn classes(all: [(bool, &str); 2]) -> Option<String> {
    let applying = all.into_iter().filter(|(applies, _)| *applies);
    let names: Vec<&str> = applying.map(|(_, name)| name).collect();
    (!names.is_empty()).then(|| names.join(" "))
}

/// Charts side by side, with one legend or one for each.
///
/// Those that have nothing to show are left out.
pub(super) fn charts(charts: &Charts) -> Markup {
    let drawn = charts.all.iter().filter_map(|c| Some((c, chart(c)?)));
    let drawn: Vec<_> = drawn.collect();
    let shared = drawn.iter().flat_map(|(chart, _)| &chart.series);
    html! {
        @if !drawn.is_empty() {
            @if charts.share_legend {
                (legend(shared))
            }
            .plots {
                @for (chart, picture) in &drawn {
                    figure {
                        @if !chart.title.is_empty() {
                            figcaption {
                                b { (chart.title) }
                                @if !chart.caption.is_empty() {
                                    ": " (chart.caption)
                                }
                                "."
                            }
                        }
                        .wide { (picture) }
                        @if !charts.share_legend {
                            (legend(chart.series.iter()))
                        }
                    }
                }
            }
        }
    }
}

/// Every series once, in the order of the first mention.
fn legend<'a>(all: impl Iterator<Item = &'a Series>) -> Markup {
    let mut named: Vec<&Series> = Vec::new();
    for series in all {
        let is_known = |other: &&Series| (other.key, &other.name) == (series.key, &series.name);
        if !named.iter().any(is_known) {
            named.push(series);
        }
    }
    html! {
        ul.legend {
            @for series in named {
                li {
                    (swatch(series.key))
                    span {
                        (series.name)
                        @if !series.aside.is_empty() {
                            " " span.soft { (series.aside) }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::studies::STUDIES;
    use crate::compare::study::tests::example;
    use crate::compare::study::{Key, Unit};
    use crate::report::tests::unbalanced;

    #[test]
    fn every_piece_of_a_study_is_shown_and_escaped() {
        let html = study(&example()).into_string();
        assert_eq!(unbalanced(&html), Vec::<String>::new());
        for present in [
            "<summary>Study: an &lt;example&gt;</summary>",
            "<p>Smoke &amp; &quot;hair&quot;.</p>",
            "<h3>A &lt;table&gt;</h3>",
            "<p class=\"soft above\">Its &lt;caption&gt;.</p>",
            "<p>A &lt;note&gt;.</p>",
            "<b>a ray &lt;of&gt; light</b>: one &amp; all.",
            "aria-label=\"error against &quot;time&quot;\"",
            "<code>example.csv</code>",
            "≥ 10",
        ] {
            assert!(html.contains(present), "{present}: {html}");
        }
        for absent in ["<series>", "<both>", "<here>", "<%>", "NaN", "inf<", "inf "] {
            assert!(!html.contains(absent), "{absent}: {html}");
        }
        assert_eq!(html.matches("<svg class=\"chart\"").count(), 2);
        assert_eq!(html.matches("<ul class=\"legend\">").count(), 2);
    }

    #[test]
    fn cells_that_are_not_finite_say_so() {
        let html = table(&example().records).into_string();
        assert_eq!(html.matches("not finite").count(), 2, "{html}");
    }

    #[test]
    fn neighbours_of_one_group_are_named_once() {
        let mut example = example().records;
        example.grouped = true;
        let html = table(&example).into_string();
        assert_eq!(html.matches("<tbody class=\"group\">").count(), 1);
        assert_eq!(html.matches("<th scope=\"row\" rowspan=\"3\">").count(), 1);
        assert_eq!(html.matches("<td").count(), 9);
        example.grouped = false;
        let html = table(&example).into_string();
        assert_eq!(html.matches("<th scope=\"row\">").count(), 3);
        assert!(!html.contains("class=\"group") && !html.contains("rowspan"));
    }

    #[test]
    fn rows_and_cells_that_stand_out_have_their_classes() {
        let mut columns = vec![Column::plain("a"), Column::new("b", Unit::Seconds)];
        columns[0].soft = true;
        let mut example = Table::new(columns);
        let winner = Cell {
            mark: "*",
            aside: "<64>".into(),
            shaded: true,
            ..Cell::from(0.5)
        };
        example.push_row(vec![Cell::keyed("x", Key::new(3)), winner], true);
        let html = table(&example).into_string();
        assert!(
            html.contains("<tr class=\"best\"><th scope=\"row\" class=\"soft\">"),
            "{html}"
        );
        let cell = "<td class=\"won\">500 ms* <span class=\"aside\">&lt;64&gt;</span></td>";
        assert!(html.contains(cell), "{html}");
        assert!(html.contains("class=\"dot m3\""), "{html}");
    }

    #[test]
    fn a_long_table_has_all_of_its_rows() {
        let mut long = Table::new(vec![Column::plain("n"), Column::new("t", Unit::Seconds)]);
        long.grouped = true;
        for n in 0..5000_u32 {
            long.push(vec![(n / 10).into(), (1e-6 * f64::from(n)).into()]);
        }
        let html = table(&long).into_string();
        assert_eq!(html.matches("<tr").count(), 5001);
        assert_eq!(html.matches("class=\"group\"").count(), 500);
        assert_eq!(unbalanced(&html), Vec::<String>::new());
    }

    #[test]
    fn a_study_without_parts_has_no_section_and_charts_of_nothing_no_legend() {
        let mut empty = example();
        empty.parts.clear();
        assert_eq!(study(&empty).into_string(), "");
        let mut nothing = example();
        for part in &mut nothing.parts {
            if let Part::Charts(charts) = part {
                for chart in &mut charts.all {
                    chart.series.clear();
                }
            }
        }
        let html = study(&nothing).into_string();
        assert!(
            !html.contains("legend") && !html.contains("<figure"),
            "{html}"
        );
    }

    #[test]
    fn every_study_of_the_list_is_shown_with_its_csv_file() {
        for kind in &STUDIES {
            let mut one = kind.blank();
            one.parts = example().parts;
            let html = study(&one).into_string();
            assert!(html.contains(&format!("<code>{}</code>", kind.csv)));
            assert!(html.contains(kind.title));
        }
    }
}
