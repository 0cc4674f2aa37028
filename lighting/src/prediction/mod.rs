//! What each method will cost and how far off it will be, before a picture is made.
//!
//! A short [`probe`](Probe) runs methods on a [`Sample`] of the pixels of a picture and
//! compares them with the truth about some of these pixels ([`Judged`]). What comes out is
//! a [`Forecast`]: a row for each [`Setting`], a method at a quality, from which
//! [`Forecast::choose`] takes the one that meets a [`Target`].
//!
//! # Time
//! A picture of `N` rays takes `once` seconds before the first frame and, for each frame,
//!
//! ```text
//! t(N) = a + b N        a = t₁ − b n₁,   b = (t₂ − t₁) / (n₂ − n₁) ≥ 0
//! ```
//!
//! where `t₁` and `t₂` are the shortest of some repetitions with `n₁` and `n₂` rays of the
//! sample; repetitions of all settings are interleaved. A method that
//! [takes no part of a picture](crate::methods::Method::takes_some_pixels) is timed with all
//! rays. `once` is what a [`Store`](crate::methods::Store) says that the setting needs, things
//! that other settings share included.
//!
//! # Error
//! The relative RMSE over the judged pixels `i` of radiance `xᵢ`, with the truth `rᵢ`:
//!
//! ```text
//! e = √(Σ wᵢ |xᵢ − rᵢ|² / 3) / (Σ wᵢ mean(rᵢ))        Σ wᵢ = 1
//! ```
//!
//! One segment of pixels is drawn from each cell of the picture. Within a segment more pixels
//! are judged where the light varies, and `wᵢ` makes up for that. The pixels nearest to lights,
//! where a few can have most of the error, are judged all
//! ([`Sample::with_nearest`]) and stand for themselves. The standard error of `e`
//! comes from the differences of neighbouring cells. Errors do not depend on the clock.
//!
//! # Settings that are not probed
//! What is run is decided by [counted work](crate::methods::Work) and the [`Profile`] of the
//! machine, never by the clock: first the ends of the qualities of each method and one
//! between, with their times; then the others, for their errors. The time of these is found
//! on straight lines through the logarithms of times over those of counted work (of the
//! quality, where work is the same), which go on beyond the ends. Errors that are not known
//! are found between two that are, over the quality; beyond these nothing is foreseen,
//! because errors level out where something else limits them.
//!
//! # The profile
//! A [`Profile`] holds, for each method on each backend, seconds per unit of counted work,
//! as medians over the scenes that it was learned from. It says what is too expensive to
//! probe, and how long that takes.
//!
//! # Limits
//! Cells are about 30 pixels wide: light that only single pixels have is missed, or
//! overrated. Times are those of the machine as it is during the probe.

mod choice;
mod error;
mod forecast;
mod interpolate;
mod probe;
mod profile;
mod sample;

pub use choice::{Target, Unmet};
pub use forecast::{Forecast, Known, Prediction, Skipped};
pub use probe::{Probe, Setting};
pub use profile::{Costs, Profile};
pub use sample::{Judged, Sample};

#[cfg(test)]
mod tests;
