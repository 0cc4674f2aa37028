//! Lit volumes: volumes that contain all light, outside of which everything is dark.

use glam::DVec3;
use gpu_backend::{Backend, Cpu, Error, Host, Memory};

use super::cells::{Cells, DEPTH, NOTHING, POSITION};
use crate::scene::raster::{Face, Rays};
use crate::shadow_map::ShadowMap;
use crate::shadow_map::line::cube_face;

/// Volumes outside of which everything is dark according to a shadow map.
///
/// In each cell of the pictures of a light, of eight texels or any larger power of two, the
/// volume is the part in front of the farthest texel: the inverse of
/// [`ShadowVolumes`](super::ShadowVolumes). In a room with a window, lit volumes form a shaft
/// behind the window.
///
/// A sample that is lit according to the map is never outside of them. A cell is as far as the
/// texels around it, too, and depths are bounds that allow for the rounding of positions. In a
/// cube of pictures, a cell is also as far as its neighbours in other pictures. What is in no
/// picture is lit.
#[derive(Debug)]
pub struct LitVolumes<M: Memory> {
    pub(super) cells: Cells,
    pub(super) far: M::Buffer<f32>,
}

/// A backend that makes lit volumes of shadow maps.
pub trait BuildLitVolumes: Backend {
    /// The lit volumes of a map. This takes little more than reading each of its texels once.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory: 2 MiB for a cube.
    fn lit_volumes(&self, map: &ShadowMap<Self::Memory>)
    -> Result<LitVolumes<Self::Memory>, Error>;
}

impl<M: Memory> LitVolumes<M> {
    /// Texels per side of the shadow map that they belong to.
    pub fn resolution(&self) -> u32 {
        self.cells.resolution
    }

    /// The largest distances, in the memory of the backend.
    pub fn far(&self) -> &M::Buffer<f32> {
        &self.far
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        4 * self.cells.len() as u64
    }
}

impl LitVolumes<Host> {
    /// An estimate of a map's lit volumes without the map. It assumes that casters fill each
    /// cell of the finest level that contains one, between the smallest depths of the cells
    /// around it.
    ///
    /// It only tells what lit volumes would save: light that passes between casters within a
    /// cell is outside of these volumes.
    #[cfg(any(feature = "methods", test))]
    pub(super) fn estimated(shadows: &super::ShadowVolumes<Host>) -> Self {
        let cells = shadows.cells.clone();
        let (side, pictures) = (cells.side as usize, cells.pictures.len());
        let used = cells.resolution.div_ceil(cells.cell) as usize;
        let around = |at: usize| at.saturating_sub(1)..(at + 2).min(used);
        let mut far = vec![0.0; cells.len()];
        for (row, far) in far.chunks_exact_mut(side).enumerate().take(pictures * side) {
            let (picture, row) = (row / side, row % side);
            if row >= used {
                continue;
            }
            let greatest = |columns: std::ops::Range<usize>| {
                let rows = around(row).map(|row| (picture * side + row) * side);
                let near = rows.flat_map(|row| &shadows.near[row..][columns.clone()]);
                near.copied().fold(f32::NEG_INFINITY, f32::max)
            };
            for (column, far) in far[..used].iter_mut().enumerate() {
                *far = greatest(around(column));
            }
        }
        cells.fill(&mut far, f32::max);
        Self { cells, far }
    }

    /// Copies the volumes to another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<LitVolumes<B::Memory>, Error> {
        Ok(LitVolumes {
            cells: self.cells.clone(),
            far: backend.upload(&self.far)?,
        })
    }
}

/// Texels around a cell that count as part of it.
pub(super) fn margin(cells: &Cells) -> u32 {
    let margins = cells.pictures.iter().map(|picture| picture.margin());
    margins.fold(1.0, f64::max).ceil() as u32
}

/// The allowance for the depths of a map, as a factor and in metres, for rounding of positions.
pub(super) fn allowance(face: &Face) -> [f32; 2] {
    let reach = match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => half_width + half_height,
        Rays::Central { .. } => 0.0,
    };
    let scale = f64::from(face.origin.abs().max_element() + reach);
    [(1.0 + DEPTH + POSITION) as f32, (POSITION * scale) as f32]
}

/// The direction of the centre of a texel, which may be outside of the picture.
fn direction(face: &Face, tan: f32, resolution: u32, [column, row]: [i64; 2]) -> DVec3 {
    let at = |texel: i64| f64::from(tan) * ((2 * texel + 1) as f64 / f64::from(resolution) - 1.0);
    let [right, up, forward] = [face.right, face.up, face.forward].map(|v| v.as_dvec3());
    forward + at(column) * right - at(row) * up
}

impl BuildLitVolumes for Cpu {
    fn lit_volumes(&self, map: &ShadowMap<Host>) -> Result<LitVolumes<Host>, Error> {
        let cells = Cells::new(map.faces(), map.resolution());
        let (side, n) = (cells.side as usize, i64::from(map.resolution()));
        let margin = i64::from(margin(&cells));
        let texels = |cell: usize| {
            let from = cell as i64 * i64::from(cells.cell) - margin;
            let to = (cell + 1) as i64 * i64::from(cells.cell) + margin;
            from.max(-margin)..to.min(n + margin)
        };
        let depth = |face: usize, [column, row]: [i64; 2]| -> f32 {
            let inside = |texel: i64| (0..n).contains(&texel);
            if inside(column) && inside(row) {
                let index = (face as i64 * n + row) * n + column;
                return map.depth()[index as usize];
            }
            match map.faces()[face].rays {
                Rays::Central { tan } if map.faces().len() > 1 => {
                    let v = direction(&map.faces()[face], tan, map.resolution(), [column, row]);
                    let other = cube_face(v);
                    let at = cells.pictures[other].of_point(v);
                    // Conversions saturate.
                    let [x, y] = [at.x, at.y].map(|t| ((t / at.z) as i64).min(n - 1));
                    map.depth()[((other as i64 * n + y) * n + x) as usize]
                }
                _ => 0.0,
            }
        };
        let [factor, more] = allowance(&map.faces()[0]);
        let mut far = self.zeros::<f32>(cells.len())?;
        let finest = cells.finest();
        self.for_each_chunk(&mut far[..finest], side, |first, chunk| {
            let (face, row) = (first / side / side, first / side % side);
            let mut each = Vec::new();
            for (column, far) in chunk.iter_mut().enumerate() {
                let columns = texels(column);
                let start = columns.start.clamp(0, n);
                let inside = start..columns.end.clamp(start, n);
                each.clear();
                each.resize((inside.end - inside.start) as usize, 0.0_f32);
                let mut greatest = 0.0_f32;
                for row in texels(row) {
                    // Texels that are certainly inside of the picture need no test.
                    let at_once = match (0..n).contains(&row) {
                        true => inside.clone(),
                        false => columns.start..columns.start,
                    };
                    if !at_once.is_empty() {
                        let first = ((face as i64 * n + row) * n + at_once.start) as usize;
                        for (greatest, depth) in each.iter_mut().zip(&map.depth()[first..]) {
                            *greatest = greatest.max(*depth);
                        }
                    }
                    let before = columns.start..at_once.start;
                    let behind = at_once.end.max(columns.start)..columns.end;
                    for column in before.chain(behind) {
                        greatest = greatest.max(depth(face, [column, row]));
                    }
                }
                greatest = each.iter().copied().fold(greatest, f32::max);
                *far = (greatest.min(NOTHING) * factor + more).min(NOTHING);
            }
        });
        cells.fill(&mut far, f32::max);
        Ok(LitVolumes { cells, far })
    }
}
