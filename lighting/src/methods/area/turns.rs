//! Bounds on the loop iterations of evaluators in a shader.

use ::airlight::Table;

use crate::Emitter;
use crate::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use crate::path::MOST_KINKS;
use crate::scene::{Emission, MOST_COOKIE_LINES};

/// Bounds the loop iterations of an evaluator's shader.
///
/// Some software drivers end all loops of an invocation after 65,535 iterations. The bound
/// decides how many lights a [gather](super::GatherMany) puts into one invocation. An evaluator
/// that needs more for a single light loses some of its light on such a driver: with 128 voxels
/// along a ray, [`EquiAngular`] with 480 nodes or more.
pub trait AirlightTurns {
    /// An upper bound on the iterations of all loops together, for the airlight of one light
    /// along a ray with `parts` lit parts.
    fn turns(&self, emitter: &Emitter, parts: u32) -> u32;
}

const KINKS: u32 = MOST_KINKS as u32;

/// Pieces of a ray in a [`Quadrature`] in addition to those that kinks end: 20 on either side
/// of the foot point, while the distance from the light grows eightfold each time, up to 2^60
/// times itself; and some for peaks and for optical depths.
const PIECES: u32 = 64;

/// Pieces in a cookie in addition to those that its texels end; `light_COOKIE_PIECES` limits
/// them in shaders.
const COOKIE_PIECES: u32 = 2048;

impl AirlightTurns for Midpoint {
    fn turns(&self, _: &Emitter, _: u32) -> u32 {
        0
    }
}

impl AirlightTurns for EquiAngular {
    /// One iteration for each kink, and for each node of each part between kinks.
    fn turns(&self, _: &Emitter, parts: u32) -> u32 {
        (KINKS + self.nodes()).saturating_mul(parts.saturating_add(KINKS))
    }
}

impl AirlightTurns for Quadrature {
    /// For each piece and channel, the search for a rule, and its nodes. A piece of a cookie
    /// takes three iterations, both in its level and in the next one, of which a ray crosses
    /// half as many texels. Each part takes a search for the level.
    fn turns(&self, emitter: &Emitter, parts: u32) -> u32 {
        let parts = parts.saturating_add(KINKS);
        if let Emitter::Point(point) = emitter
            && let Emission::Spot(spot) = point.emission()
            && let Some(cookie) = spot.texture()
        {
            let lines = (cookie.width() + cookie.height()).min(2 * MOST_COOKIE_LINES);
            return parts.saturating_mul(30) + 9 * (lines + COOKIE_PIECES) / 2;
        }
        let rules = self.rule().gpu_uniforms().rules;
        // The last rule has the most nodes.
        let nodes = self.rule().gpu_entries()[rules as usize - 1][3] as u32;
        (KINKS + 3 * (rules + nodes + 1)).saturating_mul(parts.saturating_add(PIECES))
    }
}

impl AirlightTurns for Analytic<Table> {
    /// The nodes of the table in each channel, or the fallback.
    fn turns(&self, emitter: &Emitter, parts: u32) -> u32 {
        let table = self.evaluator().gpu_uniforms();
        let nodes = 3 * table.nodes.max(table.near_nodes);
        (nodes.saturating_mul(parts.saturating_add(KINKS)))
            .saturating_add(self.fallback().turns(emitter, parts))
    }
}
