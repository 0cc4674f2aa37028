//! Baking the grids of several lights.
//!
//! Grids are baked side by side. A thread that has nothing left to do in one helps
//! in another, so none is idle before the last tiles of all; and what is done once
//! for a grid, looking at all triangles and putting tiles together, one thread does
//! while others make tiles.

use std::io::{self, Write};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use gpu_backend::Cpu;

use crate::checkpoint::CheckpointError;
use crate::progress::Progress;
use crate::set::ShadowSet;
use crate::set_checkpoint::{State, Task};
use crate::share::Share;
use crate::tiles::{Plan, Tiles, Watch, lock};
use crate::{Builder, Error, Form, LightSpace, Mesh, Resolution, Surfaces, Watertightness};

/// Checkpoints of [`SetBake::run`] may take one part in so many of the time.
const SHARE: u32 = 20;

/// The grids that a light is to have.
#[derive(Debug, Clone, PartialEq)]
pub struct LightGrids {
    /// Where they are; at least one.
    pub spaces: Vec<LightSpace>,
    /// Voxels along each axis of each of them.
    pub resolution: Resolution,
    /// How far beyond half a filter's width a point on a surface is moved along its normal
    /// before it is asked about, in voxels; see [`ShadowSet::bias`].
    pub bias: f32,
}

impl LightGrids {
    /// The bias of lights that are given no other: surface and point are known to half
    /// a voxel each.
    pub const BIAS: f32 = 1.0;

    /// Grids with the usual bias.
    pub fn new(spaces: Vec<LightSpace>, resolution: Resolution) -> Self {
        Self {
            spaces,
            resolution,
            bias: Self::BIAS,
        }
    }

    /// # Errors
    /// [`Error::Length`] if there is no light, or one without grids;
    /// [`Error::BadValue`] for a bias that is negative or not finite.
    pub(crate) fn check(lights: &[Self]) -> Result<(), Error> {
        if lights.is_empty() || lights.iter().any(|light| light.spaces.is_empty()) {
            return Err(Error::Length {
                what: "grids of a light",
                given: 0,
                expected: 1,
            });
        }
        Self::check_biases(lights.iter().map(|light| light.bias))
    }

    /// # Errors
    /// [`Error::BadValue`] for a bias that is negative or not finite.
    pub(crate) fn check_biases(mut biases: impl Iterator<Item = f32>) -> Result<(), Error> {
        match biases.find(|bias| !(0.0..f32::INFINITY).contains(bias)) {
            Some(bias) => Err(Error::bad_value("a bias", bias, "a finite number from 0")),
            None => Ok(()),
        }
    }
}

/// The grids of several lights in the making, or a [part](SetBake::share) of them.
///
/// All tiles of all grids are one queue for all threads. [`SetBake::run`] makes all
/// of them and hands out checkpoints on its way; [`SetBake::advance`] goes on by as
/// much as it is told. As with a [`Bake`](crate::Bake) the result has the same bytes
/// however often it was interrupted, and on any number of threads.
///
/// Triangles are checked and sorted once for all lights; each grid takes those that
/// it may show. At any time about as many grids are unfinished as there are threads.
///
/// ```
/// # use std::sync::atomic::AtomicBool;
/// # use std::time::Duration;
/// # use glam::DMat4;
/// # use gpu_backend::Cpu;
/// # use shadow_dag::{Builder, LightGrids, LightSpace, Resolution, SetBake, Surfaces};
/// # let corners = [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]];
/// # let surfaces = || Surfaces::new(&corners[..], &[[0, 1, 2]][..]);
/// # let sun = LightSpace::orthographic(DMat4::IDENTITY, 2.0, 2.0, 0.0, 2.0)?;
/// # let lamp = LightSpace::perspective(DMat4::IDENTITY, 1.0, 0.1, 2.0)?;
/// let lights = || -> Result<_, shadow_dag::Error> {
///     let fine = LightGrids::new(vec![sun], Resolution::new(256)?);
///     Ok(vec![fine, LightGrids::new(vec![lamp], Resolution::new(128)?)])
/// };
/// let begin = || SetBake::new(Builder::new(), surfaces()?, lights()?);
/// let never = AtomicBool::new(false);
/// // A few tiles, then the rest somewhere else.
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
    surfaces: Surfaces<'a>,
    task: Task,
    form: Form,
    /// Those of all lights.
    grids: Vec<Grid>,
}

/// A grid in the making.
#[derive(Debug)]
struct Grid {
    space: LightSpace,
    plan: Plan,
    /// The tiles that are to be made here.
    own: Range<usize>,
    state: State,
    /// The triangles that the light sees. They are kept from the first tile to the last.
    mesh: Option<Box<Mesh>>,
}

