//! Single scattering on a GPU.
//!
//! The shader of a [`Gather`](crate::Gather) is put together from the parts of its visibility
//! source and of its airlight evaluator, and from parts that all of them share:
//!
//! ```text
//! airlight::gpu::PHASE                     phase functions
//! NUMERIC  PATH  ARC  DIRECTIONAL  LIT     what every part may use
//! lit_parts.wgsl                           the loop over the lit parts of a ray
//! panes.wgsl  gather.wgsl                  entry point, rays and panes before them,
//!                                          light, medium
//! the part in the VisibilitySlot           light_cursor, light_next_lit
//! the part in the AirlightSlot             light_airlight
//! ```
//!
//! A new source is a type that implements
//! [`InShader<VisibilitySlot>`](gpu_backend::gpu::InShader), a new evaluator one that
//! implements `InShader<AirlightSlot>`; each works with all the others. A source of visibility
//! at points implements `InShader<PointSlot>` and works in a march; one that can be filtered
//! over a step of a march implements `InShader<StepSlot>`.
//!
//! Bind group 0 belongs to the frame and group 1 to the parts; groups 2 and 3 are free. A frame
//! has 3 storage buffers, which leaves 5 of WebGPU's 8 for parts. A frame that gathers [many
//! lights](crate::methods::many_lights) at once has 4.
//!
//! # Agreement with the CPU
//!
//! The CPU computes the foot point and the distance `h` of a light in f64, shaders do in f32.
//! There `h` has an error of a few ε of the distance `D` between eye and light, so for a ray
//! that passes the light at a hundredth of that distance CPU and GPU agree to about 100 ε.
//! Apart from that they differ by rounding and by what WGSL allows for `exp` (3 + 2|x| ULP),
//! division and square roots. Shaders compute angles by polynomials, because WGSL's own
//! trigonometry may be off by thousands of ULP. A sample within rounding of a texel's border
//! may fall into another texel of a shadow map.
//!
//! Distances are at most 1e18 m. Rays that run into a point light give `f32::MAX` where the CPU
//! gives infinity.
//!
//! # Limits
//!
//! A spotlight's cookie is uploaded with every gather, followed by its mip levels. Some
//! software drivers end loops after 65,535 iterations per ray: steps × nodes must stay below
//! that, and so do the texels of a cookie
//! ([`MOST_COOKIE_LINES`](crate::scene::MOST_COOKIE_LINES)).
//! Exact visibility takes a turn for each node of the hierarchy and each triangle that it looks
//! at, which are up to 3,000 for a ray over 3,200 triangles and grow with their square root:
//! its methods leave scenes of more than 100,000 triangles to the CPU on a software driver.

mod airlight;
mod both;
mod gather;
#[cfg(feature = "voxel-shadow")]
mod holes;
#[cfg(feature = "voxel-shadow")]
mod imperfect;
#[cfg(feature = "shadow-map")]
pub(crate) mod many_maps;
#[cfg(feature = "shadow-map")]
mod map;
#[cfg(feature = "voxel-shadow")]
mod map_atlas;
pub(crate) mod scene;
#[cfg(feature = "shadow-map")]
mod shadow_map;
mod slots;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use gather::assembly;
#[cfg(feature = "shadow-map")]
pub(crate) use slots::Shadows;
pub(crate) use slots::visibility_on;
pub use slots::{AirlightSlot, PointSlot, StepSlot, VisibilitySlot};

/// Trigonometry and exponentials with known errors.
pub const NUMERIC: &str = include_str!("numeric.wgsl");
/// Rays, lights and media, and a ray as seen from a light.
pub const PATH: &str = include_str!("path.wgsl");
/// The equi-angular variable.
pub const ARC: &str = include_str!("arc.wgsl");
/// The airlight of directional light in closed form.
pub const DIRECTIONAL: &str = include_str!("directional.wgsl");
/// Lit parts of a path.
pub const LIT: &str = include_str!("lit.wgsl");
/// The light of all lit parts of a path, for the entry points of gathers.
pub(crate) const LIT_PARTS: &str = include_str!("lit_parts.wgsl");
/// See-through surfaces and hair in front of rays, for the entry points of gathers.
pub(crate) const PANES: &str = include_str!("panes.wgsl");
/// Where masked triangles have holes.
pub const MASK: &str = include_str!("mask.wgsl");
/// A point of a surface.
pub const SURFACE_POINT: &str = include_str!("../surface_point.wgsl");
/// Light that reaches surfaces directly.
pub const ARRIVING: &str = include_str!("arriving.wgsl");
/// A picture plane of a light.
pub const FACE: &str = include_str!("face.wgsl");
/// The place of a point in the pictures of a light.
pub const PLACE: &str = include_str!("place.wgsl");
/// Directions as points of a square.
#[cfg(feature = "voxel-shadow")]
pub(crate) const OCTAHEDRON: &str = include_str!("octahedron.wgsl");
/// A ray as the pictures of a light show it.
pub const LINE: &str = include_str!("line.wgsl");
/// Lookup in a shadow map.
pub const MAP: &str = include_str!("map.wgsl");
