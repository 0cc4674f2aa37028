//! From which of its resolutions the error of a voxelized shadow volume comes.

use std::collections::HashMap;

use gpu_backend::{Cpu, Host};
use indicatif::ProgressBar;
use lighting::airlight::EquiAngular;
use lighting::shadow_map::ShadowMap;
use lighting::voxelized::{Detail, Resolution, Sampling, VoxelVolume};
use lighting::{Gather, LitRays, Ray};
use reference::metrics::image_error;
use reference::oracle::image::Reference;

use super::{Scene, record};
use crate::compare::studies::Limit;
use crate::compare::study::{Cell, Column, Part, Study, Table, Unit};
use crate::failure::Failure;
use crate::format::error;

/// The resolution that varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    Map,
    Phi,
    Theta,
    Alpha,
    All,
}

impl Axis {
    const ALL: [Self; 5] = [Self::Map, Self::Phi, Self::Theta, Self::Alpha, Self::All];

    /// Its name in a table.
    fn name(self) -> &'static str {
        match self {
            Self::Map => "shadow map",
            Self::Phi => "φ",
            Self::Theta => "θ",
            Self::Alpha => "α",
            Self::All => "all",
        }
    }
}

/// RMSE over the mean radiance, with one resolution other than the rest.
#[derive(Debug, Clone)]
struct Refinement {
    axis: Axis,
    size: u32,
    /// With all others at the coarsest size, and at the finest.
    rest_coarse: f64,
    rest_fine: f64,
}

/// The errors of one axis after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Refinements {
    rows: Vec<Refinement>,
    /// The finest size, and the RMSE with the paper's biases and without at it.
    finest: u32,
    biased: f64,
    unbiased: f64,
}

/// Rays, their true radiance, and a shadow map of twice each size.
pub(super) struct Picture<'a> {
    pub(super) scene: Scene<'a>,
    pub(super) rays: &'a Vec<Ray>,
    pub(super) truth: &'a Reference,
    pub(super) maps: &'a [ShadowMap<Host>],
    pub(super) sizes: &'a [u32],
}

impl Picture<'_> {
    /// All axes, as far as the time allows.
    pub(super) fn measure(
        &self,
        cpu: &Cpu,
        study: &mut Study,
        limit: &Limit<'_>,
        bar: &ProgressBar,
    ) -> Result<Refinements, Failure> {
        let (sizes, last) = (self.sizes, self.sizes.len() - 1);
        let mut found = Refinements {
            finest: sizes[last],
            ..Refinements::default()
        };
        // Axes share their ends.
        let mut known: HashMap<[usize; 4], f64> = HashMap::new();
        let mut error = |at: [usize; 4]| -> Result<f64, Failure> {
            if let Some(error) = known.get(&at) {
                return Ok(*error);
            }
            let error = self.error(cpu, at, Sampling::UNBIASED)?;
            known.insert(at, error);
            Ok(error)
        };
        for axis in Axis::ALL {
            if let Some(why) = limit.reached() {
                study.leave_out(&format!("other resolutions of {}", axis.name()), why);
                continue;
            }
            for (index, &size) in sizes.iter().enumerate() {
                let with = |rest: usize| {
                    [Axis::Map, Axis::Phi, Axis::Theta, Axis::Alpha].map(|other| {
                        if axis == other || axis == Axis::All {
                            index
                        } else {
                            rest
                        }
                    })
                };
                found.rows.push(Refinement {
                    axis,
                    size,
                    rest_coarse: error(with(0))?,
                    rest_fine: error(with(last))?,
                });
                bar.inc(1);
            }
        }
        found.unbiased = error([last; 4])?;
        found.biased = self.error(cpu, [last; 4], Sampling::PAPER)?;
        Ok(found)
    }

    /// The RMSE of a sum over voxels, which any light takes, at these places of
    /// the sizes: shadow map, φ, θ, α.
    fn error(
        &self,
        cpu: &Cpu,
        [map, phi, theta, alpha]: [usize; 4],
        sampling: Sampling,
    ) -> Result<f64, Failure> {
        let Scene {
            emitter,
            eye,
            medium,
            ..
        } = self.scene;
        let sizes = self.sizes;
        let resolution = Resolution::new(sizes[alpha], sizes[theta], sizes[phi])?;
        let mut volume = VoxelVolume::new(cpu, resolution)?.with_sampling(sampling);
        volume.update(cpu, emitter, &eye, &self.maps[map])?;
        let mut radiance = vec![[0.0; 4]; self.rays.len()];
        let (source, one) = (volume.source(Detail::Voxels), EquiAngular::new(1)?);
        let lit = LitRays::new(self.rays, emitter, medium);
        cpu.gather(&lit, &source, &one, &mut radiance)?;
        Ok(image_error(&radiance, self.truth).rmse)
    }
}

