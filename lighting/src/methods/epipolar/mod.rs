//! Exact lit runs of a shadow map, by min–max trees along epipolar lines.
//!
//! Based on: Chen, Baran, Durand and Jarosz, Real-Time Volumetric Shadows using 1D
//! Min-Max Mipmaps, I3D 2011; Yusov, High-Performance Outdoor Light Scattering
//! Using Epipolar Sampling, GPU Pro 5, 2014.
//!
//! A ray is a straight line in the light's picture, and all rays of an epipolar plane (a plane
//! through eye and light) lie on the same line. A tree along this line that stores the smallest
//! and the largest depth of each part tells which parts of a ray are wholly lit or wholly dark.
//!
//! # Which surface
//!
//! It is the surface of the point test [`ShadowMap::is_lit`]: a point is lit if it is no deeper
//! than the texel into which it is projected. Along a ray, a texel is an interval that ends
//! where the ray crosses the borders of the texel. The lit part of it is another interval: the
//! part within a sphere around the light, or in front of a plane perpendicular to parallel
//! light. The runs of a ray are the union of these, in f64; a march converges to them.
//!
//! # How it departs from the papers
//!
//! The papers resample the map along the lines, and their result is exact for the resampled
//! map. Here a line is a slice between two epipolar lines that is at most a texel wide, unless
//! that makes too many slices. Its cells are columns or rows of texels, whichever it crosses
//! more of. Its tree stores bounds of *all* texels that any ray of the slice may meet in a
//! cell, and of a few beside them. Where the bounds do not decide, a leaf of eight cells is
//! walked texel by texel. So a ray gets the same bits as if all of its texels were walked.
//!
//! Distances are compared instead of rectified depths, so that eyes behind the light and all
//! kinds of pictures need no special cases. A cube has lines in each of its faces.
//!
//! # Cost
//!
//! A map has the bounds of [blocks](MapBlocks) of eight texels, which serve all views. Trees
//! are made anew for each view, for as many lines as its rays need; a leaf is made from the
//! half dozen blocks that it meets. A ray visits about ten nodes for each of its runs. Rays
//! that do not start at the eye, those that pass very close to the light, and those beside the
//! lines are walked.

mod blocks;
mod fan;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
#[cfg(feature = "methods")]
pub mod sampling;
#[cfg(test)]
mod tests;
mod tree;
mod walk;

use std::borrow::Borrow;

use gpu_backend::{Backend, Error, Host, Memory};

pub use blocks::{BuildMapBlocks, MapBlocks};
pub use fan::Fans;
pub use tree::{BuildLineTrees, Node};

use fan::eye_picture;
#[cfg(feature = "methods")]
pub(super) use method::methods;
use tree::{Tally, search};
use walk::Walk;

use crate::scene::{Emitter, Medium};
use crate::shadow_map::ShadowMap;
use crate::shadow_map::line::{Line, Part, Projection, Runs};
use crate::{Interval, LightPath, LitInterval, Ray, VisibilitySource};

/// The lit runs of rays, exactly as a shadow map gives them; the map is borrowed or shared.
#[derive(Debug)]
pub struct MapRuns<P, M: Memory> {
    map: P,
    projections: Vec<Projection>,
    /// `None` if all rays are walked.
    trees: Option<Trees<M>>,
}

#[derive(Debug)]
struct Trees<M: Memory> {
    fans: Fans,
    nodes: M::Buffer<Node>,
}

/// How much the search for the runs of a ray visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Visits {
    /// Nodes of trees.
    pub nodes: u64,
    /// Texels.
    pub texels: u64,
    /// Runs that were found.
    pub runs: u64,
}

impl<P: Borrow<ShadowMap<M>>, M: Memory> MapRuns<P, M> {
    /// Trees for `rays`, most of which should start where the first one does.
    ///
    /// `map` must be that of `emitter`, and `medium` the medium along the rays.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the trees do not fit into memory.
    pub fn new<B>(
        backend: &B,
        map: P,
        rays: &[Ray],
        emitter: &Emitter,
        medium: &Medium,
    ) -> Result<Self, Error>
    where
        B: BuildMapBlocks + BuildLineTrees + Backend<Memory = M>,
    {
        let blocks = backend.map_blocks(map.borrow())?;
        Self::with_blocks(backend, map, &blocks, rays, emitter, medium)
    }

