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

/// The settings that decide which nodes are over a tile, and how they are made.
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

    /// All tiles.
    pub(crate) fn tiles(&self) -> usize {
        (self.width() as usize).pow(2)
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
    /// Row by row; none for those that are not made.
    pub(crate) columns: Vec<Option<Finished>>,
    /// The tiles that are to be made, in order; all unless some are known or made elsewhere.
    pub(crate) wanted: Vec<usize>,
    /// Nodes by who made them: every thread has a pool of its own that lives
    /// through many tiles.
    pub(crate) pools: Vec<Pool>,
    /// Patches that are kept, by pool.
    patches: Vec<Patches>,
}

/// An observer that is told about tiles and can call a halt.
pub(crate) struct Watch<'a> {
    pub(crate) stop: &'a AtomicBool,
    /// Asked before each tile whether to leave it for later.
    pub(crate) pause: &'a (dyn Fn() -> bool + Sync),
    pub(crate) observe: &'a mut (dyn FnMut(Progress) + Send),
}

/// The working memory of a thread.
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
pub(crate) fn lock<T: ?Sized>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poison| poison.into_inner())
}

impl Tiles {
    pub(crate) fn new(plan: Plan) -> Self {
        let tiles = plan.tiles();
        Self {
            plan,
            columns: vec![None; tiles],
            wanted: (0..tiles).collect(),
            pools: Vec::new(),
            patches: Vec::new(),
        }
    }

    pub(crate) fn progress(&self) -> Progress {
        Progress {
            finished: self.wanted.len() - self.missing().count(),
            tiles: self.wanted.len(),
        }
    }

    /// The tiles that are to be made and are not made yet.
    fn missing(&self) -> impl Iterator<Item = usize> {
        let wanted = self.wanted.iter().copied();
        wanted.filter(|&tile| self.columns[tile].is_none())
    }

