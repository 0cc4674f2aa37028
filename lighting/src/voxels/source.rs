//! What a gather reads from the voxels of a ray.

use gpu_backend::{Host, Memory};
use voxel_shadow::ShadowVolume;

use super::VoxelVolume;
use super::volume::State;
use crate::{Interval, LightPath, LitInterval, VisibilitySource};

/// What is read from the voxels of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Detail {
    /// The paper's gather: the share of voxels that are lit, as the visibility
    /// of all of the ray. Right where shadow and light are mixed evenly along it
    /// or the light of each voxel is the same; cheapest.
    Average,
    /// A part for each lit voxel: with an evaluator of one sample, a sum with a
    /// weight for each bit.
    Voxels,
    /// A part for each run of lit voxels: as few evaluations as can be, and
    /// exact but for the ends of runs.
    #[default]
    Runs,
}

/// The lit parts of rays, from a [`VoxelVolume`].
#[derive(Debug)]
pub struct VoxelShadow<'a, M: Memory> {
    pub(super) volume: &'a VoxelVolume<M>,
    pub(super) detail: Detail,
}

impl<M: Memory> Clone for VoxelShadow<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Memory> Copy for VoxelShadow<'_, M> {}

impl<'a, M: Memory> VoxelShadow<'a, M> {
    /// The voxels.
    pub fn volume(&self) -> &'a VoxelVolume<M> {
        self.volume
    }

    /// What is read from them.
    pub fn detail(&self) -> Detail {
        self.detail
    }
}

impl VisibilitySource for VoxelShadow<'_, Host> {
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let span = path.span();
        let lattice = match self.volume.state() {
            State::Lit => {
                lit.push(LitInterval::unshadowed(span.start, span.end));
                return;
            }
            State::Dark => return,
            State::Voxels(lattice) => lattice,
        };
        let volume = ShadowVolume::new(lattice, self.volume.grid(), self.volume.sampling());
        // They were checked when the voxels were made.
        let Ok(volume) = volume else { return };
        let ray = path.ray();
        let shadow = volume.ray_shadow(ray.direction(), ray.length().min(f32::MAX));
        let mut push = |part: voxel_shadow::LitInterval| {
            // The sky begins at f32::MAX.
            let end = if part.end < f32::MAX {
                part.end
            } else {
                f32::INFINITY
            };
            let (start, end) = (part.start.max(span.start), end.min(span.end));
            if start < end {
                lit.push(LitInterval {
                    interval: Interval::new(start, end),
                    visibility: part.visibility,
                });
            }
        };
        match self.detail {
            Detail::Average => {
                let end = span.end.min(f32::MAX);
                let visibility = shadow.lit_fraction_between(span.start, end);
                if visibility > 0.0 {
                    push(voxel_shadow::LitInterval {
                        start: span.start,
                        end,
                        visibility,
                    });
                }
            }
            Detail::Voxels => shadow.lit_voxels().for_each(push),
            Detail::Runs => shadow.lit_runs().for_each(push),
        }
    }
}
