//! Unfinished sets, and parts of sets, as bytes.
//!
//! All numbers are little-endian.
//!
//! ```text
//!   0  magic "CPVSWORK"
//!   8  version (u32), CRC-32 of the rest of the head (u32)
//!  16  identity of the surfaces (u64), and of the bake by this version of the crate (u64)
//!  32  part, number of parts (u32 each)
//!  40  rule, lights (u32 each)
//!   …  of each light: grids, log2 of the resolution (u32 each), bias (f32)
//!   …  of each grid: its space (slices u32, near and far f64, matrix 16 f64), what
//!      there is of it (u32), and how many bytes that takes (u64)
//!   …  what there is of the grids
//! ```
//!
//! Of a grid there is nothing, or its finished file, or what [`checkpoint`] writes.
//! The last two bring checks of their own.

use std::io::{self, Write};
use std::ops::Range;

use glam::DMat4;

use crate::bake::of_rule;
use crate::checkpoint::{self, Bytes, CheckpointError, damaged};
use crate::identity::Identity;
use crate::set_bake::LightGrids;
use crate::share::Share;
use crate::tiles::{Plan, Tiles};
use crate::{Builder, Error, Form, LightSpace, Resolution, Rule, ShadowDag, Slices};

const MAGIC: [u8; 8] = *b"CPVSWORK";
/// What an earlier form began with, which had no version.
const EARLIER: [u8; 8] = *b"CPVSGRID";
const VERSION: u32 = 2;
/// Where the part of the head begins that its checksum covers.
const CHECKED: usize = 16;
/// Bytes that a light and a grid take in the head.
const LIGHT: u64 = 12;
const GRID: u64 = 160;

/// True if bytes begin like an unfinished set.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC) || bytes.starts_with(&EARLIER)
}

/// Everything that a bake depends on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Task {
    pub(crate) rule: Rule,
    pub(crate) surfaces: Identity,
    pub(crate) lights: Vec<LightGrids>,
    pub(crate) share: Share,
}

/// The progress of a grid.
#[derive(Debug)]
pub(crate) enum State {
    /// Nothing.
    Waiting,
    /// Tiles, some of them finished.
    Tiles(Tiles),
    /// The grid itself.
    Finished(ShadowDag),
}

impl State {
    /// The grid, if all that it takes is there.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`].
    pub(crate) fn into_grid(
        self,
        space: &LightSpace,
        form: Form,
    ) -> Result<Option<ShadowDag>, Error> {
        match self {
            Self::Finished(dag) if dag.form() == form => Ok(Some(dag)),
            Self::Finished(dag) => dag.to_form(form).map(Some),
            Self::Tiles(tiles) if tiles.columns.iter().all(Option::is_some) => {
                ShadowDag::from_graph(&tiles.graph()?, Some(space), form).map(Some)
            }
            Self::Tiles(_) | Self::Waiting => Ok(None),
        }
    }
}

impl Task {
    /// The grids of all lights: where each is, and how it is made.
    pub(crate) fn grids(&self) -> impl Iterator<Item = (LightSpace, Plan)> {
        let builder = Builder::new().rule(self.rule);
        self.lights.iter().flat_map(move |light| {
            let plan = builder.plan_of_mesh(light.resolution);
            light.spaces.iter().map(move |space| (*space, plan))
        })
    }

    /// Which tiles of each grid its share holds.
    pub(crate) fn shares(&self) -> Vec<Range<usize>> {
        let share = self
            .share
            .of(self.grids().map(|(_, plan)| plan.tiles()).sum());
        let mut first = 0;
        let own = |(_, plan): (LightSpace, Plan)| {
            let end = first + plan.tiles();
            let within = |tile: usize| tile.clamp(first, end) - first;
            let own = within(share.start)..within(share.end);
            first = end;
            own
        };
        self.grids().map(own).collect()
    }

    /// Its identity, which tells it from others; all parts of a task have the same.
    pub(crate) fn identity(&self) -> Identity {
        let mut identity = of_rule(self.surfaces, self.rule);
        for light in &self.lights {
            let words = [
                light.spaces.len() as u64,
                u64::from(light.resolution.log2()),
                u64::from(light.bias.to_bits()),
            ];
            identity = words.into_iter().fold(identity, Identity::with);
            for space in &light.spaces {
                identity = identity.with(Identity::of_light(space).value());
            }
        }
        identity
    }

