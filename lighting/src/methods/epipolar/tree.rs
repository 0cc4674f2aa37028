//! Min–max trees of epipolar lines: building and searching.

use gpu_backend::{Backend, BufferOf, Cpu, Error, Host};

use super::blocks::{BLOCK, MapBlocks};
use super::fan::{Fan, Fans, LEAF};
use super::walk::Walk;
use crate::shadow_map::EMPTY;
use crate::shadow_map::line::{Line, Part, Runs, Verdict};

/// The smallest and the largest depth of the texels that the lines of a slice meet in some
/// cells.
pub type Node = [f32; 2];

/// No texels.
pub(super) const NONE: Node = [EMPTY, 0.0];

/// How much wider than its lines a slice is, in texels, to allow for rounding in lookups.
const MARGIN: f64 = 0.0625;

pub(super) fn joined(a: Node, b: Node) -> Node {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// A backend that makes min–max trees of epipolar lines.
pub trait BuildLineTrees: Backend {
    /// The trees of all lines of `fans`, one after the other. They store the smallest and the
    /// largest depth of each part and are made from the blocks of the map.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    fn line_trees(
        &self,
        blocks: &MapBlocks<Self::Memory>,
        fans: &Fans,
    ) -> Result<BufferOf<Self, Node>, Error>;
}

impl BuildLineTrees for Cpu {
    fn line_trees(&self, blocks: &MapBlocks<Host>, fans: &Fans) -> Result<Vec<Node>, Error> {
        let mut nodes = self.zeros::<Node>(fans.nodes)?;
        let mut rest = nodes.as_mut_slice();
        for (index, fan) in fans.fans.iter().enumerate() {
            let Some(fan) = fan else { continue };
            let per_slice = fan.nodes_per_slice() as usize;
            let own = rest.split_off_mut(..per_slice * fan.slices as usize);
            self.for_each_chunk(own.unwrap_or_default(), per_slice, |first, tree| {
                fill(
                    tree,
                    fan,
                    (first / per_slice) as u32,
                    |block, [low, high]| blocks.bounds(index, block, low, high),
                    fans.resolution,
                );
            });
        }
        Ok(nodes)
    }
}

/// Fills the tree of a slice. `bounds` gives those of a block between two texels across.
fn fill(
    tree: &mut [Node],
    fan: &Fan,
    slice: u32,
    bounds: impl Fn(u32, [usize; 2]) -> Node,
    resolution: u32,
) {
    let leaves = 1_usize << fan.height;
    let last = f64::from(resolution - 1);
    let [one, two] = fan.lines(slice, resolution);
    // The texels between which the slice crosses the border in front of a cell.
    let crossed = |border: i64| {
        let x = fan.border(border, resolution);
        let (a, b) = (one[0] + one[1] * x, two[0] + two[1] * x);
        (a.min(b), a.max(b))
    };
    tree[leaves..].fill(NONE);
    for (leaf, node) in (0..).zip(&mut tree[leaves..]) {
        let Some([first, last_cell]) = fan.cells_of_leaf(leaf, resolution) else {
            break;
        };
        let (near, far) = (crossed(first), crossed(last_cell + 1));
        let low = (near.0.min(far.0) - MARGIN).clamp(0.0, last) as usize;
        let high = (near.1.max(far.1) + MARGIN).clamp(0.0, last) as usize;
        for block in first >> BLOCK..=last_cell >> BLOCK {
            *node = joined(*node, bounds(block as u32, [low, high]));
        }
    }
    for index in (1..leaves).rev() {
        tree[index] = joined(tree[2 * index], tree[2 * index + 1]);
    }
}

/// Counts what a search visits.
pub(super) trait Tally {
    /// A node was visited.
    fn node(&mut self) {}
    /// So many texels were visited.
    fn texels(&mut self, _count: u32) {}
}

/// Counts nothing.
impl Tally for () {}

/// Adds the lit parts of a walk, found with the tree of its slice.
#[inline]
pub(super) fn search<F: FnMut(Part)>(
    line: &Line,
    walk: &Walk,
    (fan, tree, resolution): (&Fan, &[Node], u32),
    texels: &[f32],
    runs: &mut Runs<F>,
    tally: &mut impl Tally,
) {
    let number = |cell: i64| fan.seen_from_side(cell, resolution) - i64::from(fan.first_cell);
    let cell_of = |number: i64| fan.seen_from_side(number + i64::from(fan.first_cell), resolution);
    let [first, last] = walk.cells().map(number);
    let is_rising = first <= last;
    let step = if is_rising { 1 } else { -1 };
    let leaves = 1_i64 << fan.height;
    let mut at = first;
    // The smallest node that contains the whole walk.
    let mut level = i64::BITS - ((first ^ last) >> LEAF).leading_zeros();
    let mut start = walk.start();
    loop {
        let index = at >> LEAF >> level;
        let end_number = match is_rising {
            true => (((index + 1) << level << LEAF) - 1).min(last),
            false => (index << level << LEAF).max(last),
        };
        let end = walk.exit(cell_of(end_number)).max(start);
        tally.node();
        let node = tree[((leaves >> level) + index) as usize];
        match line.verdict(node, start, end) {
            Verdict::Lit => runs.push([start, end]),
            Verdict::Dark => {}
            Verdict::Unknown if level > 0 => {
                level -= 1;
                continue;
            }
            Verdict::Unknown => {
                let cells = [at, end_number].map(cell_of);
                tally.texels(walk.add_cells(texels, cells, start, runs));
            }
        }
        if end_number == last {
            return;
        }
        at = end_number + step;
        start = end;
        // The largest node that begins here is inside of one that is known to be mixed.
        let leaf = at >> LEAF;
        level = match is_rising {
            true => leaf.trailing_zeros(),
            false => (leaf + 1).trailing_zeros(),
        }
        .min(fan.height);
    }
}
