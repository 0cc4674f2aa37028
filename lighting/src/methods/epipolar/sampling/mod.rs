//! Epipolar sampling: a few samples along the epipolar lines of the picture, and interpolation
//! between them.
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
//! # The lines
//!
//! The epipole is a projective point (x, y, w). Its lines follow from the sign and direction of
//! p w − (x, y). This covers lights in view, outside of it, behind the eye (lines through the
//! image of the antipode) and perpendicular to the view direction (w = 0, parallel lines). A
//! line is identified by the point at which it *leaves* the picture, seen from the epipole, so
//! an epipole outside of the picture has lines on the far sides only. For a light with a range,
//! or in a bounded medium, the lines are those of the rectangle around the pixels that it
//! reaches.
//!
//! # Departures
//!
//! * Every second line ends half way to the epipole, every second of the remaining ones at a
//!   quarter, and so on. So the distance of neighbouring lines stays between half of their
//!   distance at the border and all of it; in the paper lines crowd around the epipole.
//! * A sample has its own ray, through a point of the line and not through a pixel. It ends on
//!   the plane that the pixel around it sees.
//! * The search visits every pixel between two samples, in a list of the picture's edges that
//!   is made once for all lights. Sharp bends of a surface count as edges too, because the
//!   light of a pixel has a kink there, and so do the edges of a box of haze.
//! * The samples along a line are not a fixed number that discontinuities share: a line has as
//!   many as it needs.
//! * The paper marches along the ray of each sample. Here its light is exact, so that all of
//!   the error is from interpolation.
//! * The rays are chosen before anything is gathered, so that nothing is read back, and pixels
//!   without resemblance are in the same list as the samples. The choice is made on the CPU for
//!   every backend.
//!
//! # Error
//!
//! Along a line it is the error of linear interpolation: s²/8 times the second derivative of
//! the light by pixels, and at a kink s/8 times the change of slope. Across lines it is the
//! same with their distance. Where the light itself jumps across lines, at the edge of a shaft
//! seen edge-on, the jump is spread over that distance. Lines are at least a pixel apart. With
//! more samples along them the error across them remains, a few thousandths of the mean; it
//! vanishes where every pixel is gathered by itself. A shadow that lies between two samples of
//! a line and on neither of them is missed.
//!
//! # Cost
//!
//! For each light and pixel, a few comparisons and two searches in lists of samples on the CPU,
//! which take a fifth or more of the time that the lit runs of a sun take there. The rays are
//! one in s pixels, one and a half times as many if the epipole is in view, and those at edges.
//! If lines would have more samples than the light reaches pixels, these pixels are gathered
//! instead.
//!
//! Compared with a [grid](crate::methods::reduced) of every second pixel in both directions, at
//! 480 × 270 with 2 samples per 64 pixels and in equal time: the error is slightly smaller
//! where a low sun shines past high-rises (0.5 % of the mean against 0.65 %), and a sixth or
//! less in the cone of a spotlight with a cookie, whose pattern the grid cannot see. It is
//! larger where the light is smooth and there are many edges, as among mountains in haze. The
//! method does not pay if the gather of a ray costs little more than finding its place on two
//! lines: for an evaluator with a few steps, for many lights, each with lines of its own, and
//! on a GPU, which waits for the CPU.
//!
//! The scenes `city` and `landscape` at 480 × 270 with a map of 1024 texels, on two cores, one
//! run each. Errors are against the reference; 1.3 and 0.095 % of them are those of the map
//! itself:
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
