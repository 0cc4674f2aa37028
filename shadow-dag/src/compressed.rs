//! Graphs as few bytes, for storing: they have to be decoded before use.
//!
//! Levels come from the coarsest to the finest, each in the order in which the
//! level above names its nodes first, and the masks after them. So a child that
//! was not named before needs no number, and no level a length. Everything is
//! coded bit by bit by the range coder, each with a model for its surroundings:
//!
//! * Of each child whether it is mixed, and if not, whether it is lit, given the
//!   same of those beside and in front of it within the node.
//! * Of a mixed one whether it is one of a few that are likely: those beside and
//!   in front of it, and those that were last seen beside and behind these.
//! * Whether it is new; if not, its number: how many bits that has, the first few
//!   of them, and the rest as they are.
//! * Of masks each voxel, given those around it that are known.
//!
//! Any bytes whatever decode to a graph, or to too many nodes for their number.
//!
//! Masks are coded like pictures of two levels in JBIG (ITU-T T.82).

use std::borrow::Cow;
use std::sync::Arc;

use crate::file::{check_sum, seal};
use crate::graph::Graph;
use crate::layout::{FORM, Head, form};
use crate::pool::{Children, LIT, Reference, SHADOWED, is_mixed};
use crate::range_coder::{Bit, Coder, Decoder, Encoder};
use crate::{FileError, Form, ShadowDag};

/// The axes along which a child has others beside or in front of it.
const AXES: usize = 3;
/// Likely references of a child: of each axis the one beside it, and what was
/// beside that one the last time.
const LIKELY: usize = 2 * AXES;
/// Bits behind the first one of a number that have models.
const MODELLED: u32 = 4;

/// Models of the children of the nodes of one level.
#[derive(Debug)]
struct Level {
    is_finest: bool,
    /// By child and the kinds of those around it.
    mixed: Vec<Bit>,
    lit: Vec<Bit>,
    /// By child and number of the likely one.
    likely: Vec<Bit>,
    /// By child and how many likely ones there were.
    new: Vec<Bit>,
    /// How many bits numbers have: a tree.
    lengths: Vec<Bit>,
    /// By length, a tree of the first bits.
    digits: Vec<Bit>,
    /// The last reference that was seen behind a reference along each axis.
    beside: Vec<[Reference; AXES]>,
    /// References that were named.
    named: u32,
}

/// Nothing was seen there.
const NONE: Reference = LIT;

fn kind(reference: Option<Reference>) -> usize {
    match reference {
        None => 0,
        Some(LIT) => 1,
        Some(SHADOWED) => 2,
        Some(_) => 3,
    }
}

impl Level {
    fn new(is_finest: bool) -> Self {
        let models = |count: usize| vec![Bit::default(); count];
        Self {
            is_finest,
            mixed: models(8 * 64),
            lit: models(8 * 64),
            likely: models(8 * LIKELY),
            new: models(8 * (LIKELY + 1)),
            lengths: models(64),
            digits: models(33 << MODELLED),
            beside: Vec::new(),
            named: 0,
        }
    }

    /// Where the child is that is next to child `at` along an axis, towards the
    /// first.
    fn neighbour(&self, at: usize, axis: usize) -> Option<usize> {
        if self.is_finest {
            // Slices: along the light, the one in front and the one before that.
            return at.checked_sub(axis + 1).filter(|_| axis < 2);
        }
        let bit = [4, 2, 1][axis];
        (at & bit != 0).then_some(at & !bit)
    }

    fn children<C: Coder>(&mut self, coder: &mut C, wanted: Children) -> Children {
        let mut children = [LIT; 8];
        for at in 0..8 {
            let child = self.child(coder, at, &children, wanted[at]);
            children[at] = child;
            if !is_mixed(child) {
                continue;
            }
            for axis in 0..AXES {
                let Some(neighbour) = self.neighbour(at, axis) else {
                    continue;
                };
                if let Some(beside) = self.beside.get_mut(children[neighbour] as usize) {
                    beside[axis] = child;
                }
            }
        }
        children
    }