impl Refinements {
    /// Records the errors, and shows them in a table.
    pub(super) fn describe(&self, study: &mut Study) {
        for row in &self.rows {
            let axis = row.axis.name();
            record(study, "rmse rest coarse", axis, row.size, row.rest_coarse);
            record(study, "rmse rest fine", axis, row.size, row.rest_fine);
        }
        if !self.rows.is_empty() {
            let (biased, unbiased) = (self.biased, self.unbiased);
            record(study, "rmse", "the paper's biases", self.finest, biased);
            record(study, "rmse", "no bias", self.finest, unbiased);
        }
        // The time may not have sufficed for all axes.
        let measured = |axis: Axis| self.rows.iter().filter(move |row| row.axis == axis);
        let Some(first) = self.rows.first() else {
            return;
        };
        let sizes: Vec<u32> = measured(first.axis).map(|row| row.size).collect();
        let (coarsest, finest) = (first.size, self.finest);
        let mut columns = vec![Column::plain("varied"), Column::plain("the rest")];
        columns.extend(
            sizes
                .iter()
                .map(|size| Column::new(size.to_string(), Unit::Share)),
        );
        let mut table = Table::new(columns).titled(
            "Which resolution the error comes from",
            format!(
                "The sweep of figure 8 of Wyman and Dai 2013. The shadow map has twice as many texels per side. A row in which all coordinates but one are at {finest} shows the error that this one adds; a row in which all but one are at {coarsest} shows what refining it alone gains."
            ),
        );
        table.grouped = true;
        for axis in Axis::ALL
            .into_iter()
            .filter(|axis| measured(*axis).next().is_some())
        {
            let mut add = |rest: Cell, value: fn(&Refinement) -> f64| {
                let mut cells = vec![axis.name().into(), rest];
                cells.extend(measured(axis).map(|row| Cell::from(value(row))));
                table.push(cells);
            };
            // If all vary together, there are no others.
            if axis == Axis::All {
                add("".into(), |row| row.rest_coarse);
            } else {
                add(coarsest.into(), |row| row.rest_coarse);
                add(finest.into(), |row| row.rest_fine);
            }
        }
        study.parts.push(Part::Table(table));
        study.parts.push(Part::Note(format!(
            "With the biases of the paper (α −2.25 voxels, φ −1), which keep surfaces from shadowing themselves, the error at {finest} is {}; without a bias, as in all methods of this report, {}.",
            error(self.biased, false),
            error(self.unbiased, false)
        )));
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One resolution.
    pub(in super::super) fn example() -> Refinements {
        Refinements {
            rows: Axis::ALL
                .map(|axis| Refinement {
                    axis,
                    size: 64,
                    rest_coarse: 0.1,
                    rest_fine: 0.01,
                })
                .to_vec(),
            finest: 64,
            biased: 0.02,
            unbiased: 0.01,
        }
    }

    #[test]
    fn an_axis_has_a_row_for_each_rest_and_all_axes_together_have_one() {
        let mut study = Study::new("", "", super::super::value_columns());
        example().describe(&mut study);
        let Part::Table(table) = &study.parts[0] else {
            panic!("a table: {:?}", study.parts);
        };
        assert_eq!(table.rows().len(), 2 * 4 + 1);
        assert_eq!(table.rows()[1].cells[2], 0.01.into());
    }
}
