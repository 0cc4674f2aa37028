//! What judges the crates of this workspace.
//!
//! Tests, benches and the program's comparison all draw on this library, so
//! that nothing is defined twice:
//!
//! | module | what |
//! |---|---|
//! | [`oracle`] | the truth in f64, sharing no mathematics with what it judges; the reference image |
//! | [`metrics`] | the error of an image |
//! | [`hard_cases`] | named inputs at which methods break |
//! | [`tolerances`] | every allowed error, with its derivation |
//! | [`segments`] | parts of rays with the extinction around them, easy and stiff, to judge evaluators by |
//! | [`generators`] | random inputs that lean towards hard ones |
//! | [`shapes`], [`scenes`] | small scenes with known shadows; the embedded scenes made ready |
//! | [`suite`] | one test body for every backend, one loop for every property |
//!
//! ```
//! use crepuscular_tests::oracle::image::{Options, reference};
//! use crepuscular_tests::metrics::image_error;
//! use crepuscular_tests::shapes;
//! use glam::Vec3;
//! use lighting::scene::{Medium, PhaseFunction};
//! use lighting::{Emitter, Ray};
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

pub mod generators;
pub mod hard_cases;
pub mod metrics;
pub mod oracle;
pub mod scenes;
pub mod segments;
pub mod shapes;
pub mod suite;
pub mod tolerances;
