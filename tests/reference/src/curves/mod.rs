//! Transmittance behind blockers as a function of depth: the truth, where to look
//! at it, and the best that a curve of few nodes can do.

mod optimal;

pub use optimal::{Least, least_error};

/// Something that takes light away between two depths, evenly along the way; all
/// of it behind its depth if the two are the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocker {
    /// Where it begins.
    pub entry: f32,
    /// Where it ends, at least `entry`.
    pub exit: f32,
    /// Natural logarithm of what light is divided by; may be infinite.
    pub optical_depth: f32,
}

/// The exact transmittance at `depth`: Beer–Lambert, in f64, blocker by blocker.
pub fn transmittance(blockers: impl IntoIterator<Item = Blocker>, depth: f32) -> f64 {
    let z = f64::from(depth);
    let tau: f64 = blockers
        .into_iter()
        .map(|blocker| {
            let (a, b) = (f64::from(blocker.entry), f64::from(blocker.exit));
            let tau = f64::from(blocker.optical_depth);
            if z <= a {
                0.0
            } else if z >= b {
                tau
            } else {
                tau * ((z - a) / (b - a))
            }
        })
        .sum();
    (-tau).exp()
}

/// [`transmittance`] at each of `depths`, which rise, in one pass: a sum in another
/// order, the same but for its rounding.
pub fn transmittances(blockers: impl IntoIterator<Item = Blocker>, depths: &[f32]) -> Vec<f64> {
    let mut coming: Vec<Blocker> = blockers.into_iter().collect();
    coming.sort_by(|a, b| b.entry.total_cmp(&a.entry));
    let mut inside: Vec<Blocker> = Vec::new();
    let mut passed = 0.0;
    depths
        .iter()
        .map(|&depth| {
            while let Some(blocker) = coming.pop_if(|blocker| blocker.entry < depth) {
                inside.push(blocker);
            }
            inside.retain(|blocker| {
                let behind = blocker.exit <= depth;
                if behind {
                    passed += f64::from(blocker.optical_depth);
                }
                !behind
            });
            let part = |blocker: &Blocker| {
                let (entry, exit) = (f64::from(blocker.entry), f64::from(blocker.exit));
                let share = (f64::from(depth) - entry) / (exit - entry);
                f64::from(blocker.optical_depth) * share
            };
            let tau: f64 = passed + inside.iter().map(part).sum::<f64>();
            (-tau).exp()
        })
        .collect()
}

/// Where blockers begin and end, in order, each depth once.
pub fn ends(blockers: impl IntoIterator<Item = Blocker>) -> Vec<f32> {
    let mut ends: Vec<f32> = blockers
        .into_iter()
        .flat_map(|blocker| [blocker.entry, blocker.exit])
        .collect();
    ends.sort_by(f32::total_cmp);
    ends.dedup();
    ends
}

/// Depths at which curves of these blockers may go wrong: each end, the floats
/// beside it, and between each two.
pub fn probes(blockers: impl IntoIterator<Item = Blocker>) -> Vec<f32> {
    let ends = ends(blockers);
    let mut probes = vec![f32::NEG_INFINITY, f32::MIN, f32::MAX, f32::INFINITY, 0.0];
    for pair in ends.windows(2) {
        let (a, b) = (f64::from(pair[0]), f64::from(pair[1]));
        for share in [0.1, 0.5, 0.75] {
            probes.push((a + (b - a) * share) as f32);
        }
    }
    for end in ends {
        probes.extend([end.next_down(), end, end.next_up()]);
    }
    probes.sort_by(f32::total_cmp);
    probes
}

/// Mean and largest error of `curve` over the depths from the first to the last
/// end, by Simpson's rule between the ends.
pub fn errors(blockers: &[Blocker], curve: impl Fn(f32) -> f32) -> (f64, f64) {
    let exact = |depth: f32| transmittance(blockers.iter().copied(), depth);
    let error = |depth: f32| (f64::from(curve(depth)) - exact(depth)).abs();
    let (mut area, mut length, mut max) = (0.0, 0.0, 0.0_f64);
    for pair in ends(blockers.iter().copied()).windows(2) {
        let (a, b) = (f64::from(pair[0]), f64::from(pair[1]));
        let middle = (0.5 * (a + b)) as f32;
        let sample = [pair[0].next_up(), middle, pair[1]].map(error);
        area += (b - a) * (sample[0] + 4.0 * sample[1] + sample[2]) / 6.0;
        length += b - a;
        max = sample.into_iter().fold(max, f64::max);
    }
    (area / length, max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn blocker(entry: f32, exit: f32, optical_depth: f32) -> Blocker {
        Blocker {
            entry,
            exit,
            optical_depth,
        }
    }

    fn stream(seed: u64) -> Vec<Blocker> {
        let mut random = Random::new(seed);
        (0..40)
            .map(|i| {
                let entry = random.between(-5.0, 5.0);
                let length = if i % 3 == 0 {
                    0.0
                } else {
                    random.between(0.0, 4.0)
                };
                blocker(entry, entry + length, random.unit())
            })
            .collect()
    }

    #[test]
    fn one_pass_gives_what_each_depth_gives_by_itself() {
        for seed in 0..20 {
            let blockers = stream(seed);
            let depths = probes(blockers.iter().copied());
            let together = transmittances(blockers.iter().copied(), &depths);
            for (depth, found) in depths.iter().zip(together) {
                let expected = transmittance(blockers.iter().copied(), *depth);
                assert!(
                    (found - expected).abs() < 1e-14,
                    "{depth} {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn walls_are_dark_behind_and_clear_at_their_depth() {
        let wall = [blocker(2.0, 2.0, f32::INFINITY), blocker(1.0, 3.0, 0.8)];
        let at = |depth| transmittance(wall, depth);
        assert_eq!((at(1.0), at(2.0_f32.next_up())), (1.0, 0.0));
        assert!((at(2.0) - (-f64::from(0.4_f32)).exp()).abs() < 1e-7);
        assert_eq!(transmittances(wall, &[0.0, 2.5, 9.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn all_nodes_leave_no_error_and_more_nodes_no_larger_one() {
        let blockers = stream(3);
        for least in [Least::Area, Least::Maximum] {
            let error = |nodes| least_error(&blockers, nodes, least, true);
            assert!(error(200) < 1e-12);
            assert!(error(6) <= error(5) && error(5) > 0.0);
        }
    }
}
