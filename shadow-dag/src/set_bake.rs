//! Baking the grids of several lights, one after the other.
//!
//! A checkpoint is a head, the number of finished grids and the length of each
//! as little-endian numbers of 64 bits, those grids, and what [`Bake::save`]
//! writes of the next. Both of those bring checks of their own.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gpu_backend::Cpu;

use crate::checkpoint::{CheckpointError, SET_MAGIC, damaged};
use crate::progress::Progress;
use crate::set::ShadowSet;
use crate::{Bake, Builder, Error, LightSpace, Resolution, ShadowDag, Surfaces, Watertightness};

/// Parts in which [`SetBake::run`] makes the tiles of a grid, with a look at
/// the clock after each.
const ROUNDS: usize = 64;

/// Checkpoints of [`SetBake::run`] may take one part in so many of the time.
const SHARE: u32 = 20;

/// The grids of several lights in the making, tile by tile and grid by grid.
///
/// [`SetBake::run`] makes all of them and hands out checkpoints on its way;
/// [`SetBake::advance`] goes on by as much as it is told. As with a [`Bake`] the
/// result has the same bytes however often it was interrupted, and on any
/// number of threads.
///
/// ```
/// # use std::sync::atomic::AtomicBool;
/// # use std::time::Duration;
/// # use glam::DMat4;
/// # use gpu_backend::Cpu;
/// # use shadow_dag::{Builder, LightSpace, Resolution, SetBake, Surfaces};
/// # let corners = [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]];
/// # let surfaces = || Surfaces::new(&corners[..], &[[0, 1, 2]][..]);
/// # let sun = LightSpace::orthographic(DMat4::IDENTITY, 2.0, 2.0, 0.0, 2.0)?;
/// # let lamp = LightSpace::perspective(DMat4::IDENTITY, 1.0, 0.1, 2.0)?;
/// let resolution = Resolution::new(256)?;
/// let begin = || SetBake::new(Builder::new(), surfaces()?, resolution, vec![vec![sun], vec![lamp]]);
/// let never = AtomicBool::new(false);
/// // Half of the tiles of the first grid, then the rest somewhere else.
/// let mut bake = begin()?;
/// bake.advance(&Cpu::new(), 512, &never, |_| {})?;
/// let mut checkpoint = Vec::new();
/// bake.save(&mut checkpoint)?;
///
/// let mut bake = begin()?;
/// bake.resume(&checkpoint)?;
/// let pause = Duration::from_secs(10);
/// bake.run(&Cpu::new(), &never, pause, |_| {}, |bake| {
///     checkpoint.clear();
///     bake.save(&mut checkpoint)?;
///     Ok::<(), Box<dyn std::error::Error>>(())
/// })?;
/// assert_eq!(bake.finish()?.lights().len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SetBake<'a> {
    builder: Builder,
    surfaces: Surfaces<'a>,
    resolution: Resolution,
    /// The number of grids of each light.
    counts: Vec<usize>,
    /// Where the grids of all lights are.
    spaces: Vec<LightSpace>,
    finished: Vec<ShadowDag>,
    /// Of the next grid; also of the last once all of its tiles are finished.
    current: Bake<'static>,
}

impl<'a> SetBake<'a> {
    /// The shadows that `surfaces` cast from each light into its grids, with
    /// nothing done yet.
    ///
    /// # Errors
    /// [`Error::Length`] if there is no light, or one without grids.
    pub fn new(
        builder: Builder,
        surfaces: Surfaces<'a>,
        resolution: Resolution,
        lights: Vec<Vec<LightSpace>>,
    ) -> Result<Self, Error> {
        let counts: Vec<usize> = lights.iter().map(Vec::len).collect();
        let spaces = lights.concat();
        let Some(first) = spaces.first().filter(|_| !counts.contains(&0)) else {
            return Err(Error::Length {
                what: "grids of a light",
                given: 0,
                expected: 1,
            });
        };
        let mesh = surfaces.seen_from(*first, resolution);
        Ok(Self {
            builder,
            resolution,
            counts,
            finished: Vec::with_capacity(spaces.len()),
            current: Bake::of_own_mesh(builder, mesh),
            surfaces,
            spaces,
        })
    }

