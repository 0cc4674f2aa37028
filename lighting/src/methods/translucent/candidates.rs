//! What casts shadows, as candidates of texels that shaders go through: strands, particles,
//! density grids and opaque triangles. See-through triangles and long pieces of strands are made
//! into segments on the CPU.
//!
//! All that is needed once per caster is computed in f64 on the CPU, as [`FaceBlockers`] does:
//! which texels a caster may touch, and where it lies in the picture. Positions count from
//! these texels, and outlines are cut where the picture ends. The two long sides of a piece of
//! strand are rounded to f32 one by one, which changes their distance by a share of the length
//! of the piece: the shader is off by up to 1e-5 of a texel, because pieces of more than
//! [`MOST_TEXELS`] are not for it.
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
use super::grid_rays::{Densities, GridRays};
use super::map::check;
use super::particles::{Ball, PARTS};
use super::strands::Outline;
use super::view::{Texels, View};
use super::{Casters, TransmittanceMap, TransmittanceMapError};
use crate::Emitter;
use crate::scene::gpu::MEDIA;
use crate::scene::raster::Face;
use crate::scene::{Caster, Geometry, Translucent};
use crate::shadow_map::EMPTY;

/// `light_Picture` of `candidates.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct PictureRecord {
    pub(super) scale: [f32; 2],
    pub(super) half: f32,
    pub(super) resolution: u32,
    pub(super) parallel: u32,
    pub(super) empty: f32,
    pub(super) rows: u32,
    pub(super) padding: u32,
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
/// From here on kinds are those of grids, in their order.
pub(super) const GRID: u32 = 3;

/// The most columns or rows of texels that a piece of strand may touch in shaders.
const MOST_TEXELS: u32 = 128;

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

    /// First column and row, and those behind the last.
    fn texels(&self) -> [u32; 4] {
        let [first, end] = [self.columns & 0xffff, self.columns >> 16];
        [first, self.first_row, end, self.end_row]
    }

    /// As `Crowding::of` takes it.
    fn touched(&self, grids: &[GridRays]) -> ([u32; 4], u32) {
        let segments = match self.kind {
            BALL if self.b[1] == 1.0 => PARTS,
            STRAND | BALL | OPAQUE => 1,
            grid => grids[(grid - GRID) as usize].segments,
        };
        (self.texels(), segments)
    }

    /// Whether it is a piece of strand too long for the precision of shaders.
    fn is_too_long(&self) -> bool {
        let [x, y, end_x, end_y] = self.texels();
        self.kind == STRAND && (end_x - x).max(end_y - y) > MOST_TEXELS
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
    grids: GpuBuffer<GridRays>,
    densities: GpuBuffer<f32>,
}

const CANDIDATES: &str = include_str!("candidates.wgsl");
const GRIDS: &str = include_str!("grid.wgsl");

/// The part of `FaceCandidates`.
pub(super) fn part() -> Part {
    Part::new("light_blockers")
        .sources(&[MEDIA, GRIDS, CANDIDATES])
        .uniform("light_picture", "light_Picture")
        .read("light_candidates", "array<light_Candidate>")
        .read("light_opaque", "array<f32>")
        .read("light_grids", "array<light_GridRays>")
        .read("light_densities", "array<f32>")
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
            Argument::read(&self.grids),
            Argument::read(&self.densities),
        ]
    }
}

impl ShaderCandidates for FaceCandidates {
    // Of a strand four cuts of at most eight corners, an area and depths; a cell of a grid is
    // found in fewer.
    const LOOPS: u32 = 4 * 9 + 8 + 8;

    fn count(&self) -> u32 {
        self.count
    }

    fn crowding(&self) -> Crowding {
        self.crowding
    }
}

/// Whether some triangle that casts a shadow lets a share of the light through.
fn casts_through(geometry: &Geometry) -> bool {
    let mut triangles = 0..geometry.triangles().len();
    geometry.coatings().any_see_through()
        && triangles.any(|index| matches!(geometry.caster(index), Caster::SeeThrough(_)))
}

/// The number of pieces or balls of a caster; a grid is one.
fn part_count(caster: &Translucent) -> usize {
    match caster {
        Translucent::Strands(strands) => strands.piece_count(),
        Translucent::Particles(particles) => particles.all().len(),
        Translucent::Grid(_) => 1,
    }
}

/// What the faces of a light see.
#[derive(Debug, Default)]
struct Seen {
    records: Vec<CandidateRecord>,
    grids: Vec<GridRays>,
}

