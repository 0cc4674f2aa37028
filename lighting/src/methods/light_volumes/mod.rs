//! Light volumes: the lit space of a light, bounded by a mesh made from its shadow map.
//!
//! Based on: Billeter, Sintorn and Assarsson, Real Time Volumetric Shadows using
//! Polygonal Light Volumes, HPG 2010.
//!
//! The paper turns every texel of a shadow map into a vertex at its depth, connects the
//! vertices to a mesh that is coarse where the map is flat, and closes the mesh along the
//! borders of the light's cone. A ray from the eye is lit between a face by which it enters
//! this volume and the face by which it leaves.
//!
//! # The mesh
//!
//! The vertices are the centres of texels. A *cell* lies between four of them; there is one
//! more row and column of cells on either side, so that cells cover the whole picture. Each
//! vertex stores its height: the depth in parallel light, and −1/z for a point light, which
//! makes planes linear over the picture. If a square of cells is within a tolerance of two
//! triangles between its corners, it is one *patch*, of up to 64 × 64 cells. So floors and
//! walls are a few triangles, whatever their slope. The tolerance is a number of texel widths
//! at the distance of each vertex. Every other cell consists of two triangles whose common edge
//! joins the two corners with more similar heights.
//!
//! # Error
//!
//! Runs end where the ray crosses a triangle or the wall between two patches. This is within
//! half a texel, sideways, of where the texels of the map end them, and within the tolerance
//! along the light. So lit and dark parts are those of the map, except for a texel, and
//! converge as texels become smaller. Across a smooth surface, the mesh is closer to it than
//! the blocky map. At silhouettes, where most of the error is, the two are alike. Tolerances
//! below a texel change little, because they are below the error of the map.
//!
//! # How it departs from the paper
//!
//! * The paper draws all triangles and adds at each pixel the airlight from the eye to each of
//!   them, with a sign. This takes blending of floats, which WebGPU does not guarantee, a
//!   single closed form of the airlight, and differences of sums that may be much larger than
//!   the result. Here each ray walks through the mesh and yields its lit parts in order, so
//!   that any [evaluator](crate::AirlightEvaluator) can integrate them. The sums are the same.
//!   An eye inside the volume, behind the light or at the light, and rays that start elsewhere,
//!   need no special cases, and nothing is clipped.
//! * A ray walks through a quadtree with the smallest and the largest height of every square of
//!   cells, so that it visits the mesh only near its surface.
//! * Patches of different size meet at walls along the light, instead of at triangles that fit
//!   both. A point is lit if it is in front of the patch that the light sees there, whatever
//!   the neighbours are. So there are no cracks to close.
//! * A cell whose corners are farther apart than any surface would make them is a silhouette.
//!   The paper's triangles between a caster and the surface behind it widen the shadow by up to
//!   half a texel, and more the farther behind the surface is. Here such a cell has a wall in
//!   the middle: each of its four quarters has the height of its corner. The same holds between
//!   a caster and empty texels.
//!
//! # Cost
//!
//! The mesh depends on the map alone and serves all views. It takes four bytes per texel for
//! the heights and three for the quadtree, and is made in a fifth of the time of the map.
//! Finding runs takes about 1.7 times as long as with the trees of
//! [`epipolar`](crate::methods::epipolar), which are made anew for each view, and as long as a
//! march of 64 steps. This is for a city in 480 × 270 pixels and a map of 1024 texels per side,
//! whose mesh has 3.6 times fewer patches than cells.
//!
//! # Limits
//!
//! Within half a texel of the border of a picture, heights are those of the last texels.
//! Distances are at most 1e18 m. Some software drivers end all loops of a shader after 65,535
//! iterations. A ray takes about five for each texel that it crosses where nothing is flat, and
//! the nodes of its evaluator for each run: maps of hair or leaves with more than 8192 texels
//! per side may exceed this.

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

/// The lit space of a light, as its shadow map gives it.
#[derive(Debug)]
pub struct LightVolume<M: Memory> {
    faces: Vec<Face>,
    projections: Vec<Projection>,
    layout: Layout,
    /// The heights of the vertices, face by face, each row by row from the top.
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
    /// Number of patches in the mesh, each of which is two triangles or the wall of a
    /// silhouette. The cost is linear in the number of texels.
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

    /// Calls `emit` for the lit runs of a part of a line.
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
