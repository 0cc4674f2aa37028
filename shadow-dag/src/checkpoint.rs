//! Unfinished bakes as bytes.
//!
//! Little-endian: magic, version, level of the tiles, identity of the bake,
//! number of tiles and of pools; the tiles, row by row; the pools; a checksum
//! of all that.

use std::io::{self, Write};

use crate::column::Run;
use crate::file_error::FileError;
use crate::identity::Identity;
use crate::interval::Interval;
use crate::pool::{Pool, is_mixed};
use crate::share::Share;
use crate::tiles::{Finished, Plan, Tiles};

const MAGIC: [u8; 8] = *b"CPVSPART";
const VERSION: u32 = 1;

/// Why bytes are no checkpoint of a bake.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// They do not begin like one.
    #[error("not a checkpoint of a bake: it does not begin with {MAGIC:?}")]
    Magic,
    /// Another version wrote them.
    #[error("version {0} of the format of checkpoints, expected {VERSION}")]
    Version(u32),
    /// They belong to another bake.
    #[error(
        "the checkpoint is of another bake: {found:#018x}, expected {expected:#018x} from casters, light, resolution, rule and version"
    )]
    Foreign {
        /// The bake that they are of.
        found: u64,
        /// The one to be resumed.
        expected: u64,
    },
    /// They are another part of the bake.
    #[error("the checkpoint is of part {found}, expected {expected}")]
    OtherPart {
        /// The part that they are of.
        found: Share,
        /// The one to be resumed.
        expected: Share,
    },
    /// A finished grid is of another bake.
    #[error("the checkpoint is of another bake: grid {grid} is of another light or resolution")]
    OtherGrid {
        /// Which one, from 0.
        grid: usize,
    },
    /// A finished grid is not sound.
    #[error("grid {grid} of the checkpoint: {error}")]
    Grid {
        /// Which one, from 0.
        grid: usize,
        /// What is wrong with it.
        error: FileError,
    },
    /// They were cut off or changed.
    #[error("the checkpoint is damaged: {what}")]
    Damaged {
        /// What gave it away.
        what: &'static str,
    },
}

pub(crate) fn damaged(what: &'static str) -> CheckpointError {
    CheckpointError::Damaged { what }
}

/// True if bytes begin like a checkpoint of one grid.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// The first word of a tile.
mod kind {
    pub(super) const MISSING: u32 = 0;
    pub(super) const UNIFORM: u32 = 1;
    pub(super) const RUNS: u32 = 2;
}

/// Passes bytes on and sums them.
struct Summed<W> {
    out: W,
    sum: crc32fast::Hasher,
}

impl<W: Write> Summed<W> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sum.update(bytes);
        self.out.write_all(bytes)
    }

    fn words(&mut self, words: &[u32]) -> io::Result<()> {
        words
            .iter()
            .try_for_each(|word| self.put(&word.to_le_bytes()))
    }
}

pub(crate) fn save(tiles: &Tiles, identity: Identity, out: impl Write) -> io::Result<()> {
    let mut out = Summed {
        out: io::BufWriter::new(out),
        sum: crc32fast::Hasher::new(),
    };
    out.put(&MAGIC)?;
    out.words(&[VERSION, tiles.plan.level as u32])?;
    for word in [
        identity.value(),
        tiles.columns.len() as u64,
        tiles.pools.len() as u64,
    ] {
        out.put(&word.to_le_bytes())?;
    }
    for column in &tiles.columns {
        match column {
            None => out.words(&[kind::MISSING])?,
            Some(Finished::Uniform(interval)) => {
                out.words(&[kind::UNIFORM, interval.enter, interval.exit])?;
            }
            Some(Finished::Runs { pool, runs, bounds }) => {
                let count = runs.len() as u32;
                out.words(&[kind::RUNS, bounds.enter, bounds.exit, *pool as u32, count])?;
                for run in runs {
                    out.words(&[run.start, run.node])?;
                }
            }
        }
    }
    for pool in &tiles.pools {
        let masks = pool.masks.items();
        out.words(&[masks.len() as u32])?;
        for mask in masks {
            out.put(&mask.to_le_bytes())?;
        }
        for level in &pool.levels {
            out.words(&[level.items().len() as u32])?;
            for children in level.items() {
                out.words(children)?;
            }
        }
    }
    let sum = out.sum.finalize();
    out.out.write_all(&sum.to_le_bytes())?;
    out.out.flush()
}

/// Takes bytes from the front.
pub(crate) struct Bytes<'a>(pub(crate) &'a [u8]);

