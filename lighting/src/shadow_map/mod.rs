//! What a light sees: the depth of the first blocker in every direction.
//!
//! * A **directional** light has one orthographic map of all casters; depth is the distance
//!   along the light.
//! * A **spotlight** of up to 75° half angle has one perspective map; depth is the Euclidean
//!   distance from the light.
//! * A **point** light, a wider spotlight or a cosine emitter has six perspective maps, the
//!   faces of a cube, with Euclidean distances.
//! * If one of these is outside of the casters' bounding box, it has one perspective map around
//!   the box where that is narrower.
//!
//! Lookups take the nearest texel and compare without a bias: a point in the air has no surface
//! of its own that could shadow it.
//!
//! [`MapsOfMany`] holds the maps of several lights in one buffer, filtered on surfaces. It
//! serves for the shadows of what moves, beside precomputed shadows of what stays.
//!
//! [`Depth16Maps`] has depths of 16 bits, and cascades for a sun, as game engines do. It is a
//! baseline to compare with.
//!
//! A `ShadowMapAtlas` (feature `voxel-shadow`) holds the maps of many lights in one buffer:
//! exact ones (`RenderShadowMapAtlas`), or imperfect ones made from points
//! (`RenderImperfectMaps`), whose holes can be filled (`FillHoles`).

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
pub use map::{EMPTY, RenderShadowMap, ShadowMap, ShadowMapError, face_count};
pub(crate) use map::{Place, locate};
#[cfg(feature = "translucent")]
pub(crate) use map::{face_towards, render_face};
#[cfg(any(feature = "shadow-dag", feature = "translucent"))]
pub(crate) use masked::Masked;
#[cfg(feature = "voxel-shadow")]
pub use points::{CasterPoints, LevelOfDetail};
pub use reach::reached;
#[cfg(feature = "voxel-shadow")]
pub use tiles::TileMaps;
