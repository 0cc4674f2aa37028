//! Sizes and times of precomputed voxelized shadows by each rule and in each form, on the same
//! map.

use std::time::Instant;

use gpu_backend::Cpu;
use lighting::precomputed::{Builder, Form, Resolution};
use shadow_dag::{DepthSource, Error, Exits, LightSpace, Mesh, Rule, TileRect};

use super::record;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;
use crate::format::bytes;

/// Sizes at one resolution.
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    resolution: u32,
    /// Edges between texels whose depths have nothing in common.
    pub(super) edges: u64,
    pub(super) rows: Vec<SizeRow>,
}

/// One rule.
#[derive(Debug, Clone)]
pub(super) struct SizeRow {
    rule: &'static str,
    /// Bytes of the plain and of the packed file.
    pub(super) bytes: [u64; 2],
    /// Seconds to build from maps in memory, with and without culling.
    seconds: [f64; 2],
}

impl Sizes {
    /// Builds from the depths of the casters with every rule, in both forms.
    pub(super) fn measure(mesh: &Mesh) -> Result<Self, Failure> {
        let maps = Maps::of(mesh)?;
        let cpu = Cpu::new();
        let mut rows = Vec::new();
        for (name, rule) in [
            ("2014", Rule::Sintorn2014),
            ("2015", Rule::Kampe2015),
            ("aligned", Rule::Aligned),
        ] {
            let builder = Builder::new().rule(rule);
            let clock = Instant::now();
            builder.culling(false).build(&cpu, &maps)?;
            let unculled = clock.elapsed().as_secs_f64();
            let clock = Instant::now();
            let plain = builder.build(&cpu, &maps)?;
            let culled = clock.elapsed().as_secs_f64();
            let packed = plain.to_form(Form::Packed)?;
            rows.push(SizeRow {
                rule: name,
                bytes: [plain, packed].map(|dag| dag.as_bytes().len() as u64),
                seconds: [culled, unculled],
            });
        }
        Ok(Self {
            resolution: mesh.resolution().side(),
            edges: maps.silhouette_edges(),
            rows,
        })
    }

    /// Records the sizes, and shows them in a table.
    pub(super) fn describe(&self, study: &mut Study) {
        let map = 2 * u64::from(self.resolution).pow(2);
        let mut table = Table::new(vec![
            Column::plain("rule"),
            Column::new("plain", Unit::Bytes),
            Column::new("packed", Unit::Bytes),
            Column::plain("packed / plain"),
            Column::plain("map / packed"),
            Column::plain("bits per edge, plain"),
            Column::plain("packed"),
            Column::new("build", Unit::Seconds),
            Column::new("without culling", Unit::Seconds),
        ])
        .titled(
            "What rules and forms take",
            format!(
                "{}³ voxels, built from the same maps. \
A 16-bit shadow map takes {}. The map has {} silhouette edges: edges between texels whose depths, \
from entering solids to leaving them, have nothing in common. Building is without what made the maps.",
                self.resolution,
                bytes(map),
                self.edges
            ),
        );
        let edges = self.edges as f64;
        record(study, "silhouette", "", self.resolution, ("edges", edges));
        for row in &self.rows {
            let [plain, packed] = row.bytes.map(|bytes| bytes as f64);
            let [culled, unculled] = row.seconds;
            for (what, value) in [
                ("size plain", ("bytes", plain)),
                ("size packed", ("bytes", packed)),
                ("build", ("seconds", culled)),
                ("build without culling", ("seconds", unculled)),
            ] {
                record(study, what, row.rule, self.resolution, value);
            }
            let per_edge = |size: f64| match self.edges {
                0 => Cell::from("no edges"),
                _ => (8.0 * size / edges).into(),
            };
            table.push(vec![
                row.rule.into(),
                row.bytes[0].into(),
                row.bytes[1].into(),
                (packed / plain).into(),
                (map as f64 / packed).into(),
                per_edge(plain),
                per_edge(packed),
                culled.into(),
                unculled.into(),
            ]);
        }
        study.parts.push(Part::Table(table));
    }
}

