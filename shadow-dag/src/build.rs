//! From depths to a graph without equal nodes.

use std::sync::atomic::AtomicBool;

use gpu_backend::Cpu;

use crate::graph::Graph;
use crate::region::Region;
use crate::tiles::{Plan, Tiles, Watch};
use crate::{DepthSource, Error, Resolution, Rule};

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

    pub(crate) fn graph<C: DepthSource + ?Sized>(
        &self,
        cpu: &Cpu,
        casters: &C,
    ) -> Result<Graph, Error> {
        let mut tiles = Tiles::new(self.plan_of_maps(casters.resolution()));
        let watch = Watch {
            stop: &AtomicBool::new(false),
            pause: &|| false,
            observe: &mut |_| {},
        };
        tiles.read(cpu, usize::MAX, watch, casters)?;
        tiles.graph()
    }

    /// Tiles as large as the parts in which maps are read.
    pub(crate) fn plan_of_maps(&self, resolution: Resolution) -> Plan {
        self.plan(resolution, REGION.min(resolution.side()))
    }

    /// Tiles of `side` texels.
    pub(crate) fn plan(&self, resolution: Resolution, side: u32) -> Plan {
        Plan {
            resolution,
            rule: self.rule,
            culling: self.culling,
            level: side.trailing_zeros() as usize - 3,
        }
    }
}

impl Tiles {
    /// [`Tiles::advance`] over the maps of `casters`.
    pub(crate) fn read<C: DepthSource + ?Sized>(
        &mut self,
        cpu: &Cpu,
        most: usize,
        watch: Watch<'_>,
        casters: &C,
    ) -> Result<(), Error> {
        let plan = self.plan;
        self.advance(cpu, most, watch, Region::default, |region, x, y| {
            region
                .read(casters, plan.tile(x, y), plan.rule)
                .map(|()| (0, 0))
        })
    }
}
