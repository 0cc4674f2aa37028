//! Columns of nodes over one footprint, and how four become one.
//!
//! A column lists what lies along the light over a square footprint as runs of
//! equal references. The column of a footprint follows from those of its four
//! quarters by walking the places where any of them changes.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction
//! of Voxelized Shadows, I3D 2015, sections 3.2 and 3.4.
//!
//! The paper walks volumes top-down, near to far, and remembers per footprint
//! the last node and the depth up to which it can be reused. Here the depth is
//! innermost: the nodes that the paper reuses are one run, which is stepped
//! over as a whole, at every level. The nodes that come out are the same (a
//! test compares the two), but nothing has to be remembered across the map and
//! reuse needs no rule of its own that could go wrong.

use crate::interval::Interval;
use crate::pool::{LIT, Pool, Reference, SHADOWED, is_mixed};
use crate::resolution::Resolution;
use crate::rule::{Rule, Tile, Transition};

/// The volumes of a column from `start` up to the next run are all `node`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) start: u32,
    pub(crate) node: Reference,
}

/// Stands behind the last run of every column.
const END: Run = Run {
    start: u32::MAX,
    node: LIT,
};

/// The casters along the light over one footprint.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Column {
    /// All texels can turn at any one depth of this interval, which is not chosen yet: a larger
    /// footprint may have a better one in common with its neighbours.
    Uniform(Interval),
    /// Runs on the stack of the [`Columns`] that made them, the first of them
    /// here.
    Runs {
        first: usize,
        /// The largest enter and the smallest exit of the footprint.
        bounds: Interval,
    },
}

/// Makes columns. Those that are not merged yet lie on a stack, the last four of which become
/// one when a footprint is complete, so that no column has memory of its own.
#[derive(Debug)]
pub(crate) struct Columns {
    side: u32,
    rule: Rule,
    culling: bool,
    stack: Vec<Run>,
    merged: Vec<Run>,
    transitions: Vec<Transition>,
}

impl Columns {
    pub(crate) fn new(resolution: Resolution, rule: Rule, culling: bool) -> Self {
        Self {
            side: resolution.side(),
            rule,
            culling,
            stack: Vec::new(),
            merged: Vec::new(),
            transitions: Vec::new(),
        }
    }

    /// Where the next column will lie on the stack.
    pub(crate) fn top(&self) -> usize {
        self.stack.len()
    }

    /// Puts the runs of a column, but for the end, on the stack.
    pub(crate) fn push(&mut self, runs: impl IntoIterator<Item = Run>, bounds: Interval) -> Column {
        let first = self.top();
        self.stack.extend(runs);
        self.stack.push(END);
        Column::Runs { first, bounds }
    }

    /// The runs of the last column without its first and without the end; `None` if
    /// it is uniform.
    pub(crate) fn runs(&self, column: Column) -> Option<&[Run]> {
        match column {
            Column::Uniform(_) => None,
            Column::Runs { first, .. } => Some(&self.stack[first + 1..self.stack.len() - 1]),
        }
    }

    /// Takes the runs of the last column off the stack.
    pub(crate) fn pop(&mut self, first: usize) -> Vec<Run> {
        let mut runs = self.stack.split_off(first);
        runs.pop();
        runs
    }

    /// The column of slice nodes over an 8×8 tile.
    pub(crate) fn tile(&mut self, tile: &Tile, pool: &mut Pool) -> Column {
        let bounds = tile.meet();
        if self.rule == Rule::Aligned && !bounds.is_empty() {
            return Column::Uniform(bounds);
        }
        let mut transitions = std::mem::take(&mut self.transitions);
        tile.transitions(self.rule, self.side, &mut transitions);
        transitions.push(Transition {
            start: u32::MAX,
            mask: 0,
        });
        let first = self.top();
        let span = self.span(bounds, 0);
        self.merged.clear();
        let (mut mask, mut next) = (LIT, 0);
        self.walk(span, |volume| {
            let mut slices = [mask; 8];
            let mut change = u32::MAX;
            while transitions[next].start < 8 * volume + 8 {
                let Transition { start, mask: lit } = transitions[next];
                mask = pool.mask(lit);
                // A change in the volume's first slice concerns the whole volume. One behind it
                // makes the next volume differ from this one.
                if start > 8 * volume {
                    change = volume;
                }
                slices[start.saturating_sub(8 * volume) as usize..].fill(mask);
                next += 1;
            }
            (
                pool.node(0, slices),
                change.min(transitions[next].start / 8),
            )
        });
        self.transitions = transitions;
        self.replace(first, bounds)
    }

    /// The column of slice nodes over a tile whose texels can turn together,
    /// by the rules of the papers: as late as they can, but volumes that can
    /// be lit or shadowed throughout are.
    pub(crate) fn flat(&mut self, bounds: Interval, pool: &mut Pool) -> Column {
        let first = self.top();
        let Span { lit, shadowed, end } = self.span(bounds, 0);
        let mut put = |start, node| self.stack.push(Run { start, node });
        if lit > 0 {
            put(0, LIT);
        }
        if lit < shadowed {
            put(lit, pool.planar(0, bounds.exit % 8));
        }
        if shadowed < end {
            put(shadowed, SHADOWED);
        }
        self.stack.push(END);
        Column::Runs { first, bounds }
    }