    /// Of one of its grids.
    fn identity_of(&self, grid: usize) -> Identity {
        self.identity().with(grid as u64)
    }

    /// Writes what there is.
    pub(crate) fn save<'s>(
        &self,
        states: impl ExactSizeIterator<Item = &'s State>,
        mut out: impl Write,
    ) -> io::Result<()> {
        let mut contents = Vec::with_capacity(states.len());
        for (grid, state) in states.enumerate() {
            contents.push(match state {
                State::Waiting => Content::Nothing,
                State::Finished(dag) => Content::Finished(dag),
                State::Tiles(tiles) => {
                    let mut bytes = Vec::new();
                    checkpoint::save(tiles, self.identity_of(grid), &mut bytes)?;
                    Content::Tiles(bytes)
                }
            });
        }
        out.write_all(&self.head(&contents))?;
        (contents.iter()).try_for_each(|content| out.write_all(content.bytes()))
    }

    fn head(&self, contents: &[Content<'_>]) -> Vec<u8> {
        let mut checked = self.surfaces.value().to_le_bytes().to_vec();
        checked.extend(self.identity().value().to_le_bytes());
        let mut words = |words: &[u32]| checked.extend(words.iter().flat_map(|w| w.to_le_bytes()));
        words(&[self.share.part(), self.share.parts()]);
        words(&[self.rule.number(), self.lights.len() as u32]);
        for light in &self.lights {
            let grids = light.spaces.len() as u32;
            words(&[grids, light.resolution.log2(), light.bias.to_bits()]);
        }
        for ((space, _), content) in self.grids().zip(contents) {
            let (slices, ends) = match space.slices() {
                Slices::Linear => (0_u32, [0.0; 2]),
                Slices::Logarithmic(ends) => (1, [ends.near(), ends.far()]),
            };
            checked.extend(slices.to_le_bytes());
            let numbers = ends.into_iter().chain(space.matrix().to_cols_array());
            checked.extend(numbers.flat_map(f64::to_le_bytes));
            checked.extend(content.kind().to_le_bytes());
            checked.extend((content.bytes().len() as u64).to_le_bytes());
        }
        let mut head = MAGIC.to_vec();
        head.extend(VERSION.to_le_bytes());
        head.extend(crc32fast::hash(&checked).to_le_bytes());
        head.extend(checked);
        head
    }

    /// Reads what [`Task::save`] wrote: the task, and what there is of its grids.
    ///
    /// # Errors
    /// [`CheckpointError`] if that is not sound.
    pub(crate) fn load(bytes: &[u8]) -> Result<(Self, Vec<State>), CheckpointError> {
        if bytes.starts_with(&EARLIER) {
            return Err(CheckpointError::Version(0));
        }
        let mut head = Bytes(bytes.strip_prefix(&MAGIC).ok_or(CheckpointError::Magic)?);
        let version = head.word()?;
        if version != VERSION {
            return Err(CheckpointError::Version(version));
        }
        let sum = head.word()?;
        let surfaces = Identity::of_value(head.long()?);
        let found = head.long()?;
        let share = Share::new(head.word()?, head.word()?);
        let share = share.map_err(|_| damaged("its part is none"))?;
        let rule = Rule::of_number(head.word()?).ok_or(damaged("its rule is unknown"))?;
        let count = u64::from(head.word()?);
        let count = head.count(count, LIGHT)?;
        let mut sizes = Vec::with_capacity(count);
        for _ in 0..count {
            let grids = head.word()?;
            let resolution = Resolution::from_log2(head.word()?);
            let resolution = resolution.ok_or(damaged("a resolution is none"))?;
            sizes.push((grids, resolution, f32::from_bits(head.word()?)));
        }
        let grids = sizes.iter().map(|(grids, ..)| u64::from(*grids)).sum();
        head.count(grids, GRID)?;
        let mut lights = Vec::with_capacity(count);
        let mut contents = Vec::new();
        for (grids, resolution, bias) in sizes {
            let mut spaces = Vec::new();
            for _ in 0..grids {
                spaces.push(read_space(&mut head)?);
                contents.push((head.word()?, head.long()?));
            }
            lights.push(LightGrids {
                spaces,
                resolution,
                bias,
            });
        }
        let end = bytes.len() - head.0.len();
        if crc32fast::hash(&bytes[CHECKED..end]) != sum {
            return Err(damaged("the checksum of its head is another"));
        }
        LightGrids::check(&lights).map_err(|_| damaged("a light has no grid, or no bias"))?;
        let task = Self {
            rule,
            surfaces,
            lights,
            share,
        };
        let expected = task.identity().value();
        if found != expected {
            return Err(CheckpointError::Foreign { found, expected });
        }
        let builder = Builder::new().rule(rule);
        let mut rest = head.0;
        let mut states = Vec::with_capacity(contents.len());
        for (grid, ((space, plan), (kind, length))) in task.grids().zip(contents).enumerate() {
            let length = usize::try_from(length).unwrap_or(usize::MAX);
            let (own, after) = (rest.split_at_checked(length)).ok_or(damaged("it is cut off"))?;
            rest = after;
            states.push(match kind {
                kind::NOTHING if own.is_empty() => State::Waiting,
                kind::TILES => {
                    let identity = task.identity_of(grid);
                    State::Tiles(checkpoint::load(plan, identity, own)?)
                }
                kind::FINISHED => {
                    let read = ShadowDag::from_bytes(own.to_vec());
                    let read = read.map_err(|error| CheckpointError::Grid { grid, error })?;
                    if read.light() != Some(&space) || read.resolution() != plan.resolution {
                        return Err(CheckpointError::OtherGrid { grid });
                    }
                    State::Finished(read)
                }
                _ => return Err(damaged("what there is of a grid is of an unknown kind")),
            });
        }
        if !rest.is_empty() {
            return Err(damaged("it goes on behind its end"));
        }
        for (own, state) in task.shares().into_iter().zip(&mut states) {
            let is_sound = match state {
                State::Waiting => true,
                State::Finished(dag) => own.len() == builder.plan_of_mesh(dag.resolution()).tiles(),
                State::Tiles(made) => {
                    let (before, after) = (&made.columns[..own.start], &made.columns[own.end..]);
                    let is_sound = before.iter().chain(after).all(Option::is_none);
                    made.wanted = own.collect();
                    is_sound
                }
            };
            if !is_sound {
                return Err(damaged("it has more than its part"));
            }
        }
        Ok((task, states))
    }
}

