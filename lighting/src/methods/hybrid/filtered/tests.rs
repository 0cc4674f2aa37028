//! Shares of steps against the map itself, and convergence of what is filtered.

use std::sync::Arc;

use gpu_backend::Cpu;

use super::*;
use crate::methods::epipolar::MapRuns;
use crate::methods::hybrid::BuildLitVolumes;
use crate::methods::hybrid::asking::{Steps, whole};
use crate::methods::hybrid::tests::{MAP, case, fog, rays, room};
use crate::methods::prefiltered::{MomentPyramid, Moments};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use crate::visibility::join_touching;

/// All steps of the part that is not known are asked about, which says whether those that
/// are not are left out for good.
#[test]
fn steps_that_are_left_out_are_as_the_map_has_them() {
    let (fog, cpu) = (fog(), Cpu::new());
    let (mut asked, mut lit_parts) = (0, 0);
    for number in 0..96 {
        let (mut random, _, light, eye, mut map, mut volumes) = case(number, MAP);
        if number % 3 == 0 {
            let casters = Casters::upload(&cpu, &room()).unwrap();
            map = cpu.shadow_map(&casters, &light, MAP).unwrap();
            volumes = ShadowVolumes::new(&cpu, &room(), &light, MAP).unwrap();
        }
        let shadow = Some(Arc::new(volumes));
        let lit = Some(Arc::new(cpu.lit_volumes(&map).unwrap()));
        for ray in rays(&mut random, eye, &light, 100) {
            let Some(path) = LightPath::new(&ray, &light, &fog) else {
                continue;
            };
            for (shadow, lit) in [(&shadow, &None), (&None, &lit), (&shadow, &lit)] {
                for count in [1, 7, 200] {
                    let march = |points| {
                        FilteredHybrid::new(points, shadow.clone(), lit.clone(), count).unwrap()
                    };
                    let march: FilteredHybrid<&ShadowMap<Host>, Host> = march(&map);
                    let mut found = Vec::new();
                    march.lit_intervals(&path, &mut found);
                    let ends = found.iter().map(|part| part.interval);
                    assert!(ends.clone().all(|part| part.start < part.end));
                    assert!(
                        ends.clone()
                            .zip(ends.skip(1))
                            .all(|(a, b)| a.end <= b.start)
                    );
                    lit_parts += found.len();
                    join_touching(&mut found, 0);

                    let asking = march.asking(&path);
                    let part = asking.part();
                    let steps = Steps::new(part, count);
                    let mut expected = Vec::new();
                    let mut put = |start: f32, end: f32, is_lit: bool| {
                        if start < end && is_lit {
                            expected.push(LitInterval::unshadowed(start, end));
                        }
                    };
                    put(whole(&path).start, part.start, asking.is_lit_before());
                    if part.start < part.end {
                        for number in 0..count {
                            let [start, end] = [number, number + 1].map(|n| steps.start(n));
                            let middle = 0.5 * (ray.at(start) + ray.at(end));
                            put(start, end, map.is_lit(middle));
                            asked += 1;
                        }
                    }
                    put(part.end, whole(&path).end, asking.rest().1);
                    join_touching(&mut expected, 0);
                    assert_eq!(found, expected, "{number}, {count} steps: {ray:?}");
                }
            }
        }
    }
    assert!(
        asked > 100_000 && lit_parts > 100_000,
        "{asked} {lit_parts}"
    );
}

/// With steps shorter than a texel the moments are those of single depths.
#[test]
fn with_more_steps_shares_become_those_of_the_map() {
    let (fog, cpu) = (fog(), Cpu::new());
    let mut sums = [0.0_f64; 3];
    for number in 0..48 {
        let (mut random, geometry, light, eye, map, volumes) = case(number, MAP);
        let volumes = Arc::new(volumes);
        let moments = Moments::Variance;
        let bounds = geometry.bounds();
        let pyramid = MomentPyramid::new(&cpu, &map, moments, &bounds, 0).unwrap();
        let runs = MapRuns::walked(&map);
        for ray in rays(&mut random, eye, &light, 20) {
            let Some(path) = LightPath::new(&ray, &light, &fog) else {
                continue;
            };
            let whole = whole(&path);
            let length = |lit: &[LitInterval]| -> f64 {
                let parts = lit.iter().map(|lit| {
                    assert!((0.0..=1.0).contains(&lit.visibility), "{lit:?}");
                    f64::from(lit.visibility * lit.interval.length())
                });
                parts.sum()
            };
            let mut exact = Vec::new();
            runs.lit_intervals(&path, &mut exact);
            let exact: f64 = exact
                .iter()
                .map(|lit| f64::from(lit.interval.end.min(whole.end) - lit.interval.start))
                .map(|length| length.max(0.0))
                .sum();
            for (sum, steps) in sums.iter_mut().zip([4, 32, 1024]) {
                let march =
                    FilteredHybrid::new(&pyramid, Some(volumes.clone()), None, steps).unwrap();
                let mut lit = Vec::new();
                march.lit_intervals(&path, &mut lit);
                *sum += (length(&lit) - exact).abs() / f64::from(whole.end - whole.start);
            }
        }
    }
    let means = sums.map(|sum| sum / (48.0 * 20.0));
    println!("{means:?}");
    assert!(means[1] < 0.5 * means[0], "{means:?}");
    // What is left is between the texels, where bounds are interpolated.
    assert!(means[2] < 0.02, "{means:?}");
}

#[test]
fn volumes_of_two_maps_are_refused() {
    let cpu = Cpu::new();
    let (.., geometry, light, _, map, volumes) = case(0, MAP);
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let larger = cpu.shadow_map(&casters, &light, 2 * MAP).unwrap();
    let lit = Arc::new(cpu.lit_volumes(&larger).unwrap());
    assert!(FilteredHybrid::new(&map, Some(Arc::new(volumes)), Some(lit), 8).is_err());
}
