//! Precomputed voxelized shadows of what does not move: in the air, and filtered
//! on surfaces.
//!
//! Based on: Sintorn, Kämpe, Olsson and Assarsson, Compact Precomputed
//! Voxelized Shadows, SIGGRAPH 2014; Kämpe, Sintorn and Assarsson, Fast,
//! Memory-Efficient Construction of Voxelized Shadows, I3D 2015. They filter
//! shadows on surfaces; the same voxels also tell which parts of an eye ray are
//! lit, by a step for each homogeneous volume on its way.
//!
//! [`BakedShadow::bake`] makes the grids of one light from a scene, once.
//! A [`BakedShadow`] is a [`VisibilitySource`](crate::VisibilitySource) that
//! [`Gather`](crate::Gather) takes, and [`BakedShadow::filtered`] a
//! [`SurfaceShadow`](crate::visibility::SurfaceShadow); those of many lights at once are
//! [`FilteredShadows`], on any backend. What moves gets an ordinary shadow map of its own
//! beside it, see [below](self#what-moves):
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu};
//! use lighting::airlight::Quadrature;
//! use lighting::precomputed::{BakedShadow, Builder, FilterSize, Resolution};
//! use lighting::scene::{Geometry, Instance, Medium, Mesh, PhaseFunction, Scene};
//! use lighting::shadow_map::{Casters, MapsOfMany, RenderShadowMap};
//! use lighting::visibility::{Both, SurfaceShadow};
//! use lighting::methods::epipolar::MapRuns;
//! use lighting::{Emitter, Gather, LitRays, Ray};
//!
//! let corner = |dx: f32, dz: f32| Vec3::new(dx - 2.0, 2.0, -5.0 + dz);
//! let mut scene = Scene::from(Mesh {
//!     positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! });
//! scene.instances.push(Instance {
//!     name: "guest".into(),
//!     ..Instance::default()
//! });
//! scene.set_dynamic("guest", true);
//! let geometry = Geometry::new(&scene)?;
//! let scenery = geometry.static_part().expect("there is a triangle that stays");
//! let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE)?;
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! let cpu = Cpu::new();
//!
//! let (baked, watertightness) =
//!     BakedShadow::bake(&cpu, scenery, &sun, Resolution::new(512)?, Builder::new())?;
//! assert_eq!(watertightness.open_parts, 1, "a triangle encloses nothing");
//!
//! let rays = [Ray::new(Vec3::new(-9.0, 1.0, -5.5), Vec3::X, 18.0).expect("a sound ray")];
//! let quadrature = Quadrature::with_tolerance(fog.phase(), 1e-4)?;
//! let mut seen = Vec::new();
//! // Frames in which the guest comes out of the shadow of the scenery. Nothing is baked.
//! for x in [0.0, 1.0, 2.0] {
//!     scene.instances[1].transform.translation.x = x;
//!     let casters = Casters::upload(&cpu, &Geometry::of_dynamic(&scene)?)?;
//!     let map = cpu.shadow_map(&casters, &sun, 256)?;
//!     let runs = MapRuns::new(&cpu, &map, &rays, &sun, &fog)?;
//!     let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//!     let rays = cpu.upload(&rays)?;
//!     let lit = LitRays::new(&rays, &sun, &fog).joined();
//!     cpu.gather(&lit, &Both(&baked, runs), &quadrature, &mut radiance)?;
//!     seen.push(radiance[0][0]);
//!
//!     let (size, suns) = (FilterSize::new(9)?, [sun.clone()]);
//!     let maps = MapsOfMany::render(&cpu, &casters, &suns, 256)?;
//!     let floor = Both(baked.filtered(size), maps.filtered(9).of_light(0));
//!     let under = |x: f32| floor.visibility(Vec3::new(x, 0.0, -5.0), Vec3::Y).x;
//!     assert_eq!([under(-2.0), under(x - 2.0)], [0.0; 2]);
//!     assert_eq!(under(8.0), 1.0);
//! }
//! assert!(seen[0] > seen[1] && seen[1] > seen[2]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`BakedShadow::upload`] takes them to any backend. Files hold the shadows of
//! one light or several, see [`ShadowSet`]; [`bake`] makes them with breaks.
//!
//! # What moves
//!
//! [Instances](crate::scene::Instance::dynamic) that a scene marks as dynamic have no place in
//! a bake: the methods `precomputed x …` and the program's `bake` leave them out, and whoever
//! calls [`bake`] or [`BakedShadow::bake`] passes the
//! [static part](crate::scene::Geometry::static_part). The methods `precomputed x …`, and `render` with a file, take their
//! shadows from a map of the [dynamic part](crate::scene::Geometry::dynamic_part) alone,
//! for each light with a picture of its own around that part as far as the light
//! [reaches](crate::shadow_map::reached): a point is lit where grid and map say so.
//!
//! In the air these are the [runs](crate::methods::epipolar::MapRuns) of the map, which are
//! all that it knows: what is lit by both is their intersection, and it ends within a
//! voxel of the grid or a texel of the map of where it should. A march would add half a
//! step, a light volume half a texel. On surfaces the k × k texels of the grid's filter are
//! multiplied by as many of the [map](crate::shadow_map::MapsOfMany).
//!
//! A store keeps the maps as long as nothing moves. Before a frame in which something has
//! moved, `methods::forget_dynamic` empties the stores but for the bakes.
//!
//! Lights that reach no dynamic caster, and scenes without any, take the sources and shaders
//! that they would take anyway. Many lights stay in one pass but for those that do.
//!
//! # Accuracy
//!
//! A shadow's edge is off by at most a texel across the rays of the light and
//! half a slice along them; details smaller than a texel are there where the
//! ray through its centre meets them. What is inside of closed solids has no
//! meaning. A light inside of a solid lights nothing.

#[cfg(feature = "methods")]
mod dynamic;
mod filtered;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
#[cfg(all(feature = "methods", feature = "wgpu"))]
mod method_gpu;
mod shadow;
mod space;
#[cfg(test)]
mod tests;

pub use filtered::{FilteredShadow, FilteredShadows};
#[cfg(feature = "methods")]
pub(super) use method::methods;
#[cfg(feature = "methods")]
pub use method::{FROM_FILE, PRECOMPUTED, share_precomputed};
pub use shadow::{BakedError, BakedShadow, BakedShadows, bake, surfaces};
pub use shadow_dag::{
    Builder, Error, FilterSize, Form, LightGrids, Resolution, SetError, ShadowSet, Surfaces,
    Watertightness,
};
pub use space::{light_grids, light_spaces};