/// The progress of a grid, as a number in the head.
mod kind {
    pub(super) const NOTHING: u32 = 0;
    pub(super) const TILES: u32 = 1;
    pub(super) const FINISHED: u32 = 2;
}

/// The part of a grid that is written.
enum Content<'a> {
    Nothing,
    Tiles(Vec<u8>),
    Finished(&'a ShadowDag),
}

impl Content<'_> {
    fn kind(&self) -> u32 {
        match self {
            Self::Nothing => kind::NOTHING,
            Self::Tiles(_) => kind::TILES,
            Self::Finished(_) => kind::FINISHED,
        }
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Nothing => &[],
            Self::Tiles(bytes) => bytes,
            Self::Finished(dag) => dag.as_bytes(),
        }
    }
}

fn read_space(head: &mut Bytes<'_>) -> Result<LightSpace, CheckpointError> {
    let no_space = |_| damaged("the space of a light is none");
    let kind = head.word()?;
    let [near, far] = [head.take()?, head.take()?].map(f64::from_le_bytes);
    let mut matrix = [0.0; 16];
    for number in &mut matrix {
        *number = f64::from_le_bytes(head.take()?);
    }
    let slices = match kind {
        0 if [near, far].map(f64::to_bits) == [0; 2] => Slices::Linear,
        1 => Slices::logarithmic(near, far).map_err(no_space)?,
        _ => return Err(damaged("slices of an unknown kind")),
    };
    LightSpace::new(DMat4::from_cols_array(&matrix), slices).map_err(no_space)
}
