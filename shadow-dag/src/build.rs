//! From depths to a graph without equal nodes.

use std::sync::Mutex;

use gpu_backend::Cpu;

use crate::column::{Column, Columns, Run};
use crate::footprint::Footprints;
use crate::graph::Graph;
use crate::interval::Interval;
use crate::pool::{Pool, Reference, is_mixed};
use crate::region::Region;
use crate::{Casters, Error, Resolution, Rule, TileRect};

/// Texels along each side of the parts in which maps are read: with both
/// depths and both ends of the conversion 16 MiB per thread.
const REGION: u32 = 1024;

/// Builds shadows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Builder {
    pub(crate) rule: Rule,
    culling: bool,
}

impl Default for Builder {
    fn default() -> Self {
        Self {
            rule: Rule::default(),
            culling: true,
        }
    }
}

/// A column that has left its stack.
#[derive(Debug)]
enum Finished {
    Uniform(Interval),
    Runs {
        /// Which worker made the nodes.
        pool: usize,
        runs: Vec<Run>,
        bounds: Interval,
    },
}

/// What one thread works with. Its pool lives through many regions.
#[derive(Debug)]
struct Worker<S> {
    number: usize,
    pool: Pool,
    columns: Columns,
    scratch: S,
}

impl Builder {
    /// The default: [`Rule::Aligned`], with culling.
    pub fn new() -> Self {
        Self::default()
    }

    /// Chooses how free voxels are resolved.
    #[must_use]
    pub fn rule(self, rule: Rule) -> Self {
        Self { rule, ..self }
    }

    /// Without culling every volume along the light is made and compared,
    /// even if it repeats the one in front of it. For comparison: the result
    /// is the same.
    #[must_use]
    pub fn culling(self, culling: bool) -> Self {
        Self { culling, ..self }
    }

    pub(crate) fn graph<C: Casters + ?Sized>(
        &self,
        cpu: &Cpu,
        casters: &C,
    ) -> Result<Graph, Error> {
        let resolution = casters.resolution();
        let side = REGION.min(resolution.side());
        let level = side.trailing_zeros() as usize - 3;
        self.assemble(cpu, resolution, level, Region::default, |region, x, y| {
            let tile = TileRect {
                x: x * side,
                y: y * side,
                side,
            };
            region.read(casters, tile, self.rule).map(|()| (0, 0))
        })
    }

    /// Builds the columns of all footprints of `level`, in any order and on
    /// any thread, and puts them together. `part` prepares the scratch memory
    /// of a thread for one footprint.
    pub(crate) fn assemble<S: Footprints + Send>(
        &self,
        cpu: &Cpu,
        resolution: Resolution,
        level: usize,
        scratch: impl Fn() -> S + Sync + Send,
        part: impl Fn(&mut S, u32, u32) -> Result<S::Part, Error> + Sync + Send,
    ) -> Result<Graph, Error> {
        let width = resolution.side() >> (3 + level);
        let made = Mutex::new(0);
        let idle: Mutex<Vec<Worker<S>>> = Mutex::new(Vec::new());
        let columns = cpu.map((width as usize).pow(2), |index| {
            let mut worker = lock(&idle).pop().unwrap_or_else(|| {
                let mut made = lock(&made);
                *made += 1;
                Worker {
                    number: *made - 1,
                    pool: Pool::new(resolution),
                    columns: Columns::new(resolution, self.rule, self.culling),
                    scratch: scratch(),
                }
            });
            let (x, y) = (index as u32 % width, index as u32 / width);
            let column = part(&mut worker.scratch, x, y).map(|part| worker.finish(level, part));
            lock(&idle).push(worker);
            column
        });
        let columns = columns.into_iter().collect::<Result<Vec<_>, Error>>()?;
        let mut workers = idle
            .into_inner()
            .unwrap_or_else(|poison| poison.into_inner());
        workers.sort_by_key(|worker| worker.number);

        let mut pools = workers.into_iter().map(|worker| worker.pool);
        let mut pool = pools.next().unwrap_or_else(|| Pool::new(resolution));
        pool.check()?;
        let mut names: Vec<Vec<Reference>> = vec![Vec::new()];
        for other in pools {
            other.check()?;
            names.push(pool.absorb(&other).swap_remove(level));
        }
        let mut whole = Whole {
            columns: Columns::new(resolution, self.rule, self.culling),
            pool,
            width,
            level,
            parts: columns,
            names,
        };
        let root = whole.column(resolution.root_level(), 0, 0);
        let first = whole
            .columns
            .expand(resolution.root_level(), root, &mut whole.pool);
        let root = whole.columns.pop(first)[0].node;
        whole.pool.check()?;
        Ok(Graph::collect(resolution, &whole.pool, root))
    }
}

/// A thread that panicked does so again where its work is collected; what it
/// held is not looked at.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poison| poison.into_inner())
}

impl<S: Footprints> Worker<S> {
    fn finish(&mut self, level: usize, part: S::Part) -> Finished {
        let column = self
            .columns
            .column(&mut self.scratch, level, part, &mut self.pool);
        match column {
            Column::Uniform(interval) => Finished::Uniform(interval),
            Column::Runs { first, bounds } => Finished::Runs {
                pool: self.number,
                runs: self.columns.pop(first),
                bounds,
            },
        }
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
                let runs: Vec<Run> = runs.iter().map(rename).collect();
                self.columns.push(&runs, *bounds)
            }
        }
    }
}