impl<'a> SetBake<'a> {
    /// The shadows that `surfaces` cast from each light into its grids, with
    /// nothing done yet.
    ///
    /// # Errors
    /// [`Error::Length`] if there is no light, or one without grids;
    /// [`Error::BadValue`] for a bias that is negative or not finite.
    pub fn new(
        builder: Builder,
        surfaces: Surfaces<'a>,
        lights: Vec<LightGrids>,
    ) -> Result<Self, Error> {
        LightGrids::check(&lights)?;
        let task = Task {
            rule: builder.rule,
            surfaces: surfaces.identity(),
            lights,
            share: Share::default(),
        };
        Ok(Self {
            surfaces,
            form: Form::Plain,
            grids: Grid::waiting(&task),
            task,
        })
    }

    /// The form that grids are given when they are finished; plain by default.
    /// They change it on the threads that bake.
    #[must_use]
    pub fn form(self, form: Form) -> Self {
        Self { form, ..self }
    }

    /// Only this part of the bake, with nothing done yet. What [`SetBake::save`]
    /// writes of it when it is complete, [`ShadowSet::merge`] joins with the others.
    #[must_use]
    pub fn share(self, share: Share) -> Self {
        let task = Task { share, ..self.task };
        Self {
            grids: Grid::waiting(&task),
            task,
            ..self
        }
    }

    /// How much of the surfaces encloses something.
    pub fn watertightness(&self) -> Watertightness {
        self.surfaces.watertightness()
    }

    /// How far all grids are together, or the part of them that is baked here.
    pub fn progress(&self) -> Progress {
        let nothing = Progress {
            finished: 0,
            tiles: 0,
        };
        self.grids.iter().fold(nothing, |all, grid| {
            let Progress { finished, tiles } = grid.progress();
            Progress {
                finished: all.finished + finished,
                tiles: all.tiles + tiles,
            }
        })
    }

    /// The grids of each light.
    pub fn lights(&self) -> &[LightGrids] {
        &self.task.lights
    }

    /// Makes `most` tiles more (0 counts as 1), or all if there are fewer left,
    /// and says how far the bake is then.
    ///
    /// `observe` and `stop` are those of [`Bake::advance`](crate::Bake::advance);
    /// numbers are those of all grids.
    ///
    /// # Errors
    /// As for [`Bake::advance`](crate::Bake::advance).
    pub fn advance(
        &mut self,
        cpu: &Cpu,
        most: usize,
        stop: &AtomicBool,
        observe: impl FnMut(Progress) + Send,
    ) -> Result<Progress, Error> {
        self.go_on(cpu, most, None, stop, observe)
    }

    /// The same, which begins no more tiles from a time on, but at least one.
    fn go_on(
        &mut self,
        cpu: &Cpu,
        most: usize,
        until: Option<Instant>,
        stop: &AtomicBool,
        observe: impl FnMut(Progress) + Send,
    ) -> Result<Progress, Error> {
        let Progress { finished, tiles } = self.progress();
        let mut left = most.max(1);
        let mut jobs = Vec::new();
        for grid in &mut self.grids {
            let missing = grid.missing();
            if missing > 0 && left > 0 {
                jobs.push(Mutex::new((grid, missing.min(left))));
                left -= missing.min(left);
            }
        }
        let begun = AtomicBool::new(false);
        let is_late = || until.is_some_and(|until| Instant::now() >= until);
        let watched = Mutex::new((finished, observe));
        let (surfaces, form) = (&self.surfaces, self.form);
        let next = AtomicUsize::new(0);
        let made = cpu.map(jobs.len(), |_| {
            // Whoever is free takes the next grid, so that few are begun at a time.
            let job = next.fetch_add(1, Ordering::Relaxed);
            if stop.load(Ordering::Relaxed) || (begun.load(Ordering::Relaxed) && is_late()) {
                return Ok(());
            }
            // No other job is of this grid.
            let (grid, most) = &mut *lock(&jobs[job]);
            let watch = Watch {
                stop,
                pause: &|| begun.swap(true, Ordering::Relaxed) && is_late(),
                observe: &mut |_| {
                    let (finished, observe) = &mut *lock(&watched);
                    *finished += 1;
                    observe(Progress {
                        finished: *finished,
                        tiles,
                    });
                },
            };
            grid.advance(cpu, surfaces, form, *most, watch)
        });
        drop(jobs);
        let progress = self.progress();
        for result in made {
            match result {
                // Its numbers are those of one grid.
                Ok(()) | Err(Error::Cancelled { .. }) => {}
                error => error?,
            }
        }
        let wanted = most.max(1).min(tiles - finished);
        if stop.load(Ordering::Relaxed) && progress.finished < finished + wanted {
            return Err(progress.cancelled());
        }
        Ok(progress)
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
        let mut wait = pause;
        while !self.progress().is_complete() {
            // None is beyond all clocks.
            let until = Instant::now().checked_add(wait);
            match self.go_on(cpu, usize::MAX, until, stop, &mut observe) {
                Err(Error::Cancelled { .. }) => break,
                result => result?,
            };
            if stop.load(Ordering::Relaxed) {
                break;
            }
            if !self.progress().is_complete() {
                let clock = Instant::now();
                save(self)?;
                wait = pause.max(clock.elapsed() * SHARE);
            }
        }
        if stop.load(Ordering::Relaxed) {
            save(self)?;
            return Err(self.progress().cancelled().into());
        }
        Ok(())
    }