    /// The bake of one of the grids, with nothing done yet.
    fn bake(&self, grid: usize) -> Bake<'static> {
        let mesh = self.surfaces.seen_from(self.spaces[grid], self.resolution);
        Bake::of_own_mesh(self.builder, mesh)
    }

    /// How much of the surfaces encloses something.
    pub fn watertightness(&self) -> Watertightness {
        self.surfaces.watertightness()
    }

    /// How far all grids are together.
    pub fn progress(&self) -> Progress {
        let Progress { finished, tiles } = self.current.progress();
        Progress {
            finished: tiles * self.finished.len() + finished,
            tiles: tiles * self.spaces.len(),
        }
    }

    /// The grid that is being made, and how many there are.
    pub fn grid(&self) -> (usize, usize) {
        (self.finished.len(), self.spaces.len())
    }

    /// Makes the next `most` tiles (0 counts as 1) of one grid, or all of it
    /// if there are fewer left, and says how far the bake is then. The next
    /// call goes on with the next grid.
    ///
    /// `observe` and `stop` are those of [`Bake::advance`]; numbers are those of
    /// all grids.
    ///
    /// # Errors
    /// As for [`Bake::advance`].
    pub fn advance(
        &mut self,
        cpu: &Cpu,
        most: usize,
        stop: &AtomicBool,
        mut observe: impl FnMut(Progress) + Send,
    ) -> Result<Progress, Error> {
        if self.current.progress().is_complete() && self.finished.len() + 1 < self.spaces.len() {
            let next = self.bake(self.finished.len() + 1);
            let done = std::mem::replace(&mut self.current, next);
            match done.finish() {
                Ok(grid) => self.finished.push(grid),
                Err(error) => {
                    // Grids and their numbers stay together.
                    self.current = self.bake(self.finished.len());
                    return Err(error);
                }
            }
        }
        let Progress { finished, tiles } = self.progress();
        let before = finished - self.current.progress().finished;
        let made = self.current.advance(cpu, most, stop, |progress| {
            observe(Progress {
                finished: before + progress.finished,
                tiles,
            });
        });
        match made {
            Ok(_) => Ok(self.progress()),
            Err(Error::Cancelled { .. }) => Err(self.progress().cancelled()),
            Err(error) => Err(error),
        }
    }

    /// Makes all that is missing.
    ///
    /// `save` is called with the bake when it is worth a [checkpoint](Self::save):
    /// about `pause` after the last time, or later, so that checkpoints take no
    /// more than a twentieth of the time, and once more if it is stopped.
    ///
    /// # Errors
    /// [`Error::Cancelled`] once `stop` was set, even if that was after the
    /// last tile; what [`SetBake::advance`] and `save` return.
    pub fn run<E: From<Error>>(
        &mut self,
        cpu: &Cpu,
        stop: &AtomicBool,
        pause: Duration,
        mut observe: impl FnMut(Progress) + Send,
        mut save: impl FnMut(&Self) -> Result<(), E>,
    ) -> Result<(), E> {
        let round = self.current.progress().tiles.div_ceil(ROUNDS);
        let mut wait = pause;
        let mut clock = Instant::now();
        while !self.progress().is_complete() {
            match self.advance(cpu, round, stop, &mut observe) {
                Err(Error::Cancelled { .. }) => break,
                result => result?,
            };
            if stop.load(Ordering::Relaxed) {
                break;
            }
            if clock.elapsed() >= wait && !self.progress().is_complete() {
                clock = Instant::now();
                save(self)?;
                wait = pause.max(clock.elapsed() * SHARE);
                clock = Instant::now();
            }
        }
        if stop.load(Ordering::Relaxed) {
            save(self)?;
            return Err(self.progress().cancelled().into());
        }
        Ok(())
    }

    /// Writes what is finished: the grids, and about 36 bytes for each node so
    /// far of the next.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn save(&self, mut out: impl Write) -> io::Result<()> {
        out.write_all(&SET_MAGIC)?;
        out.write_all(&(self.finished.len() as u64).to_le_bytes())?;
        for grid in &self.finished {
            out.write_all(&(grid.as_bytes().len() as u64).to_le_bytes())?;
        }
        for grid in &self.finished {
            out.write_all(grid.as_bytes())?;
        }
        self.current.save(out)
    }

    /// Takes over what is finished of a checkpoint in place of its own.
    ///
    /// # Errors
    /// [`CheckpointError`] if the bytes are no checkpoint of this bake: same
    /// surfaces, lights, resolution, rule and version of this crate. Nothing is
    /// taken from them then.
    pub fn resume(&mut self, checkpoint: &[u8]) -> Result<(), CheckpointError> {
        let (finished, tiles) = self.read(checkpoint)?;
        let mut next = self.bake(finished.len());
        next.resume(tiles)?;
        self.finished = finished;
        self.current = next;
        Ok(())
    }

    /// The grids of a checkpoint, and what there is of the next.
    fn read<'c>(
        &self,
        checkpoint: &'c [u8],
    ) -> Result<(Vec<ShadowDag>, &'c [u8]), CheckpointError> {
        let cut_off = || damaged("it is cut off");
        let rest = checkpoint
            .strip_prefix(&SET_MAGIC)
            .ok_or(CheckpointError::Magic)?;
        let (count, mut rest) = rest.split_first_chunk().ok_or_else(cut_off)?;
        // The last grid is never among the finished ones.
        let count = u64::from_le_bytes(*count);
        if count >= self.spaces.len() as u64 {
            return Err(CheckpointError::Grids {
                found: count,
                grids: self.spaces.len(),
            });
        }
        let mut lengths = Vec::new();
        for _ in 0..count {
            let (length, after) = rest.split_first_chunk().ok_or_else(cut_off)?;
            lengths.push(u64::from_le_bytes(*length));
            rest = after;
        }
        let mut grids = Vec::new();
        for (grid, (length, space)) in lengths.into_iter().zip(&self.spaces).enumerate() {
            let length = usize::try_from(length).map_err(|_| cut_off())?;
            let (bytes, after) = rest.split_at_checked(length).ok_or_else(cut_off)?;
            let read = ShadowDag::from_bytes(bytes.to_vec());
            let read = read.map_err(|error| CheckpointError::Grid { grid, error })?;
            if read.light() != Some(space) || read.resolution() != self.resolution {
                return Err(CheckpointError::OtherGrid { grid });
            }
            grids.push(read);
            rest = after;
        }
        Ok((grids, rest))
    }

    /// Puts the tiles of the last grid together, and the grids.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if not all tiles are finished,
    /// [`Error::TooManyNodes`].
    pub fn finish(mut self) -> Result<ShadowSet, Error> {
        let progress = self.progress();
        if !progress.is_complete() {
            return Err(progress.cancelled());
        }
        self.finished.push(self.current.finish()?);
        let mut grids = self.finished.into_iter();
        let lights = (self.counts.iter())
            .map(|count| grids.by_ref().take(*count).collect())
            .collect();
        Ok(ShadowSet::of_checked(lights))
    }
}
