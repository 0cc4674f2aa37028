//! The airlight of a picture by any setting, on any backend.

use std::cell::RefCell;
use std::time::Instant;

use airlight::{SunTable, Table};
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use gpu_backend::{Backend, BufferOf, Cpu, Download};
use lighting::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use lighting::precomputed::BakedShadow;
use lighting::scene::{Geometry, Medium, PhaseFunction};
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap, face_count};
use lighting::trace::Tracer;
use lighting::translucent::{StoredMap, TransmittanceMap};
use lighting::visibility::{
    Exact, MergeTouching, ShadowMapMarch, Spacing, TransmittanceMarch, Unshadowed,
};
use lighting::voxels::{BuildVoxels, Detail, Eye, Resolution, VoxelShadow, VoxelVolume};
use lighting::{AirlightEvaluator, Emitter, Gather, Ray};

use crate::failure::Failure;
use crate::methods::{Airlight, Setting, Visibility};

/// Why exact visibility is left out on a GPU.
pub(crate) const EXACT_IS_TRACED: &str = "exact visibility is traced on the CPU; it has no shader";

/// Whether a backend finds exact visibility, which takes a tracer.
pub(crate) trait Tracing: Backend {
    /// False if [`Tracing::gather_exact`] always fails.
    const TRACES: bool;

    /// [`Gather::gather`] with exact visibility.
    fn gather_exact<A: AirlightEvaluator>(
        &self,
        rays: &BufferOf<Self, Ray>,
        emitter: &Emitter,
        medium: &Medium,
        visibility: &Exact<'_>,
        airlight: &A,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Failure>;
}

impl Tracing for Cpu {
    const TRACES: bool = true;

    fn gather_exact<A: AirlightEvaluator>(
        &self,
        rays: &BufferOf<Self, Ray>,
        emitter: &Emitter,
        medium: &Medium,
        visibility: &Exact<'_>,
        airlight: &A,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Failure> {
        Ok(self.gather(rays, emitter, medium, visibility, airlight, radiance)?)
    }
}

impl Tracing for Gpu<Queued> {
    const TRACES: bool = false;

    fn gather_exact<A: AirlightEvaluator>(
        &self,
        _: &BufferOf<Self, Ray>,
        _: &Emitter,
        _: &Medium,
        _: &Exact<'_>,
        _: &A,
        _: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Failure> {
        Err(Failure::new(EXACT_IS_TRACED))
    }
}

/// A backend that looks into maps of transmittance.
pub(crate) trait Veils: Backend {
    /// A map where it can.
    type Veil;

    /// Brings a map there.
    fn veil(&self, map: TransmittanceMap) -> Result<Self::Veil, Failure>;
}

impl Veils for Cpu {
    type Veil = TransmittanceMap;

    fn veil(&self, map: TransmittanceMap) -> Result<TransmittanceMap, Failure> {
        Ok(map)
    }
}

impl Veils for Gpu<Queued> {
    type Veil = StoredMap<GpuMemory>;

