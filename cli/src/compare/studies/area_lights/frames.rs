//! One frame of an area light, with every number a choice.

use std::time::Instant;

use gpu_backend::{Cpu, Host};
use lighting::airlight::EquiAngular;
use lighting::area::{GatherMany, LightVolumes, ManyLights};
use lighting::scene::Pattern;
use lighting::shadow_map::{
    CasterPoints, Casters, LevelOfDetail, RenderImperfectMaps, RenderShadowMapAtlas, ShadowMapAtlas,
};
use lighting::voxelized::{Detail, Resolution, Sampling};
use lighting::{Emitter, Interleaving};
use reference::metrics::{Reference, image_error};

use super::Scene;
use crate::failure::Failure;

/// Points that stand for the casters, of which each light takes some.
pub(super) const CASTER_POINTS: u32 = 1 << 17;

/// How shadow maps are made.
#[derive(Debug, Clone, Copy)]
pub(super) enum Maps {
    /// From the triangles.
    Exact,
    /// From this many points.
    Imperfect(u32, LevelOfDetail),
}

/// How a frame is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    pub(super) lights: u32,
    /// Texels per side of each shadow map.
    pub(super) map: u32,
    /// Voxels along α and θ, and bits of φ.
    pub(super) voxels: [u32; 2],
    pub(super) maps: Maps,
    pub(super) detail: Detail,
    pub(super) interpolate: bool,
}

/// The paper's setting, with the lit runs of exact maps.
impl Default for Setting {
    fn default() -> Self {
        Self {
            lights: 128,
            map: 128,
            voxels: [128, 128],
            maps: Maps::Exact,
            detail: Detail::Runs,
            interpolate: true,
        }
    }
}

/// Error and time of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outcome {
    pub(super) rmse: f64,
    /// Time of the maps, of the voxels, and of the gather.
    pub(super) seconds: [f64; 3],
}

impl Setting {
    /// The lights.
    pub(super) fn emitters(&self, scene: Scene<'_>) -> Result<Vec<Emitter>, Failure> {
        Ok(scene.light.virtual_lights(Pattern::Lattice, self.lights)?)
    }

    /// Their shadow maps, and the time for these without the part that all lights share.
    pub(super) fn maps(
        &self,
        cpu: &Cpu,
        scene: Scene<'_>,
        lights: &[Emitter],
    ) -> Result<(ShadowMapAtlas<Host>, f64), Failure> {
        match self.maps {
            Maps::Exact => {
                let casters = Casters::upload(cpu, scene.geometry)?;
                let clock = Instant::now();
                let maps = cpu.shadow_map_atlas(&casters, lights, self.map)?;
                Ok((maps, clock.elapsed().as_secs_f64()))
            }
            Maps::Imperfect(points, level) => {
                let casters = CasterPoints::sample(cpu, scene.geometry, CASTER_POINTS)?;
                let clock = Instant::now();
                let maps = cpu.imperfect_maps(&casters, lights, self.map, points, level)?;
                Ok((maps, clock.elapsed().as_secs_f64()))
            }
        }
    }

    /// Room for the voxels.
    pub(super) fn volumes(&self, cpu: &Cpu) -> Result<LightVolumes<Host>, Failure> {
        let [side, bits] = self.voxels;
        let resolution = Resolution::new(side, side, bits)?;
        let sampling = Sampling {
            interpolate: self.interpolate,
            ..Sampling::UNBIASED
        };
        Ok(LightVolumes::new(cpu, resolution, self.lights as usize)?.with_sampling(sampling))
    }

    /// The error and the time of the frame.
    pub(super) fn error(
        &self,
        cpu: &Cpu,
        scene: Scene<'_>,
        truth: &Reference,
    ) -> Result<Outcome, Failure> {
        let lights = self.emitters(scene)?;
        let (maps, map_seconds) = self.maps(cpu, scene, &lights)?;
        let mut volumes = self.volumes(cpu)?;
        let clock = Instant::now();
        volumes.update(cpu, &lights, &scene.eye, &maps)?;
        let voxel_seconds = clock.elapsed().as_secs_f64();
        let rays = scene.rays.to_vec();
        let mut radiance = vec![[0.0; 4]; rays.len()];
        let many = ManyLights {
            rays: &rays,
            emitters: &lights,
            medium: scene.medium,
            detail: self.detail,
            interleaving: Interleaving::NONE,
        };
        let clock = Instant::now();
        cpu.gather_many(&many, &volumes, &self.airlight()?, &mut radiance)?;
        let seconds = [map_seconds, voxel_seconds, clock.elapsed().as_secs_f64()];
        Ok(Outcome {
            rmse: image_error(&radiance, truth).rmse,
            seconds,
        })
    }

    /// The quadrature that the methods of the report use with this detail.
    pub(super) fn airlight(&self) -> Result<EquiAngular, Failure> {
        Ok(EquiAngular::new(match self.detail {
            Detail::Average => 8,
            Detail::Voxels => 1,
            Detail::Runs => 4,
        })?)
    }
}
