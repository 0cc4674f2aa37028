//! How far behind a blocker its voxelized shadow begins.

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use indicatif::ProgressBar;
use lighting::shadow_map::ShadowMap;
use lighting::voxelized::{Resolution, Sampling, VoxelVolume};
use lighting::{Emitter, Ray};
use voxel_shadow::ShadowVolume;

use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;

/// Resolutions of α.
pub(super) const ALPHAS: &[u32] = &[64, 128, 256, 512, 1024];

/// About how many light rays are followed.
const LIGHT_RAYS: usize = 2000;

/// Metres along the light between a blocker and its shadow.
#[derive(Debug, Clone)]
struct Detachment {
    alpha: u32,
    /// Median and 90th percentile over light rays, with the paper's bias and
    /// with none.
    paper: [f64; 2],
    unbiased: [f64; 2],
}

/// The lengths at one resolution of α after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Detachments(Vec<Detachment>);

impl Detachments {
    /// Records the lengths, and shows them in a table.
    pub(super) fn describe(&self, study: &mut Study) {
        if self.0.is_empty() {
            return;
        }
        let mut columns = vec![Column::plain("α")];
        let names = ["bias −2.25: median", "90 %", "no bias: median", "90 %"];
        columns.extend(names.map(|name| Column::new(name, Unit::With(" m"))));
        let mut table = Table::new(columns).titled(
            "Where shadows begin",
            "The quantity of figure 7 of Wyman and Dai 2013: the distance in metres, along the light, between a blocker and its shadow; median and 90th percentile over light rays that meet a blocker in view.",
        );
        for row in &self.0 {
            for (of, [median, most]) in
                [("the paper's biases", row.paper), ("no bias", row.unbiased)]
            {
                record(study, "metres detached median", of, row.alpha, median);
                record(study, "metres detached 90 %", of, row.alpha, most);
            }
            let mut cells: Vec<Cell> = vec![row.alpha.into()];
            let lengths = row.paper.into_iter().chain(row.unbiased);
            cells.extend(lengths.map(Cell::from));
            table.push(cells);
        }
        study.parts.push(Part::Table(table));
    }
}

/// All resolutions of α, as far as the time allows, from a shadow map and with
/// the other resolutions at the `finest`.
pub(super) fn measure(
    cpu: &Cpu,
    scene: Scene<'_>,
    (map, finest): (&ShadowMap<Host>, u32),
    (study, limit, bar): (&mut Study, &Limit<'_>, &ProgressBar),
) -> Result<Detachments, Failure> {
    let mut found = Detachments::default();
    for &alpha in ALPHAS {
        if let Some(why) = limit.reached() {
            study.leave_out("detachment at finer α", why);
            break;
        }
        let resolution = Resolution::new(alpha, finest, finest)?;
        found.0.extend(detachment(cpu, scene, map, resolution)?);
        bar.inc(1);
    }
    Ok(found)
}

/// `None` if no light ray meets anything in view.
fn detachment(
    cpu: &Cpu,
    scene: Scene<'_>,
    map: &ShadowMap<Host>,
    resolution: Resolution,
) -> Result<Option<Detachment>, Failure> {
    let mut volume = VoxelVolume::new(cpu, resolution)?;
    volume.update(cpu, scene.emitter, &scene.eye, map)?;
    let Some(lattice) = volume.lattice_in_use() else {
        return Ok(None);
    };
    let shadows = [Sampling::PAPER, Sampling::UNBIASED]
        .map(|sampling| ShadowVolume::new(lattice, volume.grid(), sampling));
    let [paper, unbiased] = shadows;
    let shadows = [paper?, unbiased?];
    let bounds = scene.geometry.bounds();
    let size = bounds.min().distance(bounds.max());
    let (theta, bits) = (resolution.theta() as usize, resolution.bits() as usize);
    let stride = (theta * bits / LIGHT_RAYS).max(1) | 1;
    let mut lengths = [Vec::new(), Vec::new()];
    for index in (0..theta * bits).step_by(stride) {
        let bit = index % bits;
        let light = lattice.light_ray(index / bits, bit);
        let [start, direction] = [light.origin, light.direction].map(Vec3::from);
        // The start of a parallel light ray is moved in front of all casters.
        let back = if matches!(scene.emitter, Emitter::Directional(_)) {
            size + start.distance(bounds.min())
        } else {
            0.0
        };
        let origin = start - back * direction;
        let Some(ray) = Ray::new(origin, direction, f32::INFINITY) else {
            continue;
        };
        let Some(hit) = scene.tracer.closest_hit(&ray) else {
            continue;
        };
        let first = hit.distance - back;
        let row = lattice.blocked_from(bit, first);
        if row == 0 || row >= resolution.alpha() {
            continue;
        }
        for (shadow, lengths) in shadows.iter().zip(&mut lengths) {
            let lit = |behind: f32| shadow.visibility(start + (first + behind) * direction) > 0.5;
            lengths.push(f64::from(last_lit(lit, size)));
        }
    }
    let [Some(paper), Some(unbiased)] = lengths.map(percentiles) else {
        return Ok(None);
    };
    Ok(Some(Detachment {
        alpha: resolution.alpha(),
        paper,
        unbiased,
    }))
}

/// The position at which a light ray turns dark, at most `most`. It is found by halving, because
/// light does not come back along a light ray.
fn last_lit(lit: impl Fn(f32) -> bool, most: f32) -> f32 {
    let (mut low, mut high) = (0.0, most);
    if !lit(low) {
        return 0.0;
    }
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if lit(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Median and 90th percentile.
fn percentiles(mut values: Vec<f64>) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * (values.len().max(1) - 1) as f64).round();
        values.get(index as usize).copied()
    };
    Some([at(0.5)?, at(0.9)?])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One resolution.
    pub(in super::super) fn example() -> Detachments {
        Detachments(vec![Detachment {
            alpha: 64,
            paper: [0.2, 0.3],
            unbiased: [0.01, 0.1],
        }])
    }

    #[test]
    fn the_end_of_light_is_found_and_limited() {
        assert_eq!(last_lit(|_| false, 8.0), 0.0);
        assert_eq!(last_lit(|_| true, 8.0), 8.0);
        assert!((last_lit(|x| x < 0.3, 8.0) - 0.3).abs() < 1e-5);
    }

    #[test]
    fn percentiles_are_of_what_there_is() {
        assert_eq!(percentiles(Vec::new()), None);
        assert_eq!(percentiles(vec![2.0]), Some([2.0, 2.0]));
        let values = (0..=10).rev().map(f64::from).collect();
        assert_eq!(percentiles(values), Some([5.0, 9.0]));
    }
}