    /// Writes what is finished: grids, and of those that are not about 36 bytes
    /// for each node so far.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn save(&self, out: impl Write) -> io::Result<()> {
        let states = self.grids.iter().map(|grid| &grid.state);
        self.task.save(states, out)
    }

    /// Takes over what is finished of a checkpoint in place of its own.
    ///
    /// # Errors
    /// [`CheckpointError`] if the bytes are no checkpoint of this bake: same
    /// surfaces, lights, resolutions, biases, rule, part and version of this crate.
    /// Nothing is taken from them then.
    pub fn resume(&mut self, checkpoint: &[u8]) -> Result<(), CheckpointError> {
        let (task, states) = Task::load(checkpoint)?;
        let [found, expected] = [&task, &self.task].map(|task| task.identity().value());
        if found != expected {
            return Err(CheckpointError::Foreign { found, expected });
        }
        if task.share != self.task.share {
            return Err(CheckpointError::OtherPart {
                found: task.share,
                expected: self.task.share,
            });
        }
        for (grid, state) in self.grids.iter_mut().zip(states) {
            grid.state = state;
        }
        Ok(())
    }

    /// Puts the grids together.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if not all tiles of all grids are finished, and so for
    /// a part of a bake; [`Error::TooManyNodes`].
    pub fn finish(self) -> Result<ShadowSet, Error> {
        let finished = self.progress().finished;
        let tiles = self.grids.iter().map(|grid| grid.plan.tiles()).sum();
        let mut dags = Vec::with_capacity(self.grids.len());
        for Grid { space, state, .. } in self.grids {
            let dag = state.into_grid(&space, self.form)?;
            dags.push(dag.ok_or_else(|| Progress { finished, tiles }.cancelled())?);
        }
        Ok(ShadowSet::of_lights(&self.task.lights, dags))
    }
}

impl Grid {
    fn waiting(task: &Task) -> Vec<Self> {
        (task.grids().zip(task.shares()))
            .map(|((space, plan), own)| Self {
                space,
                plan,
                own,
                state: State::Waiting,
                mesh: None,
            })
            .collect()
    }

    fn progress(&self) -> Progress {
        match &self.state {
            State::Tiles(made) => made.progress(),
            State::Waiting => Progress {
                finished: 0,
                tiles: self.own.len(),
            },
            State::Finished(_) => Progress {
                finished: self.own.len(),
                tiles: self.own.len(),
            },
        }
    }

    /// Tiles that are still to be made.
    fn missing(&self) -> usize {
        let Progress { finished, tiles } = self.progress();
        tiles - finished
    }

    /// Makes up to `most` tiles, and the grid from all of them.
    fn advance(
        &mut self,
        cpu: &Cpu,
        surfaces: &Surfaces<'_>,
        form: Form,
        most: usize,
        watch: Watch<'_>,
    ) -> Result<(), Error> {
        let mut tiles = match std::mem::replace(&mut self.state, State::Waiting) {
            State::Tiles(tiles) => tiles,
            State::Waiting => Tiles::new(self.plan),
            State::Finished(_) => return Ok(()),
        };
        tiles.wanted = self.own.clone().collect();
        let (space, resolution) = (self.space, self.plan.resolution);
        let mesh =
            (self.mesh).get_or_insert_with(|| Box::new(Mesh::of(cpu, surfaces, space, resolution)));
        let made = tiles.bake(cpu, most, watch, mesh);
        let is_complete = tiles.progress().is_complete();
        if is_complete {
            self.mesh = None;
        }
        if made.is_err() || !is_complete || self.own.len() < self.plan.tiles() {
            self.state = State::Tiles(tiles);
            return made;
        }
        if let Some(dag) = State::Tiles(tiles).into_grid(&self.space, form)? {
            self.state = State::Finished(dag);
        }
        Ok(())
    }
}
