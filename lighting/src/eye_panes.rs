//! See-through surfaces and hair in front of the ends of the rays of a frame.

#[cfg(all(feature = "methods", feature = "translucent", feature = "wgpu"))]
mod lit;

use glam::Vec3;
#[cfg(feature = "trace")]
use gpu_backend::Cpu;

use crate::Interval;
#[cfg(feature = "trace")]
use crate::Ray;
#[cfg(feature = "trace")]
use crate::scene::view::Cover;
use crate::visibility::{LitInterval, Share};

/// The see-through surfaces and the hair between the origins and the ends of the rays of a
/// frame. What is behind one of them, airlight included, is seen through it.
///
/// A gather that is given them cuts each part of a ray where the ray meets one, and multiplies
/// its light by what all of them in front of it let through.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EyePanes {
    /// For each ray, the index behind its last pane.
    ends: Vec<u32>,
    panes: Vec<Behind>,
}

/// The part of a ray behind a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Behind {
    /// Where it begins, m from the origin of the ray.
    pub(crate) from: f32,
    /// The share of its light that passes this surface and all in front of it.
    pub(crate) share: Vec3,
}

impl EyePanes {
    /// Finds the see-through surfaces in front of the ends of these rays; `None` if there are
    /// none.
    ///
    /// Cost: one traced ray each, unless nothing in the scene is see-through.
    #[cfg(feature = "trace")]
    pub fn new(cpu: &Cpu, tracer: &crate::scene::trace::Tracer, rays: &[Ray]) -> Option<Self> {
        if !tracer.coatings().any_see_through() {
            return None;
        }
        let mut all = Self::default();
        for panes in cpu.map(rays.len(), |ray| tracer.panes(&rays[ray])) {
            let mut share = Vec3::ONE;
            all.panes.extend(panes.iter().map(|pane| {
                share *= pane.transmittance;
                Behind {
                    from: pane.hit.distance,
                    share,
                }
            }));
            // Memory holds no more panes than a u32 counts.
            all.ends.push(all.panes.len() as u32);
        }
        (!all.panes.is_empty()).then_some(all)
    }

    /// The panes of `count` rays: `own` of the rays themselves, if there are any, and those
    /// that `cover` has for the pixel of each ray; `None` if both are empty.
    #[cfg(feature = "trace")]
    pub fn with_cover(
        panes: Option<Self>,
        cover: &Cover,
        count: usize,
        pixel: impl Fn(usize) -> usize,
    ) -> Option<Self> {
        if cover.is_clear() {
            return panes;
        }
        let mut all = Self::default();
        for ray in 0..count {
            let own = panes.as_ref();
            // Memory holds no more rays than a u32 counts.
            let mut own = own.map_or(&[][..], |panes| panes.of(ray as u32));
            let mut steps = cover.steps(pixel(ray));
            let (mut by_panes, mut by_steps) = (Vec3::ONE, 1.0);
            loop {
                let from = match (own, steps) {
                    ([], []) => break,
                    ([pane, others @ ..], [step, ..]) if pane.from <= step.distance => {
                        (by_panes, own) = (pane.share, others);
                        pane.from
                    }
                    ([pane, others @ ..], []) => {
                        (by_panes, own) = (pane.share, others);
                        pane.from
                    }
                    (_, [step, others @ ..]) => {
                        (by_steps, steps) = (step.share, others);
                        step.distance
                    }
                };
                let share = by_panes * by_steps;
                all.panes.push(Behind { from, share });
            }
            all.ends.push(all.panes.len() as u32);
        }
        Some(all)
    }

    /// The panes of the ray of this number, the nearest first; none if there is no such ray.
    pub(crate) fn of(&self, ray: u32) -> &[Behind] {
        let Some(&end) = self.ends.get(ray as usize) else {
            return &[];
        };
        &self.panes[self.start(ray) as usize..end as usize]
    }

    /// The index of a ray's first pane.
    fn start(&self, ray: u32) -> u32 {
        let before = ray.checked_sub(1);
        before.map_or(0, |before| self.ends[before as usize])
    }

    /// Appends to `table` what shaders read about `count` rays from `first` on: the index
    /// behind the last pane of each ray, four to an entry, and then the panes.
    #[cfg(feature = "wgpu")]
    pub(crate) fn write(&self, first: u32, count: usize, table: &mut Vec<[u32; 4]>) {
        let first = (first as usize).min(self.ends.len());
        let ends = &self.ends[first..self.ends.len().min(first + count)];
        let start = match ends {
            [] => 0,
            _ => self.start(first as u32),
        };
        let last = ends.last().copied().unwrap_or(start);
        for entry in 0..count.div_ceil(4) {
            let end = |ray: usize| ends.get(ray).map_or(last, |end| *end) - start;
            table.push(std::array::from_fn(|i| end(4 * entry + i)));
        }
        let panes = &self.panes[start as usize..last as usize];
        table.extend(panes.iter().map(|pane| {
            let [r, g, b] = pane.share.to_array();
            [r, g, b, pane.from].map(f32::to_bits)
        }));
    }
}

