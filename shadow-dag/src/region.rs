//! A part of the depth maps with its min–max pyramid.

use crate::footprint::{Content, Footprints};
use crate::interval::Interval;
use crate::rule::{Rule, Tile};
use crate::{DepthSource, Error, Exits, TileRect};

/// Depths of a square of texels and their bounds: one entry per 8×8 tile,
/// per 16×16 texels, and so on.
#[derive(Debug, Default)]
pub(crate) struct Region {
    side: usize,
    enter: Vec<u32>,
    exit: Vec<u32>,
    pyramid: Vec<Vec<Interval>>,
    rule: Rule,
}

impl Region {
    /// Takes in the depths of `tile`.
    pub(crate) fn read<C: DepthSource + ?Sized>(
        &mut self,
        casters: &C,
        tile: TileRect,
        rule: Rule,
    ) -> Result<(), Error> {
        self.side = tile.side as usize;
        self.rule = rule;
        self.enter.resize(tile.len(), 0);
        self.exit.resize(tile.len(), 0);
        let exits = casters.read(tile, &mut self.enter, &mut self.exit)?;
        let end = casters.resolution().side();
        if exits == Exits::Open {
            self.exit.copy_from_slice(&self.enter);
        }
        for (enter, exit) in self.enter.iter_mut().zip(&mut self.exit) {
            *enter = (*enter).min(end);
            *exit = (*exit).clamp(*enter, end);
        }
        self.bound();
        Ok(())
    }

    fn bound(&mut self) {
        let mut tiles = Vec::with_capacity((self.side / 8).pow(2));
        let mut last = vec![0; self.side];
        let mut first = vec![u32::MAX; self.side];
        let rows = self
            .enter
            .chunks(8 * self.side)
            .zip(self.exit.chunks(8 * self.side));
        for (enter, exit) in rows {
            last.fill(0);
            first.fill(u32::MAX);
            for (enter, exit) in enter.chunks(self.side).zip(exit.chunks(self.side)) {
                for (last, &enter) in last.iter_mut().zip(enter) {
                    *last = enter.max(*last);
                }
                for (first, &exit) in first.iter_mut().zip(exit) {
                    *first = exit.min(*first);
                }
            }
            for (last, first) in last.chunks(8).zip(first.chunks(8)) {
                tiles.push(Interval {
                    enter: last.iter().fold(0, |a, &b| a.max(b)),
                    exit: first.iter().fold(u32::MAX, |a, &b| a.min(b)),
                });
            }
        }
        self.pyramid.clear();
        let mut width = self.side / 8;
        self.pyramid.push(tiles);
        while width > 1 {
            let below = &self.pyramid[self.pyramid.len() - 1];
            let mut level = Vec::with_capacity(width * width / 4);
            for rows in below.chunks(2 * width) {
                let (upper, lower) = rows.split_at(width);
                for (a, b) in upper.chunks(2).zip(lower.chunks(2)) {
                    level.push(a[0].meet(a[1]).meet(b[0].meet(b[1])));
                }
            }
            self.pyramid.push(level);
            width /= 2;
        }
    }
}

impl Footprints for Region {
    /// Column and row, in footprints of the level.
    type Part = (usize, usize);

    fn content(
        &mut self,
        level: usize,
        (x, y): (usize, usize),
        tile: &mut Tile,
    ) -> Content<(usize, usize)> {
        let width = self.side >> (3 + level);
        let bounds = self.pyramid[level][y * width + x];
        if !bounds.is_empty() {
            // The rules of the papers let every volume choose for itself.
            match self.rule {
                Rule::Aligned => return Content::Uniform(bounds),
                Rule::Sintorn2014 | Rule::Kampe2015 if level == 0 => return Content::Flat(bounds),
                Rule::Sintorn2014 | Rule::Kampe2015 => {}
            }
        }
        if level > 0 {
            let (x, y) = (2 * x, 2 * y);
            return Content::Quarters([(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]);
        }
        let start = 8 * (y * self.side + x);
        for row in 0..8 {
            let from = start + row * self.side;
            tile.enter[8 * row..][..8].copy_from_slice(&self.enter[from..][..8]);
            tile.exit[8 * row..][..8].copy_from_slice(&self.exit[from..][..8]);
        }
        Content::Texels
    }

    fn leave(&mut self, _: (usize, usize)) {}
}
