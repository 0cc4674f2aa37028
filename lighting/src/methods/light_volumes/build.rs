//! Making the mesh of a light volume from a shadow map.

use gpu_backend::{Backend, Cpu, Error, Host};

use super::LightVolume;
use super::mesh::{LARGEST_PATCH, Layout, Mesh, NEAREST, Node};
use crate::scene::raster::{Face, Rays};
use crate::shadow_map::{EMPTY, ShadowMap};

/// A backend that makes light volumes from shadow maps.
pub trait BuildLightVolume: Backend {
    /// The light volume of a map. Its patches are within `tolerance` texel widths of the depth
    /// of every texel. Negative tolerances and NaN count as 0, for which only cells of equal
    /// height form patches.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it does not fit into memory. It takes twice as much as the map.
    fn light_volume(
        &self,
        map: &ShadowMap<Self::Memory>,
        tolerance: f32,
    ) -> Result<LightVolume<Self::Memory>, Error>;
}

/// The height of a vertex in a column and a row of a picture.
fn height(face: &Face, resolution: u32, [column, row]: [usize; 2], depth: f32) -> f32 {
    if depth == EMPTY {
        return EMPTY;
    }
    match face.rays {
        Rays::Parallel { .. } => depth,
        Rays::Central { tan } => {
            let at = |texel: usize| {
                let centre = (2 * texel + 1) as f32 / resolution as f32 - 1.0;
                centre * tan
            };
            let (x, y) = (at(column), at(row));
            // The depth is the length of the way to the texel, which is z times this root.
            -(x * x + y * y + 1.0).sqrt() / depth.max(NEAREST)
        }
    }
}

impl BuildLightVolume for Cpu {
    fn light_volume(
        &self,
        map: &ShadowMap<Host>,
        tolerance: f32,
    ) -> Result<LightVolume<Host>, Error> {
        let (faces, resolution) = (map.faces(), map.resolution());
        let layout = Layout::new(faces, resolution, tolerance);
        let side = resolution as usize;
        let mut heights = self.zeros(layout.vertices())?;
        self.for_each_chunk(&mut heights, side, |first, chunk| {
            let (face, row) = (first / side / side, first / side % side);
            for (column, vertex) in chunk.iter_mut().enumerate() {
                let depth = map.depth()[first + column];
                *vertex = height(&faces[face], resolution, [column, row], depth);
            }
        });
        let mut nodes = self.zeros::<Node>(layout.nodes())?;
        for level in 1..=layout.levels() {
            let (range, side) = layout.level(level);
            let (finer, own) = nodes.split_at_mut(range.start);
            let mesh = Mesh {
                layout: &layout,
                heights: &heights,
                nodes: finer,
            };
            self.for_each_chunk(&mut own[..range.len()], side, |first, row| {
                let (face, y) = (first / side / side, first / side % side);
                for (x, node) in row.iter_mut().enumerate() {
                    *node = mesh.new_node(face, level, x as i64, y as i64);
                }
            });
        }
        Ok(LightVolume::new(faces, layout, heights, nodes))
    }
}

impl Mesh<'_> {
    /// The node of a level, made from those of the next finer one.
    fn new_node(&self, face: usize, level: u32, x: i64, y: i64) -> Node {
        let mut bounds = [EMPTY, f32::MIN];
        let mut is_flat = level <= LARGEST_PATCH;
        if level == 1 {
            bounds = self.bounds_of_cells(face, x, y);
        } else {
            let last = i64::from(self.layout.side(level - 1)) - 1;
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let (x, y) = (2 * x + i, 2 * y + j);
                if x <= last && y <= last {
                    let [first, second] = self.node(face, level - 1, x, y);
                    bounds = [
                        bounds[0].min(first.min(second)),
                        bounds[1].max(first.max(second)),
                    ];
                    is_flat &= first >= second;
                }
            }
        }
        let [least, greatest] = bounds;
        match is_flat && greatest < EMPTY && self.is_flat(face, level, x, y) {
            true => [greatest, least],
            false => [least, greatest],
        }
    }
}
