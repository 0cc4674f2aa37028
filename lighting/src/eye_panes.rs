//! What covers parts of the rays of a frame, as their origins see them.

use glam::Vec3;
#[cfg(feature = "trace")]
use gpu_backend::Cpu;

#[cfg(feature = "trace")]
use crate::Ray;

/// The see-through surfaces before the ends of the rays of a frame: what is behind
/// one of them is seen through it, the light of the air too.
///
/// A gather that is given them multiplies the light of each part of a ray by what
/// all of them before it let through, and cuts the part where the ray meets one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EyePanes {
    /// Where the panes of each ray end.
    ends: Vec<u32>,
    panes: Vec<Behind>,
}

/// The way of a ray behind a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Behind {
    /// Where it begins, m from the origin.
    pub(crate) from: f32,
    /// The share of its light that this surface and all before it let through.
    pub(crate) share: Vec3,
}

impl EyePanes {
    /// What covers parts of these rays; `None` if nothing does.
    ///
    /// Cost: one traced ray each, unless nothing in the scene is see-through.
    #[cfg(feature = "trace")]
    pub fn new(cpu: &Cpu, tracer: &crate::scene::trace::Tracer, rays: &[Ray]) -> Option<Self> {
        if !tracer.coatings().any_see_through() {
            return None;
        }
        let mut all = Self::default();
        for panes in cpu.map(rays.len(), |ray| tracer.panes(&rays[ray])) {
            let mut share = Vec3::ONE;
            all.panes.extend(panes.iter().map(|pane| {
                share *= pane.transmittance;
                Behind {
                    from: pane.hit.distance,
                    share,
                }
            }));
            // More do not fit into memory.
            all.ends.push(all.panes.len() as u32);
        }
        (!all.panes.is_empty()).then_some(all)
    }

    /// Those of the ray of this number, the nearest first; none if there is no such
    /// ray.
    pub(crate) fn of(&self, ray: u32) -> &[Behind] {
        let Some(&end) = self.ends.get(ray as usize) else {
            return &[];
        };
        &self.panes[self.start(ray) as usize..end as usize]
    }

    /// The number of the first of a ray that there is.
    fn start(&self, ray: u32) -> u32 {
        let before = ray.checked_sub(1);
        before.map_or(0, |before| self.ends[before as usize])
    }

    /// Appends to `table` what shaders read of `count` rays from `first` on: where the
    /// panes of each end, four to an entry, and then the panes.
    #[cfg(feature = "wgpu")]
    pub(crate) fn write(&self, first: u32, count: usize, table: &mut Vec<[u32; 4]>) {
        let first = (first as usize).min(self.ends.len());
        let ends = &self.ends[first..self.ends.len().min(first + count)];
        let start = match ends {
            [] => 0,
            _ => self.start(first as u32),
        };
        let last = ends.last().copied().unwrap_or(start);
        for entry in 0..count.div_ceil(4) {
            let end = |ray: usize| ends.get(ray).map_or(last, |end| *end) - start;
            table.push(std::array::from_fn(|i| end(4 * entry + i)));
        }
        let panes = &self.panes[start as usize..last as usize];
        table.extend(panes.iter().map(|pane| {
            let [r, g, b] = pane.share.to_array();
            [r, g, b, pane.from].map(f32::to_bits)
        }));
    }
}
