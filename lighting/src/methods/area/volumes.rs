//! The voxels of many lights for one view.

use epipolar::Lattice;
use glam::Vec3;
use gpu_backend::{Backend, Host, Memory};
use voxel_shadow::{AtlasGrid, AtlasMap, BuildAtlas, RectifyAtlas, ShadowVolume};

use super::SurfaceLookup;
use crate::Emitter;
use crate::shadow_map::{ShadowMapAtlas, TileMaps};
use crate::visibility::SurfaceShadow;
use crate::voxelized::{Eye, Resolution, Sampling, State, VoxelError};

/// A backend that makes the voxels of many lights from their shadow maps: every
/// backend of this workspace.
pub trait BuildLightVolumes:
    BuildAtlas + for<'a> RectifyAtlas<TileMaps<'a, <Self as Backend>::Memory>>
{
}

impl<B> BuildLightVolumes for B where
    B: BuildAtlas + for<'a> RectifyAtlas<TileMaps<'a, <B as Backend>::Memory>>
{
}

/// The voxels of many lights: what a [`VoxelVolume`](crate::voxelized::VoxelVolume)
/// has for one, for all of them in one buffer.
///
/// Each light has an epipolar space of its own, turned around its axis by an angle
/// that depends on where the light is: the sampling errors of the lights average
/// instead of lining up as bands.
#[derive(Debug)]
pub struct LightVolumes<M: Memory> {
    map: AtlasMap<M>,
    grid: AtlasGrid<M>,
    sampling: Sampling,
    /// The state of each light; its voxels are those of a tile.
    lights: Vec<State<usize>>,
    /// The lattices of the tiles.
    lattices: Vec<Lattice>,
}

impl<M: Memory> LightVolumes<M> {
    /// Memory for the voxels of at most `lights` lights, which are read without a bias and with
    /// interpolation.
    ///
    /// # Errors
    /// [`VoxelError::Voxels`] if they do not fit into memory; see
    /// [`BuildAtlas::atlas_capacity`].
    pub fn new<B>(backend: &B, resolution: Resolution, lights: usize) -> Result<Self, VoxelError>
    where
        B: Backend<Memory = M>,
    {
        Ok(Self {
            map: AtlasMap::new(backend, resolution, lights)?,
            grid: AtlasGrid::new(backend, resolution, lights)?,
            sampling: Sampling::UNBIASED,
            lights: Vec::new(),
            lattices: Vec::new(),
        })
    }

    /// The same volumes with other biases or without interpolation. They have no lights until
    /// [`LightVolumes::update`], which checks the biases.
    #[must_use]
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        Self {
            sampling,
            lights: Vec::new(),
            ..self
        }
    }

    /// Makes the voxels of all `emitters` anew from their shadow maps, which must belong to the
    /// same emitters in the same order. One pass rectifies all maps, and another builds all
    /// grids. A light that needs no voxels, because all rays or no rays are lit, has no tile.
    ///
    /// # Errors
    /// [`VoxelError::Voxels`] if there are more lights than there is room for, if there are not
    /// as many maps as lights, for biases beyond ±1024 voxels, and if the backend fails;
    /// [`VoxelError::Epipolar`] as for
    /// [`VoxelVolume::update`](crate::voxelized::VoxelVolume::update). After an error there are
    /// no lights.
    pub fn update<B>(
        &mut self,
        backend: &B,
        emitters: &[Emitter],
        eye: &Eye,
        maps: &ShadowMapAtlas<M>,
    ) -> Result<(), VoxelError>
    where
        B: BuildLightVolumes + Backend<Memory = M>,
    {
        self.lights.clear();
        self.lattices.clear();
        let mut lights = Vec::with_capacity(emitters.len());
        let mut of_tiles = Vec::new();
        for (light, emitter) in (0..).zip(emitters) {
            let state = eye.lattice(emitter, self.grid.resolution(), turn(emitter))?;
            lights.push(match state {
                State::Lit => State::Lit,
                State::Dark => State::Dark,
                State::Voxels(lattice) => {
                    self.lattices.push(lattice);
                    of_tiles.push(light);
                    State::Voxels(self.lattices.len() - 1)
                }
            });
        }
        let lengths = |actual| gpu_backend::Error::LengthMismatch {
            what: "the shadow maps of many lights",
            expected: emitters.len(),
            actual,
        };
        let source = maps.of_tiles(&of_tiles);
        let source = source.filter(|_| maps.lights() == emitters.len());
        let source = source.ok_or_else(|| voxel_shadow::Error::from(lengths(maps.lights())))?;
        if let Some(lattice) = self.lattices.first() {
            // This checks the sampling before any work is done.
            self.grid.volume(0, lattice, self.sampling)?;
        }
        backend.rectify_atlas(&self.lattices, &source, &mut self.map)?;
        backend.build_atlas(&self.map, self.lattices.len(), &mut self.grid)?;
        self.lights = lights;
        Ok(())
    }

    /// Number of lights.
    pub fn lights(&self) -> usize {
        self.lights.len()
    }

    /// Number of voxels along each axis, for each light.
    pub fn resolution(&self) -> Resolution {
        self.grid.resolution()
    }

    /// The bits of all tiles.
    pub fn grid(&self) -> &AtlasGrid<M> {
        &self.grid
    }

    /// How voxels are looked up.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        let resolution = self.resolution();
        let tile = 4 * (resolution.words() + resolution.light_rays()) as u64;
        tile * self.grid.tiles() as u64
    }

    /// Checks that there is a volume for each of some lights.
    pub(super) fn are_of(&self, emitters: &[Emitter]) -> Result<(), gpu_backend::Error> {
        if emitters.len() == self.lights() {
            return Ok(());
        }
        Err(gpu_backend::Error::LengthMismatch {
            what: "the voxels of many lights",
            expected: emitters.len(),
            actual: self.lights(),
        })
    }

    /// What is known about a light.
    pub(crate) fn state(&self, light: usize) -> State<(usize, &Lattice)> {
        match self.lights[light] {
            State::Lit => State::Lit,
            State::Dark => State::Dark,
            State::Voxels(tile) => State::Voxels((tile, &self.lattices[tile])),
        }
    }
}

