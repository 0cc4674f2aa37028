//! Enter and exit slices from triangles, texel by texel on a GPU.

use std::fmt;

use gpu_backend::gpu::{Argument, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Queued, Workgroups};
use gpu_backend::{Backend, Download};

use crate::mesh::{Kind, ONE, Scratch, Triangle};
use crate::{DepthSource, Error, Exits, LightSpace, Mesh, Resolution, Slices, TileRect};

/// Invocations per workgroup.
const GROUP: u32 = 64;
/// Texels along each side of a block, whose texels share a list of triangles.
const BLOCK: u32 = 32;

pub(super) const PEEL: [&str; 2] = [INDEX_WGSL, include_str!("peel.wgsl")];

/// `Parameters` of `peel.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct PeelParameters {
    pub(super) first: [i32; 2],
    pub(super) step: i32,
    pub(super) side: u32,
    pub(super) block: u32,
    pub(super) slices: f32,
    pub(super) near: f32,
    pub(super) stretch: f32,
}

/// `Triangle` of `peel.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct TriangleRecord {
    pub(super) a: [i32; 2],
    pub(super) b: [i32; 2],
    pub(super) c: [i32; 2],
    pub(super) kind: u32,
    pub(super) nearer: f32,
    pub(super) depth: f32,
    pub(super) deeper_b: f32,
    pub(super) deeper_c: f32,
    pub(super) inverse_area: f32,
    pub(super) least: f32,
    pub(super) most: f32,
    pub(super) padding_a: f32,
    pub(super) padding_b: f32,
}

impl TriangleRecord {
    fn new(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.corners();
        let ([depth, second, third], [least, most]) = triangle.corner_depths();
        Self {
            a,
            b,
            c,
            kind: number_of(triangle.kind),
            nearer: triangle.snapped() as f32,
            depth: depth as f32,
            deeper_b: (second - depth) as f32,
            deeper_c: (third - depth) as f32,
            // No sample is in one without area.
            inverse_area: (1.0 / (triangle.twice_area().max(1) as f64)) as f32,
            least: least as f32,
            most: most as f32,
            padding_a: 0.0,
            padding_b: 0.0,
        }
    }
}

/// A kind as the shader knows it.
pub(super) fn number_of(kind: Kind) -> u32 {
    match kind {
        Kind::Front => 0,
        Kind::Open => 1,
        Kind::Back => 2,
    }
}

/// A mesh on a GPU, which peels off its surfaces tile by tile: the same
/// [`DepthSource`] like the [`Mesh`] itself.
///
/// The CPU finds the triangles over blocks of 32×32 texels, the GPU does the
/// rest. Nothing but triangles, lists and one tile at a time is on the device.
///
/// Where the [holes](crate::Holes) of a mesh are, only the host can tell: a mesh that
/// has any is peeled there, with the results of [`Mesh`] to the last slice and in its
/// time.
///
/// # Agreement with the CPU
///
/// The same triangles are over the same texels. Depths are f32 and off by at
/// most `(|d| + 5 r) · 2⁻²⁴` of the depth `d` of a triangle whose corners span
/// `r`: one rounding each of the depth of the corner and of the result, and
/// five of the way between: two differences, two weights and two products that
/// are at most `r` together. A slice differs, by one, where the boundary
/// between two is within that of the surface: with linear slices for the share
/// `2N (|d| + 5 r) · 2⁻²⁴` of either of both slices of a texel, at most
/// 12N · 2⁻²⁴ with depths from 0 to 1, which is 0.3 % of N = 4096.
///
/// With logarithmic slices, depths are −1/distance and not beyond 1/near, and a
/// slice at the distance `s` is `L / (N s)` high, L = ln(far/near): the
/// share is at most far/(near L) times as large, for surfaces at the far end.
/// Logarithms add 2N · 2⁻²¹ (1 + 1/L).
///
/// The share of texels of which a slice differs is at most twice that of one
/// slice. Surfaces that are closer than that to each other may come in the other
/// order; solids that touch are given twice the room.
pub struct PeeledMesh<'a> {
    gpu: &'a Gpu<Queued>,
    mesh: &'a Mesh,
    triangles: GpuBuffer<TriangleRecord>,
}

impl fmt::Debug for PeeledMesh<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PeeledMesh")
            .field("triangles", &self.triangles)
            .finish_non_exhaustive()
    }
}

