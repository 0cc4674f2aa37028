//! A few samples along the epipolar lines of the picture, and all others between them.
//!
//! Based on: Engelhardt and Dachsbacher, Epipolar Sampling for Shadows and Crepuscular
//! Rays in Participating Media with Single Scattering, I3D 2010. Engines call it light
//! scattering with epipolar sampling (Yusov, High-Performance Outdoor Light Scattering
//! Using Epipolar Sampling, GPU Pro 5, 2014).
//!
//! Shafts of light run along straight lines of the picture that meet in the picture of
//! the light, its *epipole*. Across these lines the light changes from pixel to pixel;
//! along them it changes slowly, except where the depth of what is seen jumps. So for each
//! light, an [`EpipolarSampling`]
//!
//! 1. lays lines from points of the picture's border to the epipole, a pixel apart at
//!    the border or a few;
//! 2. samples each at a regular spacing of s pixels, and at a distance r from the epipole
//!    of at most r/8;
//! 3. walks the pixels between samples, and where two that follow each other see different
//!    surfaces puts a sample on both sides;
//! 4. gathers the light of the samples, exactly, by any visibility source and evaluator:
//!    in the list of methods by the [lit runs](super) of the shadow map;
//! 5. makes each pixel of the two lines beside it, as
//!
//! ```text
//! L(p) = Σᵢ wᵢ ((1 − tᵢ) L(sᵢ) + tᵢ L(sᵢ₊₁)) / Σᵢ wᵢ,   wᵢ = (share of line i) · k(p, pᵢ)
//! ```
//!
//! where sᵢ and sᵢ₊₁ are the samples around the point pᵢ of line i that is closest to the
//! pixel p, tᵢ is its place between them, and k is the resemblance of what p and pᵢ see, as
//! in [`reduced`](crate::methods::reduced). Between the two sides of a discontinuity
//! nothing is interpolated. What no line resembles is gathered by its own ray, and so
//! are pixels where samples would be no farther apart than pixels: those within 16 of the
//! epipole, and all of them at the best quality, which is the method without sampling, to
//! rounding.
//!
//! # Lines
//!
//! The epipole is a projective point (x, y, w): its lines are found from the sign and
//! direction of p w − (x, y), for lights in view, outside, behind the eye (lines through
//! the picture of the antipode) and across the line of sight (w = 0, parallel lines)
//! alike. A line is named by where it *leaves* the picture, seen from the epipole, so an
//! epipole outside has lines on the far sides alone. A light of limited reach, or a
//! bounded medium, has lines of the rectangle of the pixels that it reaches.
//!
//! # Departures
//!
//! * Every other line ends half way to the epipole, every second one of the others at a
//!   quarter, and so on: lines stay between half of their distance at the border and all
//!   of it, where in the paper they crowd around the epipole.
//! * A sample is a ray of its own, through a point of the line, not of a pixel; it ends
//!   on the plane that the pixel around it sees.
//! * The search looks at every pixel between two samples, in a list of the edges of the
//!   picture that is made once for all lights. Sharp turns of a surface count as edges too,
//!   since the light of a pixel has a kink there, and so do the edges of a box of haze.
//! * The samples along a line are not a fixed number that discontinuities share: a line
//!   has as many as it needs.
//! * The paper marches along each sample's ray; here its light is exact, so that all of
//!   the error is that of the interpolation.
//! * Which rays to gather is known before anything is gathered, so that nothing is read
//!   back and pixels without resemblance are in the same list as the samples. It is found
//!   on the CPU on every backend.
//!
//! # Error
//!
//! Along a line that of linear interpolation: s²/8 of the second derivative of the light by
//! pixels, for a kink s/8 of the change of slope. Across lines the same with their distance.
//! Where the light itself jumps across lines, at the edge of a shaft that is seen edge on,
//! a jump is spread over that distance. Lines are a pixel apart at the closest: with more
//! samples along them, what is left is the error across them, a few thousandths of the mean,
//! and it is gone where every pixel is gathered by itself. What casts shadows between two
//! samples of a line and on neither is missed.
//!
//! # Cost
//!
//! For each light and pixel a few comparisons and two searches in lists of samples, on the
//! CPU: a fifth or more of what the lit runs of a sun cost there. The rays are one in s, one
//! and a half if the epipole is in view, and those of edges. Where lines would have more
//! samples than a light reaches pixels, these are gathered.
//!
//! Against a [grid](crate::methods::reduced) of every second pixel in both directions, at
//! 480 × 270 with 2 samples per 64 pixels: in as much time, a little less error where a low
//! sun shines past high-rises (0.5 % of the mean against 0.65 %), a sixth of it and less in
//! the cone of a spotlight with a cookie, whose pattern the grid cannot see; more where the
//! light is smooth and edges are many, as among mountains in haze. It does not pay where
//! the gather of a ray costs little more than its place on two lines: for an evaluator of
//! a few steps, for many lights that each have lines of their own, and on a GPU, which
//! waits for the CPU there.
//!
//! The scenes `city` and `landscape` at 480 × 270 with a map of 1024 texels, on two cores,
//! in one run each; errors are those against the reference, of which 1.3 and 0.095 % are
//! the map's own:
//!
//! | samples per 64 pixels | 1 | 2 | 4 | 8 | 16 | all pixels | march, 64 steps |
//! |---|---|---|---|---|---|---|---|
//! | city, ms | 26 | 34 | 52 | 61 | 80 | 101 | 181 |
//! | error, % | 1.46 | 1.34 | 1.33 | 1.32 | 1.32 | 1.34 | 5.6 |
//! | landscape, ms | 26 | 31 | 42 | 52 | 70 | 80 | 310 |
//! | error, % | 0.44 | 0.36 | 0.25 | 0.14 | 0.11 | 0.095 | 0.22 |

mod choice;
mod fill;
#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(all(test, feature = "wgpu"))]
mod gpu_tests;
mod lines;
mod method;
mod samples;
mod surfaces;
#[cfg(test)]
mod tests;

pub use choice::Choice;
pub use fill::FillFromLines;
pub use method::EpipolarSampling;