/// Depths of a whole map in memory.
struct Maps {
    resolution: Resolution,
    light: Option<LightSpace>,
    enter: Vec<u32>,
    exit: Vec<u32>,
}

/// Texels along each side of the tiles in which a map is made.
const TILE: u32 = 256;

impl Maps {
    fn of(mesh: &Mesh) -> Result<Self, Error> {
        let resolution = mesh.resolution();
        let side = resolution.side();
        let width = side / TILE;
        let tile = |index: usize| TileRect {
            x: index as u32 % width * TILE,
            y: index as u32 / width * TILE,
            side: TILE,
        };
        let tiles = Cpu::new().map((width * width) as usize, |index| {
            let (mut enter, mut exit) = (vec![0; tile(index).len()], vec![0; tile(index).len()]);
            mesh.read(tile(index), &mut enter, &mut exit)
                .map(|_| (enter, exit))
        });
        let texels = (side as usize).pow(2);
        let mut maps = Self {
            resolution,
            light: mesh.light(),
            enter: vec![0; texels],
            exit: vec![0; texels],
        };
        for (index, depths) in tiles.into_iter().enumerate() {
            let (enter, exit) = depths?;
            for (row, (enter, exit)) in
                (0..).zip(enter.chunks(TILE as usize).zip(exit.chunks(TILE as usize)))
            {
                let at = maps.at(tile(index).x, tile(index).y + row);
                maps.enter[at..at + enter.len()].copy_from_slice(enter);
                maps.exit[at..at + exit.len()].copy_from_slice(exit);
            }
        }
        Ok(maps)
    }

    fn at(&self, x: u32, y: u32) -> usize {
        y as usize * self.resolution.side() as usize + x as usize
    }

    /// Edges between texels whose depths have nothing in common.
    fn silhouette_edges(&self) -> u64 {
        let side = self.resolution.side() as usize;
        let apart = |a: usize, b: usize| {
            u64::from(self.enter[a].max(self.enter[b]) > self.exit[a].min(self.exit[b]))
        };
        let mut edges = 0;
        for at in 0..side * side {
            if at % side + 1 < side {
                edges += apart(at, at + 1);
            }
            if at + side < side * side {
                edges += apart(at, at + side);
            }
        }
        edges
    }
}

impl DepthSource for Maps {
    fn resolution(&self) -> Resolution {
        self.resolution
    }

    fn light(&self) -> Option<LightSpace> {
        self.light
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        let side = tile.side as usize;
        for (row, (enter, exit)) in
            (tile.y..).zip(enter.chunks_mut(side).zip(exit.chunks_mut(side)))
        {
            let at = self.at(tile.x, row);
            enter.copy_from_slice(&self.enter[at..at + side]);
            exit.copy_from_slice(&self.exit[at..at + side]);
        }
        Ok(Exits::Closed)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One rule on a map without edges.
    pub(in super::super) fn example() -> Sizes {
        Sizes {
            resolution: 512,
            edges: 0,
            rows: vec![SizeRow {
                rule: "2015",
                bytes: [3000, 1000],
                seconds: [0.1, 0.4],
            }],
        }
    }

    #[test]
    fn silhouettes_are_where_depths_have_nothing_in_common() {
        let side = 256_usize;
        let column = |i: usize| u32::from(i % side >= 100);
        // A step from [0, 10] to [20, 30] along a column, and one that overlaps.
        let maps = Maps {
            resolution: Resolution::new(256).unwrap(),
            light: None,
            enter: (0..side * side).map(|i| 20 * column(i)).collect(),
            exit: (0..side * side)
                .map(|i| 10 + 20 * column(i) + u32::from(i >= side * side / 2) * 10)
                .collect(),
        };
        assert_eq!(maps.silhouette_edges(), 128);
    }
}
