//! The voxels of one light for one view, and how they are made.

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

/// Why there are no voxels.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// The view, the light or the spacing cannot be used.
    #[error(transparent)]
    Epipolar(#[from] epipolar::Error),
    /// A step failed.
    #[error(transparent)]
    Voxels(#[from] voxel_shadow::Error),
}

/// Where rays start and which of them there are: the part of space that is
/// divided into voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// The origin of all rays.
    pub position: Vec3,
    /// Directions through the corners of the picture, in order around it;
    /// `None` looks everywhere.
    pub corners: Option<[Vec3; 4]>,
    /// Distances along rays between which anything matters, m; see
    /// [`depth_range`]. Must end for a directional light.
    pub depths: Interval,
    /// How voxels are spread along a ray, for a light at a point.
    pub lamp_spacing: Spacing,
    /// The same for a directional light.
    pub sun_spacing: Spacing,
}

impl Eye {
    /// What `rays` of a picture of `width` × `height` pixels show.
    ///
    /// Voxels of a light at a point are equal angles, which are many where it is
    /// near. Those of a directional light carry equal airlight, with the mean
    /// extinction of the channels: equal distances up to ten mean free paths would
    /// be few where its light comes from.
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

    /// What surfaces at distances from `nearest` to `farthest` metres along the rays of a
    /// picture of `width` × `height` pixels are, whatever is in the air before them.
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
        // The view volume refuses an end that is no distance.
        if !(end >= 0.0) {
            return ViewVolume::all_around(start, end);
        }
        // Nothing beyond the range of a light is lit.
        if let Emitter::Point(point) = emitter {
            end = end.min(self.position.distance(point.position()) + point.range());
        }
        // An empty range is one at its start.
        let end = end.max(start + f32::EPSILON * start.max(1.0));
        match self.corners {
            Some(corners) => ViewVolume::new(corners, start, end),
            None => ViewVolume::all_around(start, end),
        }
    }

    /// The voxels for a light, θ counted from a direction that is turned around
    /// the axis by so many radians; or what is known without voxels.
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

/// A backend that makes voxels from its shadow maps and from triangles: every
/// backend of this workspace.
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

/// What a volume says of the rays of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum State<V> {
    /// All of them are lit, as far as the light reaches.
    Lit,
    /// None is.
    Dark,
    /// Voxels tell.
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
    /// A volume without shadow, read without a bias and interpolated.
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

    /// The same with other biases or without interpolation, and without shadow
    /// until [`VoxelVolume::update`], which checks them.
    #[must_use]
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        Self {
            sampling,
            state: State::Lit,
            ..self
        }
    }

    /// Makes the voxels anew: rectifies the shadow map of `emitter`, sets a voxel
    /// for each light ray in epipolar space and extrudes them away from the
    /// light.
    ///
    /// An eye at the light sees no shadow: all rays are lit then. Where the cone
    /// of a spotlight does not reach what is in view, none is.
    ///
    /// # Errors
    /// [`VoxelError::Epipolar`] for corners that are not those of a pyramid,
    /// for depths that are negative or NaN or, with a directional light, without
    /// an end, and for coordinates beyond 1e18 m; [`VoxelError::Voxels`] for
    /// biases beyond ±1024 voxels and if the backend fails. The volume is without
    /// shadow after an error.
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

    /// The same from anything that knows the first blockers of the light: on the CPU a
    /// [`FirstBlocker`](voxel_shadow::FirstBlocker), on a GPU the depths that a renderer has
    /// drawn (`voxel_shadow::gpu::DepthLayers`).
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

    /// The same from the triangles themselves, without a shadow map and without
    /// its error: every light ray is intersected with all that it may meet, which
    /// takes much longer. Masked triangles block where they are there.
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
        // Checks the sampling before any work.
        ShadowVolume::new(&lattice, &self.grid, self.sampling)?;
        rectify(&lattice, &mut self.map)?;
        backend.voxelise(&self.map, &mut self.grid)?;
        backend.extrude(&mut self.grid)?;
        self.state = State::Voxels(Box::new(lattice));
        Ok(())
    }

    /// Its voxels as a visibility source.
    pub fn source(&self, detail: Detail) -> VoxelShadow<&Self, M> {
        VoxelShadow::new(self, detail)
    }

    /// Number of voxels along each axis.
    pub fn resolution(&self) -> Resolution {
        self.grid.resolution()
    }

    /// Where the voxels are; `None` if none are needed, because all rays or no
    /// rays are lit.
    pub fn lattice_in_use(&self) -> Option<&Lattice> {
        match &self.state {
            State::Voxels(lattice) => Some(lattice),
            State::Lit | State::Dark => None,
        }
    }

    /// The bits; of no meaning without [`VoxelVolume::lattice_in_use`].
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

/// A light, with what of space it reaches.
fn light(emitter: &Emitter) -> Result<Light, epipolar::Error> {
    match emitter {
        Emitter::Directional(sun) => Light::directional(sun.direction()),
        Emitter::Point(point) => match point.emission() {
            Emission::Isotropic => Light::point(point.position()),
            Emission::Cosine { normal } => Light::spot(point.position(), *normal, FRAC_PI_2),
            Emission::Spot(spot) => {
                let outer = 2.0 * (0.5 * spot.outer_versine()).sqrt().asin();
                // A cone narrower than f32 tells counts as one that it does.
                Light::spot(point.position(), spot.axis(), outer.max(1e-4))
            }
        },
    }
}