impl<M: Memory> LightVolumes<M> {
    /// The lights that have voxels, in order, with their lattices. The first of them has the
    /// first tile of [`LightVolumes::grid`], and so on.
    pub fn with_voxels(&self) -> impl Iterator<Item = (usize, &Lattice)> {
        let lights = self.lights.iter().enumerate();
        lights.filter_map(|(light, state)| match state {
            State::Voxels(tile) => Some((light, &self.lattices[*tile])),
            State::Lit | State::Dark => None,
        })
    }
}

impl LightVolumes<Host> {
    /// The shadow volume of a light.
    pub(crate) fn volume(&self, light: usize) -> State<ShadowVolume<'_, Host>> {
        match self.state(light) {
            State::Lit => State::Lit,
            State::Dark => State::Dark,
            // It was checked when the voxels were made.
            State::Voxels((tile, lattice)) => self
                .grid
                .volume(tile, lattice, self.sampling)
                .map_or(State::Lit, State::Voxels),
        }
    }

    /// The shadows of a light on surfaces that the eye sees, from the same voxels, with the
    /// biases that keep lit surfaces from shadowing themselves ([`Sampling::PAPER`]). For an
    /// index of no light nothing is in shadow.
    pub fn on_surfaces(&self, light: usize, lookup: SurfaceLookup) -> SurfaceVoxels<'_> {
        let volume = match self.lights.get(light) {
            Some(State::Voxels(tile)) => {
                let lattice = &self.lattices[*tile];
                self.grid.volume(*tile, lattice, lookup.sampling()).ok()
            }
            _ => None,
        };
        SurfaceVoxels { volume }
    }
}

/// The voxels of a light as shadows on surfaces; see
/// [`LightVolumes::on_surfaces`].
#[derive(Debug)]
pub struct SurfaceVoxels<'a> {
    volume: Option<ShadowVolume<'a, Host>>,
}

impl SurfaceShadow for SurfaceVoxels<'_> {
    fn visibility(&self, point: Vec3, _normal: Vec3) -> Vec3 {
        let volume = self.volume.as_ref();
        Vec3::splat(volume.map_or(1.0, |volume| volume.visibility(point)))
    }
}

/// The angle by which the space of a light is rotated, radians. It depends on the light alone
/// and not on its place in a list, and follows no pattern over lights.
fn turn(emitter: &Emitter) -> f32 {
    let Emitter::Point(point) = emitter else {
        return 0.0;
    };
    let position = point.position().to_array();
    let mixed = position.iter().fold(0x9E37_79B9_u32, |hash, x| {
        let hash = (hash ^ x.to_bits()).wrapping_mul(0x85EB_CA6B);
        (hash ^ (hash >> 15)).wrapping_mul(0xC2B2_AE35)
    });
    std::f32::consts::TAU * ((mixed ^ (mixed >> 16)) >> 8) as f32 / (1_u32 << 24) as f32
}
