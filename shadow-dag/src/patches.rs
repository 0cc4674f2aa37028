//! Columns over patches of planes, which repeat.
//!
//! Over a footprint under a plane the slice of a texel is `⌈v + a x + b y⌉`,
//! where `v` is that of its first texel before rounding and `a` and `b` are the
//! slopes in slices per texel. Which slices those are, counted from `⌊v⌋`, only
//! depends on where among the fractions of `−(a x + b y)` that of `v` lies: they
//! are at most as many as texels. Which nodes they make depends on `⌊v⌋` within
//! a node as well. Two footprints that agree in both have the same column,
//! moved by whole nodes.
//!
//! All that is computed in f64, so a `v` that is so close to one of the
//! fractions that rounding could decide is left to be looked at by itself.

use std::collections::HashMap;

use crate::column::{Column, Columns, Run};
use crate::interval::Interval;
use crate::pool::{LIT, Table};

/// A footprint under a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    /// The slice of the first texel before it is rounded up.
    pub(crate) at: f64,
    /// By how much that grows from one column or row of texels to the next.
    pub(crate) slope: [f64; 2],
    /// A bound of how far the slices of texels, before they are rounded up, are
    /// from those that follow from the above.
    pub(crate) error: f64,
}

/// Where the column over a patch is kept.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    generation: u32,
    plane: usize,
    level: usize,
    number: usize,
    /// By how many nodes the column is moved.
    shift: u32,
}

/// A column, as if its patch began within the first node along the light.
#[derive(Debug, Clone, Copy)]
struct Kept {
    /// The runs behind the first, which is lit; none if the column is uniform.
    runs: Option<(usize, usize)>,
    bounds: Interval,
}

#[derive(Debug, Default)]
struct Level {
    /// The fractions of `v` at which the slice of a texel changes, in order.
    breaks: Vec<f64>,
    known: Table<u64>,
    /// By the number of what is known.
    kept: Vec<Option<Kept>>,
}

#[derive(Debug)]
struct Plane {
    slope: [u64; 2],
    levels: Vec<Level>,
}

/// Columns that have been made of patches, with nodes of one pool.
#[derive(Debug, Default)]
pub(crate) struct Patches {
    planes: Vec<Plane>,
    numbers: HashMap<[u64; 2], usize>,
    /// The plane that was asked for last.
    last: usize,
    runs: Vec<Run>,
    entries: usize,
    generation: u32,
}

/// When so many columns and breaks are kept, which is about 100 MB, all of them are dropped.
const MOST: usize = 1 << 21;

fn moved(bounds: Interval, by: u32) -> Interval {
    Interval {
        enter: bounds.enter.wrapping_add(by),
        exit: bounds.exit.wrapping_add(by),
    }
}

impl Level {
    fn new(slope: [f64; 2], side: usize) -> Self {
        let fractions = (0..side * side).map(|texel| {
            let rise = slope[0] * (texel % side) as f64 + slope[1] * (texel / side) as f64;
            1.0 - (rise - rise.floor())
        });
        let mut breaks: Vec<f64> = fractions.collect();
        breaks.sort_unstable_by(f64::total_cmp);
        Self {
            breaks,
            ..Self::default()
        }
    }

    /// Between which of the breaks a fraction lies; none if it may be on either
    /// side of one.
    fn class(&self, fraction: f64, error: f64) -> Option<usize> {
        // 0 and 1 are breaks as well: those of the first texel.
        let class = self.breaks.partition_point(|&at| at < fraction);
        let before = match class {
            0 => 0.0,
            class => self.breaks[class - 1],
        };
        let behind = self.breaks.get(class).map_or(1.0, |&at| at);
        (fraction - before > error && behind - fraction > error).then_some(class)
    }
}

impl Patches {
    /// Where the column over a patch of `8 · 2^level` texels is kept, or is to
    /// be. The surface must not be in the first or the last node along the
    /// light. None if rounding decides about the column.
    pub(crate) fn place(&mut self, level: usize, patch: &Patch) -> Option<Place> {
        if self.entries > MOST {
            *self = Self {
                generation: self.generation.wrapping_add(1),
                ..Self::default()
            };
        }
        let side = 8_usize << level;
        let plane = self.plane(patch.slope);
        let levels = &mut self.planes[plane].levels;
        if levels.len() <= level {
            levels.resize_with(level + 1, Level::default);
        }
        let of_level = &mut levels[level];
        if of_level.breaks.is_empty() {
            *of_level = Level::new(patch.slope, side);
            self.entries += side * side;
        }
        let whole = patch.at.floor();
        let class = of_level.class(patch.at - whole, patch.error)?;
        let (node, within) = (whole as usize / side, whole as usize % side);
        let number = of_level.known.insert((class as u64) << 32 | within as u64) as usize;
        if number >= of_level.kept.len() {
            of_level.kept.resize(number + 1, None);
            self.entries += 1;
        }
        Some(Place {
            generation: self.generation,
            plane,
            level,
            number,
            shift: node as u32,
        })
    }

    fn plane(&mut self, slope: [f64; 2]) -> usize {
        let slope = slope.map(f64::to_bits);
        if self.planes.get(self.last).map(|plane| plane.slope) != Some(slope) {
            self.last = *self.numbers.entry(slope).or_insert_with(|| {
                self.planes.push(Plane {
                    slope,
                    levels: Vec::new(),
                });
                self.planes.len() - 1
            });
        }
        self.last
    }

    /// The column that is kept there, if there is one, put on the stack.
    pub(crate) fn recall(&self, place: Place, columns: &mut Columns) -> Option<Column> {
        let kept = self.planes[place.plane].levels[place.level].kept[place.number]?;
        let bounds = moved(kept.bounds, place.shift * (8 << place.level));
        let Some((start, end)) = kept.runs else {
            return Some(Column::Uniform(bounds));
        };
        let lit = Run {
            start: 0,
            node: LIT,
        };
        let behind = self.runs[start..end].iter().map(|run| Run {
            start: run.start.wrapping_add(place.shift),
            ..*run
        });
        Some(columns.push(std::iter::once(lit).chain(behind), bounds))
    }

    /// Keeps the last column of a stack.
    pub(crate) fn keep(&mut self, place: Place, columns: &Columns, column: Column) {
        if place.generation != self.generation {
            return;
        }
        let (runs, bounds) = (columns.runs(column), column.bounds());
        let start = self.runs.len();
        if let Some(runs) = runs {
            self.runs.extend(runs.iter().map(|run| Run {
                start: run.start.wrapping_sub(place.shift),
                ..*run
            }));
            self.entries += runs.len();
        }
        let by = (place.shift * (8 << place.level)).wrapping_neg();
        self.planes[place.plane].levels[place.level].kept[place.number] = Some(Kept {
            runs: runs.map(|_| (start, self.runs.len())),
            bounds: moved(bounds, by),
        });
    }
}