    fn veil(&self, map: TransmittanceMap) -> Result<StoredMap<GpuMemory>, Failure> {
        Ok(map.upload(self)?)
    }
}

/// A backend that gathers every visibility source that comes from a map
/// or was baked, and none, with the evaluator `A`.
pub(crate) trait GatherMapped<A>:
    Veils
    + Gather<Unshadowed, A>
    + Gather<BakedShadow<<Self as Backend>::Memory>, A>
    + for<'a> Gather<TransmittanceMarch<'a, <Self as Veils>::Veil>, A>
    + for<'a> Gather<VoxelShadow<'a, <Self as Backend>::Memory>, A>
    + for<'a> Gather<ShadowMapMarch<'a, <Self as Backend>::Memory>, A>
    + for<'a> Gather<MergeTouching<ShadowMapMarch<'a, <Self as Backend>::Memory>>, A>
{
}

impl<B, A> GatherMapped<A> for B where
    B: Veils
        + Gather<Unshadowed, A>
        + Gather<BakedShadow<<B as Backend>::Memory>, A>
        + for<'a> Gather<TransmittanceMarch<'a, <B as Veils>::Veil>, A>
        + for<'a> Gather<VoxelShadow<'a, <B as Backend>::Memory>, A>
        + for<'a> Gather<ShadowMapMarch<'a, <B as Backend>::Memory>, A>
        + for<'a> Gather<MergeTouching<ShadowMapMarch<'a, <B as Backend>::Memory>>, A>
{
}

/// A backend that can do all that the program needs.
pub(crate) trait Renderer:
    Download
    + RenderShadowMap
    + BuildVoxels
    + Tracing
    + GatherMapped<Midpoint>
    + GatherMapped<EquiAngular>
    + GatherMapped<Quadrature>
    + GatherMapped<Analytic<Table>>
{
}

impl<B> Renderer for B where
    B: Download
        + RenderShadowMap
        + BuildVoxels
        + Tracing
        + GatherMapped<Midpoint>
        + GatherMapped<EquiAngular>
        + GatherMapped<Quadrature>
        + GatherMapped<Analytic<Table>>
{
}

/// The tables that some settings need, for one phase function.
#[derive(Debug, Default)]
pub(crate) struct Tables {
    /// By size in KiB, with the seconds it took to build.
    own: Vec<(u32, Analytic<Table>, f64)>,
    published: Option<(Analytic<SunTable>, f64)>,
}

/// Tolerance for what tables do not apply to, far below their own.
const REST: f32 = 1e-5;

impl Tables {
    /// Builds what `settings` need.
    pub(crate) fn new(
        phase: PhaseFunction,
        settings: impl Iterator<Item = Setting>,
    ) -> Result<Self, Failure> {
        let mut tables = Self::default();
        for Setting {
            airlight, detail, ..
        } in settings
        {
            let clock = Instant::now();
            let rest = Quadrature::with_tolerance(phase, REST)?;
            if airlight == Airlight::Table && tables.own.iter().all(|own| own.0 != detail) {
                let table = Table::new(&phase, detail)?;
                let seconds = clock.elapsed().as_secs_f64();
                tables
                    .own
                    .push((detail, Analytic::new(table, rest), seconds));
            } else if airlight == Airlight::Published && tables.published.is_none() {
                if phase != PhaseFunction::Isotropic {
                    return Err(Failure::new(PUBLISHED_IS_ISOTROPIC));
                }
                let table = SunTable::new();
                let seconds = clock.elapsed().as_secs_f64();
                tables.published = Some((Analytic::new(table, rest), seconds));
            }
        }
        Ok(tables)
    }

    /// Seconds and bytes of the table of a setting.
    pub(crate) fn cost(&self, setting: Setting) -> (f64, u64) {
        match setting.airlight {
            Airlight::Table => self
                .own(setting.detail)
                .map_or((0.0, 0), |(_, table, seconds)| {
                    (*seconds, table.evaluator().bytes() as u64)
                }),
            Airlight::Published => self
                .published
                .as_ref()
                .map_or((0.0, 0), |(table, seconds)| {
                    (*seconds, table.evaluator().bytes() as u64)
                }),
            _ => (0.0, 0),
        }
    }

