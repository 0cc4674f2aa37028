//! Light volumes: the lit space of a light, bounded by a mesh made from its shadow map.
//!
//! Based on: Billeter, Sintorn and Assarsson, Real Time Volumetric Shadows using
//! Polygonal Light Volumes, HPG 2010.
//!
//! The paper turns every texel of a shadow map into a vertex at its depth, connects them
//! to a mesh that is coarse where the map is flat, and closes it along the borders of the
//! light's cone. A ray of the eye is in light between a face by which it enters this
//! volume and one by which it leaves.
//!
//! # The mesh
//!
//! Texels' centres are the vertices; a *cell* lies between four of them, and there is one
//! more on either side, so that cells cover the whole picture. What is stored of a vertex
//! is its height: the depth in parallel light, and −1/z for a light at a point, which make
//! planes linear over the picture. Cells that lie within a tolerance of two triangles
//! between the corners of a square of them are one *patch*, up to 64 × 64 cells: floors and
//! walls are a few triangles, whatever their slope. The tolerance is a number of texels'
//! widths, at the distance of each vertex. Cells that are left are two triangles each,
//! whose common edge joins the two corners that are more alike.
//!
//! # Error
//!
//! Runs end where the ray crosses a triangle or the wall between two patches: within half a
//! texel, sideways, of where the texels of the map end them, and within the tolerance along
//! the light. So they are lit and dark where the map is, but for a texel, and converge as texels
//! shrink. Across a smooth surface the mesh is nearer to it than the blocks of the map are; at
//! silhouettes, where most of the error is, the two are alike. Tolerances below a texel change
//! little: they are below what the map misses.
//!
//! # How it departs from the paper
//!
//! * The paper draws all triangles and adds, at each pixel, the airlight from the eye to each
//!   of them with a sign. That takes blending of floats, which WebGPU does not promise, one
//!   closed form of the airlight, and differences of sums that may be much larger than their
//!   result. Here each ray walks through the mesh and yields its lit parts in order, so that any
//!   [evaluator](crate::AirlightEvaluator) integrates them. The sums are the same. Eyes inside
//!   of the volume, behind the light or at it, and rays that start elsewhere are no special
//!   cases, and nothing is clipped.
//! * A ray walks through a quadtree that has the least and the greatest height of every square
//!   of cells, so that it looks at the mesh near its surface only.
//! * Patches of different size meet at walls along the light instead of at triangles that are
//!   fitted to each other: a point is lit if it lies before the patch that the light sees there,
//!   whatever its neighbours are, so that there are no cracks to close.
//! * A cell whose corners are farther apart than any surface would make them is a silhouette. The
//!   paper's triangles between a caster and what lies behind it widen the shadow by up to half a
//!   texel, more the farther behind. Here such a cell is a wall halfway: its four quarters have the
//!   heights of their corners. So are those between a caster and nothing.
//!
//! # Cost
//!
//! The mesh depends on the map alone and serves all views: four bytes for the height of a
//! texel and three for the quadtree, made in a fifth of the time of the map. Runs take about 1.7
//! times as long as by the trees of [`epipolar`](crate::methods::epipolar), which are made
//! anew for each view, and as long as a march of 64 steps: of a city in 480 × 270 pixels with
//! a map of 1024 texels a side, whose mesh has 3.6 times fewer patches than cells.
//!
//! # Limits
//!
//! Within half a texel of the border of a picture heights are those of its last texels. Distances are
//! at most 1e18 m. Some software drivers end all loops of a shader after 65,535 turns, of
//! which a ray takes about five for each texel that it crosses where nothing is flat, and
//! the nodes of its evaluator for each run: maps of more than 8192 texels of hair or leaves
//! may exceed that.

mod build;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
mod mesh;
#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
mod tests;
mod walk;

use gpu_backend::{Host, Memory};

pub use build::BuildLightVolume;
use mesh::{Layout, Mesh, Node};
#[cfg(feature = "methods")]
pub(super) use method::methods;
use walk::{FARTHEST, Track};

use crate::scene::raster::Face;
use crate::shadow_map::line::{Line, Part, Projection, Runs};
use crate::{Interval, LightPath, LitInterval, VisibilitySource};

/// The lit space of a light, as far as its shadow map tells.
#[derive(Debug)]
pub struct LightVolume<M: Memory> {
    faces: Vec<Face>,
    projections: Vec<Projection>,
    layout: Layout,
    /// Of the vertices, face by face, each row by row from the top.
    heights: M::Buffer<f32>,
    nodes: M::Buffer<Node>,
}

impl<M: Memory> LightVolume<M> {
    fn new(
        faces: &[Face],
        layout: Layout,
        heights: M::Buffer<f32>,
        nodes: M::Buffer<Node>,
    ) -> Self {
        Self {
            projections: faces.iter().map(Projection::new).collect(),
            faces: faces.to_vec(),
            layout,
            heights,
            nodes,
        }
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        let heights = self.layout.vertices() * size_of::<f32>();
        (heights + self.layout.nodes() * size_of::<Node>()) as u64
    }
}

impl LightVolume<Host> {
    /// Patches of the mesh: two triangles each, or the wall of a silhouette.
    ///
    /// Linear in the number of texels.
    pub fn patches(&self) -> usize {
        self.mesh().patches()
    }

    fn mesh(&self) -> Mesh<'_> {
        Mesh {
            layout: &self.layout,
            heights: &self.heights,
            nodes: &self.nodes,
        }
    }

    /// Calls `emit` for the lit runs of the part of a line.
    fn runs(&self, line: &Line, span: Part, emit: impl FnMut(Part)) {
        let mut runs = Runs::new(emit);
        line.for_each_picture(&self.projections, span, |face, a, b| match face {
            None => runs.push([a, b]),
            Some(face) => {
                let pictures = line.pictures(&self.projections[face]);
                let track = Track::new(line, pictures, [a, b], self.layout.resolution());
                track.add_lit(&self.mesh(), face, &mut runs);
            }
        });
        runs.finish();
    }
}

impl VisibilitySource for LightVolume<Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let line = Line::new(path.ray(), &self.faces[0]);
        let span = path.span();
        let start = line.position(span.start);
        let end = line.position(span.end).min(FARTHEST.max(4.0 * start.abs()));
        self.runs(&line, [start, end], |run: Part| {
            let from = line.distance(run[0]).max(span.start);
            let to = match run[1] < end {
                true => line.distance(run[1]).min(span.end),
                false => span.end,
            };
            if from < to {
                lit.push(LitInterval {
                    interval: Interval::new(from, to),
                    visibility: 1.0,
                });
            }
        });
    }
}
