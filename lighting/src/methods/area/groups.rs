//! The virtual lights of a frame and their shadow maps.

use std::sync::Arc;

use gpu_backend::{Backend, Buffer, Memory};
use voxel_shadow::BuildAtlas;

use crate::Emitter;
use crate::methods::{Frame, FrameInputs, MethodError, OfScene};
use crate::scene::Pattern;
use crate::shadow_map::{
    CasterPoints, FillHoles, LevelOfDetail, RenderImperfectMaps, RenderShadowMapAtlas,
    ShadowMapAtlas,
};
use crate::voxelized::Resolution;

pub(super) const UNIT: &str = "points per area light";

/// The largest number of points per area light.
pub(super) const MOST: u32 = 4096;

/// Texels per side of shadow maps and voxels along each axis, at most: the number that the
/// paper found enough for many lights.
pub(super) const SIDE: u32 = 128;

/// Number of points that represent the casters in imperfect shadow maps, and of points that
/// each light takes of them.
const CASTER_POINTS: u32 = 1 << 16;
pub(super) const POINTS_PER_MAP: u32 = 4096;

/// How the shadow maps are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Maps {
    /// From triangles.
    Exact,
    /// From points; holes are filled from so many levels above.
    Imperfect { levels: u32 },
}

/// A backend that makes maps in all of these ways.
pub(super) trait MakeMaps: RenderShadowMapAtlas + RenderImperfectMaps + FillHoles {}

impl<B: RenderShadowMapAtlas + RenderImperfectMaps + FillHoles> MakeMaps for B {}

/// The virtual lights of a frame with their shadow maps, in groups whose maps and voxels fit on
/// the backend.
#[derive(Debug)]
pub(super) struct Groups<M: Memory>(pub(super) Vec<(Vec<Emitter>, ShadowMapAtlas<M>)>);

/// The key of a scene's groups: points per area light, and how their maps are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct OfAreas {
    pub(super) points: u32,
    pub(super) maps: Maps,
}

/// The lights of a frame: so many points for each area light, other lights unchanged.
pub(super) fn virtual_lights(
    inputs: &FrameInputs<'_>,
    points: u32,
) -> Result<Vec<Emitter>, MethodError> {
    if !(1..=MOST).contains(&points) {
        return Err(MethodError::Quality {
            value: points,
            unit: UNIT,
            expected: format!("1 to {MOST}"),
        });
    }
    let mut lights = Vec::new();
    let mut next = 0;
    for area in inputs.areas {
        let range = &area.emitters;
        lights.extend_from_slice(inputs.emitters.get(next..range.start).unwrap_or_default());
        let own = area.light.virtual_lights(Pattern::Lattice, points);
        lights.extend(own.map_err(MethodError::resource("virtual lights"))?);
        next = range.end;
    }
    lights.extend_from_slice(inputs.emitters.get(next..).unwrap_or_default());
    Ok(lights)
}

pub(super) fn resolution() -> Result<Resolution, MethodError> {
    Resolution::new(SIDE, SIDE, SIDE).map_err(MethodError::resource("voxels of many lights"))
}

impl<M: Memory> Groups<M> {
    /// Makes groups of at most so many lights.
    pub(super) fn make<B>(
        frame: &Frame<'_, B>,
        key: OfAreas,
        most: usize,
    ) -> Result<Self, MethodError>
    where
        B: MakeMaps + Backend<Memory = M>,
    {
        let backend = frame.backend;
        let all = virtual_lights(&frame.inputs, key.points)?;
        let mut groups = Vec::new();
        for lights in all.chunks(most.max(1)) {
            let (done, total) = (groups.len() * most, all.len());
            if !frame.inputs.watch.goes_on(done, total) {
                return Err(MethodError::Stopped { done, total });
            }
            let maps = match key.maps {
                Maps::Exact => backend.shadow_map_atlas(&*frame.casters()?, lights, SIDE),
                Maps::Imperfect { levels } => {
                    let casters = caster_points(frame)?;
                    let level = LevelOfDetail::Near;
                    let maps =
                        backend.imperfect_maps(&casters, lights, SIDE, POINTS_PER_MAP, level);
                    maps.and_then(|mut maps| {
                        backend.fill_holes(&mut maps, levels)?;
                        Ok(maps)
                    })
                }
            };
            let maps = maps.map_err(MethodError::resource("the shadow maps of many lights"))?;
            groups.push((lights.to_vec(), maps));
        }
        Ok(Self(groups))
    }

    /// Number of lights in the largest group; only the last group may have fewer.
    pub(super) fn lights(&self) -> usize {
        self.0.first().map_or(0, |(lights, _)| lights.len())
    }

    pub(super) fn of<B>(
        frame: &Frame<'_, B>,
        points: u32,
        maps: Maps,
    ) -> Result<Arc<Self>, MethodError>
    where
        B: MakeMaps + BuildAtlas + Backend<Memory = M>,
    {
        let key = OfAreas { points, maps };
        let bytes = |all: &Self| all.0.iter().map(|(_, maps)| maps.bytes()).sum();
        let what = "shadow maps of virtual lights";
        frame.store.get(what, key, bytes, || {
            let voxels = frame.backend.atlas_capacity(resolution()?);
            let cubes = frame.backend.map_capacity(SIDE);
            let lights = match maps {
                Maps::Exact => cubes,
                // There is one picture for each light instead of six.
                Maps::Imperfect { .. } => cubes.saturating_mul(6),
            };
            Self::make(frame, key, voxels.min(lights))
        })
    }
}

/// The points that represent the casters.
fn caster_points<B: Backend>(
    frame: &Frame<'_, B>,
) -> Result<Arc<CasterPoints<B::Memory>>, MethodError> {
    let bytes = |points: &CasterPoints<B::Memory>| 16 * points.points().len() as u64;
    frame.store.get("points of casters", OfScene, bytes, || {
        let points = CasterPoints::sample(frame.backend, frame.inputs.geometry, CASTER_POINTS);
        Ok(points?)
    })
}
