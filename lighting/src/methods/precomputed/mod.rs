//! Precomputed voxelized shadows of what does not move: in the air, and filtered
//! on surfaces.
//!
//! Based on: Sintorn, Kämpe, Olsson and Assarsson, Compact Precomputed
//! Voxelized Shadows, SIGGRAPH 2014; Kämpe, Sintorn and Assarsson, Fast,
//! Memory-Efficient Construction of Voxelized Shadows, I3D 2015. They filter
//! shadows on surfaces; the same voxels also tell which parts of an eye ray are
//! lit, by a step for each homogeneous volume on its way.
//!
//! [`BakedShadow::bake`] makes the grids of one light from a scene, once. A [`BakedShadow`] is
//! a [`VisibilitySource`](crate::VisibilitySource) that [`Gather`](crate::Gather) takes.
//! [`BakedShadow::filtered`] is a [`SurfaceShadow`](crate::visibility::SurfaceShadow); for many
//! lights at once there are [`FilteredShadows`], on any backend. What moves has an ordinary
//! shadow map of its own beside the bake, see [below](self#what-moves):
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
//! [`BakedShadow::upload`] copies them to any backend. Files hold the shadows of one or several
//! lights, see [`ShadowSet`]; [`bake`] makes them in steps that can be interrupted.
//!
//! # What moves
//!
//! [Instances](crate::scene::Instance::dynamic) that a scene marks as dynamic do not belong
//! into a bake. The methods `precomputed x …` and the program's `bake` leave them out; callers
//! of [`bake`] or [`BakedShadow::bake`] pass the [static
//! part](crate::scene::Geometry::static_part). The methods `precomputed x …`, and `render` with
//! a file, take the shadows of the [dynamic part](crate::scene::Geometry::dynamic_part) from
//! shadow maps of that part alone. Each light has a map around the part of it that it
//! [reaches](crate::shadow_map::reached). A point is lit if both grid and map say so.
//!
//! In the air the map contributes its exact [runs](crate::methods::epipolar::MapRuns). The
//! intersection of lit parts ends within a voxel of the grid or a texel of the map of the true
//! end; a march would add half a step, a light volume half a texel. On surfaces the filtered
//! shadow of the grid, over k × k texels, is multiplied by that of the
//! [map](crate::shadow_map::MapsOfMany) over as many.
//!
//! A store keeps the maps as long as nothing moves. Before a frame in which something has
//! moved, `methods::forget_dynamic` empties the stores except for the bakes.
//!
//! Lights that reach no dynamic caster, and scenes without any, use the same sources and
//! shaders as if nothing could move. Many lights stay in one pass, except for those that reach
//! a dynamic caster.
//!
//! # Accuracy
//!
//! The edge of a shadow is off by at most a texel across the rays of the light and half a slice
//! along them. Details smaller than a texel are present where the ray through its centre meets
//! them. What a grid says about the inside of closed solids has no meaning; a light inside a
//! solid lights nothing.

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
