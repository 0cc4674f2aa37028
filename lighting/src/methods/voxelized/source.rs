//! What a gather reads from the voxels along a ray.

use std::borrow::Borrow;
use std::marker::PhantomData;

use gpu_backend::{Host, Memory};
use voxel_shadow::ShadowVolume;

use super::{State, VoxelVolume};
use crate::{Interval, LightPath, LitInterval, VisibilitySource};

/// What is read from the voxels along a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Detail {
    /// The share of voxels that are lit, as the visibility of the whole ray, which is the
    /// paper's gather. It is right if shadow and light are mixed evenly along the ray, or if
    /// all voxels have the same light. It is the cheapest.
    Average,
    /// One part for each lit voxel. With an evaluator of one sample, this is a sum with a
    /// weight for each bit.
    Voxels,
    /// One part for each run of lit voxels. This needs the fewest evaluations and is exact
    /// except at the ends of runs.
    #[default]
    Runs,
}

/// The lit parts of rays, from a [`VoxelVolume`] that is borrowed or shared.
#[derive(Debug, Clone, Copy)]
pub struct VoxelShadow<V, M> {
    volume: V,
    detail: Detail,
    memory: PhantomData<fn() -> M>,
}

impl<V: Borrow<VoxelVolume<M>>, M: Memory> VoxelShadow<V, M> {
    /// Reads `volume` in this detail.
    pub fn new(volume: V, detail: Detail) -> Self {
        Self {
            volume,
            detail,
            memory: PhantomData,
        }
    }

    /// The voxels.
    pub fn volume(&self) -> &VoxelVolume<M> {
        self.volume.borrow()
    }

    /// What is read from them.
    pub fn detail(&self) -> Detail {
        self.detail
    }

    /// Returns the volume as it was given.
    pub fn into_volume(self) -> V {
        self.volume
    }
}

impl<V: Borrow<VoxelVolume<Host>> + Sync> VisibilitySource for VoxelShadow<V, Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let span = path.span();
        let lattice = match self.volume().state() {
            State::Lit => {
                lit.push(LitInterval::unshadowed(span.start, span.end));
                return;
            }
            State::Dark => return,
            State::Voxels(lattice) => lattice,
        };
        let volume = ShadowVolume::new(lattice, self.volume().grid(), self.volume().sampling());
        // It was checked when the voxels were made.
        let Ok(volume) = volume else { return };
        self.detail.lit_parts(&volume, path, lit);
    }
}

impl Detail {
    /// Appends the lit parts of a path.
    pub(crate) fn lit_parts(
        self,
        volume: &ShadowVolume<'_, Host>,
        path: &LightPath<'_>,
        lit: &mut Vec<LitInterval>,
    ) {
        let span = path.span();
        let ray = path.ray();
        let shadow = volume.ray_shadow(ray.direction(), ray.length().min(f32::MAX));
        let mut push = |part: voxel_shadow::LitInterval| {
            // A ray to the sky ends at f32::MAX or beyond.
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
        match self {
            Self::Average => {
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
            Self::Voxels => shadow.lit_voxels().for_each(push),
            Self::Runs => shadow.lit_runs().for_each(push),
        }
    }
}
