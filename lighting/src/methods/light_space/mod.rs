//! Ray marching in the picture of a spotlight.
//!
//! Based on: Gautron, Marvie and François, Volumetric Shadow Mapping, SIGGRAPH 2009 Talks.
//! A march of equal steps along a ray passes over many texels of the shadow map where the
//! ray is near the light and stays on one where it is far. Steps that are equal *in the
//! map* pass over as many texels everywhere, and so over as much of a cookie.
//!
//! # The steps
//!
//! The span of the ray in the cone runs from a to b, whose depths in front of the light
//! (distances from the plane through it across its axis) are z_a and z_b. A projection
//! divides by the depth. So the point that is a share t of the way from a to b in the
//! picture is, on the ray,
//!
//! ```text
//! x(t) = (a (1 − t) z_b + b t z_a) / ((1 − t) z_b + t z_a)
//! ```
//!
//! a convex combination of a and b: no point ever leaves the span. Steps in a beam seen from the side
//! are near the equal ones; along the beam or towards the light they become shorter in
//! proportion to the square of the depth, as the light becomes stronger.
//!
//! A ray through the light is a single point of the picture, and every division is
//! right. Then z_a or z_b is 0, and the formula would put all steps there; less than a
//! thousandth of the other depth counts as that much, so that the shortest step is a
//! millionth of the longest. That holds for every ray: where the far end is kilometres
//! away in thin air, the first metres before a light share a step. A ray to the sky ends
//! after ten mean free paths.
//!
//! # Departures
//!
//! * The light of a step is not its value in the middle times its length: an evaluator
//!   integrates it, by default in the angle at the light, of which one node is exact for
//!   the inverse square.
//! * Other lights than spotlights project on no one plane. Of a point light the
//!   directions themselves are equal: steps of equal angle at it
//!   ([`Spacing::EquiAngular`]). A sun's picture has equal steps where the ray has:
//!   [`Spacing::Distance`].
//! * What is asked at a step is any [`PointVisibility`](crate::visibility::PointVisibility):
//!   with a map of transmittance the shadows of hair, smoke and glass have soft edges, which
//!   the talk leaves for later.
//!
//! The talk's ambient light that the fog scatters is not part of a method:
//! [`environment`](crate::environment) adds it to any picture.
//!
//! # Cost and error
//!
//! A lookup for each step, as for any march. The ends of lit parts are off by half a
//! step, half a texel of a map of as many texels as steps. Below a leaded window (a beam
//! of 52°, a map of 256²) the error relative to the mean is
//!
//! | steps | 4 | 16 | 64 | 256 | 1024 | equal steps for the same |
//! |---|---|---|---|---|---|---|
//! | across the beam | 39 % | 8.7 % | 4.8 % | 0.80 % | 0.21 % | 1.0 × |
//! | towards the light | 18 % | 5.7 % | 1.3 % | 0.57 % | 0.12 % | 8.2 × |
//! | from beside it | 19 % | 4.0 % | 0.93 % | 0.26 % | 0.06 % | 4.5 × |
//!
//! Where a ray keeps its depth, equal steps are equal in the picture too. Steps of equal
//! angle do as well as these in all three rows, and they need no plane: what this adds to
//! them is that a cookie of n texels across is met n times by n steps, whatever the ray.
//!
//! ```
//! use glam::{Quat, Vec3};
//! use lighting::scene::{Cone, Emission, Emitter, Medium, PhaseFunction};
//! use lighting::visibility::{March, Spacing, Unshadowed, VisibilitySource};
//! use lighting::{LightPath, Ray};
//!
//! // Downwards from 2 m above the eye, and a ray that rises into the beam.
//! let cone = Cone { inner: 0.0, outer: 0.4 };
//! let emission = Emission::spot(Quat::from_rotation_x(-1.5708), cone, None)?;
//! let spot = Emitter::point(Vec3::new(0.0, 2.0, -3.0), Vec3::ONE, 10.0, emission)?;
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! let ray = Ray::new(Vec3::ZERO, Vec3::new(0.0, 0.5, -1.0), 8.0).expect("a sound ray");
//! let path = LightPath::new(&ray, &spot, &fog).expect("it meets the beam");
//! let mut steps = Vec::new();
//! March::new(Unshadowed, 8, Spacing::Picture).lit_intervals(&path, &mut steps);
//! // Steps become shorter towards the light.
//! assert!(steps[7].interval.length() < steps[0].interval.length());
//! # Ok::<(), lighting::scene::SceneError>(())
//! ```

#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
mod tests;

#[cfg(feature = "methods")]
pub(super) use method::methods;

#[cfg(doc)]
use crate::visibility::Spacing;