    fn own(&self, size: u32) -> Option<&(u32, Analytic<Table>, f64)> {
        self.own.iter().find(|own| own.0 == size)
    }
}

/// Why the published table is left out.
pub(crate) const PUBLISHED_IS_ISOTROPIC: &str =
    "the published table is one of isotropic scattering";

/// Lights and rays on a backend, ready to be gathered.
pub(crate) struct Stage<'a, B: Veils> {
    pub(crate) backend: &'a B,
    pub(crate) tracer: &'a Tracer,
    pub(crate) medium: &'a Medium,
    pub(crate) emitters: &'a [Emitter],
    /// One per emitter, or none if no setting needs them.
    pub(crate) maps: &'a [ShadowMap<B::Memory>],
    /// The same of what hair and smoke let through.
    pub(crate) veils: &'a [B::Veil],
    /// Those of the settings.
    pub(crate) tables: &'a Tables,
    /// Where the rays start, for voxels.
    pub(crate) eye: Eye,
    pub(crate) voxels: &'a Voxels<B>,
    /// Baked shadows by resolution, one per emitter.
    pub(crate) baked: &'a [Held<B>],
    pub(crate) rays: BufferOf<B, Ray>,
    pub(crate) count: usize,
}

/// The baked shadows of all lights at one resolution, on a backend.
#[derive(Debug)]
pub(crate) struct Held<B: Backend> {
    pub(crate) resolution: u32,
    pub(crate) shadows: Vec<BakedShadow<B::Memory>>,
}

impl<B: Backend> Held<B> {
    /// Copies shadows to a backend.
    pub(crate) fn new(
        backend: &B,
        resolution: u32,
        shadows: &[BakedShadow],
    ) -> Result<Self, Failure> {
        let shadows = shadows.iter().map(|shadow| shadow.upload(backend));
        Ok(Self {
            resolution,
            shadows: shadows.collect::<Result<_, _>>()?,
        })
    }
}

/// Memory for voxels that is kept from frame to frame: one volume of each size, which all
/// lights use in turn.
#[derive(Debug)]
pub(crate) struct Voxels<B: Backend>(RefCell<Vec<VoxelVolume<B::Memory>>>);

impl<B: Backend> Default for Voxels<B> {
    fn default() -> Self {
        Self(RefCell::new(Vec::new()))
    }
}

impl<B: BuildVoxels> Voxels<B> {
    /// Calls `use_volume` with a volume of `side` voxels along each coordinate,
    /// but for φ at most 1024 and a multiple of 32.
    fn with(
        &self,
        backend: &B,
        side: u32,
        use_volume: impl FnOnce(&mut VoxelVolume<B::Memory>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let resolution = voxel_resolution(side)?;
        let mut all = self.0.borrow_mut();
        let index = match all.iter().position(|v| v.resolution() == resolution) {
            Some(index) => index,
            None => {
                all.push(VoxelVolume::new(backend, resolution)?);
                all.len() - 1
            }
        };
        use_volume(&mut all[index])
    }

    /// Memory of the volume of a setting, if there is one.
    pub(crate) fn bytes(&self, setting: Setting) -> u64 {
        if setting.visibility.voxel_detail().is_none() {
            return 0;
        }
        let all = self.0.borrow();
        let mut own = all.iter().filter(|volume| {
            voxel_resolution(setting.samples).is_ok_and(|r| r == volume.resolution())
        });
        own.next().map_or(0, VoxelVolume::bytes)
    }
}

/// Voxels along a coordinate, at most: a volume of 2 GiB.
const MAX_VOXELS: u32 = 4096;

fn voxel_resolution(side: u32) -> Result<Resolution, Failure> {
    if side > MAX_VOXELS {
        return Err(Failure::new(format!(
            "{side} voxels a side were asked for (--samples), expected at most {MAX_VOXELS}"
        )));
    }
    let bits = side.next_multiple_of(32).min(1024);
    Ok(Resolution::new(side, side, bits)?)
}

impl<B: Renderer> Stage<'_, B> {
    /// The airlight of every ray, all work done.
    pub(crate) fn airlight(&self, setting: Setting) -> Result<BufferOf<B, [f32; 4]>, Failure> {
        let mut radiance = self.backend.zeros::<[f32; 4]>(self.count)?;
        let phase = self.medium.phase();
        let missing = || Failure::new("a table that was not built");
        match setting.airlight {
            Airlight::Midpoint => self.gather(setting, &Midpoint, &mut radiance)?,
            Airlight::EquiAngular => {
                let quadrature = EquiAngular::new(setting.detail)?;
                self.gather(setting, &quadrature, &mut radiance)?;
            }
            Airlight::Quadrature => {
                let tolerance = 10_f32.powi(-(setting.detail.min(6) as i32));
                let quadrature = Quadrature::with_tolerance(phase, tolerance)?;
                self.gather(setting, &quadrature, &mut radiance)?;
            }
            Airlight::Table => {
                let (_, table, _) = self.tables.own(setting.detail).ok_or_else(missing)?;
                self.gather(setting, table, &mut radiance)?;
            }
            Airlight::Double => {
                let rest = Quadrature::with_tolerance(phase, REST)?;
                let exact = Analytic::new(airlight::Exact::new(phase)?, rest);
                self.gather_exact(setting, &exact, &mut radiance)?;
            }
            Airlight::Published => {
                let (table, _) = self.tables.published.as_ref().ok_or_else(missing)?;
                self.gather_exact(setting, table, &mut radiance)?;
            }
        }
        self.backend.wait()?;
        Ok(radiance)
    }

    /// With exact visibility, which is the one that goes with an evaluator
    /// without a shader.
    fn gather_exact<A: AirlightEvaluator>(
        &self,
        setting: Setting,
        evaluator: &A,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), Failure> {
        if setting.visibility != Visibility::Exact {
            return Err(Failure::new(
                "--airlight double and published go with --visibility exact only",
            ));
        }
        let (backend, exact) = (self.backend, Exact::new(self.tracer));
        for emitter in self.emitters {
            backend.gather_exact(
                &self.rays,
                emitter,
                self.medium,
                &exact,
                evaluator,
                radiance,
            )?;
        }
        Ok(())
    }

