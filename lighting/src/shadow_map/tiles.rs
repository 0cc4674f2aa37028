//! Lookups in the shadow maps of many lights.

use epipolar::LightRay;
use glam::Vec3;
use gpu_backend::{Host, Memory};

use super::ShadowMapAtlas;
use super::map::{EMPTY, cube_face, texel_along};
use super::octahedron::{HEMISPHERE, SPHERE, octahedral};
use crate::scene::raster::{Face, Rays};

/// The maps of some lights of a [`ShadowMapAtlas`]. [`ShadowMapAtlas::of_tiles`] makes it.
#[derive(Debug)]
pub struct TileMaps<'a, M: Memory> {
    pub(crate) maps: &'a ShadowMapAtlas<M>,
    pub(crate) lights: &'a [u32],
}

/// A picture of a light. It has no texels where the light does not shine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Picture<'a> {
    face: &'a Face,
    texels: Option<&'a [f32]>,
    side: u32,
}

/// The pictures of a light.
#[derive(Debug, Clone, Copy)]
pub(super) enum OfLight<'a> {
    Parallel(Picture<'a>),
    /// One perspective picture.
    Narrow(Picture<'a>),
    /// The six faces of a cube, in order.
    Cube([Picture<'a>; 6]),
    /// One octahedral picture of this kind.
    Octahedron(Picture<'a>, u32),
}

impl ShadowMapAtlas<Host> {
    /// The pictures of the light with this index.
    #[inline]
    pub(super) fn of_light(&self, light: usize) -> OfLight<'_> {
        let layout = self.layout();
        let [first, count] = layout.lights[light];
        let side = self.resolution();
        let each = (side as usize).pow(2);
        let picture = |index: usize| {
            let (face, number) = &layout.faces[first as usize + index];
            Picture {
                face,
                texels: number.map(|number| &self.depth()[number as usize * each..][..each]),
                side,
            }
        };
        match count {
            HEMISPHERE | SPHERE => OfLight::Octahedron(picture(0), count),
            6 => OfLight::Cube([0, 1, 2, 3, 4, 5].map(picture)),
            _ => match picture(0).face.rays {
                Rays::Parallel { .. } => OfLight::Parallel(picture(0)),
                Rays::Central { .. } => OfLight::Narrow(picture(0)),
            },
        }
    }
}

impl Picture<'_> {
    /// The depth at a column and a row; [`EMPTY`] outside of the picture.
    #[inline(always)]
    fn at(&self, place: Option<[f32; 2]>) -> f32 {
        let (Some(place), Some(texels)) = (place, self.texels) else {
            return EMPTY;
        };
        // The far border of the picture belongs to the last texel.
        let last = self.side - 1;
        let [column, row] = place.map(|position| (position as u32).min(last) as usize);
        texels[row * self.side as usize + column]
    }

    #[inline(always)]
    fn along(&self, v: Vec3) -> f32 {
        self.at(texel_along(self.face, self.side, v))
    }
}

#[inline(always)]
fn parallel(picture: &Picture<'_>, origin: Vec3) -> f32 {
    let v = origin - picture.face.origin;
    let depth = picture.along(v);
    if depth < EMPTY {
        depth - v.dot(picture.face.forward)
    } else {
        EMPTY
    }
}

#[inline(always)]
fn octahedron(picture: &Picture<'_>, kind: u32, direction: Vec3) -> f32 {
    picture.at(octahedral(picture.face, kind, picture.side, direction))
}

impl OfLight<'_> {
    /// The depth at which light in the direction `direction` meets its first blocker; [`EMPTY`]
    /// if it meets none. Parallel light starts at `origin`, other light at its own position.
    #[inline]
    pub(super) fn first_blocker(&self, origin: Vec3, direction: Vec3) -> f32 {
        match self {
            Self::Parallel(picture) => parallel(picture, origin),
            Self::Narrow(picture) => picture.along(direction),
            Self::Cube(pictures) => pictures[cube_face(direction)].along(direction),
            Self::Octahedron(picture, kind) => octahedron(picture, *kind, direction),
        }
    }
}

impl voxel_shadow::AtlasBlocker for TileMaps<'_, Host> {
    #[inline]
    fn distance(&self, tile: usize, ray: &LightRay) -> f32 {
        let [origin, direction] = [ray.origin, ray.direction].map(Vec3::from);
        let light = self.lights[tile] as usize;
        self.maps.of_light(light).first_blocker(origin, direction)
    }

    /// The kind of the light's pictures is determined once for all rays.
    fn distances(&self, tile: usize, rays: &[LightRay], distances: &mut [f32]) {
        let all = rays.iter().zip(distances);
        match &self.maps.of_light(self.lights[tile] as usize) {
            OfLight::Parallel(picture) => {
                all.for_each(|(ray, found)| *found = parallel(picture, ray.origin.into()));
            }
            OfLight::Narrow(picture) => {
                all.for_each(|(ray, found)| *found = picture.along(ray.direction.into()));
            }
            OfLight::Cube(pictures) => all.for_each(|(ray, found)| {
                let direction = ray.direction.into();
                *found = pictures[cube_face(direction)].along(direction);
            }),
            OfLight::Octahedron(picture, kind) => all.for_each(|(ray, found)| {
                *found = octahedron(picture, *kind, ray.direction.into());
            }),
        }
    }
}
