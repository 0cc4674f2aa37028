//! The paper's table 1, with errors.

use lighting::methods::Registry;
use lighting::methods::reduced::Reduction;

use super::test_scene::TestScene;
use super::{BRUTE, HYBRID, Measured, PaperRow, TEXTURED, Variant, record};
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

const VARIANTS: [Variant; 3] = [BRUTE, HYBRID, TEXTURED];
const SIZES: [Reduction; 2] = [Reduction::NONE, Reduction::SIXTEENTH];

/// A mesh.
pub(super) struct Row {
    name: &'static str,
    paper: &'static str,
    triangles: usize,
    rates: [[f64; 2]; 3],
    /// Of all pixels and of a sixteenth, variant by variant.
    measured: [[Measured; 2]; 3],
}

/// Every frame of a mesh.
pub(super) fn row(
    registry: &Registry,
    of_paper: &PaperRow,
    scene: &TestScene,
) -> Result<Row, Failure> {
    let mut measured = Vec::new();
    for variant in VARIANTS {
        let frame = |size| scene.frame(registry, variant, variant.steps, size);
        let [all, some] = SIZES.map(frame);
        measured.push([all?, some?]);
    }
    Ok(Row {
        name: of_paper.stand_in.name(),
        paper: of_paper.name,
        triangles: scene.triangles(),
        rates: of_paper.rates,
        measured: [measured[0], measured[1], measured[2]],
    })
}

/// Columns of all variants at all pixels, then at a sixteenth.
fn headed(unit: Unit) -> impl Iterator<Item = Column> {
    ["", ", 1/16"].into_iter().flat_map(move |size| {
        VARIANTS
            .into_iter()
            .map(move |variant| Column::new(format!("{}{size}", variant.name), unit))
    })
}

/// One number of all variants at all pixels, then at a sixteenth.
fn numbers(row: &Row, of: impl Fn(&Measured) -> f64) -> Vec<Cell> {
    let pairs = [0, 1]
        .into_iter()
        .flat_map(|size| row.measured.iter().map(move |sizes| &sizes[size]));
    pairs.map(|measured| of(measured).into()).collect()
}

pub(super) fn describe(study: &mut Study, rows: &[Row]) {
    if rows.is_empty() {
        return;
    }
    let [brute, hybrid, textured] = VARIANTS.map(|variant| variant.steps);
    let mut columns = vec![Column::plain("mesh"), Column::plain("triangles")];
    columns.push(Column::new("map", Unit::Seconds));
    columns.push(Column::new("map, volumes", Unit::Seconds));
    columns.extend(headed(Unit::Seconds));
    columns.push(Column::new("hybrid faster", Unit::With("×")));
    columns.push(Column::new("paper", Unit::With("×")));
    let mut times = Table::new(columns).titled(
        "Frames of meshes that grow",
        format!(
            "As in table 1 of Wyman and Ramsey 2008, whose pictures have 1024² pixels: {brute} steps of brute force along each ray, {hybrid} steps of the hybrid between its shadow volumes, and across the beam of the light with a cookie {textured} steps for colour with twice as many for shadow. The light is gathered at all pixels and at a sixteenth of them. The times for the map, and for the map with the volumes, are listed apart, because these are made again only when a light or a mesh moves. The last column is the ratio of the paper's frame rates at all pixels, on a GPU of 2008."
        ),
    );
    let mut columns = vec![Column::plain("mesh"), Column::plain("for the paper's")];
    columns.extend(headed(Unit::Share));
    let mut errors = Table::new(columns).titled(
        "Errors of the same frames",
        "The paper chose its numbers of steps by eye and gives no errors.",
    );
    for row in rows {
        let [[brute, _], [hybrid, _], _] = row.measured;
        let mut cells: Vec<Cell> = vec![row.name.into(), (row.triangles as u64).into()];
        cells.push(brute.seconds[0].into());
        cells.push(hybrid.seconds[0].into());
        cells.extend(numbers(row, |measured| measured.seconds[1]));
        cells.push((brute.seconds[1] / hybrid.seconds[1]).into());
        cells.push((row.rates[1][0] / row.rates[0][0]).into());
        times.push(cells);
        let mut cells: Vec<Cell> = vec![row.name.into(), row.paper.into()];
        cells.extend(numbers(row, |measured| measured.rmse));
        errors.push(cells);
        for (variant, sizes) in VARIANTS.iter().zip(&row.measured) {
            for (size, measured) in SIZES.iter().zip(sizes) {
                let of = format!("{} {} {size}", row.name, variant.name);
                let of = of.trim_end();
                let steps = variant.steps;
                record(study, "seconds frame", of, steps, measured.seconds[1]);
                record(
                    study,
                    "seconds of map and volumes",
                    of,
                    steps,
                    measured.seconds[0],
                );
                record(study, "rmse", of, steps, measured.rmse);
            }
        }
    }
    study.parts.push(Part::Table(times));
    study.parts.push(Part::Table(errors));
}
