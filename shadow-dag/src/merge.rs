//! Parts of a bake become the whole.

use std::collections::BTreeMap;
use std::sync::Mutex;

use gpu_backend::Cpu;

use crate::checkpoint::CheckpointError;
use crate::set::ShadowSet;
use crate::set_checkpoint::{State, Task};
use crate::share::Share;
use crate::tiles::lock;
use crate::{Error, Form};

/// Why parts of a bake do not make a whole. Parts are told by where they stand among
/// those that were given, from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// There are none.
    #[error("no parts, expected at least one")]
    Empty,
    /// One is no part, or is damaged.
    #[error("part {given}: {error}")]
    Part {
        /// Which one.
        given: usize,
        /// What is wrong with it.
        error: CheckpointError,
    },
    /// One is of another bake than the first, or of a bake in another number of parts.
    #[error(
        "part {given} is of another bake than the first part given: part {found} of {identity:#018x}, expected one of {parts} of {expected:#018x}"
    )]
    Foreign {
        /// Which one.
        given: usize,
        /// The part that it is.
        found: Share,
        /// The bake that it is of.
        identity: u64,
        /// The number of parts of the first.
        parts: u32,
        /// The bake that the first is of.
        expected: u64,
    },
    /// Two are the same part.
    #[error("parts {first} and {second} are both part {share}")]
    Doubled {
        /// One of them.
        first: usize,
        /// The other.
        second: usize,
        /// The share that both are.
        share: Share,
    },
    /// Some are not there.
    #[error("{missing} of {parts} parts missing: {}", list(first, *missing))]
    Missing {
        /// How many.
        missing: u32,
        /// The first few of them, by their numbers, from 1.
        first: Vec<u32>,
        /// How many parts there are.
        parts: u32,
    },
    /// One was stopped before its last tile.
    #[error("part {share} is not finished: {finished} of {tiles} tiles; resume it first")]
    Unfinished {
        /// Which part of the bake.
        share: Share,
        /// Tiles that are finished.
        finished: usize,
        /// Tiles of this part.
        tiles: usize,
    },
    /// The whole could not be put together.
    #[error(transparent)]
    Build(#[from] Error),
}

/// Missing parts that are told by their numbers.
const TOLD: usize = 12;

/// The first of `all` numbers.
fn list(first: &[u32], all: u32) -> String {
    let mut words: Vec<String> = first.iter().map(u32::to_string).collect();
    if words.len() < all as usize {
        words.push("…".into());
    }
    words.join(", ")
}

impl ShadowSet {
    /// Joins all parts of a bake, in any order: what [`SetBake::save`](crate::SetBake::save)
    /// wrote of the complete bake of each [`Share`]. The set has the same bytes as that of
    /// one bake, with its grids in the given form.
    ///
    /// # Errors
    /// [`MergeError`] if parts are damaged, missing, unfinished, doubled or of different
    /// bakes.
    pub fn merge<P: AsRef<[u8]> + Sync>(
        cpu: &Cpu,
        parts: &[P],
        form: Form,
    ) -> Result<Self, MergeError> {
        let read = cpu.map(parts.len(), |given| {
            Task::load(parts[given].as_ref()).map_err(|error| MergeError::Part { given, error })
        });
        let read = read.into_iter().collect::<Result<Vec<_>, _>>()?;
        let (task, _) = read.first().ok_or(MergeError::Empty)?;
        let task = task.clone();
        let (expected, count) = (task.identity().value(), task.share.parts());
        let mut places = BTreeMap::new();
        for (given, (other, states)) in read.iter().enumerate() {
            let (share, identity) = (other.share, other.identity().value());
            if identity != expected || share.parts() != count {
                return Err(MergeError::Foreign {
                    given,
                    found: share,
                    identity,
                    parts: count,
                    expected,
                });
            }
            if let Some(first) = places.insert(share.part(), given) {
                return Err(MergeError::Doubled {
                    first,
                    second: given,
                    share,
                });
            }
            let (mut finished, mut tiles) = (0, 0);
            for (own, state) in other.shares().into_iter().zip(states) {
                tiles += own.len();
                finished += match state {
                    State::Waiting => 0,
                    State::Tiles(made) => made.progress().finished,
                    State::Finished(_) => own.len(),
                };
            }
            if finished < tiles {
                return Err(MergeError::Unfinished {
                    share,
                    finished,
                    tiles,
                });
            }
        }
        let missing = count - places.len() as u32;
        if missing > 0 {
            let is_missing = |part: &u32| !places.contains_key(part);
            return Err(MergeError::Missing {
                missing,
                first: (1..=count).filter(is_missing).take(TOLD).collect(),
                parts: count,
            });
        }
        let spaces: Vec<_> = task.grids().map(|(space, _)| space).collect();
        let mut states: Vec<Vec<State>> = spaces.iter().map(|_| Vec::new()).collect();
        for (_, part) in read {
            for (states, state) in states.iter_mut().zip(part) {
                states.push(state);
            }
        }
        let states: Vec<_> = states.into_iter().map(Mutex::new).collect();
        let dags = cpu.map(spaces.len(), |grid| {
            let states = std::mem::take(&mut *lock(&states[grid]));
            joined(states).into_grid(&spaces[grid], form)
        });
        let mut grids = Vec::with_capacity(dags.len());
        for dag in dags {
            // All parts are there and finished, so all tiles are.
            grids.push(dag?.ok_or(MergeError::Empty)?);
        }
        Ok(Self::of_lights(&task.lights, grids))
    }
}

/// The state of a grid after the parts are put together.
fn joined(states: Vec<State>) -> State {
    let mut whole = State::Waiting;
    for state in states {
        whole = match (whole, state) {
            (whole, State::Waiting) => whole,
            (State::Finished(grid), _) => State::Finished(grid),
            (State::Tiles(mut tiles), State::Tiles(others)) => {
                tiles.take_over(others);
                State::Tiles(tiles)
            }
            (_, state) => state,
        };
    }
    whole
}
