//! Nodes of which no two are equal.

use crate::Error;
use crate::resolution::Resolution;

/// Names a node of the level below, or says that there is no need for one.
pub(crate) type Reference = u32;

/// A volume that is lit throughout.
pub(crate) const LIT: Reference = u32::MAX;
/// A volume that is shadowed throughout.
pub(crate) const SHADOWED: Reference = u32::MAX - 1;
/// The most entries of a level: what two reserved values leave.
const LIMIT: u32 = u32::MAX - 2;

/// True if the reference names a node.
pub(crate) fn is_mixed(reference: Reference) -> bool {
    reference < SHADOWED
}

/// The children of a node. On level 0 they are the eight slices of an 8×8×8
/// volume, near to far, and name masks; on coarser levels they are octants,
/// child `4 z + 2 y + x`, and name nodes of the level below.
pub(crate) type Children = [Reference; 8];

/// Something with a hash of 64 well mixed bits.
pub(crate) trait Key: Copy + Eq + Default {
    fn hash(&self) -> u64;
}

/// Two halves of a full product mix every bit of both factors.
pub(crate) fn fold(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    (product as u64) ^ ((product >> 64) as u64)
}

/// Odd words without structure: digits of π.
pub(crate) const SALT: [u64; 4] = [
    0x2437_06ab_6a88_85a3,
    0x1319_8a2e_0370_7345,
    0xa409_3822_299f_31d1,
    0x082e_fa98_ec4e_6c89,
];

impl Key for u64 {
    fn hash(&self) -> u64 {
        fold(*self ^ SALT[0], SALT[1])
    }
}

impl Key for Children {
    fn hash(&self) -> u64 {
        let pair = |i: usize| u64::from(self[2 * i]) | u64::from(self[2 * i + 1]) << 32;
        fold(
            fold(pair(0) ^ SALT[0], pair(1) ^ SALT[1]) ^ SALT[2],
            fold(pair(2) ^ SALT[3], pair(3) ^ SALT[1]) ^ SALT[0],
        )
    }
}

/// A set that numbers its members in the order in which they came.
///
/// Members are compared by content; the hash only says where to look.
#[derive(Debug, Clone)]
pub(crate) struct Table<T> {
    items: Vec<T>,
    /// Open addressing, a power of two of them, at most half full: number of
    /// the item plus 1 in the low half (0: free), high half of its hash in
    /// the high half.
    slots: Vec<u64>,
    overflow: bool,
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            slots: vec![0; 16],
            overflow: false,
        }
    }
}

impl<T: Key> Table<T> {
    pub(crate) fn items(&self) -> &[T] {
        &self.items
    }

    /// The number of `item`, which becomes a member if it was none.
    pub(crate) fn insert(&mut self, item: T) -> Reference {
        let hash = item.hash();
        let mask = self.slots.len() - 1;
        let mut at = hash as usize & mask;
        loop {
            let slot = self.slots[at];
            if slot == 0 {
                break;
            }
            if slot >> 32 == hash >> 32 {
                let number = slot as u32 - 1;
                if self.items[number as usize] == item {
                    return number;
                }
            }
            at = (at + 1) & mask;
        }
        let number = self.items.len() as u32;
        if number >= LIMIT {
            self.overflow = true;
            return 0;
        }
        self.items.push(item);
        self.slots[at] = (hash >> 32) << 32 | u64::from(number + 1);
        if self.items.len() * 2 > self.slots.len() {
            self.grow();
        }
        number
    }

    fn grow(&mut self) {
        let mask = self.slots.len() * 2 - 1;
        let mut slots = vec![0; mask + 1];
        for (number, item) in (1_u64..).zip(&self.items) {
            let hash = item.hash();
            let mut at = hash as usize & mask;
            while slots[at] != 0 {
                at = (at + 1) & mask;
            }
            slots[at] = (hash >> 32) << 32 | number;
        }
        self.slots = slots;
    }
}

/// The nodes of all levels and the masks that the finest ones name.
#[derive(Debug, Clone)]
pub(crate) struct Pool {
    pub(crate) masks: Table<u64>,
    /// From the finest level to the root.
    pub(crate) levels: Vec<Table<Children>>,
}

impl Pool {
    pub(crate) fn new(resolution: Resolution) -> Self {
        Self {
            masks: Table::default(),
            levels: vec![Table::default(); resolution.root_level() + 1],
        }
    }

