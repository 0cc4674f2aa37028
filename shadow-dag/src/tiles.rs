//! Columns over all tiles of a map: made in any order, on any thread, with
//! breaks in between, and put together at the end.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use gpu_backend::Cpu;

use crate::Error;
use crate::column::{Column, Columns, Run};
use crate::depths::TileRect;
use crate::footprint::{Content, Footprints};
use crate::graph::Graph;
use crate::interval::Interval;
use crate::patches::{Patch, Patches};
use crate::pool::{Pool, Reference, is_mixed};
use crate::progress::Progress;
use crate::resolution::Resolution;
use crate::rule::{Rule, Tile};

/// What decides about the nodes over a tile, and how they are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Plan {
    pub(crate) resolution: Resolution,
    pub(crate) rule: Rule,
    pub(crate) culling: bool,
    /// The level whose footprints are the tiles.
    pub(crate) level: usize,
}

impl Plan {
    /// Tiles along each side of the map.
    pub(crate) fn width(&self) -> u32 {
        self.resolution.side() >> (3 + self.level)
    }

    /// The texels of a tile, by column and row.
    pub(crate) fn tile(&self, x: u32, y: u32) -> TileRect {
        let side = 8 << self.level;
        TileRect {
            x: x * side,
            y: y * side,
            side,
        }
    }

    fn columns(&self) -> Columns {
        Columns::new(self.resolution, self.rule, self.culling)
    }
}

/// The column of a tile, off its stack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Finished {
    Uniform(Interval),
    Runs {
        /// Which of the pools has the nodes.
        pool: usize,
        runs: Vec<Run>,
        bounds: Interval,
    },
}

/// Tiles, some of them finished.
#[derive(Debug)]
pub(crate) struct Tiles {
    pub(crate) plan: Plan,
    /// Row by row; none for those that are still to be made.
    pub(crate) columns: Vec<Option<Finished>>,
    /// Nodes by who made them: every thread has a pool of its own that lives
    /// through many tiles.
    pub(crate) pools: Vec<Pool>,
    /// What is kept of patches, by pool.
    patches: Vec<Patches>,
}

/// Who is told about tiles, and can call a halt.
pub(crate) struct Watch<'a> {
    pub(crate) stop: &'a AtomicBool,
    pub(crate) observe: &'a mut (dyn FnMut(Progress) + Send),
}

/// What one thread works with.
#[derive(Debug)]
struct Worker<S> {
    number: usize,
    pool: Pool,
    patches: Patches,
    columns: Columns,
    scratch: S,
}

/// Footprints that come to an end quickly, and wrongly, once `stop` is set.
#[derive(Debug)]
struct Stoppable<'a, S> {
    footprints: &'a mut S,
    stop: &'a AtomicBool,
    /// Whether it was.
    stopped: bool,
}

impl<S: Footprints> Footprints for Stoppable<'_, S> {
    type Part = S::Part;

    fn content(&mut self, level: usize, part: S::Part, texels: &mut Tile) -> Content<S::Part> {
        if self.stop.load(Ordering::Relaxed) {
            self.stopped = true;
            return Content::Uniform(Interval { enter: 0, exit: 0 });
        }
        self.footprints.content(level, part, texels)
    }

    fn leave(&mut self, part: S::Part) {
        self.footprints.leave(part);
    }

    fn patch(&self, level: usize, part: S::Part) -> Option<Patch> {
        self.footprints.patch(level, part)
    }

    fn is_stopped(&self) -> bool {
        self.stopped
    }
}

/// A thread that panicked does so again where its work is collected; what it
/// held is not looked at.
fn lock<T: ?Sized>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poison| poison.into_inner())
}

impl Tiles {
    pub(crate) fn new(plan: Plan) -> Self {
        Self {
            plan,
            columns: vec![None; (plan.width() as usize).pow(2)],
            pools: Vec::new(),
            patches: Vec::new(),
        }
    }

    pub(crate) fn progress(&self) -> Progress {
        Progress {
            finished: self.columns.iter().flatten().count(),
            tiles: self.columns.len(),
        }
    }

