//! What casts shadows, as candidates of texels that shaders go through: strands, particles and
//! opaque triangles. Grids and see-through triangles are made into segments on the CPU.
//!
//! All that is needed once per caster is computed in f64 on the CPU, as [`FaceBlockers`] does:
//! which texels a caster may touch, and where it lies in the picture. Positions count from
//! these texels, and outlines are cut where the picture ends, so that what a shader computes
//! for a texel in f32 has all of its digits.
//!
//! [`FaceBlockers`]: super::FaceBlockers

use std::fmt::Debug;

use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, GpuMemory, InShader};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Cpu};
use transmittance::Filter;
use transmittance::gpu::{
    CandidatesSlot, Crowding, ShaderCandidates, WgslRule, WgslStored, build_from_candidates,
};

use super::blockers::opaque_depths;
use super::map::check;
use super::particles::{Ball, PARTS};
use super::strands::Outline;
use super::view::{Texels, View};
use super::{Casters, TransmittanceMap, TransmittanceMapError};
use crate::Emitter;
use crate::scene::Translucent;
use crate::scene::raster::Face;
use crate::shadow_map::{EMPTY, faces};

/// `light_Picture` of `candidates.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct PictureRecord {
    pub(super) scale: [f32; 2],
    pub(super) half: f32,
    pub(super) resolution: u32,
    pub(super) parallel: u32,
    pub(super) empty: f32,
    pub(super) padding: [u32; 2],
}

/// `light_Candidate` of `candidates.wgsl`.
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct CandidateRecord {
    pub(super) kind: u32,
    pub(super) columns: u32,
    pub(super) first_row: u32,
    pub(super) end_row: u32,
    pub(super) a: [f32; 3],
    pub(super) radius: f32,
    pub(super) b: [f32; 3],
    pub(super) opacity: f32,
    pub(super) corners: [[f32; 3]; 4],
}

pub(super) const STRAND: u32 = 0;
pub(super) const BALL: u32 = 1;
pub(super) const OPAQUE: u32 = 2;

impl CandidateRecord {
    /// A candidate of these texels of a face, which has its rows from `row` on.
    pub(super) fn new(kind: u32, texels: Texels, row: u32) -> Self {
        let [first, end] = texels.x;
        Self {
            kind,
            // At most 16384.
            columns: first | end << 16,
            first_row: row + texels.y[0],
            end_row: row + texels.y[1],
            ..Self::default()
        }
    }

    /// As `Crowding::of` takes it.
    fn touched(&self) -> ([u32; 4], u32) {
        let [first, end] = [self.columns & 0xffff, self.columns >> 16];
        let is_soft = self.kind == BALL && self.b[1] == 1.0;
        let segments = if is_soft { PARTS } else { 1 };
        ([first, self.first_row, end, self.end_row], segments)
    }
}

/// The candidates of all faces of a light.
#[derive(Debug)]
struct FaceCandidates {
    picture: PictureRecord,
    count: u32,
    crowding: Crowding,
    records: GpuBuffer<CandidateRecord>,
    opaque: GpuBuffer<f32>,
}

const CANDIDATES: &str = include_str!("candidates.wgsl");

/// The part of `FaceCandidates`.
pub(super) fn part() -> Part {
    Part::new("light_blockers")
        .source(CANDIDATES)
        .uniform("light_picture", "light_Picture")
        .read("light_candidates", "array<light_Candidate>")
        .read("light_opaque", "array<f32>")
}

impl InShader<CandidatesSlot> for FaceCandidates {
    fn part() -> Part {
        part()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.picture),
            Argument::read(&self.records),
            Argument::read(&self.opaque),
        ]
    }
}

impl ShaderCandidates for FaceCandidates {
    // Four cuts of at most eight corners, an area and depths.
    const LOOPS: u32 = 4 * 9 + 8 + 8;

    fn count(&self) -> u32 {
        self.count
    }

    fn crowding(&self) -> Crowding {
        self.crowding
    }
}

impl Casters<'_> {
    /// Whether shaders know all of them.
    fn are_candidates(&self) -> bool {
        let is_grid = |caster: &Translucent| matches!(caster, Translucent::Grid(_));
        let has_panes = |panes: &crate::scene::Geometry| panes.coatings().any_see_through();
        !self.translucent.iter().any(is_grid) && !self.triangles.panes().is_some_and(has_panes)
    }

    /// The strands and particles that a face sees, in their order.
    fn records(&self, face: &Face, resolution: u32, row: u32, records: &mut Vec<CandidateRecord>) {
        let view = View::new(face, resolution);
        for caster in self.translucent {
            match caster {
                Translucent::Strands(strands) => {
                    let pieces = (0..strands.piece_count()).map(|index| strands.piece(index));
                    let outlines = pieces.filter_map(|piece| Outline::new(&view, &piece));
                    records.extend(outlines.filter_map(|it| it.candidate(&view, row)));
                }
                Translucent::Particles(particles) => {
                    let balls = particles.all().iter();
                    let balls = balls.map(|ball| Ball::new(&view, ball, particles.profile()));
                    records.extend(balls.filter_map(|ball| ball.candidate(&view, row)));
                }
                Translucent::Grid(_) => {}
            }
        }
    }
}