    /// A reference to an 8×8 mask in which bit `8 y + x` is 1 if lit.
    pub(crate) fn mask(&mut self, mask: u64) -> Reference {
        match mask {
            u64::MAX => LIT,
            0 => SHADOWED,
            _ => self.masks.insert(mask),
        }
    }

    /// A reference to a node of `level` with these children.
    pub(crate) fn node(&mut self, level: usize, children: Children) -> Reference {
        let first = children[0];
        if !is_mixed(first) && children == [first; 8] {
            first
        } else {
            self.levels[level].insert(children)
        }
    }

    /// A reference to a node of `level` that is lit in front of `depth`, in
    /// voxels from the front of the node, and shadowed from there on.
    pub(crate) fn planar(&mut self, level: usize, depth: u32) -> Reference {
        let half = 4_u32 << level;
        if depth == 0 {
            return SHADOWED;
        }
        if depth >= 2 * half {
            return LIT;
        }
        if level == 0 {
            let slice = |z: u32| if z < depth { LIT } else { SHADOWED };
            return self.node(0, [0, 1, 2, 3, 4, 5, 6, 7].map(slice));
        }
        let (near, far) = if depth < half {
            (self.planar(level - 1, depth), SHADOWED)
        } else {
            (LIT, self.planar(level - 1, depth - half))
        };
        self.node(level, [near, near, near, near, far, far, far, far])
    }

    /// Takes over all that is in `other`. Returns, level by level, what the
    /// nodes of `other` are called here.
    pub(crate) fn absorb(&mut self, other: &Self) -> Vec<Vec<Reference>> {
        let masks: Vec<Reference> = (other.masks.items().iter())
            .map(|&mask| self.masks.insert(mask))
            .collect();
        let mut names: Vec<Vec<Reference>> = Vec::with_capacity(self.levels.len());
        for (ours, theirs) in self.levels.iter_mut().zip(&other.levels) {
            let below = names.last().unwrap_or(&masks);
            let rename = |child| {
                if is_mixed(child) {
                    below[child as usize]
                } else {
                    child
                }
            };
            let renamed = (theirs.items().iter())
                .map(|children| ours.insert(children.map(rename)))
                .collect();
            names.push(renamed);
        }
        names
    }

    /// A pool of what the nodes `roots` of `level` need, and what the nodes of that
    /// level are called there; any number for those that are not.
    pub(crate) fn pruned(
        &self,
        level: usize,
        roots: impl Iterator<Item = Reference>,
    ) -> (Self, Vec<Reference>) {
        let none_of = |level: &Table<Children>| vec![false; level.items().len()];
        let mut needed: Vec<Vec<bool>> = self.levels[..=level].iter().map(none_of).collect();
        let mut masks = vec![false; self.masks.items().len()];
        for root in roots {
            needed[level][root as usize] = true;
        }
        for at in (0..=level).rev() {
            let (below, own) = needed.split_at_mut(at);
            let below = below.last_mut().unwrap_or(&mut masks);
            let nodes = self.levels[at].items().iter().zip(&own[0]);
            for (children, _) in nodes.filter(|(_, needed)| **needed) {
                for &child in children.iter().filter(|child| is_mixed(**child)) {
                    below[child as usize] = true;
                }
            }
        }
        let mut pool = Self {
            masks: Table::default(),
            levels: vec![Table::default(); self.levels.len()],
        };
        let mut names: Vec<Reference> = (self.masks.items().iter().zip(masks))
            .map(|(&mask, needed)| if needed { pool.masks.insert(mask) } else { LIT })
            .collect();
        for (at, needed) in needed.into_iter().enumerate() {
            let rename = |child: Reference| match names.get(child as usize) {
                Some(&name) if is_mixed(child) => name,
                _ => child,
            };
            let nodes = self.levels[at].items().iter().zip(needed);
            names = nodes
                .map(|(children, needed)| {
                    if needed {
                        pool.levels[at].insert(children.map(rename))
                    } else {
                        LIT
                    }
                })
                .collect();
        }
        (pool, names)
    }

    /// How much is in it.
    pub(crate) fn len(&self) -> usize {
        let nodes = self.levels.iter().map(|level| level.items().len());
        self.masks.items().len() + nodes.sum::<usize>()
    }

    /// # Errors
    /// [`Error::TooManyNodes`] if a level ran out of numbers.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.masks.overflow || self.levels.iter().any(|level| level.overflow) {
            return Err(Error::TooManyNodes { limit: LIMIT });
        }
        Ok(())
    }
}