/// A face in one colour channel, with the rows of the map from `row` on.
#[derive(Debug, Clone, Copy)]
struct Picture {
    view: View,
    row: u32,
    channel: usize,
}

impl Picture {
    /// A part of a caster, with the rays through it appended to `grids` if it is a grid, whose
    /// first density has this index; `None` if the picture does not see it.
    fn candidate(
        &self,
        caster: &Translucent,
        index: usize,
        first_density: Option<u32>,
        grids: &mut Vec<GridRays>,
    ) -> Option<CandidateRecord> {
        let Self { view, row, channel } = self;
        match caster {
            Translucent::Strands(strands) => {
                Outline::new(view, &strands.piece(index))?.candidate(view, *row)
            }
            Translucent::Particles(particles) => {
                let ball = &particles.all()[index];
                Ball::new(view, ball, particles.profile()).candidate(view, *row)
            }
            Translucent::Grid(grid) => {
                let first = first_density?;
                let texels = view.of_box(grid.occupied_bounds())?;
                if grid.tint()[*channel] == 0.0 {
                    return None;
                }
                // There are fewer than records, which fit into a buffer.
                let kind = GRID + grids.len() as u32;
                grids.push(GridRays::new(grid, view, texels, *channel, first));
                Some(CandidateRecord::new(kind, texels, *row))
            }
        }
    }
}

impl Casters<'_> {
    /// Whether shaders know all of them, but for those that are too large.
    fn are_candidates(&self) -> bool {
        !self.triangles.panes().is_some_and(casts_through)
    }

    /// The translucent casters that the pictures see, in their order. `None` if there are more
    /// than `most` records, if shaders do not take one of them, or if `goes_on` says no before a
    /// picture.
    fn seen(
        &self,
        pictures: &[Picture],
        densities: &Densities,
        most: usize,
        goes_on: &dyn Fn() -> bool,
    ) -> Option<Seen> {
        let mut seen = Seen::default();
        for picture in pictures {
            if !goes_on() {
                return None;
            }
            for (number, caster) in self.translucent.iter().enumerate() {
                let first = densities.first(number);
                for index in 0..part_count(caster) {
                    let grids = &mut seen.grids;
                    let Some(record) = picture.candidate(caster, index, first, grids) else {
                        continue;
                    };
                    // The rays through a grid take twice the memory of a record.
                    let is_full = seen.records.len() == most || 2 * seen.grids.len() > most;
                    if is_full || record.is_too_long() {
                        return None;
                    }
                    seen.records.push(record);
                }
            }
        }
        Some(seen)
    }
}

