//! Less work for a picture of any method: fewer rays, and rays that share the work.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section 3.4.
//! Light in the air changes smoothly, so that a ray of every second pixel, or a ninth of
//! the lights at each, is enough where the neighbours see the same surface. Two
//! reductions, alone or together ([`Reduction`]), around any method ([`Reduced`]):
//!
//! * *Low resolution*: the method gathers the rays of a grid of pixels, and the others
//!   are interpolated (joint bilateral upsampling: Kopf, Cohen, Lischinski, Uyttendaele,
//!   SIGGRAPH 2007).
//! * *Interleaved*: each pixel of an n × n window gathers every n²-th part of the work
//!   ([`Interleaving`](crate::Interleaving): lights, steps), and a filter over the window
//!   puts the parts together (Keller and Heidrich, EGWR 2001).
//!
//! # What resembles what
//!
//! A sample s counts for a pixel p by
//!
//! ```text
//! w = b(x) · t(10 (d_s / d_p(s) − 1)) · t(2.5 (1 − n_p · n_s)),  t(e) = max(0, 1 − e²)²
//! ```
//!
//! where b depends on the place in the picture alone, d_s is the length of the ray of the
//! sample, d_p(s) the length at which it would meet the plane of the surface that p sees,
//! and n are normals. The weight t is Tukey's: it has an end, so that nothing beyond a
//! step in depth counts at all, and it fades towards it, so that nothing pops. Sky
//! resembles sky. Comparing with the plane keeps a floor at a grazing angle together,
//! whose depth changes by more from row to row than that of a box before a wall.
//!
//! Which pixels *nothing* resembles is known before anything is gathered, from the rays
//! and what they end on. These are gathered in full by the same call of the method, in
//! one list with the others: what it makes for a frame is made once, and nothing is read
//! back.
//!
//! # Departures
//!
//! * The paper says no more of its filter than that it is bilateral, nor what becomes of
//!   pixels without a neighbour that resembles them. Here these are gathered in full.
//! * The samples of low resolution are those of every n-th pixel and of the last one of
//!   each row and column, not of the middle of blocks: every pixel lies between samples,
//!   so that linear functions are reproduced up to the border. A sample that is chosen
//!   by its depth, such as the median of a block, would not lie on a grid, and costs
//!   this everywhere to save a few pixels at edges that are found anyway.
//! * An interleaved pixel sees every subset with equal weight, each by those of its
//!   samples that resemble it; where its own window lacks a subset, that of a window
//!   further away stands in. A plain bilateral mean would favour the lights of the pixels
//!   on its side of an edge.
//!
//! [`Filter::Gaussian`] is the comparison: a 3 × 3 Gaussian over the samples, as in Wyman
//! and Ramsey, Interactive Volumetric Shadows, RT 2008, section 3.3, without depth.
//!
//! # A method of one's own
//!
//! Any [`Method`](super::Method) can be gathered at low resolution, if it takes rays as
//! they come ([`Selection::pixels`](super::Selection::pixels)). It can be interleaved if it
//! [says so](super::Method::interleaves) and honours
//! [`Selection::interleaving`](super::Selection::interleaving).
//!
//! ```
//! use lighting::methods::reduced::{Reduced, Reduction};
//! use lighting::methods::{Compared, Entry, Registry};
//! # use lighting::methods::{About, Frame, FrameInputs, Method, MethodError, Role, RunOn, Verdict};
//! # use gpu_backend::{Backend, BufferOf};
//! # #[derive(Debug)]
//! # struct Own;
//! # impl Method for Own {
//! #     fn about(&self) -> About {
//! #         About { name: "own".into(), title: "own", purpose: "", paper: "", quality: "", qualities: &[],
//! #             quick: &[], pictured: 0, usual: 0, role: Role::Variant, uses_shadow_map: false }
//! #     }
//! #     fn applies(&self, _: &FrameInputs<'_>) -> Verdict { Verdict::Applies }
//! # }
//! # impl<B: Backend> RunOn<B> for Own {
//! #     fn add_radiance(&self, _: &Frame<'_, B>, _: u32, _: &mut BufferOf<B, [f32; 4]>) -> Result<(), MethodError> {
//! #         Ok(())
//! #     }
//! # }
//! let quarter = Reduction::new(2, 1)?;
//! let methods = Registry::standard().with(Reduced::new(Own, quarter));
//! assert!(methods.find("own quarter").is_some());
//! # Ok::<(), lighting::methods::reduced::ReductionError>(())
//! ```
//!
//! # Limits
//!
//! What the surfaces do not tell is not seen: a shaft of light thinner than the distance
//! of samples is blurred or missed. See-through surfaces do not separate pixels.

mod choice;
mod fill;
#[cfg(feature = "wgpu")]
mod gpu;
mod grid;
mod method;
pub(in crate::methods) mod resemblance;
#[cfg(test)]
mod tests;

pub use choice::Choice;
pub use fill::{FillPicture, Filling};
pub use grid::{Filter, Reduction, ReductionError};
pub use method::{Reduced, ShownAs};
