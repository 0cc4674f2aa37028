//! What each method will cost and how large its error will be, before a picture is made.
//!
//! A short [`probe`](Probe) runs methods on a [`Sample`] of the pixels of a picture and
//! compares some of these pixels with the reference ([`Judged`]). The result is a [`Forecast`],
//! with a row for each [`Setting`], which is a method at a quality. [`Forecast::choose`] takes
//! the setting that meets a [`Target`].
//!
//! # Time
//! A picture of `N` rays takes `once` seconds before the first frame and, for each frame,
//!
//! ```text
//! t(N) = a + b N        a = t₁ − b n₁,   b = (t₂ − t₁) / (n₂ − n₁) ≥ 0
//! ```
//!
//! where `t₁` and `t₂` are the shortest times of several repetitions with `n₁` and `n₂` rays of
//! the sample, `n₁` of the `n₂`. The smaller number comes first: after the larger one, all that it
//! reads would be in the caches. The repetitions of all settings are interleaved. A method that
//! [cannot take some of the pixels](crate::methods::Method::takes_some_pixels) is timed with all
//! rays. `once` is the time that a [`Store`](crate::methods::Store) reports for what the setting
//! needs, including things that other settings share.
//!
//! A backend that has to be started takes `start` seconds more before its first frame: those
//! until its device is ready, and those that the first frame takes longer than later ones, in
//! which shaders are compiled. `N` frames then take `start + once + N t` seconds, and a backend
//! on which each setting is finished later than elsewhere need not be started
//! ([`Forecast::slow_starts`]).
//!
//! # Error
//! The relative RMSE over the pixels `i` whose truth is known. They have the radiance `xᵢ` and the
//! reference radiance `rᵢ`:
//!
//! ```text
//! e = √(Σ wᵢ |xᵢ − rᵢ|² / 3) / (Σ wᵢ mean(rᵢ))        Σ wᵢ = 1
//! ```
//!
//! One segment of pixels is drawn from each cell of the picture. Within a segment more pixels
//! get a truth where the light varies, and the weights `wᵢ` make up for that. The pixels nearest
//! to lights, where a few pixels can have most of the error, all get one
//! ([`Sample::with_nearest`]) and represent only themselves. The standard error of `e` is
//! estimated from differences between neighbouring cells. Errors do not depend on the clock.
//!
//! # Settings that are not probed
//! [Counted work](crate::methods::Work) and the [`Profile`] of the machine decide which
//! settings run, never the clock. First come the lowest, the highest and a middle quality of
//! each method, with times and errors; then other qualities, with errors alone. Their times lie
//! on straight lines through the logarithms of the known times over the logarithms of counted
//! work (or over quality, where the work does not differ); beyond the ends the lines are
//! extended. Unknown errors are interpolated over quality between two known ones. They are not
//! extrapolated, because errors level out where something other than the quality limits them.
//!
//! # Choices in doubt
//! A setting whose expected time is about that of a target may be within it or not, and errors of
//! neighbours in such a choice can differ by a factor of 100. [`Forecast::settle`] runs
//! those that matter on the whole picture ([`Probe::frame_seconds`]).
//!
//! # The profile
//! A [`Profile`] holds the seconds per unit of counted work for each method on each backend, as
//! medians over the scenes that it was learned from. It tells which settings are too expensive
//! to probe, and how long the probe takes. It also holds how long each backend takes to start,
//! so that one that would take too long is not started to find out
//! ([`Profile::first_picture`]).
//!
//! # Limits
//! Cells are about 30 pixels wide: light that only single pixels have is missed or overrated.
//! Times are those of the machine in its state during the probe.

mod choice;
mod error;
mod forecast;
mod interpolate;
mod probe;
mod profile;
mod sample;
mod settle;
mod start;

pub use choice::{Target, Unmet};
pub use forecast::{Forecast, Known, Prediction, Skipped};
pub use probe::{Probe, Setting};
pub use profile::{Costs, Profile};
pub use sample::{Judged, Sample};
pub use start::SlowStart;

#[cfg(test)]
mod tests;
