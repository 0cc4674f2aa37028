//! The voxels of one light for one view, and the steps that make them.

use std::f32::consts::FRAC_PI_2;

use epipolar::{Lattice, Light, Resolution, Space, Spacing, ViewVolume};
use glam::Vec3;
use gpu_backend::{Backend, Memory};
use voxel_shadow::{
    BuildGrid, Grid, IndexMap, Rectify, RectifyMasked, RectifyTriangles, Sampling, ShadowVolume,
};

use super::{Detail, VoxelShadow};
use crate::path::depth_range;
use crate::scene::{Camera, Emission, Medium};
use crate::shadow_map::{Casters, ShadowMap};
use crate::{Emitter, Interval, Ray};

/// Why voxels could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// The view, the light or the spacing cannot be used.
    #[error(transparent)]
    Epipolar(#[from] epipolar::Error),
    /// A step of making the voxels failed.
    #[error(transparent)]
    Voxels(#[from] voxel_shadow::Error),
}

/// The eye and the rays from it, which define the part of space that is divided into voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// The origin of all rays.
    pub position: Vec3,
    /// Directions through the corners of the picture, in order around it; `None` for all
    /// directions.
    pub corners: Option<[Vec3; 4]>,
    /// The distances along rays between which shadows matter, m; see [`depth_range`]. The end
    /// must be finite for a directional light.
    pub depths: Interval,
    /// How voxels are spaced along a ray, for a point light.
    pub lamp_spacing: Spacing,
    /// How voxels are spaced along a ray, for a directional light.
    pub sun_spacing: Spacing,
}

impl Eye {
    /// The eye of a camera whose picture of `width` × `height` pixels has these rays.
    ///
    /// Voxels of a point light span equal angles, so that there are many near the light. Voxels
    /// of a directional light carry equal airlight, with the mean extinction of the channels.
    /// Equal distances over ten mean free paths would leave few voxels where most of its light
    /// comes from.
    pub fn of_camera(
        camera: &Camera,
        [width, height]: [u32; 2],
        rays: &[Ray],
        medium: &Medium,
    ) -> Self {
        Self {
            position: camera.eye(),
            corners: Some(camera.corners(width, height)),
            depths: depth_range(rays, medium),
            lamp_spacing: Spacing::Angle,
            sun_spacing: Spacing::Airlight {
                sigma_t: medium.sigma_t().element_sum() / 3.0,
            },
        }
    }

    /// The eye for lighting surfaces at distances from `nearest` to `farthest` metres along the
    /// rays of a picture of `width` × `height` pixels, whatever the medium.
    pub fn of_surfaces(
        camera: &Camera,
        [width, height]: [u32; 2],
        [nearest, farthest]: [f32; 2],
    ) -> Self {
        Self {
            position: camera.eye(),
            corners: Some(camera.corners(width, height)),
            depths: Interval::new(nearest, farthest),
            lamp_spacing: Spacing::Angle,
            sun_spacing: Spacing::Angle,
        }
    }

    fn view(&self, emitter: &Emitter) -> Result<ViewVolume, epipolar::Error> {
        let Interval { start, mut end } = self.depths;
        // The view volume refuses an end that is negative or NaN.
        if !(end >= 0.0) {
            return ViewVolume::all_around(start, end);
        }
        // Nothing outside the range of a light is lit.
        if let Emitter::Point(point) = emitter {
            end = end.min(self.position.distance(point.position()) + point.range());
        }
        // An empty range becomes a short one at its start.
        let end = end.max(start + f32::EPSILON * start.max(1.0));
        match self.corners {
            Some(corners) => ViewVolume::new(corners, start, end),
            None => ViewVolume::all_around(start, end),
        }
    }

