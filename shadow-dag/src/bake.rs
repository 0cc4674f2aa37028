//! Building shadows with breaks.

use std::fmt;
use std::io;
use std::sync::atomic::AtomicBool;

use gpu_backend::Cpu;

use crate::checkpoint::{self, CheckpointError};
use crate::identity::Identity;
use crate::mesh::{BINS, Scratch};
use crate::progress::Progress;
use crate::tiles::{Plan, Tiles, Watch};
use crate::{Builder, DepthSource, Error, Form, LightSpace, Mesh, Resolution, Rule, ShadowDag};

/// Shadows in the making, tile by tile of the map.
///
/// Tiles are made by [`Bake::advance`], which can be watched and stopped. In
/// between, what is finished can be [saved](Bake::save), and a bake of the
/// same casters [resumed](Bake::resume) from it, in another process or much
/// later. The result has the same bytes however often that happened, and on
/// any number of threads.
///
/// ```
/// # use std::sync::atomic::{AtomicBool, Ordering};
/// # use glam::DMat4;
/// # use gpu_backend::Cpu;
/// # use shadow_dag::{Bake, Builder, Error, LightSpace, Mesh, Resolution};
/// # let light = LightSpace::orthographic(DMat4::IDENTITY, 2.0, 2.0, 0.0, 2.0)?;
/// # let corners = [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]];
/// # let mesh = Mesh::new(Resolution::new(512)?, light, &corners, &[[0, 1, 2]])?;
/// let stop = AtomicBool::new(false);
/// let mut bake = Bake::of_mesh(Builder::new(), &mesh);
/// let halt_halfway = |progress: shadow_dag::Progress| {
///     stop.store(2 * progress.finished > progress.tiles, Ordering::Relaxed);
/// };
/// let stopped = bake.advance(&Cpu::new(), usize::MAX, &stop, halt_halfway);
/// assert!(matches!(stopped, Err(Error::Cancelled { .. })));
/// let mut checkpoint = Vec::new();
/// bake.save(&mut checkpoint)?;
///
/// let mut bake = Bake::of_mesh(Builder::new(), &mesh);
/// bake.resume(&checkpoint)?;
/// bake.advance(&Cpu::new(), usize::MAX, &AtomicBool::new(false), |_| {})?;
/// let whole = Builder::new().bake(&Cpu::new(), &mesh)?;
/// assert_eq!(bake.finish()?.as_bytes(), whole.as_bytes());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Bake<'a> {
    source: Source<'a>,
    light: Option<LightSpace>,
    tiles: Tiles,
    identity: Identity,
}

enum Source<'a> {
    Mesh(&'a Mesh),
    Maps(&'a dyn DepthSource),
}

impl fmt::Debug for Bake<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bake")
            .field("light", &self.light)
            .field("progress", &self.progress())
            .finish_non_exhaustive()
    }
}

impl<'a> Bake<'a> {
    /// What [`Builder::bake`] does, with nothing done yet: 64×64 tiles, or
    /// those of [`Bake::of_depths`] for other rules than [`Rule::Aligned`].
    pub fn of_mesh(builder: Builder, mesh: &'a Mesh) -> Self {
        let tiles = Tiles::new(builder.plan_of(mesh));
        Self {
            source: Source::Mesh(mesh),
            light: mesh.light(),
            identity: identity(mesh.identity(), &tiles),
            tiles,
        }
    }

    /// What [`Builder::build`] does, with nothing done yet: tiles of
    /// 1024×1024 texels.
    ///
    /// `identity` has to tell casters apart: a hash of all that they depend
    /// on, for instance. A checkpoint is only taken from casters of the same
    /// identity, light and resolution.
    pub fn of_depths(builder: Builder, casters: &'a dyn DepthSource, identity: u64) -> Self {
        let tiles = Tiles::new(builder.plan_of_maps(casters.resolution()));
        let light = casters.light();
        let known = light.map_or(Identity::new(), |light| Identity::of_light(&light));
        Self {
            source: Source::Maps(casters),
            light,
            identity: self::identity(known.with(identity), &tiles),
            tiles,
        }
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        self.tiles.progress()
    }

