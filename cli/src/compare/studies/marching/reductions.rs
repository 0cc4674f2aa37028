//! How much time is saved by gathering light at few pixels, and how much error it adds.

use lighting::methods::Registry;
use lighting::methods::reduced::{Filter, Reduction};

use super::test_scene::TestScene;
use super::{BRUTE, HYBRID, Limit, Measured, TEXTURED, Variant, record};
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// Every variant at all pixels and at fewer, as far as the time allows.
pub(super) fn measure(
    registry: &Registry,
    scene: &TestScene,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    let gaussian = |reduction: Reduction| reduction.with_filter(Filter::Gaussian);
    let mut table = Table::new(vec![
        Column::plain("method"),
        Column::plain("pixels"),
        Column::new("time", Unit::Seconds),
        Column::new("faster", Unit::With("×")),
        Column::new("error", Unit::Share),
        Column::new("error added", Unit::Share),
        Column::new("in full", Unit::Share),
    ])
    .titled(
        "Light scattered at fewer pixels",
        "A ball, with the steps of the tables above. The other pixels are filled by a filter that compares depths and normals; pixels that no sample resembles are gathered in full. The 3 x 3 Gaussian of the paper, which compares neither, is beside it.",
    );
    table.grouped = true;
    for variant in [BRUTE, HYBRID, TEXTURED] {
        let mut full: Option<Measured> = None;
        for reduction in [
            Reduction::NONE,
            Reduction::QUARTER,
            gaussian(Reduction::QUARTER),
            Reduction::SIXTEENTH,
            gaussian(Reduction::SIXTEENTH),
        ] {
            if let Some(why) = limit.reached() {
                study.leave_out(&format!("{} at fewer pixels", variant.name), why);
                break;
            }
            let measured = scene.frame(registry, variant, variant.steps, reduction)?;
            let full = *full.get_or_insert(measured);
            table.push(cells(variant, reduction, full, measured));
            let of = format!("{} {reduction}", variant.name);
            let of = of.trim_end();
            for (what, value) in [
                ("seconds at fewer pixels", measured.seconds[1]),
                ("rmse at fewer pixels", measured.rmse),
                ("share gathered in full", measured.in_full),
            ] {
                record(study, what, of, variant.steps, value);
            }
        }
    }
    if !table.rows().is_empty() {
        study.parts.push(Part::Table(table));
    }
    Ok(())
}

fn cells(variant: Variant, reduction: Reduction, full: Measured, measured: Measured) -> Vec<Cell> {
    let name = match reduction.is_none() {
        true => "all".into(),
        false => reduction.to_string(),
    };
    vec![
        Cell::keyed(variant.name, variant.key),
        name.into(),
        measured.seconds[1].into(),
        (full.seconds[1] / measured.seconds[1]).into(),
        measured.rmse.into(),
        (measured.rmse - full.rmse).into(),
        measured.in_full.into(),
    ]
}
