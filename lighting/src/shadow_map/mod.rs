//! What a light sees: the depth of the first blocker in every direction.
//!
//! * A **directional** light gets one orthographic map over all casters; depth
//!   is the distance along the light.
//! * A **spotlight** of up to 75° half angle gets one perspective map; depth
//!   is the Euclidean distance from the light.
//! * A **point** light, a wider spotlight or a cosine emitter gets six
//!   perspective maps, the faces of a cube, of Euclidean distance.
//! * Any of these outside of the casters' bounding box gets one perspective
//!   map around the box instead where that is narrower.
//!
//! Lookups take the nearest texel and compare without a bias: points in the
//! air have no surface of their own to be shadowed by.
//!
//! [`MapsOfMany`] are those of several lights in one buffer, filtered on surfaces: the
//! shadows of what moves, beside precomputed ones of what stays.
//!
//! [`Depth16Maps`] have 16 bits for a depth, and cascades for a sun: what engines keep, to
//! compare with.
//!
//! A `ShadowMapAtlas` (feature `voxel-shadow`) has the maps of many lights in one
//! buffer: exact ones (`RenderShadowMapAtlas`), or imperfect ones of points
//! (`RenderImperfectMaps`), whose holes may be filled
//! (`FillHoles`).

#[cfg(feature = "voxel-shadow")]
mod atlas;
mod casters;
mod depth16;
#[cfg(feature = "voxel-shadow")]
mod holes;
#[cfg(feature = "voxel-shadow")]
#[cfg(test)]
pub(crate) mod holes_tests;
#[cfg(feature = "voxel-shadow")]
mod imperfect;
#[cfg(feature = "voxel-shadow")]
#[cfg(test)]
mod imperfect_tests;
pub(crate) mod line;
mod many;
mod map;
mod masked;
#[cfg(feature = "wgpu")]
mod masks;
#[cfg(feature = "voxel-shadow")]
mod octahedron;
#[cfg(feature = "voxel-shadow")]
mod points;
mod reach;
#[cfg(feature = "voxel-shadow")]
mod tiles;

#[cfg(all(feature = "voxel-shadow", feature = "wgpu"))]
pub(crate) use atlas::{Layout, map_capacity};
#[cfg(feature = "voxel-shadow")]
pub use atlas::{RenderShadowMapAtlas, ShadowMapAtlas};
pub use casters::Casters;
pub use depth16::{Depth16Maps, FilteredMaps};
#[cfg(feature = "voxel-shadow")]
pub use holes::FillHoles;
#[cfg(all(feature = "voxel-shadow", feature = "wgpu", test))]
pub(crate) use holes::TOGETHER;
#[cfg(all(feature = "voxel-shadow", feature = "wgpu"))]
pub(crate) use holes::sides as pyramid_sides;
#[cfg(feature = "voxel-shadow")]
pub use imperfect::RenderImperfectMaps;
#[cfg(all(feature = "voxel-shadow", feature = "wgpu"))]
pub(crate) use imperfect::{MOST_TEXELS, place, splat_scale};
pub use many::{FilteredMapsOfMany, MapsOfMany};
#[cfg(feature = "wgpu")]
pub(crate) use map::check_size;
pub(crate) use map::faces;
#[cfg(feature = "translucent")]
pub(crate) use map::render_face;
pub use map::{EMPTY, RenderShadowMap, ShadowMap, ShadowMapError, face_count};
pub(crate) use map::{Place, locate};
#[cfg(any(feature = "shadow-dag", feature = "translucent"))]
pub(crate) use masked::Masked;
#[cfg(feature = "voxel-shadow")]
pub use points::{CasterPoints, LevelOfDetail};
pub use reach::reached;
#[cfg(feature = "voxel-shadow")]
pub use tiles::TileMaps;