    /// The same from blocks of the map that were made before; as long as the map stays the same
    /// they serve every view.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the trees do not fit into memory,
    /// [`Error::LengthMismatch`] if the blocks belong to a map of another size.
    pub fn with_blocks<B>(
        backend: &B,
        map: P,
        blocks: &MapBlocks<M>,
        rays: &[Ray],
        emitter: &Emitter,
        medium: &Medium,
    ) -> Result<Self, Error>
    where
        B: BuildLineTrees + Backend<Memory = M>,
    {
        let shadow_map = map.borrow();
        blocks.check(shadow_map)?;
        let faces = shadow_map.faces();
        let fans = Fans::of_view(faces, shadow_map.resolution(), rays, emitter, medium);
        let nodes = backend.line_trees(blocks, &fans)?;
        Ok(Self {
            trees: Some(Trees { fans, nodes }),
            ..Self::walked(map)
        })
    }

    /// The same runs without trees: every texel that a ray crosses is visited.
    pub fn walked(map: P) -> Self {
        Self {
            projections: map.borrow().faces().iter().map(Projection::new).collect(),
            map,
            trees: None,
        }
    }

    /// The map.
    pub fn map(&self) -> &ShadowMap<M> {
        self.map.borrow()
    }

    /// Memory of the trees, bytes.
    pub fn bytes(&self) -> u64 {
        let nodes = self.trees.as_ref().map_or(0, |trees| trees.fans.nodes);
        size_of::<Node>() as u64 * nodes as u64
    }
}

impl<P: Borrow<ShadowMap<Host>>> MapRuns<P, Host> {
    /// Calls `emit` for the runs of a path, and counts visits in `tally`.
    #[inline]
    fn runs(
        &self,
        path: &LightPath<'_>,
        line: &Line,
        emit: impl FnMut(Part),
        tally: &mut impl Tally,
    ) {
        let map = self.map.borrow();
        let side = map.resolution() as usize;
        let trees = self
            .trees
            .as_ref()
            .filter(|trees| trees.fans.eye == path.ray().origin());
        let span = path.span();
        let span = [line.position(span.start), line.position(span.end)];
        let mut runs = Runs::new(emit);
        line.for_each_picture(&self.projections, span, |face, a, b| {
            let Some(face) = face else {
                runs.push([a, b]);
                return;
            };
            let projection = &self.projections[face];
            let pictures = line.pictures(projection);
            let walk = Walk::new(line, pictures, [a, b], map.resolution());
            let texels = &map.depth()[face * side * side..(face + 1) * side * side];
            let found = trees.and_then(|trees| {
                let eye = eye_picture(projection, trees.fans.eye, &map.faces()[0]);
                let (fan, slice) = trees.fans.find(&walk, face, eye, pictures[1])?;
                let per_slice = fan.nodes_per_slice() as usize;
                let first = fan.nodes as usize + slice as usize * per_slice;
                Some((fan, &trees.nodes[first..first + per_slice]))
            });
            match found {
                Some((fan, tree)) => {
                    let tree = (fan, tree, map.resolution());
                    search(line, &walk, tree, texels, &mut runs, tally);
                }
                None => tally.texels(walk.add_all(texels, &mut runs)),
            }
        });
        runs.finish();
    }

    /// The ray of a path as the light sees it.
    fn line(&self, path: &LightPath<'_>) -> Line {
        Line::new(path.ray(), &self.map.borrow().faces()[0])
    }

    /// How much the search for the runs of a path visits.
    pub fn visits(&self, path: &LightPath<'_>) -> Visits {
        let mut visits = Visits::default();
        let mut runs = 0;
        self.runs(path, &self.line(path), |_| runs += 1, &mut visits);
        Visits { runs, ..visits }
    }
}

impl Tally for Visits {
    fn node(&mut self) {
        self.nodes += 1;
    }

    fn texels(&mut self, count: u32) {
        self.texels += u64::from(count);
    }
}

impl<P: Borrow<ShadowMap<Host>> + Sync> VisibilitySource for MapRuns<P, Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let line = self.line(path);
        let span = path.span();
        let emit = |run: Part| {
            let [start, end] = run.map(|s| line.distance(s));
            let (start, end) = (start.max(span.start), end.min(span.end));
            if start < end {
                lit.push(LitInterval {
                    interval: Interval::new(start, end),
                    visibility: 1.0,
                });
            }
        };
        self.runs(path, &line, emit, &mut ());
    }
}
