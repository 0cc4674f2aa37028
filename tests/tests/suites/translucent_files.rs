//! Adaptive curves on hair and smoke that nobody on the project made: how near
//! they come to the best that their number of nodes allows.
//!
//! The files are looked for in `../shared/scenes`; see there. Where they are
//! missing, the test says that it was skipped.

use std::path::Path;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::scene::load::{LoadOptions, scene_from_path};
use lighting::scene::{StrandPoint, Strands, Translucent};
use lighting::translucent::Casters;
use reference::curves::{self, Blocker, Least, least_error};
use reference::random::Random;
use transmittance::{
    Accumulate, BlockerSegment, Curve, Evaluate, Linear, Maximum, Source, Stream, Tile,
};

/// The casters of a file, or what to say where there is none.
fn casters(name: &str) -> Option<Vec<Translucent>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared/scenes")
        .join(name);
    if !path.exists() {
        eprintln!("skipped: there is no {}", path.display());
        return None;
    }
    let loaded = scene_from_path(&path, &LoadOptions::default()).unwrap();
    Some(loaded.scene.translucent)
}

fn blockers(segments: &[BlockerSegment]) -> Vec<Blocker> {
    let blocker = |segment: &BlockerSegment| Blocker {
        entry: segment.entry(),
        exit: segment.exit(),
        optical_depth: segment.optical_depth()[0],
    };
    segments.iter().map(blocker).collect()
}

/// Up to `count` of a light's rays with 24 to 400 blockers, in the order in
/// which a map is told of them.
fn rays(
    casters: &[Translucent],
    direction: Vec3,
    resolution: u32,
    count: usize,
) -> Vec<Vec<BlockerSegment>> {
    let sun = Emitter::directional(direction, Vec3::ONE).unwrap();
    let cpu = Cpu::new();
    let faces = Casters::new(casters, None).faces(&cpu, &sun, resolution);
    let (_, blockers) = faces.unwrap().next().unwrap();
    let side = resolution as usize;
    let mut rays = vec![Vec::new(); side * side];
    let whole = Tile {
        x: 0..side,
        y: 0..side,
    };
    blockers.segments(&whole, &mut |[x, y], segment| {
        if !segment.is_clear() {
            rays[y * side + x].push(segment);
        }
    });
    rays.retain(|ray| (24..=400).contains(&ray.len()));
    let step = rays.len().div_ceil(count).max(1);
    rays.into_iter().step_by(step).collect()
}

fn made<A: Accumulate + Clone>(clear: &A, ray: &[BlockerSegment]) -> A::Curve {
    let mut curve = clear.clone();
    ray.iter().for_each(|segment| curve.insert(segment));
    curve.finish()
}

/// Mean of mean and largest errors.
fn measure<A: Accumulate + Clone>(clear: &A, rays: &[Vec<BlockerSegment>]) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    for ray in rays {
        let curve = made(clear, ray);
        let (mean, max) = curves::errors(&blockers(ray), |depth| curve.evaluate(depth)[0]);
        sums = (sums.0 + mean, sums.1 + max);
    }
    (sums.0 / rays.len() as f64, sums.1 / rays.len() as f64)
}

/// The mean over rays of the largest difference that their order makes.
fn spread<A: Accumulate + Clone>(clear: &A, rays: &[Vec<BlockerSegment>]) -> f64 {
    let mut sum = 0.0;
    for (seed, ray) in rays.iter().enumerate() {
        let mut random = Random::new(seed as u64);
        let curves: Vec<A::Curve> = (0..4)
            .map(|_| {
                let mut shuffled = ray.clone();
                random.shuffle(&mut shuffled);
                made(clear, &shuffled)
            })
            .collect();
        let probes = curves::probes(blockers(ray)).into_iter().map(|depth| {
            let values = || curves.iter().map(|curve| curve.evaluate(depth)[0]);
            values().fold(0.0, f32::max) - values().fold(1.0, f32::min)
        });
        sum += f64::from(probes.fold(0.0, f32::max));
    }
    sum / rays.len() as f64
}