    fn child<C: Coder>(
        &mut self,
        coder: &mut C,
        at: usize,
        children: &Children,
        wanted: Reference,
    ) -> Reference {
        let around: [Option<Reference>; AXES] =
            [0, 1, 2].map(|axis| self.neighbour(at, axis).map(|other| children[other]));
        let kinds = around
            .iter()
            .fold(at, |kinds, other| kinds << 2 | kind(*other));
        if !coder.bit(&mut self.mixed[kinds], is_mixed(wanted)) {
            let lit = coder.bit(&mut self.lit[kinds], wanted == LIT);
            return if lit { LIT } else { SHADOWED };
        }
        let mut tried = [NONE; LIKELY];
        let mut number = 0;
        for (i, axis) in (0..LIKELY).map(|i| (i, i % AXES)) {
            let Some(other) = around[axis].filter(|other| is_mixed(*other)) else {
                continue;
            };
            let likely = match i / AXES {
                0 => other,
                _ => self.beside[other as usize][axis],
            };
            if likely == NONE || tried[..number].contains(&likely) {
                continue;
            }
            tried[number] = likely;
            number += 1;
            if coder.bit(&mut self.likely[at * LIKELY + i], wanted == likely) {
                return likely;
            }
        }
        let named = self.named;
        let new = &mut self.new[at * (LIKELY + 1) + number];
        if named == 0 || coder.bit(new, wanted == named) {
            self.named += 1;
            self.beside.push([NONE; AXES]);
            return named;
        }
        self.number(coder, wanted)
    }

    /// A number that was named.
    fn number<C: Coder>(&mut self, coder: &mut C, wanted: Reference) -> Reference {
        // One more, so that there is a first bit.
        let plus = u64::from(wanted) + 1;
        let mut length = 1;
        for i in (0..5).rev() {
            let bit = (plus.ilog2() & 31) >> i & 1 == 1;
            length = length << 1 | usize::from(coder.bit(&mut self.lengths[length], bit));
        }
        let length = length as u32 - 32;
        let mut value = 1_u64;
        let mut digit = 1;
        for i in 0..length.min(MODELLED) {
            let bit = plus >> (length - 1 - i) & 1 == 1;
            let bit = coder.bit(&mut self.digits[(length as usize) << MODELLED | digit], bit);
            digit = digit << 1 | usize::from(bit);
            value = value << 1 | u64::from(bit);
        }
        let rest = length.saturating_sub(MODELLED);
        let low = coder.raw((plus & ((1 << rest) - 1)) as u32, rest);
        value = value << rest | u64::from(low);
        // References that were not named are in no file that was written here; here they become
        // named ones.
        (value - 1).min(u64::from(self.named) - 1) as Reference
    }
}

/// Models of masks.
#[derive(Debug)]
struct Masks {
    models: Vec<Bit>,
}

impl Masks {
    fn new() -> Self {
        Self {
            models: vec![Bit::default(); 1 << 14],
        }
    }

    fn mask<C: Coder>(&mut self, coder: &mut C, wanted: u64) -> u64 {
        let mut mask = 0_u64;
        for at in 0..64 {
            let (x, y) = (at & 7, at >> 3);
            // Beside the mask there is what is at its rim.
            let voxel = |dx: i32, dy: i32| {
                let (x, y) = (x + dx, y + dy);
                if y < 0 {
                    return 0;
                }
                let at = y << 3 | x.clamp(0, 7);
                (mask >> at & 1) as usize
            };
            let around = [
                voxel(-1, 0),
                voxel(-2, 0),
                voxel(-1, -1),
                voxel(0, -1),
                voxel(1, -1),
                voxel(2, -1),
                voxel(0, -2),
                voxel(1, -2),
            ];
            let around = around.iter().fold(0, |all, bit| all << 1 | bit);
            let model = &mut self.models[around << 6 | at as usize];
            let bit = coder.bit(model, wanted >> at & 1 == 1);
            mask |= u64::from(bit) << at;
        }
        mask
    }
}

/// Nodes and masks per byte at most, so that whoever decodes a file needs no more
/// memory than its length justifies. Files of scenes have about a third of one.
const MOST_PER_BYTE: usize = 2;