impl<T: WgslStored + Debug> TransmittanceMap<GpuMemory, T> {
    /// [`TransmittanceMap::build`] in shaders, each curve by the rule of `clear`: strands,
    /// particles and opaque triangles are listed by square of texels, and every texel takes
    /// what it meets, in the order of the casters and of their parts; no segment is in memory.
    /// See [`build_from_candidates`].
    ///
    /// `None` if this cannot be: with density grids or see-through triangles among the casters,
    /// or with more casters than a buffer of the device holds, at 96 bytes for each face that
    /// sees a particle or a piece of a strand. Then build the map on the CPU and
    /// [`upload`](TransmittanceMap::upload) it.
    ///
    /// Beside the map, memory on the device is 144 bytes for each of these, 4 for each texel if
    /// there are opaque triangles, and curves in the making as `build_from_candidates` says; on
    /// the host it is 96 and 12.
    ///
    /// A curve is that of the CPU but for roundings, which may decide otherwise which of two
    /// nodes is left out; both are within their error bounds.
    ///
    /// # Errors
    /// [`TransmittanceMapError::Resolution`] unless the resolution is from 1 to
    /// [`MAX_RESOLUTION`](super::MAX_RESOLUTION); [`TransmittanceMapError::Curves`] if the map
    /// does not fit on the device, with the size of one that does.
    pub fn build_in_shaders<A, E>(
        gpu: &Gpu<E>,
        casters: &Casters<'_>,
        emitter: &Emitter,
        resolution: u32,
        clear: &A,
    ) -> Result<Option<Self>, TransmittanceMapError>
    where
        A: WgslRule,
        A::Curve: Into<T>,
        E: Encode,
    {
        check(resolution)?;
        if !casters.are_candidates() {
            return Ok(None);
        }
        let planes: Vec<Face> = casters
            .bounds()
            .map(|bounds| faces(bounds, emitter))
            .into_iter()
            .flatten()
            .collect();
        let side = resolution as usize;
        let extent = [side, side * planes.len()];
        // What does not fit is said before anything is drawn.
        let mut curves = transmittance::TransmittanceMap::new(gpu, extent)?;
        let limits = gpu.context().limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let (mut records, mut opaque) = (Vec::new(), Vec::new());
        for (row, face) in (0..).step_by(side).zip(&planes) {
            casters.records(face, resolution, row, &mut records);
            if let Some(depths) = opaque_depths(&Cpu::new(), casters, face, resolution) {
                opaque.extend(depths);
                let all = View::new(face, resolution).all();
                records.push(CandidateRecord::new(OPAQUE, all, row));
            }
            if size_of_val(&records[..]) as u64 > most || size_of_val(&opaque[..]) as u64 > most {
                return Ok(None);
            }
        }
        let there = |error| TransmittanceMapError::Curves(transmittance::Error::Backend(error));
        let candidates = FaceCandidates {
            picture: PictureRecord::new(planes.first(), resolution),
            // Their bytes are within those of a buffer.
            count: records.len() as u32,
            crowding: Crowding::of(extent, records.iter().map(CandidateRecord::touched)),
            records: gpu.upload(&records).map_err(there)?,
            opaque: gpu.upload(&opaque).map_err(there)?,
        };
        build_from_candidates(gpu, clear, &candidates, &mut curves)?;
        Ok(Some(Self {
            faces: planes,
            resolution,
            channels: 1,
            curves,
            filter: Filter::Bilinear,
        }))
    }
}

impl PictureRecord {
    /// What all faces of a light have in common.
    fn new(face: Option<&Face>, resolution: u32) -> Self {
        let view = face.map(|face| View::new(face, resolution));
        Self {
            scale: view.map_or([1.0; 2], |view| view.scale().as_vec2().to_array()),
            half: 0.5 * resolution as f32,
            resolution,
            parallel: u32::from(view.is_some_and(|view| view.is_parallel())),
            empty: EMPTY,
            padding: [0; 2],
        }
    }
}
