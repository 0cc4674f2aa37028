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
    /// The lit share of the texels around the point, lifted off the surface
    /// along its normal so that it does not shadow itself: by half a filter
    /// width, as in the paper, and the light's [bias](BakedShadow::bias) more: a
    /// voxel unless the file says otherwise, because point and surface are known to
    /// half a voxel each. Filters of one texel would be lifted by nothing otherwise.
    ///
    /// Where six grids meet, a window reaches over the rim of its grid into
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

/// Filtered shadows of several lights on surfaces, from [`BakedShadows`] in the memory `M`:
/// of each light what [`FilteredShadow`] tells.
///
/// On a GPU a point within rounding of the border of a voxel may be answered from the next
/// voxel, see `shadow_dag::gpu`; all other points have the same share to a few units in the
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

    /// How wide the filter is.
    pub fn size(&self) -> FilterSize {
        self.size
    }

    /// Lights of a point that one dispatch should take, as
    /// [`LitPoints::lights_per_dispatch`](crate::direct_light::LitPoints::lights_per_dispatch): as many as take some
    /// 50,000 turns of loops. One light alone takes more with filters that are wider than
    /// some 300 texels.
    pub fn lights_per_dispatch(&self) -> usize {
        let lights = self.shadows.lights().iter();
        let most = lights.map(|light| {
            // A window reaches over a corner into three grids.
            let grids = light.grids().len().min(3) as f64;
            let levels = light.grids().iter().map(|grid| grid.resolution().log2());
            grids * turns(self.size, levels.max().unwrap_or(0))
        });
        (MOST_TURNS / most.fold(1.0, f64::max)).max(1.0) as usize
    }
}

/// Turns for a node in a window: down to it, on to the next one, and among its children.
const TURNS_OF_NODE: f64 = 12.0;

/// Turns of loops for a window in a grid with so many levels, at most.
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