    /// Makes the next `most` tiles (0 counts as 1), or all if there are fewer
    /// left, and says how far the bake is then.
    ///
    /// `observe` is told after every tile; the numbers it is given rise by one
    /// at a time, on whatever thread. Once `stop` is set, by `observe` or by
    /// any other thread, tiles that are being made are given up within
    /// milliseconds, or when the maps under a tile have been read.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if tiles were left out because of `stop`, what the
    /// casters return, and [`Error::TooManyNodes`]. Finished tiles are kept,
    /// and the bake can go on after all but the last.
    pub fn advance(
        &mut self,
        cpu: &Cpu,
        most: usize,
        stop: &AtomicBool,
        mut observe: impl FnMut(Progress) + Send,
    ) -> Result<Progress, Error> {
        let observe = &mut observe;
        let watch = Watch {
            stop,
            pause: &|| false,
            observe,
        };
        match &self.source {
            Source::Mesh(mesh) => self.tiles.bake(cpu, most.max(1), watch, mesh)?,
            Source::Maps(casters) => self.tiles.read(cpu, most.max(1), watch, *casters)?,
        }
        Ok(self.progress())
    }

    /// Writes what is finished: about 36 bytes for each node so far.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn save(&self, out: impl io::Write) -> io::Result<()> {
        checkpoint::save(&self.tiles, self.identity, out)
    }

    /// Takes over the finished tiles of a checkpoint in place of its own.
    ///
    /// # Errors
    /// [`CheckpointError`] if the bytes are no checkpoint of this bake: same
    /// casters, light, resolution, rule and version of this crate. Nothing is
    /// taken from them then.
    pub fn resume(&mut self, checkpoint: &[u8]) -> Result<(), CheckpointError> {
        self.tiles = checkpoint::load(self.tiles.plan, self.identity, checkpoint)?;
        Ok(())
    }

    /// Puts the tiles together.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if not all of them are finished,
    /// [`Error::TooManyNodes`].
    pub fn finish(self) -> Result<ShadowDag, Error> {
        let graph = self.tiles.graph()?;
        ShadowDag::from_graph(&graph, self.light.as_ref(), Form::Plain)
    }
}

/// Shadow casters cut into tiles. Another version of this crate, or of a rule, may
/// choose other nodes.
fn identity(casters: Identity, tiles: &Tiles) -> Identity {
    let plan = tiles.plan;
    let words = [u64::from(plan.resolution.log2()), plan.level as u64];
    of_rule(words.into_iter().fold(casters, Identity::with), plan.rule)
}

/// The same made by a rule and by this version of the crate.
pub(crate) fn of_rule(casters: Identity, rule: Rule) -> Identity {
    let version = env!("CARGO_PKG_VERSION").bytes().map(u64::from);
    version.fold(casters.with(rule.number().into()), Identity::with)
}

impl Builder {
    /// Builds the shadows of a mesh without maps.
    ///
    /// Where no surface crosses a gap between the last front face and the
    /// first back face over a footprint, all of its texels can turn within
    /// that gap, and nothing is rasterised: only tiles at silhouettes, and
    /// surfaces of parts with holes, are looked at texel by texel. Time and
    /// memory grow with the length of the silhouettes.
    ///
    /// Answers are those of [`Builder::build`] wherever those are defined. For
    /// rules other than [`Rule::Aligned`] it is the same as that. A [`Bake`]
    /// does the same work in parts.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`].
    pub fn bake(&self, cpu: &Cpu, mesh: &Mesh) -> Result<ShadowDag, Error> {
        let mut bake = Bake::of_mesh(*self, mesh);
        bake.advance(cpu, usize::MAX, &AtomicBool::new(false), |_| {})?;
        bake.finish()
    }

    /// The tiles in which a mesh is baked.
    pub(crate) fn plan_of(&self, mesh: &Mesh) -> Plan {
        self.plan_of_mesh(mesh.resolution())
    }

    /// The tiles in which meshes are baked at a resolution.
    pub(crate) fn plan_of_mesh(&self, resolution: Resolution) -> Plan {
        if self.rule != Rule::Aligned {
            return self.plan_of_maps(resolution);
        }
        self.plan(
            resolution,
            resolution.side() / BINS.min(resolution.side() / 8),
        )
    }
}

impl Tiles {
    /// [`Tiles::advance`] over the triangles of `mesh`.
    pub(crate) fn bake(
        &mut self,
        cpu: &Cpu,
        most: usize,
        watch: Watch<'_>,
        mesh: &Mesh,
    ) -> Result<(), Error> {
        let plan = self.plan;
        if plan.rule != Rule::Aligned {
            return self.read(cpu, most, watch, mesh);
        }
        let scratch = || Scratch::new(mesh, true);
        self.advance(cpu, most, watch, scratch, |scratch, x, y| {
            Ok(scratch.start(plan.tile(x, y)))
        })
    }
}
