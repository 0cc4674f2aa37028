//! From any description of the casters that can be split to a column.

use crate::column::{Column, Columns};
use crate::interval::Interval;
use crate::patches::{Patch, Patches};
use crate::pool::Pool;
use crate::rule::Tile;

/// Shadow casters over a square footprint that can be looked at quarter by
/// quarter.
pub(crate) trait Footprints {
    /// The state with which a walk goes on with one quarter of a footprint.
    type Part: Copy;

    /// Looks at a footprint of `8 · 2^level` texels. On level 0 the answer is
    /// never [`Content::Quarters`], and [`Content::Flat`] only there; with
    /// [`Content::Texels`] they have been written.
    fn content(&mut self, level: usize, part: Self::Part, texels: &mut Tile)
    -> Content<Self::Part>;

    /// Forgets what [`Footprints::content`] made for the quarters of `part`.
    fn leave(&mut self, part: Self::Part);

    /// The plane that is all there is over a footprint, if there is one whose
    /// columns are worth being kept. It is in none of the first and the last
    /// `8 · 2^level` slices.
    fn patch(&self, _level: usize, _part: Self::Part) -> Option<Patch> {
        None
    }

    /// Whether answers may be wrong because of a stop.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// The casters over a footprint.
#[derive(Debug)]
pub(crate) enum Content<P> {
    /// All texels can turn at any one of these depths.
    Uniform(Interval),
    /// As before, of a single tile, but what is around it is not to choose
    /// the same.
    Flat(Interval),
    /// It takes a closer look at the quarters, `2 y + x`.
    Quarters([P; 4]),
    /// The texels themselves.
    Texels,
}

impl Columns {
    /// The column over one footprint of `footprints`. `patches` are of `pool`.
    pub(crate) fn column<F: Footprints>(
        &mut self,
        footprints: &mut F,
        level: usize,
        part: F::Part,
        pool: &mut Pool,
        patches: &mut Patches,
    ) -> Column {
        let place = footprints
            .patch(level, part)
            .and_then(|patch| patches.place(level, &patch));
        if let Some(column) = place.and_then(|place| patches.recall(place, self)) {
            return column;
        }
        let mut tile = Tile::default();
        let column = match footprints.content(level, part, &mut tile) {
            Content::Uniform(interval) => Column::Uniform(interval),
            Content::Flat(interval) => self.flat(interval, pool),
            Content::Texels => self.tile(&tile, pool),
            Content::Quarters(quarters) => {
                let first = self.top();
                let quarters =
                    quarters.map(|part| self.column(footprints, level - 1, part, pool, patches));
                footprints.leave(part);
                self.merge(level, quarters, first, pool)
            }
        };
        if let Some(place) = place.filter(|_| !footprints.is_stopped()) {
            patches.keep(place, self, column);
        }
        column
    }
}