fn encode(graph: &Graph) -> Vec<u8> {
    let mut coder = Encoder::new();
    for (number, nodes) in graph.levels.iter().enumerate().rev() {
        let mut level = Level::new(number == 0);
        for children in nodes {
            level.children(&mut coder, *children);
        }
    }
    let mut masks = Masks::new();
    for &mask in &graph.masks {
        masks.mask(&mut coder, mask);
    }
    let mut bytes = coder.finish();
    let named = graph.levels.iter().map(Vec::len).sum::<usize>() + graph.masks.len();
    bytes.resize(bytes.len().max(named.div_ceil(MOST_PER_BYTE)), 0);
    bytes
}

/// The graph with this head; none if there are too many nodes, or other masks.
fn decode(head: &Head, bytes: &[u8]) -> Option<Graph> {
    let most = MOST_PER_BYTE * bytes.len();
    let mut coder = Decoder::new(bytes);
    let mut levels = vec![Vec::new(); head.resolution.root_level() + 1];
    let mut count = usize::from(is_mixed(head.root));
    let mut named = count;
    for (number, nodes) in levels.iter_mut().enumerate().rev() {
        let mut level = Level::new(number == 0);
        for _ in 0..count {
            nodes.push(level.children(&mut coder, [LIT; 8]));
            if named + level.named as usize > most {
                return None;
            }
        }
        count = level.named as usize;
        named += count;
    }
    let mut masks = Masks::new();
    (count == head.mask_count as usize).then(|| Graph {
        resolution: head.resolution,
        root: head.root,
        masks: (0..count).map(|_| masks.mask(&mut coder, 0)).collect(),
        levels,
    })
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// The same shadows as a compressed file: for closed scenes about half of the bytes of the
    /// packed form, to which [`ShadowDag::read`] turns it back. Writing takes about 9 times as
    /// long as reading the packed form itself, and reading about 15 times.
    pub fn compress(&self) -> Vec<u8> {
        let graph = self.graph();
        let head = Head {
            form: form::COMPRESSED,
            resolution: graph.resolution,
            root: graph.root,
            light: self.light().copied(),
            mask_count: graph.masks.len() as u32,
        };
        let mut bytes = head.write();
        bytes.extend(encode(&graph));
        seal(&mut bytes);
        bytes
    }
}

impl<'a> ShadowDag<Cow<'a, [u8]>> {
    /// The shadows of a file in any form: of a compressed one in memory of their
    /// own, in the packed form; of others in the bytes themselves, as
    /// [`ShadowDag::from_bytes`] has them.
    ///
    /// Decoding needs at most some 500 bytes of memory for each byte of the file, and
    /// for scenes about a tenth of that.
    ///
    /// ```
    /// # use gpu_backend::Cpu;
    /// # use shadow_dag::{Builder, DepthMap, Form, Resolution, ShadowDag, Slices};
    /// # let depths: Vec<f32> = (0..64 * 64).map(|i| (i % 61) as f32 / 61.0).collect();
    /// # let map = DepthMap::new(Resolution::new(64)?, Slices::Linear, &depths)?;
    /// # let shadows = Builder::new().build(&Cpu::new(), &map)?;
    /// let file = shadows.compress();
    /// let read = ShadowDag::read(&file)?;
    /// assert_eq!(read.as_bytes(), shadows.to_form(Form::Packed)?.as_bytes());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FileError`] if they are not a whole and consistent file.
    pub fn read(bytes: &'a [u8]) -> Result<Self, FileError> {
        let head = Head::read(bytes)?;
        if head.form != form::COMPRESSED {
            return Self::from_bytes(Cow::Borrowed(bytes));
        }
        check_sum(bytes)?;
        head.check_root(u32::from(is_mixed(head.root)))?;
        let graph = decode(&head, &bytes[FORM..]).ok_or(FileError::Code)?;
        let packed = ShadowDag::from_graph(&graph, head.light.as_ref(), Form::Packed)
            .map_err(|_| FileError::Code)?;
        let (layout, top) = (Arc::clone(&packed.layout), Arc::clone(&packed.top));
        Ok(Self::from_parts(
            Cow::Owned(packed.into_bytes()),
            layout,
            top,
        ))
    }
}
