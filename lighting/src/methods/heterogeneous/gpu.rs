//! The gather through media on a GPU.

use airlight::gpu::{PHASE, PhaseRecord};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Assembly;
use gpu_backend::{Backend, Buffer, Error};

use super::memory::MediaMemory;
use super::steps::is_gentle;
use super::{AddEmission, EmittingRays, GatherMedia, MediaRays};
use crate::EyePanes;
use crate::gather::check_lengths;
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{NUMERIC, PANES, PATH, PointSlot};
use crate::scene::gpu::{GridRecord, HeightFogRecord, MEDIA};
use crate::scene::{Media, Medium, PhaseFunction, Profile};

/// Invocations per workgroup.
const GROUP: u32 = 64;

/// The bind group of the visibility's part.
const PARTS: u32 = 1;

/// Entries of the list of records for each grid.
const GRID_RECORDS: usize = 9;

/// Stands for data that a grid or a frame does not have.
const NONE: u32 = u32::MAX;

pub(super) const WALK: &str = include_str!("walk.wgsl");
const STEPS: &str = include_str!("steps.wgsl");
const GATHER: &str = include_str!("gather.wgsl");
const EMISSION: &str = include_str!("emission.wgsl");

/// The sizes of arrays for grids and phase functions on a ray. The smallest one that suffices
/// is used, because each ray has the whole arrays in its registers.
pub(super) const ROOMS: [(usize, &str); 3] = [
    (1, "const light_media_MAX_GRIDS = 1u;"),
    (4, "const light_media_MAX_GRIDS = 4u;"),
    (MAX_GRIDS, "const light_media_MAX_GRIDS = 16u;"),
];

/// The largest number of grids, and of different phase functions, in media on a GPU.
pub const MAX_GRIDS: usize = 16;

/// Why media cannot be used on a GPU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MediaError {
    /// A grid does not fit into a binding in addition to the grids before it.
    #[error(
        "the {what} of grid {grid}, {} x {} x {} samples, take {requested} bytes, but of the \
         {limit} bytes that shaders of this device see at once {room} are left",
        resolution[0], resolution[1], resolution[2]
    )]
    Grid {
        /// Index of the grid.
        grid: usize,
        /// Its samples along x, y and z.
        resolution: [u32; 3],
        /// Which of its data does not fit.
        what: &'static str,
        /// Bytes of these data.
        requested: u64,
        /// Bytes that are left in the binding.
        room: u64,
        /// The limit of a binding, bytes.
        limit: u64,
    },
    /// There are more grids or phase functions than shaders support.
    #[error("there are {count} {what}, at most {MAX_GRIDS} are supported on GPUs")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] Error),
}

/// `light_Media` of `walk.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct MediaRecord {
    pub(super) even: MediumRecord,
    pub(super) height: HeightFogRecord,
    pub(super) low: Vec3,
    pub(super) grids: u32,
    pub(super) high: Vec3,
    pub(super) balls: u32,
    pub(super) first_ball: u32,
    pub(super) first_kind: u32,
    pub(super) first_phase: u32,
    pub(super) phases: u32,
    pub(super) first_box: u32,
    pub(super) boxes: u32,
    pub(super) even_phase: u32,
    pub(super) height_phase: u32,
}

/// `Scene` of `gather.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) emitter: EmitterRecord,
    pub(super) medium: MediumRecord,
    pub(super) rays: u32,
    pub(super) steps: u32,
    pub(super) panes: u32,
    pub(super) is_gentle: u32,
}

/// `Scene` of `emission.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct EmissionScene {
    pub(super) rays: u32,
    pub(super) panes: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

/// Media in the memory of a GPU.
///
/// Densities take 4 bytes per sample, albedos and emissions of samples 12 bytes each, and each
/// cell a bit. All densities are in one binding, and all of these colours in another.
#[derive(Debug)]
pub struct UploadedMedia {
    pub(super) record: MediaRecord,
    pub(super) records: GpuBuffer<[u32; 4]>,
    pub(super) densities: GpuBuffer<f32>,
    pub(super) colours: GpuBuffer<f32>,
    room: &'static str,
    bytes: u64,
    emits: bool,
    fog: Option<Medium>,
}

