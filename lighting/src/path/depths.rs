//! The distances in which the airlight of rays lies.

use crate::airlight::far_end;
use crate::scene::Medium;
use crate::{Interval, Ray};

/// The distances between which the airlight of `rays` lies: inside the box of a bounded medium,
/// and in front of the surfaces at the ends of the rays. A ray to the sky ends after ten mean
/// free paths of the thinnest colour channel that scatters, behind which 4.5e-5 of the light of
/// a sun is left. The end is always finite: if nothing scatters, it is where the medium begins.
pub fn depth_range(rays: &[Ray], medium: &Medium) -> Interval {
    let mut range = Interval::new(f32::INFINITY, 0.0);
    for ray in rays {
        let whole = Interval::new(0.0, ray.length());
        let inside = match medium.bounds() {
            Some(bounds) => bounds.clip(ray.origin(), ray.direction(), whole),
            None => Some(whole),
        };
        if let Some(inside) = inside {
            range.start = range.start.min(inside.start);
            range.end = range
                .end
                .max(inside.end.min(inside.start + far_end(medium)));
        }
    }
    if range.start < range.end {
        range
    } else {
        Interval::new(0.0, 0.0)
    }
}
