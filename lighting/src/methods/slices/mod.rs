//! Planes parallel to the picture, blended into it: what games did before marches.
//!
//! Based on: Dobashi, Yamamoto and Nishita, Interactive Rendering of Atmospheric Scattering
//! Effects Using Graphics Hardware, Graphics Hardware 2002; Mitchell, Light Shaft
//! Rendering, ShaderX3, 2004; Imagire, Johan, Tamura and Nishita, Anti-Aliased and Real-Time
//! Rendering of Scenes with Light Scattering Effects, The Visual Computer 2007.
//!
//! n planes across the axis of the camera, at equal distances over the depths at which a
//! light reaches what the eye sees. At each the shadow map is asked where the ray of a pixel crosses it,
//! and the answer stands for the slab halfway to its neighbours. It is the method that
//! the papers on marching argue against, and a baseline here.
//!
//! # Error
//!
//! * Slabs have one thickness, whatever lies in them: a beam that is near, or a light in
//!   view, has as many of them as a wall far away, and a short ray crosses few.
//! * A plane behind a surface is hidden by it, and its slab is lost, with the part before
//!   the surface. So along a floor the light changes in steps, as long as a slab is thick.
//!   The same is lost where a ray enters a cone, a range or a box, so that pictures are too
//!   dark, and parts of rays between two planes are black.
//! * All rays ask at the same depths, so that the steps line up as contours.
//!
//! All of it is in proportion to the thickness, 1/n.
//!
//! # Departures
//!
//! The light of a slab is integrated by any evaluator over what lies within the cone, the
//! range and the surface, so that the error is that of the planes alone. Dobashi
//! et al. divide slabs further where the light changes, by planes between them that are
//! not seen: here more planes do it. Imagire et al. average over boxes of voxels against the
//! contours, and blur what they average.
//!
//! The depths are those of the rays of a frame: where it has some of the pixels only, as at
//! a low resolution, planes lie elsewhere than in the whole picture. Finding them takes a
//! look at every ray for each light.
//!
//! Rays more than 89.9° from the axis count as ones at that angle.

#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
mod tests;

use glam::Vec3;

#[cfg(feature = "methods")]
pub(super) use method::methods;

use crate::visibility::{LitInterval, PointVisibility, Share, VisibilitySource};
use crate::{Interval, LightPath};

/// The cosine of the largest angle between a ray and the axis.
const LEAST_COS: f32 = 1.8e-3;

/// The part of a ray around each of some planes, as lit as the point on the plane.
#[derive(Debug, Clone, Copy)]
pub struct Slices<P> {
    points: P,
    forward: Vec3,
    near: f32,
    far: f32,
    count: u32,
}

impl<P> Slices<P> {
    /// `count` slices (0 counts as 1) across `forward`, a unit vector, from `near` to `far`
    /// metres before the eye. What is asked is `points`, of the light that is gathered.
    pub fn new(points: P, count: u32, forward: Vec3, [near, far]: [f32; 2]) -> Self {
        Self {
            points,
            forward,
            near: near.max(0.0),
            far,
            count: count.max(1),
        }
    }

    /// What is asked on each plane.
    pub fn points(&self) -> &P {
        &self.points
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.count
    }
}

impl<P: PointVisibility> VisibilitySource for Slices<P> {
    type Share = P::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<P::Share>>) {
        let (span, ray) = (path.span(), path.ray());
        let cos = ray.direction().dot(self.forward).max(LEAST_COS);
        let near = self.near / cos;
        let thickness = (self.far - self.near) / (self.count as f32 * cos);
        if !(thickness > 0.0 && thickness.is_finite()) {
            return;
        }
        // Slabs before the span are passed over.
        let first = ((span.start - near) / thickness) as u32;
        for i in first..self.count {
            let start = near + i as f32 * thickness;
            if start >= span.end {
                break;
            }
            let plane = near + (i as f32 + 0.5) * thickness;
            if plane < span.start || plane >= span.end {
                continue;
            }
            let visibility = self.points.visibility(ray.at(plane));
            if !visibility.is_dark() {
                let end = near + (i + 1) as f32 * thickness;
                lit.push(LitInterval {
                    interval: Interval::new(start.max(span.start), end.min(span.end)),
                    visibility,
                });
            }
        }
    }
}