impl MediaMemory for GpuMemory {
    type Media<'a> = UploadedMedia;
}

/// Data of all grids' samples, in one buffer.
struct Samples {
    what: &'static str,
    numbers: Vec<f32>,
    limit: u64,
}

impl Samples {
    /// Appends the data of a grid, and returns the index of the first value.
    fn add(
        &mut self,
        [grid, len]: [usize; 2],
        resolution: [u32; 3],
        numbers: impl Iterator<Item = f32>,
    ) -> Result<u32, MediaError> {
        const NUMBER: u64 = size_of::<f32>() as u64;
        let first = self.numbers.len();
        let room = self.limit - NUMBER * first as u64;
        let requested = NUMBER * len as u64;
        let too_large = MediaError::Grid {
            grid,
            resolution,
            what: self.what,
            requested,
            room,
            limit: self.limit,
        };
        let Ok(place) = u32::try_from(first + len) else {
            return Err(too_large);
        };
        if requested > room || self.numbers.try_reserve_exact(len).is_err() {
            return Err(too_large);
        }
        self.numbers.extend(numbers);
        Ok(place - len as u32)
    }

    fn upload<E: Encode>(mut self, gpu: &Gpu<E>) -> Result<GpuBuffer<f32>, Error> {
        if self.numbers.is_empty() {
            // A buffer must not be empty.
            self.numbers.push(0.0);
        }
        gpu.upload(&self.numbers)
    }
}

/// The phase functions of media, each once.
#[derive(Default)]
struct Phases(Vec<PhaseFunction>);

impl Phases {
    fn number(&mut self, phase: PhaseFunction) -> u32 {
        let known = self.0.iter().position(|other| *other == phase);
        let number = known.unwrap_or_else(|| {
            self.0.push(phase);
            self.0.len() - 1
        });
        number as u32
    }
}

fn bits(v: Vec3, last: u32) -> [u32; 4] {
    let [x, y, z] = v.to_array().map(f32::to_bits);
    [x, y, z, last]
}

