//! Slices: planes parallel to the picture that are blended into it, as games did before ray
//! marching.
//!
//! Based on: Dobashi, Yamamoto and Nishita, Interactive Rendering of Atmospheric Scattering
//! Effects Using Graphics Hardware, Graphics Hardware 2002; Mitchell, Light Shaft
//! Rendering, ShaderX3, 2004; Imagire, Johan, Tamura and Nishita, Anti-Aliased and Real-Time
//! Rendering of Scenes with Light Scattering Effects, The Visual Computer 2007.
//!
//! n planes lie across the axis of the camera, at equal distances over the depths at which a
//! light reaches what the eye sees. On each plane the shadow map is asked at the point where
//! the ray of a pixel crosses it, and the answer stands for the slab halfway to the
//! neighbouring planes. Here it is a baseline; the papers on ray marching argue against it.
//!
//! # Error
//!
//! * All slabs have the same thickness: a nearby beam, or a light in view, has as many of them
//!   as a distant wall, and a short ray crosses only a few.
//! * A plane behind a surface is hidden, and its slab is lost with the part that is in front of
//!   the surface. So along a floor the light changes in steps of one slab's thickness. The same
//!   happens where a ray enters a cone, a range or a box. So pictures are too dark, and parts
//!   of rays between two planes are black.
//! * All rays ask at the same depths, so that the steps line up as contours.
//!
//! All of these errors are proportional to the thickness, 1/n.
//!
//! # Departures
//!
//! The light of a slab is integrated by any evaluator over the part that lies within the cone,
//! the range and in front of the surface, so that the error is that of the planes alone.
//! Dobashi et al. divide slabs further where the light changes, by planes that are not drawn;
//! here more planes serve that purpose. Imagire et al. average over boxes of voxels to hide the
//! contours, which also blurs the shadows.
//!
//! The depths are those of the rays of a frame. In a frame with some of the pixels only, as at
//! a low resolution, planes lie elsewhere than in the whole picture. Finding the depths takes
//! one test for each ray and light.
//!
//! A ray at more than 89.9° to the axis counts as one at that angle.

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

/// Divides a ray into parts around some planes; each part is as lit as the point on its plane.
#[derive(Debug, Clone, Copy)]
pub struct Slices<P> {
    points: P,
    forward: Vec3,
    near: f32,
    far: f32,
    count: u32,
}

impl<P> Slices<P> {
    /// `count` slices (0 counts as 1) across the unit vector `forward`, from `near` to `far`
    /// metres in front of the eye. `points` is the source of visibility; it must belong to the
    /// light that is gathered.
    pub fn new(points: P, count: u32, forward: Vec3, [near, far]: [f32; 2]) -> Self {
        Self {
            points,
            forward,
            near: near.max(0.0),
            far,
            count: count.max(1),
        }
    }

    /// The source that is asked on each plane.
    pub fn points(&self) -> &P {
        &self.points
    }

    /// Number of slices.
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
        // Slabs in front of the span are skipped.
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
