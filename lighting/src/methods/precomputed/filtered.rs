//! Filtered shadows on surfaces.

use glam::Vec3;
use gpu_backend::{Host, Memory};
use shadow_dag::FilterSize;

use super::{BakedShadow, BakedShadows};
use crate::direct_light::ShadowsOfMany;
use crate::gather::MOST_TURNS;
use crate::visibility::SurfaceShadow;

/// Filtered shadows on surfaces, from a [`BakedShadow`].
#[derive(Debug, Clone, Copy)]
pub struct FilteredShadow<'a> {
    shadow: &'a BakedShadow,
    size: FilterSize,
}

impl BakedShadow {
    /// Shadows on surfaces, filtered over `size` texels.
    pub fn filtered(&self, size: FilterSize) -> FilteredShadow<'_> {
        FilteredShadow { shadow: self, size }
    }
}

impl SurfaceShadow for FilteredShadow<'_> {
    /// The lit share of the texels around the point. The point is lifted off the surface along
    /// its normal so that the surface does not shadow itself: by half the width of the filter,
    /// as in the paper, plus the light's [bias](BakedShadow::bias). The bias is one voxel
    /// unless the file says otherwise, because point and surface are each known to half a
    /// voxel. Filters of one texel would not be lifted otherwise.
    ///
    /// Where six grids meet, a window that crosses the border of its grid continues in the next
    /// grid, and the shadowed shares add up.
    /// the next one's, which has the rest of it: shadowed shares add up.
    fn visibility(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let mut shadowed = 0.0;
        for grid in self.shadow.grids() {
            let resolution = grid.resolution();
            let Some(space) = grid.light() else { continue };
            let Some(position) = space.voxel(resolution, point) else {
                continue;
            };
            let normal = space.normal(point, normal);
            let voxel = (self.size).bias_beyond(self.shadow.bias(), position, normal);
            shadowed += 1.0 - grid.filter(voxel, self.size);
        }
        Vec3::splat((1.0 - shadowed).max(0.0))
    }
}

/// Filtered shadows of several lights on surfaces, from [`BakedShadows`] in the memory `M`. For
/// each light they give what [`FilteredShadow`] gives.
///
/// On a GPU, a point within rounding of the border of a voxel may be looked up in the next
/// voxel, see `shadow_dag::gpu`. All other points have the same share to a few units in the
/// last place.
#[derive(Debug)]
pub struct FilteredShadows<'a, M: Memory = Host> {
    shadows: &'a BakedShadows<M>,
    size: FilterSize,
}

impl<M: Memory> BakedShadows<M> {
    /// Shadows on surfaces, filtered over `size` texels.
    pub fn filtered(&self, size: FilterSize) -> FilteredShadows<'_, M> {
        FilteredShadows {
            shadows: self,
            size,
        }
    }
}

impl<'a, M: Memory> FilteredShadows<'a, M> {
    /// The shadows that are filtered.
    pub fn shadows(&self) -> &'a BakedShadows<M> {
        self.shadows
    }

    /// The width of the filter.
    pub fn size(&self) -> FilterSize {
        self.size
    }

    /// How many lights of a point one dispatch should take, for
    /// [`LitPoints`](crate::direct_light::LitPoints): so many that an invocation runs some
    /// 50,000 iterations of its loops, which drivers allow. A single light exceeds this with
    /// filters wider than some 300 texels.
    pub fn lights_per_dispatch(&self) -> usize {
        let lights = self.shadows.lights().iter();
        let most = lights.map(|light| {
            // At a corner a window reaches into three grids.
            let grids = light.grids().len().min(3) as f64;
            let levels = light.grids().iter().map(|grid| grid.resolution().log2());
            grids * turns(self.size, levels.max().unwrap_or(0))
        });
        (MOST_TURNS / most.fold(1.0, f64::max)).max(1.0) as usize
    }
}

/// Loop iterations for a node in a window: down to it, on to the next one, and through its
/// children.
const TURNS_OF_NODE: f64 = 12.0;

/// The largest number of loop iterations for a window in a grid with so many levels.
fn turns(size: FilterSize, log2: u32) -> f64 {
    let nodes = (3..log2.max(4)).map(|level| {
        let across = (size.width() - 1).div_ceil(1 << level) + 1;
        f64::from(across) * f64::from(across)
    });
    TURNS_OF_NODE * nodes.sum::<f64>()
}

impl ShadowsOfMany for FilteredShadows<'_> {
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let shadow = self.shadows.lights().get(light);
        shadow.map_or(Vec3::ZERO, |shadow| {
            shadow.filtered(self.size).visibility(point, normal)
        })
    }
}