impl UploadedMedia {
    /// Copies media to a GPU.
    ///
    /// # Errors
    /// [`MediaError::Grid`] if a grid does not fit into a binding in addition to those before
    /// it: WebGPU's default limits allow 33 million densities and 11 million colours in all.
    /// [`MediaError::TooMany`] for more than [`MAX_GRIDS`] grids or phase functions.
    pub fn new<E: Encode>(gpu: &Gpu<E>, media: &Media<'_>) -> Result<Self, MediaError> {
        let limit = gpu.context().limits().max_storage_buffer_binding_size;
        let samples = |what| Samples {
            what,
            numbers: Vec::new(),
            limit,
        };
        let (mut densities, mut colours) = (samples("densities"), samples("colours"));
        let mut phases = Phases::default();
        let mut record = MediaRecord::zeroed();
        if let Some(medium) = media.medium() {
            record.even = MediumRecord::new(medium);
            record.even_phase = phases.number(medium.phase());
        }
        if let Some(fog) = media.height_fog() {
            record.height = HeightFogRecord::from(fog);
            record.height_phase = phases.number(fog.phase());
        }
        let (mut low, mut high) = (Vec3::splat(f32::MAX), Vec3::splat(-f32::MAX));
        let mut records: Vec<[u32; 4]> = Vec::new();
        for (index, grid) in media.grids().iter().enumerate() {
            let (count, resolution) = (grid.density().len(), grid.resolution());
            let density = grid.density().iter().copied();
            let first = densities.add([index, count], resolution, density)?;
            let mut add = |of_samples: &[Vec3], factor: Vec3| {
                if of_samples.is_empty() {
                    return Ok(NONE);
                }
                let numbers = of_samples.iter();
                let numbers = numbers.flat_map(|colour| (factor * *colour).to_array());
                colours.add([index, 3 * count], resolution, numbers)
            };
            let albedo = add(grid.albedo_samples(), grid.albedo())?;
            let emission = add(grid.emission(), Vec3::ONE)?;
            let words: [[u32; 4]; 8] = bytemuck::cast(GridRecord::new(grid, first));
            records.extend(words);
            // Where its occupied cells begin is not known yet.
            records.push([albedo, emission, phases.number(grid.phase()), NONE]);
            low = low.min(grid.occupied_bounds().min());
            high = high.max(grid.occupied_bounds().max());
        }
        record.grids = media.grids().len() as u32;
        record.first_ball = records.len() as u32;
        let mut kinds = Vec::new();
        for (kind, particles) in (0..).zip(media.particles()) {
            let is_soft = particles.profile() == Profile::Soft;
            kinds.push(bits(particles.albedo(), u32::from(is_soft)));
            kinds.push([phases.number(particles.phase()), 0, 0, 0]);
            let balls = particles.all().iter();
            for ball in balls.filter(|ball| ball.radius > 0.0 && ball.sigma_t > 0.0) {
                records.push(bits(ball.centre, ball.radius.to_bits()));
                records.push([ball.sigma_t.to_bits(), kind, 0, 0]);
            }
            if let Some(bounds) = particles.bounds() {
                low = low.min(bounds.min());
                high = high.max(bounds.max());
            }
        }
        record.balls = (records.len() as u32 - record.first_ball) / 2;
        (record.low, record.high) = (low, high);
        record.first_kind = records.len() as u32;
        records.extend(kinds);
        record.first_phase = records.len() as u32;
        record.phases = phases.0.len() as u32;
        for phase in &phases.0 {
            let PhaseRecord { kind, parameters } = PhaseRecord::from(*phase);
            records.push([kind, 0, 0, 0]);
            records.push(parameters.map(f32::to_bits));
        }
        record.first_box = records.len() as u32;
        for bounds in media.boxes() {
            records.push(bits(bounds.min(), 0));
            records.push(bits(bounds.max(), 0));
        }
        record.boxes = (records.len() as u32 - record.first_box) / 2;
        for (index, grid) in media.grids().iter().enumerate() {
            records[GRID_RECORDS * index + GRID_RECORDS - 1][3] = records.len() as u32;
            let words = grid.occupied().chunks(4);
            records.extend(words.map(|words| {
                let mut record = [0; 4];
                record[..words.len()].copy_from_slice(words);
                record
            }));
        }
        let too_many = |what, count| MediaError::TooMany { what, count };
        let room = ROOMS
            .iter()
            .find(|(room, _)| media.grids().len().max(phases.0.len()) <= *room)
            .ok_or_else(|| match media.grids().len() {
                grids if grids > MAX_GRIDS => too_many("grids", grids),
                _ => too_many("phase functions", phases.0.len()),
            })?;
        if records.is_empty() {
            records.push([0; 4]);
        }
        let bytes = 16 * records.len() + 4 * (densities.numbers.len() + colours.numbers.len());
        Ok(Self {
            record,
            records: gpu.upload(&records)?,
            densities: densities.upload(gpu)?,
            colours: colours.upload(gpu)?,
            room: room.1,
            bytes: bytes as u64,
            emits: media.emits(),
            fog: media.medium().copied(),
        })
    }

    /// Memory that they take, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The sources that a shader needs to walk through the media; it must declare the variables
    /// itself.
    pub(super) fn sources(&self) -> [&'static str; 3] {
        [MEDIA, self.room, WALK]
    }
}