    /// Makes the columns of the next `most` tiles. `scratch` is the memory
    /// that a thread needs, `part` prepares it for one tile, by column and
    /// row. What was finished before an error, a stop or a pause is kept.
    ///
    /// # Errors
    /// [`Error::Cancelled`] once `stop` is set, and what `part` returns.
    pub(crate) fn advance<S: Footprints + Send>(
        &mut self,
        cpu: &Cpu,
        most: usize,
        Watch {
            stop,
            pause,
            observe,
        }: Watch<'_>,
        scratch: impl Fn() -> S + Sync + Send,
        part: impl Fn(&mut S, u32, u32) -> Result<S::Part, Error> + Sync + Send,
    ) -> Result<(), Error> {
        let Progress { finished, tiles } = self.progress();
        let wanted: Vec<usize> = self.missing().take(most).collect();
        let Self {
            plan,
            columns,
            wanted: _,
            pools,
            patches,
        } = self;
        let plan = *plan;

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
        let watched = Mutex::new((finished, observe));
        let found = cpu.map(wanted.len(), |index| {
            if stop.load(Ordering::Relaxed) || pause() {
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
        let mut left_out = false;
        for (&tile, column) in wanted.iter().zip(found) {
            match column {
                Ok(column) => {
                    left_out |= column.is_none();
                    columns[tile] = column;
                }
                Err(error) => failed = failed.and(Err(error)),
            }
        }
        failed?;
        self.pools.iter().try_for_each(Pool::check)?;
        if left_out && stop.load(Ordering::Relaxed) {
            return Err(self.progress().cancelled());
        }
        Ok(())
    }

    /// The graph of all tiles. It only depends on what is over them, not on
    /// who made which in what order.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if tiles are missing, [`Error::TooManyNodes`].
    pub(crate) fn graph(mut self) -> Result<Graph, Error> {
        self.unite()?;
        self.united_graph()
    }

    /// Brings the nodes of all columns into one pool.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`]; the columns stay sound.
    pub(crate) fn unite(&mut self) -> Result<(), Error> {
        self.pools.iter().try_for_each(Pool::check)?;
        self.patches.clear();
        let mut pools = std::mem::take(&mut self.pools).into_iter();
        let mut pool = pools
            .next()
            .unwrap_or_else(|| Pool::new(self.plan.resolution));
        let mut names: Vec<Vec<Reference>> = vec![Vec::new()];
        names.extend(pools.map(|other| pool.absorb(&other).swap_remove(self.plan.level)));
        for column in self.columns.iter_mut().flatten() {
            let Finished::Runs { pool, runs, .. } = column else {
                continue;
            };
            // Nodes of the first pool keep their names.
            if *pool > 0 {
                for run in runs.iter_mut().filter(|run| is_mixed(run.node)) {
                    run.node = names[*pool][run.node as usize];
                }
                *pool = 0;
            }
        }
        self.pools.push(pool);
        self.pools[0].check()
    }

    /// The graph of all tiles, whose nodes are in one pool.
    ///
    /// # Errors
    /// As for [`Tiles::graph`].
    pub(crate) fn united_graph(&mut self) -> Result<Graph, Error> {
        if self.columns.iter().any(Option::is_none) {
            let tiles = self.columns.len();
            let finished = self.columns.iter().flatten().count();
            return Err(Progress { finished, tiles }.cancelled());
        }
        let plan = self.plan;
        let mut whole = Whole {
            work: plan.columns(),
            pool: &mut self.pools[0],
            width: plan.width(),
            level: plan.level,
            parts: &self.columns,
        };
        let root_level = plan.resolution.root_level();
        let root = whole.column(root_level, 0, 0);
        let first = whole.work.expand(root_level, root, whole.pool);
        let root = whole.work.pop(first)[0].node;
        whole.pool.check()?;
        Ok(Graph::collect(plan.resolution, &*whole.pool, root))
    }

    /// Takes over what others have of the same grid, in place of what there is.
    pub(crate) fn take_over(&mut self, others: Self) {
        let known = self.pools.len();
        self.pools.extend(others.pools);
        for (column, other) in self.columns.iter_mut().zip(others.columns) {
            match other {
                None => {}
                Some(Finished::Runs { pool, runs, bounds }) => {
                    let pool = known + pool;
                    *column = Some(Finished::Runs { pool, runs, bounds });
                }
                uniform => *column = uniform,
            }
        }
    }

    /// Leaves out nodes that no column needs. All are in one pool.
    pub(crate) fn prune(&mut self) {
        let level = self.plan.level;
        let runs = |column: &Finished| match column {
            Finished::Runs { runs, .. } => runs.clone(),
            Finished::Uniform(_) => Vec::new(),
        };
        let nodes = (self.columns.iter().flatten().flat_map(runs)).map(|run| run.node);
        let (pool, names) = self.pools[0].pruned(level, nodes.filter(|node| is_mixed(*node)));
        for column in self.columns.iter_mut().flatten() {
            if let Finished::Runs { runs, .. } = column {
                for run in runs.iter_mut().filter(|run| is_mixed(run.node)) {
                    run.node = names[run.node as usize];
                }
            }
        }
        self.pools[0] = pool;
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

/// The levels above the columns of the tiles.
#[derive(Debug)]
struct Whole<'a> {
    work: Columns,
    pool: &'a mut Pool,
    /// Columns along each side.
    width: u32,
    level: usize,
    parts: &'a [Option<Finished>],
}

impl Whole<'_> {
    fn column(&mut self, level: usize, x: u32, y: u32) -> Column {
        if level > self.level {
            let first = self.work.top();
            let quarters = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(dx, dy)| self.column(level - 1, 2 * x + dx, 2 * y + dy));
            return self.work.merge(level, quarters, first, self.pool);
        }
        match &self.parts[(y * self.width + x) as usize] {
            Some(Finished::Runs { runs, bounds, .. }) => {
                self.work.push(runs.iter().copied(), *bounds)
            }
            Some(Finished::Uniform(interval)) => Column::Uniform(*interval),
            // None is missing, which was looked at before.
            None => Column::Uniform(Interval { enter: 0, exit: 0 }),
        }
    }
}