    /// The column of nodes of `level` over a footprint, from the columns of its `quarters`
    /// `2 y + x` on the level below. These lie on the stack from `first` on and are replaced.
    pub(crate) fn merge(
        &mut self,
        level: usize,
        quarters: [Column; 4],
        first: usize,
        pool: &mut Pool,
    ) -> Column {
        let bounds = (quarters.iter())
            .map(|column| column.bounds())
            .fold(quarters[0].bounds(), Interval::meet);
        let uniform = |column: &Column| matches!(column, Column::Uniform(_));
        if quarters.iter().all(uniform) && !bounds.is_empty() {
            return Column::Uniform(bounds);
        }
        let mut at = quarters.map(|column| self.expand(level - 1, column, pool));
        let stack = std::mem::take(&mut self.stack);
        let span = self.span(bounds, level);
        self.merged.clear();
        self.walk(span, |volume| {
            let mut children = [LIT; 8];
            let mut change = u32::MAX;
            // Volume v is made of volumes 2 v (in front) and 2 v + 1 (behind) of the level below.
            for (quarter, at) in at.iter_mut().enumerate() {
                while stack[*at + 1].start <= 2 * volume {
                    *at += 1;
                }
                let near = stack[*at];
                let next = stack[*at + 1];
                let far = if next.start == 2 * volume + 1 {
                    next
                } else {
                    near
                };
                children[quarter] = near.node;
                children[4 + quarter] = far.node;
                change = change.min(next.start);
            }
            (pool.node(level, children), change / 2)
        });
        self.stack = stack;
        self.replace(first, bounds)
    }

    /// Puts a column on the stack as runs, if it is not there yet; says
    /// where.
    pub(crate) fn expand(&mut self, level: usize, column: Column, pool: &mut Pool) -> usize {
        let interval = match column {
            Column::Runs { first, .. } => return first,
            Column::Uniform(interval) => interval,
        };
        let first = self.top();
        let depth = interval.most_aligned(self.side);
        let (volume, within) = (depth >> (3 + level), depth & ((8 << level) - 1));
        let mut put = |start, node| self.stack.push(Run { start, node });
        if volume > 0 {
            put(0, LIT);
        }
        if within > 0 {
            put(volume, pool.planar(level, within));
        }
        if depth < self.side {
            put(volume + u32::from(within > 0), SHADOWED);
        }
        self.stack.push(END);
        first
    }

    /// The volumes of `level` that have to be made: behind those that all texels of the
    /// footprint allow to be lit, and in front of those that they allow to be shadowed. The
    /// rule [`Rule::Aligned`] makes those in front, too, because they are lit only up to the
    /// depth that it chooses.
    fn span(&self, bounds: Interval, level: usize) -> Span {
        let end = self.side >> (3 + level);
        let unit = 8 << level;
        let lit = match self.rule {
            Rule::Sintorn2014 | Rule::Kampe2015 => (bounds.exit / unit).min(end),
            Rule::Aligned => 0,
        };
        let shadowed = bounds.enter.div_ceil(unit).clamp(lit, end);
        Span { lit, shadowed, end }
    }

    /// Appends a column to `merged`. `step` gives the node of a volume, and the volume with the
    /// next change behind this one's first slice, up to which the node can be repeated; if it is
    /// this volume itself, the next one may differ.
    fn walk(&mut self, span: Span, mut step: impl FnMut(u32) -> (Reference, u32)) {
        let mut last = None;
        let mut put = |start, node| {
            if last != Some(node) {
                self.merged.push(Run { start, node });
            }
            last = Some(node);
        };
        if span.lit > 0 {
            put(0, LIT);
        }
        let mut volume = span.lit;
        // The volume up to which the last node holds.
        let mut valid = volume;
        while volume < span.shadowed {
            let (node, change) = step(volume);
            put(volume, node);
            valid = change.max(volume + 1);
            volume = if self.culling || !is_mixed(node) {
                valid
            } else {
                volume + 1
            };
        }
        let shadowed = match self.rule {
            Rule::Aligned => valid.max(span.shadowed),
            Rule::Sintorn2014 | Rule::Kampe2015 => span.shadowed,
        };
        if shadowed < span.end {
            put(shadowed, SHADOWED);
        }
    }

    /// Moves what is in `merged` onto the stack, in place of all from `first`.
    fn replace(&mut self, first: usize, bounds: Interval) -> Column {
        self.stack.truncate(first);
        self.stack.append(&mut self.merged);
        self.stack.push(END);
        Column::Runs { first, bounds }
    }
}

impl Column {
    pub(crate) fn bounds(self) -> Interval {
        match self {
            Self::Uniform(bounds) | Self::Runs { bounds, .. } => bounds,
        }
    }
}

/// The volumes of a column: those in front of `lit` are lit, those from `shadowed` to `end` can
/// be shadowed, and those between are made one by one.
#[derive(Debug, Clone, Copy)]
struct Span {
    lit: u32,
    shadowed: u32,
    end: u32,
}
