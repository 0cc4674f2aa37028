//! Shadow volumes of coarse stand-ins for the casters: one for each cell of a light's pictures.

use glam::{DVec3, Vec3};
use gpu_backend::{Backend, Cpu, Error, Host, Memory};

use super::cells::{Cells, DEPTH, NOTHING, POSITION};
use super::picture::{Picture, Square};
use crate::scene::{Bounds, Caster, Emitter, Geometry};
use crate::shadow_map::{Casters, faces};

/// The number of triangles that are added to a grid of their own.
const CHUNK: usize = 1 << 14;

/// The largest number of grids that are made at the same time, which take 1.5 MiB each for a
/// cube.
const MOST_CHUNKS: usize = 64;

/// Shadow volumes that contain every shadow of a light.
///
/// Each picture of the light is divided into square cells, and a cell stores the smallest
/// distance at which there is any caster in it. The part of the cell that is farther away is
/// its shadow volume: a truncated pyramid, or a prism in parallel light. The cells of all
/// levels of a pyramid have one, down to eight texels of the shadow map.
///
/// A shadow, whether of the map or exact, is never outside of these volumes: a triangle counts
/// in the cells that it touches or comes within a texel of, whatever the samples of the map
/// say, and depths are bounds. Masked triangles count as solid, except those that are holes
/// everywhere.
#[derive(Debug)]
pub struct ShadowVolumes<M: Memory> {
    pub(super) cells: Cells,
    /// Depths, the finest level first; each picture by picture, row by row.
    pub(super) near: M::Buffer<f32>,
}

/// A backend that makes shadow volumes of casters.
pub trait BuildShadowVolumes: Backend {
    /// The shadow volumes of a light, for a shadow map with so many texels per side.
    ///
    /// A GPU has fewer digits than [`ShadowVolumes::new`] and rounds depths towards the light:
    /// by 1e-5 of the distance, and by more for triangles seen edge-on (1e-4 on average), which
    /// count with their smallest depth in all cells of the box around them. One cell in a
    /// thousand is included in addition. The time is proportional to the number of triangles
    /// plus the number of cells in the boxes around them.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory: 2 MiB for a cube, and as much again
    /// while they are made.
    fn shadow_volumes(
        &self,
        casters: &Casters<Self::Memory>,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<ShadowVolumes<Self::Memory>, Error>;
}

impl BuildShadowVolumes for Cpu {
    fn shadow_volumes(
        &self,
        casters: &Casters<Host>,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<ShadowVolumes<Host>, Error> {
        let light = (casters.bounds(), emitter, resolution);
        ShadowVolumes::of_triangles(self, casters.triangles(), |_| true, light)
    }
}

/// A bound on the rounding of positions, m.
pub(super) fn margin(casters: Bounds, origin: Vec3) -> f64 {
    let scale = [casters.min(), casters.max(), origin];
    let scale = scale.map(|v| v.abs().max_element()).into_iter();
    POSITION * f64::from(scale.fold(0.0, f32::max))
}

impl<M: Memory> ShadowVolumes<M> {
    /// Texels per side of the shadow map that they belong to.
    pub fn resolution(&self) -> u32 {
        self.cells.resolution
    }

    /// Texels per side of a cell of the finest level.
    pub fn cell(&self) -> u32 {
        self.cells.cell
    }

