//! The shadow maps of many lights in one buffer.

use glam::Vec3;
use gpu_backend::{Backend, Buffer, Cpu, Error, Host, Memory};

use super::Casters;
use super::map::{ShadowMapError, check_size, faces, render_face};
use super::tiles::TileMaps;
use crate::Emitter;
use crate::scene::raster::{Face, Rays};
use crate::scene::{Bounds, Emission};

/// The first blocker in every direction from each of many lights. It holds what a
/// [`ShadowMap`](super::ShadowMap) holds for each of them, in one buffer.
///
/// Directions into which a light does not shine have no picture and count as unblocked. For a
/// light with a cosine emission, this leaves out at least one face of the cube.
#[derive(Debug)]
pub struct ShadowMapAtlas<M: Memory> {
    layout: Layout,
    resolution: u32,
    depth: M::Buffer<f32>,
}

/// The pictures of each light.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layout {
    /// The faces of all lights, each with the index of its picture, if it has one.
    pub(crate) faces: Vec<(Face, Option<u32>)>,
    /// For each light, the index of its first face and their number. The number is `HEMISPHERE`
    /// or `SPHERE` if there is a single picture of that kind, in the frame of the face.
    pub(crate) lights: Vec<[u32; 2]>,
    pub(super) pictures: u32,
}

impl Layout {
    pub(crate) fn new(bounds: Bounds, emitters: &[Emitter]) -> Self {
        let mut layout = Self::default();
        for emitter in emitters {
            let of_light = faces(bounds, emitter);
            let (first, count) = (layout.faces.len() as u32, of_light.len() as u32);
            layout.lights.push([first, count]);
            for face in of_light {
                let picture = is_lit(&face, emitter).then_some(layout.pictures);
                layout.pictures += u32::from(picture.is_some());
                layout.faces.push((face, picture));
            }
        }
        layout
    }

    /// The faces that have a picture, in order.
    pub(crate) fn pictured(&self) -> Vec<Face> {
        let all = self.faces.iter();
        all.filter_map(|(face, picture)| picture.map(|_| *face))
            .collect()
    }
}

/// Whether a light shines into a face or its corners.
fn is_lit(face: &Face, emitter: &Emitter) -> bool {
    let (Emitter::Point(point), Rays::Central { tan }) = (emitter, face.rays) else {
        return true;
    };
    let Emission::Cosine { normal } = point.emission() else {
        return true;
    };
    let most =
        normal.dot(face.forward) + tan * (normal.dot(face.right).abs() + normal.dot(face.up).abs());
    most > 0.0
}

impl<M: Memory> ShadowMapAtlas<M> {
    pub(crate) fn from_depth(layout: Layout, resolution: u32, depth: M::Buffer<f32>) -> Self {
        Self {
            layout,
            resolution,
            depth,
        }
    }

    /// Number of lights.
    pub fn lights(&self) -> usize {
        self.layout.lights.len()
    }

    /// Texels per side of each picture.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Depths as in a [`ShadowMap`](super::ShadowMap), picture by picture.
    pub fn depth(&self) -> &M::Buffer<f32> {
        &self.depth
    }

    pub(crate) fn depth_mut(&mut self) -> &mut M::Buffer<f32> {
        &mut self.depth
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        4 * self.depth.len() as u64
    }

    pub(crate) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The maps of some of the lights, as blockers of the tiles of an atlas: tile i belongs to
    /// light `lights[i]`. `None` if one of them has no maps here.
    pub fn of_tiles<'a>(&'a self, lights: &'a [u32]) -> Option<TileMaps<'a, M>> {
        let has_maps = |light: &u32| (*light as usize) < self.lights();
        let all = lights.iter().all(has_maps);
        all.then_some(TileMaps { maps: self, lights })
    }
}

impl ShadowMapAtlas<Host> {
    /// Copies the maps to another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<ShadowMapAtlas<B::Memory>, Error> {
        Ok(ShadowMapAtlas {
            layout: self.layout.clone(),
            resolution: self.resolution,
            depth: backend.upload(&self.depth)?,
        })
    }

    /// True if the map of a light shows no blocker between the light and `point`; true where
    /// the light does not shine.
    ///
    /// # Panics
    /// If there is no light with this index.
    pub fn is_lit(&self, light: usize, point: Vec3) -> bool {
        let [first, _] = self.layout.lights[light];
        let (front, _) = &self.layout.faces[first as usize];
        let v = point - front.origin;
        let blocker = self.of_light(light).first_blocker(point, v);
        match front.rays {
            Rays::Parallel { .. } => blocker >= 0.0,
            Rays::Central { .. } => v.length() <= blocker,
        }
    }
}

/// Backends that render the shadow maps of many lights.
pub trait RenderShadowMapAtlas: Backend {
    /// The maps of `emitters`, with `resolution` texels per side of each picture.
    ///
    /// # Errors
    /// [`ShadowMapError::Resolution`] if the resolution is 0 or above 65536,
    /// [`Error::TooLarge`] if the maps would exceed 4 GiB or what the device can
    /// hold; see [`RenderShadowMapAtlas::map_capacity`].
    fn shadow_map_atlas(
        &self,
        casters: &Casters<Self::Memory>,
        emitters: &[Emitter],
        resolution: u32,
    ) -> Result<ShadowMapAtlas<Self::Memory>, ShadowMapError>;

    /// The largest number of lights whose maps can be read together on this backend, if each
    /// has six faces; 0 if not even the maps of one can.
    fn map_capacity(&self, resolution: u32) -> usize;
}

/// Number of cubes that fit into so many bytes.
pub(crate) fn map_capacity(resolution: u32, bytes: u64) -> usize {
    let cube = 24 * u64::from(resolution.max(1)).pow(2);
    usize::try_from(bytes / cube).unwrap_or(usize::MAX)
}

impl RenderShadowMapAtlas for Cpu {
    /// One unit of work is one picture.
    fn shadow_map_atlas(
        &self,
        casters: &Casters<Host>,
        emitters: &[Emitter],
        resolution: u32,
    ) -> Result<ShadowMapAtlas<Host>, ShadowMapError> {
        let layout = Layout::new(casters.bounds(), emitters);
        let pictured = layout.pictured();
        check_size(pictured.len(), resolution)?;
        let texels = (resolution as usize).pow(2);
        let mut depth = self.zeros::<f32>(pictured.len() * texels)?;
        let (triangles, masked) = (casters.triangles(), casters.masks_on_host());
        self.for_each_chunk(&mut depth, texels, |first, picture| {
            let alone = Cpu::single_threaded();
            let face = &pictured[first / texels];
            render_face(&alone, face, triangles, masked, resolution, picture);
        });
        Ok(ShadowMapAtlas::from_depth(layout, resolution, depth))
    }

    fn map_capacity(&self, resolution: u32) -> usize {
        map_capacity(resolution, 1 << 30)
    }
}