    /// Makes the columns of the next `most` tiles. `scratch` is the memory
    /// that a thread needs, `part` prepares it for one tile, by column and
    /// row. What was finished before an error or a stop is kept.
    ///
    /// # Errors
    /// [`Error::Cancelled`] once `stop` is set, and what `part` returns.
    pub(crate) fn advance<S: Footprints + Send>(
        &mut self,
        cpu: &Cpu,
        most: usize,
        Watch { stop, observe }: Watch<'_>,
        scratch: impl Fn() -> S + Sync + Send,
        part: impl Fn(&mut S, u32, u32) -> Result<S::Part, Error> + Sync + Send,
    ) -> Result<(), Error> {
        let Self {
            plan,
            columns,
            pools,
            patches,
        } = self;
        let plan = *plan;
        let wanted = (0..columns.len()).filter(|&tile| columns[tile].is_none());
        let wanted: Vec<usize> = wanted.take(most).collect();
        let before = columns.iter().flatten().count();
        let tiles = columns.len();

        let worker = |(number, (pool, patches))| Worker {
            number,
            pool,
            patches,
            columns: plan.columns(),
            scratch: scratch(),
        };
        let made = AtomicUsize::new(pools.len());
        // A checkpoint brings pools only.
        patches.resize_with(pools.len(), Patches::default);
        let before_this = std::mem::take(pools)
            .into_iter()
            .zip(std::mem::take(patches));
        let idle = Mutex::new(Vec::from_iter(before_this.enumerate().map(worker)));
        let watched = Mutex::new((before, observe));
        let found = cpu.map(wanted.len(), |index| {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let waiting = lock(&idle).pop();
            let mut mine = waiting.unwrap_or_else(|| {
                let number = made.fetch_add(1, Ordering::Relaxed);
                worker((number, (Pool::new(plan.resolution), Patches::default())))
            });
            let tile = wanted[index] as u32;
            let (x, y) = (tile % plan.width(), tile / plan.width());
            let column =
                part(&mut mine.scratch, x, y).map(|part| mine.column(plan.level, part, stop));
            lock(&idle).push(mine);
            if let Ok(Some(_)) = column {
                let (finished, observe) = &mut *lock(&watched);
                *finished += 1;
                observe(Progress {
                    finished: *finished,
                    tiles,
                });
            }
            column
        });

        let mut workers = idle
            .into_inner()
            .unwrap_or_else(|poison| poison.into_inner());
        workers.sort_by_key(|worker| worker.number);
        for worker in workers {
            pools.push(worker.pool);
            patches.push(worker.patches);
        }
        let mut failed = Ok(());
        let mut stopped = false;
        for (&tile, column) in wanted.iter().zip(found) {
            match column {
                Ok(column) => {
                    stopped |= column.is_none();
                    columns[tile] = column;
                }
                Err(error) => failed = failed.and(Err(error)),
            }
        }
        failed?;
        self.pools.iter().try_for_each(Pool::check)?;
        if stopped {
            return Err(self.progress().cancelled());
        }
        Ok(())
    }

    /// The graph of all tiles. It only depends on what is over them, not on
    /// who made which in what order.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if tiles are missing, [`Error::TooManyNodes`].
    pub(crate) fn graph(self) -> Result<Graph, Error> {
        let progress = self.progress();
        let Self {
            plan,
            columns,
            pools,
            patches: _,
        } = self;
        let Some(parts) = columns.into_iter().collect::<Option<Vec<Finished>>>() else {
            return Err(progress.cancelled());
        };
        let mut pools = pools.into_iter();
        let mut pool = pools.next().unwrap_or_else(|| Pool::new(plan.resolution));
        pool.check()?;
        let mut names: Vec<Vec<Reference>> = vec![Vec::new()];
        for other in pools {
            other.check()?;
            names.push(pool.absorb(&other).swap_remove(plan.level));
        }
        let mut whole = Whole {
            columns: plan.columns(),
            pool,
            width: plan.width(),
            level: plan.level,
            parts,
            names,
        };
        let resolution = plan.resolution;
        let root = whole.column(resolution.root_level(), 0, 0);
        let first = whole
            .columns
            .expand(resolution.root_level(), root, &mut whole.pool);
        let root = whole.columns.pop(first)[0].node;
        whole.pool.check()?;
        Ok(Graph::collect(resolution, &whole.pool, root))
    }
}

impl<S: Footprints> Worker<S> {
    /// The column over one tile; none if it was stopped.
    fn column(&mut self, level: usize, part: S::Part, stop: &AtomicBool) -> Option<Finished> {
        let mut footprints = Stoppable {
            footprints: &mut self.scratch,
            stop,
            stopped: false,
        };
        let column = (self.columns).column(
            &mut footprints,
            level,
            part,
            &mut self.pool,
            &mut self.patches,
        );
        let stopped = footprints.stopped;
        let column = match column {
            Column::Uniform(interval) => Finished::Uniform(interval),
            Column::Runs { first, bounds } => Finished::Runs {
                pool: self.number,
                runs: self.columns.pop(first),
                bounds,
            },
        };
        (!stopped).then_some(column)
    }
}

/// The levels above the columns of the threads.
#[derive(Debug)]
struct Whole {
    columns: Columns,
    pool: Pool,
    /// Columns along each side.
    width: u32,
    level: usize,
    parts: Vec<Finished>,
    /// What the nodes of each worker are called in `pool`; nothing for the
    /// first, who made it.
    names: Vec<Vec<Reference>>,
}

impl Whole {
    fn column(&mut self, level: usize, x: u32, y: u32) -> Column {
        if level > self.level {
            let first = self.columns.top();
            let quarters = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(dx, dy)| self.column(level - 1, 2 * x + dx, 2 * y + dy));
            return self.columns.merge(level, quarters, first, &mut self.pool);
        }
        match &self.parts[(y * self.width + x) as usize] {
            Finished::Uniform(interval) => Column::Uniform(*interval),
            Finished::Runs { pool, runs, bounds } => {
                let names = &self.names[*pool];
                let rename = |run: &Run| match names.get(run.node as usize) {
                    Some(&node) if is_mixed(run.node) => Run { node, ..*run },
                    _ => *run,
                };
                self.columns.push(runs.iter().map(rename), *bounds)
            }
        }
    }
}
