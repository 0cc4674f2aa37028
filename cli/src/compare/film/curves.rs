//! Adaptive volumetric shadow maps as the paper has them, for films: with segments that
//! come in another order in each frame, and sorted.
//!
//! Salvi et al., Adaptive Volumetric Shadow Maps, EGSR 2010, section 4.1: where fragments
//! are captured in parallel, "Inconsistent ordering can result in visible temporal artifacts",
//! mostly imperceptible with eight nodes or more, and sorting removes them.

use std::fmt::Debug;
use std::sync::Arc;

use gpu_backend::{Cpu, Host};
use lighting::airlight::EquiAngular;
use lighting::methods::{
    About, Entry, Frame, FrameInputs, Method, MethodError, OfLight, Role, RunOn, Verdict,
};
use lighting::translucent::{Casters, TransmittanceMap};
use lighting::visibility::{March, Spacing};
use lighting::{Emitter, Gather, LitRays};
use reference::random::Random;
use transmittance::{Accumulate, BlockerSegment, Curve, Evaluate, Linear, Sorted};

/// Curves of 4 and 8 nodes, in any order and sorted.
pub(super) fn methods() -> Vec<Entry> {
    vec![
        Entry::on_cpu(Nodes::<4> { is_sorted: false }),
        Entry::on_cpu(Nodes::<4> { is_sorted: true }),
        Entry::on_cpu(Nodes::<8> { is_sorted: false }),
        Entry::on_cpu(Nodes::<8> { is_sorted: true }),
    ]
}

/// Curves with a number of nodes, by the paper's rule.
#[derive(Debug, Clone, Copy)]
struct Nodes<const N: usize> {
    is_sorted: bool,
}

/// Collects all segments and adds them in an order of its own.
#[derive(Debug, Clone)]
struct Shuffled<A> {
    seed: u64,
    segments: Vec<BlockerSegment>,
    accumulator: A,
}

impl<A: Accumulate> Accumulate for Shuffled<A> {
    type Curve = A::Curve;

    fn insert(&mut self, segment: &BlockerSegment) {
        self.segments.push(*segment);
    }

    fn finish(mut self) -> A::Curve {
        let mut random = Random::new(self.seed);
        for last in (1..self.segments.len()).rev() {
            let other = random.below(last as u32 + 1) as usize;
            self.segments.swap(last, other);
        }
        for segment in &self.segments {
            self.accumulator.insert(segment);
        }
        self.accumulator.finish()
    }
}

impl<const N: usize> Nodes<N> {
    fn build<A>(
        inputs: &FrameInputs<'_>,
        emitter: &Emitter,
        clear: &A,
    ) -> Result<Arc<TransmittanceMap<Host, A::Curve>>, MethodError>
    where
        A: Accumulate + Clone + Sync,
        A::Curve: Evaluate + Debug + Send,
    {
        let casters = Casters::new(inputs.translucent, Some(inputs.geometry));
        let resolution = casters.resolution(inputs.map, inputs.emitters, emitter);
        TransmittanceMap::build_as_needed(&Cpu::new(), &casters, emitter, resolution, clear)
            .map(Arc::new)
            .map_err(MethodError::resource("a map of transmittance"))
    }

    /// The map of a light: kept where it is the same in each frame.
    fn map(
        self,
        frame: &Frame<'_, Cpu>,
        light: usize,
    ) -> Result<Arc<TransmittanceMap<Host, Curve<N, Linear>>>, MethodError> {
        let inputs = &frame.inputs;
        let emitter = &inputs.emitters[light];
        let curve = Curve::<N, Linear>::new();
        if !self.is_sorted {
            let shuffled = Shuffled {
                seed: inputs.film_frame().unwrap_or(0).into(),
                segments: Vec::new(),
                accumulator: curve,
            };
            return Self::build(inputs, emitter, &shuffled);
        }
        let key = OfLight {
            light,
            resolution: inputs.map,
        };
        let bytes = |map: &Arc<TransmittanceMap<Host, Curve<N, Linear>>>| map.bytes();
        let map = frame
            .store
            .get("a sorted map of transmittance", key, bytes, || {
                Self::build(inputs, emitter, &Sorted::new(curve))
            })?;
        Ok((*map).clone())
    }
}

impl<const N: usize> Method for Nodes<N> {
    fn about(&self) -> About {
        let (name, title) = match (N, self.is_sorted) {
            (4, false) => (
                "translucent-4",
                "adaptive volumetric shadow map, 4 nodes, any order",
            ),
            (4, true) => (
                "translucent-4-sorted",
                "adaptive volumetric shadow map, 4 nodes, sorted",
            ),
            (_, false) => (
                "translucent-8",
                "adaptive volumetric shadow map, 8 nodes, any order",
            ),
            (_, true) => (
                "translucent-8-sorted",
                "adaptive volumetric shadow map, 8 nodes, sorted",
            ),
        };
        About {
            name: name.into(),
            title,
            purpose: "what the order of fragments does to a film",
            paper: "Salvi et al., Adaptive Volumetric Shadow Maps, EGSR 2010",
            quality: "steps",
            qualities: &[],
            quick: &[],
            pictured: 64,
            usual: 64,
            role: Role::Variant,
            uses_shadow_map: true,
        }
    }

    fn applies(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }
}

impl<const N: usize> RunOn<Cpu> for Nodes<N> {
    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        steps: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        let evaluator = EquiAngular::new(1).map_err(MethodError::resource("a quadrature"))?;
        for (light, emitter) in frame.inputs.emitters.iter().enumerate() {
            let march = March::new(self.map(frame, light)?, steps, Spacing::EquiAngular);
            let lit = LitRays::new(&frame.rays, emitter, frame.inputs.medium);
            frame.backend.gather(&lit, &march, &evaluator, radiance)?;
        }
        Ok(())
    }
}