impl<T: WgslStored + Debug> TransmittanceMap<GpuMemory, T> {
    /// [`TransmittanceMap::build`] in shaders, each curve by the rule of `clear`: strands,
    /// particles, density grids and opaque triangles are listed by square of texels, and every
    /// texel takes what it meets, in the order of the casters and of their parts; of a grid these
    /// are the cells along its ray. No segment is in memory. All faces have `resolution` texels
    /// per side. See [`build_from_candidates`].
    ///
    /// `None` if this cannot be: with see-through triangles among the casters, with a piece of a
    /// strand that touches more than 128 columns or rows of texels, with a grid of more than 2048
    /// cells along an axis, with more densities than a buffer of the device holds, with more
    /// casters than such a buffer holds, at 96 bytes for each face that sees a grid, a particle
    /// or a piece of a strand, or with more of these over one texel than the dispatches that
    /// `build_from_candidates` allows. Then build the map on the CPU and
    /// [`upload`](TransmittanceMap::upload) it.
    ///
    /// Beside the map, memory on the device is 144 bytes for each of these, 192 more for a grid,
    /// 4 for each density, 4 for each texel of the faces if there are opaque triangles, and curves
    /// in the making as `build_from_candidates` says; on the host it is 112 bytes for each of
    /// these, 192 more for a grid, 4 for each density, and 8 for each texel or 12 if there are
    /// opaque triangles. Where a [tint](crate::scene::DensityGrid::tint) colours the light, a
    /// face counts once for each colour.
    ///
    /// Optical depths and depths of segments are those of the CPU but for roundings to f32. The
    /// coverage of a texel by a piece of a strand is off by up to 1e-5 for pieces of 128 texels,
    /// and in proportion for shorter ones: 1e-3 of itself where a strand is as thin as a
    /// hundredth of a texel. A ray goes through a grid as if it were moved aside by 2⁻²² of the
    /// size of the grid; one that runs within a face between cells may meet those on the other
    /// side of it. Roundings may also decide otherwise which of two nodes of a curve is left out;
    /// the error bounds of both curves hold but for these differences.
    ///
    /// In an encoder of yours the map is only recorded: its curves are not made before you submit
    /// what was recorded. If you drop the encoder instead, drop the map too: lookups in it would
    /// read zeros.
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
        Self::build_while(gpu, casters, emitter, resolution, clear, &|| true)
    }

    /// [`TransmittanceMap::build_in_shaders`], which also gives up and returns `None` when
    /// `goes_on`, which is asked before each face, says no.
    pub(super) fn build_while<A, E>(
        gpu: &Gpu<E>,
        casters: &Casters<'_>,
        emitter: &Emitter,
        resolution: u32,
        clear: &A,
        goes_on: &dyn Fn() -> bool,
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
        let planes = casters.planes(emitter);
        let side = resolution as usize;
        let channels = casters.channels();
        let extent = [side, channels * side * planes.len()];
        let limits = gpu.context().limits();
        let bytes = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        // All faces of red come first, followed by those of green and of blue.
        let each = (0..channels).flat_map(|channel| planes.iter().map(move |face| (channel, face)));
        let rows = (0..).step_by(side);
        let pictures: Vec<Picture> = rows
            .zip(each)
            .map(|(row, (channel, face))| Picture {
                view: View::new(face, resolution),
                row,
                channel,
            })
            .collect();
        // Each picture may have opaque triangles, which are one record.
        let most = (bytes / size_of::<CandidateRecord>() as u64) as usize;
        let most = most.saturating_sub(pictures.len());
        let most_densities = (bytes / size_of::<f32>() as u64) as usize;
        let Some(densities) = Densities::new(casters.translucent, most_densities) else {
            return Ok(None);
        };
        let Some(mut seen) = casters.seen(&pictures, &densities, most, goes_on) else {
            return Ok(None);
        };
        // What does not fit is said before anything is drawn. A curve is at least as large as a
        // depth, so that these fit where it does.
        let mut curves = transmittance::TransmittanceMap::new(gpu, extent)?;
        let mut opaque = Vec::new();
        for face in &planes {
            if !goes_on() {
                return Ok(None);
            }
            opaque
                .extend(opaque_depths(&Cpu::new(), casters, face, resolution).unwrap_or_default());
        }
        if !opaque.is_empty() {
            // Opaque triangles come after all else that a texel meets.
            let all = |it: &Picture| CandidateRecord::new(OPAQUE, it.view.all(), it.row);
            seen.records.extend(pictures.iter().map(all));
        }
        let there = |error| TransmittanceMapError::Curves(transmittance::Error::Backend(error));
        let Seen { records, grids } = seen;
        let touched = records.iter().map(|record| record.touched(&grids));
        let candidates = FaceCandidates {
            picture: PictureRecord::new(&planes, resolution),
            // Their bytes are within those of a buffer.
            count: records.len() as u32,
            crowding: Crowding::of(extent, touched),
            records: gpu.upload(&records).map_err(there)?,
            opaque: gpu.upload(&opaque).map_err(there)?,
            grids: gpu.upload(&grids).map_err(there)?,
            densities: gpu.upload(&densities.all).map_err(there)?,
        };
        match build_from_candidates(gpu, clear, &candidates, &mut curves) {
            // Too many dispatches.
            Err(transmittance::Error::BadValue { .. }) => return Ok(None),
            result => result?,
        }
        Ok(Some(Self {
            sides: vec![resolution; planes.len()],
            faces: planes,
            resolution,
            channels,
            curves,
            filter: Filter::Bilinear,
        }))
    }
}

impl PictureRecord {
    /// What all faces of a light have in common.
    fn new(faces: &[Face], resolution: u32) -> Self {
        let view = faces.first().map(|face| View::new(face, resolution));
        Self {
            scale: view.map_or([1.0; 2], |view| view.scale().as_vec2().to_array()),
            half: 0.5 * resolution as f32,
            resolution,
            parallel: u32::from(view.is_some_and(|view| view.is_parallel())),
            empty: EMPTY,
            // At most six faces of 16384 rows.
            rows: faces.len() as u32 * resolution,
            padding: 0,
        }
    }
}
