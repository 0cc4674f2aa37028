//! Shadows of a scene in which something changes now and then.
//!
//! Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of Voxelized
//! Shadows, I3D 2015, suggest in sections 1 and 6 that shadows be made anew while they
//! are used, over several frames. Here only those tiles are made that differ.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gpu_backend::Cpu;

use crate::identity::Identity;
use crate::progress::Progress;
use crate::tiles::{Tiles, Watch};
use crate::{Builder, Error, Form, Mesh, ShadowDag};

/// The pool is pruned of nodes that no tile needs any more once it has this many times the
/// nodes that the last pruning left.
const WASTE: usize = 2;

/// The grid of a light together with what it was put together from, so that a change of
/// the scene costs a bake of what changed: about 36 bytes more for each node.
///
/// A [`Rebuild`] makes what a changed scene needs, in slices of time. Until it takes its
/// [place](KeptGrid::replace) the grid answers as before; dropped earlier it leaves no
/// trace. Afterwards the grid has the bytes of a fresh bake.
///
/// ```
/// # use std::time::Duration;
/// # use glam::DMat4;
/// # use gpu_backend::Cpu;
/// # use shadow_dag::{Builder, KeptGrid, LightSpace, Mesh, Resolution};
/// # let cpu = Cpu::new();
/// # let light = LightSpace::orthographic(DMat4::IDENTITY, 2.0, 2.0, 0.0, 2.0)?;
/// # let scene = |x: f32| {
/// #     let corners = [[x, 0.0, -1.0], [x + 0.1, 0.0, -1.0], [x, 0.1, -1.0]];
/// #     Mesh::new(Resolution::new(512)?, light, &corners, &[[0, 1, 2]])
/// # };
/// let mut kept = KeptGrid::new(&cpu, Builder::new(), &scene(0.0)?)?;
/// // A triangle moves a little to the right.
/// let moved = scene(0.05)?;
/// let mut rebuild = kept.rebuild(moved.clone());
/// assert!(rebuild.progress().tiles < 4096 / 100);
/// while !rebuild.progress().is_complete() {
///     // In each frame, besides drawing it with the old shadows.
///     rebuild.advance(&cpu, Duration::from_millis(2))?;
/// }
/// kept.replace(rebuild)?;
/// let fresh = Builder::new().bake(&cpu, &moved)?;
/// assert_eq!(kept.grid().as_bytes(), fresh.as_bytes());
/// # Ok::<(), shadow_dag::Error>(())
/// ```
#[derive(Debug)]
pub struct KeptGrid {
    builder: Builder,
    /// All finished, their nodes in one pool.
    tiles: Tiles,
    /// The identity of the triangles over each of them.
    known: Vec<Identity>,
    /// The size of the pool when it was pruned last.
    pruned: usize,
    grid: ShadowDag,
}

/// The tiles that a changed scene needs, in the making; see [`KeptGrid`].
#[derive(Debug)]
pub struct Rebuild {
    mesh: Mesh,
    /// Only those that changed are to be made.
    tiles: Tiles,
    known: Vec<Identity>,
    /// The identity of the triangles over all tiles of the grid when this was begun.
    before: Identity,
}

/// The identity of the triangles over all tiles.
fn all(known: &[Identity]) -> Identity {
    let words = known.iter().map(|tile| tile.value());
    words.fold(Identity::new(), Identity::with)
}

impl KeptGrid {
    /// Bakes a mesh, as [`Builder::bake`] does.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`].
    pub fn new(cpu: &Cpu, builder: Builder, mesh: &Mesh) -> Result<Self, Error> {
        let mut tiles = Tiles::new(builder.plan_of(mesh));
        let watch = Watch {
            stop: &AtomicBool::new(false),
            pause: &|| false,
            observe: &mut |_| {},
        };
        tiles.bake(cpu, usize::MAX, watch, mesh)?;
        tiles.unite()?;
        let graph = tiles.united_graph()?;
        Ok(Self {
            builder,
            known: mesh.over_tiles(&tiles.plan),
            pruned: tiles.pools[0].len(),
            tiles,
            grid: ShadowDag::from_graph(&graph, Some(&mesh.light), Form::Plain)?,
        })
    }

    /// Nodes that are kept, needed or not.
    #[cfg(test)]
    pub(crate) fn nodes(&self) -> usize {
        self.tiles.pools[0].len()
    }

    /// The shadows, in the plain form.
    pub fn grid(&self) -> &ShadowDag {
        &self.grid
    }

    /// Begins to make the shadows of the scene as it is now: of all of it, seen from the
    /// same light and at the same resolution. Only those tiles are made again over which
    /// there is something else than before: whatever moved, came or went is found by
    /// comparing the triangles over each, as they were and as they are. With another light
    /// or resolution all are.
    pub fn rebuild(&self, mesh: Mesh) -> Rebuild {
        let plan = self.builder.plan_of(&mesh);
        let known = mesh.over_tiles(&plan);
        let mut tiles = Tiles::new(plan);
        if plan == self.tiles.plan {
            tiles.wanted.retain(|&tile| known[tile] != self.known[tile]);
        }
        Rebuild {
            mesh,
            tiles,
            known,
            before: all(&self.known),
        }
    }

    /// Puts the tiles of a complete rebuild in the place of the old ones, and the grid
    /// together. This takes a time of its own, in one piece on one thread, that grows with
    /// all nodes of the grid.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the rebuild is not complete, [`Error::Outdated`] if it was
    /// begun before another was put in place, [`Error::TooManyNodes`]. The grid stays the old
    /// one then; after too many nodes no rebuild of the same surfaces mends that.
    pub fn replace(&mut self, rebuild: Rebuild) -> Result<(), Error> {
        let Rebuild {
            mesh,
            tiles,
            known,
            before,
        } = rebuild;
        let progress = tiles.progress();
        if !progress.is_complete() {
            return Err(progress.cancelled());
        }
        if before != all(&self.known) {
            return Err(Error::Outdated);
        }
        if tiles.plan == self.tiles.plan {
            self.tiles.take_over(tiles);
        } else {
            self.tiles = tiles;
        }
        self.known = known;
        self.tiles.unite()?;
        if self.tiles.pools[0].len() > WASTE * self.pruned {
            self.tiles.prune();
            self.pruned = self.tiles.pools[0].len();
        }
        let graph = self.tiles.united_graph()?;
        self.grid = ShadowDag::from_graph(&graph, Some(&mesh.light), Form::Plain)?;
        Ok(())
    }
}

impl Rebuild {
    /// How far it is: tiles that are made again.
    pub fn progress(&self) -> Progress {
        self.tiles.progress()
    }

    /// Goes on for about `limit`: no tile is begun after that, but at least one in any
    /// case.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`].
    pub fn advance(&mut self, cpu: &Cpu, limit: Duration) -> Result<Progress, Error> {
        let until = Instant::now().checked_add(limit);
        let begun = AtomicBool::new(false);
        let watch = Watch {
            stop: &AtomicBool::new(false),
            pause: &|| {
                begun.swap(true, Ordering::Relaxed)
                    && until.is_some_and(|until| Instant::now() >= until)
            },
            observe: &mut |_| {},
        };
        self.tiles.bake(cpu, usize::MAX, watch, &self.mesh)?;
        Ok(self.tiles.progress())
    }
}