    /// The lattice of voxels for a light, with θ counted from a direction that is rotated
    /// around the axis by so many radians; or an answer that needs no voxels.
    pub(crate) fn lattice(
        &self,
        emitter: &Emitter,
        resolution: Resolution,
        turned: f32,
    ) -> Result<State<Lattice>, epipolar::Error> {
        let made = || {
            let light = light(emitter)?;
            let view = self.view(emitter)?;
            let space = Space::new(light, self.position)?.rotated(turned);
            let spacing = if space.is_directional() {
                self.sun_spacing
            } else {
                self.lamp_spacing
            };
            Lattice::new(space, &view, resolution, spacing)
        };
        match made() {
            Ok(lattice) => Ok(State::Voxels(lattice)),
            Err(epipolar::Error::EyeAtLight { .. }) => Ok(State::Lit),
            Err(epipolar::Error::Unlit) => Ok(State::Dark),
            Err(error) => Err(error),
        }
    }
}

/// A backend that makes voxels from its shadow maps and from triangles. Every backend of this
/// workspace does.
pub trait BuildVoxels:
    BuildGrid
    + RectifyTriangles
    + RectifyMasked<Casters<<Self as Backend>::Memory>>
    + Rectify<ShadowMap<<Self as Backend>::Memory>>
{
}

impl<B> BuildVoxels for B where
    B: BuildGrid
        + RectifyTriangles
        + RectifyMasked<Casters<<B as Backend>::Memory>>
        + Rectify<ShadowMap<<B as Backend>::Memory>>
{
}

/// What a volume knows about the rays of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum State<V> {
    /// All rays are lit, as far as the light reaches.
    Lit,
    /// No ray is lit.
    Dark,
    /// The voxels tell which parts are lit.
    Voxels(V),
}

/// The voxelized shadow volume of one light as one eye sees it.
///
/// Memory: one bit per voxel, and four bytes per θ and φ.
#[derive(Debug)]
pub struct VoxelVolume<M: Memory> {
    state: State<Box<Lattice>>,
    map: IndexMap<M>,
    grid: Grid<M>,
    sampling: Sampling,
}

impl<M: Memory> VoxelVolume<M> {
    /// A volume without any shadow, read without a bias and with interpolation.
    ///
    /// # Errors
    /// [`VoxelError::Voxels`] if it does not fit into memory.
    pub fn new<B>(backend: &B, resolution: Resolution) -> Result<Self, VoxelError>
    where
        B: Backend<Memory = M>,
    {
        Ok(Self {
            state: State::Lit,
            map: IndexMap::new(backend, resolution)?,
            grid: Grid::new(backend, resolution)?,
            sampling: Sampling::UNBIASED,
        })
    }