impl Bytes<'_> {
    pub(crate) fn take<const N: usize>(&mut self) -> Result<[u8; N], CheckpointError> {
        let (first, rest) = self.0.split_first_chunk().ok_or(damaged("it is cut off"))?;
        self.0 = rest;
        Ok(*first)
    }

    pub(crate) fn word(&mut self) -> Result<u32, CheckpointError> {
        self.take().map(u32::from_le_bytes)
    }

    pub(crate) fn long(&mut self) -> Result<u64, CheckpointError> {
        self.take().map(u64::from_le_bytes)
    }

    /// A number of things of `size` bytes that are all still to come.
    pub(crate) fn count(&self, count: u64, size: u64) -> Result<usize, CheckpointError> {
        if count.saturating_mul(size) <= self.0.len() as u64 {
            Ok(count as usize)
        } else {
            Err(damaged("it is cut off"))
        }
    }
}

pub(crate) fn load(
    plan: Plan,
    identity: Identity,
    checkpoint: &[u8],
) -> Result<Tiles, CheckpointError> {
    let mut bytes = Bytes(checkpoint);
    if checkpoint.get(..8) != Some(&MAGIC) {
        return Err(CheckpointError::Magic);
    }
    bytes.long()?;
    let version = bytes.word()?;
    if version != VERSION {
        return Err(CheckpointError::Version(version));
    }
    let Some((content, sum)) = checkpoint.split_last_chunk() else {
        return Err(damaged("it is cut off"));
    };
    if crc32fast::hash(content) != u32::from_le_bytes(*sum) {
        return Err(damaged("its checksum is another"));
    }
    let level = bytes.word()?;
    let found = bytes.long()?;
    if found != identity.value() {
        return Err(CheckpointError::Foreign {
            found,
            expected: identity.value(),
        });
    }
    let columns = bytes.long()?;
    if columns != plan.tiles() as u64 || u64::from(level) != plan.level as u64 {
        return Err(damaged("it has another number of tiles"));
    }
    bytes.count(columns, 4)?;
    let mut tiles = Tiles::new(plan);
    // A pool takes at least the words that say how much is in it.
    let pools = bytes.long()?;
    let pools = bytes.count(pools, 4 * (plan.resolution.root_level() as u64 + 2))?;
    for column in &mut tiles.columns {
        *column = read_tile(&mut bytes, plan, pools)?;
    }
    for _ in 0..pools {
        tiles.pools.push(read_pool(&mut bytes, plan)?);
    }
    if bytes.0.len() != 4 {
        return Err(damaged("it goes on behind its end"));
    }
    for column in tiles.columns.iter().flatten() {
        let Finished::Runs { pool, runs, .. } = column else {
            continue;
        };
        let nodes = tiles.pools[*pool].levels[plan.level].items().len();
        let mut mixed = runs.iter().filter(|run| is_mixed(run.node));
        if mixed.any(|run| run.node as usize >= nodes) {
            return Err(damaged("a tile names a node that is not there"));
        }
    }
    Ok(tiles)
}

fn read_tile(
    bytes: &mut Bytes<'_>,
    plan: Plan,
    pools: usize,
) -> Result<Option<Finished>, CheckpointError> {
    let kind = bytes.word()?;
    if kind == kind::MISSING {
        return Ok(None);
    }
    let bounds = Interval {
        enter: bytes.word()?,
        exit: bytes.word()?,
    };
    let side = plan.resolution.side();
    if kind == kind::UNIFORM {
        if bounds.is_empty() || bounds.enter > side {
            return Err(damaged("a tile has no depth"));
        }
        return Ok(Some(Finished::Uniform(bounds)));
    }
    let pool = bytes.word()? as usize;
    let count = bytes.word()?;
    let count = bytes.count(u64::from(count), 8)?;
    if kind != kind::RUNS || pool >= pools || count == 0 {
        return Err(damaged("a tile of an unknown kind"));
    }
    let mut runs = Vec::with_capacity(count);
    for _ in 0..count {
        runs.push(Run {
            start: bytes.word()?,
            node: bytes.word()?,
        });
    }
    let volumes = side >> (3 + plan.level);
    let rise = runs.windows(2).all(|pair| pair[0].start < pair[1].start);
    if !rise || runs[0].start != 0 || runs[count - 1].start >= volumes {
        return Err(damaged("the runs of a tile are out of order"));
    }
    Ok(Some(Finished::Runs { pool, runs, bounds }))
}

fn read_pool(bytes: &mut Bytes<'_>, plan: Plan) -> Result<Pool, CheckpointError> {
    let mut pool = Pool::new(plan.resolution);
    let masks = bytes.word()?;
    // Numbers are given in order, so a member that gets another one is one
    // that cannot be, or is there twice.
    for number in 0..masks {
        if pool.mask(bytes.long()?) != number {
            return Err(damaged("a mask is there twice"));
        }
    }
    let mut below = masks;
    for level in 0..pool.levels.len() {
        let nodes = bytes.word()?;
        for number in 0..nodes {
            let mut children = [0; 8];
            for child in &mut children {
                *child = bytes.word()?;
                if is_mixed(*child) && *child >= below {
                    return Err(damaged("a node names one that is not there"));
                }
            }
            if pool.node(level, children) != number {
                return Err(damaged("a node is there twice"));
            }
        }
        below = nodes;
    }
    Ok(pool)
}