    fn gather<A>(
        &self,
        setting: Setting,
        evaluator: &A,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), Failure>
    where
        A: AirlightEvaluator,
        B: GatherMapped<A>,
    {
        let Self {
            backend,
            rays,
            medium,
            ..
        } = self;
        for (index, emitter) in self.emitters.iter().enumerate() {
            let march = |spacing| ShadowMapMarch::new(&self.maps[index], setting.samples, spacing);
            let voxels = |detail, radiance: &mut _| {
                self.voxels.with(*backend, setting.samples, |volume| {
                    volume.update(*backend, emitter, &self.eye, &self.maps[index])?;
                    let source = volume.source(detail);
                    Ok(backend.gather(rays, emitter, medium, &source, evaluator, radiance)?)
                })
            };
            match setting.visibility {
                Visibility::None => {
                    backend.gather(rays, emitter, medium, &Unshadowed, evaluator, radiance)?;
                }
                Visibility::Exact => {
                    let exact = Exact::new(self.tracer);
                    backend.gather_exact(rays, emitter, medium, &exact, evaluator, radiance)?;
                }
                Visibility::March => {
                    let march = march(Spacing::Distance);
                    backend.gather(rays, emitter, medium, &march, evaluator, radiance)?;
                }
                Visibility::EquiAngular => {
                    let march = march(Spacing::EquiAngular);
                    backend.gather(rays, emitter, medium, &march, evaluator, radiance)?;
                }
                Visibility::MarchMerged => {
                    let merged = MergeTouching(march(Spacing::Distance));
                    backend.gather(rays, emitter, medium, &merged, evaluator, radiance)?;
                }
                Visibility::EquiAngularMerged => {
                    let merged = MergeTouching(march(Spacing::EquiAngular));
                    backend.gather(rays, emitter, medium, &merged, evaluator, radiance)?;
                }
                Visibility::Translucent => {
                    let veil = &self.veils[index];
                    let march =
                        TransmittanceMarch::new(veil, setting.samples, Spacing::EquiAngular);
                    backend.gather(rays, emitter, medium, &march, evaluator, radiance)?;
                }
                Visibility::VoxelAverage => voxels(Detail::Average, radiance)?,
                Visibility::VoxelBits => voxels(Detail::Voxels, radiance)?,
                Visibility::VoxelRuns => voxels(Detail::Runs, radiance)?,
                Visibility::Dag => {
                    let mut held = self.baked.iter();
                    let held = held.find(|held| held.resolution == setting.samples);
                    let missing = || Failure::new("shadows that were not baked");
                    let shadow = &held.ok_or_else(missing)?.shadows[index];
                    backend.gather(rays, emitter, medium, shadow, evaluator, radiance)?;
                }
            }
        }
        Ok(())
    }
}

/// The shadow maps of all emitters, in order.
pub(crate) fn shadow_maps<B: RenderShadowMap>(
    backend: &B,
    casters: &Casters<B::Memory>,
    emitters: &[Emitter],
    resolution: u32,
    mut done: impl FnMut(),
) -> Result<Vec<ShadowMap<B::Memory>>, Failure> {
    let mut maps = Vec::with_capacity(emitters.len());
    for emitter in emitters {
        maps.push(backend.shadow_map(casters, emitter, resolution)?);
        done();
    }
    Ok(maps)
}

/// Memory that the shadow maps of all lights may take together.
const MAX_MAP_BYTES: u64 = 1 << 29;

/// The resolution asked for, or less if the maps of all `emitters` would take
/// more than 512 MiB.
pub(crate) fn affordable_resolution(asked: u32, geometry: &Geometry, emitters: &[Emitter]) -> u32 {
    let faces: u64 = emitters
        .iter()
        .map(|e| face_count(geometry, e) as u64)
        .sum();
    let bytes = |side: u32| 4 * faces * u64::from(side) * u64::from(side);
    let mut side = asked;
    while side > 16 && bytes(side) > MAX_MAP_BYTES {
        side /= 2;
    }
    side
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gpu_backend::Cpu;
    use lighting::emitter::Emission;
    use lighting::procedural::Embedded;

    use super::*;

    #[test]
    fn the_maps_of_many_lights_stay_within_their_memory() {
        let geometry = Geometry::new(&Embedded::Fence.build(1)).unwrap();
        let bounds = geometry.bounds();
        let centre = 0.5 * (bounds.min() + bounds.max());
        let light = Emitter::point(centre, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        assert_eq!(
            affordable_resolution(1024, &geometry, std::slice::from_ref(&light)),
            1024
        );
        let many = vec![light; 100];
        let side = affordable_resolution(1024, &geometry, &many);
        let backend = Cpu::new();
        let casters = Casters::upload(&backend, &geometry).unwrap();
        let map = backend.shadow_map(&casters, &many[0], side).unwrap();
        let total = 100 * map.bytes();
        assert!(
            total <= MAX_MAP_BYTES && 4 * total > MAX_MAP_BYTES,
            "{total}"
        );
    }
}
