//! Pictures of many lamps in several ways, and their times.

use std::sync::Arc;
use std::time::Instant;

use gpu_backend::Cpu;
use lighting::airlight::EquiAngular;
use lighting::culling::{Clusters, PickPixels, TileLights};
use lighting::methods::many_lights::{GatherMany, LitByMany, VisibilityOfMany};
use lighting::precomputed::{BakedShadow, Builder, Resolution};
use lighting::scene::view::View;
use lighting::visibility::Unshadowed;
use lighting::{Gather, LitRays, Ray, Touching};

use super::lamps::Lamps;
use super::{Frame, Limit, Subject};
use crate::failure::Failure;

/// Nodes of the quadrature.
pub(super) const NODES: u32 = 4;

/// How the lamps of a picture are gathered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// All in one pass, from the lists of tiles.
    Together,
    /// One after the other, each at the rays that it may reach.
    OneByOne,
    /// One after the other, each at all rays.
    Unculled,
}

impl Way {
    pub(super) const ALL: [Self; 3] = [Self::Together, Self::OneByOne, Self::Unculled];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Together => "in one pass",
            Self::OneByOne => "light by light",
            Self::Unculled => "without culling",
        }
    }
}

/// A frame of lamps without shadows.
pub(super) fn unshadowed(
    subject: &Subject<'_>,
    view: &View,
    lamps: &Lamps,
    limit: &Limit<'_>,
) -> Result<Frame, Failure> {
    frame(subject, view, lamps, (&Unshadowed, Touching::Apart), limit)
}

/// A frame of lamps with precomputed shadows, whose bake is not part of the times.
pub(super) fn shadowed(
    subject: &Subject<'_>,
    view: &View,
    lamps: &Lamps,
    (voxels, limit): (u32, &Limit<'_>),
) -> Result<Frame, Failure> {
    let side = Resolution::new(voxels)?;
    let (cpu, geometry) = (Cpu::new(), subject.geometry);
    let bake = |emitter| BakedShadow::bake(&cpu, geometry, emitter, side, Builder::new());
    let shadows = lamps.emitters.iter().map(bake);
    let shadows = shadows.map(|baked| baked.map(|(shadow, _)| Arc::new(shadow)));
    let shadows: Vec<Arc<BakedShadow>> = shadows.collect::<Result<_, _>>()?;
    frame(subject, view, lamps, (&shadows, Touching::Joined), limit)
}

fn frame<V: VisibilityOfMany>(
    subject: &Subject<'_>,
    view: &View,
    lamps: &Lamps,
    (sources, touching): (&V, Touching),
    limit: &Limit<'_>,
) -> Result<Frame, Failure> {
    let cpu = Cpu::new();
    let (emitters, medium) = (&lamps.emitters[..], subject.medium);
    let rays = view.rays().to_vec();
    let airlight = EquiAngular::new(NODES)?;
    let clock = Instant::now();
    let lists = TileLights::new(&cpu, &lamps.tiles, emitters)?;
    let of_lists = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let clusters = Clusters::new(&cpu, lists)?;
    let of_clusters = clock.elapsed().as_secs_f64();
    let mut frame = Frame {
        lamps: emitters.len() as u32,
        counts: lamps.count(view, medium, &clusters),
        lists: [of_lists, of_clusters],
        seconds: Vec::new(),
    };
    for way in Way::ALL {
        // Each way is slower than the one before it, by far where there are many lamps.
        let last = frame.seconds.last().map_or(0.0, |(_, seconds)| *seconds);
        let enough = match way {
            Way::Together => false,
            Way::OneByOne => limit.reached_after(4.0 * last).is_some(),
            Way::Unculled => {
                let pairs = rays.len() as f64 * emitters.len() as f64;
                limit.reached_after(2.0 * PAIR * pairs).is_some() || pairs > MOST_PAIRS
            }
        };
        if enough {
            break;
        }
        let mut least = f64::INFINITY;
        for _ in 0..2 {
            let mut radiance = vec![[0.0; 4]; rays.len()];
            let clock = Instant::now();
            match way {
                Way::Together => {
                    let lit = LitByMany {
                        touching,
                        ..LitByMany::new(&rays, emitters, clusters.rays(), medium)
                    };
                    cpu.gather_many(&lit, sources, &airlight, &mut radiance)?;
                }
                Way::OneByOne | Way::Unculled => {
                    for (light, emitter) in emitters.iter().enumerate() {
                        let Some(source) = sources.of_light(light) else {
                            continue;
                        };
                        let gather = |rays: &Vec<Ray>, radiance: &mut Vec<[f32; 4]>| {
                            let lit = LitRays {
                                touching,
                                ..LitRays::new(rays, emitter, medium)
                            };
                            cpu.gather(&lit, source, &airlight, radiance)
                        };
                        let reached = match way {
                            Way::OneByOne => lamps.tiles.reached(emitter),
                            _ => None,
                        };
                        let Some(reached) = reached else {
                            gather(&rays, &mut radiance)?;
                            continue;
                        };
                        let some = reached.iter().map(|ray| rays[*ray as usize]).collect();
                        let mut picked = cpu.pick(&radiance, &reached)?;
                        gather(&some, &mut picked)?;
                        cpu.put_back(&picked, &reached, &mut radiance)?;
                    }
                }
            }
            least = least.min(clock.elapsed().as_secs_f64());
        }
        frame.seconds.push((way, least));
    }
    Ok(frame)
}

/// About how many seconds a light takes that does not reach a pixel, to foresee times.
const PAIR: f64 = 5e-8;

/// The largest number of pairs of a pixel and a light that are gathered without culling: three
/// hundred lamps at the usual size.
const MOST_PAIRS: f64 = 4e7;