/// The shader of a gather.
pub(super) fn shader<V: InShader<PointSlot>>(media: [&'static str; 3]) -> Result<Assembly, Error> {
    let [scene, room, walk] = media;
    let mut shader = Assembly::new(&[
        INDEX_WGSL, NUMERIC, PHASE, PATH, scene, room, walk, STEPS, PANES, GATHER,
    ]);
    shader.fill::<PointSlot>(&V::part())?;
    Ok(shader)
}

/// Appends the panes of so many rays to a table, and returns the index at which they begin.
fn add_panes(panes: Option<&EyePanes>, rays: usize, table: &mut Vec<[u32; 4]>) -> u32 {
    panes.map_or(NONE, |panes| {
        // A table with more entries is refused.
        let first = table.len() as u32;
        panes.write(0, rays, table);
        first
    })
}

impl<V: InShader<PointSlot>, E: Encode> GatherMedia<V> for Gpu<E> {
    fn gather_media(
        &self,
        lit: &MediaRays<'_, '_, GpuMemory>,
        visibility: &V,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.rays.len(), radiance.len())?;
        let (emitter, cookie) = EmitterRecord::new(lit.emitter);
        let mut table: Vec<_> = cookie.iter().map(|texel| texel.map(f32::to_bits)).collect();
        let panes = add_panes(lit.panes, lit.rays.len(), &mut table);
        let fog = lit.media.fog.as_ref();
        let scene = Scene {
            emitter,
            medium: MediumRecord::new(&Medium::VACUUM),
            // The dispatch refuses more rays than a u32 counts.
            rays: lit.rays.len() as u32,
            steps: lit.steps,
            panes,
            is_gentle: fog.is_some_and(|fog| is_gentle(fog, lit.emitter)).into(),
        };
        let media = lit.media;
        self.dispatch(
            &Kernel {
                label: "gather through media",
                parts: &shader::<V>(media.sources())?.finish(PARTS),
                entry: "gather_media",
                constants: &visibility.constants(),
            },
            &[
                &[
                    Argument::uniform(scene),
                    Argument::uniform(media.record),
                    Argument::read(lit.rays),
                    Argument::table(&table),
                    Argument::read(&media.records),
                    Argument::read(&media.densities),
                    Argument::read(&media.colours),
                    Argument::write(radiance),
                ],
                &visibility.arguments(),
            ],
            Workgroups::covering(lit.rays.len(), GROUP),
        )
    }
}

/// The shader that adds what media emit.
pub(super) fn emission_shader([scene, room, walk]: [&'static str; 3]) -> [&'static str; 9] {
    [
        INDEX_WGSL, NUMERIC, PHASE, PATH, scene, room, walk, PANES, EMISSION,
    ]
}

impl<E: Encode> AddEmission for Gpu<E> {
    fn add_emission(
        &self,
        seen: &EmittingRays<'_, '_, GpuMemory>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(seen.rays.len(), radiance.len())?;
        let media = seen.media;
        if !media.emits {
            return Ok(());
        }
        let mut table = Vec::new();
        let panes = add_panes(seen.panes, seen.rays.len(), &mut table);
        let scene = EmissionScene {
            // The dispatch refuses more rays than a u32 counts.
            rays: seen.rays.len() as u32,
            panes,
            padding_a: 0,
            padding_b: 0,
        };
        self.dispatch(
            &Kernel {
                label: "emission of media",
                parts: &emission_shader(media.sources()),
                entry: "add_emission",
                constants: &[],
            },
            &[&[
                Argument::uniform(scene),
                Argument::uniform(media.record),
                Argument::read(seen.rays),
                Argument::table(&table),
                Argument::read(&media.records),
                Argument::read(&media.densities),
                Argument::read(&media.colours),
                Argument::write(radiance),
            ]],
            Workgroups::covering(seen.rays.len(), GROUP),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_that_does_not_fit_is_named_with_what_would() {
        let mut samples = Samples {
            what: "densities",
            numbers: Vec::new(),
            limit: 100,
        };
        let mut add = |grid, resolution: [u32; 3]| {
            let len = resolution.iter().product::<u32>() as usize;
            samples.add([grid, len], resolution, (0..len).map(|i| i as f32))
        };
        assert_eq!(add(0, [2, 2, 3]), Ok(0));
        let error = add(1, [2, 7, 1]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the densities of grid 1, 2 x 7 x 1 samples, take 56 bytes, but of the 100 bytes \
             that shaders of this device see at once 52 are left"
        );
        assert_eq!(add(2, [1, 1, 13]), Ok(12));
        assert!(add(3, [1, 1, 1]).is_err());
    }
}
