//! Ray marching in the picture of a spotlight.
//!
//! Based on: Gautron, Marvie and François, Volumetric Shadow Mapping, SIGGRAPH 2009 Talks. A
//! march of equal steps along a ray passes many texels of the shadow map per step where the ray
//! is near the light, and stays within one texel where it is far. Steps that are equal *in the
//! map* pass as many texels everywhere, and so as much of a cookie.
//!
//! # The steps
//!
//! The span of the ray in the cone runs from a to b, with the depths z_a and z_b in front of
//! the light (distances from the plane through the light that is perpendicular to its axis). A
//! projection divides by the depth. So the point at a share t of the way from a to b in the
//! picture is, on the ray,
//!
//! ```text
//! x(t) = (a (1 − t) z_b + b t z_a) / ((1 − t) z_b + t z_a)
//! ```
//!
//! which is a convex combination of a and b, so no point leaves the span. In a beam seen from
//! the side, steps are nearly equal. Along the beam or towards the light they become shorter in
//! proportion to the square of the depth, as the light becomes stronger.
//!
//! A ray through the light is a single point of the picture, and every division of it would be
//! valid. In this case z_a or z_b is 0, and the formula would put all steps there. So a depth
//! below a thousandth of the other one counts as that much, and the shortest step is a
//! millionth of the longest. This holds for every ray: where the far end is kilometres away in
//! thin air, the first metres in front of a light share a step. A ray to the sky ends after ten
//! mean free paths.
//!
//! # Departures
//!
//! * The light of a step is not its value at the middle times its length: an evaluator
//!   integrates it, by default in the angle at the light, for which one node is exact for the
//!   inverse square.
//! * Lights other than spotlights have no single image plane. A point light has equal
//!   directions instead: steps of equal angle at the light ([`Spacing::EquiAngular`]). In the
//!   picture of a sun, equal steps are equal on the ray: [`Spacing::Distance`].
//! * A step can ask any [`PointVisibility`](crate::visibility::PointVisibility). With a
//!   transmittance map, shadows of hair, smoke and glass have soft edges, which the talk leaves
//!   for later.
//!
//! The talk's ambient light that the fog scatters is not part of a method:
//! [`environment`](crate::environment) adds it to any picture.
//!
//! # Cost and error
//!
//! The cost is one lookup for each step, as for any march. The ends of lit parts are off by
//! half a step, which is half a texel of a map with as many texels as steps. Below a leaded
//! window (a beam of 52°, a map of 256²) the error relative to the mean is
//!
//! | steps | 4 | 16 | 64 | 256 | 1024 | equal steps for the same |
//! |---|---|---|---|---|---|---|
//! | across the beam | 39 % | 8.7 % | 4.8 % | 0.80 % | 0.21 % | 1.0 × |
//! | towards the light | 18 % | 5.7 % | 1.3 % | 0.57 % | 0.12 % | 8.2 × |
//! | from beside it | 19 % | 4.0 % | 0.93 % | 0.26 % | 0.06 % | 4.5 × |
//!
//! Where a ray keeps its depth, steps that are equal on the ray are equal in the picture too.
//! Steps of equal angle are as good in all three rows, and need no plane. What steps in the
//! picture add is that a cookie of n texels across is sampled n times by n steps, whatever the
//! ray.
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