/// Writes to `seen` which share of the light scattered along a ray reaches the eye if only these
/// parts are lit: nothing of what is in the dark, and what the panes in front let through of the
/// rest.
pub(crate) fn seen_along<S: Share>(
    mut panes: &[Behind],
    lit: &[LitInterval<S>],
    seen: &mut Vec<Behind>,
) {
    seen.clear();
    let mut through = Vec3::ONE;
    let mut lit_until = 0.0;
    for part in lit {
        let Interval { start, end } = part.interval;
        let mut from = start;
        if lit_until < start {
            let share = Vec3::ZERO;
            seen.push(Behind {
                from: lit_until,
                share,
            });
        }
        loop {
            while let [pane, others @ ..] = panes
                && pane.from <= from
            {
                (through, panes) = (pane.share, others);
            }
            let share = part.visibility * through;
            seen.push(Behind { from, share });
            match panes {
                [pane, ..] if pane.from < end => from = pane.from,
                _ => break,
            }
        }
        lit_until = end;
    }
    if lit_until < f32::INFINITY {
        let share = Vec3::ZERO;
        seen.push(Behind {
            from: lit_until,
            share,
        });
    }
}

#[cfg(all(test, feature = "trace"))]
mod tests {
    use super::*;
    use crate::scene::view::CoverStep;

    #[test]
    fn panes_and_cover_are_put_in_order() {
        let behind = |from: f32, share: f32| Behind {
            from,
            share: Vec3::splat(share),
        };
        let panes = || EyePanes {
            ends: vec![0, 2],
            panes: vec![behind(1.0, 0.5), behind(3.0, 0.25)],
        };
        let step = |distance, share| CoverStep { distance, share };
        // Of pixels, which are in another order than the rays.
        let cover = Cover::new([vec![step(2.0, 0.5), step(4.0, 0.25)], vec![step(9.0, 0.0)]]);
        let both = EyePanes::with_cover(Some(panes()), &cover, 2, |ray| 1 - ray).unwrap();
        assert_eq!(both.of(0), [behind(9.0, 0.0)]);
        let expected = [(1.0, 0.5), (2.0, 0.25), (3.0, 0.125), (4.0, 0.0625)];
        assert_eq!(
            both.of(1),
            expected.map(|(from, share)| behind(from, share))
        );
        let clear = EyePanes::with_cover(Some(panes()), &Cover::default(), 2, |ray| ray);
        assert_eq!(clear, Some(panes()));
        let alone = EyePanes::with_cover(None, &cover, 1, |ray| ray).unwrap();
        assert_eq!(alone.of(0), [behind(2.0, 0.5), behind(4.0, 0.25)]);
    }

    #[test]
    fn the_dark_and_what_is_behind_panes_is_seen_as_such() {
        let behind = |from: f32, share: f32| Behind {
            from,
            share: Vec3::splat(share),
        };
        let part = |start, end, visibility| LitInterval {
            interval: Interval::new(start, end),
            visibility,
        };
        let panes = [behind(1.0, 0.5), behind(3.0, 0.25), behind(4.0, 0.125)];
        let mut seen = vec![behind(7.0, 7.0)];
        let dark_from = |from| behind(from, 0.0);
        let nothing: [LitInterval; 0] = [];
        seen_along(&panes, &nothing, &mut seen);
        assert_eq!(seen, [dark_from(0.0)]);
        let lit = [
            part(0.5, 2.0, 1.0),
            part(2.0, 2.5, 0.5),
            part(3.5, 4.0, 1.0),
        ];
        seen_along(&panes, &lit, &mut seen);
        let expected = [
            dark_from(0.0),
            behind(0.5, 1.0),
            behind(1.0, 0.5),
            behind(2.0, 0.25),
            dark_from(2.5),
            behind(3.5, 0.25),
            dark_from(4.0),
        ];
        assert_eq!(seen, expected);
        seen_along(&[], &lit, &mut seen);
        let shares: Vec<f32> = seen.iter().map(|behind| behind.share.x).collect();
        assert_eq!(shares, [0.0, 1.0, 0.5, 0.0, 1.0, 0.0]);
        seen_along(&[], &[part(0.0, f32::INFINITY, 1.0)], &mut seen);
        assert_eq!(seen, [behind(0.0, 1.0)]);
    }
}
