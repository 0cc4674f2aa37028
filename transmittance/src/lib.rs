//! How much light gets through smoke, hair and surfaces, at every depth along
//! each ray of a light: adaptive volumetric shadow maps with an error bound.
//!
//! The package is `crepuscular-transmittance` and the library `transmittance`: `Cargo.toml` has
//! the first name, and `use` the second.
//!
//! A light ray meets blockers ([`BlockerSegment`]) in any order. A [`Curve`] holds the
//! transmittance behind them in at most `N` nodes, whatever their number, and
//! knows how wrong it can be at each depth. A [`CurveMap`] has a curve per
//! texel of the light's view.
//!
//! ```
//! use transmittance::{BlockerSegment, Stream};
//!
//! let mut stream = Stream::<8>::new();
//! for puff in 0..200 {
//!     let entry = (puff * 37 % 200) as f32; // in any order
//!     stream.insert(&BlockerSegment::from_density(entry, entry + 9.0, 0.001)?);
//! }
//! stream.insert(&BlockerSegment::surface(120.0, 0.5)?); // a leaf
//! stream.insert(&BlockerSegment::opaque(180.0)?); // a wall
//!
//! let curve = stream.finish();
//! // In front of the leaf are 112 of the puffs, and parts of 8 more.
//! let exact = (-0.009 * 112.0 - 0.001 * 36.0_f32).exp();
//! assert!((curve.transmittance(120.0) - exact).abs() <= curve.error_bound(120.0));
//! assert!(curve.max_error_bound() < 0.02);
//! assert_eq!(curve.transmittance(181.0), 0.0);
//! # Ok::<(), transmittance::Error>(())
//! ```
//!
//! # Which curve
//!
//! | | rule | for |
//! |---|---|---|
//! | [`Curve<N, Linear>`](Curve) | the paper's: `N` nodes at any time, linear lookup | the least work, and comparison |
//! | [`Curve<N>`](Curve) | the same with exponential lookup | smoke; exact while there is room |
//! | [`Stream<N>`](Stream) | room for `4 N` nodes, then the best `N` by area | the least mean error |
//! | [`Stream<N, Maximum>`](Stream) | the same by largest error | the least largest error |
//! | [`Sorted`] around any of them | all segments first, then front to back | no dependence on order |
//!
//! Mean errors of `N = 8` over the least that any 8 nodes can have, in random
//! order: columns of smoke 1.8 by the paper's rule and 1.1 by `Stream`, voxels
//! 2.1 and 1.1, hair 2.4 and 1.2, hair in smoke with a wall 2.9 and 1.2; what
//! the order of the segments changes is a third to a half of what it changes by
//! the paper's rule over these streams, up to 0.64 of it over the hair of other
//! files. A curve of 8 nodes takes 1.7 to 2 times as long to make that way. In the
//! repository `transmittance/tests/quality.rs` and `transmittance/benches/curves`
//! measure this.
//!
//! # What holds for every curve
//!
//! 1 in front of the first blocker, never rising, never below 0; behind the
//! last blocker the product of all, to rounding. Nodes lie where blockers begin
//! or end. Results are not NaN, and never further from the truth than the
//! curve's error bound, which includes every rounding. Depths may be any finite
//! f32. Curves depend on the order of the segments only by what was removed, and
//! not on threads; nor on the machine, where segments are given by density or
//! optical depth (a transmittance goes through the system's logarithm).
//!
//! # Maps
//!
//! [`CurveMap`] holds curves of any kind in ordinary memory, baselines included.
//! [`TransmittanceMap`] holds adaptive curves as words in the buffers of a backend, whole
//! ([`Curve`]), without their bounds ([`Packed`]) or in 16 bits ([`PackedHalf`]);
//! steps run wherever the buffers are:
//!
//! * [`BuildMap`] makes one while segments come, texel by texel
//!   ([`SegmentLists`]), in memory that does not depend on their number;
//! * [`CaptureSegments`] makes such lists of segments that come in any order, at
//!   will sorted from front to back;
//! * [`QueryMap`] answers receivers from the nearest texel, the four around, or a square of
//!   them ([`Filter`]).
//!
//! The module `gpu` (feature `wgsl`) says what shaders can do with the same curves: among
//! others, make a map of what each texel meets of hair, particles or candidates of your own,
//! without a segment in memory.
//!
//! # Compared with
//!
//! [`baseline`] has the exact curve, deep shadow maps, opacity and Fourier
//! opacity maps, and moments, behind the same two traits: [`Accumulate`] and
//! [`Evaluate`].
//!
//! # Features and limits
//!
//! `rayon` (default) builds maps and answers batches on several threads; `wgpu`
//! does it on GPUs, and `wgsl` has the parts for shaders alone. `wgpu` compiles no driver:
//! the module `gpu` of `crepuscular-backend` says how to choose one.
//!
//! A curve knows extinction only: no scattering, no emission. `N` is from 2 to 64.

pub mod baseline;
mod capture;
mod certificate;
mod curve;
mod curve_map;
mod error;
mod evaluate;
mod exponential;
mod filter;
#[cfg(feature = "wgsl")]
pub mod gpu;
mod insertion;
mod joined;
mod linear;
mod lookup;
mod metric;
mod node;
mod numeric;
mod packed;
mod removal;
mod segment;
mod selection;
mod source;
mod stored;
mod stream;
mod transmittance_map;

pub use capture::{CaptureSegments, Order};
pub use curve::Curve;
pub use curve_map::CurveMap;
pub use error::Error;
pub use evaluate::{Accumulate, Evaluate, Sorted};
pub use filter::{Filter, Receiver};
pub use gpu_backend;
pub use lookup::{Exponential, Linear, Lookup};
pub use metric::{Area, Maximum, Metric};
pub use packed::{Packed, PackedHalf};
pub use segment::BlockerSegment;
pub use source::{Lists, SegmentLists, Source, Tile};
pub use stored::Stored;
pub use stream::Stream;
pub use transmittance_map::{BuildMap, QueryMap, TransmittanceMap};

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
