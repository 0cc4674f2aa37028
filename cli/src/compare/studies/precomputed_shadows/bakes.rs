//! Whole bakes of precomputed voxelized shadows, from triangles to a packed
//! file.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use gpu_backend::Cpu;
use lighting::precomputed::{Builder, Form, Resolution, surfaces};
use lighting::scene::Geometry;
use shadow_dag::{Error, LightSpace};

use super::record;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// One bake.
#[derive(Debug, Clone)]
pub(super) struct Bake {
    pub(super) resolution: u32,
    /// Seconds and peak memory of each of [`STAGES`]; the memory only if the system tells it.
    stages: [(f64, Option<u64>); 4],
    /// Size of the packed file.
    bytes: u64,
}

/// The stages of a bake, in order.
const STAGES: [&str; 4] = ["sort triangles", "tiles", "put together", "pack"];

impl Bake {
    pub(super) fn seconds(&self) -> f64 {
        self.stages.iter().map(|stage| stage.0).sum()
    }

    /// Bakes a light; `None` if `stop` is set before it is done.
    pub(super) fn measure(
        geometry: &Geometry,
        light: LightSpace,
        resolution: Resolution,
        stop: &AtomicBool,
    ) -> Result<Option<Self>, Failure> {
        let cpu = Cpu::new();
        let mut stage = Stage::begin();
        let mesh = surfaces(geometry)?.seen_from(light, resolution);
        let sorted = stage.next();
        let mut bake = shadow_dag::Bake::of_mesh(Builder::new(), &mesh);
        match bake.advance(&cpu, usize::MAX, stop, |_| {}) {
            Err(Error::Cancelled { .. }) => return Ok(None),
            result => result?,
        };
        let made = stage.next();
        let plain = bake.finish()?;
        let joined = stage.next();
        let bytes = plain.to_form(Form::Packed)?.as_bytes().len() as u64;
        Ok(Some(Self {
            resolution: resolution.side(),
            stages: [sorted, made, joined, stage.next()],
            bytes,
        }))
    }
}

/// Records the bakes, and shows them in a table.
pub(super) fn describe(study: &mut Study, bakes: &[Bake]) {
    if bakes.is_empty() {
        return;
    }
    let mut columns = vec![Column::new("voxels", Unit::With("³"))];
    columns.extend(STAGES.map(|stage| Column::new(stage, Unit::Seconds)));
    columns.extend([
        Column::new("all", Unit::Seconds),
        Column::new("growth", Unit::With("×")),
        Column::new("most memory", Unit::Bytes),
        Column::new("packed file", Unit::Bytes),
        Column::plain("16-bit map / file"),
    ]);
    let mut table = Table::new(columns).titled(
        "From triangles to a file",
        "As far as the time allows. Growth is that of the whole over the bake of half the resolution. \
Memory is the most that the whole program held during a stage, the scene and all that the comparison keeps included; systems other than Linux do not tell.",
    );
    let mut previous: Option<&Bake> = None;
    for bake in bakes {
        for (name, (seconds, peak)) in STAGES.iter().zip(bake.stages) {
            record(study, "bake", name, bake.resolution, ("seconds", seconds));
            if let Some(peak) = peak {
                record(study, "bake", name, bake.resolution, ("bytes", peak as f64));
            }
        }
        let size = ("bytes", bake.bytes as f64);
        record(study, "file packed", "", bake.resolution, size);
        let mut cells: Vec<Cell> = vec![bake.resolution.into()];
        cells.extend(bake.stages.map(|stage| Cell::from(stage.0)));
        let growth = |previous: &Bake| (bake.seconds() / previous.seconds()).into();
        let memory = bake.stages.iter().filter_map(|stage| stage.1).max();
        let map = 2.0 * f64::from(bake.resolution).powi(2);
        cells.extend([
            bake.seconds().into(),
            previous.map_or("–".into(), growth),
            memory.map_or("not known".into(), Cell::from),
            bake.bytes.into(),
            (map / bake.bytes as f64).into(),
        ]);
        table.push(cells);
        previous = Some(bake);
    }
    study.parts.push(Part::Table(table));
}

/// Time and memory of one stage after the other.
struct Stage(Instant);

impl Stage {
    fn begin() -> Self {
        forget_peak();
        Self(Instant::now())
    }

    /// Time and memory of the stage that ends now.
    fn next(&mut self) -> (f64, Option<u64>) {
        let stage = (self.0.elapsed().as_secs_f64(), peak());
        forget_peak();
        self.0 = Instant::now();
        stage
    }
}

/// The peak memory of the process since [`forget_peak`], bytes. Only Linux tells it.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Forgets the peak memory so far, where the system can.
fn forget_peak() {
    // If it cannot, the peak includes earlier work.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Two bakes, one of which does not know its memory.
    pub(in super::super) fn example() -> Vec<Bake> {
        [(2048, None), (4096, Some(1 << 30))]
            .map(|(resolution, memory)| Bake {
                resolution,
                stages: [(0.1, None), (0.2, memory), (0.01, None), (0.02, None)],
                bytes: 4000,
            })
            .to_vec()
    }

    #[test]
    fn a_bake_that_is_interrupted_is_none() {
        use crate::compare::studies::tests::Stand;
        use lighting::precomputed::light_spaces;
        use lighting::scene::procedural::Embedded;

        let stand = Stand::of(Embedded::Coil);
        let resolution = Resolution::new(256).unwrap();
        let bake = |stop| {
            let spaces = light_spaces(&stand.geometry, &stand.emitters[0], resolution);
            let light = spaces.unwrap().swap_remove(0);
            Bake::measure(&stand.geometry, light, resolution, &AtomicBool::new(stop)).unwrap()
        };
        assert!(bake(true).is_none());
        assert!(bake(false).unwrap().bytes > 0);
    }
}
