//! Internal: not published. The truth against which the crates of this workspace are measured.
//!
//! Tests, benches and the program's comparison all draw on this library, so
//! that nothing is defined twice. It has two halves. Without features it takes
//! and gives plain numbers and knows no crate of the workspace, so that each of
//! them can test itself with it. The feature `scene` adds what needs a whole
//! scene, and `proptest` what only tests need.
//!
//! | module | feature | what |
//! |---|---|---|
//! | [`oracle`] | | the truth in f64, which shares no mathematics with the crates; with `scene` the reference image |
//! | [`metrics`] | | the error of an image |
//! | [`film`] | | the error of a film, how much of it flickers, and how late it is |
//! | [`tolerances`] | | every allowed error, with its derivation |
//! | [`segments`] | | parts of rays with the extinction around them, easy and stiff, on which evaluators are measured |
//! | [`curves`] | | transmittance behind blockers, and the best curve of few nodes |
//! | [`damage`] | | damaged copies of files |
//! | [`random`] | | numbers that are the same on every run |
//! | `hard_cases` | `scene` | named inputs at which methods break |
//! | `shapes`, `scenes` | `scene` | small scenes with known shadows; the embedded scenes made ready |
//! | `generators` | `proptest`, `scene` | random inputs that lean towards hard ones |
//! | `property` | `proptest` | one loop for every property |
//!
#![cfg_attr(feature = "scene", doc = "```")]
#![cfg_attr(not(feature = "scene"), doc = "```ignore")]
//! use reference::oracle::image::{Options, reference};
//! use reference::metrics::image_error;
//! use reference::shapes;
//! use glam::Vec3;
//! use scene::{Emitter, Medium, PhaseFunction, Ray};
//!
//! let fog = Medium::new(Vec3::splat(0.2), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE)?;
//! let rays = [Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).expect("a sound ray")];
//! let truth = reference(&rays, &[sun], &fog, &shapes::nothing(), Options::default());
//! // All that is scattered out of the sunlight comes from somewhere on the ray.
//! let isotropic = 1.0 / (4.0 * std::f32::consts::PI);
//! assert!(image_error(&[[isotropic; 4]], &truth).max < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod curves;
pub mod damage;
pub mod film;
#[cfg(feature = "proptest")]
pub mod generators;
#[cfg(feature = "scene")]
pub mod hard_cases;
pub mod metrics;
pub mod oracle;
#[cfg(feature = "proptest")]
pub mod property;
pub mod random;
#[cfg(feature = "scene")]
pub mod scenes;
pub mod segments;
#[cfg(feature = "scene")]
pub mod shapes;
pub mod tolerances;