fn compare<const N: usize>(name: &str, rays: &[Vec<BlockerSegment>]) {
    let best = |least| {
        let of = |exponential| {
            let error =
                |ray: &Vec<BlockerSegment>| least_error(&blockers(ray), N, least, exponential);
            rays.iter().map(error).sum::<f64>() / rays.len() as f64
        };
        let (linear, exponential): (f64, f64) = (of(false), of(true));
        linear.min(exponential)
    };
    let (area, maximum) = (best(Least::Area), best(Least::Maximum));
    let (paper, _) = measure(&Curve::<N, Linear>::new(), rays);
    let (ours, _) = measure(&Stream::<N>::new(), rays);
    let (_, ours_max) = measure(&Stream::<N, Maximum>::new(), rays);
    let spreads = [
        spread(&Curve::<N, Linear>::new(), rays),
        spread(&Stream::<N>::new(), rays),
    ];
    let mut looseness: Vec<f64> = rays
        .iter()
        .map(|ray| {
            let curve = made(&Stream::<N>::new(), ray);
            let (_, max) = curves::errors(&blockers(ray), |depth| curve.transmittance(depth));
            f64::from(curve.max_error_bound()) / max.max(1e-9)
        })
        .collect();
    looseness.sort_by(f64::total_cmp);
    println!(
        "{name}, {N} nodes, {} rays: mean error {ours:.6}, over the optimum {:.2} (paper's rule {:.2}); \
         largest over the optimum {:.2}; spread between orders {:.4} (paper's rule {:.4}); \
         certificate over largest error {:.2}",
        rays.len(),
        ours / area,
        paper / area,
        ours_max / maximum,
        spreads[1],
        spreads[0],
        looseness[looseness.len() / 2],
    );
    assert!(ours <= 1.4 * area, "{name}: {ours} of {area}");
    assert!(ours_max <= 1.5 * maximum, "{name}: {ours_max} of {maximum}");
    assert!(ours <= paper, "{name}: {ours}, paper's rule {paper}");
}

#[test]
fn curves_of_real_smoke_are_near_the_optimum() {
    let Some(casters) = casters("smoke_ispc_48x64x48.vol") else {
        return;
    };
    // The densities are up to 1; scaled to a plume that lets a little through.
    let scaled: Vec<Translucent> = casters
        .into_iter()
        .map(|caster| match caster {
            Translucent::Grid(grid) => {
                let scale = 8.0 / grid.max_density();
                grid.with_scale(scale).unwrap().into()
            }
            other => other,
        })
        .collect();
    for direction in [Vec3::new(0.3, -1.0, 0.2), Vec3::new(1.0, -0.3, 0.4)] {
        let rays = rays(&scaled, direction, 64, 24);
        compare::<8>("smoke", &rays);
        compare::<16>("smoke", &rays);
    }
}

#[test]
fn curves_of_real_hair_are_near_the_optimum() {
    let Some(casters) = casters("tressfx_ponytail.hair") else {
        return;
    };
    // The file's strands are opaque; the paper's are blended with an opacity.
    let hair: Vec<Translucent> = casters
        .into_iter()
        .map(|caster| match caster {
            Translucent::Strands(strands) => {
                let point = |point: &StrandPoint| StrandPoint {
                    opacity: 0.4,
                    ..*point
                };
                let points = strands.points().iter().map(point).collect();
                let ends = (1..=strands.len()).map(|strand| 16 * strand as u32);
                Strands::new(points, ends.collect()).unwrap().into()
            }
            other => other,
        })
        .collect();
    for direction in [Vec3::new(0.3, -1.0, 0.2), Vec3::new(1.0, -0.3, 0.4)] {
        let rays = rays(&hair, direction, 256, 24);
        compare::<8>("hair", &rays);
        compare::<16>("hair", &rays);
    }
}
