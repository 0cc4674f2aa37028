//! See-through triangles as a light sees them: a surface on the ray of each texel.

use glam::Vec3;
use transmittance::BlockerSegment;

use super::bins::Bins;
use super::view::Texels;
use crate::scene::raster::{Face, Footprint};
use crate::scene::{Caster, Coatings, Geometry};

/// The see-through triangles that the rays through the centres of texels meet.
#[derive(Debug)]
pub(super) struct Panes {
    coatings: Coatings,
    /// Each triangle with its index in the geometry.
    all: Vec<(Footprint, u32)>,
    bins: Bins,
}

impl Panes {
    /// `None` if the geometry has no see-through triangles.
    pub(super) fn new(geometry: &Geometry, face: &Face, resolution: u32) -> Option<Self> {
        let coatings = geometry.coatings().clone();
        if !coatings.any_see_through() {
            return None;
        }
        let footprint = |(index, triangle)| match coatings.caster(index) {
            Caster::SeeThrough(_) => {
                let footprint = Footprint::new(face, triangle, resolution)?;
                Some((footprint, index as u32))
            }
            _ => None,
        };
        let triangles = geometry.triangles().iter().enumerate();
        let all: Vec<_> = triangles.filter_map(footprint).collect();
        let texels = |index: usize| {
            let footprint = &all[index].0;
            let ranges = [footprint.columns(), footprint.rows()];
            let [x, y] = ranges.map(|(first, end)| [first, end]);
            Some(Texels { x, y })
        };
        Some(Self {
            bins: Bins::new(resolution, all.len(), texels),
            coatings,
            all,
        })
    }

    /// Calls `put` with what the triangles take from each texel of a tile, in the colour
    /// channel of this index.
    ///
    /// A ray through the common edge of two triangles meets only one of them.
    pub(super) fn segments(
        &self,
        tile: &transmittance::Tile,
        channel: usize,
        put: &mut dyn FnMut([usize; 2], BlockerSegment),
    ) {
        let clamped = |texel: usize| u32::try_from(texel).unwrap_or(u32::MAX);
        let [columns, rows] =
            [&tile.x, &tile.y].map(|range| clamped(range.start)..clamped(range.end));
        for number in self.bins.of_tile(tile) {
            let (footprint, triangle) = &self.all[number as usize];
            let caster = self.coatings.caster(*triangle as usize);
            footprint.for_each_once(columns.clone(), rows.clone(), |x, y, depth| {
                let [u, v] = footprint.barycentric(x, y);
                let passing = caster.transmittance_at(u, v);
                if passing != Vec3::ONE
                    && let Ok(segment) = BlockerSegment::surface(depth, passing[channel])
                {
                    put([x as usize, y as usize], segment);
                }
            });
        }
    }
}