    /// The smallest distances, in the memory of the backend.
    pub fn near(&self) -> &M::Buffer<f32> {
        &self.near
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        4 * self.cells.len() as u64
    }
}

impl ShadowVolumes<Host> {
    /// The shadow volumes of a light, for a shadow map with so many texels per side.
    ///
    /// The time is proportional to the number of triangles plus the number of cells in the
    /// boxes around them. At most 96 MiB are used in between.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory: 2 MiB for a cube.
    pub fn new(
        cpu: &Cpu,
        geometry: &Geometry,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<Self, Error> {
        let all_solid = geometry.all_solid();
        // The triangles from which a shadow map is rendered.
        let casts = |index: usize| {
            all_solid
                || match geometry.caster(index) {
                    Caster::Solid => true,
                    Caster::Masked(coating) => !coating.covers_nothing(),
                    _ => false,
                }
        };
        let light = (geometry.bounds(), emitter, resolution);
        Self::of_triangles(cpu, geometry.triangles(), casts, light)
    }

    /// The volumes of the triangles that cast shadows, given by their indices.
    fn of_triangles(
        cpu: &Cpu,
        triangles: &[[Vec3; 3]],
        casts: impl Fn(usize) -> bool + Sync,
        (bounds, emitter, resolution): (Bounds, &Emitter, u32),
    ) -> Result<Self, Error> {
        let cells = Cells::new(&faces(bounds, emitter), resolution);
        let grid = Grid { cells: &cells };
        // Each chunk has a grid. The minimum of all grids does not depend on how triangles are
        // divided.
        let chunk = CHUNK.max(triangles.len().div_ceil(MOST_CHUNKS));
        let parts = cpu.map(triangles.len().div_ceil(chunk), |number| {
            let first = number * chunk;
            let chosen = (first..).zip(&triangles[first..]).take(chunk);
            let chosen = chosen.filter(|(index, _)| casts(*index));
            grid.of_triangles(chosen.map(|(_, triangle)| triangle))
        });
        let margin = margin(bounds, cells.origin);
        let mut near = cpu.zeros::<f32>(cells.len())?;
        for (index, depth) in near[..cells.finest()].iter_mut().enumerate() {
            let least = parts.iter().map(|part| part[index]);
            let least = f64::from(least.fold(NOTHING, f32::min));
            *depth = (least - DEPTH * least.abs() - margin) as f32;
        }
        cells.fill(&mut near, f32::min);
        Ok(Self { cells, near })
    }

    /// Copies the volumes to another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<ShadowVolumes<B::Memory>, Error> {
        Ok(ShadowVolumes {
            cells: self.cells.clone(),
            near: backend.upload(&self.near)?,
        })
    }
}

/// The finest cells of all pictures, while they are made.
struct Grid<'a> {
    cells: &'a Cells,
}

impl Grid<'_> {
    /// The smallest depths of some triangles in each cell.
    fn of_triangles<'t>(&self, triangles: impl Iterator<Item = &'t [Vec3; 3]>) -> Vec<f32> {
        let Cells {
            origin, pictures, ..
        } = self.cells;
        let per_picture = (self.cells.side as usize).pow(2);
        let mut near = vec![NOTHING; pictures.len() * per_picture];
        for triangle in triangles {
            let corners = triangle.map(|corner| (corner - *origin).as_dvec3());
            for (picture, near) in pictures.iter().zip(near.chunks_exact_mut(per_picture)) {
                self.add(picture, &corners, near);
            }
        }
        near
    }

    fn add(&self, picture: &Picture, corners: &[DVec3; 3], near: &mut [f32]) {
        let Some(all) = picture.bounds(corners) else {
            return;
        };
        let border = picture.margin();
        let (size, side) = (f64::from(self.cells.cell), self.cells.side as usize);
        // This is exact, because the size is a power of two.
        let per_texel = size.recip();
        let last = f64::from(self.cells.side - 1);
        let Square { low, high } = all.wider(border);
        if high.min_element() < 0.0 || low.max_element() >= size * (last + 1.0) {
            return;
        }
        // Conversions round down what is clamped to the cells there are.
        let cell = |texel: f64| (texel * per_texel).clamp(0.0, last) as usize;
        let [from, to] = [low, high].map(|at| [cell(at.x), cell(at.y)]);
        let is_small = to[0] - from[0] <= 1 && to[1] - from[1] <= 1;
        let cells = |row: usize| row * side + from[0]..=row * side + to[0];
        if is_small {
            let depth = picture.least_depth(corners, all);
            for row in from[1]..=to[1] {
                for cell in &mut near[cells(row)] {
                    *cell = cell.min(depth);
                }
            }
            return;
        }
        let Some(plane) = picture.plane(corners) else {
            return;
        };
        for row in from[1]..=to[1] {
            for (column, near) in (from[0]..).zip(&mut near[cells(row)]) {
                let square = Square::new([column, row], size).wider(border);
                if let Some(depth) = plane.least_depth(picture, square) {
                    *near = near.min(depth);
                }
            }
        }
    }
}