impl<'a> PeeledMesh<'a> {
    /// Copies the triangles of a mesh, 64 bytes each, to a GPU.
    ///
    /// # Errors
    /// [`gpu_backend::Error::TooLarge`] if it cannot bind so many: two million
    /// with the default limits of WebGPU.
    pub fn new(gpu: &'a Gpu<Queued>, mesh: &'a Mesh) -> Result<Self, Error> {
        let records: Vec<_> = mesh.triangles.iter().map(TriangleRecord::new).collect();
        Ok(Self {
            gpu,
            mesh,
            triangles: gpu.upload(&records)?,
        })
    }

    /// The enter and exit slice of each texel of a tile, row by row, on the
    /// device.
    ///
    /// # Errors
    /// [`Error::BadValue`] if it is no tile of the map,
    /// [`gpu_backend::Error::TooLarge`] if the tile or the lists of its
    /// triangles are too large for the device, and other errors of it.
    pub fn peel(&self, tile: TileRect) -> Result<GpuBuffer<[u32; 2]>, Error> {
        tile.check(self.mesh.resolution())?;
        // First, so that a tile beyond the device is refused before lists of
        // its blocks are made.
        let mut texels = self.gpu.zeros(tile.len())?;
        if self.mesh.has_holes() {
            let [mut enter, mut exit] = [vec![0; tile.len()], vec![0; tile.len()]];
            self.mesh.read(tile, &mut enter, &mut exit)?;
            let pairs: Vec<_> = enter.into_iter().zip(exit).map(<[u32; 2]>::from).collect();
            return Ok(self.gpu.upload(&pairs)?);
        }
        let block = BLOCK.min(tile.side);
        let across = tile.side / block;
        let mut blocks = vec![Vec::new(); (across * across) as usize];
        Scratch::new(self.mesh, false).blocks(tile, block, |[x, y], list| {
            let at = [(x - tile.x) / block, (y - tile.y) / block];
            blocks[(at[1] * across + at[0]) as usize] = list.to_vec();
        });
        let mut starts = vec![0];
        let mut end = 0_u64;
        for list in &blocks {
            end += list.len() as u64;
            starts.push(
                u32::try_from(end).map_err(|_| gpu_backend::Error::TooLarge {
                    what: "the triangles of a tile",
                    requested: 4 * end,
                    limit: 4 * u64::from(u32::MAX),
                })?,
            );
        }
        let lists = self.gpu.upload(&blocks.concat())?;
        let starts = self.gpu.upload(&starts)?;
        self.dispatch(tile, block, [&starts, &lists], &mut texels)?;
        Ok(texels)
    }

    fn dispatch(
        &self,
        tile: TileRect,
        block: u32,
        [starts, lists]: [&GpuBuffer<u32>; 2],
        texels: &mut GpuBuffer<[u32; 2]>,
    ) -> Result<(), Error> {
        let resolution = self.mesh.resolution();
        let step = ONE / resolution.side() as i32;
        let (near, stretch) = match self.mesh.light.slices() {
            Slices::Linear => (0.0, 0.0),
            Slices::Logarithmic(ends) => (ends.near(), ends.stretch()),
        };
        let parameters = PeelParameters {
            first: [tile.x, tile.y].map(|at| at as i32 * step + step / 2),
            step,
            side: tile.side,
            block,
            slices: resolution.side() as f32,
            near: near as f32,
            stretch: stretch as f32,
        };
        self.gpu.dispatch(
            &Kernel {
                label: "peel",
                parts: &PEEL,
                entry: "peel",
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::read(&self.triangles),
                Argument::read(starts),
                Argument::read(lists),
                Argument::write(texels),
            ]],
            Workgroups::covering(tile.len(), GROUP),
        )?;
        Ok(())
    }
}

impl DepthSource for PeeledMesh<'_> {
    fn resolution(&self) -> Resolution {
        self.mesh.resolution()
    }

    fn light(&self) -> Option<LightSpace> {
        Some(self.mesh.light)
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        if self.mesh.has_holes() {
            return self.mesh.read(tile, enter, exit);
        }
        tile.check_places(self.mesh.resolution(), [enter, exit])?;
        let texels = self.gpu.download(&self.peel(tile)?)?;
        for (texel, (enter, exit)) in texels.iter().zip(enter.iter_mut().zip(exit)) {
            [*enter, *exit] = *texel;
        }
        Ok(Exits::Closed)
    }
}
