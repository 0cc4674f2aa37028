//! Methods: every way of making an image of the light in the air.
//!
//! A [`Method`] is told everything about a frame ([`FrameInputs`]: all lights, the camera and
//! its rays, the medium, the casters) and a quality, which is one number. It adds the airlight
//! of every ray to a buffer of the backend. It describes itself ([`About`]), says whether it
//! applies to a frame ([`Verdict`]), and runs on the backends for which it implements
//! [`RunOn`].
//!
//! Most methods are products: a way to find the lit parts of a ray × a way to integrate the
//! light of a part, summed over the lights. [`PerLight`] makes a method of any such pair. If
//! the source of a pair answers for [many lights](many_lights) at once, one pass gathers all of
//! them. A method that is not a product implements the traits itself.
//!
//! Every method can be run with fewer rays, and a method that [allows it](Method::interleaves)
//! with rays that share its work: see [`reduced`].
//!
//! What methods share, and what stays from frame to frame, is in a [`Store`]: the shadow map of
//! a light, its voxels, a table. The [`Registry`] lists the methods. The program, the tests and
//! the benches go through that list; nothing else knows a method by name.
//!
//! # A method of one's own
//!
//! ```
//! use gpu_backend::{Backend, BufferOf, Cpu};
//! use lighting::methods::{
//!     About, Frame, FrameInputs, Method, MethodError, Registry, Role, RunOn, Verdict,
//! };
//!
//! /// The same light in every pixel.
//! #[derive(Debug)]
//! struct Constant;
//!
//! impl Method for Constant {
//!     fn about(&self) -> About {
//!         About {
//!             name: "constant".into(),
//!             title: "constant light",
//!             purpose: "an example",
//!             paper: "none",
//!             quality: "milliunits",
//!             qualities: &[1000],
//!             quick: &[1000],
//!             pictured: 1000,
//!             usual: 1000,
//!             role: Role::Variant,
//!             uses_shadow_map: false,
//!         }
//!     }
//!
//!     fn applies(&self, _: &FrameInputs<'_>) -> Verdict {
//!         Verdict::Applies
//!     }
//! }
//!
//! impl<B: Backend> RunOn<B> for Constant {
//!     fn add_radiance(
//!         &self,
//!         frame: &Frame<'_, B>,
//!         quality: u32,
//!         radiance: &mut BufferOf<B, [f32; 4]>,
//!     ) -> Result<(), MethodError> {
//!         let light = 1e-3 * quality as f32;
//!         *radiance = frame.backend.upload(&vec![[light; 4]; frame.inputs.rays.len()])?;
//!         Ok(())
//!     }
//! }
//!
//! let methods = Registry::standard().with(Constant);
//! assert!(methods.find("constant").is_some());
//! ```
//!
//! # Files
//!
//! A method is a folder. `mod.rs` has what it computes on the CPU, `gpu.rs` and WGSL files its
//! shaders, and `method.rs` (with the feature `methods`) its entry in the list of methods. The
//! folders are of use without the list, too: their sources and maps go directly into
//! [`Gather`](crate::Gather).

#[cfg(feature = "area")]
pub mod area;
#[cfg(feature = "shadow-map")]
pub mod epipolar;
#[cfg(feature = "trace")]
pub mod exact;
#[cfg(feature = "shadow-map")]
pub mod froxels;
pub mod heterogeneous;
#[cfg(feature = "shadow-map")]
pub mod hybrid;
#[cfg(feature = "shadow-map")]
pub mod light_space;
#[cfg(feature = "shadow-map")]
pub mod light_volumes;
pub mod many_lights;
#[cfg(feature = "shadow-map")]
pub mod march;
#[cfg(feature = "shadow-dag")]
pub mod precomputed;
#[cfg(feature = "shadow-map")]
pub mod prefiltered;
#[cfg(feature = "trace")]
pub mod raytraced_area;
#[cfg(feature = "methods")]
pub mod reduced;
#[cfg(feature = "shadow-map")]
pub mod slices;
#[cfg(feature = "shadow-map")]
pub mod textured;
#[cfg(feature = "translucent")]
pub mod translucent;
pub mod unshadowed;
#[cfg(feature = "voxel-shadow")]
pub mod voxelized;

#[cfg(feature = "methods")]
mod contract;
#[cfg(feature = "methods")]
mod evaluators;
#[cfg(feature = "methods")]
mod frame;
#[cfg(feature = "methods")]
mod per_light;
#[cfg(feature = "methods")]
mod planned;
#[cfg(feature = "methods")]
mod registry;
#[cfg(feature = "methods")]
mod shared;
#[cfg(feature = "methods")]
mod store;

#[cfg(feature = "methods")]
pub use contract::{
    About, LightFrameSurfaces, Method, MethodError, Role, RunOn, Verdict, Work, Wraps,
};
#[cfg(feature = "methods")]
pub use evaluators::{EvaluatorAbout, Evaluators, GAUSS_NODES};
#[cfg(feature = "methods")]
pub use frame::{Frame, FrameInputs, Pass, Selection};
#[cfg(all(feature = "methods", feature = "translucent"))]
pub use heterogeneous::share_transmittance_map;
#[cfg(feature = "methods")]
pub use per_light::{Compared, LightSources, PerLight, SourceAbout, SourceOn, SourceQuality};
#[cfg(all(feature = "methods", feature = "shadow-dag"))]
pub use precomputed::{FROM_FILE, PRECOMPUTED, share_precomputed};
#[cfg(feature = "methods")]
pub use registry::{Entry, MethodBackend, Registry, RunEverywhere};
#[cfg(feature = "methods")]
pub use shared::{
    OfDynamic, OfLight, OfScene, OfStatic, forget_dynamic, forget_lights, share_cover,
    share_film_frame, share_tracer, tracer,
};
#[cfg(feature = "methods")]
pub use store::{Store, Used};
