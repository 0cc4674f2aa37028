//! Filtered lookups of precomputed voxelized shadows on the surfaces of a
//! picture.

use std::time::Instant;

use glam::{DVec3, Vec3};
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::precomputed::{FilterSize, Form};
use lighting::scene::Geometry;
use lighting::scene::view::View;
use shadow_dag::ShadowDag;

use super::record;
use crate::compare::studies::Subject;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::compare::times::Times;
use crate::failure::Failure;
use crate::parse::Size;

/// Widths of filters.
const WIDTHS: [u32; 3] = [1, 3, 9];

/// Runs of one filter over a picture, and the most time they take together.
const RUNS: usize = 5;
const SECONDS: f64 = 0.6;

/// Shadows on the surfaces of one picture.
#[derive(Debug, Clone)]
pub(super) struct Filters {
    size: Size,
    resolution: u32,
    /// Surfaces within the grid that face the light.
    pub(super) receivers: usize,
    /// Frame times by width of the filter: plain, packed.
    rows: Vec<(u32, [Times; 2])>,
}

impl Filters {
    /// Looks up every receiver of a picture, in both forms of the shadows.
    pub(super) fn measure(
        plain: &ShadowDag,
        subject: &Subject<'_>,
        emitter: &Emitter,
        picture: Size,
    ) -> Result<Self, Failure> {
        let cpu = Cpu::new();
        let Size { width, height } = picture;
        let view = View::new(&cpu, subject.camera, subject.tracer, width, height)?;
        let packed = plain.to_form(Form::Packed)?;
        let resolution = plain.resolution();
        let receivers = receivers(plain, (subject.geometry, &view), emitter);
        let mut rows = Vec::new();
        for width in WIDTHS {
            let size = FilterSize::new(width)?;
            let biased = receivers.iter().map(|(at, normal)| size.bias(*at, *normal));
            let voxels: Vec<_> = biased.collect();
            let mut lit = vec![0.0; voxels.len()];
            let mut time = |dag: &ShadowDag| -> Result<Times, Failure> {
                let mut seconds = Vec::new();
                while seconds.len() < RUNS && seconds.iter().sum::<f64>() < SECONDS {
                    let clock = Instant::now();
                    dag.filter_batch(&cpu, &voxels, size, &mut lit)?;
                    seconds.push(clock.elapsed().as_secs_f64());
                }
                Ok(Times::of(&seconds))
            };
            rows.push((width, [time(plain)?, time(&packed)?]));
        }
        Ok(Self {
            size: picture,
            resolution: resolution.side(),
            receivers: receivers.len(),
            rows,
        })
    }

    /// Records the times, and shows them in a table.
    pub(super) fn describe(&self, study: &mut Study) {
        let mut columns = vec![Column::plain("filter")];
        let names = ["plain", "each", "packed", "each"];
        columns.extend(names.map(|name| Column::new(name, Unit::Seconds)));
        let mut table = Table::new(columns).titled(
            "Shadows on surfaces",
            format!(
                "One lookup for each of the {} pixels of a picture of {} whose surface faces the light, \
in a grid of {}³ voxels, on all threads; of all of them, and of one.",
                self.receivers, self.size, self.resolution
            ),
        );
        for (width, times) in &self.rows {
            let mut cells: Vec<Cell> = vec![format!("{width}×{width}").into()];
            for (form, time) in ["plain", "packed"].iter().zip(times) {
                let setting = format!("{width}x{width} {form}");
                let value = ("seconds", time.median);
                record(study, "filter", &setting, self.resolution, value);
                let each = time.median / self.receivers.max(1) as f64;
                cells.extend([time.median.into(), each.into()]);
            }
            table.push(cells);
        }
        study.parts.push(Part::Table(table));
    }
}

/// Positions and normals, in the grid, of the surfaces that face the light within its map.
///
/// Surfaces beside the map belong to another grid or are lit, so that nothing is looked up there.
fn receivers(
    dag: &ShadowDag,
    (geometry, view): (&Geometry, &View),
    emitter: &Emitter,
) -> Vec<(DVec3, Vec3)> {
    let resolution = dag.resolution();
    let side = f64::from(resolution.side());
    let surfaces = view.rays().iter().zip(view.hits());
    surfaces
        .filter_map(|(ray, hit)| {
            let hit = hit.as_ref()?;
            let [a, b, c] = geometry.triangles()[hit.triangle as usize];
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let point = ray.at(hit.distance);
            let to_light = match emitter {
                Emitter::Directional(sun) => -sun.direction(),
                Emitter::Point(light) => light.position() - point,
            };
            let space = dag.light()?;
            let position = space.voxel(resolution, point)?;
            let is_within = [position.x, position.y]
                .iter()
                .all(|at| (0.0..side).contains(at))
                && position.z >= 0.0;
            (is_within && normal.dot(to_light) > 0.0)
                .then(|| (position, space.normal(point, normal)))
        })
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use lighting::precomputed::{Builder, Resolution, light_spaces, surfaces};
    use lighting::scene::procedural::Embedded;

    use super::*;
    use crate::compare::studies::tests::Stand;

    /// One width, on a picture of nothing.
    pub(in super::super) fn example() -> Filters {
        Filters {
            size: Size {
                width: 4,
                height: 2,
            },
            resolution: 512,
            receivers: 0,
            rows: vec![(9, [Times::of(&[1e-3]), Times::of(&[2e-3])])],
        }
    }

    #[test]
    fn receivers_are_surfaces_within_the_grid() {
        let stand = Stand::of(Embedded::Coil);
        let (geometry, emitter) = (&stand.geometry, &stand.emitters[0]);
        let (cpu, resolution) = (Cpu::new(), Resolution::new(64).unwrap());
        let view = View::new(&cpu, &stand.camera, &stand.tracer, 160, 90).unwrap();
        let spaces = light_spaces(geometry, emitter, resolution).unwrap();
        assert_eq!(spaces.len(), 6);
        let mut all = 0;
        for space in spaces {
            let mesh = surfaces(geometry).unwrap().seen_from(space, resolution);
            let dag = Builder::new().bake(&cpu, &mesh).unwrap();
            let found = receivers(&dag, (geometry, &view), emitter);
            for (at, _) in &found {
                let on_map = at.min_element() >= 0.0 && at.x.max(at.y) < 64.0;
                assert!(on_map, "{at}");
            }
            all += found.len();
        }
        // Each is in one of the grids, but on their rims.
        let seen = view.hits().iter().flatten().count();
        assert!(all > 0 && all <= seen, "{all} of {seen}");
    }
}
