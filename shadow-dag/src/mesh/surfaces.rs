//! Triangles before any light looks at them.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DVec4, Vec3};
use gpu_backend::Cpu;

use super::closed::Components;
use super::cull::Extents;
use super::sorted::runs;
use super::{Holes, Mesh, Watertightness};
use crate::identity::Identity;
use crate::{Error, LightSpace, Resolution};

/// The triangles of a scene as shadow casters: checked once, and sorted into
/// solids and open surfaces, for any number of lights.
///
/// ```
/// # use shadow_dag::{LightSpace, Resolution, Surfaces};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let surfaces = Surfaces::new(&corners[..], &[[0, 1, 2]][..])?;
/// assert_eq!(surfaces.watertightness().open_edges, 3);
/// let resolution = Resolution::new(64)?;
/// let mesh = surfaces.seen_from(LightSpace::of_voxels(resolution), resolution);
/// # Ok::<(), shadow_dag::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Surfaces<'a> {
    pub(crate) positions: Cow<'a, [[f32; 3]]>,
    pub(crate) indices: Cow<'a, [[u32; 3]]>,
    /// Whether each triangle belongs to a solid.
    pub(crate) closed: Vec<bool>,
    /// Which of them a light can leave out.
    pub(super) extents: Extents,
    /// Whether each triangle has holes, and where; `None` if none has.
    pub(super) holes: Option<(Vec<bool>, Arc<dyn Holes>)>,
    watertightness: Watertightness,
    /// What tells them from others.
    identity: Identity,
}

impl<'a> Surfaces<'a> {
    /// The triangles `indices` of the points `positions`, in the world, front
    /// faces counter-clockwise. Solids may touch, overlap and intersect
    /// themselves. Triangles without area cast no shadow; no triangles at all
    /// are legal.
    ///
    /// Vertices at the same position count as one, so that triangles may bring
    /// corners of their own. [`Surfaces::watertightness`] tells which parts
    /// turned out not to be solids. Takes a time of `n log n`, shared (feature
    /// `rayon`) by the threads of rayon's global pool, or of the one that the
    /// caller is running in.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a coordinate that is not finite,
    /// [`Error::NoSuchVertex`] for an index beyond the positions.
    pub fn new(
        positions: impl Into<Cow<'a, [[f32; 3]]>>,
        indices: impl Into<Cow<'a, [[u32; 3]]>>,
    ) -> Result<Self, Error> {
        Self::sorted(&Cpu::new(), positions.into(), indices.into())
    }

    /// [`Surfaces::new`] on these threads.
    pub(crate) fn sorted(
        cpu: &Cpu,
        positions: Cow<'a, [[f32; 3]]>,
        indices: Cow<'a, [[u32; 3]]>,
    ) -> Result<Self, Error> {
        let first = |len: usize, is_bad: &(dyn Fn(usize) -> bool + Sync)| {
            let found = runs(cpu, len, |mut run| run.find(|&i| is_bad(i)));
            found.into_iter().flatten().next()
        };
        let endless = |vertex: usize| !positions[vertex].iter().all(|x| x.is_finite());
        if let Some(vertex) = first(positions.len(), &endless) {
            return Err(Error::NotFinite {
                vertex,
                position: positions[vertex],
            });
        }
        let vertices = positions.len();
        let missing = |corner: &u32| *corner as usize >= vertices;
        let named = |triangle: usize| indices[triangle].iter().copied().find(missing);
        if let Some(triangle) = first(indices.len(), &|triangle| named(triangle).is_some())
            && let Some(vertex) = named(triangle)
        {
            return Err(Error::NoSuchVertex {
                triangle,
                vertex,
                vertices,
            });
        }
        let points: &[Vec3] = bytemuck::cast_slice(&positions);
        let Components {
            closed,
            extents,
            watertightness,
        } = Components::new(cpu, points, &indices, |_| false);
        Ok(Self {
            identity: Identity::of_triangles(cpu, points, &indices),
            positions,
            indices,
            closed,
            extents,
            holes: None,
            watertightness,
        })
    }

    /// The same with holes in some triangles, by their numbers; numbers that no
    /// triangle has are without effect. Light passes where the ray
    /// through the centre of a texel meets a hole. A part with such a triangle
    /// encloses nothing: all of it casts its shadow as an open surface.
    #[must_use]
    pub fn with_holes(self, triangles: &[u32], holes: Arc<dyn Holes>) -> Self {
        let mut has_holes = vec![false; self.indices.len()];
        for &triangle in triangles {
            if let Some(has_holes) = has_holes.get_mut(triangle as usize) {
                *has_holes = true;
            }
        }
        let points: &[Vec3] = bytemuck::cast_slice(&self.positions);
        let Components {
            closed,
            extents,
            watertightness,
        } = Components::new(&Cpu::new(), points, &self.indices, |triangle| {
            has_holes[triangle]
        });
        let mut identity = Identity::of_triangles(&Cpu::new(), points, &self.indices);
        for &has_holes in &has_holes {
            identity = identity.with(u64::from(has_holes));
        }
        holes.describe(&mut |word| identity = identity.with(word));
        Self {
            closed,
            extents,
            identity,
            holes: Some((has_holes, holes)),
            watertightness,
            ..self
        }
    }

    /// How much of them encloses something.
    pub fn watertightness(&self) -> Watertightness {
        self.watertightness
    }

    /// The corners of triangles in the space of a light.
    pub(super) fn corners(&self, light: &LightSpace) -> impl Fn(usize) -> [DVec4; 3] + Sync + Send {
        let positions: &[Vec3] = bytemuck::cast_slice(&self.positions);
        let (indices, light) = (&self.indices, *light);
        move |triangle| {
            indices[triangle]
                .map(|corner| light.homogeneous(positions[corner as usize].as_dvec3().extend(1.0)))
        }
    }

    /// What tells them from others.
    pub(crate) fn identity(&self) -> Identity {
        self.identity
    }

    /// The triangles as a light sees them, for a grid of `resolution`.
    ///
    /// Only those are taken that may change the grid: beside the map and behind the
    /// last slice there is nothing to see.
    ///
    /// Parts of triangles in front of a perspective light's near distance are
    /// cut off; what is inside of a solid there begins in shadow. Uses the
    /// threads that [`Surfaces::new`] does.
    pub fn seen_from(&self, light: LightSpace, resolution: Resolution) -> Mesh {
        Mesh::of(&Cpu::new(), self, light, resolution)
    }
}