    /// The same volume with other biases or without interpolation. It has no shadow until
    /// [`VoxelVolume::update`], which checks the biases.
    #[must_use]
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        Self {
            sampling,
            state: State::Lit,
            ..self
        }
    }

    /// Makes the voxels anew: rectifies the shadow map of `emitter`, sets a voxel for each
    /// light ray in epipolar space, and extrudes these away from the light.
    ///
    /// If the eye is at the light all rays are lit, because an eye there sees no shadow. If the
    /// cone of a spotlight does not reach what is in view, no ray is lit.
    ///
    /// # Errors
    /// [`VoxelError::Epipolar`] for corners that are not those of a pyramid, for depths that
    /// are negative or NaN or, with a directional light, have no end, and for coordinates
    /// beyond 1e18 m; [`VoxelError::Voxels`] for biases beyond ±1024 voxels, or if the backend
    /// fails. After an error the volume has no shadow. shadow after an error.
    pub fn update<B>(
        &mut self,
        backend: &B,
        emitter: &Emitter,
        eye: &Eye,
        map: &ShadowMap<M>,
    ) -> Result<(), VoxelError>
    where
        B: BuildVoxels + Backend<Memory = M>,
    {
        self.update_from(backend, emitter, eye, map)
    }

    /// The same from any source of the light's first blockers: on the CPU a
    /// [`FirstBlocker`](voxel_shadow::FirstBlocker), on a GPU depths that a renderer has drawn
    /// (`voxel_shadow::gpu::DepthLayers`).
    ///
    /// # Errors
    /// Those of [`VoxelVolume::update`].
    pub fn update_from<B, S: ?Sized>(
        &mut self,
        backend: &B,
        emitter: &Emitter,
        eye: &Eye,
        blockers: &S,
    ) -> Result<(), VoxelError>
    where
        B: BuildGrid + Rectify<S> + Backend<Memory = M>,
    {
        self.make(backend, emitter, eye, |lattice, indices| {
            backend.rectify(lattice, blockers, indices)
        })
    }

    /// The same from the triangles themselves, without a shadow map and its error. Every light
    /// ray is intersected with all triangles that it may meet, which takes much longer. Masked
    /// triangles block light outside of their holes.
    ///
    /// # Errors
    /// Those of [`VoxelVolume::update`].
    pub fn update_from_triangles<B>(
        &mut self,
        backend: &B,
        emitter: &Emitter,
        eye: &Eye,
        casters: &Casters<M>,
    ) -> Result<(), VoxelError>
    where
        B: BuildVoxels + Backend<Memory = M>,
    {
        let triangles = casters.triangles();
        self.make(backend, emitter, eye, |lattice, indices| {
            if casters.masked() == 0 {
                return backend.rectify_triangles(lattice, triangles, indices);
            }
            backend.rectify_masked(lattice, triangles, casters, indices)
        })
    }

    fn make<B>(
        &mut self,
        backend: &B,
        emitter: &Emitter,
        eye: &Eye,
        rectify: impl FnOnce(&Lattice, &mut IndexMap<M>) -> Result<(), voxel_shadow::Error>,
    ) -> Result<(), VoxelError>
    where
        B: BuildGrid + Backend<Memory = M>,
    {
        self.state = State::Lit;
        let lattice = match eye.lattice(emitter, self.grid.resolution(), 0.0)? {
            State::Voxels(lattice) => lattice,
            State::Lit => return Ok(()),
            State::Dark => {
                self.state = State::Dark;
                return Ok(());
            }
        };
        // This checks the sampling before any work is done.
        ShadowVolume::new(&lattice, &self.grid, self.sampling)?;
        rectify(&lattice, &mut self.map)?;
        backend.build(&self.map, &mut self.grid)?;
        self.state = State::Voxels(Box::new(lattice));
        Ok(())
    }

    /// The voxels as a visibility source.
    pub fn source(&self, detail: Detail) -> VoxelShadow<&Self, M> {
        VoxelShadow::new(self, detail)
    }

    /// Number of voxels along each axis.
    pub fn resolution(&self) -> Resolution {
        self.grid.resolution()
    }

    /// The lattice of the voxels; `None` if none are needed because all rays or no rays are
    /// lit.
    pub fn lattice_in_use(&self) -> Option<&Lattice> {
        match &self.state {
            State::Voxels(lattice) => Some(lattice),
            State::Lit | State::Dark => None,
        }
    }

    /// The bits, which have a meaning only if there is a [`VoxelVolume::lattice_in_use`].
    pub fn grid(&self) -> &Grid<M> {
        &self.grid
    }

    /// How voxels are looked up.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        let resolution = self.resolution();
        4 * (resolution.words() + resolution.light_rays()) as u64
    }

    pub(crate) fn state(&self) -> State<&Lattice> {
        match &self.state {
            State::Lit => State::Lit,
            State::Dark => State::Dark,
            State::Voxels(lattice) => State::Voxels(lattice),
        }
    }
}

/// The light in the form that the crate `epipolar` takes, with the part of space that it
/// reaches.
fn light(emitter: &Emitter) -> Result<Light, epipolar::Error> {
    match emitter {
        Emitter::Directional(sun) => Light::directional(sun.direction()),
        Emitter::Point(point) => match point.emission() {
            Emission::Isotropic => Light::point(point.position()),
            Emission::Cosine { normal } => Light::spot(point.position(), *normal, FRAC_PI_2),
            Emission::Spot(spot) => {
                let outer = 2.0 * (0.5 * spot.outer_versine()).sqrt().asin();
                // A cone too narrow for f32 is widened to one that is not.
                Light::spot(point.position(), spot.axis(), outer.max(1e-4))
            }
        },
    }
}
